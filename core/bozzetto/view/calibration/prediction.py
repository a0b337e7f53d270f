"""Predicted places of further points in the picture, their uncertainty, and the best next mark."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.view.calibration.input_checks import REACH

if TYPE_CHECKING:
    from bozzetto.view.calibration.resection import Resection


@dataclass(frozen=True, eq=False)
class Places:
    """Predicted places of points, and their uncertainty.

    Attributes
    ----------
    pixels : (m, 2) float
        Pixels of the picture; NaN for points behind the eye or next to it, or beyond all bounds.
    covariances : (m, 2, 2) float
        Covariances of the places, px², for what the camera is unsure of; a hand that marks
        them adds its own noise. NaN likewise.
    """

    pixels: Array
    covariances: Array

    def ellipses(self, probability: float = 0.9) -> Array:
        """Return semi-axes of the ellipses in which the places lie with a probability.

        Returns
        -------
        (m, 2, 2) float
            For each place the longer and the shorter semi-axis as vectors, px.

        Raises
        ------
        UserError
            If the probability is not between 0 and 1.
        """
        if not 0.0 < probability < 1.0:
            raise UserError("An ellipse needs a probability between 0 and 1.")
        radius = np.sqrt(-2.0 * np.log1p(-probability))  # two normal deviates: Rayleigh
        known = np.asarray(np.isfinite(self.covariances).all(axis=(1, 2)))
        sizes, axes = np.linalg.eigh(np.where(known[:, None, None], self.covariances, 0.0))
        lengths = radius * np.sqrt(np.maximum(sizes, 0.0))
        vectors = (np.swapaxes(axes, 1, 2) * lengths[:, :, None])[:, ::-1]
        return np.where(known[:, None, None], vectors, np.nan)


@dataclass(frozen=True, eq=False)
class Help:
    """Gain in certainty by a further mark.

    Attributes
    ----------
    best : int or None
        The candidate after which the places of all candidates are surest; None if none is
        before the eye.
    before : float
        Root mean square standard deviation of a candidate's place now, px.
    after : (m,) float
        The same once a candidate is marked; infinite for one at or behind the eye.
    """

    best: int | None
    before: float
    after: Array


def predicted(found: Resection, points: ArrayLike) -> Places:
    """Predict where points will be seen.

    Parameters
    ----------
    found : Resection
        The calibrated camera.
    points : (m, 3) array_like
        World points, mm.
    """
    slopes, pixels, known = _seen(found, points)
    size = found.framing.diagonal
    made = size**2 * (slopes @ found.covariance @ np.swapaxes(slopes, 1, 2))
    places = np.where(known[:, None], pixels, np.nan)
    return Places(places, np.where(known[:, None, None], made, np.nan))


def most_helpful(found: Resection, candidates: ArrayLike) -> Help:
    """Find the further mark that makes the predicted places of all candidates most certain.

    A mark adds to what is known of the camera; by how much does not depend on where it will
    be set, so that it can be said beforehand (A-optimal design).

    Parameters
    ----------
    found : Resection
        The calibrated camera.
    candidates : (m, 3) array_like
        World points that could be marked, mm.
    """
    slopes, _, known = _seen(found, candidates)
    if not known.any():
        return Help(None, 0.0, np.full(len(known), np.inf))
    size, covariance = found.framing.diagonal, found.covariance
    worth = np.einsum("mip,miq->pq", slopes[known], slopes[known]) / int(known.sum())
    now = float(np.trace(covariance @ worth))
    carried = slopes @ covariance
    noise = (found.deviation / size) ** 2 * np.eye(2)
    gained = np.linalg.solve(
        noise + carried @ np.swapaxes(slopes, 1, 2), carried @ worth @ np.swapaxes(carried, 1, 2)
    )
    left = np.maximum(now - np.trace(gained, axis1=1, axis2=2), 0.0)
    after = np.where(known, size * np.sqrt(left), np.inf)
    return Help(int(np.argmin(after)), size * float(np.sqrt(now)), after)


def _seen(found: Resection, points: ArrayLike) -> tuple[Array, Array, Flags]:
    """Return derivatives (m, 2, 9) of places by the camera, the places, and which of them exist."""
    world = np.reshape(np.asarray(points, float), (-1, 3))
    sensible = np.asarray((np.abs(world) <= REACH).all(axis=1))
    world = np.where(sensible[:, None], world, found.framing.centroid)
    known = found.framing.points(world)
    slopes = np.moveaxis(found.pose.slopes(found.pose.see(known))[0], 2, 0)
    before_eye = sensible & found.pose.before_eye(known)[0]
    return np.swapaxes(slopes, 1, 2), found.project(world), before_eye
