"""Straight through: an outline swept along the lines of sight in which it was drawn.

What a tunnel or a cut takes away is then what was seen inside its outline: a prism for a
parallel view, a cone from the eye for a perspective one.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bozzetto.arrays import Array, Faces
from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.implicit_solid import Sample
from bozzetto_silhouette.inflation.closed_surface import vertex_normals
from bozzetto_silhouette.inflation.manifold_check import soundness_of
from bozzetto_silhouette.model.state import Cut, Part
from bozzetto_silhouette.model.view_rays import ViewRays, view_rays_through
from bozzetto_silhouette.outline.boundary_sampling import sample_rim
from bozzetto_silhouette.outline.cut_line import cut_side
from bozzetto_silhouette.outline.domain_mesh import Plan, plan_of
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.outline.signed_distance import RimDistance
from bozzetto_silhouette.solids.body import Body

CLEARANCE = 0.15
"""How far the sweep reaches beyond what it acts on, as a share of the longest side of both:
blends at the far ends must not feel the caps."""

WALL_PITCH = 2.0
"""Rows of the walls in steps of what is cut: along a line of sight they are straight, however
small the outline."""

MOST_ROWS = 400
"""Rows of the walls at most: a tiny outline drawn far before a tiny shape has walls that are
a million times as long as either."""

FINEST = 0.2
"""Smallest spacing along the outline, in steps."""

COARSEST = 1.0 / 16.0
"""Largest spacing, as a share of the outline's own size: a small hole in a large body stays
round."""

RADIUS_TOLERANCE = 1e-3
"""Accuracy of the inscribed radius, as a share of the longest side."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """An outline swept along lines of sight between two heights, as a function of space.

    With d the distance from the outline of where a point is seen on the sheet and n its
    gradient, ``w d`` vanishes on the plane through the eye and the tangent at the foot point
    f, and has the gradient ``(n, s)`` with ``s = n . (k f - m)``. So ``w d / sqrt(1 + s^2)``
    is the exact distance from that plane.

    Attributes
    ----------
    rim : RimDistance
        The outline on the sheet.
    view_rays : ViewRays
    low, high : float
        Heights of the caps.
    """

    rim: RimDistance
    view_rays: ViewRays
    low: float
    high: float

    @property
    def bounds(self) -> Array:
        """The box around both caps."""
        caps = [self.view_rays.above(self.rim.points, z) for z in (self.low, self.high)]
        corners = np.concatenate(caps)
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def value(self, points: Array) -> Array:
        """Return the values at points (n, 3)."""
        return self.sample(points).value

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3)."""
        wall, slope, _ = self._wall(points)
        z = points[:, 2]
        below_high, above_low = self.high - z, z - self.low
        cap = np.minimum(below_high, above_low)
        outwards = np.zeros_like(slope)
        outwards[:, 2] = np.where(below_high < above_low, -1.0, 1.0)
        value = np.minimum(wall, cap)
        gradient = np.where((wall <= cap)[:, None], slope, outwards)
        # Before the edge of a cap the nearest point lies on that edge.
        edge = (wall < 0.0) & (cap < 0.0)
        value[edge] = -np.hypot(wall[edge], cap[edge])
        gradient[edge] = (
            wall[edge, None] * slope[edge] + cap[edge, None] * outwards[edge]
        ) / value[edge, None]
        return Sample(value, gradient)

    def _wall(self, points: Array) -> Sample:
        """Return the distance from the walls, which go on upright beyond the caps."""
        held = points.copy()
        held[:, 2] = np.clip(points[:, 2], self.low, self.high)
        seen = self.view_rays.drawn(held)
        closest = self.rim(seen)
        rim, after = self.rim.points, self.rim.after
        start = rim[closest.segment]
        edge = rim[after[closest.segment]] - start
        foot = start + closest.along[:, None] * edge
        left = np.column_stack([-edge[:, 1], edge[:, 0]])
        left /= np.maximum(np.hypot(left[:, 0], left[:, 1]), 1e-300)[:, None]
        distance = closest.distance[:, None]
        # Near the rim the direction to the foot is only rounding.
        far = np.abs(distance) > 1e-9 * self._size
        away = np.where(far, (seen - foot) / np.where(far, distance, 1.0), left)
        lean = (away * (self.view_rays.narrowing * foot - self.view_rays.slant)).sum(axis=1)
        steep = np.sqrt(1.0 + lean**2)
        value = closest.distance * self.view_rays.width(held[:, 2]) / steep
        return Sample(value, np.column_stack([away, lean]) / steep[:, None])

    @property
    def _size(self) -> float:
        return float(np.ptp(self.rim.points, axis=0).max())


def acts_on(part: Part) -> bool:
    """Whether a part goes straight through what comes before it, however thick that is."""
    return part.surface == "straight" and part.operation in ("carve", "intersect")


