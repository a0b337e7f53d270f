"""Solve cameras and shape together: a bundle adjustment over one sketch or several.

A camera that was found from the template is wrong by as much as the car differs from it, so the
cameras change together with the shape. The unknowns are the variables
of a symmetric car (`Template.basis`) and the numbers of each camera; the cost is that of
`prior`. The soundness inequalities hold at every iterate, not only at the end, for each
step is the least of a quadratic function under them (sequential quadratic programming with a
Gauss-Newton form, damped after Levenberg and Marquardt). A solve may therefore be cut short at
any time, and a solve that starts from the last car while a mark is dragged takes a few steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import cached_property
from bozzetto.view import triple
from bozzetto.view.calibration import Poses
from bozzetto_car.camera.marked_view import MOST_VIEWS, MarkedView, Reprojection, Residuals
from bozzetto_car.dimensions import NONE_BEYOND, Dimensions, Locks, Overlap
from bozzetto_car.listening import look
from bozzetto_car.solver.feasible_set import Feasible
from bozzetto_car.solver.hand import bent_by_hand
from bozzetto_car.solver.leave_one_out import LeftOut, leave_one_out
from bozzetto_car.solver.prior import Cost, Prior, robust_weights, size_measure
from bozzetto_car.solver.proportions import (
    OUTER,
    believable_size,
    outer_dimensions,
    size_of_known,
)
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness

MOST_STEPS: Final = 40
"""Most steps, taken or not. A cold solve takes six to ten."""

SETTLED: Final = 1e-6
"""Relative decrease of the cost at which a solve has converged."""

ROUGH: Final = 1e-4
"""The same of a solve for a frame of a drag."""

FIRST_DAMPING: Final = 1e-3
"""Damping at the start, as a share of the diagonal of the normal matrix."""

DAMPINGS: Final = (1e-9, 1e6)
"""Least damping, and the damping at which no step downhill is left."""

SOFTER, STIFFER = 0.1, 8.0
"""Factors of the damping after a step that was taken, and after one that was not."""

ANCHORED: Final = 1e-12
"""Term on the diagonal of the normal matrix, as a share of its largest entry: with few marks, some
numbers of a camera are undetermined."""

LONGEST_SERIES: Final = 0.9
"""Largest ratio of successive steps that is extrapolated to its limit: nine steps more."""

MOST_TIES: Final = 3
"""Most solves with another outermost node, where dimensions are locked."""


@dataclass(frozen=True, eq=False)
class JointSolution:
    """A car and the cameras of its sketches.

    Attributes
    ----------
    variables : (q,) float
        Variables of the car; `Template.whole` gives its nodes.
    views : tuple of MarkedView
        The sketches with their cameras as solved: a start for the next solve.
    residuals : tuple of (k,) float
        Distance of each mark from its node, px.
    left_out : tuple of LeftOut
        Distance of each mark from the place where the other marks expect it, px, and how
        surprising that is: the mark may be on the wrong side, or a mistake.
    cost : float
    span : (q, f) float
        Directions in which the variables are free; all, unless dimensions are locked.
    information : (f, f) float
        Information about the car along the span, with the cameras free to follow: its inverse is
        the covariance, apart from the inequalities.
    steps : int
        Number of steps, taken or not.
    """

    variables: Array
    views: tuple[MarkedView, ...]
    residuals: tuple[Array, ...]
    left_out: tuple[LeftOut, ...]
    cost: float
    span: Array
    information: Array
    steps: int


def solve(
    template: Template,
    views: Sequence[MarkedView],
    cost: Cost,
    soundness: Soundness,
    *,
    start: Array | None = None,
    locked: Dimensions | None = None,
    overlap: Overlap = NONE_BEYOND,
    hold_cameras: bool = False,
    rough: bool = False,
) -> JointSolution:
    """Find the car of some sketches, and their cameras.

    Parameters
    ----------
    template : Template
        The template of the car.
    views : sequence of MarkedView
        One to eight. Their cameras are where the solve starts; those that
        `bozzetto.view.calibration` finds from the template are good starts.
    cost : Cost
        The weights of marks and template.
    soundness : Soundness
        The inequalities that are switched on.
    start : (q,) float, optional
        Variables to start from, such as those of the last solve while a mark is dragged; by
        default the template. Where they violate an inequality or a locked dimension, the solve
        starts from the nearest car that does not.
    locked : Dimensions, optional
        Dimensions that are known.
    overlap : Overlap
        How far the surface bulges beyond the outermost nodes: locked dimensions are those of
        the surface. It hardly changes with the shape.
    hold_cameras : bool
        Leave the cameras as they are: the paper's deformation.
    rough : bool
        For a frame of a drag: the solve ends as soon as the cost hardly falls.

    Returns
    -------
    JointSolution
        Every inequality holds to 1e-9 mm, and every locked dimension to 1e-6 mm.

    Raises
    ------
    UserError
        If there is no sketch or there are too many, a camera has the car behind it, or locked
        dimensions contradict each other or the inequalities; the message names them.
    """
    if not 1 <= len(views) <= MOST_VIEWS:
        raise UserError(f"One to {MOST_VIEWS} sketches can be solved together.")
    first = template.variables if start is None else np.asarray(start, float)
    if not np.isfinite(first).all():
        raise ValueError("a solve must start from a finite car")
    settled = ROUGH if rough else SETTLED

    def problem_of(views: Sequence[MarkedView], prior: Prior, feasible: Feasible) -> _Problem:
        return _Problem(template, views, cost, prior, feasible, hold_cameras, settled)

    ready: _Problem | None = None
    if np.isfinite(cost.stiff):
        prior = Prior(template, cost)
    else:
        known = None if locked is None else size_of_known(_relative(template, locked, overlap))
        if known is None:
            # The size that is held is that of the start, and then the one that suits the shape.
            measure = size_measure(template)
            prior = Prior(template, cost, float(measure @ first))
            feasible = Feasible.of(soundness, None, first, prior.form(first))
            problem = problem_of(views, prior, feasible)
            shape, _ = problem.settled()
            seen = problem.turned(shape)
            size = believable_size(template, template.whole(shape.variables))
            grown = size * shape.variables, [_enlarged(view, size) for view in seen]
            for first, views in (grown, (shape.variables, seen)):
                prior = Prior(template, cost, float(measure @ first))
                try:
                    feasible = Feasible.of(soundness, None, first, prior.form(first))
                except UserError:  # no car beside it is sound: it stays as large as it is
                    continue
                problem = problem_of(views, prior, feasible)
                if problem.begin is not None:
                    ready = problem
                    break
        else:
            prior = Prior(template, cost, known, held=False)
    if locked is None or not locked.given():
        if ready is not None:
            return ready.solved()
        feasible = Feasible.of(soundness, None, first, prior.form(first))
        return problem_of(views, prior, feasible).solved()
    locks = Locks.of(template, locked, first, overlap)
    feasible = Feasible.of(soundness, locks, first, prior.form(first))
    best = problem_of(views, prior, feasible).solved()
    for _ in range(MOST_TIES):
        other = locks.tied(template, best.variables)
        if other is None:
            break
        # A node is level with the outermost one: the cost may be lower with it beyond.
        locks = Locks.of(template, locked, best.variables, overlap, other)
        feasible = Feasible.of(soundness, locks, best.variables, prior.form(best.variables))
        tried = problem_of(best.views, prior, feasible).solved()
        if tried.cost >= best.cost * (1.0 - SETTLED):
            break
        best = tried
    return best


def _relative(template: Template, locked: Dimensions, overlap: Overlap) -> dict[str, float]:
    """Return locked outer dimensions relative to the template's."""
    bulges = (overlap.front + overlap.rear, 2.0 * overlap.side, 0.0, overlap.top)
    own = outer_dimensions(template, template.positions) + bulges
    names = zip(OUTER, own.tolist(), strict=True)
    wanted = locked.wanted()
    return {name: wanted[name] / size for name, size in names if name in wanted}


