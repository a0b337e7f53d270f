"""Fills of loops with holes that lie in no plane: in parts between the outline and the holes.

What fills the outline alone guides the rest: cuts lead over it from the outline to the holes, and
along all edges the parts take its normals where the network asks for none. Each part ends in the
very curves, and is smooth to the others over the cuts.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.plugin import cached_property
from bozzetto_product.fill.cut_rings import (
    CUT_DEGREES,
    SAMPLES,
    TRIED,
    Ring,
    Search,
    Spot,
    place_of,
    turned_from,
)
from bozzetto_product.fill.edge_pieces import EdgePiece
from bozzetto_product.fill.feet import feet_on
from bozzetto_product.fill.guide_chart import GuideChart
from bozzetto_product.fill.half_sides import HalfSide, SidePiece
from bozzetto_product.fill.moved_patches import Offsets, moved_patches
from bozzetto_product.fill.normal_field import (
    NormalField,
    across,
    frame_parameters,
    unit_tangents,
)
from bozzetto_product.fill.normals import LoopNormals
from bozzetto_product.fill.parted_fill import PartedFill
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.fill.region_cuts import parted_region
from bozzetto_product.network.net import Loop

CUT_PLACES: Final = 9
"""Places of the guide that a cut goes through."""

ROUNDS: Final = 3
"""Most times that the guide is bent to the holes."""

MET: Final = 1e-6
"""Distance of the guide from the holes, as share of its size, at which it goes through them."""

WEIGHT: Final = 100.0
"""How many times as firmly as a stroke holes hold the guide: they are exact."""

LOOKS: Final = 5
"""Places along each direction of a patch at which its distance from the guide is measured."""

OFF_GUIDE: Final = 2e-4
"""Distance of a part from the guide, as share of the size of the loop, that needs no other cut."""

OFF_HOLES: Final = 1.5
"""The same as multiple of the distance of the holes from the guide, which comes on top of it; so do
that many of the angles by which they lean out of it, where parts turn from cuts."""

MOST_DEGREES: Final = 5.0
"""Largest angle, degrees, by which parts turn from cuts, however far holes lean."""


def holed_fill(
    loop: Loop,
    normals: LoopNormals,
    pieces: Sequence[Sequence[EdgePiece]],
    splines: Sequence[Spline],
    guide: PatchFill,
) -> PartedFill | None:
    """Fill a loop with holes in parts that do not fold; None where no cuts were found for it.

    Parameters
    ----------
    loop : Loop
        The outline, then the holes.
    normals : LoopNormals
        Along its half edges.
    pieces : sequence of sequence of EdgePiece
        Those of each half edge, in the sense of the edge.
    splines : sequence of Spline
        Those of each half edge, opened.
    guide : PatchFill
        Of the outline alone.
    """
    border = np.concatenate(
        [
            piece.curve.value(np.linspace(*piece.curve.range, SAMPLES + 1)[:-1])
            for own in pieces[normals.starts[1] :]
            for piece in own
        ]
    )
    guide = _through(guide, border)
    course = _Course(loop, normals, pieces, splines, GuideChart(guide))
    outer, *holes = course.rings()
    leading, near = (
        partial(_led, course.chart),
        partial(_is_near, course.chart, _off(course, holes)),
    )
    most = min(CUT_DEGREES + OFF_HOLES * course.lean(normals.starts[1]), MOST_DEGREES)
    parts: list[PatchFill] = []
    for ring in parted_region(outer, holes, leading):
        found = Search(loop, guide.spacing, leading, near, most).parts(ring, len(TRIED))
        if found is None:
            return None
        parts += found
    if not parts:
        return None
    guided = frozenset(k for k, field in enumerate(normals.fields) if field is None)
    return PartedFill.of(loop, tuple(parts), guided=guided, starts=normals.starts)


def _through(guide: PatchFill, points: Array) -> PatchFill:
    """Return the guide bent so that it goes near points; as it is where it would fold."""
    made = guide
    for _ in range(ROUNDS):
        feet = feet_on(made.patches, points)
        normals = np.empty_like(points)
        for number in np.unique(feet.patches).tolist():
            own = feet.patches == number
            normals[own] = made.patches[number].normals(*feet.parameters[own].T)
        heights = ((feet.places - points) * normals).sum(axis=1)
        if float(np.abs(heights).max()) <= MET * guide.size:
            break
        weights = np.full(len(points), WEIGHT)
        offsets = Offsets(feet.patches, feet.parameters, normals, heights, weights)
        made = moved_patches(guide, made, offsets)
    return guide if made.folded else made


def _led(chart: GuideChart, one: Spot, other: Spot) -> tuple[Spline, NormalField]:
    """Return the cut over the guide from one spot to another; see `Leading`."""
    from scipy.interpolate import make_interp_spline

    at = np.linspace(0.0, 1.0, CUT_PLACES)
    share = at[:, None]
    places, _ = chart.surface((1.0 - share) * one.flat[0] + share * other.flat[0])
    first, last = place_of(one.piece) - places[0], place_of(other.piece) - places[-1]
    fit = make_interp_spline(at, places + (1.0 - share) * first + share * last, 3)
    spline = Spline(fit.t, fit.c)
    at = frame_parameters(spline)
    share = at[:, None]
    _, normals = chart.surface((1.0 - share) * one.flat[0] + share * other.flat[0])
    return spline, NormalField(spline, at, across(normals, unit_tangents(spline, at)))


@dataclass(frozen=True, eq=False)
class _Course:
    """A loop with holes as rings of spots over a chart; see `holed_fill`."""

    loop: Loop
    normals: LoopNormals
    pieces: Sequence[Sequence[EdgePiece]]
    splines: Sequence[Spline]
    chart: GuideChart

    def rings(self) -> list[Ring]:
        """Return the outline, and the holes, which run the other way."""
        starts = (*self.normals.starts, len(self.loop))
        return [self._ring(a, b) for a, b in itertools.pairwise(starts)]

    def _ring(self, first: int, last: int) -> Ring:
        made: list[Spot] = []
        for number in range(first, last):
            forward, corner = self.loop[number][1], self.normals.corners[number]
            field = self.normals.fields[number] or self._guided(number, is_hole=first > 0)
            for place, piece in enumerate(self.pieces[number][:: 1 if forward else -1]):
                side = SidePiece(number, piece, forward, field)
                at = np.linspace(*piece.curve.range, SAMPLES + 1)[:: 1 if forward else -1][:-1]
                flat = self.chart.feet(piece.curve.value(at))[0] if first else self._border(side)
                corner_here = not first and not place
                normal = corner.normal if corner_here else field.value(at[:1])[0]
                made.append(Spot(side, corner.turn if corner_here else 0.0, normal, flat))
        if not first:
            return tuple(made)
        return tuple(
            turned_from(spot, before)
            for before, spot in zip((made[-1], *made[:-1]), made, strict=True)
        )

    def lean(self, first: int) -> float:
        """Return the largest angle of the half edges from a number on to the guide, degrees."""
        most = 0.0
        for number in range(first, len(self.loop)):
            at = frame_parameters(self.splines[number])
            normals = self.chart.feet(self.splines[number].value(at))[1]
            along = (normals * unit_tangents(self.splines[number], at)).sum(axis=1)
            most = max(most, float(np.abs(along).max()))
        return float(np.degrees(np.arcsin(min(most, 1.0))))

    def _guided(self, number: int, *, is_hole: bool) -> NormalField:
        """Return the normals of the guide along a half edge."""
        spline = self.splines[number]
        if is_hole:
            at = frame_parameters(spline)
            normals = self.chart.feet(spline.value(at))[1]
        else:
            rows = [np.linspace(*piece.curve.range, SAMPLES + 1) for piece in self.pieces[number]]
            at, first = np.unique(np.concatenate(rows), return_index=True)
            normals = self.chart.guide.normals_along(number, SAMPLES + 1)[first]
        return NormalField(spline, at, across(normals, unit_tangents(spline, at)))

    def _border(self, side: SidePiece) -> Array:
        """Return the places of a piece of the outline in the chart, (m, 2)."""
        half, start, middle = self._halves[_name_of(side)]
        number = [_name_of(own) for own in half.pieces].index(_name_of(side))
        low, high = half.breaks[number : number + 2]
        at = np.linspace(*((low, high) if half.onward else (high, low)), SAMPLES + 1)[:-1, None]
        return np.asarray(self.chart.scale * (start + at * (middle - start)))

    @cached_property
    def _halves(self) -> dict[tuple[int, float], tuple[HalfSide, Array, Array]]:
        """The half of a side of the guide, and its ends in the domain, by the names of pieces."""
        domain = self.chart.guide.solution.space.domain
        corners = domain.corners, np.roll(domain.corners, -1, axis=0)
        return {
            _name_of(piece): (half, starts[number], domain.middles[number])
            for number, side in enumerate(self.chart.guide.sides)
            for half, starts in zip(side.halves, corners, strict=True)
            for piece in half.pieces
        }


def _name_of(piece: SidePiece) -> tuple[int, float]:
    """Return what tells a piece from all others of a loop."""
    return piece.half_edge, piece.piece.curve.range[0]


def _off(course: _Course, holes: Sequence[Ring]) -> float:
    """Return how far holes are from the guide, mm."""
    places = np.stack([place_of(spot.piece) for hole in holes for spot in hole])
    return course.chart.farthest(places)


def _is_near(chart: GuideChart, off: float, fill: PatchFill) -> bool:
    """Whether a part is no farther from the guide than holes and the size of the loop explain."""
    at = np.linspace(0.0, 1.0, LOOKS)
    u, v = (grid.ravel() for grid in np.meshgrid(at, at))
    places = np.concatenate([patch.value(u, v) for patch in fill.patches])
    return chart.farthest(places) <= OFF_HOLES * off + OFF_GUIDE * chart.guide.size
