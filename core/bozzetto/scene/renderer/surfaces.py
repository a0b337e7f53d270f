"""Meshes and pictures on a window of the sheet, opaque first, then translucent."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Flags, Floats, Index
from bozzetto.scene.palette import Palette
from bozzetto.scene.renderer.compositing import Sheet, blend_sheets, nearest_sheet
from bozzetto.scene.renderer.highlights import NO_SHEEN, SHEENS, with_highlights
from bozzetto.scene.renderer.image_layers import PlacedPicture, sheet_at
from bozzetto.scene.renderer.normals import mean_curvature
from bozzetto.scene.renderer.screen_space import cavities, contours
from bozzetto.scene.renderer.shading import (
    Fragments,
    Shading,
    curvature_colors,
    draft_colors,
    fragments,
    surface_colors,
)
from bozzetto.scene.renderer.textures import with_textures
from bozzetto.scene.renderer.triangle_soup import Soup, gather
from bozzetto.scene.renderer.zbuffer import DepthBuffer, blank_buffer, rasterize
from bozzetto.scene.renderer.zebra import with_zebra

if TYPE_CHECKING:
    from bozzetto.geometry.texture import Texture
    from bozzetto.scene.display_list import Shaded
    from bozzetto.scene.renderer.view_transform import ViewTransform

Samples = Index

XRAY_LEAST, XRAY_MOST = 0.10, 0.80
"""Opacity of x-rayed surfaces seen face on and edge on."""

XRAY_INK = 0.55
"""Part of ink in their colour."""


@dataclass(frozen=True)
class Style:
    """How a picture is made.

    Attributes
    ----------
    palette : Palette
        Colours of the theme.
    shading : {"clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"}
        How surfaces are shaded.
    fineness : int
        Samples per pixel along each axis.
    checkpoint : callable
        Called between stages; what it raises passes through.
    """

    palette: Palette
    shading: Shading
    fineness: int
    checkpoint: Callable[[], None]


@dataclass(frozen=True, eq=False)
class Veil:
    """Translucent meshes before lines: nearness and opacity.

    Attributes
    ----------
    nearness, opacity : (h · w,) float32
        Values of the nearest of them; −inf and 0 where there is none.
    behind : (h · w, 4) float32
        The picture without them.
    """

    nearness: Floats
    opacity: Floats
    behind: Floats


@dataclass(frozen=True, eq=False)
class Drawn:
    """The depths at which surfaces were drawn.

    Attributes
    ----------
    nearness : (h · w,) float32
        Nearness of the opaque surfaces; −inf where there is none.
    veil : Veil or None
        None if no mesh is translucent.
    """

    nearness: Floats
    veil: Veil | None


@dataclass(frozen=True, eq=False)
class Pictures:
    """Pictures round the part of the sheet where meshes are drawn.

    Attributes
    ----------
    hung : sequence of PlacedPicture
    paper : (4,) float32
        What is behind them: colour multiplied by opacity, opacity.
    offset : (x, y)
        Where the part begins, px of the pictures' window.
    """

    hung: Sequence[PlacedPicture]
    paper: Floats
    offset: tuple[int, int]

    def in_front(self, buffer: DepthBuffer, glass: Sequence[Sheet], fineness: int) -> Samples:
        """Return the samples at which some picture is in front of some mesh."""
        if not self.hung:
            return np.zeros(0, np.intp)
        farthest = np.where(buffer.triangle >= 0, buffer.nearness, np.float32(np.inf))
        for sheet in glass:
            farthest[sheet.pixel] = np.minimum(farthest[sheet.pixel], sheet.nearness)
        least = farthest.min()
        farthest = farthest.reshape(buffer.height, buffer.width)
        found = np.zeros(farthest.shape, bool)
        for picture in self.hung:
            window, nearness = self._nearness(picture, buffer, fineness)
            if nearness.size and nearness[[0, 0, -1, -1], [0, -1, 0, -1]].max() >= least:
                found[window] |= nearness >= farthest[window]
        return np.flatnonzero(found)

    def _nearness(
        self, picture: PlacedPicture, buffer: DepthBuffer, fineness: int
    ) -> tuple[tuple[slice, slice], Floats]:
        """Return the samples in a picture's box, and the nearness of its plane there."""
        ends = []
        sizes = (buffer.width, buffer.height)
        boxes = ((picture.left, picture.right), (picture.top, picture.bottom))
        for box, begin, size in zip(boxes, self.offset, sizes, strict=True):
            low, high = (int(np.clip((edge - begin) * fineness, 0, size)) for edge in box)
            ends.append((low, high))
        x, y = (
            begin + (np.arange(low, high) + 0.5) / fineness
            for begin, (low, high) in zip(self.offset, ends, strict=True)
        )
        across = (picture.plane[0] * x + picture.plane[2]).astype(np.float32)
        down = (picture.plane[1] * y).astype(np.float32)
        return (slice(*ends[1]), slice(*ends[0])), across + down[:, None]


