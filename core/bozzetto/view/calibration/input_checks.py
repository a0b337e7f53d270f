"""Checks of what a calibration is given: arrays it can work with, or a sentence for the person."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.view.calibration.normalization import Framing

if TYPE_CHECKING:
    from bozzetto.arrays import Array

FEWEST: Final = 6
"""Marks of different points from which a camera is looked for. Four would do for seven
unknowns, and would fit whatever was marked."""

FLAT: Final = 0.01
"""Thickness of the points, as a share of their length, below which they count as lying in one
plane: for a car of 4.5 m some 15 mm either side."""

TOGETHER: Final = 0.01
"""Root mean square distance of the marks from their middle, in diagonals of the picture, below
which they say nothing: some 15 px of 1200."""

FARTHEST: Final = 10.0
"""Farthest mark from the middle of the picture, in its diagonals."""

REACH: Final = 1e9
"""Largest coordinate of a point, mm: a thousand kilometres."""

LARGEST_PICTURE: Final = 1e8
"""Most units along a side of a picture: drawings may be told in finer ones than pixels."""


def framed(
    points: ArrayLike,
    marks: ArrayLike,
    picture: tuple[float, float],
    further: Mapping[str, ArrayLike],
) -> tuple[Array, Array, Framing]:
    """Return points and marks as arrays, and the units to work in; arguments as of `resect`.

    Raises
    ------
    UserError
        As of `resect`.
    """
    width, height = float(picture[0]), float(picture[1])
    if not (1.0 <= width <= LARGEST_PICTURE and 1.0 <= height <= LARGEST_PICTURE):
        raise UserError("A picture needs a width and a height in pixels. Load the picture again.")
    world = np.reshape(np.asarray(points, float), (-1, 3))
    places = np.reshape(np.asarray(marks, float), (-1, 2))
    if len(world) != len(places):
        raise UserError("Every point needs one mark. Give as many marks as points.")
    if not np.isfinite(places).all():
        raise UserError("A mark is not at a finite place. Set that mark again.")
    if not (np.isfinite(world).all() and np.abs(world).max(initial=0.0) <= REACH):
        raise UserError("A marked point lies beyond all bounds. Choose another point.")
    different = len(np.unique(world, axis=0))
    if different < FEWEST:
        raise UserError(
            f"A camera needs marks of {FEWEST} different points, and there are {different}. "
            f"Mark further points{_for_example(world, further)}."
        )
    centroid = world.mean(axis=0)
    lengths = np.linalg.svd(world - centroid, compute_uv=False) / np.sqrt(len(world))
    if not lengths[2] > FLAT * lengths[0]:
        shape = "plane" if lengths[1] > FLAT * lengths[0] else "line"
        raise UserError(
            f"All marked points lie close to one {shape}, so the camera could be on either side. "
            f"Mark a point well off it too{_for_example(world, further)}."
        )
    framing = Framing(centroid, float(np.linalg.norm(lengths)), (width, height))
    scaled = framing.marks(places)
    if np.abs(scaled).max() > FARTHEST:
        far = int(np.argmax(np.abs(scaled).max(axis=1)))
        raise UserError(
            "A mark lies far beside the picture. Set it where the point would be seen.",
            places=[(places[far, 0], places[far, 1])],
        )
    if np.sqrt(np.mean(np.sum((scaled - scaled.mean(axis=0)) ** 2, axis=1))) < TOGETHER:
        raise UserError("The marks lie on top of one another. Set each where its point is seen.")
    return world, places, framing


def spread_most(points: ArrayLike, candidates: ArrayLike) -> int | None:
    """Return the candidate after which the points spread most evenly in space.

    That is the one with the largest determinant of the points' scatter: for points in a plane
    the one farthest from it, for points of a line one far off the line. It needs no camera.

    Parameters
    ----------
    points : (n, 3) array_like
        Marked points, mm; none at all is good too.
    candidates : (m, 3) array_like
        Points to choose from, mm.

    Returns
    -------
    int or None
        None if there is no candidate with sensible coordinates.
    """
    there = np.reshape(np.asarray(points, float), (-1, 3))
    offered = np.reshape(np.asarray(candidates, float), (-1, 3))
    numbers = np.flatnonzero((np.abs(offered) <= REACH).all(axis=1))
    if not len(numbers):
        return None
    together = np.vstack((there, offered[numbers]))
    middle = together.mean(axis=0)
    size = float(np.abs(together - middle).max())
    scaled = (together - middle) / (size if size > 0.0 else 1.0)
    best, largest = 0, -np.inf
    for row, number in enumerate(numbers.tolist(), len(there)):
        some = np.vstack((scaled[: len(there)], scaled[row]))
        about = some - some.mean(axis=0)
        # A little scatter of its own, so that few points in a line are compared as well.
        value = float(np.linalg.slogdet(about.T @ about + 1e-6 * np.eye(3))[1])
        if value > largest:
            best, largest = number, value
    return best


def _for_example(points: Array, further: Mapping[str, ArrayLike]) -> str:
    """Return ``, for example C4``: the point that helps most, if there is any."""
    names = list(further)
    best = spread_most(points, [np.asarray(further[name], float) for name in names])
    return "" if best is None else f", for example {names[best]}"
