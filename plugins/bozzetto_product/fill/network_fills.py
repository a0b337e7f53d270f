"""The surfaces of all loops of a network."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.fill.edge_pieces import EdgePiece, halved, opened, pieces_of
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.holed_fill import holed_fill
from bozzetto_product.fill.inner_cuts import parted_fill, turn_round
from bozzetto_product.fill.loop_fill import fill_loop, fill_with_holes
from bozzetto_product.fill.loop_sides import piece_count, sides_of_loop
from bozzetto_product.fill.mirrored_fill import (
    image_loop,
    mirror_axis,
    mirrored_fill,
    with_twins,
)
from bozzetto_product.fill.normal_field import NormalField
from bozzetto_product.fill.normals import LoopNormals, edge_normals, turned_over
from bozzetto_product.fill.parted_fill import PartedFill
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.network.net import HalfEdge, Loop, Net
from bozzetto_product.network.outlines import outlines_of

SEGMENTS: Final = 16.0
"""Segments of the mesh along an edge of middling length."""

UNKEPT: Final = 1.0
"""Angle to its normals, degrees, from which a surface that folds is made a crease there first."""


SEEN: Final = 5.0
"""Angle to its normals, degrees, from which a surface in parts is made a crease there."""


BENT_INWARD: Final = 2
"""Sides with a concave corner from which on patches round one centre may bulge without folding."""

BULGE: Final = 0.995
"""Share of the area of a surface round one centre below which one in parts is taken: the other
bulges."""

ONCE_ROUND: Final = 0.25 * float(np.pi)
"""How far from once round a loop may turn, radians, that is believed to turn once."""


def fill_net(
    net: Net,
    loops: Sequence[Loop],
    *,
    checkpoint: Callable[[], None] = lambda: None,
) -> tuple[Fill | None, ...]:
    """Fill loops, smooth over the smooth edges between them.

    Surfaces are remembered by their curves and normals, so those that did not change cost nothing.

    Parameters
    ----------
    net : Net
        The network.
    loops : sequence of Loop
        Counter-clockwise seen from outside.
    checkpoint : callable
        Called before each loop, and again before one that folds is tried with finer pieces.

    Returns
    -------
    tuple of Fill or None
        One for each loop; None where there is no surface.
    """
    axis = mirror_axis(net)
    plan = _plan(net, tuple(loops))
    normals, cut, spacing = plan.normals, plan.pieces, plan.spacing

    def filled(cut: Sequence[tuple[EdgePiece, ...]]) -> tuple[Fill | None, ...]:
        pieces = with_twins(net, cut, axis)
        return _fills(net, loops, normals, pieces, spacing, axis, checkpoint)

    made = filled(cut)
    finer = _cut_finer(net, loops, normals, cut, spacing, made, checkpoint)
    if not finer:
        return made
    finer |= {_twin(net, edge) for edge in finer}
    again = filled(
        [halved(net.edges[k].spline, own) if k in finer else own for k, own in enumerate(cut)]
    )
    lost = any(_is_sound(one) and not _is_sound(two) for one, two in zip(made, again, strict=True))
    return made if lost else again


@dataclass(frozen=True, eq=False)
class _Plan:
    """Fills of the loops of a net.

    Parameters
    ----------
    normals : tuple of LoopNormals
        Of each loop.
    pieces : tuple of tuple of EdgePiece
        Of each edge; not yet those of twins.
    spacing : float
        Length of the segments of edges in meshes, mm.
    """

    normals: tuple[LoopNormals, ...]
    pieces: tuple[tuple[EdgePiece, ...], ...]
    spacing: float


@remembered(limit=8)
def _plan(net: Net, loops: tuple[Loop, ...]) -> _Plan:
    normals = edge_normals(net, loops)
    counts = [2] * len(net.edges)
    for loop, own in zip(loops, normals, strict=True):
        least = max(piece_count(each.corners) for each in own.outlines())
        for edge, _ in loop:
            counts[edge] = max(counts[edge], least)
    counts = [max(count, counts[_twin(net, edge)]) for edge, count in enumerate(counts)]
    pieces = [pieces_of(each.spline, many) for each, many in zip(net.edges, counts, strict=True)]
    return _Plan(normals, tuple(pieces), mesh_spacing(net, loops))


def _twin(net: Net, edge: int) -> int:
    twin = net.edges[edge].twin
    return twin if twin >= 0 else edge


def guide_of(net: Net, loops: Sequence[Loop], number: int) -> PatchFill | None:
    """Return the patches that fill the outline of a loop, as if it had no holes.

    Parameters
    ----------
    net, loops
        See `fill_net`.
    number : int
        Which of the loops.

    Returns
    -------
    PatchFill or None
        None where it lies in a plane, or patches round one centre fold.
    """
    plan, loop = _plan(net, tuple(loops)), loops[number]
    normals = plan.normals[number]
    pieces = with_twins(net, plan.pieces, mirror_axis(net))
    return _guide(loop, normals, tuple(pieces[edge] for edge, _ in loop), plan.spacing)


def _is_sound(fill: Fill | None) -> bool:
    return fill is not None and not fill.folded


def _cut_finer(
    net: Net,
    loops: Sequence[Loop],
    normals: Sequence[LoopNormals],
    cut: Sequence[tuple[EdgePiece, ...]],
    spacing: float,
    fills: Sequence[Fill | None],
    checkpoint: Callable[[], None],
) -> set[int]:
    """Return the edges of loops that have no surface, and have one if pieces are cut in two."""
    found: set[int] = set()
    for loop, own, fill in zip(loops, normals, fills, strict=True):
        if not _is_sound(fill) and len(own.starts) == 1:
            checkpoint()
            pieces = tuple(halved(net.edges[edge].spline, cut[edge]) for edge, _ in loop)
            if _parted(loop, own, pieces, spacing) is not None:
                found |= {edge for edge, _ in loop}
    return found


def _fills(
    net: Net,
    loops: Sequence[Loop],
    normals: Sequence[LoopNormals],
    pieces: Sequence[tuple[EdgePiece, ...]],
    spacing: float,
    axis: int | None,
    checkpoint: Callable[[], None],
) -> tuple[Fill | None, ...]:
    """Return the fills of loops whose edges are cut into pieces; images of those of twins."""
    made: list[Fill | None] = []
    known: dict[frozenset[HalfEdge], Fill] = {}
    for loop, own in zip(loops, normals, strict=True):
        checkpoint()
        image = None if axis is None else image_loop(net, loop, axis)
        other = known.get(frozenset(image or ()))
        if image and other is not None and axis is not None and is_run_of(net, image, other.loop):
            made.append(mirrored_fill(other, net, loop, pieces, axis))
            continue
        cut = tuple(pieces[edge] for edge, _ in loop)
        splines = tuple(opened(net.edges[edge].spline) for edge, _ in loop)
        fill = _filled(loop, own, cut, spacing, splines)
        made.append(fill)
        if fill is not None:
            known[frozenset(loop)] = fill
    return tuple(made)


def is_run_of(net: Net, image: Loop, loop: Loop) -> bool:
    """Whether a loop is another one, each outline begun anywhere."""
    return len(image) == len(loop) and all(
        _is_begun_elsewhere(one, two)
        for one, two in zip(outlines_of(net, image), outlines_of(net, loop), strict=False)
    )


def _is_begun_elsewhere(image: Loop, outline: Loop) -> bool:
    if outline[0] not in image:
        return False
    start = image.index(outline[0])
    return image[start:] + image[:start] == outline


def _fill_key(
    loop: Loop,
    normals: LoopNormals,
    pieces: tuple[tuple[EdgePiece, ...], ...],
    spacing: float,
    splines: Sequence[Spline] = (),
) -> tuple[object, ...]:
    return loop, normals.corners, normals.fields, normals.starts, pieces, spacing


@remembered(limit=1024, key=_fill_key)
def _filled(
    loop: Loop,
    normals: LoopNormals,
    pieces: tuple[tuple[EdgePiece, ...], ...],
    spacing: float,
    splines: tuple[Spline, ...] = (),
) -> Fill | None:
    """Return the fill of a loop with the pieces of its edges; None where there is no surface.

    The curves of the edges themselves, opened, are needed where it has holes.

    What folds gets creases at smooth edges, if it then does not: a surface that closes is more use
    than none.
    """
    by_edge = {edge: own for (edge, _), own in zip(loop, pieces, strict=True)}
    if len(normals.starts) > 1:
        plane = _plane_with_holes(loop, normals, by_edge, spacing)
        return plane or _bent_with_holes(loop, normals, pieces, spacing, splines)

    def filled(own: LoopNormals) -> Fill | None:
        try:
            return fill_loop(sides_of_loop(loop, own, by_edge), loop=loop, spacing=spacing)
        except UserError:
            return None

    fill = filled(normals)
    if fill is not None and not fill.folded:
        return _without_bulge(fill, normals, pieces)
    if fill is not None:
        for fields in _with_creases(normals.fields, fill.g1_degrees):
            other = filled(replace(normals, fields=fields))
            if other is not None and not other.folded:
                return other
    parted = _parted(loop, normals, pieces, spacing)
    if parted is not None:
        return parted
    for convex in _with_convex_corners(loop, normals, pieces):
        other = filled(convex)
        if other is not None and not other.folded:
            return other
    return fill


def _plane_with_holes(
    loop: Loop,
    normals: LoopNormals,
    pieces: Mapping[int, Sequence[EdgePiece]],
    spacing: float,
) -> Fill | None:
    """Return the plane of a loop with holes; None where it lies in none."""
    outlines = []
    for first, own in zip(normals.starts, normals.outlines(), strict=True):
        outline = loop[first : first + len(own.corners)]
        if first:
            own = replace(own, corners=tuple(map(turned_over, own.corners)))
        outlines.append(sides_of_loop(outline, own, pieces, first))
    try:
        return fill_with_holes(outlines, loop=loop, spacing=spacing)
    except UserError:
        return None


def _bent_with_holes(
    loop: Loop,
    normals: LoopNormals,
    pieces: tuple[tuple[EdgePiece, ...], ...],
    spacing: float,
    splines: tuple[Spline, ...],
) -> PartedFill | None:
    """Return the fill of a loop with holes that lies in no plane; None where there is none."""
    guide = _guide(loop, normals, pieces, spacing)
    return None if guide is None else holed_fill(loop, normals, pieces, splines, guide)


def _guide(
    loop: Loop, normals: LoopNormals, pieces: tuple[tuple[EdgePiece, ...], ...], spacing: float
) -> PatchFill | None:
    """Return the patches that fill the outline of a loop; see `guide_of`."""
    end = (*normals.starts[1:], len(loop))[0]
    fill = _filled(loop[:end], normals.outlines()[0], pieces[:end], spacing)
    return fill if isinstance(fill, PatchFill) and not fill.folded else None


def _without_bulge(
    fill: Fill, normals: LoopNormals, pieces: tuple[tuple[EdgePiece, ...], ...]
) -> Fill:
    """Return a surface, or one in parts of the same loop that is smaller.

    Patches round a centre that does not see all of the outline may bulge without folding, where
    no neighbours tell tangent planes.
    """
    bends = sum(side.bend != 0.0 for side in fill.sides)
    if bends < BENT_INWARD or not isinstance(fill, PatchFill) or any(normals.fields):
        return fill
    found = parted_fill(fill.loop, normals, pieces, fill.spacing)
    return fill if found is None or found.area > BULGE * fill.area else replace(found, whole=fill)


def _with_convex_corners(
    loop: Loop, normals: LoopNormals, pieces: Sequence[Sequence[EdgePiece]]
) -> Iterator[LoopNormals]:
    """Yield the corners of a loop with a concave one as a convex one, and creases all round.

    Only where the loop then turns about once round, and does not as it is: then its neighbours told
    the corner wrong, and normals along smooth edges there point to the wrong side.
    """
    without = replace(normals, fields=(None,) * len(loop))
    own = abs(turn_round(loop, without, pieces) - 2.0 * np.pi)
    for number, corner in enumerate(normals.corners):
        if corner.concave:
            corners = list(normals.corners)
            corners[number] = replace(corner, normal=-corner.normal, concave=False)
            other = replace(without, corners=tuple(corners))
            if abs(turn_round(loop, other, pieces) - 2.0 * np.pi) < min(own, ONCE_ROUND):
                yield other


@remembered(limit=256, key=_fill_key)
def _parted(
    loop: Loop, normals: LoopNormals, pieces: tuple[tuple[EdgePiece, ...], ...], spacing: float
) -> PartedFill | None:
    found = parted_fill(loop, normals, pieces, spacing)
    angles = np.nan_to_num(found.g1_degrees) if found else np.full(len(loop), np.inf)
    if found is not None and float(angles.max()) <= SEEN:
        return found
    fields = tuple(
        None if angle > SEEN else field for field, angle in zip(normals.fields, angles, strict=True)
    )
    if fields == normals.fields:
        return found
    return parted_fill(loop, replace(normals, fields=fields), pieces, spacing) or found


Fields = tuple[NormalField | None, ...]


def _with_creases(fields: Fields, angles: Sequence[float]) -> Iterator[Fields]:
    """Yield the normals of a loop without those that it cannot keep to, then without any."""
    known = {fields}
    for least in (UNKEPT, -1.0):
        fewer = tuple(
            None if angle > least else field for field, angle in zip(fields, angles, strict=True)
        )
        if fewer not in known:
            known.add(fewer)
            yield fewer


def mesh_spacing(net: Net, loops: Sequence[Loop]) -> float:
    """Return the length of the segments of edges in meshes, mm.

    In steps of a factor of √2, so that few changes of the network change it.
    """
    edges = sorted({edge for loop in loops for edge, _ in loop})
    if not edges:
        return 1.0
    lengths = [sum(p.length for p in pieces_of(net.edges[e].spline, 2)) for e in edges]
    wanted = float(np.median(lengths)) / SEGMENTS
    return float(2.0 ** (0.5 * np.round(2.0 * np.log2(max(wanted, 1e-12)))))
