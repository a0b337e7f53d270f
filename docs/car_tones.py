"""The marker on the drawn cars: paint that mirrors sky and ground, glass, tyres, the shadow."""

from __future__ import annotations

from typing import Final

import numpy as np
from car_details import both, from_side, front_lines, lamp_lines, polygon, side_windows, spokes
from car_pencil import Color, Sheet
from car_seen import TYRE, Seen, circle
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

PAINTS: Final[dict[str, Color]] = {
    "sedan": (226, 96, 52),
    "hatchback": (62, 148, 160),
    "minivan": (222, 168, 62),
    "coupe": (196, 52, 62),
    "estate": (84, 118, 176),
    "suv": (112, 138, 84),
    "pickup": (178, 120, 74),
    "van": (120, 132, 142),
    "city_car": (206, 178, 74),
    "limousine": (96, 98, 110),
}
"""Of the cars, and of what is behind them."""

WARM: Final[Color] = (168, 160, 152)
COOL: Final[Color] = (92, 104, 122)
DEEP: Final[Color] = (52, 54, 64)
NIGHT: Final[Color] = (26, 27, 34)
RED: Final[Color] = (176, 34, 38)
"""Other markers."""

SLANT: Final = 62.0
"""Direction of the marker on the car, degrees."""

LEVEL: Final = -5.0
"""The same behind it."""

MIRRORED: Final = ((-2.0, 0.62, 0.16), (-2.0, 0.16, 0.34), (-0.35, 0.06, 0.34))
"""What paint mirrors: by how far it looks up (z of its normal) from and to, and how strong the
tone is there. Towards the sky it stays white."""

HORIZON: Final = (-0.16, -0.02, 0.20)
"""The dark band in which the paint mirrors the horizon, likewise."""

SCREENS: Final = ("windscreen", "backlight", "tailgate_glass")
TAILS: Final = ("rear_fascia", "rear_bumper", "tailgate_lower", "tailgate_glass")
"""Patches of the screens, and those on which tail lamps reach."""

REFLECTED: Final = (330.0, 105.0, 300.0)
"""Dark reflections on glass: one every so many px, from and to."""


def tones(sheet: Sheet, seen: Seen) -> None:
    """All that is put down with the marker, before any line."""
    paint = PAINTS[seen.car.network.template.id]
    empty = ~np.isfinite(seen.depth)
    sheet.fill(backdrop(sheet, seen) * soft(empty, 1.0), paint, 0.40, LEVEL)
    shadow(sheet, seen, empty)
    up = upward(seen)
    for least, most, strength in MIRRORED:
        sheet.fill(soft((up > least) & (up < most), 1.8), paint, strength, SLANT)
    least, most, strength = HORIZON
    sheet.fill(soft((up > least) & (up < most), 3.0), DEEP, strength, SLANT)
    glazed(sheet, seen, up)
    lamps(sheet, seen)
    wheels(sheet, seen)


def soft(mask: Mask, by: float = 1.2) -> Array:
    """A mask with the edges that a felt tip makes."""
    return np.asarray(gaussian_filter(mask.astype(float), by))


def filled(seen: Seen, points: Array) -> Mask:
    """Pixels inside an outline in space, as far as it is known."""
    points = points[np.isfinite(points).all(axis=1)]
    height, width = seen.depth.shape
    image = Image.new("L", (width, height))
    if len(points) > 2:
        corners = seen.camera.project(points)[0]
        ImageDraw.Draw(image).polygon([tuple(corner) for corner in corners.tolist()], fill=1)
    return np.asarray(image, bool)


def upward(seen: Seen) -> Array:
    """How far the body looks up at each pixel, -1 … 1; inf beside it."""
    body = seen.patch >= 0
    share = gaussian_filter(body.astype(float), 3.0)
    sums = gaussian_filter(np.where(body, seen.normal[..., 2], 0.0), 3.0)
    return np.where(body, sums / np.maximum(share, 1e-3), np.inf)


def backdrop(sheet: Sheet, seen: Seen) -> Array:
    """Some broad strokes behind the car, which end where the hand stopped."""
    rng, width = sheet.rng, seen.depth.shape[1]
    rows = np.flatnonzero((seen.patch >= 0).any(axis=1))
    band, _ = sheet.bands(LEVEL)
    x, y = sheet.places[..., 0], sheet.places[..., 1]
    level = y - (x - 0.5 * width) * np.tan(np.radians(LEVEL))
    tall = (level > rows[0] - 75) & (level < rows[0] + 0.52 * (rows[-1] - rows[0]))
    count = band.max() + 1
    drift = np.cumsum(rng.normal(0.0, 9.0, (2, count)), axis=1)
    starts = width * 0.13 + drift[0] + rng.normal(0.0, 16.0, count)
    ends = width * 0.88 + drift[1] + rng.normal(0.0, 16.0, count)
    return soft(tall & (x > starts[band]) & (x < ends[band]), 0.9)


