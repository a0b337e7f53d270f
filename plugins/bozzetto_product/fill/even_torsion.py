"""Torsions that corners leave open, chosen so that curvature changes least along the edges.

Along an edge the surface's second fundamental form has three entries in the frame of the unit
tangent t and b = n x t: the normal curvature κ and the geodesic torsion τ, which the normals tell,
and the curvature γ across the edge, which is between those of its ends. With the geodesic curvature
g its covariant derivative along the edge is

    (κ' - 2 g τ,   τ' + g (κ - γ),   γ' + 2 g τ),

0 on planes, spheres and cylinders; along the parallels of a body of revolution only the second is
not 0, but constant. Two curves through a corner leave its torsion open, and so the normals in the
middle of its edges: least is the integral of the squares over all edges, of the second without its
mean, as in minimum variation surfaces (Moreton & Séquin 1992, "Functional optimization for fair
surface design"), by two Gauss-Newton steps.

Where a surface of second order is told by the curves of a loop, the normals turn to its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.fill.normal_field import NormalField, unit_tangents

PLACES: Final = 17
"""Places along an edge at which curvatures are compared."""

ROUNDS: Final = 2
"""Gauss-Newton steps."""

AGREEMENT: Final = 20.0
"""Weight of the curvatures of edges at their corners against their change along edges."""

LOOSENESS: Final = 0.1
"""Weight of a mean curvature as that of the edges, where no corner tells one."""

STAY: Final = 1.5
"""Weight of a change of a torsion, and of a turn."""

DOUBT: Final = 0.1
"""How far curvatures round a node lack one second fundamental form, as share of the largest, at
which they tell half as much."""

SHARPEST: Final = 1e3
"""Largest curvature that counts, in radians by the length of an edge."""

FLAT: Final = 0.05
"""Bend of edges of mean length, radians, below which curvatures are not compared."""

MOST_TURN: Final = 0.05
"""Most that normals turn by it, radians: where more would be even, little is known."""

MOST_TOLD_TURN: Final = 0.5
"""The same of an edge of which the normals are told by a quadric, radians."""

TOLD: Final = 300.0
"""Weight of normals that a quadric tells, against the change of curvature along the edge."""

STEP: Final = 1e-3
"""What turns of normals are multiples of, radians: what is far from an edit stays the very same
surface."""

MOST_DENSE: Final = 200
"""Unknowns up to which a full matrix is solved sooner than a sparse one."""

HUMP: Final = 4.0 / 27.0
"""Largest turn along an edge of length one by a change of the torsion of one of its ends."""

EdgeEnd = tuple[int, int]
"""An edge and one of its ends: 0 where it starts, 1 where it ends."""


@dataclass(frozen=True, eq=False)
class OpenFan:
    """Corners round a node that edges with normals link, and what their torsions leave open.

    Parameters
    ----------
    senses : mapping of EdgeEnd to float
        Shares of a change of the torsions at its ends that keeps them in agreement; 0 where there
        is none.
    normal : (3,) float
        Unit.
    corners : sequence of (EdgeEnd, EdgeEnd, float, float)
        Two ends that meet, cosine and sine from the first to the second about the normal.
    """

    senses: Mapping[EdgeEnd, float]
    normal: Array
    corners: Sequence[tuple[EdgeEnd, EdgeEnd, float, float]]


@dataclass(frozen=True, eq=False)
class _Bends:
    """Curvatures along an edge, at places an even length apart, (17,) each."""

    length: float
    normal: Array
    geodesic: Array
    torsion: Array


def even_parameters(spline: Spline) -> tuple[Array, float]:
    """Return the parameters of places an even length apart, (17,), and the length, mm."""
    fine = np.linspace(*spline.range, 8 * PLACES)
    steps = np.linalg.norm(np.diff(spline.value(fine), axis=0), axis=1)
    arc = np.concatenate(((0.0,), np.cumsum(steps)))
    at = np.interp(np.linspace(0.0, arc[-1], PLACES), arc, fine)
    return at, max(float(arc[-1]), 1e-300)


@remembered(limit=4000, key=lambda field: field)
def _bends_of(field: NormalField) -> _Bends:
    spline = field.spline
    at, length = even_parameters(spline)
    way, bend = spline.derivative(at), spline.derivative(at, 2)
    square = (way * way).sum(axis=1, keepdims=True)
    square = np.where(square > 0.0, square, np.inf)
    curvature = (bend - (bend * way).sum(axis=1, keepdims=True) / square * way) / square
    tangents, normals = unit_tangents(spline, at), field.value(at)
    sides = cross_product(normals, tangents)
    rates = _SLOPES @ normals * ((PLACES - 1) / length)
    told = ((curvature * normals), (curvature * sides), -(rates * sides))
    most = SHARPEST / length
    return _Bends(length, *(np.clip(one.sum(axis=1), -most, most) for one in told))


def _slopes() -> Array:
    """Return the matrix of derivatives by the number of a place, of second order."""
    return np.asarray(np.gradient(np.eye(PLACES), axis=0, edge_order=2))


_SLOPES: Final = _slopes()


def middle_turn(share: Array) -> Array:
    """Return how far normals turn along an edge whose middle turns by one; its ends stay."""
    return np.asarray(16.0 * (share * (1.0 - share)) ** 2)


def even_torsions(
    fields: Mapping[int, NormalField],
    changes: Mapping[int, Array],
    fans: Sequence[OpenFan],
    told: Mapping[int, Array],
) -> dict[int, Array]:
    """Return further changes of the torsions at both ends of edges, and the turns of their middles.

    Parameters
    ----------
    fields : mapping of int to NormalField
        Of each edge.
    changes : mapping of int to (2,) array
        Of their torsions, by which corners agree.
    fans : sequence of OpenFan
        Round all nodes.
    told : mapping of int to (17,) array
        How far the normals of edges are from those of a quadric, at the places of
        `even_parameters`, radians about the tangent.

    Returns
    -------
    dict of int to (3,) array
        Radians by mm at start and end, and radians.
    """
    edges = sorted(fields)
    made = {edge: np.zeros(3) for edge in edges}
    if not edges:
        return made
    problem = _Problem.of(edges, fields, changes, fans)
    for number, edge in enumerate(edges):
        if edge in told:
            problem.told[number], problem.weights[number] = told[edge], TOLD
    for _ in range(ROUNDS):
        problem.improve()
    step = STEP / HUMP
    for number, fan in enumerate(fans):
        own = problem.lengths[number]
        turn = MOST_TOLD_TURN if all(edge in told for edge, _ in fan.senses) else MOST_TURN
        most = turn * own / (HUMP * max(fields[edge].length for edge, _ in fan.senses))
        amount = np.clip(step * np.round(problem.amounts[number] / step), -most, most) / own
        for (edge, end), sense in fan.senses.items():
            made[edge][end] = sense * amount
    for number, edge in enumerate(edges):
        turn = STEP * np.round(problem.turns[number] / STEP)
        most = MOST_TOLD_TURN if edge in told else MOST_TURN
        made[edge][2] = np.clip(turn, -most, most)
    return made


def _solved(rows: Index, columns: Index, values: Array, right: Array) -> Array:
    """Solve the equations whose matrix has the sums of values in these rows and columns."""
    size = len(right)
    if size <= MOST_DENSE:
        matrix = np.bincount(rows * size + columns, values, size * size).reshape(size, size)
        return np.asarray(np.linalg.solve(matrix, right))
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import spsolve

    sparse: Any = coo_matrix((values, (rows, columns)), shape=(size, size))
    return np.asarray(spsolve(sparse.tocsc(), right))


class _Problem:
    """The least squares problem of all edges and fans.

    Unknown are the amount by which each fan's torsions change, radians, the sum of its principal
    curvatures, and the turn of each edge's middle, radians.
    """

    def __init__(self, bends: Sequence[_Bends], lengths: Array) -> None:
        self.arcs = np.array([bend.length for bend in bends])
        self.first = np.array([bend.normal for bend in bends])
        self.geodesic = np.array([bend.geodesic for bend in bends])
        self.torsion = np.array([bend.torsion for bend in bends])
        self.lengths = lengths
        self.amounts = np.zeros(len(lengths))
        self.sums = np.zeros(len(lengths))
        self.turns = np.zeros(len(bends))
        shape = (len(bends), 2)
        self.fan_of: Index = np.full(shape, -1, np.intp)
        self.shares = np.zeros(shape)
        self.signs = np.ones(shape)
        self.agreed = np.zeros(shape)
        self.pairs: list[tuple[int, tuple[int, int], tuple[int, int], float, float]] = []
        self.belief = np.ones(len(lengths))
        self.told = np.zeros((len(bends), PLACES))
        self.weights = np.zeros(len(bends))

    @classmethod
    def of(
        cls,
        edges: Sequence[int],
        fields: Mapping[int, NormalField],
        changes: Mapping[int, Array],
        fans: Sequence[OpenFan],
    ) -> _Problem:
        """Give numbers to edges and fans; an end without a fan gets one of its own."""
        row = {edge: number for number, edge in enumerate(edges)}
        bends = [_bends_of(fields[edge]) for edge in edges]
        lengths = [
            float(np.mean([bends[row[edge]].length for edge, _ in fan.senses])) for fan in fans
        ]
        held = {end for fan in fans for end in fan.senses}
        loose = [(edge, end) for edge in edges for end in (0, 1) if (edge, end) not in held]
        lengths += [bends[row[edge]].length for edge, _ in loose]
        made = cls(bends, np.array(lengths))
        made.agreed[:] = [changes[edge] for edge in edges]
        for number, fan in enumerate(fans):
            for (edge, end), share in fan.senses.items():
                here = row[edge], end
                made.fan_of[here], made.shares[here] = number, share / lengths[number]
                made.signs[here] = np.sign(fields[edge].normals[-end] @ fan.normal) or 1.0
            for one, other, cosine, sine in fan.corners:
                ends = (row[one[0]], one[1]), (row[other[0]], other[1])
                made.pairs.append((number, *ends, cosine, sine))
        for number, (edge, end) in enumerate(loose, len(fans)):
            made.fan_of[row[edge], end] = number
        made._doubt()
        return made

    def _doubt(self) -> None:
        """Believe a fan less, the less its curvatures are those of one surface."""
        lacks: dict[int, list[tuple[float, float]]] = {}
        for columns, values, lack in self._at_corners():
            lacks.setdefault(int(columns[0]), []).append((float(values[1]), lack))
        largest = FLAT / self.lengths
        np.maximum.at(largest, self.fan_of, np.abs(self.first[:, [0, -1]]))
        for fan, rows in lacks.items():
            by_sum, lack = np.array(rows).T
            rest = lack - by_sum * (by_sum @ lack) / max(float(by_sum @ by_sum), 1e-300)
            worst = float(np.abs(rest).max()) / (AGREEMENT * self.lengths[fan] * largest[fan])
            self.belief[fan] = 1.0 / (1.0 + (worst / DOUBT) ** 2)

    def improve(self) -> None:
        """Take one Gauss-Newton step."""
        count, edges = len(self.lengths), len(self.arcs)
        numbers, rows, rest = self._along()
        square = np.einsum("eri,erj->eij", rows, rows)
        i, j = np.broadcast_arrays(numbers[:, :, None], numbers[:, None, :])
        right = np.zeros(2 * count + edges)
        np.add.at(right, numbers, -np.einsum("eri,er->ei", rows, rest))
        entries = [(i.ravel(), j.ravel(), square.ravel())]
        for columns, values, lack in self._at_corners():
            a, b = np.meshgrid(columns, columns, indexing="ij")
            entries.append((a.ravel(), b.ravel(), np.outer(values, values).ravel()))
            np.add.at(right, columns, -lack * values)
        lengths = self.lengths
        weights = STAY / self.belief, lengths * LOOSENESS, np.full(edges, STAY)
        expected = np.zeros(count)
        uses = np.zeros(count)
        ends = self.signs * self.first[:, [0, -1]]
        np.add.at(expected, self.fan_of, 2.0 * ends)
        np.add.at(uses, self.fan_of, 1.0)
        expected /= np.maximum(uses, 1.0)
        every = np.arange(len(right))
        entries.append((every, every, np.concatenate(weights) ** 2))
        right[:count] -= weights[0] ** 2 * self.amounts
        right[count : 2 * count] -= weights[1] ** 2 * (self.sums - expected)
        right[2 * count :] -= weights[2] ** 2 * self.turns
        i, j, values = (np.concatenate(part) for part in zip(*entries, strict=True))
        step = _solved(i, j, values, right)
        self.amounts += step[:count]
        self.sums += step[count : 2 * count]
        self.turns += step[2 * count :]

    def _along(self) -> tuple[Index, Array, Array]:
        """Return unknowns (m, 5), derivatives (m, 68, 5) and values (m, 68) of what changes."""
        share = np.linspace(0.0, 1.0, PLACES)
        back = 1.0 - share
        arc = self.arcs[:, None]
        rise = arc[:, :, None] * np.stack((share * back**2, -(share**2) * back))
        own = self.shares * self.amounts[self.fan_of]
        middle = np.broadcast_to(middle_turn(share), self.first.shape)
        turn = ((own + self.agreed)[:, :, None] * rise).sum(axis=1)
        turn = turn + self.turns[:, None] * middle
        cosine, sine = np.cos(turn), np.sin(turn)
        kappa = cosine * self.first - sine * self.geodesic
        g = cosine * self.geodesic + sine * self.first
        by_length = _SLOPES.T * (PLACES - 1) / self.arcs[:, None, None]

        def slope(values: Array) -> Array:
            return np.asarray(np.matmul(values[..., None, :], by_length).squeeze(-2))

        tau = self.torsion + slope(turn)
        ends = self.signs * self.sums[self.fan_of] - self.first[:, [0, -1]]
        gamma = ends[:, :1] * back + ends[:, 1:] * share
        rest = np.stack(
            (
                slope(kappa) - 2 * g * tau,
                np.sqrt(2.0) * (slope(tau) + g * (kappa - gamma)),
                slope(gamma) + 2 * g * tau,
            ),
            axis=1,
        )

        def turned(bump: Array) -> Array:
            twist = slope(bump)
            first = slope(-g * bump) - 2 * (kappa * tau * bump + g * twist)
            second = slope(twist) + kappa * bump * (kappa - gamma) - g * g * bump
            third = 2 * (kappa * tau * bump + g * twist)
            return np.stack((first, np.sqrt(2.0) * second, third), axis=1)

        columns = []
        for end, fade in ((0, back), (1, share)):
            columns.append(turned(self.shares[:, end, None] * rise[:, end]))
            across = self.signs[:, end, None] * fade
            columns.append(
                np.stack((0.0 * across, -np.sqrt(2.0) * g * across, slope(across)), axis=1)
            )
        columns.append(turned(middle))
        stretches = np.where((share == 0) | (share == 1), 0.5, 1.0) / (PLACES - 1)
        for part in (rest, *columns):
            part[:, 1] -= (part[:, 1] @ stretches)[:, None]
        weight = arc**2 * np.sqrt(stretches)
        rows = np.stack([column * weight[:, None] for column in columns], axis=-1)
        count = len(self.lengths)
        fans = self.fan_of
        both = [number for end in fans.T for number in (end, count + end)]
        numbers = np.stack((*both, 2 * count + np.arange(len(fans))), axis=1)
        flat = rows.reshape(len(rows), 3 * PLACES, len(columns))
        trust = 4.0 * share * back * self.weights[:, None] / np.sqrt(PLACES)
        still = np.zeros_like(turn)
        by_turn = (
            *(part for end in (0, 1) for part in (self.shares[:, end, None] * rise[:, end], still)),
            middle,
        )
        return (
            numbers,
            np.concatenate((flat, np.stack(by_turn, axis=-1) * trust[:, :, None]), axis=1),
            np.concatenate(
                ((rest * weight[:, None]).reshape(len(rows), -1), (turn - self.told) * trust),
                axis=1,
            ),
        )

    def _at_corners(self) -> list[tuple[Index, Array, float]]:
        """Return unknowns, derivatives and value of what curvatures lack at each corner."""
        made = []
        count = len(self.lengths)
        for fan, one, other, cosine, sine in self.pairs:
            weight = AGREEMENT * self.lengths[fan] * self.belief[fan]
            curvature = [self.signs[end] * self.first[end[0], -end[1]] for end in (one, other)]
            torsion = self.torsion[one[0], -one[1]] + self.agreed[one]
            torsion += self.shares[one] * self.amounts[fan]
            lack = curvature[0] * (cosine**2 - sine**2) + 2 * torsion * cosine * sine
            lack += self.sums[fan] * sine**2 - curvature[1]
            slopes = np.array((2 * self.shares[one] * cosine * sine, sine**2))
            made.append((np.array((fan, count + fan)), weight * slopes, weight * float(lack)))
        return made
