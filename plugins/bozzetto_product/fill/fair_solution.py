"""The fairest surface over a domain through the sides of a loop, tangent to its normals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import cached_property
from bozzetto_product.fill.loop_frame import LoopSides
from bozzetto_product.fill.mean_curvature import (
    FINE_GRID,
    Curvature,
    curvature_of,
    even_terms,
    is_folded,
    normals_of,
    variation,
)
from bozzetto_product.fill.patch_space import (
    BENDING_RATE,
    PLATE,
    PatchSpace,
)
from bozzetto_product.fill.quadric import Quadric
from bozzetto_product.fill.quintic import NODES, bernstein
from bozzetto_product.fill.side_conditions import SideConditions
from bozzetto_product.fill.sweep import Sweep, sweep_of
from bozzetto_product.fill.thin_strips import is_strip, strip_places

TANGENTIAL: Final = 0.09
"""Weight of the part of the Laplacian in the surface: it keeps parameters even."""

REMAINING_ENERGY: Final = 1e-5
"""Share of the start's energy that is kept while curvature is evened."""

GAIN: Final = 0.3
"""Share of the variation of curvature below which an evened surface is believed: profiles like
an S lose their shape where less is gained."""

BOTH_GAIN: Final = 0.8
"""The same share where both the rate of bending and a plate gain..."""

SAME: Final = 1e-3
"""...and become one surface: root mean square distance as share of the size."""

EVEN: Final = 0.1
"""Variation of curvature below which an evened surface is believed rather than a sweep, and
without a look at the plate's: of spheres, tori and saddles it was 0.02 at most."""

TOLD: Final = 0.3
"""Distance of a sweep from the surface of least energy, as share of its distance from the sides,
from which it tells more than that does."""

PLATE_HANDICAP: Final = 3.0
"""Factor on the variation of a plate: the rate of bending is the better start."""

ROUGH: Final = 0.01
"""Distance of sides from polynomials, as share of the size of a loop, from which curvature is not
evened: the polynomials' own says little there."""

STIFFENING: Final = 1e-4
"""Weight of the energy where a surface is fitted to a sweep, in mean diagonals: it decides what is
free."""

FAR_TURN: Final = 3.0
"""Turn of a sweep, radians, from which its places may slide along it."""

QUADRIC_STIFFENINGS: Final = (1e-2, 1.0, 100.0)
"""The same where it is laid on a quadric, in turn until the surface has its normals: sides that are
a little off it ask for tangent planes that are not theirs."""

SLIDING: Final = 1e-3
"""Weight of the way along a quadric against that off it: where on it a place is hardly matters."""

LEAST_LIKE: Final = 0.1
"""The same sine of a surface that was laid on a quadric, up to which it lies there smoothly."""

RIDGE: Final = 1e-11
"""Share of the mean diagonal that is added to it, so that a matrix can be factored."""


@dataclass(frozen=True, eq=False)
class FairSolution:
    """A surface of a `PatchSpace`, without what its sides have beyond one polynomial each.

    Parameters
    ----------
    space : PatchSpace
        Later changes of the surface are sought in ``space.basis``.
    loop : LoopSides
    free : (f, 3) float
        Free control points in the frame of the loop.
    order : int
        Of the energy that was least.
    evened : bool
        The variation of its mean curvature was reduced.
    """

    space: PatchSpace
    loop: LoopSides
    free: Array
    order: int
    evened: bool = False

    @cached_property
    def nets(self) -> Array:
        """Control nets in the frame of the loop, (n, 6, 6, 3)."""
        return self.space.nets(self.free, self.loop.controls)


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A surface that may be the fairest, with its curvature."""

    solution: FairSolution

    @cached_property
    def curvature(self) -> Curvature:
        """At the Gauss points."""
        return curvature_of(self.solution.nets)

    @cached_property
    def score(self) -> float:
        """Variation of the mean curvature that no polynomial explains, times the loop's size."""
        return variation(self.curvature, self.solution.space)

    @cached_property
    def folds(self) -> bool:
        """Whether it is folded."""
        return is_folded(self.solution.nets)


def _started(asked: SideConditions, order: int) -> FairSolution:
    """Return the surface of least energy."""
    loop = asked.loop
    stiffness, load = asked.space.stiffness(order)
    size = len(stiffness)
    matrix = np.zeros((3 * size, 3 * size))
    right = np.empty((3, size))
    for axis in range(3):
        part = slice(axis * size, (axis + 1) * size)
        matrix[part, part] = stiffness
    right[:] = -(load @ loop.controls).T
    scale = float(np.trace(stiffness)) / size
    asked.hold(matrix, right, scale)
    asked.draw(matrix, right, scale)
    return _solved(matrix, right, asked, order, scale)


