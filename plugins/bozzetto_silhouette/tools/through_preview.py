"""Lines of sight through the shape, shown before anything is cut."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.ink import Stroke, resample
from bozzetto.scene import Layer, Lines, Scene
from bozzetto.view import Camera, Rays
from bozzetto_silhouette.model.sketch_plane import Sheet
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import points_on_sheet
from bozzetto_silhouette.view.picking import Touch, shape_seen

LOOKS = 96
"""Lines of sight along an outline."""

RULED = 8
"""Of so many lines of sight one is drawn, from where it goes in to where it comes out."""

WIDTHS = (2.0, 1.0)
"""Widths of lines on the surface and of lines of sight inside, px."""


class Trace(NamedTuple):
    """The places where n lines of sight enter the shape, and where they leave it for good.

    Attributes
    ----------
    touch : Touch
        The shape.
    near, far : (n, 3) float array
        NaN where they pass it by.
    """

    touch: Touch
    near: Array
    far: Array

    @property
    def hit(self) -> Flags:
        """Which of them meet the shape."""
        return np.asarray(np.isfinite(self.near).all(axis=1) & np.isfinite(self.far).all(axis=1))

    def parts(self, state: SilhouetteState) -> list[Part]:
        """Return the parts whose surface is met."""
        points = np.concatenate([self.near[self.hit], self.far[self.hit]])
        return parts_at(state, self.touch, points)

    def scene(self, *, through: bool) -> Scene:
        """Show the line on the surface; with `through` also the far side and lines between."""
        sides = (self.near, self.far) if through else (self.near,)
        items = [_lines([run for side in sides for run in _runs(side, self.hit)], WIDTHS[0])]
        if through:
            ruled = np.flatnonzero(self.hit)[::RULED]
            items.append(_lines(np.stack([self.near[ruled], self.far[ruled]], axis=1), WIDTHS[1]))
        return Scene((Layer("preview", tuple(item for item in items if len(item.points))),))


def trace_of(touch: Touch, pixels: Array, camera: Camera) -> Trace:
    """Follow lines of sight through canvas positions (n, 2) into a shape and out of it."""
    rays = camera.rays(pixels)
    near = touch.hits(rays)
    with np.errstate(invalid="ignore"):
        box = touch.body.bounds
        away = np.linalg.norm(box[0] - rays.origins, axis=1)
        reach = away + 2.0 * np.linalg.norm(box[1] - box[0])
        beyond = rays.origins + reach[:, None] * rays.directions
    return Trace(touch, near.points, touch.hits(Rays(beyond, -rays.directions)).points)


def trace_through(state: SilhouetteState, strokes: Sequence[Stroke], sheet: Sheet) -> Trace | None:
    """Follow lines of sight through a closed outline on a sheet; None where there is no shape."""
    touch = shape_seen(state)
    if touch is None:
        return None
    ring = resample(np.concatenate(points_on_sheet(strokes, sheet)), count=LOOKS, closed=True)
    pixels, _ = strokes[0].camera.project(sheet.to_world(np.vstack([ring, ring[:1]])))
    return trace_of(touch, pixels, strokes[0].camera)


def parts_at(state: SilhouetteState, touch: Touch, points: Array) -> list[Part]:
    """Return the parts that made a shape's surface at points (n, 3) on it."""
    from scipy.spatial import cKDTree

    if not len(points):
        return []
    body = touch.body
    nearest = cKDTree(body.vertices).query(points)[1]
    sources = {body.sources[k] for k in np.unique(body.origins[nearest])}
    return [part for part in state.parts if part.id in sources]


def _runs(line: Array, hit: Flags) -> list[Array]:
    """Return the stretches of a line that lie on the shape."""
    places = np.flatnonzero(hit)
    pieces = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    return [line[piece] for piece in pieces if len(piece) > 1]


def _lines(runs: Sequence[Array] | Array, width: float) -> Lines:
    """Join polylines (n, 3) into one item."""
    starts = np.cumsum([0, *(len(run) for run in runs[:-1])])
    points = np.concatenate([*runs, np.zeros((0, 3))]).astype(np.float32)
    return Lines(points, starts.astype(np.int32), color="accent", width=width)
