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

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.hanging_parts import holds, reached, surrounds
from bozzetto_polyhedron.reconstruction.lifting import Lifting
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses
from bozzetto_polyhedron.reconstruction.part_depths import (
    PartDepths,
    gap_cost,
    gap_of,
    level_of,
    plane_of,
    with_own_sides,
)
from bozzetto_polyhedron.reconstruction.regularity import area_vector
from bozzetto_polyhedron.reconstruction.visibility import agreement, is_marked

EDGE_ON: Final = 0.08
"""Least share of a normal along the line of sight: a face seen edge-on surrounds nothing."""

MARKS: Final = 1.0
"""Weight of the log-likelihood of marks beside `Attached.rough`."""

MOST: Final = 6
"""Ways that are kept for each part."""

APART: Final = 0.8
"""Gap, in units of the noise, from which on it is also asked whether a ring lies beside a face."""

BESIDE: Final = 3.0
"""What a ring costs that lies beside a face and not in it, nats: floors are of any thickness, of
which twenty times the noise is usual (log 20). So it costs however thick the floor is."""


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
    classes : ParallelClasses
        Of all lines; sides of a hole may have one of their own.
    seated : tuple of Seated
        The parts that lie in faces.
    """

    depths: Array
    faces: tuple[Rings, ...]
    measures: Array
    classes: ParallelClasses
    seated: tuple[Seated, ...] = ()

    @classmethod
    def alone(cls, depths: Array, faces: Sequence[Rings], classes: ParallelClasses) -> Attached:
        """Return a body without parts."""
        return cls(depths, tuple(faces), np.zeros(5), classes)

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
    found = [Attached.alone(depths, faces, classes)]
    known = list(body)
    inside_of = holds(drawing, [tuple(faces), *(part.faces for part in parts)], around)
    outward = len(reached(0, inside_of)) <= len(parts)
    for part in parts:
        ways = [way for each in found for way in _ways(drawing, each, known, part, around, outward)]
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


def _ways(
    drawing: Drawing,
    body: Attached,
    known: list[int],
    part: Lifting,
    around: dict[tuple[Ring, Ring], bool],
    outward: bool,
) -> list[Attached]:
    """Return the ways in which one part lies in the faces of a body, or these in its own.

    The latter are looked for if `outward`.
    """
    system = PartDepths.of(drawing, body.classes, body.depths, known, part)
    tolerance = 0.012 + 2.5 * drawing.noise
    planes = [plane_of(drawing, body.depths, face) for face in body.faces]
    limits = [tolerance / max(1e-12, abs(float(normal[2]))) for _, normal in planes]
    options = [
        Seat(face, ring, is_outward)
        for is_outward in ((False, True) if outward else (False,))
        for face, (_, normal) in enumerate(planes)
        if abs(normal[2]) >= EDGE_ON
        for ring in range(len(part.faces))
        if _may_seat(drawing, body.faces[face], part.faces[ring], is_outward, around)
    ]
    levels = {
        each: level_of(drawing, planes[each.face], part.faces[each.ring][0]) for each in options
    }
    found: list[Attached] = []
    seen: set[frozenset[Seat]] = set()

    def join(
        seats: Sequence[Seat], cost: float, equations: PartDepths, classes: ParallelClasses
    ) -> None:
        if frozenset(seats) in seen:
            return
        depths, misfit = equations.solved([levels[seat] for seat in seats])
        seen.add(frozenset(seats))
        way = (misfit / tolerance, cost)
        found.append(_joined(drawing, body, part, seats, depths, way, classes))

    for option in options:
        depths, misfit = system.solved([levels[option]])
        if misfit > limits[option.face]:
            continue
        seats, gaps, beside = [option], [0.0], []
        for other in options:
            level, corners = levels[other]
            if all(other.face != s.face and other.ring != s.ring for s in seats):
                off = float(np.abs(depths[system.places(corners)] - level).mean())
                if off < limits[other.face]:
                    seats.append(other)
                    gaps.append(gap_of(drawing, off, planes[other.face][1]))
                else:
                    beside.append(other)
        costs = [gap_cost(gap) for gap in gaps]
        if beside and len(seats) == 1:
            costs[0] = BESIDE
        for chosen, cost in _with_and_without(seats, gaps, costs):
            join(chosen, cost, system, body.classes)
        for other in beside if len(seats) == 1 else ():
            freed = _freed(drawing, body, known, part, (option, other), levels)
            if freed is not None:
                equations, classes, cost = freed
                pair = [levels[option], levels[other]]
                if equations.solved(pair)[1] <= limits[other.face]:
                    join((option, other), cost, equations, classes)
    return found or [_loose(body, known, part, system.solved([])[0])]


def _freed(
    drawing: Drawing,
    body: Attached,
    known: Sequence[int],
    part: Lifting,
    seats: tuple[Seat, Seat],
    levels: Mapping[Seat, tuple[Array, Ring]],
) -> tuple[PartDepths, ParallelClasses, float] | None:
    """Return equations by which a part lies in two faces whatever slope its sides need.

    Also the classes in which these sides have a slope of their own, and what that costs. A hole
    through a frustum runs along no line of it: how steep it is, the faces tell that both of its
    rings lie in. None where no line joins the rings.
    """
    in_rings = [np.isin(drawing.lines, levels[seat][1]).all(axis=1) for seat in seats]
    own = np.isin(drawing.lines[:, 0], part.corners)
    sides = np.flatnonzero(own & ~in_rings[0] & ~in_rings[1])
    if not len(sides):
        return None
    classes, cost = with_own_sides(drawing, body.classes, known, sides)
    return PartDepths.of(drawing, classes, body.depths, known, part), classes, cost


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
        return len(face) == 1 and surrounds(drawing, ring[0], face[0], around)
    return surrounds(drawing, face[0], ring[0], around)


def _joined(
    drawing: Drawing,
    body: Attached,
    part: Lifting,
    seats: Sequence[Seat],
    depths: Array,
    costs: tuple[float, float],
    classes: ParallelClasses,
) -> Attached:
    """Return the body with a part in its faces, or with faces of it in those of the part.

    Misfit of the seats and what they cost are given as `costs`.
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
    seats_so_far = (*body.seated, seated)
    return Attached(new, tuple(faces), body.measures + measures, classes, seats_so_far)


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
    return Attached(new, body.faces + part.faces, measures, body.classes, body.seated)


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
