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

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property, override
from bozzetto_silhouette.implicit.implicit_solid import Batched, Implicit, Sample
from bozzetto_silhouette.inflation.closed_surface import plan_gradients
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.numerics.grid_interpolant import BORDER, Cells, Lattice, on_nodes
from bozzetto_silhouette.outline.signed_distance import RimDistance

Value = TypeVar("Value", bound=np.generic)

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

_CHUNK = 4_096
"""Points evaluated at a time: what is known of them stays in the cache."""


@dataclass(frozen=True, eq=False)
class _Side:
    """Squared heights, and the local radius at the nodes of their lattice."""

    squares: Lattice
    radii: Array

    @cached_property
    def padded(self) -> Array:
        """The radii with a node more on every side."""
        return np.pad(self.radii, 1, mode="edge")

    @cached_property
    def thin(self) -> float:
        """The least radius that counts."""
        return _FAINT * float(self.radii.max())


@dataclass(frozen=True, eq=False)
class Relief(Batched):
    """A solid that was made by `solidify`, in its object frame."""

    solid: SilhouetteSolid

    @property
    @override
    def kind(self) -> Hashable:
        """Key that is equal for solids that can be sampled at once."""
        return Relief

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
        return self.sample_row([self], points, np.array([0, len(points)]))

    @staticmethod
    @override
    def sample_row(solids: Sequence[Implicit], points: Array, ends: Index) -> Sample:
        """Sample solids of this kind, each at points of its own, as `sample_each` does."""
        reliefs = [solid for solid in solids if isinstance(solid, Relief)]
        if len(reliefs) == 1:
            row, own = reliefs[0].row, np.zeros(len(points), np.intp)
        else:
            number = {relief: k for k, relief in enumerate(dict.fromkeys(reliefs))}
            row = _Row.of(list(number))
            own = np.repeat([number[relief] for relief in reliefs], np.diff(ends))
        count = len(points)
        value, gradient, curvature = np.empty(count), np.empty((count, 3)), np.empty(count)
        for first in range(0, count, _CHUNK):
            part = slice(first, first + _CHUNK)
            row.sample(points[part], own[part], value[part], gradient[part], curvature[part])
        return Sample(value, gradient, curvature)

    @cached_property
    def row(self) -> _Row:
        """The relief by itself."""
        return _Row.of([self])

    @cached_property
    def tallest(self) -> float:
        """The largest height."""
        return float(np.sqrt(max(self.solid.front.max(), self.solid.back.max())))

    @cached_property
    def sides(self) -> tuple[_Side, _Side]:
        """The squared heights of the front and of the back."""
        from scipy.ndimage import gaussian_filter

        solid = self.solid
        points, rim = solid.plan.points, len(solid.plan.after)
        low, high = points[:rim].min(axis=0), points[:rim].max(axis=0)
        extent = high - low + 2.0 * _REACH * self.tallest
        step = max(_SHARE * solid.step, float(np.sqrt(extent.prod() / _MOST_NODES)))
        low = low - _REACH * self.tallest - BORDER * step
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


