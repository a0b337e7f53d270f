"""Shading: from visible triangles to colours.

Only what is seen is shaded. Normals are interpolated (Phong) by the plane through a
triangle's corners, weighted with nearness so that they are right in perspective.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags, Floats, Index

if TYPE_CHECKING:
    from bozzetto.scene.palette import Color, Palette
    from bozzetto.scene.renderer.triangle_soup import Soup
    from bozzetto.scene.renderer.view_transform import ViewTransform

Shading = Literal["clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"]
SHADINGS: Final[tuple[str, ...]] = get_args(Shading)


KEY: Final = np.array((-0.46, 0.62, 0.64), np.float32)
"""Towards the key light, in the frame of the view: from the upper left, tied to the camera."""

WRAP: Final = 0.28
"""Reach of the key light round the terminator; matte clay scatters."""

KEY_SHARE: Final = 0.76
SKY_SHARE: Final = 0.38
RIM_SHARE: Final = 0.10
"""Parts of key, soft fill from above, and rim in the light."""

INSIDE: Final = 0.80
"""Light left on the inside of open surfaces."""

STEPS: Final = 1024
"""Entries in a ramp from dark to light."""

SHADOW: Final = (0.44, 0.39, 0.36)
"""Share of a colour that is left without light."""

BRIGHTEST: Final = 1.25
"""Light at the end of a ramp; the colour itself is shown at 1."""

CURVATURE_STEPS: Final = 1.6
"""Slope of the colour scale of curvature at zero."""


DRAFT: Final = 3.0
"""Angle to the vertical, degrees, from which on a surface leaves its mould well."""


@dataclass(frozen=True, eq=False)
class Fragments:
    """Visible surface, pixel by pixel.

    Attributes
    ----------
    pixel : (n,) int
        Index in the window, row by row.
    triangle : (n,) int32
        In the soup.
    normal : (3, n) float32
        Unit vectors right, up, towards the eye; turned to the seen side.
    facing : (n,) float32
        Cosine between normal and line of sight, 0 … 1.
    inside : (n,) bool
        Where a triangle shows its back.
    color : (n, 4) float32
        Interpolated vertex colours, 0 … 255.
    """

    pixel: Index
    triangle: NDArray[np.int32]
    normal: Floats
    facing: Floats
    inside: Flags
    color: Floats


def fragments(
    triangle: NDArray[np.int32], soup: Soup, sight: ViewTransform, *, tinted: bool
) -> Fragments:
    """Interpolate over the visible triangles.

    Parameters
    ----------
    triangle : (h · w,) int32
        Triangles of a buffer; −1 where nothing is seen.
    soup : Soup
        The triangles on the sheet.
    sight : ViewTransform
        The transform of the window.
    tinted : bool
        Whether vertex colours are wanted; else `Fragments.color` is empty.
    """
    pixel = np.flatnonzero(triangle >= 0)
    seen = triangle[pixel]
    spread = _Spread(pixel, seen, soup, sight)
    corners = soup.corners[spread.visible]
    normal = spread.values(soup.normals[corners] * spread.weight)
    length = np.sqrt(np.einsum("kn,kn->n", normal, normal))
    normal /= np.where(length > 0, length, 1.0)
    inside = _backs(spread.places)[spread.row]
    normal *= np.where(inside, np.float32(-1), np.float32(1))
    normal[2, length == 0] = 1.0

    facing = normal[2].copy()
    if sight.perspective:
        slope_x = ((sight.middle[0] - spread.right) / sight.focal).astype(np.float32)
        slope_y = ((spread.down - sight.middle[1]) / sight.focal).astype(np.float32)
        facing += normal[0] * slope_x + normal[1] * slope_y
        facing /= np.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    np.clip(facing, 0.0, 1.0, out=facing)

    color = np.zeros((0, 4), np.float32)
    if tinted:
        colors = soup.colors[soup.faces[spread.visible]]
        color = np.clip(spread.true_values(colors).T, 0.0, 255.0)
    return Fragments(pixel, seen, normal, facing, inside, color)


def at_pixels(
    pixel: Index,
    triangle: NDArray[np.int32],
    values: NDArray[np.floating],
    soup: Soup,
    sight: ViewTransform,
) -> Floats:
    """Interpolate values over triangles as they lie in space.

    Parameters
    ----------
    pixel : (n,) int
        In the window, row by row.
    triangle : (n,) int
        The triangle seen there.
    values : (t, 3, k) float
        At the corners of all triangles.
    soup : Soup
        The triangles on the sheet.
    sight : ViewTransform
        The transform of the window.

    Returns
    -------
    (k, n) float32
    """
    spread = _Spread(pixel, triangle, soup, sight)
    return spread.true_values(values[spread.visible])


class _Spread:
    """Where some pixels lie on the triangles that are seen there.

    Attributes
    ----------
    visible : (t,) bool
        Triangles that are seen at any of the pixels; others arrays have a row for each of these.
    places : (m, 3, 3) float
        Their corners: x, y (px), nearness.
    weight : (m, 3, 1) float
        What values are multiplied by to be affine on the sheet.
    row : (n,) int32
        The row of each pixel.
    right, down : (n,) float
        Middles of the pixels, px.
    """

    def __init__(
        self, pixel: Index, triangle: NDArray[np.int32], soup: Soup, sight: ViewTransform
    ) -> None:
        self.visible = np.zeros(len(soup.faces), bool)
        self.visible[triangle] = True
        self.row = np.cumsum(self.visible, dtype=np.int32)[triangle] - 1
        self.places = soup.places[soup.faces[self.visible]]
        ones = np.ones((len(self.places), 3, 1))
        self.weight = self.places[:, :, 2:] if sight.perspective else ones
        y, x = np.divmod(pixel.astype(np.int32), np.int32(sight.width))
        self.right, self.down = x + 0.5, y + 0.5
        first = self.places[:, 0]
        self._dx = (self.right - first[:, 0].take(self.row)).astype(np.float32)
        self._dy = (self.down - first[:, 1].take(self.row)).astype(np.float32)

    def values(self, values: NDArray[np.floating]) -> Floats:
        """Interpolate corner values (m, 3, k) affinely on the sheet; (k, n)."""
        return _interpolated(self.places, values, self.row, self._dx, self._dy)

    def true_values(self, values: NDArray[np.floating]) -> Floats:
        """Interpolate corner values (m, 3, k) affinely in space; (k, n)."""
        found = self.values(np.concatenate((values * self.weight, self.weight), 2))
        return np.asarray(found[:-1] / found[-1])


def _interpolated(
    places: Array,
    values: NDArray[np.floating],
    row: NDArray[np.int32],
    dx: Floats,
    dy: Floats,
) -> Floats:
    """Interpolate (t, 3, k) corner values affinely at offsets from first corners; (k, n)."""
    edge = places[:, 1:, :2] - places[:, :1, :2]
    area = edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0]
    scale = np.divide(1.0, area, out=np.zeros_like(area), where=area != 0)[:, None]
    rise1, rise2 = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    by_x = (rise1 * edge[:, 1, 1:] - rise2 * edge[:, 0, 1:]) * scale
    by_y = (rise2 * edge[:, 0, :1] - rise1 * edge[:, 1, :1]) * scale
    count = values.shape[2]
    table = np.concatenate((values[:, 0], by_x, by_y), 1).astype(np.float32)
    table = np.ascontiguousarray(table.T)
    result = np.empty((count, len(row)), np.float32)
    for k in range(count):
        own = table[k].take(row, out=result[k], mode="clip")  # clipped or not, rows are in range
        for slopes, way in ((table[count + k], dx), (table[2 * count + k], dy)):
            step = slopes.take(row)
            step *= way
            own += step
    # Rounding in slivers must not leave the range of the corners by much.
    limit = np.float32(np.abs(values).max(initial=0.0))
    return np.clip(result, -limit, limit, out=result)


def _backs(places: Array) -> Flags:
    x, y = places[:, :, 0], places[:, :, 1]
    area = (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0]) - (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0])
    return np.asarray(area < 0)


def diffuse_light(seen: Fragments, cavity: Floats | None = None) -> Floats:
    """Return how much light matte clay sends to the eye, (n,); 1 shows its colour.

    Parameters
    ----------
    seen : Fragments
        The visible surface.
    cavity : (n,) float32, optional
        Part of the light that is kept out of hollows, 0 … 1.
    """
    key = KEY / np.linalg.norm(KEY)
    across, up, near = seen.normal
    light = across * key[0] + up * key[1] + near * key[2]
    light += np.float32(WRAP)
    np.maximum(light, 0.0, out=light)
    light *= np.float32(KEY_SHARE / (1.0 + WRAP))
    light += np.float32(SKY_SHARE) * (np.float32(0.72) + np.float32(0.28) * up)
    grazing = np.float32(1) - seen.facing
    grazing *= grazing
    light += np.float32(RIM_SHARE) * grazing * grazing
    if cavity is not None:
        light *= np.float32(1) - cavity
    light[seen.inside] *= np.float32(INSIDE)
    return np.asarray(light, np.float32)


def ramp(color: Color) -> Floats:
    """Return colours of a matte surface from no light to `BRIGHTEST`, shape (STEPS, 3), 0 … 255.

    Shadows keep some warmth instead of going grey; highlights tend to white without
    reaching it.
    """
    light = np.linspace(0.0, BRIGHTEST, STEPS, dtype=np.float32)[:, None]
    base = np.array(color, np.float32)
    shadow = base * np.array(SHADOW, np.float32)
    dark = shadow + (base - shadow) * np.clip(light, 0, 1) ** np.float32(1.15)
    bright = base + (np.float32(255) - base) * np.float32(0.55)
    over = np.clip((light - 0.86) / (BRIGHTEST - 0.86), 0, 1)
    return np.asarray(dark + (bright - dark) * over * over, np.float32)


def surface_colors(
    seen: Fragments,
    part: NDArray[np.int32],
    colors: Sequence[Color],
    tinted: Flags,
    shading: Shading,
    palette: Palette,
    cavity: Floats | None = None,
) -> Floats:
    """Return colours of the visible surface, shape (n, 3), 0 … 255.

    Parameters
    ----------
    seen : Fragments
        The visible surface.
    part : (n,) int32
        Which of `colors` each pixel has.
    colors : sequence of (r, g, b)
        Colours of the parts, 0 … 255.
    tinted : (parts,) bool
        Which parts show their vertex colours instead.
    shading : {"clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"}
        How surfaces are shaded.
    palette : Palette
        Colours of the theme.
    cavity : (n,) float32, optional
        Part of the light that is kept out of hollows, 0 … 1.
    """
    if shading == "normals":
        return np.asarray((seen.normal.T * 0.5 + 0.5) * 255.0, np.float32)
    light = diffuse_light(seen, cavity)
    step = np.clip(light * np.float32((STEPS - 1) / BRIGHTEST), 0, STEPS - 1).astype(np.intp)
    ramps = np.concatenate([ramp(color) for color in colors])
    result = ramps.take(part.astype(np.intp) * STEPS + step, 0)
    own = np.flatnonzero(tinted[part])
    if len(own):
        white = ramp((255, 255, 255))[step[own]]
        result[own] = seen.color[own, :3] * white / np.float32(255)
    return np.asarray(result, np.float32)


def draft_colors(normals: Floats, palette: Palette) -> Floats:
    """Return RGBA per vertex by the draft angle to the vertical, (v, 4), 0 … 255.

    What looks up is clay and leaves a mould upward, what looks down has the second colour; towards
    the vertical, from `DRAFT` on, both go over to the colour of warnings.
    """
    length = np.maximum(np.linalg.norm(normals, axis=1), 1e-30)
    rise = (normals[:, 2] / length).astype(np.float32)[:, None]
    angle = np.degrees(np.arcsin(np.clip(np.abs(rise), 0.0, 1.0)))
    steep = np.clip(1.0 - angle / DRAFT, 0.0, 1.0).astype(np.float32)
    clay, second, warning = (
        np.array(color, np.float32) for color in (palette.clay, palette.second, palette.warning)
    )
    rgb = np.where(rise >= 0.0, clay, second)
    rgb = rgb + steep * (warning - rgb)
    return np.asarray(np.concatenate((rgb, np.full((len(rgb), 1), 255)), 1), np.float32)


def curvature_colors(curvature: Floats, palette: Palette) -> Floats:
    """Return RGBA per vertex: hollows in the second colour, bulges in the accent; (v, 4), 0 … 255.

    Scaled by the mesh's own 90th percentile, so that detail shows at any size.
    """
    scale = float(np.percentile(np.abs(curvature), 90)) if len(curvature) else 0.0
    value = np.tanh(curvature * (CURVATURE_STEPS / scale)) if scale > 0 else 0.0 * curvature
    base = np.array(palette.clay, np.float32)
    warm = np.array(palette.accent, np.float32) - base
    cool = np.array(palette.second, np.float32) - base
    value = value[:, None].astype(np.float32)
    rgb = base + warm * np.maximum(value, 0) + cool * np.maximum(-value, 0)
    return np.asarray(np.concatenate((rgb, np.full((len(rgb), 1), 255)), 1), np.float32)
