"""Known places in space for the pen to start from or end on: ends, corners, curves, edges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.plugin import Context, cached_property, remembered
from bozzetto.view import Camera, triple
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.box_geometry import box_corners, box_edges, plane_section
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane, Point
from bozzetto_symmetry.solve.picking import solved_curves

Kind = Literal["end", "crossing", "corner", "curve", "line", "edge"]
"""The end of a curve or line, where a curve crosses the centre plane, a corner of the box or of
the centre plane in it; a curve, a line, an edge of the box or of that plane."""

PIECES_PER_SPAN: Final = 16
"""Segments that stand for one span of a spline: a span that turns by a right angle is left
by a thousandth of its length."""

NEAREST_DEPTH: Final = 1e-6
"""Share of the camera's distance in front of the eye at which segments are cut off."""

SAME_CURVE: Final = 1e-6
"""Distance of control points, in diagonals of the box, that a change of frame rounds by."""

SAME_PIXEL: Final = 0.5
"""Difference of distances, px, below which the place nearer to the eye is meant."""


@dataclass(frozen=True, eq=False)
class Targets:
    """Places and segments in the model's frame, mm.

    Parameters
    ----------
    points : (n, 3) float
    point_kinds : tuple of Kind
    tangents : (n, 3) float
        Unit direction in which a curve or line goes on through each of the points, in either
        sense; 0 where there is none.
    begins, ends : (m, 3) float
        Both ends of every segment.
    segment_kinds : tuple of Kind
    """

    points: Array
    point_kinds: tuple[Kind, ...]
    tangents: Array
    begins: Array
    ends: Array
    segment_kinds: tuple[Kind, ...]

    @classmethod
    def of(
        cls, points: Sequence[tuple[Array, Kind, Array]], paths: Sequence[tuple[Array, Kind]]
    ) -> Targets:
        """Return points (n, 3) with their kind and directions, and the segments of paths (m, 3)."""
        none = np.zeros((0, 3))
        return cls(
            np.concatenate([none, *(places for places, _, _ in points)]),
            tuple(kind for places, kind, _ in points for _ in places),
            np.concatenate([none, *(ways for _, _, ways in points)]),
            np.concatenate([none, *(path[:-1] for path, _ in paths)]),
            np.concatenate([none, *(path[1:] for path, _ in paths)]),
            tuple(kind for path, kind in paths for _ in path[1:]),
        )

    @cached_property
    def corners(self) -> Array:
        """Lowest and highest corner of the box around its segments, (2, 3)."""
        return np.stack((self.begins.min(axis=0), self.begins.max(axis=0)))

    def without_points(self, *kinds: Kind) -> Targets:
        """Return all but the points of some kinds."""
        kept = [k for k, kind in enumerate(self.point_kinds) if kind not in kinds]
        return replace(
            self, points=self.points[kept], tangents=self.tangents[kept],
            point_kinds=tuple(self.point_kinds[k] for k in kept),
        )  # fmt: skip

    @classmethod
    def joined(cls, some: Iterable[Targets]) -> Targets:
        """Return the targets of several together."""
        every = [cls.of((), ()), *some]
        return cls(
            np.concatenate([each.points for each in every]),
            tuple(chain.from_iterable(each.point_kinds for each in every)),
            np.concatenate([each.tangents for each in every]),
            np.concatenate([each.begins for each in every]),
            np.concatenate([each.ends for each in every]),
            tuple(chain.from_iterable(each.segment_kinds for each in every)),
        )


@dataclass(frozen=True)
class Place:
    """A known place near the pen.

    Parameters
    ----------
    point : (x, y, z)
        In the model's frame, mm.
    kind : Kind
    pixels : float
        Its distance from the pen on the sheet.
    """

    point: Point
    kind: Kind
    pixels: float


def targets(
    state: SymmetryState, curves: Iterable[SpaceCurve], context: Context, *, box: bool = True
) -> Targets:
    """Return everything that a stroke can start from or end on.

    Parameters
    ----------
    state : SymmetryState
        Its box, the centre plane's section with it, and the construction lines shown.
    curves : iterable of SpaceCurve
        In the centre plane's frame; both of a pair count.
    context : Context
        The curves of other models.
    box : bool
        Whether the box counts.
    """
    points: list[tuple[Array, Kind, Array]] = []
    paths: list[tuple[Array, Kind]] = []
    if box:
        section = plane_section(state)
        corners = np.concatenate((box_corners(state), section))
        points.append((corners, "corner", np.zeros_like(corners)))
        paths += [(edge, "edge") for edge in box_edges(state)]
        if len(section):
            paths.append((np.vstack((section, section[:1])), "edge"))
    lines: list[tuple[Array, Array, Kind]] = []
    for line in state.shown_lines:
        path = np.array([line.begin, line.end], float)
        lines.append((path, path, "line"))
    for curve in context.curves:
        lines.append((polyline(curve), np.asarray(curve.control_points, float), "curve"))
    for path, controls, kind in lines:
        paths.append((path, kind))
        if (path[0] != path[-1]).any():
            points.append((path[[0, -1]], "end", _end_ways(controls)))
    solved = [curve_targets(curve, state.plane) for curve in curves]
    return Targets.joined((*solved, Targets.of(points, paths)))