def shadow(sheet: Sheet, seen: Seen, empty: Mask) -> None:
    """What the car casts on the ground below it."""
    positions = seen.car.network.positions
    low, high = positions.min(axis=0), positions.max(axis=0)
    half, middle = 0.5 * (high - low), 0.5 * (high + low)
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    x, y = (np.sign(way) * np.abs(way) ** 0.35 for way in (np.cos(turn), np.sin(turn)))
    flat = seen.camera.kind == "orthographic"  # the ground is a line then: give it a breadth
    height = np.where(y > 0.0, 14.0, -26.0) if flat else np.zeros(len(turn))
    for length, breadth, color, strength in ((0.99, 0.99, DEEP, 0.62), (0.92, 0.85, NIGHT, 0.55)):
        spot = (middle[0] + length * half[0] * x, breadth * half[1] * y, height)
        on = filled(seen, np.column_stack(spot)) & empty
        sheet.fill(soft(on, 2.5), color, strength, 2.0)


def glazed(sheet: Sheet, seen: Seen, up: Array) -> None:
    """Glass, with slanting reflections; darker where it looks at the ground."""
    names = seen.car.body.patch_names
    glass = seen.on_patches([name for name in names if name.split(".")[0] in SCREENS])
    for pane in side_windows(seen.car):
        outline = from_side(seen.car, polygon(pane, 200))
        for side, mirror in (("R", 1.0), ("L", -1.0)):
            own = [name for name in names if name.startswith("glass") and name.endswith(side)]
            glass |= filled(seen, outline * (1.0, mirror, 1.0)) & seen.on_patches(own)
    sheet.fill(soft(glass), COOL, 0.50, SLANT)
    every, start, end = REFLECTED
    across = np.mod(sheet.places @ np.array([1.0, 0.55]), every)
    sheet.fill(soft(glass & (across > start) & (across < end), 2.0), COOL, 0.42, SLANT)
    sheet.fill(soft(glass & (up < 0.32)), DEEP, 0.30, SLANT)


def lamps(sheet: Sheet, seen: Seen) -> None:
    """Grille and intake, headlamps, tail lamps."""
    nose = seen.on_patches(["front_fascia.R", "front_fascia.L"])
    for line in front_lines(seen.car):
        if line.role == "lamp":
            sheet.fill(soft(filled(seen, line.points) & nose), DEEP, 0.66, SLANT)
    tails = [name for name in seen.car.body.patch_names if name.split(".")[0] in TAILS]
    for line in both(lamp_lines(seen.car)):
        if line.role != "lamp" or seen.shows(line.points).mean() < 0.5:
            continue
        x, y, _ = np.nanmean(line.points, axis=0)
        side = ".R" if y > 0.0 else ".L"
        front = x < seen.car.network.positions[:, 0].mean()
        on = seen.on_patches(["fender" + side] if front else [*tails, "quarter" + side])
        on |= nose if front else seen.on_patches(["d_pillar" + side])
        sheet.fill(
            soft(filled(seen, line.points) & on), COOL if front else RED, 0.3 if front else 0.7
        )


def wheels(sheet: Sheet, seen: Seen) -> None:
    """The dark in the arches, tyres, and what is between the spokes."""
    rims, bright = np.zeros((2, *seen.depth.shape), bool)
    for number, wheel in enumerate(seen.car.wheels):
        own = seen.wheel == number
        rims |= filled(seen, circle(wheel, 0.72 * wheel[2], TYRE - 4.0)) & own
        for outline in (*spokes(wheel), circle(wheel, 0.15 * wheel[2], 12.0)):
            bright |= filled(seen, outline) & own
    sheet.fill(soft(seen.housing, 0.8), NIGHT, 0.88, 80.0)
    sheet.fill(soft((seen.wheel >= 0) & ~rims, 0.8), DEEP, 0.78, 80.0)
    sheet.fill(soft(rims & ~bright, 0.8), DEEP, 0.62, SLANT)
    sheet.fill(soft(rims & bright, 0.8), WARM, 0.18, SLANT)
