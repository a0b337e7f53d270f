"""Holes, pockets and bosses: parts of a drawing that no line joins to the rest.

Parallel lines and planar faces tell the depth of such a part up to a constant. It is found where a
ring of the part lies in a face of the body that surrounds it on the sheet. Two rings in two faces
make a through-hole, one a pocket or a boss, which differ in whether the part is inside the body.
The other way round, a part lies on a body where one of its faces surrounds a ring of the body, as
the second plate of a spool does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.affine_depth import face_rows
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.lifting import Lifting
from bozzetto_polyhedron.reconstruction.parallel_classes import HAND, ParallelClasses
from bozzetto_polyhedron.reconstruction.planar_faces import inside
from bozzetto_polyhedron.reconstruction.regularity import area_vector
from bozzetto_polyhedron.reconstruction.visibility import agreement, is_marked

EDGE_ON: Final = 0.08
"""Least share of a normal along the line of sight: a face seen edge-on surrounds nothing."""

MARKS: Final = 1.0
"""Weight of the log-likelihood of marks beside `Attached.rough`."""

MOST: Final = 6
"""Ways that are kept for each part."""

GAP: Final = 0.7
"""Standard deviation of how far a ring that lies in a face is drawn from it, in units of the noise
of a corner, in 120 drawings of holes."""

FREEDOM: Final = 4.0
"""Degrees of freedom of Student's distribution of these gaps: the noise is itself estimated from
few corners, and the depth of a ring follows from lines whose errors it has in common, so that of
holes in strokes one in twenty is drawn off by three standard deviations."""

APART: Final = 0.8
"""Gap, in units of the noise, from which on it is also asked whether a ring lies beside a face."""

BESIDE: Final = 3.0
"""What a ring costs that lies beside a face and not in it, nats: floors are of any thickness, of
which twenty times the noise is usual (log 20). So it costs however thick the floor is."""

WORST: Final = 12.0
"""What a gap costs at most, nats."""


CLEARLY: Final = 4.5
"""Standard deviations by which a part's lines run otherwise than all of a body at least, for their
slope to be free: classes are parted from 1.6 on."""


class Seat(NamedTuple):
    """Numbers of a face of a body and one of a part that lie in one plane.

    On the sheet the body's face surrounds the part's, or `is_outward` and the other way round.
    """

    face: int
    ring: int
    is_outward: bool


@dataclass(frozen=True, eq=False)
class Seated:
    """A part in faces of a body.

    Parameters
    ----------
    part : Lifting
    corners : frozenset of int
        Those of its rings that lie in faces of the body.
    faces : tuple of Rings
        The body without the part.
    through : bool
        Whether it lies in two faces.
    """

    part: Lifting
    corners: frozenset[int]
    faces: tuple[Rings, ...]
    through: bool

    def measures(self, drawing: Drawing, depths: Array) -> Array:
        """Return the measures of `Attached` for one part, misfit left out, at given depths."""
        within = _share_inside(drawing, self, depths)
        return np.array((self.through * within, 1.0 - within, 0.0, 0.0, 0.0))


@dataclass(frozen=True, eq=False)
class Attached:
    """A body with parts in it.

    Parameters
    ----------
    depths : (n,) float64
        Away from the eye, diagonals.
    faces : tuple of Rings
    measures : (5,) float64
        Sums over the parts: through-holes, parts that stand out, misfit, parts that hang nowhere,
        what gaps between rings and faces cost.
    seated : tuple of Seated
        The parts that lie in faces.
    """

    depths: Array
    faces: tuple[Rings, ...]
    measures: Array
    seated: tuple[Seated, ...] = ()

    @classmethod
    def alone(cls, depths: Array, faces: Sequence[Rings]) -> Attached:
        """Return a body without parts."""
        return cls(depths, tuple(faces), np.zeros(5))

    @property
    def rough(self) -> float:
        """What is better is less: a rough order in which ways are dropped."""
        return float(self.measures @ (-0.5, 0.1, 1.0, 3.0, 0.4))

    @property
    def hangs(self) -> bool:
        """Whether all parts lie in faces, so that the depths of all follow from one another."""
        return bool(self.seated) and float(self.measures[3]) == 0.0

    def measured(self, drawing: Drawing, depths: Array) -> Array:
        """Return the measures where the corners are as deep as this, (5,)."""
        found = self.measures * (0.0, 0.0, 1.0, 1.0, 1.0)
        for each in self.seated:
            found = found + each.measures(drawing, depths)
        return np.asarray(found)


def attached(
    drawing: Drawing,
    classes: ParallelClasses,
    depths: Array,
    faces: Sequence[Rings],
    body: Sequence[int],
    parts: Sequence[Lifting],
    around: dict[tuple[Ring, Ring], bool],
) -> list[Attached]:
    """Return the ways in which loose parts belong to a body, the likeliest first.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    depths : (n,) array
        Of the corners of the body, away from the eye, diagonals.
    faces : sequence of Rings
        Of the body.
    body : sequence of int
        Its corners.
    parts : sequence of Lifting
        What is loose, the largest first.
    around : dict
        Whether a ring appears around another one, as far as it was asked: added to.
    """
    found = [Attached.alone(depths, faces)]
    known = list(body)
    holds = _holds(drawing, [tuple(faces), *(part.faces for part in parts)], around)
    outward = len(_reached(0, holds)) <= len(parts)
    for part in parts:
        ways = [
            way
            for each in found
            for way in _ways(drawing, classes, each, known, part, around, outward)
        ]
        known += part.corners
        found = likeliest(drawing, ways, known, MOST)
    return found


def likeliest(
    drawing: Drawing, ways: Sequence[Attached], known: Sequence[int], most: int
) -> list[Attached]:
    """Return the ways in which parts lie in a body that are likely, the likeliest first.

    Where some are left out, marks of hidden lines count as well: two bosses on a plate make more
    ways than are read, and a hole looks like a boss without marks.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    ways : sequence of Attached
        Ways in which the same parts lie in the body.
    known : sequence of int
        Corners of the body and these parts.
    most : int
        How many to return at most.
    """
    marks = [0.0] * len(ways)
    if len(ways) > most and is_marked(drawing):
        lines = np.isin(drawing.lines[:, 0], known)
        marks = [max(agreement(drawing, way.depths, way.faces, lines)) for way in ways]
    order = sorted(range(len(ways)), key=lambda k: ways[k].rough - MARKS * marks[k])
    return [ways[k] for k in order[:most]]


def hanging_order(drawing: Drawing, parts: Sequence[Lifting]) -> list[Lifting]:
    """Return parts so that each one can lie in faces of those before it.

    The long shaft of a bolt lies in a face of its short head. So the body is the largest part of
    those at which all others hang, directly or by others. Where there is none, some are held by
    what lies in their own faces, as both plates of a spool are by its core; then, or where that
    holds not all of them, the body is the largest part.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    parts : sequence of Lifting
        The largest first.
    """
    holds = _holds(drawing, [part.faces for part in parts], {})
    both = [held | {k for k, each in enumerate(holds) if n in each} for n, held in enumerate(holds)]
    orders = [_reached(start, way) for way in (holds, both) for start in range(len(parts))]
    if not orders:
        return []
    whole = next((each for each in orders if len(each) == len(parts)), orders[0])
    return [parts[k] for k in (*whole, *(k for k in range(len(parts)) if k not in whole))]


def _holds(
    drawing: Drawing, parts: Sequence[Sequence[Rings]], around: dict[tuple[Ring, Ring], bool]
) -> list[set[int]]:
    """Return for each part, given by its faces, which others may lie in a face of it."""
    return [
        {
            k
            for k, inner in enumerate(parts)
            if k != number and _may_hold(drawing, outer, inner, around)
        }
        for number, outer in enumerate(parts)
    ]


def _reached(start: int, holds: Sequence[set[int]]) -> list[int]:
    """Return what hangs at a part, directly or by others; each after what holds it."""
    order = [start]
    while left := set().union(*(holds[k] for k in order)) - set(order):
        order.append(min(left))
    return order


def _may_hold(
    drawing: Drawing,
    part: Sequence[Rings],
    other: Sequence[Rings],
    around: dict[tuple[Ring, Ring], bool],
) -> bool:
    """Whether a face of a part appears around one of another part."""
    return any(_surrounds(drawing, outer[0], inner[0], around) for outer in part for inner in other)


def _ways(
    drawing: Drawing,
    classes: ParallelClasses,
    body: Attached,
    known: list[int],
    part: Lifting,
    around: dict[tuple[Ring, Ring], bool],
    outward: bool,
) -> list[Attached]:
    """Return the ways in which one part lies in the faces of a body, or these in its own.

    The latter are looked for if `outward`.
    """
    system = _Part.of(drawing, classes, body.depths, known, part)
    tolerance = 0.012 + 2.5 * drawing.noise
    planes = [_plane(drawing, body, face) for face in range(len(body.faces))]
    options = [
        Seat(face, ring, is_outward)
        for is_outward in ((False, True) if outward else (False,))
        for face, (_, normal) in enumerate(planes)
        if abs(normal[2]) >= EDGE_ON
        for ring in range(len(part.faces))
        if _may_seat(drawing, body.faces[face], part.faces[ring], is_outward, around)
    ]
    levels = {each: _seat(drawing, planes[each.face], part.faces[each.ring][0]) for each in options}
    found: list[Attached] = []
    seen: set[frozenset[Seat]] = set()
    for option in options:
        depths, misfit = system.solved([levels[option]])
        if misfit > tolerance / abs(float(planes[option.face][1][2])):
            continue
        seats, gaps, is_beside = [option], [0.0], False
        for other in options:
            level, corners = levels[other]
            if all(other.face != s.face and other.ring != s.ring for s in seats):
                off = float(np.abs(depths[system.places(corners)] - level).mean())
                if off < tolerance / abs(float(planes[other.face][1][2])):
                    seats.append(other)
                    gaps.append(_gap(drawing, off, planes[other.face][1]))
                else:
                    is_beside = True
        costs = [_gap_cost(gap) for gap in gaps]
        if is_beside and len(seats) == 1:
            costs[0] = BESIDE
        ways = _with_and_without(seats, gaps, costs)
        if system.is_free and len(seats) == 1:
            opposite = _opposite(system, planes, levels, option, tolerance)
            ways += [([option, other], 0.0) for other in opposite]
        for chosen, cost in ways:
            key = frozenset(chosen)
            if key in seen:
                continue
            seen.add(key)
            depths, misfit = system.solved([levels[seat] for seat in chosen])
            way = (misfit / tolerance, cost)
            found.append(_joined(drawing, body, part, chosen, depths, way))
    return found or [_loose(body, known, part, system.solved([])[0])]


def _opposite(
    system: _Part,
    planes: Sequence[tuple[Array, Array]],
    levels: Mapping[Seat, tuple[Array, Ring]],
    seat: Seat,
    tolerance: float,
) -> list[Seat]:
    """Return the other seats that a part in one may have as well, where it leaves its slope free.

    A hole through a frustum runs along no line of it: how steep it is, the faces tell that both of
    its rings lie in.
    """
    return [
        other
        for other in levels
        if other.face != seat.face
        and other.ring != seat.ring
        and system.solved([levels[seat], levels[other]])[1]
        <= tolerance / abs(float(planes[other.face][1][2]))
    ]


def _gap(drawing: Drawing, off: float, normal: Array) -> float:
    """Return how far a ring is drawn from a face, in units of the noise.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    off : float
        Distance of the ring from the plane along the line of sight, diagonals.
    normal : (3,) array
        Of the plane. What is off along it appears as off |n_z| sqrt(1 - n_z²) on the sheet.
    """
    upright = abs(float(normal[2]))
    return off * upright * float(np.sqrt(max(0.0, 1.0 - upright**2))) / max(1e-6, drawing.noise)


def _gap_cost(gap: float) -> float:
    """Return what a gap costs that a ring in a face is drawn with, nats."""
    odds = 1.0 + (gap / GAP) ** 2 / FREEDOM
    return min(WORST, 0.5 * (FREEDOM + 1.0) * float(np.log(odds)))


def _with_and_without(
    seats: Sequence[Seat], gaps: Sequence[float], costs: Sequence[float]
) -> list[tuple[list[Seat], float]]:
    """Return seats and their cost: all, and where some are far off, those that are not."""
    ways = [(list(seats), sum(costs))]
    near = [k for k, gap in enumerate(gaps) if gap < APART]
    if len(near) < len(seats):
        cost = sum(costs[k] for k in near) + BESIDE * (len(seats) - len(near))
        ways.append(([seats[k] for k in near], cost))
    return ways


def _may_seat(
    drawing: Drawing,
    face: Rings,
    ring: Rings,
    is_outward: bool,
    around: dict[tuple[Ring, Ring], bool],
) -> bool:
    """Whether a face of a body surrounds one of a part, or the other way round.

    What is surrounded is whole: of a face with a hole nobody knows what lies in the hole.
    """
    if is_outward:
        return len(face) == 1 and _surrounds(drawing, ring[0], face[0], around)
    return _surrounds(drawing, face[0], ring[0], around)


def _joined(
    drawing: Drawing,
    body: Attached,
    part: Lifting,
    seats: Sequence[Seat],
    depths: Array,
    costs: tuple[float, float],
) -> Attached:
    """Return the body with a part in its faces, or with faces of it in those of the part.

    Misfit and gaps of the seats are given as `costs`.
    """
    new = body.depths.copy()
    new[list(part.corners)] = depths
    inward = {seat.face: part.faces[seat.ring][0] for seat in seats if not seat.is_outward}
    outward = {seat.ring: body.faces[seat.face][0] for seat in seats if seat.is_outward}
    covered = [seat.face for seat in seats if seat.is_outward]
    taken = [seat.ring for seat in seats if not seat.is_outward]
    faces = [
        *_with_holes(body.faces, inward, left_out=covered),
        *_with_holes(part.faces, outward, left_out=taken),
    ]
    corners = frozenset(corner for seat in seats for corner in part.faces[seat.ring][0])
    seated = Seated(part, corners, body.faces, len(seats) > 1)
    measures = seated.measures(drawing, new) + np.array((0.0, 0.0, costs[0], 0.0, costs[1]))
    return Attached(new, tuple(faces), body.measures + measures, (*body.seated, seated))


def _with_holes(
    faces: Sequence[Rings], holes: Mapping[int, Ring], left_out: Sequence[int]
) -> list[Rings]:
    """Return faces, one more hole in each that is named, but for some of them."""
    return [
        (*face, holes[number]) if number in holes else face
        for number, face in enumerate(faces)
        if number not in left_out
    ]


def _loose(body: Attached, known: list[int], part: Lifting, depths: Array) -> Attached:
    """Return the body with a part beside it, as deep as its middle."""
    new = body.depths.copy()
    new[list(part.corners)] = depths - depths.mean() + body.depths[known].mean()
    measures = body.measures + np.array((0.0, 0.0, 0.0, 1.0, 0.0))
    return Attached(new, body.faces + part.faces, measures, body.seated)


@dataclass(frozen=True, eq=False)
class _Part:
    """Equations for the depths of a part: its lines and its planar faces.

    It is free where some of its lines run clearly as none of the body: nothing tells their slope.
    """

    corners: tuple[int, ...]
    rows: Array
    values: Array
    is_free: bool

    @classmethod
    def of(
        cls,
        drawing: Drawing,
        classes: ParallelClasses,
        depths: Array,
        known: list[int],
        part: Lifting,
    ) -> _Part:
        slopes = _slopes(drawing, classes, depths, known)
        column = np.full(len(drawing.points), -1)
        column[list(part.corners)] = np.arange(len(part.corners))
        planar = face_rows(drawing.points, part.corners, part.faces)
        rows, values = [planar], [np.zeros(len(planar))]
        along = (drawing.spans * classes.directions[classes.labels]).sum(1)
        inner = column[drawing.lines[:, 0]] >= 0
        for label in np.unique(classes.labels[inner]):
            chosen = np.flatnonzero(inner & (classes.labels == label))
            block = np.zeros((len(chosen), len(part.corners)))
            block[np.arange(len(chosen)), column[drawing.lines[chosen, 1]]] = 1.0
            block[np.arange(len(chosen)), column[drawing.lines[chosen, 0]]] = -1.0
            if np.isfinite(slopes[label]):
                values.append(slopes[label] * along[chosen])
            else:
                axis = along[chosen] / np.linalg.norm(along[chosen])
                block -= np.outer(axis, axis @ block)
                values.append(np.zeros(len(chosen)))
            rows.append(block)
        is_free = _is_clearly_apart(drawing, classes, inner, np.isfinite(slopes))
        return cls(part.corners, np.vstack(rows), np.concatenate(values), is_free)

    def places(self, corners: Sequence[int]) -> Index:
        """Return where corners stand among those of the part."""
        return np.searchsorted(self.corners, corners)

    def solved(self, seats: Sequence[tuple[Array, Ring]]) -> tuple[Array, float]:
        """Return depths with rings at given levels, and the root mean square misfit of these."""
        count = len(self.corners)
        rows, values = [self.rows, 1e-5 * np.eye(count)], [self.values, np.zeros(count)]
        for level, corners in seats:
            rows.append(np.eye(count)[self.places(corners)])
            values.append(level)
        matrix, right = np.vstack(rows), np.concatenate(values)
        depths = np.linalg.lstsq(matrix, right, rcond=None)[0]
        off = (matrix @ depths - right) ** 2
        return depths, float(np.sqrt(off.sum() / max(1, count)))


def _slopes(drawing: Drawing, classes: ParallelClasses, depths: Array, known: list[int]) -> Array:
    """Return the slope of each class in the body, NaN for those it has not."""
    lines = np.isin(drawing.lines[:, 0], known)
    labels = classes.labels[lines]
    along = (drawing.spans[lines] * classes.directions[labels]).sum(1)
    rise = depths[drawing.lines[lines, 1]] - depths[drawing.lines[lines, 0]]
    count = len(classes.directions)
    below = np.bincount(labels, along**2, count)
    above = np.bincount(labels, along * rise, count)
    return np.where(below > 0.0, above / np.where(below > 0.0, below, 1.0), np.nan)


def _is_clearly_apart(
    drawing: Drawing, classes: ParallelClasses, lines: Flags, known: Flags
) -> bool:
    """Whether some lines run as none of a body, however unsteady the hand.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    lines : (m,) bool
        Those that are asked.
    known : (c,) bool
        Classes that the body has.
    """
    own = np.setdiff1d(classes.labels[lines], np.flatnonzero(known))
    if not len(own) or not known.any():
        return bool(len(own))
    squares = np.bincount(classes.labels, drawing.lengths**2, len(known))
    spread = np.hypot(HAND, drawing.noise / np.sqrt(np.maximum(squares, 1e-12)))
    angles = np.arctan2(classes.directions[:, 1], classes.directions[:, 0])
    apart = angles[own, None] - angles[known]
    apart = np.abs((apart + np.pi / 2.0) % np.pi - np.pi / 2.0)
    return bool((apart > CLEARLY * np.hypot(spread[own, None], spread[known])).all(axis=1).any())


def _plane(drawing: Drawing, body: Attached, face: int) -> tuple[Array, Array]:
    """Return the middle of a face and its unit normal."""
    ring = list(body.faces[face][0])
    space = np.column_stack((drawing.points[ring], body.depths[ring]))
    normal = area_vector(space)
    return space.mean(0), normal / max(1e-12, float(np.linalg.norm(normal)))


def _seat(drawing: Drawing, plane: tuple[Array, Array], ring: Ring) -> tuple[Array, Ring]:
    """Return the depths that a ring has in a plane, which is not seen edge-on."""
    middle, normal = plane
    across = (drawing.points[list(ring)] - middle[:2]) @ normal[:2]
    return middle[2] - across / normal[2], ring


def _surrounds(
    drawing: Drawing, outer: Ring, inner: Ring, around: dict[tuple[Ring, Ring], bool]
) -> bool:
    """Whether a ring appears inside another one, up to the noise."""
    if (outer, inner) not in around:
        ring, places = drawing.points[list(outer)], drawing.points[list(inner)]
        near = _distances(places, ring) < 2.0 * drawing.noise
        around[outer, inner] = bool((inside(places, ring) | near).all())
    return around[outer, inner]


def _distances(places: Array, ring: Array) -> Array:
    """Return the distance of places from the sides of a polygon."""
    span = np.roll(ring, -1, axis=0) - ring
    share = ((places[:, None] - ring) * span).sum(2) / np.maximum((span**2).sum(1), 1e-18)
    feet = ring + np.clip(share, 0.0, 1.0)[..., None] * span
    return np.asarray(np.linalg.norm(places[:, None] - feet, axis=2).min(1))


def _share_inside(drawing: Drawing, seated: Seated, depths: Array) -> float:
    """Return the share of the lines of a part, those in faces left out, that is inside the body.

    Their middles are, by the parity of a ray along the view.
    """
    own = np.isin(drawing.lines[:, 0], seated.part.corners)
    free = np.flatnonzero(own & ~np.isin(drawing.lines, list(seated.corners)).all(1))
    if not len(free):
        return 1.0
    space = np.column_stack((drawing.points, depths))
    places = space[drawing.lines[free]].mean(1)
    odd = np.zeros(len(free), bool)
    for face in seated.faces:
        outer = space[list(face[0])]
        normal = area_vector(outer)
        if abs(normal[2]) < 1e-9:
            continue
        middle = outer.mean(0)
        level = middle[2] - (places[:, :2] - middle[:2]) @ normal[:2] / normal[2]
        for ring in face:
            odd ^= drawing.covered.middles(ring)[free] & (level > places[:, 2])
    return float(odd.mean())
