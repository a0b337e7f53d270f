"""The scene of a symmetry model: the box, the curves, their uncertainty, what waits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.geometry import FLATNESS, flattened
from bozzetto.ink import resample
from bozzetto.plugin import remembered
from bozzetto.scene import Layer, Lines, Paint, Scene
from bozzetto.view import Camera
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.operations.construction_lines import line_layer
from bozzetto_symmetry.solve.curve_solver import Trace, View
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.view.box import box_layers
from bozzetto_symmetry.view.drawing_plane import plane_layers
from bozzetto_symmetry.view.uncertainty_bands import heat_bands
from bozzetto_symmetry.view.unmatched_ink import unmatched_ink

WIDTH: Final = 2.0
"""Width of a curve, px."""

CHOSEN_WIDTH: Final = 3.0
"""Width of the chosen curve, px."""

FINER: Final = 0.2
"""Share of the flatness that is invisible in the view of the ink: one looks from nearer, too."""

LOOSE_WIDTH: Final = 1.2
"""Width of ink without a partner, px: thin, for it is no curve."""

FAN: Final = 24
"""Rays that are shown of a side that waits for the other."""


def scene_of(state: SymmetryState, traces: Mapping[str, Trace]) -> Scene:
    """Return the box, the curves, the chosen one's uncertainty, and what waits."""
    layers = [*box_layers(state), *plane_layers(state)]
    shown = [(curve, traces[curve.id]) for curve in state.shown_curves if curve.id in traces]
    layers.append(Layer("curves", tuple(_items(state, shown))))
    layers.append(Layer("chosen curve", tuple(_chosen(state, shown)), chosen=True))
    layers.append(line_layer(state, state.shown_lines))
    for curve, trace in shown:
        if curve.id == state.selected and trace.curve is not None:
            layers.append(Layer("heat", tuple(_heat(state, trace)), chosen=True))
            if trace.ghost is not None:
                items = curve_lines(trace.ghost, state, camera_of(trace), "ghost", 1.0, 0.7)
                layers.append(Layer("ghost", items, chosen=True))
            if not curve.edits and (loose := unmatched_ink(trace)):
                pieces = [state.plane.placement.points(end) for end in loose]
                items = (joined(pieces, "warning", LOOSE_WIDTH),)
                layers.append(Layer("loose ends", items, chosen=True))
    waiting = [(c, t) for c, t in shown if t.reading == "half"]
    fans = [item for _, trace in waiting for view in trace.views for item in fan(view, state)]
    layers.append(Layer("waiting", tuple(fans)))
    inks = [
        Lines(ink, color="accent", width=CHOSEN_WIDTH, hidden="show")
        for curve, trace in waiting
        if curve.id == state.selected
        for view in trace.views
        for ink, _ in _waiting(view, state)
    ]
    layers.append(Layer("waiting ink", tuple(inks), chosen=True))
    return Scene(tuple(layer for layer in layers if layer.items))


def _items(state: SymmetryState, shown: Sequence[tuple[Curve, Trace]]) -> Iterable[Lines]:
    for curve, trace in shown:
        if trace.curve is not None:
            camera, color = camera_of(trace), curve.color or "ink"
            yield from curve_lines(trace.curve, state, camera, color, WIDTH)


def _chosen(state: SymmetryState, shown: Sequence[tuple[Curve, Trace]]) -> Iterable[Lines]:
    """Yield the chosen curve again, over those that are there always."""
    for curve, trace in shown:
        if curve.id == state.selected and trace.curve is not None:
            camera = camera_of(trace)
            yield from curve_lines(trace.curve, state, camera, "accent", CHOSEN_WIDTH)


def camera_of(trace: Trace) -> Camera:
    """Return the camera, in the plane's frame, through which a curve was drawn first."""
    return trace.views[0].stereo.camera


def curve_lines(
    curve: SpaceCurve,
    state: SymmetryState,
    camera: Camera,
    color: Paint,
    width: float,
    opacity: float = 1.0,
) -> tuple[Lines, ...]:
    """Return a curve as lines in the frame of the model; the mirror image in the second colour.

    Parameters
    ----------
    curve : SpaceCurve
        The curve, in the frame of the plane.
    state : SymmetryState
        Its plane says where the curve is in the model.
    camera : Camera
        In the frame of the plane; it says how finely the curve is flattened.
    color : str or (r, g, b)
        Colour of the curve itself.
    width : float
        px.
    opacity : float
        Share of the light that the lines take, 0 … 1.
    """
    tolerance = FINER * FLATNESS / camera.pixels_per_mm
    return _flat_lines(curve, state.plane, tolerance, color, width, opacity)


