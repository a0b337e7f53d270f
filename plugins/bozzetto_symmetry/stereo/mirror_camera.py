"""A camera and its mirror image in the centre plane: two views of one symmetric thing.

What is drawn on both sides of a plane of symmetry through one camera is seen by that camera
and by its mirror image: two views, so a point is where two rays meet (Bae, Kijima & Kim
2004, appendix). Everything here is in the plane's own frame: the plane is y = 0, mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.plugin import cached_property
from bozzetto.view import Camera, Rays
from bozzetto_symmetry.model.perspective import focal_length, vanishing_point
from bozzetto_symmetry.model.symmetry_plane import CentrePlane

MIRROR: Final = np.array([1.0, -1.0, 1.0])
"""The reflection in y = 0, as factors of the coordinates."""

NORMAL: Final = (0.0, 1.0, 0.0)
"""The normal of the centre plane in its own frame."""

ALONG: Final = 1e-12
"""Length of a ray's part along the plane, per unit, below which it is parallel to the normal."""


@dataclass(frozen=True)
class Stereo:
    """One camera of a drawing, in the frame of the centre plane.

    Parameters
    ----------
    camera : Camera
        Carried into the plane's frame; `of` does so.
    """

    camera: Camera

    @classmethod
    def of(cls, camera: Camera, plane: CentrePlane) -> Stereo:
        """Return the stereo of a camera in the model's frame."""
        return cls(camera if plane.inverse.is_identity else camera.moved(plane.inverse))

    @property
    def parallel(self) -> bool:
        """Whether the rays are parallel (orthographic)."""
        return self.camera.kind == "orthographic"

    # -- between the sheet and space -----------------------------------------------------------

    def rays(self, pixels: ArrayLike) -> Rays:
        """Return rays through places on the sheet, (n, 2) px."""
        return self.camera.rays(pixels)

    def project(self, points: ArrayLike) -> Array:
        """Return where points (n, 3) mm are seen, (n, 2) px; NaN at or behind the eye."""
        return self.camera.project(points)[0]

    def on_plane(self, pixels: ArrayLike) -> Array:
        """Return where rays meet the centre plane, (n, 3) mm, y exactly 0; NaN where they miss."""
        points = self.camera.on_plane(pixels, (0.0, 0.0, 0.0), NORMAL)
        points[:, 1] *= 0.0
        return points

    # -- epipolar geometry ---------------------------------------------------------------------

    @cached_property
    def vanishing_point(self) -> Array:
        """The epipole: where lines along the plane's normal meet on the sheet.

        Homogeneous coordinates (x, y, w), px, as `model.perspective.vanishing_point` gives them: it
        is at infinity where w is 0, and nowhere where a parallel view looks along the normal.
        """
        return vanishing_point(self.camera, NORMAL)

    def toward_vanishing(self, pixels: ArrayLike) -> Array:
        """Return unit directions (n, 2) along the epipolar lines; 0 at the vanishing point."""
        place = np.reshape(np.asarray(pixels, float), (-1, 2))
        x, y, w = self.vanishing_point
        way = np.array([x, y]) - w * place
        length = np.linalg.norm(way, axis=1, keepdims=True)
        return np.asarray(np.divide(way, length, out=np.zeros_like(way), where=length > 0))

    def angles(self, pixels: ArrayLike) -> Array:
        """Return the epipolar line of each place of a curve.

        The angle (radians) of the plane through the eye, the place and the y axis, unwrapped
        along the curve; of a parallel view the offset (mm) across the image of the y axis.
        Mirrored places have equal angles, up to whole turns.
        """
        place = np.reshape(np.asarray(pixels, float), (-1, 2))
        if self.parallel:
            across = self._across
            width, height = self.camera.viewport
            return np.asarray((place - (0.5 * width, 0.5 * height)) @ across / self._scale)
        _, directions = self.rays(place)
        return np.asarray(np.unwrap(np.arctan2(directions[:, 2], directions[:, 0])))

    def pixels_per_angle(self, pixels: ArrayLike) -> Array:
        """Return the distance, px, of epipolar lines one unit of `angles` apart, at each place."""
        place = np.reshape(np.asarray(pixels, float), (-1, 2))
        if self.parallel:
            return np.full(len(place), self._scale)
        # The gradient of the angle on the sheet, through the ray that is not yet normalised.
        right, up, forward = self.camera.axes
        width, height = self.camera.viewport
        focal = focal_length(self.camera)
        ray = (
            (place[:, :1] - 0.5 * width) * right
            + (0.5 * height - place[:, 1:]) * up
            + focal * forward
        )
        squared = ray[:, 0] ** 2 + ray[:, 2] ** 2
        slope = np.stack(
            [ray[:, 0] * axis[2] - ray[:, 2] * axis[0] for axis in (right, -up)], axis=1
        )
        steep = np.linalg.norm(slope, axis=1)
        out = np.full(len(place), np.inf)
        return np.asarray(np.divide(squared, steep, out=out, where=steep > 0))

    @property
    def _scale(self) -> float:
        return self.camera.viewport[1] / self.camera.height

    @property
    def _across(self) -> Array:
        x, y, _ = self.vanishing_point
        length = float(np.hypot(x, y))
        return np.array([-y, x]) / length if length > ALONG else np.zeros(2)

    @cached_property
    def slant(self) -> float:
        """Angle between the line of sight and the centre plane, radians, 0 … π/2.

        The stereo's baseline grows with its sine. For a perspective camera the line from the
        eye to the place of the plane nearest to the target counts as the line of sight.
        """
        if self.parallel:
            sine = abs(float(self.camera.axes[2, 1]))
        else:
            eye, target = np.asarray(self.camera.eye), np.asarray(self.camera.target) * (1, 0, 1)
            sine = abs(float(eye[1])) / float(np.linalg.norm(target - eye) or np.inf)
        return float(np.arcsin(min(1.0, sine)))

    # -- where mirrored rays meet --------------------------------------------------------------

    def intersected(self, near: ArrayLike, far: ArrayLike) -> Array:
        """Return points whose own image and whose mirror's image are given.

        In closed form: both rays lie in one plane through the y axis, in which the slope
        ``m = d_y / hypot(d_x, d_z)`` of each says how y grows with the way ``w`` along the
        plane: ``w = -2 e_y / (m1 + m2)``, ``y = e_y (m2 - m1) / (m1 + m2)``. For parallel
        rays the same with origins instead of one eye. Equals the least squares solution of
        Bae, Kijima & Kim 2004, equations (6)–(8), for pairs on one epipolar line.

        Parameters
        ----------
        near, far : (n, 2) array_like
            Pairs on common epipolar lines, px.

        Returns
        -------
        (n, 3) float
            mm; NaN where the rays do not meet in front of the eye.
        """
        first, second = self.rays(near), self.rays(far)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if self.parallel:
                points = self._meeting_parallel(first, second)
            else:
                points = self._meeting(first, second)
        return np.where(np.isfinite(points).all(axis=1, keepdims=True), points, np.nan)

    def _meeting(self, first: Rays, second: Rays) -> Array:
        ex, ey, ez = self.camera.eye
        one, other = first.directions, second.directions
        level = np.hypot(one[:, 0], one[:, 2])
        slopes = one[:, 1] / level + other[:, 1] / np.hypot(other[:, 0], other[:, 2])
        difference = other[:, 1] / np.hypot(other[:, 0], other[:, 2]) - one[:, 1] / level
        way = -2.0 * ey / slopes
        # A point and its image lie the same way along the plane: no pair has the vanishing
        # point between its places.
        facing = one[:, 0] * other[:, 0] + one[:, 2] * other[:, 2]
        way = np.where((way > 0) & (facing > 0), way, np.nan)
        return np.column_stack(
            (ex + way * one[:, 0] / level, ey * difference / slopes, ez + way * one[:, 2] / level)
        )

    def _meeting_parallel(self, first: Rays, second: Rays) -> Array:
        way = self.camera.axes[2]
        start, image = first.origins, second.origins * MIRROR
        # start + t d and image + s M d meet: their y gives t + s, their x and z give t − s.
        total = (image[:, 1] - start[:, 1]) / way[1]
        level = way[[0, 2]]
        squared = float(level @ level)
        if squared > ALONG**2:
            apart = (image[:, [0, 2]] - start[:, [0, 2]]) @ level / squared
        else:
            apart = np.full(len(start), np.nan)
        return np.asarray(start + (0.5 * (total + apart))[:, None] * way)
