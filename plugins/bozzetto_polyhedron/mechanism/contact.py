"""Contact and Coulomb's friction, at the level of velocities.

Impulses P in the places that touch solve, with u = G P + u₀ the velocities there,

    0 ≤ Pₙ ⟂ uₙ + gap / h ≥ 0,   |P_T| ≤ μ Pₙ, against u_T where it slides,

in time steps of Stewart & Trinkle (1996). With De Saxcé's change of variables, u + μ |u_T| n, that
is a problem on second-order cones (Acary, Cadoux, Lemaréchal & Malick 2011): convex for a given
|u_T|, which is then renewed. The convex one is solved where the natural map P − Π(P − ρ u) is zero,
Π the projection on the cones: by Newton's method on that map (semi-smooth; Qi & Sun 1993), all
places at once, and where that does not settle by projected gradients with Nesterov's momentum
(Mazhar et al. 2015).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array

ROUNDS: Final = 100
"""Rounds of projected gradients for one guess of how fast corners slide."""

GUESSES: Final = 3
"""How often that guess is renewed."""

NEWTON: Final = 15
"""Rounds of Newton's method before projected gradients go on from the best of them."""

RIDGE: Final = 1e-5
"""Added to the slopes of Newton's method: places that carry the same share it."""

SETTLED: Final = 1e-7
"""Change of impulses, relative to the largest, at which they are known."""


ALIKE: Final = 1e-10
"""Singular value, relative to the largest, below which places that touch carry the same."""


def contact_impulses(response: Array, speeds: Array, friction: float) -> Array:
    """Return the impulses in the places that touch.

    Parameters
    ----------
    response : (3 k, 3 k) float64
        Velocities that unit impulses give (Delassus operator): symmetric, not negative.
    speeds : (k, 3) float64
        Velocities without any impulse, along the normal last; there with gap / h added.
    friction : float
        Coefficient μ.

    Returns
    -------
    (k, 3) float64
        N s.
    """
    largest = float(np.abs(response).sum(axis=1).max(initial=0.0))
    impulses = np.zeros_like(speeds)
    if largest == 0.0:
        return impulses
    holding = _holding_impulses(response, speeds, friction)
    if holding is not None:
        return holding
    lifted = np.zeros(len(speeds))
    for _ in range(GUESSES):
        wanted = speeds.copy()
        wanted[:, 2] += friction * lifted
        impulses = least_impulses(response, wanted, friction, impulses)
        moving = speeds + (response @ impulses.ravel()).reshape(-1, 3)
        slides = np.hypot(moving[:, 0], moving[:, 1])
        change = float(np.abs(slides - lifted).max())
        lifted = slides
        if change <= 1e-3 * (float(slides.max()) + 1e-6):
            break
    return impulses


def _holding_impulses(response: Array, speeds: Array, friction: float) -> Array | None:
    """Return the impulses that stop all places, if they are in the cones: what stands, stands."""
    found = np.linalg.lstsq(response, -speeds.ravel(), rcond=ALIKE)[0]
    left = float(np.abs(response @ found + speeds.ravel()).max())
    impulses: Array = np.asarray(found.reshape(-1, 3), float)
    away = float(np.abs(in_cones(impulses, friction) - impulses).max())
    small = left <= SETTLED * float(np.abs(speeds).max())
    return impulses if small and away <= SETTLED * float(np.abs(impulses).max()) else None


def least_impulses(response: Array, speeds: Array, friction: float, start: Array) -> Array:
    """Return the impulses P in the cones of friction of least energy ½ P·G P + P·u.

    Parameters
    ----------
    response, speeds, friction
        As for `contact_impulses`, without what makes the problem one of Coulomb's.
    start : (k, 3) float64
        A guess.
    """
    step = 1.0 / float(np.abs(response).sum(axis=1).max())
    found, settled = _newton_impulses(response, speeds, friction, start, step)
    return found if settled else _cone_impulses(response, speeds, friction, found, step)


def _newton_impulses(
    response: Array, speeds: Array, friction: float, start: Array, step: float
) -> tuple[Array, bool]:
    """Return the impulses at which the natural map is least, and whether it vanishes there."""
    count = len(speeds)
    unit = np.eye(3 * count)
    onward = unit - step * response
    now = best = in_cones(start, friction)
    least = np.inf
    for _ in range(NEWTON):
        aimed = now - step * (speeds + (response @ now.ravel()).reshape(-1, 3))
        left = now - in_cones(aimed, friction)
        away = float(np.abs(left).max())
        if away <= SETTLED * float(np.abs(now).max()):
            return in_cones(now, friction), True
        if away < least:
            best, least = now, away
        bent = _cone_slopes(aimed, friction) @ onward.reshape(count, 3, 3 * count)
        slopes = (1.0 + RIDGE) * unit - bent.reshape(3 * count, 3 * count)
        now = now - np.linalg.solve(slopes, left.ravel()).reshape(-1, 3)
        if not np.isfinite(now).all():
            break
    return in_cones(best, friction), False


def _cone_slopes(impulses: Array, friction: float) -> Array:
    """Return how the nearest impulses in the cones go with impulses (k, 3), (k, 3, 3)."""
    across = np.hypot(impulses[:, 0], impulses[:, 1])
    upwards = impulses[:, 2]
    ways = impulses[:, :2] / np.maximum(across, 1e-300)[:, None]
    normal = np.column_stack((friction * ways, np.ones(len(ways))))
    shared = np.asarray(np.einsum("ka,kb->kab", normal, normal) / (1.0 + friction * friction))
    length = (friction * across + upwards) / (1.0 + friction * friction)
    bend = friction * length / np.maximum(across, 1e-300)
    around = np.eye(2) - np.einsum("ka,kb->kab", ways, ways)
    shared[:, :2, :2] += bend[:, None, None] * around
    shared[across <= friction * upwards] = np.eye(3)
    shared[friction * across + upwards <= 0.0] = 0.0
    return shared


def _cone_impulses(
    response: Array, speeds: Array, friction: float, start: Array, step: float
) -> Array:
    """Return the impulses in the cones of friction of least energy (Mazhar et al. 2015)."""
    now, ahead, momentum = start, start, 1.0
    for _ in range(ROUNDS):
        slope = speeds + (response @ ahead.ravel()).reshape(-1, 3)
        following = in_cones(ahead - step * slope, friction)
        change = following - now
        if float(np.abs(following - ahead).max()) <= SETTLED * float(np.abs(following).max()):
            return following
        if float((slope * change).sum()) > 0.0:
            momentum = 1.0
        later = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum))
        ahead = following + (momentum - 1.0) / later * change
        now, momentum = following, later
    return now


def in_cones(impulses: Array, friction: float) -> Array:
    """Return the nearest impulses (k, 3) with |P_T| ≤ μ Pₙ."""
    across = np.hypot(impulses[:, 0], impulses[:, 1])
    upwards = impulses[:, 2]
    shared = np.maximum((friction * across + upwards) / (1.0 + friction * friction), 0.0)
    inside = across <= friction * upwards
    made = np.empty_like(impulses)
    made[:, 2] = np.where(inside, upwards, shared)
    scale = np.where(inside, 1.0, friction * shared / np.maximum(across, 1e-300))
    made[:, :2] = impulses[:, :2] * scale[:, None]
    return made
