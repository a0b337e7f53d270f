"""Depth of a surface over the inside of its outline: one class for every kind of surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.implicit.convolution_field import convolution_field, with_correction
from bozzetto_silhouette.inflation.height_fairing import faired
from bozzetto_silhouette.model.state import Kernel
from bozzetto_silhouette.outline.boundary_sampling import Rim
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.normalized import Frame


class HeightModel(Protocol):
    """A kind of surface: given an outline, the square of its half thickness anywhere inside.

    Squares, because the surface stands upright on the outline: there the height itself has
    no slope, its square has.
    """

    def squares(self, frame: Frame, rim: Rim, plan: Plan) -> Array:
        """Return the squared half thickness at a plan's points, in the frame of the sums.

        Parameters
        ----------
        frame : Frame
            The outline, its skeleton and its scale.
        rim : Rim
            The samples of the outline that the plan starts with.
        plan : Plan
            Triangles of the inside of the outline.

        Returns
        -------
        (n,) float array
            0 on the rim, positive inside.
        """
        ...


@dataclass(frozen=True)
class ConvolutionHeights:
    """The convolution surface around the skeleton, corrected at the rim, and faired.

    Attributes
    ----------
    softness : float
        Support of the kernel in radii, 1.25 to 2: how far limbs blend into each other.
    kernel : str
        What is summed along the skeleton; the default knows the radius from place to place.
    """

    softness: float = 1.4
    kernel: Kernel = "scalis"

    def squares(self, frame: Frame, rim: Rim, plan: Plan) -> Array:
        """Return the squared half thickness at a plan's points."""
        raw = convolution_field(frame, softness=self.softness, kernel=self.kernel)
        field = with_correction(raw, rim)
        square = np.zeros(len(plan.points))
        first = len(plan.after)
        inner = plan.points[first:]
        closest = field.closest(inner)
        square[first:] = field.heights(inner, closest) ** 2
        return faired(plan, square, closest.distance)
