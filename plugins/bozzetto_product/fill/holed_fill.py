"""Fills of loops with holes that lie in no plane: in parts between the outline and the holes.

What fills the outline alone guides the rest: cuts lead over it from the outline to the holes, and
along all edges the parts take its normals where the network asks for none. Each part ends in the
very curves, and is smooth to the others over the cuts.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.plugin import cached_property
from bozzetto_product.fill.cut_rings import (
    SAMPLES,
    TRIED,
    Ring,
    Search,
    Spot,
    angle_from,
    factor_of_angles,
    joined_rings,
    place_of,
    spots_of_cut,
    turned_from,
)
from bozzetto_product.fill.edge_pieces import EdgePiece
from bozzetto_product.fill.guide_chart import GuideChart
from bozzetto_product.fill.half_sides import HalfSide, SidePiece
from bozzetto_product.fill.normal_field import (
    NormalField,
    across,
    frame_parameters,
    unit_tangents,
)
from bozzetto_product.fill.normals import LoopNormals
from bozzetto_product.fill.parted_fill import PartedFill
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.network.net import Loop

CUT_PLACES: Final = 9
"""Places of the guide that a cut goes through."""

LEAST_SHARE: Final = 0.2
"""Least share of a hole between the two cuts that lead from it."""

PAIRS: Final = 40
"""Single cuts of which pairs are made."""

TRIED_PAIRS: Final = 12
"""Pairs of cuts of a hole that are tried."""


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
    course = _Course(loop, normals, pieces, splines, GuideChart(guide))
    outer, *holes = course.rings()
    parts = _parts(_Region(loop, course.chart, guide.spacing), outer, holes)
    if parts is None:
        return None
    guided = frozenset(k for k, field in enumerate(normals.fields) if field is None)
    return PartedFill.of(loop, parts, guided=guided, starts=normals.starts)


def _led(chart: GuideChart, one: Spot, other: Spot) -> tuple[Spline, NormalField]:
    """Return the cut over the guide from one spot to another; see `Leading`."""
    from scipy.interpolate import make_interp_spline

    at = np.linspace(0.0, 1.0, CUT_PLACES)
    share = at[:, None]
    places, _ = chart.surface((1.0 - share) * one.flat[0] + share * other.flat[0])
    first, last = place_of(one.piece) - places[0], place_of(other.piece) - places[-1]
    places = places + (1.0 - share) * first + share * last
    fit = make_interp_spline(at, places, 3)
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
        half, start, middle = self._halves[id(side.piece)]
        number = next(k for k, own in enumerate(half.pieces) if own.piece is side.piece)
        low, high = half.breaks[number : number + 2]
        at = np.linspace(*((low, high) if half.onward else (high, low)), SAMPLES + 1)[:-1, None]
        return np.asarray(self.chart.scale * (start + at * (middle - start)))

    @cached_property
    def _halves(self) -> dict[int, tuple[HalfSide, Array, Array]]:
        """The half of a side of the guide, and its ends in the domain, by identities of pieces."""
        domain = self.chart.guide.solution.space.domain
        corners = domain.corners, np.roll(domain.corners, -1, axis=0)
        return {
            id(piece.piece): (half, starts[number], domain.middles[number])
            for number, side in enumerate(self.chart.guide.sides)
            for half, starts in zip(side.halves, corners, strict=True)
            for piece in half.pieces
        }


# -- regions ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Cut:
    """A cut from a spot of an outline to one of a hole."""

    cost: float
    outer: int
    inner: int


@dataclass(frozen=True, eq=False)
class _Region:
    """What all regions of a loop have in common."""

    loop: Loop
    chart: GuideChart
    spacing: float


def _parts(region: _Region, outer: Ring, holes: Sequence[Ring]) -> tuple[PatchFill, ...] | None:
    """Return the fills of a region in parts that do not fold; None where no cuts do it.

    From one of its holes two cuts lead to the outline; what is left are regions with fewer holes.
    """
    if not holes:
        search = Search(region.loop, region.spacing, partial(_led, region.chart))
        return search.parts(outer, len(TRIED))
    for number, hole in _by_nearness(outer, holes):
        others = [other for k, other in enumerate(holes) if k != number]
        for one, two in itertools.islice(_pairs(outer, hole, others), TRIED_PAIRS):
            both = _parted(outer, hole, one, two, region.chart)
            within = [[hole for hole in others if _holds(part, hole)] for part in both]
            if sum(map(len, within)) < len(others):
                continue
            rows = sorted(zip(both, within, strict=True), key=lambda row: len(row[1]))
            first = _parts(region, *rows[0])
            second = None if first is None else _parts(region, *rows[1])
            if first is not None and second is not None:
                return (*first, *second)
    return None


def _flat_of(ring: Ring) -> Array:
    return np.concatenate([spot.flat for spot in ring])


def _by_nearness(outer: Ring, holes: Sequence[Ring]) -> list[tuple[int, Ring]]:
    """Return holes with their numbers, the nearest to the outline first."""
    import shapely

    line = shapely.LinearRing(_flat_of(outer))
    gaps = [line.distance(shapely.LinearRing(_flat_of(hole))) for hole in holes]
    return [(k, holes[k]) for k in np.argsort(gaps, kind="stable").tolist()]


def _holds(ring: Ring, hole: Ring) -> bool:
    import shapely

    return bool(shapely.Polygon(_flat_of(ring)).contains(shapely.Point(hole[0].flat[0])))


def _pairs(outer: Ring, hole: Ring, others: Sequence[Ring]) -> Iterator[tuple[_Cut, _Cut]]:
    """Yield pairs of cuts from a hole to the outline that do not cross, the best first."""
    import shapely

    cuts = _single_cuts(outer, hole, others)
    ends = np.cumsum([spot.piece.piece.length for spot in hole])
    arc = np.append(0.0, ends)[:-1] / ends[-1]
    spots = [np.array([spot.flat[0] for spot in ring]) for ring in (outer, hole)]
    lines = [shapely.LineString((spots[0][cut.outer], spots[1][cut.inner])) for cut in cuts]
    rated = []
    for k, j in itertools.combinations(range(len(cuts)), 2):
        one, two = cuts[k], cuts[j]
        if one.outer == two.outer or one.inner == two.inner:
            continue
        share = abs(float(arc[one.inner] - arc[two.inner]))
        share = min(share, 1.0 - share)
        if share < LEAST_SHARE or lines[k].intersects(lines[j]):
            continue
        rated.append(((one.cost + two.cost) * (0.5 / share), k, j))
    for _, k, j in sorted(rated):
        yield cuts[k], cuts[j]


def _single_cuts(outer: Ring, hole: Ring, others: Sequence[Ring]) -> list[_Cut]:
    """Return cuts from the spots of an outline to those of a hole that nothing is in the way of."""
    import shapely

    rings = [_flat_of(ring) for ring in (outer, hole, *others)]
    region = shapely.Polygon(rings[0], rings[1:])
    if not region.is_valid:
        return []
    room = region.buffer(1e-6 * float(np.sqrt(region.area)))
    shapely.prepare(room)
    starts, outs, insides = zip(*(_ways(ring) for ring in (outer, hole)), strict=True)
    made = []
    for i, j in itertools.product(range(len(outer)), range(len(hole))):
        way = starts[1][j] - starts[0][i]
        one, two = float(angle_from(outs[0][i], way)), float(angle_from(outs[1][j], -way))
        angles = np.array((one, insides[0][i] - one, two, insides[1][j] - two))
        factor = factor_of_angles(angles, (outer[i].kink, hole[j].kink))
        if factor is not None:
            made.append(_Cut(factor * float(np.hypot(*way)), i, j))
    made.sort(key=lambda cut: cut.cost)
    free = (
        cut
        for cut in made
        if room.covers(shapely.LineString((starts[0][cut.outer], starts[1][cut.inner])))
    )
    return list(itertools.islice(free, PAIRS))


def _ways(ring: Ring) -> tuple[Array, Array, Array]:
    """Return the flat spots of a ring, the chords from them, and the angles within it."""
    spots = np.array([spot.flat[0] for spot in ring])
    out = np.array([spot.flat[1] for spot in ring]) - spots
    back = np.array([ring[k - 1].flat[-1] for k in range(len(ring))]) - spots
    return spots, out, angle_from(out, back)


def _parted(outer: Ring, hole: Ring, one: _Cut, two: _Cut, chart: GuideChart) -> tuple[Ring, Ring]:
    """Return both parts of a region between two cuts from a hole."""
    if one.outer > two.outer:
        one, two = two, one
    (there, back), (forth, home) = (
        spots_of_cut(*ends, *_led(chart, *ends))
        for ends in ((outer[cut.outer], hole[cut.inner]) for cut in (one, two))
    )
    between = outer[one.outer : two.outer]
    rest = (*outer[two.outer :], *outer[: one.outer])
    return (
        joined_rings(between, forth, _run(hole, two.inner, one.inner), back),
        joined_rings(rest, there, _run(hole, one.inner, two.inner), home),
    )


def _run(ring: Ring, start: int, end: int) -> Ring:
    """Return the spots of a ring from one to before another."""
    return ring[start:end] if start < end else (*ring[start:], *ring[:end])
