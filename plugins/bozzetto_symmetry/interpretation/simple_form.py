"""Forms that curves are given where the rays say nothing: flat, or straight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.stereo.bowed_plane import BowedPlane
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import across_image, image_slopes

TREMOR: Final = 0.04
"""Share of a curve over which a tremor is alike."""

ONE: Final = 0.1
"""Least part of the error of a hand that two images do not share."""


@dataclass(frozen=True, eq=False)
class SimpleForm:
    """The planes in which a curve across the centre plane lies, and how well they are known.

    Each contains the direction of the centre plane's normal, as the plane of a flat symmetric
    curve does. One makes the curve flat; two make it straight.

    Attributes
    ----------
    planes : (k, 4) float
        Rows (n, d) with ``n · X = d``, n of unit length with ``n_y = 0``; mm.
    covariance : (k, k) float
        For 1 px of the hand: of one plane, that of its angle (radians) and of d (mm), and of its
        bows; of two, that of x and z (mm²).
    surface : BowedPlane or None
        The one plane, where it is bowed.
    """

    planes: Array
    covariance: Array
    surface: BowedPlane | None = None

    @classmethod
    def on(cls, surface: BowedPlane, covariance: Array) -> SimpleForm:
        """Return the form of a curve on a plane or a bowed one, from the doubt of its figures."""
        planes = np.append(surface.normal, surface.away)[None]
        return cls(planes if surface.flat else planes[:0], covariance, surface)

    @property
    def flat(self) -> bool:
        """Whether planes say where the curve lies."""
        return len(self.planes) > 0

    def sigmas(self, stereo: Stereo, points: Array, tangents: Array) -> Array:
        """Return how far places of the curve may be off across it, (n,) mm for 1 px.

        A place of a flat curve is where its ray meets the plane: it moves across the curve with
        the ink, of which both halves tell, and along the ray with the plane.

        Parameters
        ----------
        stereo : Stereo
            The view in which the curve was drawn.
        points, tangents : (n, 3) float
            Places along the curve, and its direction there, mm.
        """
        if len(self.planes) > 1:
            return np.full(len(points), float(np.trace(self.covariance)) ** 0.5)
        surface = self.surface
        assert surface is not None
        length = np.linalg.norm(tangents, axis=1, keepdims=True)
        along = np.divide(tangents, length, out=np.zeros_like(tangents), where=length > 0)
        steep = surface.gradients(points)
        normals = steep / np.linalg.norm(steep, axis=1, keepdims=True)
        aside = np.cross(normals, along)
        near, far = stereo.project(points), stereo.project(points * MIRROR)
        one, other = (
            np.abs(
                (across_image(image_slopes(stereo, points * sides) * sides, along) * aside).sum(1)
            )
            for sides in (np.ones(3), MIRROR)
        )
        known = information_of_two(one, other, _alike(near, far))
        rays = stereo.rays(near).directions
        slope = (rays * steep).sum(axis=1)
        way = rays - (rays * along).sum(axis=1, keepdims=True) * along
        reach = np.linalg.norm(way, axis=1) / np.maximum(np.abs(slope), 1e-9)
        moves = surface.moves(points)[:, : len(self.covariance)]
        moved = np.einsum("ni,ij,nj->n", moves, self.covariance, moves)
        sigma = np.sqrt(1.0 / np.maximum(known, 1e-12) + reach**2 * moved)
        apart = np.linalg.norm(points[:, None] - points, axis=2)
        return np.asarray((sigma + apart).min(axis=1, initial=np.inf))


def _alike(near: Array, far: Array) -> Array:
    """Return how alike the hand errs at the images (n, 2) px of places and of their mirror images.

    A tremor is alike over a 25th of the curve, and 1 where the curve crosses the centre plane.
    """
    reach = TREMOR * float(np.nansum(np.linalg.norm(np.diff(near, axis=0), axis=1)))
    apart = np.linalg.norm(near - far, axis=1)
    return np.asarray(np.exp(-((apart / max(2.0 * reach, 1e-9)) ** 2)))


def information_of_two(one: Array, other: Array, alike: Array) -> Array:
    """Return what two measurements of one figure say whose errors are alike, 1/mm² for 1 px.

    Parameters
    ----------
    one, other : (n,) float
        How far the image moves with the figure, px/mm; not negative.
    alike : (n,) float
        Correlation of their errors.
    """
    mean, half = 0.5 * (one + other), 0.5 * (one - other)
    # In the sum and the difference of the two the errors are independent.
    return np.asarray(2.0 * mean**2 / (1.0 + alike) + 2.0 * half**2 / np.maximum(1.0 - alike, ONE))
