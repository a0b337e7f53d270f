"""The relief: a solid of heights over an outline as a function of space.

With u the squared height, ``F = u(x, y) - z^2`` is zero on the surface, positive inside, and
on balls and tubes exactly the difference of two squared distances. From F and its gradient
the ball that fits there gives the distance. With g half the length of the gradient,

    d = sqrt(g^2 + F) - g,

which is exact for them, and smooth where the gradient vanishes, inside. The gradient that is
given is the unit vector along grad F: that of d on the surface, and for balls everywhere.

Beyond the outline u goes on as it would for a tube: with r half the slope of u at the nearest
point of the rim, at the distance e, ``u = -(2 r + e) e``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import cached_property
from bozzetto_silhouette.implicit.implicit_solid import Sample
from bozzetto_silhouette.inflation.sewing import plan_gradients
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.numerics.grid_interpolant import BORDER, Lattice, on_nodes
from bozzetto_silhouette.outline.signed_distance import RimDistance

_SHARE = 0.75
"""Step of the lattice as a share of the plan's: limbs are quadratic across, and so is the
spline, so that even those thinner than a cell are kept."""

_MOST_NODES = 1_000_000
"""Nodes of the lattice at most: eight megabytes a side."""

_REACH = 0.5
"""Margin of the lattice beyond the outline, as a share of the largest height."""

_CALM = 2.0
"""Width of the filter, in nodes, that takes the corners of the sampled rim out of its distance.
Applied twice with opposite signs it leaves cubics as they are."""

_ROUNDS = 6
"""Rounds of averaging the radius along the rim."""

_FAINT = 1e-9
"""Gradients and radii shorter than this share of the largest height count as none."""


@dataclass(frozen=True, eq=False)
class _Side:
    """Squared heights, and the local radius at the nodes of their lattice."""

    squares: Lattice
    radii: Array

    def curvature(self, xy: Array) -> Array:
        """Return one over the local radius at points (n, 2)."""
        from scipy.ndimage import map_coordinates

        at = ((xy - self.squares.low) / self.squares.step).T
        radius = map_coordinates(self.radii, at, order=1, mode="nearest")
        curvature: Array = 1.0 / np.maximum(radius, _FAINT * self.radii.max())
        return curvature


@dataclass(frozen=True, eq=False)
class Relief:
    """A solid that was made by `solidify`, in its object frame."""

    solid: SilhouetteSolid

    @cached_property
    def bounds(self) -> Array:
        """The box around the mesh."""
        vertices = self.solid.vertices
        return np.stack([vertices.min(axis=0), vertices.max(axis=0)])

    def value(self, points: Array) -> Array:
        """Return the values at points (n, 3)."""
        return self.sample(points).value

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3)."""
        front, back = self._sides
        low, high = front.squares.bounds
        xy = np.clip(points[:, :2], low, high)
        z = points[:, 2]
        if front is back:
            value, gradient, curvature = self._fitted(front, xy, z)
        else:
            value, gradient, curvature = np.empty(len(z)), np.empty((len(z), 3)), np.empty(len(z))
            for side, mine in ((front, z >= 0.0), (back, z < 0.0)):
                value[mine], gradient[mine], curvature[mine] = self._fitted(side, xy[mine], z[mine])
        beyond = points[:, :2] - xy
        gap = np.hypot(beyond[:, 0], beyond[:, 1])
        far = np.flatnonzero(gap > 0.0)
        if len(far):
            # Nothing of the solid is there: with c the nearest point of the lattice's box,
            # the distance lies between this and sqrt(2) of it.
            near = np.minimum(value[far], 0.0)
            total = -np.hypot(near, gap[far])
            gradient[far] *= (near / total)[:, None]
            gradient[far, :2] *= beyond[far] == 0.0
            gradient[far, :2] += beyond[far] / total[:, None]
            value[far] = total
        return Sample(value, gradient, curvature)

    def _fitted(self, side: _Side, xy: Array, z: Array) -> tuple[Array, Array, Array]:
        """Return the distance by the fitted ball, its gradient's direction, and the curvature."""
        u, slope = side.squares.sample(xy)
        half = np.column_stack([0.5 * slope, -z])
        g2 = np.einsum("ij,ij->i", half, half)
        g = np.sqrt(g2)
        square = u - z * z
        # Around no ball the gradient is shorter; in valleys far outside it vanishes.
        fitted = np.maximum(g2, -square)
        gradient = half / np.maximum(g, _FAINT * self._tallest)[:, None]
        return np.sqrt(fitted + square) - np.sqrt(fitted), gradient, side.curvature(xy)

    @cached_property
    def _tallest(self) -> float:
        return float(np.sqrt(max(self.solid.front.max(), self.solid.back.max())))

    @cached_property
    def _sides(self) -> tuple[_Side, _Side]:
        """The squared heights of the front and of the back."""
        from scipy.ndimage import gaussian_filter

        solid = self.solid
        points, rim = solid.plan.points, len(solid.plan.after)
        low, high = points[:rim].min(axis=0), points[:rim].max(axis=0)
        extent = high - low + 2.0 * _REACH * self._tallest
        step = max(_SHARE * solid.step, float(np.sqrt(extent.prod() / _MOST_NODES)))
        low = low - _REACH * self._tallest - BORDER * step
        nx, ny = (int(n) + 2 * BORDER + 1 for n in np.ceil(extent / step))
        distance = RimDistance(points[:rim], solid.plan.after)

        def side(squares: Array) -> _Side:
            gradients = plan_gradients(solid.plan, squares)
            values = on_nodes(points, solid.plan.triangles, squares, gradients, low, step, (nx, ny))
            outside = np.isnan(values)
            closest = distance(low + step * np.argwhere(outside))
            radius = self._rim_radius(gradients[:rim])
            radius = (
                radius[closest.segment] * (1.0 - closest.along)
                + radius[solid.plan.after[closest.segment]] * closest.along
            )
            gap = np.abs(closest.distance)
            values[outside] = -(2.0 * radius + gap) * gap
            calm = 2.0 * gaussian_filter(values, _CALM) - gaussian_filter(values, _CALM * 2**0.5)
            share = np.clip(gap / (_CALM * step) - 0.5, 0.0, 1.0)
            values[outside] += share * (calm - values)[outside]
            lattice = Lattice.through(low, step, values)
            slope_x, slope_y = np.gradient(values, step)
            thick = np.sqrt(np.maximum(values + 0.25 * (slope_x**2 + slope_y**2), 0.0))
            thick[outside] = radius
            return _Side(lattice, gaussian_filter(thick, _CALM))

        front = side(solid.front)
        same = np.array_equal(solid.front, solid.back)
        return front, front if same else side(solid.back)

    def _rim_radius(self, gradients: Array) -> Array:
        """Return the radius of the section at every sample of the rim, averaged along it."""
        after = self.solid.plan.after
        radius: Array = 0.5 * np.hypot(gradients[:, 0], gradients[:, 1])
        for _ in range(_ROUNDS):
            middle = 0.5 * (radius + radius[after])
            radius[after] = 0.5 * (middle + middle[after])
        return radius
