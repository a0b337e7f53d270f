"""A spline through the ink of all views, how sure it is, and how far it is off that ink."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.ink import distances_to_polyline
from bozzetto.plugin import cached_property
from bozzetto_symmetry.fitting.bundle_adjustment import Sight
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.interpretation.simple_form import SimpleForm
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.stereo.uncertainty import LEFT, curve_sigmas

SAMPLES: Final = 200
"""Places of a curve at which its uncertainty is given."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A spline through the ink of all views.

    Attributes
    ----------
    curve : SpaceCurve
    rms : float
        Distance of the ink from the images of the curve, px.
    sights : tuple of Sight
        The ink that was fitted to.
    form : SimpleForm or None
        Which the curve was given.
    """

    curve: SpaceCurve
    rms: float
    sights: tuple[Sight, ...]
    form: SimpleForm | None = None

    @cached_property
    def points(self) -> Array:
        """Places along the curve, (k, 3) mm."""
        return sampled(self.curve.spline)

    @cached_property
    def off_ink(self) -> float:
        """Distance between ink and images (rms, px), from either to the other, the greatest."""
        worst = 0.0
        for sight in self.sights:
            sides = [(sight.near, np.ones(3)), (sight.far, MIRROR)]
            if self.curve.reading == "self":  # its image shows both halves
                sides = [((*sight.near, *sight.far), np.ones(3))]
            for ink, factors in sides:
                image = sight.stereo.project(self.points * factors)
                if not len(ink):
                    continue
                if not np.isfinite(image).all():
                    return np.inf
                gaps = [distances_to_polyline(image, line) for line in ink]
                ways = np.min(gaps, axis=0), *(distances_to_polyline(line, image) for line in ink)
                worst = max(worst, *(float(np.sqrt(np.mean(way**2))) for way in ways))
        return worst

    @cached_property
    def sigma(self) -> Array:
        """How far each of these places may be off across the curve, (k,) mm for 1 px."""
        spline, flat = self.curve.spline, self.curve.reading == "plane"
        tangents = spline.derivative(np.linspace(*spline.range, len(self.points)))
        if self.form is not None:
            return LEFT * self.form.sigmas(self.sights[0].stereo, self.points, tangents)
        near = [sight.stereo for sight in self.sights if sight.near]
        far = [sight.stereo for sight in self.sights if sight.far]
        return LEFT * curve_sigmas(near, far, self.points, tangents, flat=flat)


def sampled(spline: Spline) -> Array:
    """Return places along a spline, both ends included."""
    return spline.sampled(SAMPLES)
