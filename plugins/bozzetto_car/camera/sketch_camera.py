"""Where a sketch stands in space: its camera, and the plane its picture lies on.

A picture that hangs behind the car, square to the line of sight, looks the same through its own
camera at any distance, however one turns or zooms about the camera's eye. So a place on the
sheet is a place in the picture by the ray through it, from whatever view.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.scene import Image, Picture
from bozzetto.view import Camera
from bozzetto.view.eye_fixed_motion import FOV_LIMITS
from bozzetto.view.rotations import triple
from bozzetto_car.array_types import Array

SHEET: Final = 6000.0
"""Width of a picture whose camera is not known yet, mm: a car in it has about its size."""

MIDDLE: Final = (2300.0, 0.0, 800.0)
"""Where its middle is, mm: about that of a car."""

BEYOND: Final = 1.25
"""How far behind the farthest node of the car a picture hangs, per distance of that from the
eye; of an orthographic camera per length of the car."""

SAME_EYE: Final = 1e-6
"""Difference of two eyes, per distance of their targets, that is none."""

ALL_IN: Final = 1.04
"""How much more than the picture is seen of it at first, so that its border is in view."""


@dataclass(frozen=True, eq=False)
class Stand:
    """A sketch in space.

    Attributes
    ----------
    camera : Camera
        Its viewport is as large as the picture.
    shift : (dx, dy)
        Pixels of the picture are those of the camera plus this; see `resect`.
    depth : float
        Of the picture along the line of sight, mm from the eye.
    """

    camera: Camera
    shift: tuple[float, float] = (0.0, 0.0)
    depth: float = 10_000.0

    @classmethod
    def behind(cls, camera: Camera, shift: tuple[float, float], positions: Array) -> Stand:
        """A sketch that hangs behind a car with nodes at `positions` (n, 3), mm."""
        depth = camera.view_space(positions)[:, 2]
        if camera.kind == "perspective":
            return cls(camera, shift, BEYOND * float(depth.max()))
        return cls(camera, shift, float(depth.max() + (BEYOND - 1.0) * np.ptp(positions[:, 0])))

    def lifted(self, pixels: ArrayLike) -> Array:
        """Places (n, 3) in space of pixels (n, 2) of the picture, mm."""
        forward = self.camera.axes[2]
        place = np.add(self.camera.eye, self.depth * forward)
        return self.camera.on_plane(np.subtract(pixels, self.shift), place, forward)

    def pixels(self, points: ArrayLike) -> Array:
        """Where the picture shows points (n, 3), px; NaN at or behind the eye."""
        return np.asarray(self.camera.project(points)[0] + self.shift)

    def seen_at(self, camera: Camera, places: ArrayLike) -> Array:
        """Pixels (n, 2) of the picture at places (n, 2) on the sheet of another view.

        NaN where a ray does not meet the picture's plane.
        """
        forward = self.camera.axes[2]
        point = np.add(self.camera.eye, self.depth * forward)
        return self.pixels(camera.on_plane(places, point, forward))

    def image(self, picture: Picture, opacity: float) -> Image:
        """The picture where it hangs."""
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
        """Whether a view is from where the sketch was drawn, turned or zoomed as it may be."""
        own = self.camera
        if camera.kind != own.kind:
            return False
        if own.kind == "perspective":
            away = float(np.linalg.norm(np.subtract(camera.eye, own.eye)))
            facing = float(camera.axes[2] @ own.axes[2])
            return away < SAME_EYE * own.distance and facing > 0.0
        return bool(np.abs(camera.axes - own.axes).max() < SAME_EYE)

    def view(self, viewport: tuple[float, float]) -> Camera:
        """The view with all of the picture on a canvas of another size, and a border around it."""
        width, height = self.camera.viewport
        wide, high = viewport
        half = 0.5 * ALL_IN * height * max(1.0, (width / height) / (wide / high))
        middle = 0.5 * width, 0.5 * height
        return self.windowed(viewport, [middle, (middle[0], middle[1] - half)])

    def window(self, camera: Camera) -> Array:
        """What a view shows of the picture.

        Returns
        -------
        (2, 2) float
            The picture's pixels in the middle of the view and in the middle of its upper edge.
        """
        width, height = camera.viewport
        return self.seen_at(camera, [(0.5 * width, 0.5 * height), (0.5 * width, 0.0)])

    def windowed(self, viewport: tuple[float, float], window: ArrayLike) -> Camera:
        """The view that shows a window of the picture, turned and zoomed about the eye.

        Parameters
        ----------
        viewport : (width, height)
            Of the canvas, px.
        window : (2, 2) array_like
            As of `window`, perhaps through another camera.
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


def flat_stand(size: tuple[float, float]) -> Stand:
    """A picture of which no camera is known: it stands upright over the ground, seen from the side.

    Parameters
    ----------
    size : (width, height)
        px.
    """
    width, height = size
    eye = (MIDDLE[0], MIDDLE[1] - 10_000.0, MIDDLE[2])
    camera = Camera(
        "orthographic", eye, MIDDLE, height=SHEET * height / width, viewport=(width, height)
    )
    return Stand(camera)
