"""Stretch a network to dimensions, and bring changes back to the network before that.

The map of `dimension_map` moves the nodes, and its derivative changes the tangents there: lines
and surfaces that were smooth stay exactly smooth. A stretched edge differs from the map of the
whole edge by what a cubic cannot represent.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry.patches import extent
from bozzetto.plugin import remembered
from bozzetto_car.body.dimension_map import Reshaping, fit_reshaping
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.network import Network

REMEMBERED: Final = 64
"""Number of stretched networks that are remembered: the last one that was measured is shown."""


def reshaping_of(network: Network, wanted: Dimensions) -> Reshaping | None:
    """Return the map that gives the surfaces of a network the dimensions that are wanted.

    Returns
    -------
    Reshaping or None
        None if the network has these dimensions already.

    Raises
    ------
    UserError
        As `fit_reshaping` does.
    """
    if not wanted.given():
        return None
    wheels = network.positions[network.template.wheels[:, 0], 0]
    return fit_reshaping(wanted, _box(network), wheels, lambda map_: _box(stretch(network, map_)))


@remembered(limit=REMEMBERED)
def stretch(network: Network, map_: Reshaping) -> Network:
    """Return a network after a map; wheels keep their radius, and symmetry is exact."""
    positions = map_.nodes(network.template, network.positions)
    return Network(network.template, positions, map_.tangents(network.tangents, network.ends))


def undo_stretch(network: Network, there: Network, changed: Network, map_: Reshaping) -> Network:
    """Apply the changes that were made to a stretched network to the network before.

    Parameters
    ----------
    network : Network
        The network before it was stretched.
    there : Network
        ``stretch(network, map_)``.
    changed : Network
        The stretched network after the changes.
    map_ : Reshaping
        The map.

    Returns
    -------
    Network
        All that did not change equals `network`, bit for bit.
    """
    template = network.template
    moved = (changed.positions != there.positions).any(axis=1)
    positions = network.positions.copy()
    if moved.any():  # a stroke bends edges, and mostly moves no node
        positions[moved] = map_.points_before(changed.positions[moved])
    wheels = template.wheels.ravel()
    positions[wheels, 2] = changed.positions[wheels, 2]
    # The map has another slope where a node has moved to, so its tangents change as well.
    bent = (changed.tangents != there.tangents).any(axis=2) | moved[template.edges]
    ends = positions[template.edges]
    tangents = np.where(
        bent[..., None], map_.tangents_before(changed.tangents, ends), network.tangents
    )
    return Network(template, positions, tangents)


def _box(network: Network) -> Array:
    """Return the least and greatest coordinates of the surfaces, (2, 3) mm."""
    return extent(fair_nets(network))
