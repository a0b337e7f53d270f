"""Fills of loops that are mirror images: one is solved, the other is its image to the last bit."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import BSplineSurface, Curve, Spline
from bozzetto.plugin import remembered
from bozzetto_product.fill.domain import Domain
from bozzetto_product.fill.edge_pieces import EdgePiece, opened
from bozzetto_product.fill.fair_solution import FairSolution
from bozzetto_product.fill.fill import CUT, Fill
from bozzetto_product.fill.half_sides import HalfSide, Side, SidePiece
from bozzetto_product.fill.loop_frame import LoopSides
from bozzetto_product.fill.normal_field import NormalField
from bozzetto_product.fill.parted_fill import PartedFill
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.fill.patch_space import space_of
from bozzetto_product.fill.plane_fill import PlaneFill
from bozzetto_product.network.net import HalfEdge, Loop, Net
from bozzetto_product.network.outlines import outlines_of


def mirror_axis(net: Net) -> int | None:
    """Return the axis whose sign changes between twins; None if no axis plane mirrors them."""
    pairs = [(edge, net.edges[edge.twin]) for edge in net.edges if _has_twin(net, edge.twin)]
    pairs = [(one, two) for one, two in pairs if one is not two]
    for axis in range(3):
        if pairs and all(_image_sense(one.spline, two.spline, axis) for one, two in pairs):
            return axis
    return None


def _has_twin(net: Net, twin: int) -> bool:
    return 0 <= twin < len(net.edges)


def _image_sense(one: Spline, two: Spline, axis: int) -> int:
    """Return 1 if a curve is the image of another, -1 if it is run from its end, 0 if neither."""
    image = mirrored(one.control_points, axis)
    if image.shape != two.control_points.shape:
        return 0
    if np.array_equal(image, two.control_points):
        return 1
    return -1 if np.array_equal(image[::-1], two.control_points) else 0


def mirrored(points: Array, axis: int) -> Array:
    """Return points with the sign of a coordinate changed."""
    made = points.copy()
    made[..., axis] = 0.0 - made[..., axis]
    return made


@dataclass(frozen=True)
class EdgeImage:
    """How an edge is the mirror image of another.

    Parameters
    ----------
    axis : int
        The coordinate that changes its sign.
    sense : int
        1 if both run alike, -1 if one is run from its end.
    there, here : (float, float)
        Ranges of the parameters of the other edge, and of this one.
    """

    axis: int
    sense: int
    there: tuple[float, float]
    here: tuple[float, float]

    def parameters(self, at: Array) -> Array:
        """Return parameters of this edge for those of the other one, still rising."""
        (low, high), (begin, end) = self.there, self.here
        if self.sense > 0:
            return (
                at if self.there == self.here else begin + (at - low) / (high - low) * (end - begin)
            )
        return np.asarray(end - (at[::-1] - low) / (high - low) * (end - begin))

    def rows(self, values: Array) -> Array:
        """Return mirrored points or vectors along this edge, for those along the other one."""
        return mirrored(values, self.axis)[:: self.sense]


def edge_image(net: Net, number: int, axis: int) -> EdgeImage | None:
    """Return how the twin of an edge is its image; None if it has none."""
    edge = net.edges[number]
    if not _has_twin(net, edge.twin):
        return None
    return _image_between(edge.spline, net.edges[edge.twin].spline, axis)


@remembered(limit=4000)
def _image_between(edge: Spline, twin: Spline, axis: int) -> EdgeImage | None:
    one, two = opened(edge), opened(twin)
    sense = _image_sense(one, two, axis)
    return EdgeImage(axis, sense, one.range, two.range) if sense else None


@remembered(limit=4000)
def mirrored_piece(piece: EdgePiece, image: EdgeImage) -> EdgePiece:
    """Return the image of a piece of an edge."""
    curve = piece.curve
    knots, points = image.parameters(curve.knots), image.rows(curve.control_points)
    return EdgePiece(Curve(curve.degree, knots, points), piece.length)


def with_twins(
    net: Net, pieces: Sequence[tuple[EdgePiece, ...]], axis: int | None
) -> list[tuple[EdgePiece, ...]]:
    """Return the pieces of all edges, those of the later of two twins as images of the other's."""
    made = list(pieces)
    if axis is None:
        return made
    for number, edge in enumerate(net.edges):
        if not 0 <= edge.twin < number or len(made[edge.twin]) != len(made[number]):
            continue
        image = edge_image(net, edge.twin, axis)
        if image is not None and net.edges[edge.twin].twin == number:
            images = [mirrored_piece(piece, image) for piece in made[edge.twin]]
            made[number] = tuple(images[:: image.sense])
    return made


def image_loop(net: Net, loop: Loop, axis: int) -> Loop | None:
    """Return the mirror image of a loop, run so that its outside stays outside."""
    made = []
    for outline in outlines_of(net, loop):
        run: list[HalfEdge] = []
        for number, forward in reversed(outline):
            image = edge_image(net, number, axis)
            if image is None:
                return None
            run.append((net.edges[number].twin, forward != (image.sense > 0)))
        made += run
    return tuple(made)


