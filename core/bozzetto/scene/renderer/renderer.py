"""One picture of a scene: surfaces, then lines and dots, then handles and labels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby, product
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.errors import UserError
from bozzetto.scene.display_list import (
    Handle,
    Image,
    Item,
    Label,
    Lines,
    Points,
    Scene,
    Shaded,
)
from bozzetto.scene.renderer.image_layers import apart, blend_pictures, place_picture
from bozzetto.scene.renderer.labels import draw_label
from bozzetto.scene.renderer.lines_and_points import (
    BIAS,
    Canvas,
    draw_discs,
    draw_lines,
    draw_points,
)
from bozzetto.scene.renderer.surfaces import Pictures, Style, Veil, draw_surfaces, see_through
from bozzetto.scene.renderer.view_transform import ViewTransform, view_transform

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Bytes, Floats
    from bozzetto.scene.palette import Palette
    from bozzetto.scene.renderer.shading import Shading
    from bozzetto.view.camera import Camera

Window = tuple[int, int, int, int]

FINENESS = 2
"""Samples per pixel along each axis in anti-aliased pictures."""

MOST_PIXELS = 64_000_000
"""Largest picture, px: four bytes each, about 8000 × 8000."""

BAND_VALUES = 12_000_000
"""Samples times layers worked on at once; larger pictures are made in bands."""

HALO = 48
"""Rows (px) around a band that are drawn and thrown away, so that hollows and contours do
not know about the band."""

ALIGNMENT = 8
"""Windows begin at multiples of this (px), so that all sample depth at the same places."""

SLOPE_SLACK = 2.5
"""Pixels' worth of its own slope by which a surface gives way to a line on it."""

HANDLE_RADIUS, HANDLE_RIM = 9.0, 2.0
"""Radius of a handle's disc and width of the dark rim around it, px."""


def _go_on() -> None:
    """Continue: nobody wants to stop."""


def render(
    scene: Scene,
    camera: Camera,
    palette: Palette,
    *,
    size: tuple[float, float] | None = None,
    scale: float = 1.0,
    shading: Shading = "clay",
    background: bool = True,
    antialias: bool = True,
    checkpoint: Callable[[], None] = _go_on,
) -> Bytes:
    """Draw a scene as a picture; the same input gives the same picture, bit for bit.

    Parameters
    ----------
    scene : Scene
        What to draw.
    camera : Camera
        Its vertical field of view fills the picture's height.
    palette : Palette
        Colours of the theme.
    size : (width, height), optional
        Canvas pixels; the camera's viewport if absent.
    scale : float
        Picture pixels per canvas pixel (the screen's device pixel ratio): a picture of
        ``size · scale``, with lines that much wider.
    shading : {"clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"}
        How surfaces are shaded.
    background : bool
        Paper behind everything; else the picture is transparent there.
    antialias : bool
        Four samples for each pixel of a surface; lines and pictures are always smooth.
    checkpoint : callable
        Called between stages; what it raises passes through, so that a picture can be given up.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, sRGB, straight alpha.

    Raises
    ------
    UserError
        If the picture would have no pixels, or more than `MOST_PIXELS`.
    """
    width, height = (round(float(v) * scale) for v in (size or camera.viewport))
    if width < 1 or height < 1:
        raise UserError("A picture needs a width and a height of at least one pixel.")
    if width * height > MOST_PIXELS:
        raise UserError(
            f"A picture of {width} × {height} pixels is too large. Stay below "
            f"{MOST_PIXELS // 1_000_000} million pixels, for example 8000 × 8000."
        )
    style = Style(palette, shading, FINENESS if antialias else 1, checkpoint)
    paper = (*palette.paper, 1.0) if background else (0.0,) * 4
    items = [item for _, item in scene.items()]
    result = np.empty((height, width, 4), np.uint8)
    for top, bottom in _bands(width, height, style.fineness**2 * _layers(items, shading)):
        above = max(0, top - HALO)
        below = min(height, bottom + HALO)
        window = (0, above, width, below - above)
        pixels = _drawn(items, camera, (width, height), window, scale, paper, style)
        band = pixels.reshape(below - above, width, 4)[top - above : bottom - above]
        result[top:bottom] = _finished(band, opaque=background)
    return result


def _layers(items: Sequence[Item], shading: Shading) -> int:
    """Return how many values each sample holds: the surface, and every translucent sheet."""
    sheets = [2 if see_through(i, shading) else 0 for i in items if isinstance(i, Shaded)]
    pictures = sum(isinstance(item, Image) for item in items)
    return 1 + sum(sheets) + (pictures if any(isinstance(i, Shaded) for i in items) else 0)