def _depends_on(part: Part, around: Array | None, resolution: int) -> Hashable:
    box = None if around is None else tuple(float(v) for v in around.ravel())
    return part.recipe, part.id, part.pose, box, resolution


@remembered(limit=128, key=_depends_on)
def straight_body(part: Part, around: Array | None, resolution: int) -> Body:
    """Return the body of a part that goes straight through, in the frame of the part's group.

    Parameters
    ----------
    part : Part
        Its surface is "straight".
    around : (2, 3) float array, optional
        Corners of a box, in the same frame, around what it acts on: it reaches beyond that
        on both sides, or on the far one as deep as the part is, but not behind the eye.
        Without it, it is a slab as thick as the outline is wide, times its inflation.
    resolution : int
        Cells along the longest side of the outline and of what it acts on.

    Raises
    ------
    UserError
        If the part's ink is no outline, or for a cut no line across.
    """
    corners = None
    if around is not None:
        corners = part.placement.inverse().points(corners_of(around))
    outline = cut_side(part, corners) if isinstance(part, Cut) else outline_of(part)
    view_rays = view_rays_through(part.sheet, part.strokes[0].camera)
    radius = _inscribed_radius(outline)
    size = outline.size
    if corners is not None:
        size = max(size, float(np.ptp(corners, axis=0).max()))
    step = min(size / resolution, COARSEST * outline.size)
    plan = _plan(outline, step)
    if corners is None:
        half = part.inflation * radius
        low, high = view_rays.before_eye(-half, half)
    else:
        z = corners[:, 2]
        reach = CLEARANCE * size
        floor = -part.depth if part.depth > 0.0 else min(z.min(), 0.0) - reach
        low, high = view_rays.before_eye(floor, max(z.max(), 0.0) + reach)
    vertices, faces = _prism(plan, view_rays, low, high, WALL_PITCH * size / resolution)
    soundness = soundness_of(vertices, faces, outline)
    if not soundness.ok:
        raise UserError(
            "This outline is too intricate to go straight through. Draw it more simply."
        )
    rim = len(plan.after)
    body = Body(
        vertices,
        faces,
        vertex_normals(vertices, faces),
        np.zeros(len(vertices), np.int32),
        (part.id,),
        Sweep(RimDistance(plan.points[:rim], plan.after), view_rays, low, high),
        radius,
        step,
    )
    return body.placed(part.placement)


def corners_of(box: Array) -> Array:
    """Return the eight corners (8, 3) of a box (2, 3)."""
    grid = np.meshgrid(*box.T, indexing="ij")
    return np.stack([axis.ravel() for axis in grid], axis=1)


def _inscribed_radius(outline: Outline) -> float:
    import shapely

    circles = shapely.maximum_inscribed_circle(
        shapely.get_parts(outline.polygon()), tolerance=RADIUS_TOLERANCE * outline.size
    )
    return float(shapely.length(circles).max())


def _plan(outline: Outline, step: float) -> Plan:
    """Triangulate the inside of an outline, `step` apart in the thick places.

    Every drawn vertex is kept: both sides of a cut then have the same wall.
    """
    low, high = outline.bounds
    middle, scale = 0.5 * (low + high), outline.size
    unit = outline.transformed(1.0 / scale, -middle / scale)
    rim = sample_rim(unit.rings, step / scale, FINEST * step / scale, every_vertex=True)
    plan = plan_of(rim, np.zeros((0, 2)), step / scale)
    return replace(plan, points=plan.points * scale + middle)


def _prism(
    plan: Plan, view_rays: ViewRays, low: float, high: float, pitch: float
) -> tuple[Array, Faces]:
    """Make two caps and the walls between them, oriented outwards.

    Rows of the walls lie from the bottom to the top; the caps' rims are the first and the
    last of them.
    """
    rim, count = len(plan.after), len(plan.points)
    rows = max(1, int(np.ceil(min((high - low) / pitch, MOST_ROWS))))
    heights = np.linspace(low, high, rows + 1)
    rings = [view_rays.above(plan.points[:rim], z) for z in heights[1:-1]]
    bottom, top = (view_rays.above(plan.points, z) for z in (low, high))
    vertices = np.concatenate([bottom, top, *rings])
    starts = [0, *(2 * count + rim * k for k in range(rows - 1)), count]
    here, there = np.arange(rim), plan.after
    walls = []
    for below, above in pairwise(starts):
        walls += [
            np.stack([here + below, there + below, there + above], axis=1),
            np.stack([here + below, there + above, here + above], axis=1),
        ]
    faces = np.concatenate([plan.triangles[:, ::-1], plan.triangles + count, *walls])
    return vertices, faces.astype(np.int32)
