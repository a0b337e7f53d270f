"""Surfaces inflated, or sucked in, by a volume.

Where a surface meets its neighbours smoothly it bends like a clamped plate under an even load, so
that tangent planes stay. Where all its edges are creases it is a soap film (a membrane whose mean
curvature is the same everywhere), and goes through the hemisphere. In both cases the volume is
asked for, not the pressure: beyond the hemisphere a film holds less pressure in more volume.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import remembered
from bozzetto_product.fill.exact_patches import exact_patches
from bozzetto_product.fill.fair_solution import RIDGE, FairSolution
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.fill.patch_space import PLATE, PatchSpace, side_nodes
from bozzetto_product.fill.quintic import NODES, WEIGHTS, bernstein
from bozzetto_product.fill.side_conditions import TANGENCY
from bozzetto_product.shaping.volume import displaced_volume, size_for, volume_of

UNIT: Final = 0.25
"""Volume of the pressure 1, as share of the area to the power of 3/2: about a half ball's on a
disc."""

PLATE_STEP: Final = 0.01
"""Largest volume of one step of a plate, as share of the cube of the loop's size; after each its
load is turned to the new normals."""

FILM_STEP: Final = 0.06
"""Largest volume of one step of a film, likewise."""

FILM_ROUNDS: Final = 30
"""Most solves of a film at its full volume."""

START_ROUNDS: Final = 3
"""Solves of a film at each volume on the way."""

RELAXATION: Final = 0.8
"""Share of the way to the next film that is gone at once; the whole way swings."""

SETTLED: Final = 2e-4
"""Move, as share of the loop's size, after which a film is at rest: what is left is a drift of its
parameters in the film."""

MOST_TURN: Final = 1.0
"""Degrees by which pressure may turn a surface along a smooth edge; more pressure has no effect."""


@dataclass(frozen=True, eq=False)
class Inflated:
    """A surface under pressure.

    Parameters
    ----------
    fill : Fill
    volume : float
        Between it and the surface without pressure, mm³; along the normals is positive.
    limited : bool
        The volume asked for would tear smooth edges open; this is as far as it went.
    """

    fill: Fill
    volume: float
    limited: bool


def volume_of_pressure(area: float, pressure: float) -> float:
    """Return the volume of a pressure on an area in mm², mm³; ±1 blows a disc up to half a ball."""
    return float(pressure * UNIT * area**1.5)


def inflated(
    fill: Fill, volume: float, *, checkpoint: Callable[[], None] = lambda: None
) -> Inflated:
    """Return a surface that holds a volume over the given one; its boundary stays as it is.

    Parameters
    ----------
    fill : Fill
        Without pressure.
    volume : float
        mm³, positive to the side of its normals.
    checkpoint : callable
        Called between the steps.
    """
    if volume == 0.0 or not np.isfinite(volume):
        return Inflated(fill, 0.0, limited=False)
    bent = fill.bent
    if bent is None:
        return Inflated(fill, 0.0, limited=True)
    smooth = bool(np.isfinite(bent.solution.loop.normals[..., 0]).any())
    way = _plate if smooth else _film
    return way(bent, volume, checkpoint)


def _made(fill: PatchFill, solution: FairSolution) -> PatchFill:
    return replace(fill, solution=solution, patches=exact_patches(solution))


def _volume(solution: FairSolution) -> float:
    loop = solution.loop
    return volume_of(exact_patches(solution), loop.origin) / loop.size**3


def _by_size(solution: FairSolution, field: Array) -> Callable[[float], float]:
    """Return the volume by the size of a displacement of the free control points.

    The exact patches are an affine function of these.
    """
    loop = solution.loop
    moved = exact_patches(replace(solution, free=solution.free + field))
    volume = displaced_volume(exact_patches(solution), moved, loop.origin)
    return lambda size: volume(size) / loop.size**3


# -- plates ----------------------------------------------------------------------------------------


def _plate(fill: PatchFill, volume: float, checkpoint: Callable[[], None]) -> Inflated:
    loop = fill.solution.loop
    wanted = volume / loop.size**3
    base = _volume(fill.solution)
    most = _turned(fill) + MOST_TURN
    solution, last = fill.solution, fill
    for number, goal in enumerate(_goals(wanted, PLATE_STEP)):
        checkpoint()
        made = _stepped(fill.key, number, wanted > 0, goal, base, solution)
        found = None if made is None else _made(fill, made)
        if made is None or found is None or _turned(found) > most:
            held = _volume(solution) - base
            return Inflated(last, held * loop.size**3, limited=True)
        solution, last = made, found
    return Inflated(last, volume, limited=False)


def _goals(wanted: float, step: float) -> Iterator[float]:
    """Yield whole steps, so that a slider finds those that were there before, then the volume."""
    sense = 1.0 if wanted > 0 else -1.0
    count = int(np.ceil(abs(wanted) / step - 1e-9))
    for number in range(1, count):
        yield sense * step * number
    yield wanted


def _step_key(
    key: bytes, number: int, out: bool, goal: float, base: float, solution: FairSolution
) -> tuple[bytes, int, bool, float]:
    return key, number, out, goal


@remembered(limit=256, key=_step_key)
def _stepped(
    key: bytes, number: int, out: bool, goal: float, base: float, solution: FairSolution
) -> FairSolution | None:
    """Return the plate at a volume over the base, from a solution near it."""
    field = _plate_field(key, number, out, solution)
    volume = _by_size(solution, field)
    here = volume(0.0)
    slope = volume(1.0) - here
    if slope <= 0.0:
        return None
    size = size_for(volume, base + goal, (base + goal - here) / slope)
    if size is None:
        return None
    return replace(solution, free=solution.free + size * field)


@remembered(limit=64, key=lambda key, number, out, solution: (key, number, out))
def _plate_field(key: bytes, number: int, out: bool, solution: FairSolution) -> Array:
    """Return the displacement of the free control points under an even load, (f, 3)."""
    from scipy.linalg import cho_factor, cho_solve

    space = solution.space
    stiffness, _ = space.stiffness(PLATE)
    size = len(stiffness)
    matrix = np.kron(np.eye(3), stiffness)
    scale = float(np.trace(stiffness)) / size
    held = np.isfinite(solution.loop.normals[..., 0])
    if held.any():
        weights = np.sqrt(np.broadcast_to(side_nodes()[1], held.shape)[held])[:, None]
        normals = solution.loop.normals[held] * weights
        rows = (normals[:, :, None] * space.across[0][held][:, None, :]).reshape(len(normals), -1)
        matrix += TANGENCY * scale * (rows.T @ rows)
    matrix[np.diag_indices_from(matrix)] += RIDGE * scale
    factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
    found = cho_solve(factor, _load(solution).T.ravel(), check_finite=False)
    return np.asarray(space.basis @ found.reshape(3, size).T)


def _turned(fill: PatchFill) -> float:
    """Return the largest angle between a fill and the normals of its smooth edges, degrees."""
    angles = np.array(fill.g1_degrees)
    return float(np.nanmax(angles, initial=0.0)) if np.isfinite(angles).any() else 0.0


# -- films -----------------------------------------------------------------------------------------


def _film(fill: PatchFill, volume: float, checkpoint: Callable[[], None]) -> Inflated:
    loop = fill.solution.loop
    wanted = volume / loop.size**3
    base = _volume(fill.solution)
    solution = fill.solution
    *way, end = _goals(wanted, FILM_STEP)
    for goal in way:
        for _ in range(START_ROUNDS):
            checkpoint()
            solution = _relaxed(solution, base + goal, RELAXATION) or solution
    for round_number in range(FILM_ROUNDS):
        checkpoint()
        last = round_number == FILM_ROUNDS - 1
        found = _relaxed(solution, base + end, 1.0 if last else RELAXATION)
        if found is None:
            held = (_volume(solution) - base) * loop.size**3
            return Inflated(_made(fill, solution), held, limited=True)
        moved = float(np.abs(found.free - solution.free).max())
        solution = found
        if moved < SETTLED:
            solution = _relaxed(solution, base + end, 1.0) or solution
            break
    return Inflated(_made(fill, solution), volume, limited=False)


def _relaxed(solution: FairSolution, wanted: float, share: float) -> FairSolution | None:
    """Go a share of the way to the film of a volume over the present metric.

    A film h + p q has the least area to first order: h without pressure, q by a pressure of one.
    """
    from scipy.linalg import cho_factor, cho_solve

    space, controls = solution.space, solution.loop.controls
    weights, _, by_u, by_v = _gauss_tables()
    points = solution.nets.reshape(space.count, -1, 3)
    slope_u, slope_v = by_u @ points, by_v @ points
    first, mixed, second = (
        (a * b).sum(axis=-1)
        for a, b in ((slope_u, slope_u), (slope_u, slope_v), (slope_v, slope_v))
    )
    area = np.sqrt(np.maximum(first * second - mixed**2, 1e-24))
    basis_u, basis_v = by_u @ space.own_basis, by_v @ space.own_basis
    sides = space.own_sides @ controls
    known_u, known_v = by_u @ sides, by_v @ sides
    a, b, c = (weights * each / area for each in (second, -mixed, first))
    flux_u = a[..., None] * basis_u + b[..., None] * basis_v
    flux_v = b[..., None] * basis_u + c[..., None] * basis_v
    size = space.basis.shape[1]
    matrix = _paired(basis_u, flux_u) + _paired(basis_v, flux_v)
    matrix[np.diag_indices(size)] += RIDGE * np.trace(matrix) / size
    right = _paired(flux_u, known_u) + _paired(flux_v, known_v)
    factor = cho_factor(matrix, lower=True, check_finite=False)
    still = cho_solve(factor, -right, check_finite=False)
    pressed = cho_solve(factor, _load(solution), check_finite=False)
    free = space.basis @ still + space.particular @ controls
    field = np.asarray(space.basis @ pressed)
    volume = _by_size(replace(solution, free=free), field)
    here = volume(0.0)
    slope = volume(1.0) - here
    if slope == 0.0:
        return None
    found = size_for(volume, wanted, (wanted - here) / slope or 1.0)
    if found is None:
        return None
    goal = free + found * field
    return replace(solution, free=solution.free + share * (goal - solution.free))


def _paired(one: Array, other: Array) -> Array:
    return np.asarray(one.reshape(-1, one.shape[-1]).T @ other.reshape(-1, other.shape[-1]))


# -- both ------------------------------------------------------------------------------------------


def _gauss_tables() -> tuple[Array, Array, Array, Array]:
    """Return weights (49,), values and both first derivatives (49, 36) at Gauss points."""
    values, slopes = bernstein(NODES), bernstein(NODES, 1)
    places = len(NODES) ** 2

    def table(one: Array, other: Array) -> Array:
        return np.asarray(np.einsum("ai,bj->abij", one, other).reshape(places, -1))

    return (
        np.outer(WEIGHTS, WEIGHTS).ravel(),
        table(values, values),
        table(slopes, values),
        table(values, slopes),
    )


def _load(solution: FairSolution) -> Array:
    """Return what a pressure of one does to the coefficients of the basis, (z, 3)."""
    space: PatchSpace = solution.space
    weights, values, by_u, by_v = _gauss_tables()
    points = solution.nets.reshape(space.count, -1, 3)
    across = cross_product(by_u @ points, by_v @ points) * weights[:, None]
    return _paired(values @ space.own_basis, across)
