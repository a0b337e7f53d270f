"""A network brought to dimensions, and what was done to it there taken back.

Nodes go where the map of `dimension_map` takes them, and tangents undergo its derivative there:
what was smooth stays so exactly, lines and surfaces alike. An edge then differs from the map of
the edge as a whole by what the cubic form leaves out, as it does if its control points are moved.
"""

from __future__ import annotations

import numpy as np

from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.patch import extent
from bozzetto_car.array_types import Array
from bozzetto_car.body.dimension_map import Reshaping, reshaped
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.template.network import Network


def reshaping_of(network: Network, wanted: Dimensions) -> Reshaping | None:
    """The map that gives the surface of a network the dimensions that are wanted.

    Returns
    -------
    Reshaping or None
        None if it has them.

    Raises
    ------
    UserError
        As of `reshaped`.
    """
    if not wanted.given():
        return None
    wheels = network.positions[network.template.wheels[:, 0], 0]
    return reshaped(wanted, _box(network), wheels, lambda map_: _box(stretched(network, map_)))


def stretched(network: Network, map_: Reshaping) -> Network:
    """A network after a map; wheels keep their radius, and symmetry holds to the last bit."""
    positions = map_.nodes(network.template, network.positions)
    return Network(network.template, positions, map_.tangents(network.tangents, network.ends))


def brought_back(network: Network, there: Network, changed: Network, map_: Reshaping) -> Network:
    """What was done to a stretched network, done to the network as it was.

    Parameters
    ----------
    network : Network
        As it was.
    there : Network
        ``stretched(network, map_)``.
    changed : Network
        The same after somebody has worked on it.
    map_ : Reshaping

    Returns
    -------
    Network
        All that did not change is that of `network`, bit for bit.
    """
    template = network.template
    moved = (changed.positions != there.positions).any(axis=1)
    positions = np.where(moved[:, None], map_.points_before(changed.positions), network.positions)
    wheels = template.wheels.ravel()
    positions[wheels, 2] = changed.positions[wheels, 2]
    # Where a node has moved the map has another slope, and other tangents look the same there.
    bent = (changed.tangents != there.tangents).any(axis=2) | moved[template.edges]
    ends = positions[template.edges]
    tangents = np.where(
        bent[..., None], map_.tangents_before(changed.tangents, ends), network.tangents
    )
    return Network(template, positions, tangents)


def _box(network: Network) -> Array:
    """Least and greatest coordinates of the surface, (2, 3) mm."""
    return extent(coons_nets(network.control_points, network.template.sides))