def _enlarged(view: MarkedView, factor: float) -> MarkedView:
    """Return a sketch with the camera that sees a car, enlarged about the origin, as before."""
    camera = view.camera
    eye, target = (triple(factor * np.asarray(place)) for place in (camera.eye, camera.target))
    larger = replace(camera, eye=eye, target=target, height=factor * camera.height)
    return view.turned(larger, view.shift)


@dataclass(frozen=True, eq=False)
class _Iterate:
    """A car and its cameras, with the normal equations there.

    Attributes
    ----------
    variables : (q,) float
    poses : tuple of Poses
    bends : tuple of (b, 2) float
        What the hand bends of each sketch, along the columns of `bent_by_hand`.
    cost : float
    form : (f + c, f + c) float
        Gauss-Newton form over the free directions of the car, and for each sketch the numbers of
        its camera and its bends.
    slope : (f + c,) float
    seen : tuple of _Seen
        Each sketch.
    """

    variables: Array
    poses: tuple[Poses, ...]
    bends: tuple[Array, ...]
    cost: float
    form: Array
    slope: Array
    seen: tuple[_Seen, ...]


class _Seen(NamedTuple):
    """A sketch as an iterate has it.

    Attributes
    ----------
    missed : (k, 2) float
        Place minus mark, in diagonals of the marks.
    unbent : (k, 2) float
        The same without what the hand bends, in standard deviations of the hand.
    weights : (k,) float
    rows : (2 k, f + c) float
        Derivative by the car, the camera and the bends, in these units.
    """

    missed: Array
    unbent: Array
    weights: Array
    rows: Array


