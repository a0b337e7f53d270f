"""A surface laid out in a square: few charts, little stretch, nothing over anything else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from bozzetto.cached_properties import cached_property
from bozzetto.geometry.atlas.chart_cutting import Surface
from bozzetto.geometry.atlas.chart_flattening import (
    FOLDED,
    Piece,
    areas,
    borders,
    flattened_piece,
    folded,
    stretch,
)
from bozzetto.geometry.atlas.chart_packing import Outline, box_sizes, packed, side_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from bozzetto.arrays import Array, Index

MOST_STRETCH: Final = 2.0
"""By how much a chart is drawn out or pressed together at most, in all but a hundredth of it."""

AWAY: Final = -0.35
"""Component of a face's normal along its chart's below which it looks away."""

FEW: Final = 0.02
"""Share of a chart that may look away when it is laid flat."""

BENT: Final = 0.9
"""Length of a piece's mean normal below which it is cut where it bends, if it covers itself."""

CELLS: Final = 256
"""Cells along the square; charts are one apart."""

FEW_CELLS: Final = 128
"""The same to learn whether a cut helps: charts that touch none in common are as far apart."""

FULL: Final = 0.8
"""Share of the square from which no more charts are cut."""

CUTS: Final = 24
"""How many more cuts are tried."""

PATIENCE: Final = 5
"""After how many that gain nothing no more are."""

GAIN: Final = 0.01
"""By how much more of the square each further chart has to fill."""

LEAST_FREE: Final = 0.005
"""Area beside a chart in its box, as a share of the surface, from which a cut is tried."""

LONG: Final = 0.7
"""Share of the square's side from which a chart is tried to be cut because it is long."""


FLAT: Final = 0.5
CUT: Final = 0.8
"""Share of the work that is done when all lies flat, and when it is cut to fit, about."""


def _nobody(fraction: float) -> None:
    """Ignore progress that no one watches."""


class Atlas(NamedTuple):
    """Where all faces are in the square.

    Attributes
    ----------
    corners : (f, 3, 2) float array
        To the right and down from the top left, 0 to 1; seen from outside, not mirrored.
    chart : (f,) int array
        The number of the chart of each face.
    side : float
        Of the square, in the unit of the mesh: what a chart is as large as on the surface.
    """

    corners: Array
    chart: Index
    side: float


@dataclass(frozen=True, eq=False)
class Chart:
    """A piece that lies flat.

    Attributes
    ----------
    surface : Surface
        What it is a piece of.
    piece : Piece
    places : (v, 2) float array
        Of its points, in the size that it has on the surface.
    """

    surface: Surface
    piece: Piece
    places: Array

    @cached_property
    def corners(self) -> Array:
        """Places of the corners of its triangles, (f, 3, 2)."""
        return self.places[self.piece.triangles]

    @cached_property
    def outline(self) -> Outline:
        """What packing needs."""
        rings = [self.places[ring] for ring in borders(self.piece.triangles)]
        return Outline(rings, float(areas(self.corners).sum()))


def unwrapped(vertices: Array, faces: Index) -> Atlas:
    """Cut a surface into charts, lay them flat, and pack them into a square.

    Parameters
    ----------
    vertices : (v, 3) float array
        Corners of the mesh.
    faces : (f, 3) int array
        Oriented; triangles without an area are laid where they belong.
    """
    return unwrapped_together([(vertices, faces)])[0]


def unwrapped_together(
    meshes: Sequence[tuple[Array, Index]], checkpoint: Callable[[float], None] = _nobody
) -> list[Atlas]:
    """Cut surfaces into charts, lay them flat, and pack all of them into one square.

    Parameters
    ----------
    meshes : sequence of ((v, 3) float array, (f, 3) int array)
        As `unwrapped` takes them, in one unit; one of them has an area.
    checkpoint : callable
        Called with the fraction done (0 … 1) between steps and in loops; may raise to stop it.

    Returns
    -------
    list of Atlas
        Of each mesh its faces; the numbers of the charts go on from one to the next.
    """
    surfaces = [
        Surface(np.asarray(vertices, np.float64), np.asarray(faces, np.intp))
        for vertices, faces in meshes
    ]
    checkpoint(0.0)
    count, done = sum(len(surface.faces) for surface in surfaces), 0
    charts: list[Chart] = []
    for surface in surfaces:
        for found in _laid_flat(surface):
            if found is not None:
                charts.append(found)
                done += len(found.piece.face)
            checkpoint(FLAT * done / count)
    area = sum(float(one.areas.sum()) for one in surfaces)
    charts = _cut_to_fit(area, charts, lambda part: checkpoint(FLAT + part * (CUT - FLAT)))
    packing = packed(
        [chart.outline for chart in charts], CELLS, lambda part: checkpoint(CUT + part * (1 - CUT))
    )
    laid = []
    for surface in surfaces:
        corners = np.zeros((len(surface.faces), 3, 2))
        number = np.zeros(len(surface.faces), np.intp)
        for k, chart in enumerate(charts):
            if chart.surface is surface:
                corners[chart.piece.face] = chart.corners @ packing.turn[k] + packing.offset[k]
                number[chart.piece.face] = k
        corners = np.clip(corners / packing.side, 0.0, 1.0)  # but for its rounding it is
        corners[..., 1] = 1.0 - corners[..., 1]
        laid.append(Atlas(corners, number, packing.side))
    return laid


