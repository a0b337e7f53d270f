"""Time steps that keep lengths and energy: RATTLE on rigid bodies (Andersen 1983).

A step of length h from x₀, v₀ finds impulses μ along the slopes of the gaps at its start such that
all gaps are closed at its end, then takes away velocities along the slopes there:

    v½ = v₀ + h/2 M⁻¹ F(x₀) + M⁻¹ J₀ᵀ μ,   x₁ = x₀ + h v½,   gap(x₁) = 0,
    v₁ = v½ + h/2 M⁻¹ F(x₁) + M⁻¹ J₁ᵀ λ,   J₁ v₁ = 0.

Rotations keep angular momentum: they turn by the angular velocity at the middle of the step. What
touches gives its impulses twice: before bodies move, so that nothing ends in something else, and
where they have come to, so that what landed stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.mechanism.acceleration import Acceleration
from bozzetto_polyhedron.mechanism.analysis import weights
from bozzetto_polyhedron.mechanism.assembly import Assembly, Motion
from bozzetto_polyhedron.mechanism.constraints import BandedSystem, Factored
from bozzetto_polyhedron.mechanism.gaps import Gaps, Slopes
from bozzetto_polyhedron.mechanism.rotations import nearest_rotations, rotations_by
from bozzetto_polyhedron.mechanism.springs import spring_energy, spring_forces
from bozzetto_polyhedron.mechanism.touches import Touching

LONGEST: Final = 1.0 / 120.0
"""Longest step, s: with 1/60 s and no damping a swinging chain gained twice its energy."""

STEEPEST: Final = 0.15
"""Largest turn in a step, rad: with twice that a double pendulum lost a tenth of its energy."""

ROUNDS: Final = 25
"""Rounds in which gaps are closed before a step is halved."""

PATIENCE: Final = 3
"""Rounds after which gaps must have become much smaller, or the step is halved."""

SLOW: Final = 0.3
"""Share of a gap that may be left after so many rounds."""

HALVINGS: Final = 5
"""How often a step is halved before everything stands still rather than tears."""

SETTLED: Final = 1e-9
"""Change of a turn between two rounds, rad, at which the middle of a step is known."""

STRAINED: Final = 10.0
"""Share of velocity that what a pen pulls at loses per second, 1/s, where it is far beyond reach:
one weight at 1 m/s, of the eight with which the pen pulls."""

TORN: Final = 0.5
"""Gap, in extents of the mechanism, from which on there is no hope of closing it in this step."""


@dataclass(frozen=True, eq=False)
class Pull:
    """The pen that holds a body by a spring.

    Parameters
    ----------
    body : int
    point : (3,) float64
        Where it holds it, in the frame of the body, m.
    target : (3,) float64
        Where the pen is, m.
    stiffness : float
        N/m.
    damping : float
        N s/m.
    limit : float
        Largest force, N.
    """

    body: int
    point: Array
    target: Array
    stiffness: float
    damping: float
    limit: float


@dataclass(frozen=True, eq=False)
class _Pose:
    """Masses and factored joints of a pose, for steps of one length.

    Parameters
    ----------
    inverse : (n, 6, 6) float64
        Inverse masses in the world.
    softened : (n, 6, 6) float64
        The same with the pen's spring, which adds to the mass of what it holds.
    """

    h: float
    inertias: Array
    inverse: Array
    softened: Array
    slopes: Slopes
    factored: Factored


class Stepper:
    """Moves one assembly.

    Parameters
    ----------
    assembly : Assembly
    damping : float
        Share of velocity lost per second, 1/s.
    tolerance : float
        Largest gap, m.
    """

    def __init__(
        self, assembly: Assembly, *, damping: float = 0.0, tolerance: float = 1e-8
    ) -> None:
        self.assembly = assembly
        self.damping = damping
        self.tolerance = tolerance
        self._gaps = Gaps(assembly.joints)
        self._system = BandedSystem(assembly)
        self._freedoms = assembly.freedoms
        self._inverse_inertias = np.linalg.pinv(assembly.inertias, rcond=1e-9, hermitian=True)
        meeting = (assembly.ground, assembly.colliding, assembly.stops)
        meets = any(each is not None for each in meeting)
        self._touching = Touching(assembly) if meets else None
        # What spins after a corner hit something must not turn through it within a step.
        self._careful = HALVINGS if assembly.colliding is not None else HALVINGS - 2

    def advanced(self, motion: Motion, seconds: float, pull: Pull | None = None) -> Motion:
        """Return the motion some time later; where it cannot go on it stops before that time."""
        count = max(1, int(np.ceil(seconds / LONGEST - 1e-9)))
        pose = None
        for _ in range(count):
            motion, pose = self._stepped(motion, pose, seconds / count, pull, 0)
        return replace(motion, turns=nearest_rotations(motion.turns))

    def settled(self, motion: Motion) -> Motion:
        """Return the same pose with the nearest velocities that open no gap."""
        return self._without_opening(motion, self._pose(motion, None, 0.0))

    def closed(self, motion: Motion) -> Motion:
        """Return the nearest pose in which all gaps are closed, as far as that can be."""
        for _ in range(ROUNDS):
            gaps = self._gaps.at(motion.places, motion.turns, motion.time)
            if not len(gaps) or np.abs(gaps).max() < self.tolerance:
                break
            factored = self._pose(motion, None, 0.0).factored
            moved = factored.velocities(factored.impulses(-gaps))
            motion = replace(
                motion,
                places=motion.places + moved[:, :3],
                turns=rotations_by(moved[:, 3:]) @ motion.turns,
            )
        return motion

    def gaps(self, motion: Motion) -> Array:
        """Return the gaps of all rows of the joints, (m,), m or rad."""
        return self._gaps.at(motion.places, motion.turns, motion.time)

    def beyond_stops(self, motion: Motion) -> float:
        """Return how far a hinge is beyond an end of its way, rad; 0 where none is."""
        stops = self.assembly.stops
        if stops is None:
            return 0.0
        return float((np.abs(stops.angles(motion)) - stops.reach).max(initial=0.0))

    def largest_gap(self, motion: Motion) -> float:
        """Return the largest gap, m or rad."""
        return float(np.abs(self.gaps(motion)).max(initial=0.0))

    def energy(self, motion: Motion) -> float:
        """Return kinetic and potential energy, J."""
        assembly = self.assembly
        velocities = self._velocities(motion, self._inverse(motion.turns))
        moving = (assembly.masses * (motion.velocities**2).sum(axis=1)).sum()
        turning = (velocities[:, 3:] * motion.momenta).sum()
        height = (assembly.masses * (motion.places @ assembly.gravity)).sum()
        return float(0.5 * (moving + turning) - height) + spring_energy(assembly.springs, motion)

    def loads(self, motion: Motion) -> Array:
        """Return weights, springs and what carries them at rest, (n, 6) N and N m."""
        still = motion.stopped()
        forces, moments = spring_forces(self.assembly.springs, still)
        loads = weights(self.assembly) + np.concatenate((forces, moments), axis=1)
        if self._touching is None:
            return np.asarray(loads)
        pose = self._pose(still, None, LONGEST)
        kicked = self._without_opening(self._kicked(still, LONGEST), pose)
        velocities = self._velocities(kicked, pose.inverse)
        joints = pose.slopes, pose.factored
        pushed = self._touching.impulses(kicked, velocities, pose.inverse, joints, LONGEST)[1]
        return np.asarray(loads + pushed / LONGEST)

    def turning(self, motion: Motion) -> Array:
        """Return the angular velocities of all bodies, (n, 3) rad/s."""
        return self._turning(motion.turns, motion.momenta)

    def pushed(self, motion: Motion, velocities: Array) -> Motion:
        """Return the motion with further velocities (n, 6), m/s and rad/s."""
        return _pushed(motion, self._pose(motion, None, 0.0), velocities)

    # -- one step --

    def _stepped(
        self, motion: Motion, pose: _Pose | None, h: float, pull: Pull | None, depth: int
    ) -> tuple[Motion, _Pose | None]:
        """Return the motion after a step, and what is known about its end."""
        if pose is None or pose.h != h:
            pose = self._pose(motion, pull, h)
        kicked = self._kicked(motion, 0.5 * h)
        if pull is not None:
            kicked = self._pulled(kicked, pose, pull)
        kicked = self._without_opening(kicked, pose)
        kicked = self._kept_apart(kicked, pose, h)
        moved = self._moved(kicked, pose, depth < self._careful)
        if moved is None:
            if depth == HALVINGS:
                return motion.stopped(), None
            half, known = self._stepped(motion, None, 0.5 * h, pull, depth + 1)
            return self._stepped(half, known, 0.5 * h, pull, depth + 1)
        end = self._kicked(moved, 0.5 * h)
        left = float(np.exp(-(self.damping + _strained(motion, pull)) * h))
        end = replace(end, velocities=end.velocities * left, momenta=end.momenta * left)
        known = self._pose(end, pull, h)
        end = self._without_opening(end, known)
        return self._kept_apart(end, known, 0.0), known

    def _moved(self, motion: Motion, pose: _Pose, careful: bool) -> Motion | None:
        """Return the pose after a step with all gaps closed; None where they cannot be.

        A careful step is not longer than it may be for what turns fastest.
        """
        h = pose.h
        impulses = np.zeros(len(self.assembly.joints))
        turning = self._velocities(motion, pose.inverse)[:, 3:]
        if careful and float(np.linalg.norm(turning, axis=1).max(initial=0.0)) * h > STEEPEST:
            return None
        extent = 1.0 + float(np.abs(motion.places).max(initial=0.0))
        guess, expected = Acceleration(), np.inf
        for number in range(ROUNDS):
            given = pose.factored.velocities(impulses)
            velocities = motion.velocities + given[:, :3]
            momenta = motion.momenta + np.einsum("nij,nj->ni", pose.inertias, given[:, 3:])
            before = turning
            turning = self._turning(rotations_by(0.5 * h * turning) @ motion.turns, momenta)
            places = motion.places + h * velocities
            turns = rotations_by(h * turning) @ motion.turns
            gaps = self._gaps.at(places, turns, motion.time + h)
            largest = float(np.abs(gaps).max(initial=0.0))
            settled = float(np.abs(turning - before).max(initial=0.0)) * h
            if largest < self.tolerance and settled < max(self.tolerance, SETTLED):
                return Motion(places, turns, velocities, momenta, motion.time + h)
            if number % PATIENCE == 0:
                if not largest < min(expected, TORN * extent):
                    return None
                expected = max(SLOW * largest, self.tolerance)
            impulses = guess.after(impulses, pose.factored.impulses(-gaps / h))
        return None

    def _kicked(self, motion: Motion, h: float) -> Motion:
        """Return the motion after gravity and springs have acted for a while."""
        assembly = self.assembly
        forces, moments = spring_forces(assembly.springs, motion)
        forces = forces / assembly.masses[:, None] + assembly.gravity
        return replace(
            motion,
            velocities=motion.velocities + h * forces * self._freedoms[:3],
            momenta=motion.momenta + h * moments * self._freedoms[3:],
        )

    def _pulled(self, motion: Motion, pose: _Pose, pull: Pull) -> Motion:
        """Return the motion after the pen has pulled, implicitly: a stiff spring stays calm."""
        slope = _slope_at(motion, pull) * self._freedoms
        velocity = self._velocities(motion, pose.inverse)[pull.body]
        place = motion.places[pull.body] + motion.turns[pull.body] @ pull.point
        speed = slope @ velocity
        away = pull.target - place - pose.h * speed
        force = pull.stiffness * away - pull.damping * speed
        size = float(np.linalg.norm(force))
        force *= min(1.0, pull.limit / size) if size > 0.0 else 1.0
        given = np.zeros((len(motion.places), 6))
        given[pull.body] = pose.softened[pull.body] @ (slope.T @ (pose.h * force))
        return _pushed(motion, pose, given)

    def _without_opening(self, motion: Motion, pose: _Pose) -> Motion:
        """Return the motion without the velocities that would open gaps."""
        if not len(self.assembly.joints):
            return motion
        for _ in range(2):
            velocities = self._velocities(motion, pose.inverse)
            rates = self._gaps.rates(pose.slopes, velocities, motion.time)
            motion = _pushed(motion, pose, pose.factored.velocities(pose.factored.impulses(-rates)))
        return motion

    def _kept_apart(self, motion: Motion, pose: _Pose, h: float) -> Motion:
        """Return the motion after all that touches has answered; see `Touching.impulses`."""
        if self._touching is None:
            return motion
        given, _ = self._touching.impulses(
            motion,
            self._velocities(motion, pose.inverse),
            pose.softened,
            (pose.slopes, pose.factored),
            h,
        )
        return _pushed(motion, pose, given)

    # -- masses --

    def _pose(self, motion: Motion, pull: Pull | None, h: float) -> _Pose:
        inverse = softened = self._inverse(motion.turns)
        if pull is not None:
            slope = _slope_at(motion, pull) * self._freedoms
            weight = h * h * pull.stiffness + h * pull.damping
            own = inverse[pull.body]
            soft = np.eye(3) / weight + slope @ own @ slope.T
            softened = inverse.copy()
            softened[pull.body] = own - own @ slope.T @ np.linalg.solve(soft, slope @ own)
        slopes = self._gaps.slopes(motion.places, motion.turns, self._freedoms)
        inertias = motion.turns @ self.assembly.inertias @ np.swapaxes(motion.turns, 1, 2)
        factored = self._system.factored(slopes, softened)
        return _Pose(h, inertias, inverse, softened, slopes, factored)

    def _inverse(self, turns: Array) -> Array:
        """Return the inverse masses of all bodies in the world, (n, 6, 6)."""
        made = np.zeros((len(turns), 6, 6))
        axes = np.arange(3)
        made[:, axes, axes] = 1.0 / self.assembly.masses[:, None]
        made[:, 3:, 3:] = turns @ self._inverse_inertias @ np.swapaxes(turns, 1, 2)
        return made * self._freedoms[:, None] * self._freedoms

    def _turning(self, turns: Array, momenta: Array) -> Array:
        """Return angular velocities, (n, 3) rad/s."""
        own = np.einsum("nji,nj->ni", turns, momenta)
        own = np.einsum("nij,nj->ni", self._inverse_inertias, own)
        return np.asarray(np.einsum("nij,nj->ni", turns, own) * self._freedoms[3:])

    def _velocities(self, motion: Motion, inverse: Array) -> Array:
        turning = np.einsum("nij,nj->ni", inverse[:, 3:, 3:], motion.momenta)
        return np.concatenate((motion.velocities, turning), axis=1)


def _pushed(motion: Motion, pose: _Pose, given: Array) -> Motion:
    """Return the motion with changes of velocities (n, 6)."""
    turned = np.einsum("nij,nj->ni", pose.inertias, given[:, 3:])
    return replace(
        motion, velocities=motion.velocities + given[:, :3], momenta=motion.momenta + turned
    )


def _strained(motion: Motion, pull: Pull | None) -> float:
    """Return the share of velocity that is lost per second since the pen is beyond reach, 1/s.

    What it holds swings there like a pendulum about the place that is nearest to it, for the limit
    leaves nothing of what damps it; and all between that and what stands still like a taut string.
    """
    if pull is None:
        return 0.0
    place = motion.places[pull.body] + motion.turns[pull.body] @ pull.point
    wanted = pull.stiffness * float(np.linalg.norm(pull.target - place))
    return STRAINED * (1.0 - pull.limit / wanted) if wanted > pull.limit else 0.0


def _slope_at(motion: Motion, pull: Pull) -> Array:
    """Return how the place that the pen holds moves with the six velocities of its body, (3, 6)."""
    arm = motion.turns[pull.body] @ pull.point
    turn = np.array([[0.0, arm[2], -arm[1]], [-arm[2], 0.0, arm[0]], [arm[1], -arm[0], 0.0]])
    return np.hstack((np.eye(3), turn))
