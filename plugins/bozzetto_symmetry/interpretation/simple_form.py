"""Forms that curves are given where the rays say nothing: flat, or straight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import across_image, image_slopes


@dataclass(frozen=True, eq=False)
class SimpleForm:
    """The planes in which a curve across the centre plane lies, and how well they are known.

    Each contains the direction of the centre plane's normal, as the plane of a flat symmetric
    curve does. One makes the curve flat; two make it straight.

    Attributes
    ----------
    planes : (k, 4) float
        Rows (n, d) with ``n · X = d``, n of unit length with ``n_y = 0``; mm.
    covariance : (2, 2) float
        For 1 px of the hand: of one plane, that of its angle (radians) and of d (mm); of two,
        that of x and z (mm²).
    """

    planes: Array
    covariance: Array

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
        normal = self.planes[0, :3]
        turned = np.array((-normal[2], 0.0, normal[0]))
        length = np.linalg.norm(tangents, axis=1, keepdims=True)
        along = np.divide(tangents, length, out=np.zeros_like(tangents), where=length > 0)
        aside = np.cross(normal, along)
        known = np.zeros(len(points))
        for sides in (np.ones(3), MIRROR):
            rows = across_image(image_slopes(stereo, points * sides) * sides, along)
            known += np.einsum("ni,ni->n", rows, aside) ** 2
        rays = stereo.rays(stereo.project(points)).directions
        slope = rays @ normal
        way = rays - (rays * along).sum(axis=1, keepdims=True) * along
        reach = np.linalg.norm(way, axis=1) / np.maximum(np.abs(slope), 1e-9)
        moves = np.column_stack((-(points @ turned), np.ones(len(points))))
        moved = np.einsum("ni,ij,nj->n", moves, self.covariance, moves)
        sigma = np.sqrt(1.0 / np.maximum(known, 1e-12) + reach**2 * moved)
        apart = np.linalg.norm(points[:, None] - points, axis=2)
        return np.asarray((sigma + apart).min(axis=1, initial=np.inf))
