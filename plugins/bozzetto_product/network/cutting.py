"""From curves and joints to a net: every curve cut exactly where it meets others.

Mirror images are made by reflecting what was computed on one side: for the standard plane a
change of sign, so both sides agree to the last bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.model.curve_stretch import crease_over
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.meetings import SAME_PLACE, Cut, CutCurve, NodeKey, cut_curves
from bozzetto_product.network.net import Edge, Net
from bozzetto_product.network.reflection import Reflection


@dataclass(frozen=True, eq=False)
class _Piece:
    """A part of a curve between two cuts; nodes None where a closed curve has no cut."""

    curve: CutCurve
    number: int
    spline: Spline
    start: NodeKey | None
    end: NodeKey | None
    span: tuple[float, float] = (0.0, 1.0)


def net_of(curves: Sequence[Curve], joints: Sequence[Joint], symmetry: Plane) -> Net:
    """Cut curves at their joints.

    Parameters
    ----------
    curves : sequence of Curve
        Those that count; one without a spline, or without length, is left out.
    joints : sequence of Joint
        Meetings with curves that are not there are left out.
    symmetry : Plane
        The plane of the mirror images.

    Returns
    -------
    Net
        Edges in the order of the curves, pieces in order along each, the pieces of a mirror image
        after those of its curve. Nodes in the order in which the edges come to them. Where a
        curve and its joints are as before, the splines are the very same objects.
    """
    reflection = Reflection(symmetry)
    cut, images = cut_curves(curves, joints, reflection)
    same = _merged_nodes(cut, images)
    pieces = [piece for each in cut for piece in _pieces(each, same)]
    images = {same.get(node, node): same.get(image, image) for node, image in images.items()}
    positions = _positions(pieces, images, reflection)
    return _net(pieces, positions, images, reflection)


# -- pieces ----------------------------------------------------------------------------------


def _merged_nodes(
    curves: Sequence[CutCurve], images: dict[NodeKey, NodeKey]
) -> dict[NodeKey, NodeKey]:
    """Return for each node that lies on another one the node that stands for both."""
    same: dict[NodeKey, NodeKey] = {}

    def root(node: NodeKey) -> NodeKey:
        while node in same:
            node = same[node]
        return node

    for curve in curves:
        for first, second in itertools.pairwise(curve.cuts):
            if second.at - first.at > SAME_PLACE:
                continue
            pairs = [(first.node, second.node)]
            if first.node in images and second.node in images:
                pairs.append((images[first.node], images[second.node]))
            for one, other in pairs:
                kept, gone = sorted((root(one), root(other)), key=_named_first)
                if kept != gone:
                    same[gone] = kept
    return {node: root(node) for node in same}


def _named_first(node: NodeKey) -> tuple[bool, NodeKey]:
    return not node[0], node


def _pieces(curve: CutCurve, same: dict[NodeKey, NodeKey]) -> list[_Piece]:
    """Cut one curve; pieces without length fall away."""
    cuts: list[Cut] = []
    for each in curve.cuts:
        if not cuts or each.at - cuts[-1].at > SAME_PLACE:
            cuts.append(replace(each, node=same.get(each.node, each.node)))
    if not cuts:
        return [_Piece(curve, 0, curve.spline, None, None)]
    begin, end = curve.spline.range
    inner = cuts if curve.spline.closed else cuts[1:-1]
    splines = _split(curve.spline, tuple(begin + each.at * (end - begin) for each in inner))
    ends = [*cuts, replace(cuts[0], at=cuts[0].at + 1.0)] if curve.spline.closed else cuts
    return [
        _Piece(curve, number, spline, first.node, second.node, (first.at, second.at))
        for number, (spline, (first, second)) in enumerate(
            zip(splines, itertools.pairwise(ends), strict=True)
        )
    ]


@remembered(limit=2000)
def _split(spline: Spline, places: tuple[float, ...]) -> tuple[Spline, ...]:
    return spline.split(*places) if places else (spline,)


# -- nodes -----------------------------------------------------------------------------------


def _positions(
    pieces: Sequence[_Piece], images: dict[NodeKey, NodeKey], reflection: Reflection
) -> dict[NodeKey, Array]:
    """Return where the nodes are: on the curve that runs through, else the mean of the ends."""
    through: dict[NodeKey, list[Array]] = {}
    ends: dict[NodeKey, list[Array]] = {}
    for piece in pieces:
        last = piece.number == _count(piece.curve) - 1
        points, closed = piece.spline.control_points, piece.curve.spline.closed
        for node, point, outer in (
            (piece.start, points[0], piece.number == 0),
            (piece.end, points[-1], last),
        ):
            if node is not None:
                kind = ends if outer and not closed else through
                kind.setdefault(node, []).append(point)
    positions: dict[NodeKey, Array] = {}
    for node in [*through, *ends]:
        image = images.get(node)
        if node not in positions:
            found = _own_and_mirrored(node, image, through, ends, reflection)
            position = found[0] + (found - found[0]).mean(axis=0)
            positions[node] = reflection.onto(position[None])[0] if image == node else position
            if image is not None and image != node:
                positions[image] = reflection.points(positions[node][None])[0]
    return positions


def _own_and_mirrored(
    node: NodeKey,
    image: NodeKey | None,
    through: dict[NodeKey, list[Array]],
    ends: dict[NodeKey, list[Array]],
    reflection: Reflection,
) -> Array:
    """Return the places that curves give a node, or give its image, reflected."""
    for kind in (through, ends):
        own = kind.get(node, [])
        other = [] if image in (None, node) else kind.get(image, [])
        if own or other:
            parts = [np.reshape(own, (-1, 3)), reflection.points(np.reshape(other, (-1, 3)))]
            return np.vstack(parts)
    raise KeyError(node)


def _count(curve: CutCurve) -> int:
    """Return the number of pieces of a curve."""
    places = [each.at for each in curve.cuts]
    gaps = sum(second - first > SAME_PLACE for first, second in itertools.pairwise(places))
    return gaps + 1 if curve.spline.closed else gaps


# -- the net ---------------------------------------------------------------------------------


def _net(
    pieces: Sequence[_Piece],
    positions: dict[NodeKey, Array],
    images: dict[NodeKey, NodeKey],
    reflection: Reflection,
) -> Net:
    sides = _both_sides(pieces)
    place = {(each.curve.curve.id, each.number, side): i for i, (each, side) in enumerate(sides)}
    numbers: dict[NodeKey, int] = {}
    edges: list[Edge] = []
    for piece, mirrored in sides:
        ends = [images[node] if mirrored else node for node in (piece.start, piece.end) if node]
        start, end = [numbers.setdefault(node, len(numbers)) for node in ends] or [-1, -1]
        partner = _partner(piece, pieces, images)
        curve = piece.curve
        twin = (
            place[curve.curve.id, partner, curve.mirrored and not mirrored] if partner >= 0 else -1
        )
        if mirrored:
            spline = _image(edges[twin].spline, reflection.plane, False)
        elif 0 <= twin < len(edges):
            spline = _image(edges[twin].spline, reflection.plane, True)
        else:
            spline = piece.spline
            if twin == len(edges) and curve.across and ends:
                spline = _made_symmetric(spline, reflection.plane)
        if ends:
            spline = _between(spline, positions[ends[0]], positions[ends[1]])
        is_image = 0 <= twin < len(edges)
        crease = edges[twin].crease if is_image else crease_over(curve.curve, *piece.span)
        row = (spline, start, end, curve.curve.id, piece.number, mirrored, twin, crease)
        edges.append(Edge(*row, piece.span))
    names = tuple((joint, mirrored and bool(joint)) for joint, mirrored, _ in numbers)
    places = [positions[node] for node in numbers]
    mirrored_nodes = tuple(
        numbers.get(images[node], -1) if node in images else -1 for node in numbers
    )
    return Net(np.reshape(places, (-1, 3)), tuple(edges), names, mirrored_nodes)


def _both_sides(pieces: Sequence[_Piece]) -> list[tuple[_Piece, bool]]:
    """Return the pieces of each curve, and after them those of its mirror image."""
    sides = []
    for _, group in itertools.groupby(pieces, lambda piece: piece.curve.curve.id):
        own = list(group)
        sides += [(piece, False) for piece in own]
        sides += [(piece, True) for piece in own if piece.curve.mirrored]
    return sides


def _partner(piece: _Piece, pieces: Sequence[_Piece], images: dict[NodeKey, NodeKey]) -> int:
    """Return the number of the piece of the same curve that is the mirror image; -1 for none."""
    if piece.curve.mirrored or piece.curve.in_plane:
        return piece.number
    if not piece.curve.across:
        return -1
    if piece.start is None or piece.end is None:
        return piece.number
    ends = images.get(piece.end), images.get(piece.start)
    for each in pieces:
        if each.curve is piece.curve and (each.start, each.end) == ends:
            return each.number
    return -1


@remembered(limit=4000)
def _image(spline: Spline, plane: Plane, backwards: bool) -> Spline:
    image = Reflection(plane).spline(spline)
    return image.reversed() if backwards else image


@remembered(limit=2000)
def _made_symmetric(spline: Spline, plane: Plane) -> Spline:
    return Reflection(plane).symmetric(spline)


@remembered(limit=4000, key=lambda spline, start, end: (spline, start.tobytes(), end.tobytes()))
def _between(spline: Spline, start: Array, end: Array) -> Spline:
    """Return a clamped curve that begins and ends in given places, bent as little as needed."""
    points, (low, high) = spline.control_points, spline.range
    if (points[0] == start).all() and (points[-1] == end).all():
        return spline
    knots = spline.knots
    share = ((knots[1:-3] + knots[2:-2] + knots[3:-1]) / 3.0 - low) / (high - low)
    weight = (share * share * (3.0 - 2.0 * share))[:, None]
    moved = points + (1.0 - weight) * (start - points[0]) + weight * (end - points[-1])
    moved[0], moved[-1] = start, end
    return Spline(knots, moved)
