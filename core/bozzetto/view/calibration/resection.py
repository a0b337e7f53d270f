"""The camera of a picture from known points and their marks: resection, as surveyors call it.

The camera has square pixels, no skew, and its principal point in the middle of the picture
unless the picture is cropped. It is looked for from all around, so that it needs no guess; by
robust least squares, so that one wrong mark does not spoil it; and once as a perspective and
once as an orthographic camera, of which the marks choose.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.view.calibration.initial_guesses import resume_poses, starts
from bozzetto.view.calibration.input_checks import framed
from bozzetto.view.calibration.levenberg_marquardt import (
    HAND,
    STRAY,
    Adjusted,
    covariance,
    fit_poses,
    freedom,
    variance,
)
from bozzetto.view.calibration.normalization import Framing
from bozzetto.view.calibration.outliers import REMAINING, Scrutiny, set_outliers_aside
from bozzetto.view.calibration.pose import Poses
from bozzetto.view.camera import Camera

Kind = Literal["perspective", "orthographic"]

KINDS: Final[tuple[Kind, ...]] = ("perspective", "orthographic")
"""All kinds; the one with more freedom first."""

CANDIDATES: Final = 8
"""Starts of each kind that are adjusted at all."""

FIRST_STEPS: Final = 6
"""Steps after which the better ones are told."""

FINALISTS: Final = 2
"""Starts of each kind that are adjusted to the end."""

STEPS: Final = 60
"""Most steps to the end; a usual camera takes five to ten."""

LOST: Final = 7.0 * STRAY
"""Median distance of the marks, in diagonals, at which a camera that was resumed has lost its
way and is looked for from all around: 30 px of 1200."""

BACK: Final = 15.0 * HAND
"""Residual, diagonals, at which a mark that was set aside gets another hearing: more than a
mark must be off at least to be set aside, so that none is lost for good."""

EXACT: Final = 1e-4
"""Standard deviation, diagonals, below which marks count as exact when kinds are compared:
what is less than a seventh of a pixel of 1200 proves no perspective."""


@dataclass(frozen=True, eq=False)
class Resection:
    """A camera that was found from marks.

    Attributes
    ----------
    camera : Camera
        Its canvas is as large as the picture, its principal point in the middle.
    shift : (dx, dy)
        Pixels of the picture are those of the camera plus this: (0, 0) unless the picture is
        cropped. So a cropped picture needs no other camera: it is laid on the camera's canvas,
        moved by minus the shift.
    residuals : (n, 2) float
        Mark minus place, px; NaN where the point of a mark that was set aside is at or behind
        the eye or next to it.
    leave_one_out : (n, 2) float
        Mark minus its place by the camera of the other marks, px; infinite where that camera
        has it at or behind its eye.
    disagreeing : tuple of int
        Marks that were set aside because the others contradict them, the worst first. They
        have no part in the camera.
    deviation : float
        Standard deviation of a coordinate of a mark, px, as the residuals and what is known
        of hands say.
    scores : mapping of kind to float
        For each kind that was tried the price of its misfit and its parameters (Bayesian
        information criterion); the camera is the one with the lower. A difference of 10 is
        beyond doubt (Kass & Raftery 1995, section 3.2).
    framing, pose, covariance
        The same in the units in which it was solved: for `prediction`, and to go on from.
        The covariance is that of the nine parameters, (9, 9).
    """

    camera: Camera
    shift: tuple[float, float]
    residuals: Array
    leave_one_out: Array
    disagreeing: tuple[int, ...]
    deviation: float
    scores: Mapping[Kind, float]
    framing: Framing
    pose: Poses
    covariance: Array

    def project(self, points: ArrayLike) -> Array:
        """Project world points (m, 3), mm, to places (m, 2) in pixels of the picture.

        NaN for points at or behind the eye.
        """
        return np.asarray(self.camera.project(points)[0] + self.shift)

    @property
    def rms(self) -> float:
        """Root mean square distance of the marks that count from their places, px."""
        counts = np.ones(len(self.residuals), bool)
        counts[list(self.disagreeing)] = False
        return float(np.sqrt(np.mean(np.sum(self.residuals[counts] ** 2, axis=1))))


def resect(
    points: ArrayLike,
    marks: ArrayLike,
    picture: tuple[float, float],
    *,
    kind: Kind | Literal["auto"] = "auto",
    cropped: bool = False,
    further: Mapping[str, ArrayLike] | None = None,
    before: Resection | None = None,
) -> Resection:
    """Find the camera that sees known points at their marks.

    Parameters
    ----------
    points : (n, 3) array_like
        World points, mm, n ≥ 6.
    marks : (n, 2) array_like
        Their places, px from the top left corner; they may lie beside the picture.
    picture : (width, height)
        px.
    kind : {"auto", "perspective", "orthographic"}
        "auto" takes the orthographic camera unless perspective is worth its parameter.
    cropped : bool
        Whether the picture is a part of a larger one, so that the principal point may be
        anywhere about the middle. Otherwise keep it off: a free principal point swallows
        what the points have wrong, and turns the camera for it.
    further : mapping of str to (3,) array_like, optional
        Points that could be marked, by names. If the marks are too few or lie in a plane, the
        message names the one that helps most.
    before : Resection, optional
        Result for marks that have changed little since, while one of them is dragged, say:
        the search starts there and nowhere else, unless that leads nowhere, and the kind of
        the camera stays what it was. Ask without it once the marks have come to rest.

    Raises
    ------
    UserError
        If there are fewer than six marks of different points, the points lie in one plane,
        the marks in one place, or a number is not finite or beyond all sense.
    """
    world, places, framing = framed(points, marks, picture, further or {})
    known, seen = framing.points(world), framing.marks(places)
    found = None
    if before is not None and kind in ("auto", before.camera.kind):
        found = _resumed(known, seen, cropped, before)
    if found is not None:
        tried = [found.fit]
    else:
        fits = _searched(known, seen, KINDS if kind == "auto" else (kind,), cropped)
        # The camera with more freedom is the one that can tell which marks are wrong.
        found = set_outliers_aside(known, seen, fits[0], cropped=cropped)
        tried = [found.fit]
        for fit in fits[1:]:
            if found.aside:
                counted = found.counted[None]
                fit = fit_poses(known, seen, fit.poses, counted, cropped=cropped, steps=STEPS)
            tried.append(fit)
    count = int(found.counted.sum())
    prices = [_price(fit, count, cropped) for fit in tried]
    best = int(np.argmin(prices))
    if best:
        found = set_outliers_aside(known, seen, tried[best], found.aside, cropped=cropped)
    scores = {_kind(fit): price for fit, price in zip(tried, prices, strict=True)}
    return _described(known, framing, found, cropped, scores)


def _searched(
    points: Array, marks: Array, kinds: tuple[Kind, ...], cropped: bool
) -> list[Adjusted]:
    """Return the best pose of each kind, from starts all around."""
    begun = starts(points, marks)
    every = np.ones((len(begun), len(points)))
    costs = fit_poses(points, marks, begun, every, cropped=cropped, steps=0).costs
    flat = begun.perspectivity == 0.0
    rows = [_cheapest(costs, flat == (kind == "orthographic"), CANDIDATES) for kind in kinds]
    chosen = np.concatenate(rows)
    near = fit_poses(
        points, marks, begun[chosen], every[chosen], cropped=cropped, steps=FIRST_STEPS
    )
    flat = near.poses.perspectivity == 0.0
    rows = [_cheapest(near.costs, flat == (kind == "orthographic"), FINALISTS) for kind in kinds]
    chosen = np.concatenate(rows)
    last = fit_poses(points, marks, near.poses[chosen], every[chosen], cropped=cropped, steps=STEPS)
    sound = last[np.flatnonzero(np.isfinite(last.costs))]
    if not len(sound.poses):
        raise UserError(
            "No camera sees all these points at their marks. Check which point each "
            "mark belongs to."
        )
    flat = sound.poses.perspectivity == 0.0
    rows = [_cheapest(sound.costs, flat == (kind == "orthographic"), 1) for kind in kinds]
    return [sound[row] for row in rows if len(row)]


def _resumed(points: Array, marks: Array, cropped: bool, before: Resection) -> Scrutiny | None:
    """Return the pose next to one found before; None if it does not fit any more.

    Marks that were set aside stay so while they are still off: then nothing has to be found
    out again.
    """
    for aside in dict.fromkeys((before.disagreeing, ())):
        if max(aside, default=0) >= len(points) or len(points) - len(aside) < REMAINING:
            continue
        counted = np.ones((1, len(points)))
        counted[0, list(aside)] = 0.0
        good = counted[0] > 0.0
        begun = resume_poses(points[good], marks[good], before.pose, cropped)
        fit = fit_poses(points, marks, begun, counted, cropped=cropped, steps=STEPS)
        off = np.linalg.norm(fit.residuals[0], axis=1)
        if np.isfinite(fit.costs[0]) and np.median(off) < LOST and (off[list(aside)] > BACK).all():
            return set_outliers_aside(points, marks, fit, aside, cropped=cropped)
    return None


def _cheapest(costs: Array, allowed: Flags, count: int) -> Index:
    """Return rows with the least costs among those allowed."""
    return np.argsort(np.where(allowed, costs, np.inf), kind="stable")[: min(count, allowed.sum())]


def _kind(fit: Adjusted) -> Kind:
    return "perspective" if fit.poses.perspectivity[0] > 0.0 else "orthographic"


def _price(fit: Adjusted, count: int, cropped: bool) -> float:
    """Return the Bayesian information criterion of a fit whose noise is not known."""
    size = 2 * count
    unknowns = int(freedom(fit.poses, cropped).sum())
    noise = max(float(fit.costs[0]) / size, EXACT**2)
    return float(size * np.log(noise) + unknowns * np.log(size))


def _described(
    points: Array, framing: Framing, found: Scrutiny, cropped: bool, scores: dict[Kind, float]
) -> Resection:
    """Return the result in pixels."""
    fit, counted = found.fit, found.counted
    pose, count = fit.poses, int(counted.sum())
    unknowns = int(freedom(pose, cropped).sum())
    noise = variance(float(fit.costs[0]), count, unknowns)
    camera, shift = framing.camera(pose)
    size = framing.diagonal
    before_eye = pose.before_eye(points)[0]
    return Resection(
        camera,
        shift,
        np.where(before_eye[:, None], size * fit.residuals[0], np.nan),
        size * found.leave_one_out,
        found.aside,
        size * float(np.sqrt(noise)),
        scores,
        framing,
        pose,
        covariance(fit, points, counted, noise, cropped=cropped),
    )