@remembered(limit=512)
def _flat_lines(
    curve: SpaceCurve,
    plane: CentrePlane,
    tolerance: float,
    color: Paint,
    width: float,
    opacity: float,
) -> tuple[Lines, ...]:
    lines = []
    for number, spline in enumerate(curve.curves()):
        points = plane.placement.points(flattened(spline.beziers(), tolerance)[0])
        paint = "second" if number else color
        lines.append(Lines(points.astype(np.float32), color=paint, width=width, opacity=opacity))
    return tuple(lines)


def _heat(state: SymmetryState, trace: Trace) -> Iterable[Lines]:
    place = state.plane.placement
    sides = [trace.points] + ([trace.points * MIRROR] if trace.reading == "pair" else [])
    return heat_bands([(place.points(side), trace.sigma) for side in sides], state.diagonal)


def fan(view: View, state: SymmetryState) -> Iterable[Lines]:
    """Yield a side that waits: its ink inside the box, and rays on which its curve must lie."""
    for ink, pieces in _waiting(view, state):
        yield Lines(ink, color="ink", width=WIDTH, hidden="show")
        yield joined(pieces, "second", 1.0, 0.35)


def _waiting(view: View, state: SymmetryState) -> Iterable[tuple[NDArray[np.float32], Array]]:
    """Yield the ink of each side that waits, (n, 3) mm, and some of its rays, (m, 2, 3) mm."""
    for side in view.sides:
        begin, end = _in_box(view.stereo, side.pixels, state.bounds)
        if len(begin) < 2:
            continue
        place = state.plane.placement
        ink = place.points(_upright(view.stereo, begin, end, state.bounds)).astype(np.float32)
        rays = np.linspace(0, len(begin) - 1, min(FAN, len(begin))).astype(int)
        points = place.points(np.stack((begin[rays], end[rays]), axis=1).reshape(-1, 3))
        yield ink, points.reshape(-1, 2, 3)


def _upright(stereo: Stereo, begin: Array, end: Array, bounds: Array) -> Array:
    """Return ink where its rays cut the sheet through the middle of the box."""
    forward = stereo.camera.axes[2]
    whole = (end - begin) @ forward
    way = (bounds.mean(axis=0) - begin) @ forward
    share = np.divide(way, whole, out=np.full(len(way), 0.5), where=whole > 0.0)
    return np.asarray(begin + share[:, None] * (end - begin))


def joined(
    pieces: Sequence[Array] | Array, color: Paint, width: float, opacity: float = 1.0
) -> Lines:
    """Return polylines as one item, seen through everything."""
    starts = np.cumsum([0, *(len(piece) for piece in pieces[:-1])])
    points = np.concatenate(list(pieces)).astype(np.float32)
    return Lines(points, starts, color=color, width=width, opacity=opacity, hidden="show")


def _in_box(stereo: Stereo, pixels: Array, bounds: Array) -> tuple[Array, Array]:
    """Return where the rays of ink enter and leave the box, a fifth larger.

    A ray that misses the box keeps the depths of those that do not.
    """
    middle, half = bounds.mean(axis=0), 0.6 * np.ptp(bounds, axis=0)
    rays = stereo.rays(resample(pixels, count=max(2, min(len(pixels), 200))))
    with np.errstate(divide="ignore", invalid="ignore"):
        one = (middle - half - rays.origins) / rays.directions
        other = (middle + half - rays.origins) / rays.directions
    near = np.nanmax(np.minimum(one, other), axis=1)
    far = np.nanmin(np.maximum(one, other), axis=1)
    hits = (far > near) & (far > 0)
    if not hits.any():
        depth = np.einsum("nk,nk->n", middle - rays.origins, rays.directions)
        size = float(np.linalg.norm(half))
        near, far, hits = depth - size, depth + size, np.ones(len(depth), dtype=bool)
    near = np.where(hits, near, np.median(near[hits]))
    far = np.where(hits, far, np.median(far[hits]))
    if not stereo.parallel:
        near = np.maximum(near, 1e-3 * np.abs(far))
    return (
        rays.origins + near[:, None] * rays.directions,
        rays.origins + far[:, None] * rays.directions,
    )