def _bands(width: int, height: int, depth: int) -> Iterator[tuple[int, int]]:
    rows = max(ALIGNMENT, BAND_VALUES // (width * depth) // ALIGNMENT * ALIGNMENT)
    for top in range(0, height, rows):
        yield top, min(height, top + rows)


def _finished(pixels: Floats, *, opaque: bool) -> Bytes:
    """Return bytes of straight alpha."""
    if opaque:
        result = (pixels + np.float32(0.5)).astype(np.uint8)
        result[..., 3] = 255
        return result
    rgb, alpha = pixels[..., :3], pixels[..., 3:]
    straight = np.divide(rgb, alpha, out=np.zeros_like(rgb), where=alpha > 0)
    both = np.concatenate((straight, alpha * np.float32(255)), -1)
    return np.clip(both + np.float32(0.5), 0, 255).astype(np.uint8)


def _drawn(
    items: Sequence[Item],
    camera: Camera,
    size: tuple[int, int],
    window: Window,
    scale: float,
    background: tuple[float, ...],
    style: Style,
) -> Floats:
    """Render a window of the picture, shape (h · w, 4): colour times opacity, opacity."""
    width, height = size
    _, _, w, h = window
    fineness = style.fineness
    paper = np.array(background, np.float32)
    pixels = np.empty((h * w, 4), np.float32)
    pixels[:] = paper
    sight = view_transform(camera, height, width, window)
    images = [place_picture(item, sight) for item in items if isinstance(item, Image)]
    surfaces = [item for item in items if isinstance(item, Shaded)]
    corners = _corners(surfaces, sight)
    before, after = apart([one for one in images if one is not None], corners)
    blend_pictures(pixels, before, sight)
    style.checkpoint()
    canvas = Canvas(pixels, np.full((h, w), -np.inf, np.float32), None, sight, scale)
    part = _occupied(corners, sight)
    if part is not None:
        x, y, part_w, part_h = part
        inner = (window[0] + x, window[1] + y, part_w, part_h)
        fine = view_transform(camera, height, width, inner, fineness)
        inside = np.s_[y : y + part_h, x : x + part_w]
        samples = _enlarged(pixels.reshape(h, w, 4)[inside], fineness)
        pictures = Pictures(before, paper, (x, y))
        drawn = draw_surfaces(samples, surfaces, pictures, fine, style)

        def rows(values: Floats) -> Floats:
            return values.reshape(fine.height, fine.width, *values.shape[1:])

        def limit(nearness: Floats) -> Floats:
            return sight.backed(_threshold(rows(nearness), fineness), BIAS * scale)

        pixels.reshape(h, w, 4)[inside] = _reduced(rows(samples), fineness)
        canvas.surface[inside] = limit(drawn.nearness)
        if drawn.veil is not None:
            veil = Veil(
                np.full((h, w), -np.inf, np.float32), np.zeros((h, w), np.float32), pixels.copy()
            )
            veil.nearness[inside] = limit(drawn.veil.nearness)
            veil.opacity[inside] = _reduced(rows(drawn.veil.opacity), fineness)
            veil.behind.reshape(h, w, 4)[inside] = _reduced(rows(drawn.veil.behind), fineness)
            blend_pictures(veil.behind, after, sight)
            canvas = replace(canvas, veil=veil)
        style.checkpoint()
    blend_pictures(pixels, after, sight)
    _draw_marks(canvas, items, style.palette)
    return pixels


def _enlarged(pixels: Floats, fineness: int) -> Floats:
    """Repeat each pixel (h, w, 4) for its samples along both axes, row by row, (n, 4)."""
    return np.repeat(np.repeat(pixels, fineness, 0), fineness, 1).reshape(-1, 4)


def _corners(items: Sequence[Shaded], sight: ViewTransform) -> Array | None:
    """Return corners of the meshes' boxes: x, y (px), nearness; None if some are behind the eye."""
    boxes = [item.mesh.bounds for item in items if np.isfinite(item.mesh.bounds).all()]
    corners = [np.array(list(product(*box.T))) for box in boxes]
    seen = sight.seen(np.concatenate([np.zeros((0, 3)), *corners]))
    return None if (seen[:, 2] < sight.near).any() else sight.placed(seen)


def _occupied(corners: Array | None, sight: ViewTransform) -> Window | None:
    """Return the part of a window that meshes can reach; None if they reach nothing."""
    if corners is None:
        return (0, 0, sight.width, sight.height)
    if not len(corners):
        return None
    limit = np.array((sight.width, sight.height))
    low = np.clip(corners[:, :2].min(0) - 2, 0, limit).astype(int) // ALIGNMENT * ALIGNMENT
    high = np.clip(np.ceil(corners[:, :2].max(0)) + 2, 0, limit).astype(int)
    if (high <= low).any():
        return None
    return (int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))