def without_own(context: Context, state: SymmetryState) -> Context:
    """Return a context that knows the curves of other models only.

    In the window it has those of all, and ends would be held by what they were before.

    Parameters
    ----------
    context : Context
        In the frame of the model.
    state : SymmetryState
        As it was solved last.
    """
    own: dict[int, list[Array]] = {}
    for _, solved in solved_curves(state):
        for made in solved.to_curves():
            controls = state.plane.placement.points(made.control_points)
            own.setdefault(len(controls), []).append(controls)

    def is_own(curve: ShapeCurve) -> bool:
        controls = np.asarray(curve.control_points)
        return any(
            float(np.abs(each - controls).max()) < SAME_CURVE * state.diagonal
            for each in own.get(len(controls), ())
        )

    return replace(context, curves=tuple(c for c in context.curves if not is_own(c)))


@remembered(limit=512)
def curve_targets(curve: SpaceCurve, plane: CentrePlane) -> Targets:
    """Return the ends of a curve, where it crosses the centre plane, and both of its sides."""
    points: list[tuple[Array, Kind, Array]] = []
    paths: list[tuple[Array, Kind]] = []
    to_model = plane.placement
    for spline in curve.curves():
        spans = len(np.unique(spline.knots))
        path = to_model.points(spline.sampled(spans * PIECES_PER_SPAN + 1))
        paths.append((path, "curve"))
        if not curve.closed:
            points.append((path[[0, -1]], "end", _end_ways(to_model.points(spline.control_points))))
    if curve.reading == "self" and not curve.closed:
        middle = to_model.points(curve.spline.value([0.5 * sum(curve.spline.range)]))
        points.append((middle, "crossing", np.array([plane.normal])))
    return Targets.of(points, paths)


def _end_ways(controls: Array) -> Array:
    """Return the unit directions in which a line leaves its ends, by its control points, (2, 3)."""
    ways = np.stack((controls[0] - controls[1], controls[-1] - controls[-2]))
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    return np.asarray(np.divide(ways, length, out=np.zeros_like(ways), where=length > 0))


def polyline(curve: ShapeCurve) -> Array:
    """Return places along a curve of another model, both ends included, (n, 3) mm."""
    from scipy.interpolate import BSpline

    degree, knots = curve.degree, curve.knots
    breaks = np.unique(knots[degree : len(knots) - degree])
    pieces = 1 if degree == 1 else PIECES_PER_SPAN
    share = np.arange(pieces) / pieces
    at = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * share).ravel(), breaks[-1])
    weights = np.ones(len(curve.control_points)) if curve.weights is None else curve.weights
    homogeneous = np.column_stack((curve.control_points * weights[:, None], weights))
    made = BSpline(knots, homogeneous, degree)(at)
    return np.asarray(made[:, :3] / made[:, 3:])


def nearest_target(
    pixel: ArrayLike, camera: Camera, known: Targets, tolerance: float
) -> Place | None:
    """Return the known place that is meant by a place on the sheet.

    Parameters
    ----------
    pixel : (2,) array_like
        px.
    camera : Camera
        In the model's frame.
    known : Targets
        The places and segments to choose from.
    tolerance : float
        How far away it may be, px.

    Returns
    -------
    Place or None
        A point within the tolerance wins over all segments; among equals the nearest on the
        sheet, and of those in one place on the sheet the one nearest to the eye.
    """
    pen = np.asarray(pixel, float)
    seen, depth = camera.project(known.points)
    gaps = np.linalg.norm(seen - pen, axis=1)
    chosen = _chosen(gaps, depth, tolerance)
    if chosen is not None:
        return _place(known.points[chosen], known.point_kinds[chosen], gaps[chosen])
    begins, ends, kept = _in_front(known, camera)
    (first, near), (last, far) = camera.project(begins), camera.project(ends)
    step = last - first
    square = np.einsum("ij,ij->i", step, step)
    share = np.einsum("ij,ij->i", pen - first, step)
    share = np.divide(share, square, out=np.zeros_like(share), where=square > 0)
    share = np.clip(share, 0.0, 1.0)
    gaps = np.linalg.norm(first + share[:, None] * step - pen, axis=1)
    if camera.kind == "perspective":
        share = share * near / (far + share * (near - far))
    places = begins + share[:, None] * (ends - begins)
    chosen = _chosen(gaps, near + share * (far - near), tolerance)
    if chosen is None:
        return None
    return _place(places[chosen], known.segment_kinds[kept[chosen]], gaps[chosen])


def _in_front(known: Targets, camera: Camera) -> tuple[Array, Array, Sequence[int]]:
    """Return the segments' parts in front of a perspective eye, and the segments' numbers."""
    count = len(known.begins)
    if camera.kind == "orthographic":
        return known.begins, known.ends, range(count)
    limit = NEAREST_DEPTH * camera.distance
    near = camera.view_space(known.begins)[:, 2] - limit
    far = camera.view_space(known.ends)[:, 2] - limit
    kept = np.flatnonzero((near > 0) | (far > 0))
    begins, ends = known.begins[kept], known.ends[kept]
    near, far = near[kept], far[kept]
    cut = np.zeros(len(kept))
    np.divide(near, near - far, out=cut, where=near * far < 0)
    met = begins + cut[:, None] * (ends - begins)
    begins = np.where((near <= 0)[:, None], met, begins)
    return begins, np.where((far <= 0)[:, None], met, ends), kept.tolist()


def _chosen(gaps: Array, depth: Array, tolerance: float) -> int | None:
    within = np.flatnonzero(gaps <= tolerance)  # NaN, behind the eye, is never within
    if not len(within):
        return None
    alike = within[gaps[within] <= gaps[within].min() + SAME_PIXEL]
    return int(alike[np.argmin(depth[alike])])


def _place(point: Array, kind: Kind, pixels: float) -> Place:
    return Place(triple(point), kind, float(pixels))
