"""Measures of how close a solid is to its drawing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Faces
from bozzetto.plugin import remembered
from bozzetto_silhouette.analysis.projected_outline import shadow_of
from bozzetto_silhouette.inflation.manifold_check import soundness_of
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.outline.medial_axis import Skeleton
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.outline.signed_distance import RimDistance

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

FLATTENED = 0.02
"""Share of the area that the flattest places are: less is not seen."""

DENSIFY = 2.5e-3
"""Spacing of the Hausdorff distance's samples, as a share of the diagonal."""


@dataclass(frozen=True)
class Fidelity:
    """Figures that a person can be shown.

    Attributes
    ----------
    iou : float
        Area of the intersection over that of the union, of the exact projection of the
        solid along z and the drawn polygon.
    hausdorff : float
        Largest distance between the two outlines, in outline units.
    hausdorff_share : float
        The same as a share of the diagonal.
    worst_place : (x, y)
        Where that distance occurs.
    status : str
        The verdict of `soundness_of`.
    watertight : bool
        Whether the mesh bounds a solid.
    volume, area : float
        Of the solid and of its surface, in outline units.
    genus, expected_genus : int
        Handles, and drawn holes.
    components, expected_components : int
        Bodies, and drawn outer rings.
    thickness_ratio : float
        Greatest half thickness over the greatest inscribed radius; 1 is round.
    flattest : float
        Half thickness over the height of the inscribed balls, in the flattest fiftieth of the
        area that has balls under it; 1 is round, less is flattened somewhere.
    asymmetry : float
        Difference between front and back, as a share of the depth.
    """

    iou: float
    hausdorff: float
    hausdorff_share: float
    worst_place: tuple[float, float]
    status: str
    watertight: bool
    volume: float
    area: float
    genus: int
    expected_genus: int
    components: int
    expected_components: int
    thickness_ratio: float
    flattest: float
    asymmetry: float

    @property
    def topology_ok(self) -> bool:
        """Whether the solid has the topology of the drawing."""
        return (
            self.watertight
            and self.volume > 0.0
            and self.genus == self.expected_genus
            and self.components == self.expected_components
        )


def measure(solid: SilhouetteSolid, outline: Outline | None = None) -> Fidelity:
    """Compare a solid with an outline, by default the one it was made from."""
    outline = solid.outline if outline is None else outline
    sound = soundness_of(solid.vertices, solid.faces, outline)
    drawn = outline.polygon()
    shadow = _shadow(solid)
    if not drawn.is_valid:
        drawn = drawn.buffer(0)
    union = drawn.union(shadow).area
    iou = drawn.intersection(shadow).area / union if union > 0 else 0.0
    far, place = _hausdorff(drawn.boundary, shadow.boundary, DENSIFY * outline.diagonal)
    radius = float(solid.skeleton.nodes[:, 2].max())
    z = solid.vertices[:, 2]
    depth = float(z.max() - z.min())
    return Fidelity(
        iou=float(iou),
        hausdorff=far,
        hausdorff_share=far / outline.diagonal,
        worst_place=place,
        status=sound.status,
        watertight=sound.watertight,
        volume=sound.volume,
        area=area_of(solid.vertices, solid.faces),
        genus=sound.genus,
        expected_genus=sound.expected_genus,
        components=sound.components,
        expected_components=sound.expected_components,
        thickness_ratio=0.5 * depth / radius,
        flattest=_flattest(solid),
        asymmetry=float(abs(z.max() + z.min()) / depth) if depth > 0 else 0.0,
    )


def _flattest(solid: SilhouetteSolid) -> float:
    """Return the share of a round section's height that is left in the flattest places."""
    corners, triangles = solid.plan.points, solid.plan.triangles
    a, b, c = corners[triangles].transpose(1, 0, 2)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    area = 0.5 * np.abs(ux * vy - uy * vx)
    balls = _inscribed(solid).heights((a + b + c) / 3.0)
    inside = balls > 0.0
    if not inside.any():
        return 1.0
    heights = [np.sqrt(np.maximum(side[triangles].mean(axis=1), 0.0))
               for side in (solid.front, solid.back)]  # fmt: skip
    share = 0.5 * (heights[0] + heights[1])[inside] / balls[inside]
    order = np.argsort(share)
    below = np.cumsum(area[inside][order])
    return float(share[order][np.searchsorted(below, FLATTENED * below[-1])])


def _inscribed(solid: SilhouetteSolid) -> Skeleton:
    """Return the balls of a solid's skeleton, none larger than the outline around it allows.

    A disc has two beside its middle that are as large as itself.
    """
    nodes, rim = solid.skeleton.nodes, len(solid.plan.after)
    room = RimDistance(solid.plan.points[:rim], solid.plan.after)(nodes[:, :2]).distance
    fitting = np.minimum(nodes[:, 2], np.maximum(room, 0.0))
    return Skeleton(np.column_stack([nodes[:, :2], fitting]), solid.skeleton.edges)


def deviation_along(solid: SilhouetteSolid, ring: Array) -> tuple[Array, Array]:
    """Measure how far a solid's silhouette is from a drawn ring, along the ring.

    Returns
    -------
    points : (n, 2) float array
        Closely along the ring; the last is the first.
    distance : (n,) float array
        From each to the silhouette, in outline units.
    """
    import shapely

    border = _shadow(solid).boundary
    spacing = DENSIFY * solid.outline.diagonal
    points = shapely.get_coordinates(shapely.segmentize(shapely.LinearRing(ring), spacing))
    if shapely.is_empty(border):
        return points, np.full(len(points), np.inf)
    tree = shapely.STRtree(_pieces(border))
    _, gap = tree.query_nearest(shapely.points(points), return_distance=True, all_matches=False)
    return points, np.asarray(gap, np.float64)


@remembered(limit=8)
def _shadow(solid: SilhouetteSolid) -> BaseGeometry:
    """Return the projection of a solid; remembered, for all rings of an outline need it."""
    return shadow_of(solid.vertices, solid.faces)


def area_of(vertices: Array, faces: Faces) -> float:
    """Return the area of a mesh (v, 3), (f, 3)."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _hausdorff(one: object, other: object, spacing: float) -> tuple[float, tuple[float, float]]:
    """Return the Hausdorff distance of two line geometries, and the place where it occurs."""
    import shapely

    if shapely.is_empty(one) or shapely.is_empty(other):
        return float("inf"), (float("nan"), float("nan"))
    worst, place = 0.0, (0.0, 0.0)
    for a, b in ((one, other), (other, one)):
        points = shapely.get_coordinates(shapely.segmentize(a, spacing))
        tree = shapely.STRtree(_pieces(b))
        _, gap = tree.query_nearest(shapely.points(points), return_distance=True, all_matches=False)
        k = int(np.argmax(gap))
        if gap[k] > worst:
            worst, place = float(gap[k]), (float(points[k, 0]), float(points[k, 1]))
    return worst, place


def _pieces(lines: object) -> np.ndarray:
    """Split a line geometry into single segments, so that a tree can find the nearest."""
    import shapely

    result = []
    for part in shapely.get_parts(lines):
        for line in shapely.get_parts(part):
            p = shapely.get_coordinates(line)
            result.append(shapely.linestrings(np.stack([p[:-1], p[1:]], axis=1)))
    return np.concatenate(result)