def _reduced(samples: Floats, fineness: int) -> Floats:
    """Return the mean of each pixel's samples."""
    total = samples[::fineness, ::fineness].copy()
    for row, column in product(range(fineness), repeat=2):
        if row or column:
            total += samples[row::fineness, column::fineness]
    total *= np.float32(1.0 / fineness**2)
    return total


def _threshold(nearness: Floats, fineness: int) -> Floats:
    """Return the nearness above which a line is in front of the surface at a pixel, or on it.

    The surface's slope is allowed for, since the line crosses the pixel anywhere: on each
    axis the smaller of the steps to both neighbours, so that an edge of the surface,
    where one step is large, hides what passes behind it right up to its rim.
    """
    near = nearness[::fineness, ::fineness].copy()
    for row, column in product(range(fineness), repeat=2):
        np.maximum(near, nearness[row::fineness, column::fineness], out=near)
    slack = np.zeros_like(near)
    for axis in (0, 1):
        with np.errstate(invalid="ignore"):  # nothing beside nothing
            step = np.nan_to_num(np.abs(np.diff(near, axis=axis)), nan=np.inf, posinf=np.inf)
        before, after = [(0, 0), (0, 0)], [(0, 0), (0, 0)]
        before[axis], after[axis] = (1, 0), (0, 1)
        least = np.minimum(
            np.pad(step, before, constant_values=np.inf),
            np.pad(step, after, constant_values=np.inf),
        )
        slack += np.where(np.isfinite(least), least, np.float32(0))
    return np.asarray(near - np.float32(SLOPE_SLACK) * slack, np.float32)


def _draw_marks(canvas: Canvas, items: Sequence[Item], palette: Palette) -> None:
    marks = [i for i in items if isinstance(i, Lines | Points) and len(i.points) and i.opacity > 0]
    for style, group in groupby(marks, _style):
        color = np.array(palette.color(style[0]), float)
        batch = list(group)
        lines = [item for item in batch if isinstance(item, Lines)]
        if lines:
            draw_lines(canvas, lines, color)
        for item in batch:
            if isinstance(item, Points):
                draw_points(canvas, item, color)
    _draw_handles(canvas, [item for item in items if isinstance(item, Handle)], palette)
    for label in (item for item in items if isinstance(item, Label)):
        draw_label(canvas, label, palette)


def _style(item: Lines | Points) -> tuple[str | tuple[int, int, int], float, str, bool]:
    """Return the style of an item: neighbours in drawing order that share it are drawn as one."""
    return item.color, item.opacity, item.hidden, isinstance(item, Lines)


def _draw_handles(canvas: Canvas, items: Sequence[Handle], palette: Palette) -> None:
    """Draw discs with dark rims, each over those before it."""
    if not items:
        return
    seen = canvas.sight.seen([item.point for item in items])
    shown = np.flatnonzero(seen[:, 2] >= canvas.sight.near)
    places = canvas.sight.placed(seen[shown])
    colors = [items[k].color for k in shown.tolist()]
    radius, rim = HANDLE_RADIUS * canvas.scale, HANDLE_RIM * canvas.scale
    dark = np.array(min(palette.ink, palette.paper, key=sum), float)
    for layer in _drawn_at_once(places, 2.0 * radius + 2.0):
        draw_discs(canvas, places[layer], radius, dark, 1.0)
        for paint in dict.fromkeys(colors[k] for k in layer):
            own = [k for k in layer if colors[k] == paint]
            color = np.array(palette.color(paint), float)
            draw_discs(canvas, places[own], radius - rim, color, 1.0)


def _drawn_at_once(places: Array, gap: float) -> list[list[int]]:
    """Return layers of places (n, 2 or more) that lie at least a gap apart, px, the lowest first.

    Each place is in the layer above the highest of those before it that are nearer than the gap.
    """
    away = np.abs(places[:, None, :2] - places[None, :, :2]).max(axis=2)
    level = np.zeros(len(places), np.intp)
    for k in range(1, len(places)):
        level[k] = level[:k][away[k, :k] < gap].max(initial=-1) + 1
    return [np.flatnonzero(level == own).tolist() for own in range(level.max(initial=-1) + 1)]
