"""A surface laid out in a square: few charts, little stretch, nothing over anything else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from bozzetto.cached_properties import cached_property
from bozzetto.geometry.atlas.chart_cutting import Surface
from bozzetto.geometry.atlas.chart_fitting import Line, Part, cut_to_fit, straight_cuts
from bozzetto.geometry.atlas.chart_flattening import (
    FOLDED,
    Piece,
    areas,
    borders,
    flattened_piece,
    folded,
    ring_area,
    stretch,
)
from bozzetto.geometry.atlas.chart_packing import Outline, packed

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

DIGITS: Final = 10
"""Decimals of places that count, with the root of all area as unit."""

CELLS: Final = 256
"""Cells along the square; charts are one apart."""

FLAT: Final = 0.5
CUT: Final = 0.8
"""Share of the work that is done when all lies flat, and when it is cut to fit, about."""


HALVING: Final = np.array([[1.0, 0.0], [0.0, 1.0], [0.7, 0.7], [0.7, -0.7]])
"""Directions in which a piece is cut in the middle where none of the better cuts parts it."""


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
        """Outline of the chart, as packing needs it."""
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
    plain = [(np.asarray(v, np.float64), np.asarray(f, np.intp)) for v, f in meshes]
    unit = float(np.sqrt(sum(map(_area, *zip(*plain, strict=True)))))
    surfaces = [Surface(_in_unit(vertices, unit), faces) for vertices, faces in plain]
    checkpoint(0.0)
    count, done = sum(len(surface.faces) for surface in surfaces), 0
    charts: list[Chart] = []
    for surface in surfaces:
        for found in _laid_flat(surface):
            if found is not None:
                charts.append(found)
                done += len(found.piece.face)
            checkpoint(FLAT * done / count)
    charts = _cut_to_fit(charts, lambda part: checkpoint(FLAT + part * (CUT - FLAT)))
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
        laid.append(Atlas(corners, number, packing.side * unit))
    return laid


def _area(vertices: Array, faces: Index) -> float:
    """Return the area of a mesh."""
    corner, first, second = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(first - corner, second - corner)
    return float(np.linalg.norm(across, axis=1).sum()) / 2.0


def _in_unit(vertices: Array, unit: float) -> Array:
    """Return places about the middle of a mesh, in a unit, without the rounding of its own unit.

    Of two layouts that are as good one is taken by the last digit, and the same mesh in another
    unit or place is laid out in the same way.
    """
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return np.asarray(np.round((vertices - middle) / unit, DIGITS))


def _cut_to_fit(charts: list[Chart], checkpoint: Callable[[float], None]) -> list[Chart]:
    """Cut charts straight across as far as that fills the square."""
    fitting = cut_to_fit([_outlined(chart) for chart in charts], _cut, checkpoint)
    return [part.content for part in fitting]


def _outlined(chart: Chart) -> Part:
    import shapely

    rings = sorted(chart.outline.rings, key=lambda ring: -abs(ring_area(ring)))
    polygon = shapely.Polygon(rings[0], [ring for ring in rings[1:] if len(ring) > 2])
    if not polygon.is_valid:
        polygon = max(shapely.get_parts(polygon.buffer(0.0)), key=lambda one: one.area)
    return Part(polygon, chart)


def _cut(part: Part, line: Line) -> list[Part]:
    """Cut a chart near a line; all of it where no edges lead across."""
    chart: Chart = part.content
    middles = chart.corners.mean(axis=1)
    ahead = (middles @ line.towards - line.level) / np.sqrt(chart.outline.area)
    faces = chart.surface.across(chart.piece.face, ahead)
    return [part] if len(faces) == 1 else [_outlined(_part_of(chart, face)) for face in faces]


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
    middles = corners.mean(axis=1)
    lines = [*straight_cuts(rings), *(Line(to, float(np.median(middles @ to))) for to in HALVING)]
    for line in lines:
        parts = surface.across(face, (middles @ line.towards - line.level) / np.sqrt(size.sum()))
        if len(parts) > 1:
            return parts
    return [face]


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
