"""A detail carved into a shell: one region after another."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import BSplineSurface
from bozzetto.plugin import remembered
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.course import (
    CORNER,
    REACH,
    TURNED,
    MeetsCorner,
    Passage,
    course_across,
    course_of,
)
from bozzetto_product.details.floor import Offset, offset_of
from bozzetto_product.details.floor_places import LaidFloor
from bozzetto_product.details.levels import Level, floor_level, inset_points
from bozzetto_product.details.region import (
    CutShell,
    cut_shell,
    faces_over,
    first_face,
    flooded,
    outline_edges,
    region_faces,
)
from bozzetto_product.details.ring import Ring, spline_of_stretch
from bozzetto_product.details.shell import Owner, Shell
from bozzetto_product.details.walls import with_walls
from bozzetto_product.model.details import DetailKind

OVER_CREASES: Final = ("cut", "split")
"""Kinds of details that may lie over creases: they have no floor."""

NUDGES: Final = ((0.0, 0.0), (0.61, 0.37), (-0.43, 0.71), (0.29, -0.83))
"""Ways to move an outline that goes through a corner of faces, in units of `NUDGE`."""

NUDGE: Final = 2e-5
"""Share of the size by which such an outline is moved."""

ROOM: Final = 1.02
"""How much thicker than a detail is deep the body must be."""

PLACES: Final = 65
"""Places of a stretch through which an inset outline goes."""

LOOKS: Final = 12
"""Places along each axis of a region at which the thickness of the body is looked at."""

GAP: Final = "The gap is wider than the outline has room for. Make the gap smaller."
DRAFT: Final = (
    "The walls would meet before the floor. Make the draft angle or the depth smaller, or the "
    "outline rounder."
)
GROOVE: Final = (
    "The walls of the gap would meet before its floor. Make the draft angle or the depth smaller, "
    "or the gap wider."
)

Thickness = Callable[[Array, Array], Array]
"""Points and outward normals, (n, 3), to how far the body reaches behind them, (n,) mm."""


Near = Callable[[Array], Array]
"""A place of the chart, (2,), to a point in space near the surface meant there, (3,) mm."""


@dataclass(frozen=True)
class Form:
    """Result of carving a region.

    Parameters
    ----------
    kind : str
    depth : float
        mm.
    draft : float
        Radians.
    gap : float
        mm.
    """

    kind: DetailKind
    depth: float
    draft: float
    gap: float


@dataclass(frozen=True, eq=False)
class Carved:
    """A shell with a region carved.

    Parameters
    ----------
    shell : Shell
    floor : LaidFloor, optional
        What its walls end in, if that is a floor.
    """

    shell: Shell
    floor: LaidFloor | None = None


def carved(
    shell: Shell,
    chart: Chart,
    rings: Sequence[Ring],
    near: Near,
    form: Form,
    thickness: Thickness,
    number: int,
) -> Carved:
    """Return a shell with one region carved into it.

    Parameters
    ----------
    shell : Shell
        What is carved.
    chart : Chart
        Over the region.
    rings : sequence of Ring
        The outline of the region counter-clockwise, and clockwise those of holes in it.
    near : callable
        Tells which of several surfaces over a place is meant.
    form : Form
        What becomes of the region.
    thickness : callable
        How thick the body is.
    number : int
        Of the detail.

    Raises
    ------
    UserError
        If the region cannot be carved; the message says what to change.
    """
    return _nudged(
        shell, rings, lambda moved: _carved(shell, chart, moved, near, form, thickness, number)
    )


def parted(shell: Shell, chart: Chart, ring: Ring, near: Near, number: int) -> Carved:
    """Return a shell whose patches are parted by a curve from border to border.

    Parameters
    ----------
    shell : Shell
        What is parted.
    chart : Chart
        Over the curve.
    ring : Ring
        The curve; it may miss the borders a little.
    near : callable
        Tells which of several surfaces over a place is meant.
    number : int
        Of the detail.

    Raises
    ------
    UserError
        If it does not part a patch.
    """

    def made(rings: list[Ring]) -> Carved:
        longer = _longer(rings[0])
        ends = np.array((1.0, longer.end - 1.0))
        place = longer.value(ends.mean(keepdims=True))[0]
        first = first_face(shell, chart, place, near(place), 1.0)
        courses = [course_across(shell, chart, longer, first, ends)]
        edges = outline_edges(shell, chart, [longer], courses, None, [])
        cut = cut_shell(shell, edges, courses, [], closed=False)
        return Carved(_owned(cut.shell, cut.inside, number))

    return _nudged(shell, [ring], made)


@remembered(limit=64)
def _longer(ring: Ring) -> Ring:
    return ring.drawn_out(REACH)


def _nudged(shell: Shell, rings: Sequence[Ring], made: Callable[[list[Ring]], Carved]) -> Carved:
    """Return what is made of outlines, moved a little where they go through a corner of faces."""
    for way in NUDGES:
        step = NUDGE * shell.size * np.array(way)
        try:
            return made([ring.moved(step) for ring in rings] if step.any() else list(rings))
        except MeetsCorner:
            continue
    raise UserError(CORNER)


def _carved(
    shell: Shell,
    chart: Chart,
    rings: list[Ring],
    near: Near,
    form: Form,
    thickness: Thickness,
    number: int,
) -> Carved:
    first = _first_faces(shell, chart, rings, near)
    creased = form.kind in OVER_CREASES
    courses = [
        course_of(shell, chart, r, f, 1.0, creased=creased)
        for r, f in zip(rings, first, strict=True)
    ]
    under = [p.face for c in courses for p in c]
    faces = region_faces(shell, chart, rings[0], under, creased=creased)
    surfaces = tuple({id(s): s for s in (shell.faces[face].surface for face in faces)}.values())
    through = form.kind == "cut" and shell.is_closed
    plan = _planned(chart, tuple(rings), surfaces, form, thickness, shell.size, through)
    for inner in plan.rings[len(rings) :]:
        (start,) = _first_faces(shell, chart, [inner], near)
        courses.append(course_of(shell, chart, inner, start, 1.0))
    owner = Owner(shell.owners[first[0]].patch, number, made=True)
    far = [_far_course(shell, chart, ring, plan.offset) for ring in plan.far]
    edges = outline_edges(shell, chart, plan.rings, courses, plan.level, far)
    cut = cut_shell(shell, edges, courses, far, creased=creased)
    if plan.level is None:
        inside = cut.inside
        return Carved(_owned(cut.shell, inside, number) if form.kind == "split" else _opened(cut))
    made = with_walls(cut, edges, plan.level.floor, owner)
    floor = plan.level.floor
    laid = None
    if floor is not None:
        height = form.depth if form.kind == "raised" else -form.depth
        laid = LaidFloor(chart, floor, made.faces[-1], height, plan.offset)
    if form.kind == "button":
        within = {cut.tops[k] for k, edge in enumerate(edges) if edge.ring >= len(rings)}
        made = _owned(made, flooded(made, within), number)
    return Carved(made, laid)


def _first_faces(shell: Shell, chart: Chart, rings: Sequence[Ring], near: Near) -> list[int]:
    starts = [ring.value(np.zeros(1))[0] for ring in rings]
    return [first_face(shell, chart, start, near(start), 1.0) for start in starts]


@dataclass(frozen=True, eq=False)
class _Plan:
    """Shape of a detail, whatever has become of the faces that it lies on.

    Parameters
    ----------
    rings : tuple of Ring
        The outlines, and behind them those of a button in its opening.
    far : tuple of Ring
        The outlines on the far side of the body, of what goes through it.
    level : Level, optional
        Where walls end; None without walls.
    offset : callable
        Places and normals of the surfaces.
    """

    rings: tuple[Ring, ...]
    far: tuple[Ring, ...]
    level: Level | None
    offset: Offset


@remembered(limit=256)
def _planned(
    chart: Chart,
    rings: tuple[Ring, ...],
    surfaces: tuple[BSplineSurface, ...],
    form: Form,
    thickness: Thickness,
    size: float,
    through: bool,
) -> _Plan:
    """Return what a detail is made of.

    It depends on surfaces as wholes and not on how faces are trimmed, so that a detail needs no
    new one when another detail has changed.
    """
    offset = offset_of(surfaces, chart)
    count = len(rings)
    if form.kind == "button":
        inner = [_inner_ring(chart, offset, ring, form.gap) for ring in rings]
        rings = (*rings, *inner)
        _check(rings, rings[:count], [ring.reversed() for ring in inner], GAP)
    if through:
        far = _far_rings(chart, offset, rings, form.draft, thickness)
        return _Plan(rings, far, Level(None, rings=far), offset)
    if form.kind in ("split", "cut"):
        return _Plan(rings, (), None, offset)
    height = form.depth if form.kind == "raised" else -form.depth
    level = floor_level(chart, rings, surfaces, height, form.draft, size)
    if height < 0.0:
        _check_room(offset, rings[0], form.depth, thickness)
    floors = [_on_floor(level, k, ring) for k, ring in enumerate(rings)]
    _check(floors, rings, floors, GROOVE if form.kind == "button" else DRAFT)
    return _Plan(rings, (), level, offset)


def _owned(shell: Shell, faces: Collection[int], number: int) -> Shell:
    """Return the shell with faces coloured by a detail, but for walls."""
    owners = [
        replace(owner, detail=number) if k in faces and not owner.is_wall else owner
        for k, owner in enumerate(shell.owners)
    ]
    return replace(shell, owners=tuple(owners))


def _opened(cut: CutShell) -> Shell:
    kept = [k for k in range(len(cut.shell.faces)) if k not in cut.inside]
    return Shell(
        cut.shell.edges,
        tuple(cut.shell.faces[k] for k in kept),
        tuple(cut.shell.owners[k] for k in kept),
    )


def _inner_ring(chart: Chart, offset: Offset, ring: Ring, gap: float) -> Ring:
    """Return the border of a button in its opening, run the other way: the region lies between."""
    rows = []
    for number in range(len(ring.stretches)):
        t = np.linspace(number, number + 1.0, PLACES)
        t[-1] -= 1e-12 * max(1.0, t[-1])
        rows.append(chart.flat(inset_points(chart, offset, ring, t, gap, 0.0)))
    return _joined(rows).reversed()


def _far_rings(
    chart: Chart, offset: Offset, rings: Sequence[Ring], draft: float, thickness: Thickness
) -> tuple[Ring, ...]:
    """Return where outlines leave the body on its far side: smaller by the draft."""
    if draft == 0.0:
        return tuple(rings)
    made = []
    for ring in rings:
        rows = []
        for number in range(len(ring.stretches)):
            t = np.linspace(number, number + 1.0, PLACES)
            t[-1] -= 1e-12 * max(1.0, t[-1])
            flat, along = ring.value(t), ring.tangents(t)
            along = along / np.linalg.norm(along, axis=1, keepdims=True)
            points, _ = offset(flat)
            deep = thickness(points, np.broadcast_to(chart.normal, points.shape))
            if not np.isfinite(deep).all():
                raise UserError(TURNED)
            left, on = ring.inset_by(t, np.tan(draft) * deep)
            inward = np.column_stack((-along[:, 1], along[:, 0]))
            rows.append(flat + left[:, None] * inward + on[:, None] * along)
        made.append(_joined(rows))
    _check(made, rings, made, DRAFT)
    return tuple(made)


def _joined(rows: list[Array]) -> Ring:
    """Return stretches through points; where ends differ a little they meet in the middle."""
    starts = [0.5 * (rows[k - 1][-1] + rows[k][0]) for k in range(len(rows))]
    made = []
    for row, start, end in zip(rows, starts, [*starts[1:], starts[0]], strict=True):
        share = np.linspace(0.0, 1.0, len(row))[:, None]
        moved = row + (1.0 - share) * (start - row[0]) + share * (end - row[-1])
        moved[0], moved[-1] = start, end
        made.append(spline_of_stretch(moved))
    return Ring(tuple(made))


def _far_course(shell: Shell, chart: Chart, ring: Ring, offset: Offset) -> tuple[Passage, ...]:
    """Return the way of an outline over the far side of the body."""
    start = ring.value(np.zeros(1))
    top = float(chart.heights(offset(start)[0])[0])
    below = [
        (top - float(chart.heights(where[None])[0]), number)
        for number, where in faces_over(shell, chart, start[0], -1.0)
    ]
    below = [(depth, number) for depth, number in below if depth > 0.0]
    if not below:
        raise UserError(TURNED)
    return course_of(shell, chart, ring, min(below)[1], -1.0, creased=True)


def _on_floor(level: Level, number: int, ring: Ring) -> Array:
    assert level.places is not None
    return level.places(number, ring.polyline_at[:-1], None)


Outline = Ring | Array


def _check(
    region: Sequence[Outline], before: Sequence[Ring], after: Sequence[Outline], sentence: str
) -> None:
    """Raise `UserError` unless outlines bound one region, and none turned back when it was inset.

    Parameters
    ----------
    region : sequence of Ring or (n, 2) float
        The outline round it, then those of holes.
    before, after : sequence of Ring or (n, 2) float
        Outlines, and the same inset, at the same parameters.
    sentence : str
        What to say.
    """
    import shapely

    rows = [_polygon(outline) for outline in region]
    turned = [shapely.LinearRing(row).is_ccw for row in rows]
    sound = shapely.Polygon(rows[0], rows[1:]).is_valid and turned[0] and not any(turned[1:])
    for ring, inset in zip(before, after, strict=True):
        old = ring.polyline[:-1]
        new = inset if not isinstance(inset, Ring) else inset.value(ring.polyline_at[:-1])
        steps = np.roll(old, -1, axis=0) - old, np.roll(new, -1, axis=0) - new
        sound = sound and bool(((steps[0] * steps[1]).sum(axis=1) > 0.0).all())
    if not sound:
        raise UserError(sentence)


def _polygon(outline: Outline) -> Array:
    return outline.polyline[:-1] if isinstance(outline, Ring) else outline


def _check_room(offset: Offset, ring: Ring, depth: float, thickness: Thickness) -> None:
    """Raise `UserError` where the body is not thicker than a detail is deep."""
    import shapely

    region = shapely.Polygon(ring.polyline[:-1])
    low, high = ring.polyline.min(axis=0), ring.polyline.max(axis=0)
    axes = [np.linspace(low[k], high[k], LOOKS) for k in range(2)]
    flat = np.column_stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")])
    flat = np.vstack((flat[shapely.contains_xy(region, *flat.T)], ring.polyline[::4]))
    points, normals = offset(flat)
    known = np.isfinite(points).all(axis=1)
    least = float(thickness(points[known], normals[known]).min(initial=np.inf))
    if least < ROOM * depth:
        raise UserError(
            f"The body is only {least:.3g} mm thick here. Make the detail less deep, or cut it "
            "through."
        )
