"""The place of a sketch in space: its camera, and the plane that its picture lies on.

A picture that hangs behind the car, square to the line of sight, looks the same through its own
camera at any distance, also after turns and zooms about the camera's eye. So the ray through a
place on the sheet gives a place in the picture, from any view.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.scene import Image, Picture
from bozzetto.view import FOV_LIMITS, Camera, triple

SHEET: Final = 6000.0
"""Width of a picture whose camera is not known yet, mm: the car in it has about its real size."""

MIDDLE: Final = (2300.0, 0.0, 800.0)
"""Middle of such a picture, mm: about that of a car."""

BEYOND: Final = 1.25
"""Depth of a picture per depth of the farthest node of the car from the eye. With an orthographic
camera the part above 1 is the distance behind that node, per length of the car."""

SAME_EYE: Final = 1e-6
"""Distance of two eyes, per distance of their targets, that counts as none."""

ALL_IN: Final = 1.04
"""Size of the first view relative to the picture, so that the picture's border is in view."""


@dataclass(frozen=True, eq=False)
class SketchCamera:
    """The camera of a sketch, and the depth at which its picture hangs.

    Attributes
    ----------
    camera : Camera
        Its viewport is as large as the picture.
    shift : (dx, dy)
        Pixels of the picture are those of the camera plus this; see `resect`.
    depth : float
        Depth of the picture along the line of sight, mm from the eye.
    """

    camera: Camera
    shift: tuple[float, float] = (0.0, 0.0)
    depth: float = 10_000.0

    @classmethod
    def behind(cls, camera: Camera, shift: tuple[float, float], positions: Array) -> SketchCamera:
        """Return the camera of a sketch that hangs behind a car with nodes (n, 3), mm."""
        depth = camera.view_space(positions)[:, 2]
        if camera.kind == "perspective":
            return cls(camera, shift, BEYOND * float(depth.max()))
        return cls(camera, shift, float(depth.max() + (BEYOND - 1.0) * np.ptp(positions[:, 0])))

    def lifted(self, pixels: ArrayLike) -> Array:
        """Return the places (n, 3) in space of pixels (n, 2) of the picture, mm."""
        forward = self.camera.axes[2]
        place = np.add(self.camera.eye, self.depth * forward)
        return self.camera.on_plane(np.subtract(pixels, self.shift), place, forward)

    def pixels(self, points: ArrayLike) -> Array:
        """Return where the picture shows points (n, 3), px; NaN at or behind the eye."""
        return np.asarray(self.camera.project(points)[0] + self.shift)

    def seen_at(self, camera: Camera, places: ArrayLike) -> Array:
        """Return pixels (n, 2) of the picture at places (n, 2) on the sheet of another view.

        NaN where a ray does not meet the picture's plane.
        """
        forward = self.camera.axes[2]
        point = np.add(self.camera.eye, self.depth * forward)
        return self.pixels(camera.on_plane(places, point, forward))

    def image(self, picture: Picture, opacity: float) -> Image:
        """Return the picture as an image in space."""
        width, height = self.camera.viewport
        corner, right, low = self.lifted([[0.0, 0.0], [width, 0.0], [0.0, height]])
        across, down = right - corner, low - corner
        return Image(
            picture.pixels,
            (float(corner[0]), float(corner[1]), float(corner[2])),
            (float(across[0]), float(across[1]), float(across[2])),
            (float(down[0]), float(down[1]), float(down[2])),
            opacity,
        )

    def is_seen_through(self, camera: Camera) -> bool:
        """Whether a view has the eye of the sketch, turned and zoomed in any way."""
        own = self.camera
        if camera.kind != own.kind:
            return False
        if own.kind == "perspective":
            away = float(np.linalg.norm(np.subtract(camera.eye, own.eye)))
            facing = float(camera.axes[2] @ own.axes[2])
            return away < SAME_EYE * own.distance and facing > 0.0
        return bool(np.abs(camera.axes - own.axes).max() < SAME_EYE)

    def view(self, viewport: tuple[float, float]) -> Camera:
        """Return the view of the whole picture with a border, on a canvas of another size."""
        width, height = self.camera.viewport
        wide, high = viewport
        half = 0.5 * ALL_IN * height * max(1.0, (width / height) / (wide / high))
        middle = 0.5 * width, 0.5 * height
        return self.windowed(viewport, [middle, (middle[0], middle[1] - half)])

    def window(self, camera: Camera) -> Array:
        """Return the part of the picture that a view shows.

        Returns
        -------
        (2, 2) float
            The picture's pixels in the middle of the view and in the middle of its upper edge.
        """
        width, height = camera.viewport
        return self.seen_at(camera, [(0.5 * width, 0.5 * height), (0.5 * width, 0.0)])

    def windowed(self, viewport: tuple[float, float], window: ArrayLike) -> Camera:
        """Return the view that shows a window of the picture, turned and zoomed about the eye.

        Parameters
        ----------
        viewport : (width, height)
            Size of the canvas, px.
        window : (2, 2) array_like
            As `window` returns it, also through another camera.
        """
        own = self.camera
        middle, upper = self.lifted(window)
        if own.kind == "orthographic":
            move = middle - np.asarray(own.target)
            move -= (move @ own.axes[2]) * own.axes[2]
            return replace(
                own,
                eye=triple(np.asarray(own.eye) + move),
                target=triple(np.asarray(own.target) + move),
                height=2.0 * float(np.linalg.norm(upper - middle)),
                viewport=viewport,
            )
        sight, edge = middle - np.asarray(own.eye), upper - np.asarray(own.eye)
        across = float(np.linalg.norm(np.cross(sight, edge)))
        opening = float(2.0 * np.degrees(np.arctan2(across, sight @ edge)))
        ahead = own.distance / float(np.linalg.norm(sight)) * sight
        return replace(
            own,
            target=triple(np.asarray(own.eye) + ahead),
            fov_y=float(np.clip(opening, *FOV_LIMITS)),
            viewport=viewport,
        )


def upright_camera(size: tuple[float, float]) -> SketchCamera:
    """Return the camera of a picture without a known one: upright, seen from the side.

    Parameters
    ----------
    size : (width, height)
        Size of the picture, px.
    """
    width, height = size
    eye = (MIDDLE[0], MIDDLE[1] - 10_000.0, MIDDLE[2])
    camera = Camera(
        "orthographic", eye, MIDDLE, height=SHEET * height / width, viewport=(width, height)
    )
    return SketchCamera(camera)
