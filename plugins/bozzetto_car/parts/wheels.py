"""Wheels as exact solids: a tyre and a rim with spokes, in the well of their arch."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, Curve, Mesh, Placement, sewn, surface_of_revolution
from bozzetto.view import triple
from bozzetto_car.body.wheels import (
    DEEPEST,
    LAID,
    REMEMBERED,
    SPOKE_DEPTH,
    SPOKES,
    Proportions,
    wheel_meshes,
)
from bozzetto_car.parts.looks import CHROME, RUBBER, CarPart, on_both_sides
from bozzetto_car.parts.trimmed_face import bezier
from bozzetto_car.parts.wheel_arches import cut_panels
from bozzetto_car.template.network import Network

TYRE_SECTION: Final = (
    (0.70, -0.03), (0.72, -0.005), (0.80, 0.0), (0.90, -0.012), (0.965, -0.045), (0.99, -0.09),
    (1.0, -0.16), (1.0, -0.46), (0.99, -0.53), (0.93, -0.60), (0.72, -0.62), (0.70, -0.60),
    (0.70, -0.03),
)  # fmt: skip
RIM_SECTION: Final = (
    (0.0, -0.012), (0.09, -0.016), (0.125, -0.028), (0.135, -0.060), (0.63, -0.060),
    (0.645, -0.030), (0.665, -0.012), (0.69, -0.008), (0.70, -0.03), (0.70, -0.60), (0.66, -0.60),
    (0.62, -0.12), (0.0, -0.12),
)  # fmt: skip
"""Sections: distances from the axle and places along it, per radius. The outermost place is 0."""

BEHIND: Final = 8.0
"""How far a wheel lies behind the panel around its arch, mm."""

AXLE: Final = (0.0, 1.0, 0.0)


def wheels_of(network: Network, nets: Array, tyre: str = "", *, sunk: bool = True) -> list[CarPart]:
    """Return the tyres and the rims of all wheels.

    Parameters
    ----------
    network : Network
        The car; its wheels stand on the ground, so that their height is their radius.
    nets : (k, 4, 4, 3) array_like
        Its patches, mm.
    tyre : str
        Size of its tyres; "" for those of the sections.
    sunk : bool
        Whether they stand in arches; they are outside the panels as they are seen otherwise.
    """
    made: list[CarPart] = []
    sizes = Proportions.of(tyre)
    panels = cut_panels(network, nets).values() if sunk else ()
    meshes = wheel_meshes(network, nets, tyre, {cut.wheel: cut.radius for cut in panels})
    for mesh, where in zip(meshes, ("front", "rear"), strict=False):
        proud = LAID + DEEPEST * sizes.width * mesh.radius
        face = mesh.reach - BEHIND if sunk else mesh.reach + proud
        x, _, z = triple(mesh.centre)
        to = Placement(scale=mesh.radius, offset=(x, face, z))
        for seen, unit, name, look in (
            (mesh.tyre, _tyre, "Tyre", RUBBER),
            (mesh.rim, _rim, "Rim", CHROME),
        ):
            shown, exact = partial(_as_it_is, seen), partial(_placed, unit, sizes, to)
            made += on_both_sides(f"{name} {where}", look, shown, exact)
    return made


def _as_it_is(mesh: Mesh) -> Mesh:
    return mesh


def _placed(unit: Callable[[Proportions], Brep], sizes: Proportions, to: Placement) -> Brep:
    return unit(sizes).placed(to)


@lru_cache(maxsize=REMEMBERED)
def _tyre(sizes: Proportions) -> Brep:
    """Return a right tyre of radius 1 whose outer face is at y = 0."""
    return _turned(sizes.section(TYRE_SECTION))


@lru_cache(maxsize=REMEMBERED)
def _rim(sizes: Proportions) -> Brep:
    """Return the rim of such a tyre; spokes are solids that reach into its disc."""
    spokes = [_spoke(sizes, turn) for turn in np.arange(SPOKES) * 2.0 * np.pi / SPOKES]
    return sewn([_turned(sizes.section(RIM_SECTION)), *spokes])


def _turned(section: Array) -> Brep:
    points = np.insert(section, 2, 0.0, axis=1)
    knots = np.concatenate(([0.0], np.linspace(0.0, 1.0, len(points)), [1.0]))
    return surface_of_revolution(Curve(1, knots, points), (0.0, 0.0, 0.0), AXLE)


def _spoke(sizes: Proportions, turn: float) -> Brep:
    """Return a spoke: hexahedra from the hub to the rim, as one solid."""
    cos, sin = np.cos(turn), np.sin(turn)
    rows = []
    deep = SPOKE_DEPTH * sizes.width
    for away, half, along in sizes.spokes.tolist():
        ring = ((away, along, -half), (away, along, half),
                (away, along - deep, half), (away, along - deep, -half))  # fmt: skip
        rows.append([(x * cos - z * sin, y, x * sin + z * cos) for x, y, z in ring])
    rings = np.array(rows)
    flanks = [
        np.stack((one[[k, (k + 1) % 4]], two[[k, (k + 1) % 4]]), axis=1)
        for one, two in pairwise(rings)
        for k in range(4)
    ]
    ends = [rings[0][[[0, 1], [3, 2]]], rings[-1][[[0, 3], [1, 2]]]]
    return sewn([Brep.of_surface(bezier(net)) for net in (*flanks, *ends)])