class _Problem:
    """A joint solve: the data that stay the same from step to step."""

    def __init__(
        self,
        template: Template,
        views: Sequence[MarkedView],
        cost: Cost,
        prior: Prior,
        feasible: Feasible,
        held: bool,
        settled: float,
    ) -> None:
        self.template, self.cost, self.prior, self.feasible = template, cost, prior, feasible
        self.views, self.least_gain = tuple(views), settled
        made = [Reprojection.of(template, view, held) for view in views]
        self.sights = tuple(sight for sight, _ in made)
        self.starts = tuple(pose for _, pose in made)
        self.free = feasible.span.shape[1]
        self.ways = tuple(bent_by_hand(sight, cost) for sight in self.sights)
        self.bent = tuple(np.kron(ways, np.eye(2)) for ways in self.ways)
        of_views = zip(self.sights, self.ways, strict=True)
        ends = np.cumsum([self.free, *(len(s.free) + 2 * ways.shape[1] for s, ways in of_views)])
        self.parts = tuple(map(slice, ends[:-1].tolist(), ends[1:].tolist()))
        self.size = int(ends[-1])
        # How the coordinates of each node follow the free directions, (n, 3, f).
        self.nodes = (template.basis @ feasible.span).reshape(-1, 3, self.free)

    @cached_property
    def begin(self) -> _Iterate | None:
        """The start; None where a camera has a marked node behind it."""
        return self.at(self.feasible.start, self.starts, self.straight)

    def own_form(self, variables: Array) -> Array:
        """Return the prior's part of the form over the free directions of the car, (f, f)."""
        if np.isfinite(self.cost.stiff):
            return self._within_span(self.prior.form(variables))
        return self._same_everywhere

    @cached_property
    def _same_everywhere(self) -> Array:
        return self._within_span(self.prior.form(self.prior.variables))

    def _within_span(self, form: Array) -> Array:
        span = self.feasible.span
        return np.asarray(span.T @ form @ span)

    @property
    def straight(self) -> tuple[Array, ...]:
        """Sketches that no hand bends."""
        return tuple(np.zeros((ways.shape[1], 2)) for ways in self.ways)

    def solved(self) -> JointSolution:
        """Return the car and the cameras of the least cost, with what is to be known about them."""
        return self.joint(*self.settled())

    def settled(self) -> tuple[_Iterate, int]:
        """Return the iterate at which the solve has converged, and the number of steps."""
        here = self.begin
        if here is None:
            raise UserError(
                "The camera of a sketch stands within the car. Set its marks again, or start "
                "from the template."
            )
        damping, steps = FIRST_DAMPING, 0
        last: Array | None = None
        while steps < MOST_STEPS and damping < DAMPINGS[1]:
            steps += 1
            look()
            step = self.step(here, damping)
            there = None if step is None else self.moved(here, step)
            if step is None or there is None or there.cost >= here.cost:
                damping *= STIFFER
                last = None
                continue
            gain, here = here.cost - there.cost, there
            damping = max(damping * SOFTER, DAMPINGS[0])
            if gain <= self.least_gain * here.cost:
                break
            further = None if last is None else self.moved(here, _rest(last, step))
            last = step
            if further is not None and further.cost < here.cost:
                here, last = further, None
        return here, steps

    def turned(self, here: _Iterate) -> tuple[MarkedView, ...]:
        """Return the sketches with their cameras at an iterate."""
        of_views = zip(self.views, self.sights, here.poses, strict=True)
        return tuple(view.turned(*sight.framing.camera(pose)) for view, sight, pose in of_views)

    def at(
        self, variables: Array, poses: tuple[Poses, ...], bends: tuple[Array, ...]
    ) -> _Iterate | None:
        """Return the normal equations; None where a marked node is not in front of its camera."""
        span, free = self.feasible.span, self.free
        positions = self.template.whole(variables)
        own = self.prior.form(variables)
        form = np.zeros((self.size, self.size))
        slope = np.zeros(self.size)
        form[:free, :free] = self.own_form(variables)
        slope[:free] = span.T @ (own @ (variables - self.prior.variables))
        cost = self.prior.value(variables)
        all_seen = []
        for number, (sight, pose, bend) in enumerate(zip(self.sights, poses, bends, strict=True)):
            part, ways = self.parts[number], self.ways[number]
            seen = sight.residuals(pose, positions)
            if seen is None:
                return None
            missed = (seen.missed + ways @ bend) / self.cost.hand
            weights, lost = robust_weights((missed**2).sum(axis=1), self.cost.stray)
            cost += lost
            rows = self.rows(number, seen)
            weighted = rows * np.repeat(weights, 2)[:, None]
            square, pull = weighted.T @ rows, weighted.T @ missed.ravel()
            form[:free, :free] += square[:free, :free]
            form[:free, part] = square[:free, free:]
            form[part, :free] = square[free:, :free]
            form[part, part] = square[free:, free:]
            slope[:free] += pull[:free]
            slope[part] = pull[free:]
            hold, drawn, more = sight.middle(pose)
            camera = slice(part.start, part.start + len(sight.free))
            form[camera, camera] += hold
            slope[camera] += drawn
            bending = np.arange(camera.stop, part.stop)
            form[bending, bending] += 1.0
            slope[bending] += bend.ravel()
            cost += more + float((bend**2).sum())
            all_seen.append(_Seen(seen.missed, missed, weights, rows))
        return _Iterate(variables, poses, bends, cost, form, slope, tuple(all_seen))

    def rows(self, number: int, seen: Residuals) -> Array:
        """Return the derivative of the residuals of a sketch by the car, its camera and bends."""
        rows = self.sights[number].rows(seen, self.nodes)
        return np.hstack((rows, self.bent[number])) / self.cost.hand

    def step(self, here: _Iterate, damping: float) -> Array | None:
        """Return the step (f + c,) of the normal equations; None if there is none."""
        form = here.form.copy()
        diagonal = np.arange(self.size)
        size = form[diagonal, diagonal]
        form[diagonal, diagonal] += damping * size + ANCHORED * size.max()
        return self.feasible.step(here.variables, form, here.slope)

    def moved(self, here: _Iterate, step: Array) -> _Iterate | None:
        """Return the iterate after a step; None if no car may be there."""
        variables = self.feasible.moved(here.variables, step[: self.free])
        if variables is None:
            return None
        poses, bends = [], []
        for number, (sight, part) in enumerate(zip(self.sights, self.parts, strict=True)):
            turned, bent = np.split(step[part], [len(sight.free)])
            poses.append(sight.stepped(here.poses[number], turned))
            bends.append(here.bends[number] + bent.reshape(-1, 2))
        return self.at(variables, tuple(poses), tuple(bends))

    def joint(self, here: _Iterate, steps: int) -> JointSolution:
        covariance = np.asarray(np.linalg.pinv(here.form, ANCHORED, True), float)
        residuals, others = [], []
        for number, (sight, seen) in enumerate(zip(self.sights, here.seen, strict=True)):
            unit = sight.extent * sight.framing.diagonal
            residuals.append(np.linalg.norm(seen.missed, axis=1) * unit)
            others.append(self.left_out(number, seen, covariance))
        return JointSolution(
            here.variables,
            self.turned(here),
            tuple(residuals),
            tuple(others),
            here.cost,
            self.feasible.span,
            without_cameras(here.form, self.free),
            steps,
        )

    def left_out(self, number: int, seen: _Seen, covariance: Array) -> LeftOut:
        """Return how far the marks of a sketch are from where the others expect them, px."""
        sight, part = self.sights[number], self.parts[number]
        among = np.r_[slice(0, self.free), part]
        found = leave_one_out(
            seen.rows, seen.unbent, seen.weights, covariance[np.ix_(among, among)]
        )
        unit = self.cost.hand * sight.extent * sight.framing.diagonal
        return LeftOut(found.missed * unit, found.surprise)


def _rest(last: Array, step: Array) -> Array:
    """Return the rest of the way when steps shrink like a geometric series (Aitken 1926).

    The quadratic form ignores how the projection curves while the shape slides along what the
    marks allow, so that close tracing converges in ever shorter steps in one direction.
    """
    size = float(last @ last)
    ratio = min(max(float(step @ last) / size, 0.0), LONGEST_SERIES) if size > 0.0 else 0.0
    return step * (ratio / (1.0 - ratio))


def without_cameras(form: Array, free: int) -> Array:
    """Return the form over the car alone, (f, f), with the cameras free: the Schur complement."""
    cross, cameras = form[:free, free:], form[free:, free:]
    if not cameras.size:
        return form
    # The pseudo-inverse, because few marks leave some numbers of a camera undetermined.
    return np.asarray(form[:free, :free] - cross @ np.linalg.pinv(cameras, 1e-12, True) @ cross.T)