def draw_surfaces(
    pixels: Floats,
    items: Sequence[Shaded],
    pictures: Pictures,
    sight: ViewTransform,
    style: Style,
) -> Drawn:
    """Draw meshes over pictures, and pictures over meshes where those are in front.

    Parameters
    ----------
    pixels : (h · w, 4) float32
        Written to: colour (0 … 255) multiplied by opacity, opacity (0 … 1). The pictures are
        there already.
    items : sequence of Shaded
        The meshes.
    pictures : Pictures
        Pictures in front of or behind some of the meshes.
    sight : ViewTransform
        The transform of the window.
    style : Style
        How the picture is made.
    """
    shaded = [i for i in items if len(i.mesh.faces) and i.opacity > 0]
    solid = [i for i in shaded if not see_through(i, style.shading)]
    buffer = blank_buffer(sight.width, sight.height)
    if solid:
        _draw_opaque(pixels, solid, buffer, sight, style)
        style.checkpoint()
    glass: list[Sheet] = []
    for item in shaded:
        if see_through(item, style.shading):
            sheets = _mesh_sheets(item, sight, style)
            glass += [sheet.before(buffer.nearness) for sheet in sheets] if solid else sheets
            style.checkpoint()
    crossing = pictures.in_front(buffer, glass, style.fineness)
    hung: list[Sheet] = []
    if len(crossing):
        pixels[crossing[buffer.triangle[crossing] < 0]] = pictures.paper
        hung = [
            sheet_at(one, crossing, sight.width, pictures.offset, style.fineness).before(
                buffer.nearness
            )
            for one in pictures.hung
        ]
    veil = None
    if glass:
        behind = pixels.copy()
        blend_sheets(behind, hung)
        veil = Veil(*nearest_sheet(glass, len(pixels)), behind)
    blend_sheets(pixels, hung + glass)
    return Drawn(buffer.nearness, veil)


def see_through(item: Shaded, shading: Shading) -> bool:
    """Whether what lies behind a mesh shows."""
    colors = item.mesh.colors
    return (
        shading == "xray"
        or item.opacity < 1
        or (colors is not None and bool((colors[:, 3] < 255).any()))
    )


def shown_texture(item: Shaded, shading: Shading) -> Texture | None:
    """Return the texture of a mesh; None where the shading has colours of its own."""
    return None if shading in ("curvature", "draft") else item.texture


def is_polished(item: Shaded, shading: Shading) -> bool:
    """Whether a mesh mirrors the tubes of the zebra."""
    return shading == "zebra" or (shading == "clay" and item.finish == "zebra")


def _vertex_colors(item: Shaded, style: Style) -> NDArray[np.generic] | None:
    if style.shading == "curvature":
        return curvature_colors(mean_curvature(item.mesh), style.palette)
    if style.shading == "draft":
        return draft_colors(item.mesh.vertex_normals(), style.palette)
    color = style.palette.color(item.color)
    own = item.mesh.colors_over(color)
    if own is None and item.texture is not None:
        return np.tile(np.array((*color, 255), np.uint8), (len(item.mesh.vertices), 1))
    return own