def _evened(asked: SideConditions, start: _Candidate) -> FairSolution:
    """Return the surface after one Gauss–Newton step on the variation of its mean curvature.

    With L the Laplace–Beltrami operator of the surface at the start, n its normals and Q
    orthonormal polynomials of the domain, it minimises ``|(I - Q Qᵀ) n·Lx / 2|²`` and, weakly, the
    part of ``Lx`` in the surface and the energy of the start.
    """
    space, loop, order = asked.space, asked.loop, start.solution.order
    curvature = start.curvature
    stiffness, load = space.stiffness(order)
    size = len(stiffness)
    root = np.sqrt(np.maximum(curvature.areas, 1e-14)).ravel()
    normals = curvature.normals.reshape(-1, 3)
    operator = curvature.operator
    laplace = (operator @ space.own_basis).reshape(-1, size) * root[:, None]
    known = (operator @ (space.own_sides @ loop.controls)).reshape(-1, 3) * root[:, None]
    ortho = np.linalg.qr(even_terms(space) * root[:, None])[0]
    turned = (normals[:, :, None] * laplace[:, None, :]).reshape(len(normals), 3 * size)
    explained = ortho.T @ turned
    across = turned.T @ turned
    along = laplace.T @ laplace
    matrix = (1.0 - TANGENTIAL) * across - explained.T @ explained
    height = (normals * known).sum(axis=1)
    right = (TANGENTIAL - 1.0) * (turned.T @ height) + explained.T @ (ortho.T @ height)
    right = right.reshape(3, size) - TANGENTIAL * (laplace.T @ known).T
    share = REMAINING_ENERGY * TANGENTIAL * np.trace(along) / np.trace(stiffness)
    for axis in range(3):
        part = slice(axis * size, (axis + 1) * size)
        matrix[part, part] += share * stiffness + TANGENTIAL * along
    right -= share * (load @ loop.controls).T
    scale = float(np.trace(matrix)) / (3 * size)
    asked.hold(matrix, right, scale)
    made = _solved(matrix, right, asked, order, scale)
    return replace(made, evened=True)


def _fitted(asked: SideConditions, start: _Candidate, sweep: Sweep) -> FairSolution:
    """Return the surface nearest to a sweep, with a little of the energy of a start.

    What turns by half a turn or more is hardly at the places where polynomials want to be, so it
    may slide along itself then.
    """
    places = sweep.places(asked.space, asked.loop.controls)
    made = _nearest(asked, start, places, None, STIFFENING)
    if sweep.screw.angle < FAR_TURN:
        return made
    normals = normals_of(made.nets, NODES).reshape(-1, 3)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return _nearest(asked, start, places, normals, STIFFENING)


def _nearest(
    asked: SideConditions,
    start: _Candidate,
    places: Array,
    normals: Array | None,
    stiffening: float,
) -> FairSolution:
    """Return the surface nearest to places for its Gauss points.

    Parameters
    ----------
    asked : SideConditions
        What the sides ask.
    start : _Candidate
        Whose energy and areas count.
    places : (49 n, 3) float
        In the frame of the loop.
    normals : (49 n, 3) float, optional
        Unit, of the surface that the places are on: it matters little where on it they are.
    stiffening : float
        Weight of the energy, in mean diagonals.
    """
    space, loop, order = asked.space, asked.loop, start.solution.order
    stiffness, load = space.stiffness(order)
    size = len(stiffness)
    root = np.sqrt(np.maximum(start.curvature.areas, 1e-14)).reshape(-1, 1)
    values = bernstein(NODES)
    values = np.einsum("ai,bj->abij", values, values).reshape(len(NODES) ** 2, -1)
    basis = root * (values @ space.own_basis).reshape(len(root), size)
    sides = (values @ (space.own_sides @ loop.controls)).reshape(-1, 3)
    wanted = root * (places - sides)
    square = basis.T @ basis
    share = stiffening * float(np.trace(square) / np.trace(stiffness))
    along = 1.0 if normals is None else SLIDING
    matrix = np.zeros((3 * size, 3 * size))
    for axis in range(3):
        part = slice(axis * size, (axis + 1) * size)
        matrix[part, part] = along * square + share * stiffness
    right = (along * (basis.T @ wanted) - share * (load @ loop.controls)).T
    if normals is not None:
        rows = (normals[:, :, None] * basis[:, None, :]).reshape(len(normals), 3 * size)
        height = (normals * wanted).sum(axis=1)
        matrix += (1.0 - along) * (rows.T @ rows)
        right += (1.0 - along) * (rows.T @ height).reshape(3, size)
    scale = float(np.trace(matrix)) / (3 * size)
    asked.hold(matrix, right, scale)
    return _solved(matrix, right, asked, order, scale)


