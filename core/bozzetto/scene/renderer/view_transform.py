"""Transform from the world to a window of pixels, with a nearness affine on the sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Floats

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera

NEAR = 1e-4
"""Nearest depth shown in perspective, as a part of the distance to the target."""


@dataclass(frozen=True, eq=False)
class ViewTransform:
    """A camera bound to a window of pixels.

    `nearness` stands in for depth: it grows towards the eye and is affine in the pixel
    coordinates across a plane in space, so it may be interpolated on the sheet. It is
    reference / depth in perspective and reference − depth (mm) in parallel views.

    Parameters
    ----------
    eye : (3,) float
        mm.
    axes : (3, 3) float
        Rows right, up, forward.
    perspective : bool
    focal : float
        Pixels per unit slope (perspective), or per mm (parallel).
    middle : (x, y)
        Where the line of sight meets the window, px.
    width, height : int
        The window, px.
    reference : float
        Depth of the target, mm.
    """

    eye: Array
    axes: Array
    perspective: bool
    focal: float
    middle: tuple[float, float]
    width: int
    height: int
    reference: float

    @property
    def near(self) -> float:
        """Depth before which nothing is shown, mm."""
        return NEAR * self.reference if self.perspective else -np.inf

    def seen(self, points: ArrayLike) -> Array:
        """Return world points in the frame of the view: right, up, depth; shape (n, 3), mm."""
        return (np.asarray(points, np.float64) - self.eye) @ self.axes.T

    def placed(self, seen: Array) -> Array:
        """Return columns x, y (px) and nearness of points not before `near`, shape (n, 3)."""
        result = np.empty_like(seen)
        if self.perspective:
            with np.errstate(divide="ignore", invalid="ignore"):
                result[:, 2] = self.reference / seen[:, 2]
            scale = self.focal / self.reference * result[:, 2]
        else:
            result[:, 2] = self.reference - seen[:, 2]
            scale = np.full(len(seen), self.focal)
        result[:, 0] = self.middle[0] + seen[:, 0] * scale
        result[:, 1] = self.middle[1] - seen[:, 1] * scale
        return result

    def backed(self, nearness: Floats, pixels: float) -> Floats:
        """Return nearness moved away from the eye by as much as so many pixels measure there."""
        mm = np.float32(pixels / self.focal)
        if self.perspective:  # d q = −q² dz / reference, and a pixel measures z / focal
            return nearness * (np.float32(1) - mm)
        return nearness - mm


def view_transform(
    camera: Camera,
    height: float,
    width: float,
    window: tuple[int, int, int, int],
    fineness: int = 1,
) -> ViewTransform:
    """Return the transform of a camera through a window of the picture.

    Parameters
    ----------
    camera : Camera
        The view.
    height, width : float
        The whole picture, px; the camera's field of view fills its height.
    window : (x, y, w, h)
        The part of it to see, px.
    fineness : int
        Samples per pixel along each axis.
    """
    x, y, w, h = window
    fine = float(fineness)
    if camera.kind == "perspective":
        focal = 0.5 * height * fine / np.tan(np.radians(camera.fov_y) / 2.0)
    else:
        focal = height * fine / camera.height
    return ViewTransform(
        np.asarray(camera.eye),
        camera.axes,
        camera.kind == "perspective",
        float(focal),
        ((0.5 * width - x) * fine, (0.5 * height - y) * fine),
        w * fineness,
        h * fineness,
        camera.distance,
    )