def _mirrored_key(
    fill: Fill, net: Net, loop: Loop, pieces: Sequence[tuple[EdgePiece, ...]], axis: int
) -> tuple[object, ...]:
    return fill, loop, axis, tuple(pieces[edge] for edge, _ in loop)


@remembered(limit=1024, key=_mirrored_key)
def mirrored_fill(
    fill: Fill, net: Net, loop: Loop, pieces: Sequence[tuple[EdgePiece, ...]], axis: int
) -> Fill:
    """Return the image of a fill as the fill of the image of its loop.

    Parameters
    ----------
    fill : Fill
        That of the other loop.
    net : Net
        The network of both.
    loop : Loop
        What the image is of: `image_loop` of the other loop, begun anywhere.
    pieces : sequence of tuple of EdgePiece
        Of each edge, from `with_twins`.
    axis : int
        The coordinate that changes its sign.
    """
    if isinstance(fill, PartedFill):
        parts = (mirrored_fill(part, net, loop, pieces, axis) for part in fill.parts)
        whole = fill.whole and mirrored_fill(fill.whole, net, loop, pieces, axis)
        return PartedFill.of(
            loop,
            tuple(part for part in parts if isinstance(part, PatchFill)),
            whole if isinstance(whole, PatchFill) else None,
            frozenset(loop.index(_image_of(net, fill.loop[k], axis)) for k in fill.guided),
            _starts_of(net, loop),
        )
    numbers = {half_edge: number for number, half_edge in enumerate(loop)}

    def image(piece: SidePiece) -> SidePiece:
        if piece.half_edge == CUT:
            assert piece.field is not None
            span = piece.field.spline.range
            over = EdgeImage(axis, 1, span, span)
            other = mirrored_piece(piece.piece, over)
            return SidePiece(CUT, other, not piece.forward, _image_field(piece.field, over))
        number, forward = fill.loop[piece.half_edge]
        twin = net.edges[number].twin
        of_edge = edge_image(net, number, axis)
        assert of_edge is not None
        other = mirrored_piece(piece.piece, of_edge)
        near = [own for own in pieces[twin] if _same(own, other)]
        other = near[0] if near else other
        field = None if piece.field is None else _image_field(piece.field, of_edge)
        onward = forward != (of_edge.sense > 0)
        return SidePiece(numbers[twin, onward], other, onward, field)

    def image_half(half: HalfSide) -> HalfSide:
        points = mirrored(half.points, axis)
        own = tuple(image(piece) for piece in half.pieces)
        return HalfSide(own, not half.onward, half.breaks, half.knots, points)

    outlines = fill.outlines if isinstance(fill, PlaneFill) else (fill.sides,)
    sides = tuple(
        Side((image_half(side.halves[1]), image_half(side.halves[0])), side.bend)
        for outline in outlines
        for side in reversed(outline)
    )
    count = len(fill.patches)
    patches = tuple(_image_patch(fill.patches[-number], axis) for number in range(count))
    key = fill.key + f" mirrored {axis}".encode()
    if isinstance(fill, PatchFill):
        solution = _image_solution(fill.solution, sides, axis)
        return PatchFill(loop, sides, patches, fill.spacing, key, solution)
    assert isinstance(fill, PlaneFill)
    return PlaneFill(loop, sides, patches, fill.spacing, key, fill.starts)


def _image_of(net: Net, half_edge: HalfEdge, axis: int) -> HalfEdge:
    """Return the half edge that is the image of one, run so that its outside stays outside."""
    number, forward = half_edge
    image = edge_image(net, number, axis)
    assert image is not None
    return net.edges[number].twin, forward != (image.sense > 0)


def _starts_of(net: Net, loop: Loop) -> tuple[int, ...]:
    """Return the first half edge of each outline of a loop."""
    lengths = [len(outline) for outline in outlines_of(net, loop)]
    return tuple(itertools.accumulate(lengths[:-1], initial=0))


def _same(one: EdgePiece, two: EdgePiece) -> bool:
    return np.array_equal(one.curve.control_points, two.curve.control_points)


def _image_field(field: NormalField, image: EdgeImage) -> NormalField:
    points = image.rows(field.spline.control_points)
    spline = Spline(image.parameters(field.spline.knots), points)
    return NormalField(spline, image.parameters(field.parameters), image.rows(field.normals))


def _image_patch(patch: BSplineSurface, axis: int) -> BSplineSurface:
    return replace(patch, control_points=mirrored(patch.control_points, axis)).turned_over()


def _image_solution(solution: FairSolution, sides: tuple[Side, ...], axis: int) -> FairSolution:
    flip = np.array((1.0, -1.0))
    domain = solution.space.domain
    corners = np.roll(domain.corners[::-1], 1, axis=0) * flip
    space = space_of(Domain(corners, domain.middles[::-1] * flip, domain.centre * flip))
    loop = LoopSides.of(sides)
    nets = mirrored(solution.nets * solution.loop.size + solution.loop.origin, axis)
    nets = np.roll(nets[::-1], 1, axis=0).transpose(0, 2, 1, 3)
    every = np.empty((int(space.numbers.max()) + 1, 3))
    every[space.numbers] = (nets - loop.origin) / loop.size
    return replace(solution, space=space, loop=loop, free=every[: space.free])
