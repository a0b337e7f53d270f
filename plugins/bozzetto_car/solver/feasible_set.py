"""The set of allowed cars: sound, and with the dimensions that are known.

The linear inequalities bound a convex set, and a step that keeps them at its end keeps them all
the way. The inequalities against folds are quadratic. A step linearizes them and may use up only
a part of their slack; where the rest does not cover the curvature, the step is refused. A shorter
step then succeeds, because the curvature falls with the square of its length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto_car.dimensions import Locks
from bozzetto_car.solver.quadratic_program import Contradiction, constrained_minimum
from bozzetto_car.template.shape_constraints import Soundness

VIOLATED: Final = 1e-10
"""Negative slack, mm, that counts as a violation. Rounding on a car of 5000 mm is a hundredth of
it."""

USABLE: Final = 0.9
"""Share of the slack of a fold that the linear part of a step may use up."""

MOST_RETURNS: Final = 20
"""Most steps from a start that violates inequalities to a car where all hold."""

MOST_NAMED: Final = 3
"""Inequalities that a message names."""


@dataclass(frozen=True, eq=False)
class Feasible:
    """The set of allowed cars.

    Attributes
    ----------
    soundness : Soundness
    bounds : (m, q) float
        More linear inequalities: ``bounds @ variables >= 0``.
    span : (q, f) float
        Orthonormal directions in which the locked dimensions do not change.
    start : (q,) float
        A car of the set.
    """

    soundness: Soundness
    bounds: Array
    span: Array
    start: Array

    @classmethod
    def of(cls, soundness: Soundness, locks: Locks | None, near: Array, form: Array) -> Feasible:
        """Return the set, with the allowed car in it that is nearest to a given one.

        Parameters
        ----------
        soundness : Soundness
            The inequalities that are switched on.
        locks : Locks, optional
            The locked dimensions.
        near : (q,) float
            Variables of the given car. It is taken as it is where it is allowed.
        form : (q, q) float
            The quadratic form that measures nearness.

        Raises
        ------
        UserError
            If there is no such car; the inequalities that contradict are named.
        """
        if locks is None:
            bounds, span, first = np.zeros((0, len(near))), np.eye(len(near)), near
        else:
            span, first = _with_locks(locks, near, form)
            bounds = locks.bounds
        made = cls(soundness, bounds, span, first)
        inner = span.T @ form @ span
        straight = made._straight()
        # Contradictions of the linear inequalities are certain, so these come first.
        for which in (straight, np.ones(len(straight), bool)):
            for _ in range(MOST_RETURNS):
                slacks = made._slacks(first)[which]
                if slacks.min(initial=0.0) >= -VIOLATED:
                    break
                pull = span.T @ (form @ (first - near))
                rows = made._jacobian(first)[which] @ span
                try:
                    step = constrained_minimum(inner, pull, rows, -slacks)
                except Contradiction as found:
                    named = np.flatnonzero(which)[found.rows].tolist()
                    raise UserError(_contradiction(soundness, named)) from None
                except np.linalg.LinAlgError:
                    raise UserError(
                        _contradiction(soundness, [int(made._slacks(first).argmin())])
                    ) from None
                first = first + span @ step.place
            else:
                worst = np.argsort(made._slacks(first)).tolist()
                raise UserError(_contradiction(soundness, worst[:MOST_NAMED]))
        return cls(soundness, bounds, span, first)

    def step(self, variables: Array, form: Array, slope: Array) -> Array | None:
        """Return the step to the least of a quadratic function while the car stays allowed.

        Parameters
        ----------
        variables : (q,) float
            An allowed car.
        form, slope : (f + c, f + c) and (f + c,) float
            The quadratic function over the span and c numbers without bounds.

        Returns
        -------
        (f + c,) float or None
            None if rounding leaves no step at all: try again with a stiffer form.
        """
        slacks = np.maximum(self._slacks(variables), 0.0)
        slacks[~self._straight()] *= USABLE
        rows = np.zeros((len(slacks), len(slope)))
        rows[:, : self.span.shape[1]] = self._jacobian(variables) @ self.span
        try:
            return constrained_minimum(form, slope, rows, -slacks).place
        except (Contradiction, np.linalg.LinAlgError):
            return None

    def moved(self, variables: Array, step: Array) -> Array | None:
        """Return the car after a step (f,) within the span; None if it is not allowed."""
        moved = variables + self.span @ step
        allowed = self._slacks(moved).min(initial=0.0) >= -VIOLATED
        return np.asarray(moved) if allowed else None

    def _straight(self) -> Flags:
        """Which of the inequalities are linear, (m,)."""
        linear, named = len(self.soundness.matrix), len(self.soundness.names)
        number = np.arange(named + len(self.bounds))
        return np.asarray((number < linear) | (number >= named))

    def _slacks(self, variables: Array) -> Array:
        return np.concatenate((self.soundness.slacks(variables), self.bounds @ variables))

    def _jacobian(self, variables: Array) -> Array:
        return np.vstack((self.soundness.jacobian(variables), self.bounds))


def _with_locks(locks: Locks, near: Array, form: Array) -> tuple[Array, Array]:
    """Return free directions (q, f), and the nearest car that has the locked dimensions."""
    # The trailing right singular vectors leave the rows as they are.
    _, sizes, turned = np.linalg.svd(locks.rows)
    rank = int((sizes > 1e-9).sum())
    span = turned[rank:].T
    toward = np.linalg.solve(form, locks.rows.T)
    lacking = locks.values - locks.rows @ near
    first = near + toward @ np.linalg.lstsq(locks.rows @ toward, lacking, rcond=None)[0]
    if np.abs(locks.rows @ first - locks.values).max(initial=0.0) > 1e-6:
        raise UserError("The locked dimensions contradict each other. Unlock one of them.")
    return span, first


def _contradiction(soundness: Soundness, rows: list[int]) -> str:
    names = [soundness.names[row] for row in rows if row < len(soundness.names)]
    kept_names = ", ".join(f"“{name}”" for name in list(dict.fromkeys(names))[:MOST_NAMED])
    if not kept_names:
        return "No car has these dimensions. Change one of them."
    return (
        f"No car has these dimensions and keeps {kept_names}. Change a dimension, or switch one of "
        "these off."
    )
