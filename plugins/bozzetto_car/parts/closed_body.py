"""The body as a closed solid: panels with openings, wheel arches with wells, a floor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Brep, ParameterCurve, sewn
from bozzetto_car.parts.looks import DARK, PAINT, RUBBER, left, looking
from bozzetto_car.parts.trimmed_face import bezier, face_within, local, polyline, side_of
from bozzetto_car.parts.wheel_arches import DEPTH, cut_panels, well
from bozzetto_car.parts.windows import Window, bed, gap, windows_of
from bozzetto_car.template.network import Network

NOT_CLOSED: Final = (
    "The body cannot be closed: its panels fold where a wheel arch or a window is cut. Switch "
    "“Complete car” off, or undo the last change of the lines there."
)


def closed_body(network: Network, nets: Array) -> Brep:
    """Return the body as one closed shell.

    The right half is made, face by face, and its mirror image; edges that are the same are
    sewn. The floor consists of straight lines across the car between the sills.

    Parameters
    ----------
    network : Network
        The car.
    nets : (k, 4, 4, 3) array_like
        Its patches, mm.

    Raises
    ------
    UserError
        If the body folds where it is cut, so that it cannot be closed.
    """
    arches = cut_panels(network, nets)
    insets: dict[int, list[Window]] = {}
    for window in windows_of(network.template, nets):
        if window.patch not in arches:
            insets.setdefault(window.patch, []).append(window)
    painted: list[Brep] = []
    others: list[Brep] = []
    for number, patch in enumerate(network.template.patches):
        if not patch.name.endswith(".R"):
            continue
        net, arch, windows = nets[number], arches.get(number), insets.get(number, [])
        if arch is None:
            panels = [_panel(net, windows)]
        else:
            panels = [face_within(bezier(net), [loop]) for loop in arch.outside]
            others += [looking(face, "Wheel well", DARK) for face in well(arch, net)]
        painted += [looking(panel, patch.name, PAINT) for panel in panels]
        for window in windows:
            others.append(looking(bed(window, net), "Bed", DARK))
            others += [looking(face, "Gap", RUBBER) for face in gap(window, net)]
        for side in range(4):
            if network.template.edge_of(number, side) in network.template.rim:
                cut = None if arch is None else arch.cut.get(side)
                others.append(looking(_strip(side_of(net, side), cut), "Floor", DARK))
    others += [left(part) for part in others]
    ordered = [*painted, *map(left, painted), *sorted(others, key=lambda part: part.faces[0].name)]
    try:
        closed = sewn(ordered, "Body")
    except ValueError as problem:
        raise UserError(NOT_CLOSED) from problem
    if not closed.is_closed:
        raise UserError(NOT_CLOSED)
    return closed


def _panel(net: Array, windows: Sequence[Window]) -> Brep:
    """Return a patch without what is let into it."""
    holes = [window.paths for window in windows if window.open < 0]
    outer: list[ParameterCurve] = []
    for side in range(4):
        here = local(side, 0.0, 0.0)
        for window in sorted((w for w in windows if w.open == side), key=lambda w: w.opening):
            first, last = (local(side, along, 0.0) for along in window.opening)
            outer += [*polyline([here, first]), *window.paths]
            here = last
        outer += polyline([here, local(side, 1.0, 0.0)])
    return face_within(bezier(net), [outer, *holes])


def _strip(sill: Array, cut: tuple[float, float] | None) -> Brep:
    """Return the floor between an edge of the sill and the middle, without a wheel well."""
    surface = bezier(np.stack((sill, sill * (1.0, 0.0, 1.0)), axis=1))
    places = [(0.0, 0.0), (1.0, 0.0)]
    if cut is not None:
        start, end = cut
        before = [(0.0, 0.0), (start, 0.0)] if start > 0.0 else []
        after = [(end, 0.0), (1.0, 0.0)] if end < 1.0 else []
        places = [*before, (start, DEPTH), (end, DEPTH), *after]
    loop = polyline([*places, (1.0, 1.0), (0.0, 1.0), places[0]])
    return face_within(surface, [loop]).turned_over()
