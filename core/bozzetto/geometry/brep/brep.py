"""Faces that share their edges: the exact boundary of a solid, or an open sheet."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array, Index, frozen
from bozzetto.cached_properties import cached_property
from bozzetto.errors import UserError
from bozzetto.geometry.basis import curve_derivative, span_parameters
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Color, Curve
from bozzetto.geometry.kept_answers import kept
from bozzetto.geometry.look import Finish

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement

GAP: Final = 1e-8
"""Largest distance of an edge from the surface of a face, as share of the size of the whole:
a millionth of a millimetre on what is 100 mm wide."""

ROUNDING: Final = 1e-13
"""What is added to the gap, as share of the largest coordinate."""

FURTHEST: Final = 1e75
"""Coordinates beyond which no shape is made, mm: products of four would be no numbers."""

OFF: Final = 1e-9
"""Largest step between trims that follow one another, as share of the range of u or v."""

CHECKS: Final = 4
"""Places on every span of an edge at which it is checked against its faces."""


@dataclass(frozen=True, eq=False)
class ParameterCurve:
    """A B-spline curve in the parameters of a surface, rational where weights are given.

    Parameters
    ----------
    degree : int
    knots : (m + degree + 1,) float64
        Full knot vector, clamped.
    control_points : (m, 2) float64
        u and v.
    weights : (m,) float64, optional
        Positive.

    Raises
    ------
    ValueError
        If the arrays do not belong together, or hold a number that is not finite.
    """

    degree: int
    knots: NDArray[np.float64]
    control_points: NDArray[np.float64]
    weights: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots", frozen(self.knots, np.float64))
        object.__setattr__(self, "control_points", frozen(self.control_points, np.float64, 2))
        if self.weights is not None:
            object.__setattr__(self, "weights", frozen(self.weights, np.float64))
        Curve(self.degree, self.knots, self.in_space, self.weights)

    @classmethod
    def line(cls, start: ArrayLike, end: ArrayLike, over: tuple[float, float]) -> ParameterCurve:
        """Return the straight line between two places (u, v), run evenly over a range."""
        return cls(1, np.repeat(over, 2), np.array((start, end), float))

    @property
    def in_space(self) -> Array:
        """Control points with a third coordinate of 0, (m, 3): as files want them."""
        return np.column_stack((self.control_points, np.zeros(len(self.control_points))))

    def value(self, parameters: ArrayLike) -> Array:
        """Return u and v at parameters within the range, (n, 2)."""
        return curve_derivative(
            self.degree, self.knots, self.control_points, self.weights, parameters, 0
        )

    def polyline(self, steps: int) -> Array:
        """Return places of a polyline near the curve, (n, 2); as `Curve.polyline`."""

        def made() -> Array:
            straight = self.degree == 1
            return self.value(span_parameters(self.degree, self.knots, 1 if straight else steps))

        return kept(self, ("polyline", steps), made)

    @property
    def range(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[0]), float(self.knots[-1])


@dataclass(frozen=True, eq=False)
class Trim:
    """One side of a trimming loop: an edge as one face sees it.

    Parameters
    ----------
    edge : int or None
        Number of the edge in the `Brep`; None at a pole, where the side is one point in space.
    forward : bool
        Whether the loop runs the edge from its start to its end.
    curve : ParameterCurve
        The edge in the parameters of the face's surface. At each parameter of the edge it is the
        place where the edge is, in the sense of the edge, whichever way the loop runs.
    """

    edge: int | None
    forward: bool
    curve: ParameterCurve

    @property
    def ends(self) -> Array:
        """Where the loop enters and leaves the side, u and v, (2, 2)."""
        points = self.curve.control_points[[0, -1]]
        return points if self.forward else points[::-1]

    def turned_over(self) -> Trim:
        """Return the side as the surface with u and v exchanged has it, run backwards."""
        curve = replace(self.curve, control_points=self.curve.control_points[:, ::-1])
        return Trim(self.edge, not self.forward, curve)


Loop = tuple[Trim, ...]


@dataclass(frozen=True, eq=False)
class Face:
    """A surface within trimming loops.

    Parameters
    ----------
    surface : BSplineSurface
        Its normals point outward where there is an outside.
    loops : tuple of tuple of Trim
        The first runs round the face, counter-clockwise in u and v; each other one runs
        clockwise round a hole.
    name : str
        "" for that of the whole.
    color : (r, g, b), optional
        sRGB; None for that of the whole.
    finish : {"matt", "gloss", "rubber", "metal", "glass"}
        Of what it is made, for files that know materials.
    material : str
        Name of the material in such files, one for all that have it; "" for a material that is
        called like the face.

    Raises
    ------
    ValueError
        If a loop does not close or runs the wrong way, or leaves the surface.
    """

    surface: BSplineSurface
    loops: tuple[Loop, ...]
    name: str = ""
    color: Color | None = None
    finish: Finish = "matt"
    material: str = ""

    def __post_init__(self) -> None:
        edged = [any(trim.edge is not None for trim in loop) for loop in self.loops]
        if not edged or not all(edged):
            raise ValueError("a face needs an outer loop, and a loop at least one edge")
        # A face that only gets another name or look has the loops that were checked before.
        kept(self.surface, _as_loops(self.loops), self._check_loops)

    def _check_loops(self) -> None:
        low, high = np.transpose(self.surface.ranges)
        slack = OFF * (high - low)
        for number, loop in enumerate(self.loops):
            ends = np.array([trim.ends for trim in loop])
            if (np.abs(ends[:, 1] - np.roll(ends[:, 0], -1, axis=0)) > slack).any():
                raise ValueError("the sides of a loop must follow one another")
            ring = loop_ring(loop)
            if (ring < low - slack).any() or (ring > high + slack).any():
                raise ValueError("a loop leaves its surface")
            if (signed_area(ring) > 0) != (number == 0):
                raise ValueError("the outer loop runs counter-clockwise, holes run clockwise")

    @property
    def trims(self) -> Iterable[Trim]:
        """All sides of all loops."""
        return chain.from_iterable(self.loops)

    @property
    def is_whole(self) -> bool:
        """Whether the face is all of its surface: one loop round the border."""
        low, high = np.transpose(self.surface.ranges)
        slack = OFF * (high - low)
        if len(self.loops) > 1:
            return False
        for trim in self.loops[0]:
            points = trim.curve.control_points
            on_border = [(np.abs(points - side) <= slack).all(axis=0).any() for side in (low, high)]
            if not any(on_border):
                return False
        return True

    def turned_over(self) -> Face:
        """Return the face with its normals the other way."""
        return replace(self, surface=self.surface.turned_over(), loops=self._turned_loops())

    def placed(self, placement: Placement) -> Face:
        """Return the face moved by a placement; turned over where that mirrors."""
        surface = self.surface.placed(placement)
        if placement.mirrors:
            return replace(self, surface=surface, loops=self._turned_loops())
        kept(surface, _as_loops(self.loops), lambda: None)  # u and v stay what they were
        return replace(self, surface=surface)

    def _turned_loops(self) -> tuple[Loop, ...]:
        return tuple(tuple(t.turned_over() for t in reversed(loop)) for loop in self.loops)


class GapError(ValueError):
    """Faces that miss their edges by more than an exact shape allows."""


@dataclass(frozen=True, eq=False)
class Brep:
    """Faces that share edges: a boundary representation, exact wherever it is handed over.

    Parameters
    ----------
    edges : tuple of Curve
        mm, clamped. An edge belongs to one face (it lies on the *rim*), or to two, which run it
        in opposite senses; a seam is run both ways by one face.
    faces : tuple of Face
        At least one.
    name : str
    color : (r, g, b), optional
        sRGB.

    Raises
    ------
    GapError
        If an edge lies elsewhere than a face that names it (`GAP`).
    ValueError
        If a face names an edge that does not exist, an edge is run twice in the same sense, or by
        nobody.
    """

    edges: tuple[Curve, ...]
    faces: tuple[Face, ...]
    name: str = "brep"
    color: Color | None = None

    def __post_init__(self) -> None:
        if not self.faces:
            raise ValueError("a brep needs a face")
        runs = [(t.edge, t.forward) for f in self.faces for t in f.trims if t.edge is not None]
        if len(set(runs)) < len(runs):
            raise ValueError("an edge is run twice in the same sense")
        if {edge for edge, _ in runs} != set(range(len(self.edges))):
            raise ValueError("faces name edges that do not exist, or leave one out")
        if not all(edge.is_clamped for edge in self.edges):
            raise ValueError("an edge must begin and end in its control points")
        gap = self.largest_gap()
        if not gap <= self.tolerance:
            raise GapError(f"an edge lies {gap:.3g} mm beside a face")

    @classmethod
    def of_surface(
        cls, surface: BSplineSurface, name: str = "brep", color: Color | None = None
    ) -> Brep:
        """Return all of a surface as one face; a side that is one point becomes a pole."""
        (u0, u1), (v0, v1) = surface.ranges
        corners = ((u0, v0), (u1, v0), (u1, v1), (u0, v1), (u0, v0))
        tolerance = gap_tolerance([surface.control_points])
        edges: list[Curve] = []
        loop = []
        for number, (points, weights) in enumerate(_borders(surface)):
            along, forward = number % 2, number < 2
            start, end = corners[number : number + 2][:: 1 if forward else -1]
            path = ParameterCurve.line(start, end, surface.ranges[along])
            pole = bool(np.ptp(points, axis=0).max() <= tolerance)
            loop.append(Trim(None if pole else len(edges), forward, path))
            if not pole:
                degree, knots = surface.degrees[along], surface.knots[along]
                edges.append(Curve(degree, knots, points, weights))
        return cls(tuple(edges), (Face(surface, (tuple(loop),)),), name, color)

    # -- facts -----------------------------------------------------------------------------

    @cached_property
    def tolerance(self) -> float:
        """Largest distance between an edge and its faces that counts as none, mm."""
        return gap_tolerance([face.surface.control_points for face in self.faces])

    def largest_gap(self) -> float:
        """Return the largest distance between edges and their faces where they are checked, mm."""
        return max(self._gap(face) for face in self.faces)

    def _gap(self, face: Face) -> float:
        """Return the largest distance between a face and its edges, mm.

        A face that only gets another name or look lies where it lay: its distance is kept.
        """
        sides = _as_sides(face, self.edges)
        return kept(face.surface, ("gap", *sides), lambda: _gap_of(face.surface, sides))

    @cached_property
    def rim(self) -> Index:
        """Edges of one face, in order of their numbers, (r,)."""
        uses = [trim.edge for face in self.faces for trim in face.trims if trim.edge is not None]
        return np.flatnonzero(np.bincount(uses, minlength=len(self.edges)) == 1)

    @property
    def is_closed(self) -> bool:
        """Whether the faces have no rim: they bound a volume."""
        return not len(self.rim)

    @cached_property
    def vertices(self) -> tuple[Array, Index, dict[tuple[int, int, int], int]]:
        """Places in which edges meet.

        Two sides that follow one another in a loop meet in a vertex; a pole is one.

        Returns
        -------
        places : (n, 3) float
            mm, each an end of an edge.
        ends : (m, 2) int
            Where each edge starts and ends.
        poles : dict
            The vertex of each pole, by the numbers of its face, loop and side.
        """
        count = len(self.edges)
        poles = {
            (f, k, i): 2 * count + number
            for number, (f, k, i) in enumerate(
                (f, k, i)
                for f, face in enumerate(self.faces)
                for k, loop in enumerate(face.loops)
                for i, trim in enumerate(loop)
                if trim.edge is None
            )
        }
        total = 2 * count + len(poles)
        pairs = []
        for f, face in enumerate(self.faces):
            for k, loop in enumerate(face.loops):
                run = []
                for i, trim in enumerate(loop):
                    if trim.edge is None:
                        run.append((poles[f, k, i],) * 2)
                    else:
                        start = 2 * trim.edge
                        run.append((start, start + 1) if trim.forward else (start + 1, start))
                pairs += [(a[1], b[0]) for a, b in zip(run, run[1:] + run[:1], strict=True)]
        least = _least_connected(total, np.array(pairs))
        kept, numbers = np.unique(least, return_inverse=True)
        places = np.empty((len(kept), 3))
        for number, first in enumerate(kept.tolist()):
            places[number] = self.edges[first // 2].control_points[-(first % 2)]
        of_poles = {key: int(numbers[end]) for key, end in poles.items()}
        return places, numbers[: 2 * count].reshape(-1, 2), of_poles

    @cached_property
    def pieces(self) -> tuple[Index, ...]:
        """Faces of each part that hangs together by edges."""
        owners: dict[int, int] = {}
        pairs = [
            (owners.setdefault(trim.edge, number), number)
            for number, face in enumerate(self.faces)
            for trim in face.trims
            if trim.edge is not None
        ]
        least = _least_connected(len(self.faces), np.reshape(pairs, (-1, 2)).astype(np.intp))
        return tuple(np.flatnonzero(least == first) for first in np.unique(least))

    # -- the same otherwise ----------------------------------------------------------------

    def turned_over(self) -> Brep:
        """Return the faces with their normals the other way."""
        return replace(self, faces=tuple(face.turned_over() for face in self.faces))

    def placed(self, placement: Placement) -> Brep:
        """Return the faces moved by a placement; an outside stays the outside."""
        if placement.is_identity:
            return self
        edges = tuple(edge.placed(placement) for edge in self.edges)
        faces = tuple(face.placed(placement) for face in self.faces)
        for old, new in zip(self.faces, faces, strict=True):
            # Distances grow with the scale, and rounding is far below what a gap may be.
            gap = placement.scale * self._gap(old)
            kept(new.surface, ("gap", *_as_sides(new, edges)), partial(float, gap))
        return replace(self, edges=edges, faces=faces)


def _as_loops(loops: tuple[Loop, ...]) -> tuple[object, ...]:
    """Return what tells loops on a surface apart from others, but for the edges that they name."""
    return "loops", *(tuple((trim.curve, trim.forward) for trim in loop) for loop in loops)


def _as_sides(
    face: Face, edges: tuple[Curve, ...]
) -> tuple[tuple[ParameterCurve, Curve | None], ...]:
    """Return the sides of a face with their edges; None at a pole."""
    return tuple(
        (trim.curve, None if trim.edge is None else edges[trim.edge]) for trim in face.trims
    )


def refuse_far(points: Array) -> None:
    """Raise `UserError` where coordinates are too large to reckon with."""
    if np.abs(points).max(initial=0.0) > FURTHEST:
        raise UserError("The shape reaches too far. Make it smaller, or move it nearer.")


def gap_tolerance(points: Iterable[Array]) -> float:
    """Return the distance between edges and faces that counts as none, from control points, mm."""
    rows = np.concatenate([p.reshape(-1, 3) for p in points])
    size = float(np.linalg.norm(np.ptp(rows, axis=0)))
    return GAP * size + ROUNDING * float(np.abs(rows).max())


def _gap_of(surface: BSplineSurface, sides: Iterable[tuple[ParameterCurve, Curve | None]]) -> float:
    """Return the largest distance between sides on a surface and their edges, mm.

    A side without an edge is a pole, and must stay in one place.
    """
    wanted, parameters = [], []
    for curve, edge in sides:
        if edge is None:
            here = curve.value(np.linspace(*curve.range, CHECKS + 1))
            wanted.append(np.repeat(surface.value(*here[:1].T), len(here), axis=0))
        elif not np.allclose(curve.range, edge.range, 1e-12, 1e-12):
            raise ValueError("a trim runs over the range of its edge")
        else:
            at, places = _checked_places(edge)
            here = curve.value(np.clip(at, *curve.range))
            wanted.append(places)
        parameters.append(here)
    found = surface.value(*np.concatenate(parameters).T)
    return float(np.linalg.norm(found - np.concatenate(wanted), axis=1).max())


def _checked_places(edge: Curve) -> tuple[Array, Array]:
    """Return parameters (n,) and places (n, 3) at which an edge is checked against its faces."""

    def checked() -> tuple[Array, Array]:
        at = span_parameters(edge.degree, edge.knots, CHECKS)
        return at, edge.value(at)

    return kept(edge, "checked", checked)


def _borders(surface: BSplineSurface) -> list[tuple[Array, Array | None]]:
    """Return control points and weights along v = low, u = high, v = high, u = low."""
    net, weights = surface.control_points, surface.weights
    rows = [net[:, 0], net[-1], net[:, -1], net[0]]
    if weights is None:
        return [(row, None) for row in rows]
    others = (weights[:, 0], weights[-1], weights[:, -1], weights[0])
    return list(zip(rows, others, strict=True))


def loop_ring(loop: Loop) -> Array:
    """Return places on a loop, once round, for its sense and its extent, (n, 2)."""
    rows = []
    for trim in loop:
        places = trim.curve.polyline(CHECKS)
        rows.append((places if trim.forward else places[::-1])[:-1])
    return np.concatenate(rows)


def signed_area(ring: Array) -> float:
    """Return the area within a polygon (n, 2), positive where it runs counter-clockwise."""
    x, y = (ring - ring[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _least_connected(count: int, pairs: Index) -> Index:
    """Return for each of some things the least one that it is connected with by pairs."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, labels = connected_components(links, directed=False)
    least = np.full(count, count)
    np.minimum.at(least, labels, np.arange(count))
    return np.asarray(least[labels], np.intp)