def _gathered(
    items: Sequence[Shaded], sight: ViewTransform, style: Style
) -> tuple[Soup, Flags, list[Texture | None]]:
    colors = [_vertex_colors(item, style) for item in items]
    tinted = np.array([own is not None for own in colors])
    textures = [shown_texture(item, style.shading) for item in items]
    return gather([item.mesh for item in items], colors, sight, textures), tinted, textures


def _draw_opaque(
    pixels: Floats, items: Sequence[Shaded], buffer: DepthBuffer, sight: ViewTransform, style: Style
) -> None:
    soup, tinted, textures = _gathered(items, sight, style)
    rasterize(buffer, soup.places, soup.faces, soup.doubled_areas() > 0)
    seen = fragments(buffer.triangle, soup, sight, tinted=bool(tinted.any()))
    if not len(seen.pixel):
        return
    seen = with_textures(seen, soup, textures, sight)
    normal = _spread_normals(seen, buffer)
    cavity = None
    matte = not all(is_polished(item, style.shading) for item in items)
    if matte and style.shading in ("clay", "curvature", "draft", "thickness"):
        cavity = cavities(buffer, sight, normal, style.fineness).ravel()[seen.pixel]
    rgb = _colors_of(seen, soup, items, tinted, sight, style, cavity)
    line = contours(buffer, sight, normal, style.fineness).ravel()[seen.pixel]
    drawn = np.flatnonzero(line > 0)
    ink = np.array(style.palette.ink, np.float32)
    rgb[drawn] += line[drawn, None] * (ink - rgb[drawn])
    pixels[seen.pixel, :3] = rgb
    pixels[seen.pixel, 3] = 1.0


def _colors_of(
    seen: Fragments,
    soup: Soup,
    items: Sequence[Shaded],
    tinted: Flags,
    sight: ViewTransform,
    style: Style,
    cavity: Floats | None = None,
) -> Floats:
    """Return colours of the visible parts of some meshes, (n, 3), 0 … 255."""
    part = soup.part[seen.triangle]
    colors = [style.palette.color(item.color) for item in items]
    polished = np.array([is_polished(item, style.shading) for item in items])
    if polished.any():
        seen = with_zebra(seen, part, colors, tinted, polished, sight)
        if cavity is not None:  # what is mirrored lies outside of the hollow
            cavity = np.where(polished[part], np.float32(0), cavity)
    found = surface_colors(
        seen, part, colors, tinted | polished, style.shading, style.palette, cavity
    )
    if style.shading == "clay" and any(item.finish in SHEENS for item in items):
        sheens = [SHEENS.get(item.finish, NO_SHEEN) for item in items]
        found = with_highlights(found, seen, np.array(sheens, np.float32)[part])
    return found


def _spread_normals(seen: Fragments, buffer: DepthBuffer) -> Floats:
    normal = np.zeros((3, buffer.height * buffer.width), np.float32)
    normal[:, seen.pixel] = seen.normal
    return normal.reshape(3, buffer.height, buffer.width)


def _mesh_sheets(item: Shaded, sight: ViewTransform, style: Style) -> list[Sheet]:
    """Return the nearest back and the nearest front of a mesh."""
    soup, tinted, textures = _gathered([item], sight, style)
    front = soup.doubled_areas() > 0
    sheets = []
    for side in (~front, front):
        half = soup.only(side)
        buffer = blank_buffer(sight.width, sight.height)
        rasterize(buffer, half.places, half.faces)
        seen = fragments(buffer.triangle, half, sight, tinted=bool(tinted.any()))
        seen = with_textures(seen, half, textures, sight)
        rgb = _colors_of(seen, half, [item], tinted, sight, style)
        opacity = np.full(len(seen.pixel), item.opacity, np.float32)
        if item.mesh.colors is not None and tinted.any():
            opacity *= seen.color[:, 3] / np.float32(255)
        if style.shading == "xray":
            grazing = np.square(np.float32(1) - seen.facing)
            rgb += np.float32(XRAY_INK) * (np.array(style.palette.ink, np.float32) - rgb)
            opacity *= np.float32(XRAY_LEAST) + np.float32(XRAY_MOST - XRAY_LEAST) * grazing
        sheets.append(Sheet(seen.pixel, buffer.nearness[seen.pixel], rgb, opacity))
    return sheets