def fairest(space: PatchSpace, loop: LoopSides) -> FairSolution:
    """Return the best of two energies, evened or not, by a score that needs no true surface.

    Where all sides lie on one quadric, and are smooth to it, the surface is that quadric. A narrow
    strip with waves along its sides goes straight from side to side. Sides with creases that lie
    exactly on one quadric alone have that for a surface. Where two
    sides are swept into one another, that sweep takes their place, unless the tangent planes along
    all sides tell a surface of even curvature, such as a sphere, or the sides are no nearer to the
    sweep than it is to the surface of least energy. An evened surface that gains less is believed
    if those of both energies gain and are the same; where they are not, one more step is taken.
    What folds is taken only if all do.
    """
    asked = SideConditions.of(space, loop)
    start = _Candidate(_started(asked, BENDING_RATE))
    even = _evened_or(asked, start)
    on_quadric = _on_quadric(asked, even) if loop.is_smooth else None
    if on_quadric is not None:
        return on_quadric.solution
    if is_strip(loop.sides):
        places = strip_places(space, loop.controls)
        strip = _Candidate(_nearest(asked, start, places, None, STIFFENING))
        if not strip.folds:
            return strip.solution
    best = even if even.score < GAIN * start.score else start
    if not loop.is_smooth:
        on_quadric = _on_quadric(asked, best)
        if on_quadric is not None:
            return on_quadric.solution
    is_even = best.solution.evened
    if not (is_even and best.score < EVEN and loop.is_smooth):
        sweep = sweep_of(loop.sides, loop.origin, loop.size)
        if sweep is not None:
            swept = _Candidate(_fitted(asked, start, sweep))
            if not swept.folds and _apart(swept, best) > TOLD * sweep.off:
                return swept.solution
    if is_even and best.score < EVEN:
        return best.solution
    plate = _Candidate(_started(asked, PLATE))
    even_plate = _evened_or(asked, plate)
    both = even.solution.evened and even_plate.solution.evened
    if both and _apart(even, even_plate) < SAME:
        if even.score < BOTH_GAIN * start.score and even_plate.score < BOTH_GAIN * plate.score:
            return even.solution
    elif even_plate.solution.evened and even_plate.score >= GAIN * plate.score:
        even_plate = _evened_or(asked, even_plate)
    if even_plate.score < GAIN * plate.score:
        plate = even_plate
    judged = [
        (made.folds, handicap * made.score)
        for made, handicap in ((best, 1.0), (plate, PLATE_HANDICAP))
    ]
    return (plate if judged[1] < judged[0] else best).solution


def _on_quadric(asked: SideConditions, start: _Candidate) -> _Candidate | None:
    """Return the surface on the quadric through all sides; None where there is none."""
    quadric = asked.loop.quadric
    if quadric is None:
        return None
    nearest = quadric.nearest(_places(start.solution.nets, NODES).reshape(-1, 3))
    if nearest is None:
        return None
    normals = quadric.normals(nearest)
    for stiffening in QUADRIC_STIFFENINGS:
        made = _Candidate(_nearest(asked, start, nearest, normals, stiffening))
        if not made.folds and _leaning(made, quadric) <= LEAST_LIKE:
            return made
    return None


def _leaning(made: _Candidate, quadric: Quadric) -> float:
    """Return the largest sine between normals of a surface and those of a quadric."""
    at = np.linspace(0.03, 0.97, FINE_GRID)
    normals = normals_of(made.solution.nets, at).reshape(-1, 3)
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    wanted = quadric.normals(_places(made.solution.nets, at).reshape(-1, 3))
    return float((np.linalg.norm(cross_product(normals, wanted), axis=1) / lengths).max())


def _places(nets: Array, at: Array) -> Array:
    """Return places of patches on a grid of parameters, (n, k, k, 3)."""
    values = bernstein(at)
    return np.asarray(np.einsum("ai,kijd,bj->kabd", values, nets, values, optimize=True))


def _apart(one: _Candidate, other: _Candidate) -> float:
    """Return the root mean square distance of two surfaces along the normals of the first."""
    apart = _places(one.solution.nets - other.solution.nets, NODES)
    areas, normals = one.curvature.areas, one.curvature.normals
    along = (apart.reshape(normals.shape) * normals).sum(axis=-1)
    return float(np.sqrt((areas * along**2).sum() / max(float(areas.sum()), 1e-300)))


def _evened_or(asked: SideConditions, start: _Candidate) -> _Candidate:
    """Return the surface with evened curvature; the start if that folds or has rough sides."""
    if asked.loop.rest >= ROUGH:
        return start
    even = _Candidate(_evened(asked, start))
    return start if even.folds else even


def _solved(
    matrix: Array, right: Array, asked: SideConditions, order: int, scale: float
) -> FairSolution:
    from scipy.linalg import cho_factor, cho_solve

    size = matrix.shape[0] // 3
    matrix[np.diag_indices_from(matrix)] += RIDGE * scale
    factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
    found = cho_solve(factor, right.ravel(), check_finite=False).reshape(3, size).T
    space, loop = asked.space, asked.loop
    free = space.basis @ found + space.particular @ loop.controls
    return FairSolution(space, loop, free, order)
