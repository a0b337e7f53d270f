"""Views for a page: one that a person chose, or one that shows everything."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.view.camera import Camera
from bozzetto.view.navigation import fit_points, with_kind
from bozzetto.view.standard_views import standard_view

PAGE: Final = (1200.0, 900.0)
"""Page of pictures without a canvas of their own, pixels."""

MARGIN: Final = 0.06
"""Part of a page left free on each side of what is shown."""

SLACK: Final = 0.5
"""Pixels by which something may stand over the border of a page and still lie in it."""

OBLIQUE: Final = "three-quarter"
"""The standard view that is not square to an axis, and so is no plan in millimetres."""


def shows(camera: Camera, points: ArrayLike, *, whole: bool = True) -> bool:
    """Whether points lie on a camera's canvas: all of them, or at least one.

    Points at or behind the eye of a perspective camera do not. Where there are no points there
    is nothing that could lie outside.
    """
    places, _ = camera.project(points)
    low, high = -SLACK, np.add(camera.viewport, SLACK)
    within = np.asarray(np.all((places >= low) & (places <= high), axis=1))
    return bool(within.all() if whole or not len(places) else within.any())


def framing(
    points: ArrayLike,
    name: str = OBLIQUE,
    size: tuple[float, float] = PAGE,
    *,
    plans: bool = False,
) -> Camera:
    """Return a standard view that frames points.

    Parameters
    ----------
    points : (n, 3) array_like
        mm.
    name : str
        See `standard_view`.
    size : (width, height)
        Size of the page, pixels.
    plans : bool
        Views along an axis are parallel ones.

    Raises
    ------
    UserError
        If the view has no such name.
    """
    camera = standard_view(Camera(viewport=size), name)
    if plans and name != OBLIQUE:
        camera = with_kind(camera, "orthographic")
    return fit_points(camera, points, MARGIN)


def page_view(
    points: ArrayLike,
    camera: Camera | None,
    size: tuple[float, float] | None = None,
    *,
    whole: bool = True,
) -> Camera:
    """Return a person's own view if it shows the points, else the three-quarter view of them.

    Parameters
    ----------
    points : (n, 3) array_like
        Points of all that is to be seen, mm.
    camera : Camera, optional
        The person's view.
    size : (width, height), optional
        Size of the page, pixels; by default the camera's canvas, or `PAGE`.
    whole : bool
        Whether the view must show all points or some are enough.
    """
    if camera is not None:
        own = camera if size is None else replace(camera, viewport=size)
        if shows(own, points, whole=whole):
            return own
    return framing(points, size=size or (PAGE if camera is None else camera.viewport))
