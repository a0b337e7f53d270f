"""Walls and floors: what stands in the place of a region."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.geometry import BSplineSurface, Curve, Face, ParameterCurve, Trim
from bozzetto_product.details.floor import Floor
from bozzetto_product.details.joint_edges import DEGREE
from bozzetto_product.details.mitres import Mitre
from bozzetto_product.details.region import CutShell, OutlineEdge
from bozzetto_product.details.shell import Owner, Shell

LINE: Final = np.array((0.0, 0.0, 1.0, 1.0))
"""Knots of a straight line."""


@dataclass(frozen=True, eq=False)
class FloorFace:
    """A floor within loops.

    Parameters
    ----------
    floor : Floor
    loops : tuple of tuple of (bool, int, bool)
        Of each side: whether it is the foot of an outline's edge, else a mitre; its number, and
        whether it is run forward.
    """

    floor: Floor
    loops: tuple[tuple[tuple[bool, int, bool], ...], ...]


def whole_floor(edges: Sequence[OutlineEdge], floor: Floor) -> FloorFace:
    """Return one floor within all outlines."""
    rings = sorted({edge.ring for edge in edges})
    return FloorFace(
        floor,
        tuple(
            tuple((True, k, True) for k, edge in enumerate(edges) if edge.ring == ring)
            for ring in rings
        ),
    )


def with_walls(
    cut: CutShell,
    edges: Sequence[OutlineEdge],
    floors: Sequence[FloorFace],
    owner: Owner,
    mitres: Sequence[Mitre] = (),
) -> Shell:
    """Return a shell whose region is gone, with walls down to floors or to the far side.

    Floors are its last faces, in their order.
    """
    shell = cut.shell
    curves = list(shell.edges)
    bottoms = list(cut.bottoms)
    if floors:
        bottoms = list(range(len(curves), len(curves) + len(edges)))
        curves += [edge.bottom.curve for edge in edges if edge.bottom is not None]
    folds = range(len(curves), len(curves) + len(mitres))
    curves += [mitre.forward.curve for mitre in mitres]
    faces = [face for k, face in enumerate(shell.faces) if k not in cut.inside]
    owners = [own for k, own in enumerate(shell.owners) if k not in cut.inside]
    for ring in sorted({edge.ring for edge in edges}):
        own = [k for k, edge in enumerate(edges) if edge.ring == ring]
        uprights = []
        for k in own:
            upper, lower = curves[cut.tops[k]], curves[bottoms[k]]
            uprights.append(len(curves))
            ends = np.stack((upper.control_points[0], lower.control_points[0]))
            curves.append(Curve(1, LINE, ends))
        for place, k in enumerate(own):
            after = uprights[(place + 1) % len(own)]
            faces.append(_wall(curves, cut.tops[k], bottoms[k], uprights[place], after))
            owners.append(owner)

    def side(is_foot: bool, number: int, forward: bool) -> Trim:
        if not is_foot:
            fitted = mitres[number].forward if forward else mitres[number].back
            return Trim(folds[number], forward, fitted.path)
        foot = edges[number].bottom
        assert foot is not None
        return Trim(bottoms[number], forward, foot.path)

    for piece in floors:
        loops = tuple(tuple(side(*one) for one in loop) for loop in piece.loops)
        faces.append(Face(piece.floor.surface, loops))
        owners.append(replace(owner, floor=piece.floor))
    return Shell(tuple(curves), tuple(faces), tuple(owners))


def _wall(curves: Sequence[Curve], top: int, bottom: int, before: int, after: int) -> Face:
    """Return the face of straight lines from an edge to the one under it."""
    upper, lower = curves[top], curves[bottom]
    net = np.stack((upper.control_points, lower.control_points), axis=1)
    surface = BSplineSurface((DEGREE, 1), upper.knots, LINE, net)
    low, high = upper.range
    run = (low, high)
    return Face(
        surface,
        (
            (
                Trim(top, True, ParameterCurve.line((low, 0.0), (high, 0.0), run)),
                Trim(after, True, ParameterCurve.line((high, 0.0), (high, 1.0), (0.0, 1.0))),
                Trim(bottom, False, ParameterCurve.line((low, 1.0), (high, 1.0), run)),
                Trim(before, False, ParameterCurve.line((low, 0.0), (low, 1.0), (0.0, 1.0))),
            ),
        ),
    )
