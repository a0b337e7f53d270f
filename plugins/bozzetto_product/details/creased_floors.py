"""Details over creases: a floor for each smooth zone, and mitres where floors meet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import signed_area
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.course import Passage, course_of
from bozzetto_product.details.floor_places import LaidFloor
from bozzetto_product.details.folded_rings import folded
from bozzetto_product.details.form import Carved, Form, Near
from bozzetto_product.details.inset_rings import (
    DRAFT,
    GAP,
    GROOVE,
    Thickness,
    check_inset,
    check_room,
    inner_ring,
)
from bozzetto_product.details.levels import zone_level
from bozzetto_product.details.mitres import NARROW, Mitre, mitred_floors
from bozzetto_product.details.region import (
    CutShell,
    OutlineEdge,
    cut_shell,
    first_face,
    flooded,
    outline_edges,
    region_faces,
)
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.shell import Owner, Shell, is_crease, owned
from bozzetto_product.details.wall_feet import following
from bozzetto_product.details.walls import FloorFace, with_walls
from bozzetto_product.details.zones import ZonedRegion, creases_within, zones_of

CLOSED: Final = 1e-9
"""Share of the extent of a floor by which its sides may miss one another."""

SAMPLES: Final = 12
"""Places on each span of a side, at which it is looked at."""


def carved_over_creases(
    shell: Shell,
    chart: Chart,
    rings: Sequence[Ring],
    courses: Sequence[tuple[Passage, ...]],
    form: Form,
    thickness: Thickness,
    near: Near,
    owner: Owner,
) -> Carved | None:
    """Return a shell with a region carved that has floors; None where no crease lies inside.

    Parameters
    ----------
    shell, chart, rings, form, thickness, near
        See `carve.carved`.
    courses : sequence of tuple of Passage
        Of the rings.
    owner : Owner
        Of walls and floors.

    Raises
    ------
    UserError
        If there is no room for walls and floors.
    """
    under = [passage.face for course in courses for passage in course]
    if not creases_within(
        shell, chart, rings[0], region_faces(shell, chart, rings[0], under, creased=True)
    ):
        return None
    cut, _, region = _zoned(shell, chart, rings, courses)
    if len(region.zones) < 2:
        return None
    every, ways = _folded(shell, chart, rings, near)
    count = len(every)
    if form.kind == "button":
        inner = [inner_ring(chart, region.offset, ring, form.gap) for ring in every]
        check_inset([*every, *inner], every, [ring.reversed() for ring in inner], GAP)
        inside, others = _folded(shell, chart, inner, near)
        every, ways = [*every, *inside], [*ways, *others]
    cut, edges, region = _zoned(shell, chart, every, ways)
    if form.height < 0.0:
        check_room(region.offset, every[0], form.depth, thickness)
    inward = form.depth * float(np.tan(form.draft))
    reach = form.depth * region.steepness + 2.0 * inward
    levels = [
        zone_level(zone, every, form.height, inward, shell.size, reach) for zone in region.zones
    ]
    mitred = mitred_floors(cut, region, every, edges, levels, form.height, inward)
    edges = outline_edges(shell, chart, every, ways, None, (), mitred.seats)
    cut = cut_shell(shell, edges, ways, ())
    _check_feet(edges, GROOVE if form.kind == "button" else DRAFT)
    floors = []
    for number, level in enumerate(levels):
        assert level.floor is not None
        loops = _loops(edges, mitred.mitres, mitred.zones, number)
        floors.append(FloorFace(level.floor, loops))
    made = with_walls(cut, edges, floors, owner, mitred.mitres)
    if form.kind == "button":
        within = {cut.tops[k] for k, edge in enumerate(edges) if edge.ring >= count}
        made = owned(made, flooded(made, within), owner.detail)
    laid = tuple(
        LaidFloor(chart, piece.floor, face, form.height, zone.offset)
        for piece, face, zone in zip(floors, made.faces[-len(floors) :], region.zones, strict=True)
    )
    return Carved(made, laid)


def _folded(
    shell: Shell, chart: Chart, rings: Sequence[Ring], near: Near
) -> tuple[list[Ring], list[tuple[Passage, ...]]]:
    """Return outlines with a joint at every crease that they cross, and their courses."""
    made, ways = [], []
    for ring in rings:
        creases = [
            passage.leave.t
            for passage in _course(shell, chart, ring, near)
            if passage.leave is not None and is_crease(shell, passage.leave.edge)
        ]
        made.append(folded(ring, creases) if creases else ring)
        ways.append(_course(shell, chart, made[-1], near))
    return made, ways


def _course(shell: Shell, chart: Chart, ring: Ring, near: Near) -> tuple[Passage, ...]:
    start = ring.value(np.zeros(1))[0]
    return course_of(shell, chart, ring, first_face(shell, chart, start, near(start), 1.0), 1.0)


def _zoned(
    shell: Shell,
    chart: Chart,
    rings: Sequence[Ring],
    courses: Sequence[tuple[Passage, ...]],
) -> tuple[CutShell, tuple[OutlineEdge, ...], ZonedRegion]:
    """Return the shell cut along outlines, their edges, and the zones within."""
    edges = outline_edges(shell, chart, rings, courses, None, ())
    cut = cut_shell(shell, edges, courses, ())
    return cut, edges, zones_of(cut.shell, chart, cut.inside)


def _check_feet(edges: Sequence[OutlineEdge], sentence: str) -> None:
    """Raise `UserError` where the foot of a wall runs back."""
    for edge in edges:
        assert edge.bottom is not None
        at = np.linspace(edge.start, edge.end, SAMPLES)
        at[-1] = edge.top.curve.range[1]
        upper, lower = (
            np.diff(one.curve.value(np.clip(at, *one.curve.range)), axis=0)
            for one in (edge.top, edge.bottom)
        )
        if not ((upper * lower).sum(axis=1) > 0.0).all():
            raise UserError(sentence)


def _loops(
    edges: Sequence[OutlineEdge], mitres: Sequence[Mitre], zones: Sequence[int], zone: int
) -> tuple[tuple[tuple[bool, int, bool], ...], ...]:
    """Return the loops of the floor of a zone, the outer one first; see `FloorFace`.

    Raises
    ------
    UserError
        If they bound no area.
    """
    import shapely

    sides: dict[int, tuple[tuple[bool, int, bool], int, Array]] = {}
    for number, own in enumerate(zones):
        foot = edges[number].bottom
        if own == zone and foot is not None:
            row = foot.path.polyline(SAMPLES)
            sides[number] = (True, number, True), following(edges, number), row
    for number, mitre in enumerate(mitres):
        if zone in mitre.crease.zones:
            forward = mitre.crease.zones[0] == zone
            row = (mitre.forward if forward else mitre.back).path.polyline(SAMPLES)
            start, end = mitre.nodes if forward else mitre.nodes[::-1]
            if start in sides:
                raise UserError(NARROW)
            sides[start] = (False, number, forward), end, row if forward else row[::-1]
    found = []
    while sides:
        at = next(iter(sides))
        loop, ring = [], []
        while at in sides:
            side, at, row = sides.pop(at)
            loop.append(side)
            ring.append(row)
        ends = np.array([(row[0], row[-1]) for row in ring])
        gaps = np.abs(ends[:, 1] - np.roll(ends[:, 0], -1, axis=0))
        if (gaps > CLOSED * np.ptp(np.concatenate(ring), axis=0)).any():
            raise UserError(NARROW)
        ring = [row[:-1] for row in ring]
        found.append((tuple(loop), np.concatenate(ring)))
    found.sort(key=lambda one: -signed_area(one[1]))
    areas = [signed_area(ring) for _, ring in found]
    whole = shapely.Polygon(found[0][1], [ring for _, ring in found[1:]])
    if not (areas[0] > 0.0 and all(area < 0.0 for area in areas[1:]) and whole.is_valid):
        raise UserError(NARROW)
    return tuple(loop for loop, _ in found)
