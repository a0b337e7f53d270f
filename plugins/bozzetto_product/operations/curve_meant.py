"""The curve that ink, or a hovering pen, is meant for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, distances_to_polyline, nearest_curve
from bozzetto.scene import Scene, cast_rays
from bozzetto.view import Camera, triple
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.planes import Point
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import spline_of
from bozzetto_product.projection.planes import mirror_image
from bozzetto_product.projection.views import pixel_size, seen_at

PIECES: Final = 24
"""Segments of an image for each span of the spline: within a tenth of a pixel of it."""

REACH: Final = 120.0
"""Mean distance, px, beyond which ink is meant for no curve."""

CHOSEN: Final = 0.6
"""The chosen curve seems nearer than it is by this factor: a person goes on with it."""


PLACES: Final = 257
"""Places of a curve among which the one under the pen is sought."""

BEHIND: Final = 3.0
"""How far behind a surface, in the lengths of the reach there, a curve still lies on it: where
that is seen aslant, the curve is beside the place under the pen."""

CLOSER: Final = 3
"""How often it is sought among as many, between the neighbours of the last one."""


@dataclass(frozen=True)
class CurveMeant:
    """A curve, or its mirror image, near the pen.

    Attributes
    ----------
    curve : str
        Its id.
    mirrored : bool
        The mirror image is nearer.
    distance : float
        px.
    """

    curve: str
    mirrored: bool
    distance: float


def curve_meant(
    state: ProductState, strokes: Sequence[Stroke], *, reach: float = REACH
) -> CurveMeant | None:
    """Find the curve that strokes are drawn over: the least mean distance on the sheet.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    strokes : sequence of Stroke
        Drawn in one view.
    reach : float
        Largest mean distance, px.

    Returns
    -------
    CurveMeant or None
    """
    if not strokes:
        return None
    images = _images(state, strokes[0].camera)
    ink = np.vstack([stroke.points for stroke in strokes]).astype(float)
    chosen = [image for image in images if image[0] == state.selected]
    best: CurveMeant | None = None
    for group, factor in ((images, 1.0), (chosen, CHOSEN)):
        found = _nearest(group, strokes, ink)
        if found is not None and (best is None or factor * found.distance <= best.distance):
            best = found
    return best if best is not None and best.distance <= reach else None


def curve_under(
    state: ProductState, camera: Camera, pixel: ArrayLike, *, reach: float = 12.0
) -> CurveMeant | None:
    """Find the curve under a hovering pen.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    camera : Camera
        Of the view.
    pixel : (2,) array_like
        Place of the pen, px.
    reach : float
        Largest distance, px.
    """
    return next(iter(_curves_under(state, camera, pixel, reach)), None)


def _curves_under(
    state: ProductState, camera: Camera, pixel: ArrayLike, reach: float
) -> list[CurveMeant]:
    """Return the curves under the pen, nearest first."""
    place = np.asarray(pixel, float).reshape(1, 2)
    found = [
        CurveMeant(name, mirrored, float(distances_to_polyline(place, path)[0]))
        for name, mirrored, path in _images(state, camera)
        if len(path)
    ]
    return sorted((one for one in found if one.distance <= reach), key=lambda one: one.distance)


@dataclass(frozen=True)
class CurvePlace:
    """A place of a curve, or of its mirror image, under the pen.

    Attributes
    ----------
    curve : str
        Id of the curve.
    at : float
        Share of its parameter range.
    point : (x, y, z)
        Where it is seen, mm: on the mirror image where that is meant.
    """

    curve: str
    at: float
    point: Point


def place_under(
    state: ProductState, camera: Camera, pixel: ArrayLike, surfaces: Scene, *, reach: float
) -> CurvePlace | None:
    """Find the place of a curve under the pen that no surface hides.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    camera : Camera
        Of the view.
    pixel : (2,) array_like
        Place of the pen, px.
    surfaces : Scene
        What may hide a curve.
    reach : float
        Largest distance, px.
    """
    rays = camera.rays(np.asarray(pixel, float).reshape(1, 2))
    hits = cast_rays(surfaces, rays)
    for found in _curves_under(state, camera, pixel, reach):
        place = _nearest_place(state, camera, pixel, found)
        behind = float((np.asarray(place.point) - hits.points[0]) @ rays.directions[0])
        slack = BEHIND * reach * float(pixel_size(camera, [place.point])[0])
        if not hits.hit[0] or behind <= slack:
            return place
    return None


def _nearest_place(
    state: ProductState, camera: Camera, pixel: ArrayLike, found: CurveMeant
) -> CurvePlace:
    """Return the place of a curve that is seen nearest to a pixel."""
    spline = spline_of(state, found.curve)
    begin, end = spline.range
    low, high = begin, end
    for _ in range(CLOSER):
        at = np.linspace(low, high, PLACES)
        points = spline.value(at)
        points = mirror_image(points, state.symmetry) if found.mirrored else points
        away = np.linalg.norm(seen_at(camera, points) - np.asarray(pixel, float), axis=1)
        best = int(np.nanargmin(away))
        low, high = at[max(0, best - 1)], at[min(len(at) - 1, best + 1)]
    share = float((at[best] - begin) / (end - begin))
    return CurvePlace(found.curve, share, triple(points[best]))


_Image = tuple[str, bool, Array]


def _images(state: ProductState, camera: Camera) -> list[_Image]:
    """Return the images of all visible curves: id, whether mirrored, and places, px."""
    found: list[_Image] = []
    for curve in state.shown(Curve):
        if curve.spline is None:
            continue
        points = curve.spline.sampled(PIECES * len(curve.spline.control_points))
        for mirrored in (False, True) if curve.mirrored else (False,):
            image = mirror_image(points, state.symmetry) if mirrored else points
            path = seen_at(camera, image)
            found.append((curve.id, mirrored, path[np.isfinite(path).all(axis=1)]))
    return found


def _nearest(images: Sequence[_Image], strokes: Sequence[Stroke], ink: Array) -> CurveMeant | None:
    paths = [path for _, _, path in images]
    if len(strokes) == 1:
        found = nearest_curve(paths, ink)
        if found is None:
            return None
        name, mirrored, _ = images[found.index]
        return CurveMeant(name, mirrored, found.distance)
    means = [
        float(distances_to_polyline(ink, path).mean()) if len(path) else np.inf for path in paths
    ]
    if not means or not np.isfinite(min(means)):
        return None
    best = int(np.argmin(means))
    return CurveMeant(images[best][0], images[best][1], means[best])