class _Row(NamedTuple):
    """Several reliefs whose numbers stand in one row.

    Attributes
    ----------
    low, high : (s, 2) float array
        The box of each lattice.
    origin : (s, 2) float array
        The place of its first node.
    step : (s,) float array
    last : (s, 2) int array
        The last cell along both axes.
    width : (s,) int array
        Nodes across, those at the border included.
    front, back : (s,) int array
        Where in the rows those of either side begin.
    squares, radii : (c,) float array
        Coefficients of all splines, and the radii at their nodes.
    faint, thin : (s,) float array
        The shortest gradients and radii.
    """

    low: Array
    high: Array
    origin: Array
    step: Array
    last: Index
    width: Index
    front: Index
    back: Index
    squares: Array
    radii: Array
    faint: Array
    thin: Array

    @classmethod
    def of(cls, reliefs: list[Relief]) -> _Row:
        """Put reliefs into a row."""
        sides = [relief.sides for relief in reliefs]
        fronts = [front.squares for front, _ in sides]
        single = [(side,) if side is other else (side, other) for side, other in sides]
        padded = [side.squares.padded.ravel() for some in single for side in some]
        starts = np.cumsum([0, *map(len, padded)])
        first = np.cumsum([0, *map(len, single)])[:-1]
        boxes = np.array([lattice.bounds for lattice in fronts])
        return cls(
            boxes[:, 0],
            boxes[:, 1],
            np.array([lattice.low for lattice in fronts]),
            np.array([lattice.step for lattice in fronts]),
            np.array([lattice.coefficients.shape for lattice in fronts]) - 2,
            np.array([lattice.padded.shape[1] for lattice in fronts]),
            starts[first],
            starts[first + [len(some) - 1 for some in single]],
            _joined(padded),
            _joined([side.padded.ravel() for some in single for side in some]),
            np.array([_FAINT * relief.tallest for relief in reliefs]),
            np.array([[side.thin for side in pair] for pair in sides]),
        )

    def sample(
        self, points: Array, own: Index, value: Array, gradient: Array, curvature: Array
    ) -> None:
        """Sample reliefs at points (n, 3), each the one with a number (n,), into the last three."""

        def of(values: NDArray[Value]) -> NDArray[Value]:
            """Return something of the reliefs for each point."""
            return values[0] if len(values) == 1 else values.take(own)

        x, y, z = np.ascontiguousarray(points.T)
        within_x = np.clip(x, of(self.low[:, 0]), of(self.high[:, 0]))
        within_y = np.clip(y, of(self.low[:, 1]), of(self.high[:, 1]))
        step, width, start, thin = (
            of(self.step),
            of(self.width),
            of(self.front),
            of(self.thin[:, 0]),
        )
        if (self.front != self.back).any():
            behind = z < 0.0
            start = np.where(behind, of(self.back), start)
            thin = np.where(behind, of(self.thin[:, 1]), thin)
        along = (within_x - of(self.origin[:, 0])) / step
        across = (within_y - of(self.origin[:, 1])) / step
        i = np.clip(np.floor(along).astype(np.intp), 0, of(self.last[:, 0]))
        j = np.clip(np.floor(across).astype(np.intp), 0, of(self.last[:, 1]))
        cells = Cells(start + i * width + j, width, along - i, across - j)
        u, slope_x, slope_y = cells.cubic(self.squares)
        half_x, half_y = 0.5 * slope_x / step, 0.5 * slope_y / step
        g2 = half_x * half_x + half_y * half_y + z * z
        square = u - z * z
        # Around no ball the gradient is shorter; in valleys far outside it vanishes.
        fitted = np.maximum(g2, -square)
        np.subtract(np.sqrt(fitted + square), np.sqrt(fitted), out=value)
        length = np.maximum(np.sqrt(g2), of(self.faint))
        gradient[:, 0], gradient[:, 1], gradient[:, 2] = (
            half_x / length,
            half_y / length,
            -z / length,
        )
        np.divide(1.0, np.maximum(cells.linear(self.radii), thin), out=curvature)
        beyond_x, beyond_y = x - within_x, y - within_y
        far = np.flatnonzero((beyond_x != 0.0) | (beyond_y != 0.0))
        if len(far):
            # Nothing of the solid is there: with c the nearest point of the lattice's box,
            # the distance lies between this and sqrt(2) of it.
            beyond = np.stack([beyond_x[far], beyond_y[far]], axis=1)
            near = np.minimum(value[far], 0.0)
            total = -np.hypot(near, np.hypot(beyond[:, 0], beyond[:, 1]))
            gradient[far] *= (near / total)[:, None]
            gradient[far, :2] *= beyond == 0.0
            gradient[far, :2] += beyond / total[:, None]
            value[far] = total


def _joined(rows: list[Array]) -> Array:
    """Put arrays (n,) into one row; one by itself is not copied."""
    return rows[0] if len(rows) == 1 else np.concatenate(rows)