def _cut_to_fit(
    area: float, charts: list[Chart], checkpoint: Callable[[float], None]
) -> list[Chart]:
    """Cut charts across that are long or leave much of their boxes free, as far as that pays."""

    def full(charts: list[Chart]) -> float:
        return area / side_of([chart.outline for chart in charts], FEW_CELLS) ** 2

    share = full(charts)
    best, most, idle = charts, share, 0
    count = len(charts)
    whole: set[int] = set()
    for number in range(CUTS):
        checkpoint(number / CUTS)
        if share >= FULL or idle == PATIENCE:
            break
        needs = [0.0 if id(chart) in whole else _need(chart, area, share) for chart in charts]
        # Of equal ones the first, however they are rounded.
        worst = int(np.argmax(np.round(needs, 5)))
        if needs[worst] < 1.0:
            break
        chart = charts[worst]
        parts = chart.surface.across(chart.piece.face, chart.corners, chart.outline.rings)
        if len(parts) == 1:
            whole.add(id(chart))
            continue
        charts = [*charts[:worst], *(_part_of(chart, part) for part in parts), *charts[worst + 1 :]]
        share = full(charts)
        idle += 1
        worth = share - GAIN * (len(charts) - count)
        if worth > most + 1e-6:
            best, most, idle = charts, worth, 0
    return best


def _need(chart: Chart, area: float, share: float) -> float:
    """Return how much a cut of a chart is needed; below one, not at all."""
    if len(chart.piece.face) == 1:
        return 0.0
    width, height = box_sizes(
        np.concatenate(list(chart.outline.rings)), np.linspace(0.0, 0.5 * np.pi, 64, endpoint=False)
    )
    best = int((width * height).argmin())
    free = float(width[best] * height[best]) - chart.outline.area
    long = float(max(width[best], height[best])) / float(np.sqrt(area / share))
    return max(free / (LEAST_FREE * area), long / LONG)


def _part_of(chart: Chart, face: Index) -> Chart:
    """Return some of the faces of a chart, as they lie in it."""
    piece = chart.surface.piece(face)
    place = np.zeros(len(chart.surface.faces), np.intp)
    place[chart.piece.face] = np.arange(len(chart.piece.face))
    places = np.zeros((len(piece.points), 2))
    places[piece.triangles] = chart.corners[place[face]]
    return Chart(chart.surface, piece, places)


def _laid_flat(surface: Surface) -> Iterator[Chart | None]:
    """Cut a surface until every piece lies flat as it should; None after each cut."""
    waiting = surface.regions()[::-1] if len(surface.faces) else []
    while waiting:
        face = waiting.pop()
        found = _tried(surface, face)
        if isinstance(found, Chart):
            yield found
        else:
            waiting += _in_two(surface, face, found)[::-1]
            yield None


def _tried(surface: Surface, face: Index) -> Chart | list[Index]:
    """Lay faces flat, or return the parts into which they have to be cut first."""
    piece = surface.piece(face)
    if len(face) == 1:
        return _chart(surface, piece, flattened_piece(piece)[0])
    normals, size = surface.normals[face], surface.areas[face]
    mean = (size[:, None] * normals).sum(axis=0)
    away = normals @ mean < AWAY * float(np.linalg.norm(mean))
    if size[away].sum() > FEW * size.sum():
        return surface.by_sides(face)
    places, once = flattened_piece(piece)
    corners = places[piece.triangles]
    large, little = stretch(piece, places)
    worst = np.maximum(large, 1.0 / np.maximum(little, 1e-9))
    drawn_out = size[worst > MOST_STRETCH].sum() > 0.01 * size.sum()
    if drawn_out or folded(areas(corners)) > FOLDED:
        return surface.by_sides(face)
    if once:
        return _chart(surface, piece, places)
    if float(np.linalg.norm(mean)) < BENT * float(size.sum()):
        return surface.by_sides(face)
    rings = [places[ring] for ring in borders(piece.triangles)]
    return surface.across(face, corners, rings)


def _in_two(surface: Surface, face: Index, parts: list[Index]) -> list[Index]:
    """Return the parts, or both halves of the faces where no cut was found."""
    if len(parts) > 1:
        return parts
    return surface.parts(face, (np.arange(len(face)) < len(face) // 2).astype(np.intp))


def _chart(surface: Surface, piece: Piece, places: Array) -> Chart:
    """Return a chart as large as its piece is."""
    corners = piece.points[piece.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    wanted = 0.5 * float(np.linalg.norm(cross, axis=1).sum())
    there = float(areas(places[piece.triangles]).sum())
    return Chart(surface, piece, places * np.sqrt(wanted / there) if there > 0.0 else places)
