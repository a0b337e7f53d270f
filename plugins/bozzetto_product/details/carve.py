"""A detail carved into a shell: one region after another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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
from bozzetto_product.details.creased_floors import carved_over_creases
from bozzetto_product.details.floor import Offset, offset_of
from bozzetto_product.details.floor_places import LaidFloor
from bozzetto_product.details.form import Carved, Form, Near
from bozzetto_product.details.inset_rings import (
    DRAFT,
    GAP,
    GROOVE,
    Thickness,
    check_inset,
    check_room,
    far_rings,
    inner_ring,
)
from bozzetto_product.details.levels import Level, floor_level
from bozzetto_product.details.region import (
    CutShell,
    cut_shell,
    faces_over,
    first_face,
    flooded,
    outline_edges,
    region_faces,
)
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.shell import Owner, Shell, owned
from bozzetto_product.details.walls import whole_floor, with_walls

OVER_WALLS: Final = ("cut", "split")
"""Kinds of details that may lie over walls of others: they have no floor."""

NUDGES: Final = ((0.0, 0.0), (0.61, 0.37), (-0.43, 0.71), (0.29, -0.83))
"""Ways to move an outline that goes through a corner of faces, in units of `NUDGE`."""

NUDGE: Final = 2e-5
"""Share of the size by which such an outline is moved."""


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
        return Carved(owned(cut.shell, cut.inside, number))

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
    walls = form.kind in OVER_WALLS
    courses = [
        course_of(shell, chart, r, f, 1.0, walls=walls) for r, f in zip(rings, first, strict=True)
    ]
    under = [p.face for c in courses for p in c]
    owner = Owner(shell.owners[first[0]].patch, number, made=True)
    if not walls:
        creased = carved_over_creases(shell, chart, rings, courses, form, thickness, near, owner)
        if creased is not None:
            return creased
    faces = region_faces(shell, chart, rings[0], under, creased=walls)
    surfaces = tuple({id(s): s for s in (shell.faces[face].surface for face in faces)}.values())
    through = form.kind == "cut" and shell.is_closed
    plan = _planned(chart, tuple(rings), surfaces, form, thickness, shell.size, through)
    for inner in plan.rings[len(rings) :]:
        (start,) = _first_faces(shell, chart, [inner], near)
        courses.append(course_of(shell, chart, inner, start, 1.0))
    far = [_far_course(shell, chart, ring, plan.offset) for ring in plan.far]
    edges = outline_edges(shell, chart, plan.rings, courses, plan.level, far)
    cut = cut_shell(shell, edges, courses, far, walls=walls)
    if plan.level is None:
        inside = cut.inside
        return Carved(owned(cut.shell, inside, number) if form.kind == "split" else _opened(cut))
    floor = plan.level.floor
    made = with_walls(cut, edges, () if floor is None else (whole_floor(edges, floor),), owner)
    laid: tuple[LaidFloor, ...] = ()
    if floor is not None:
        laid = (LaidFloor(chart, floor, made.faces[-1], form.height, plan.offset),)
    if form.kind == "button":
        within = {cut.tops[k] for k, edge in enumerate(edges) if edge.ring >= len(rings)}
        made = owned(made, flooded(made, within), number)
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
        inner = [inner_ring(chart, offset, ring, form.gap) for ring in rings]
        rings = (*rings, *inner)
        check_inset(rings, rings[:count], [ring.reversed() for ring in inner], GAP)
    if through:
        far = far_rings(chart, offset, rings, form.draft, thickness)
        return _Plan(rings, far, Level(None, rings=far), offset)
    if form.kind in ("split", "cut"):
        return _Plan(rings, (), None, offset)
    level = floor_level(chart, rings, surfaces, form.height, form.draft, size)
    if form.height < 0.0:
        check_room(offset, rings[0], form.depth, thickness)
    floors = [_on_floor(level, k, ring) for k, ring in enumerate(rings)]
    check_inset(floors, rings, floors, GROOVE if form.kind == "button" else DRAFT)
    return _Plan(rings, (), level, offset)


def _opened(cut: CutShell) -> Shell:
    kept = [k for k in range(len(cut.shell.faces)) if k not in cut.inside]
    return Shell(
        cut.shell.edges,
        tuple(cut.shell.faces[k] for k in kept),
        tuple(cut.shell.owners[k] for k in kept),
    )


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
    return course_of(shell, chart, ring, min(below)[1], -1.0, walls=True)


def _on_floor(level: Level, number: int, ring: Ring) -> Array:
    assert level.places is not None
    return level.places(number, ring.polyline_at[:-1], None)
