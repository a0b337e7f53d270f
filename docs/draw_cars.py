"""Draw the three cars of the gallery, and write down their marks and strokes.

Run ``python docs/draw_cars.py [sedan] [hatchback] [minivan]``. The same pictures come out every
time, for the hand trembles by a generator of fixed numbers.
"""

from __future__ import annotations

import json
import re
import sys
import zlib
from pathlib import Path

import car_designs
import numpy as np
from car_details import (
    arch_lines, both, mirrors, spokes, door_lines, edge_points, from_side, front_lines, glass_lines, lamp_lines,
    polygon, rear_lines, side_windows, styling, wheel_lines,
)  # fmt: skip
from car_marks import marks_of, strokes_of, styling_of
from car_pencil import Sheet
from car_seen import TYRE, Car, Seen, circle
from numpy.typing import NDArray
from picture_kit import GALLERY
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter

from bozzetto_car.template_file import TEMPLATES, bundled

Array = NDArray[np.float64]

CARS = GALLERY / "car"

ACCENTS = {"sedan": (226, 96, 52), "hatchback": (62, 148, 160), "minivan": (222, 168, 62)}
LEVEL = -5.0
TAIL = ("rear_fascia", "rear_bumper", "tailgate_lower", "tailgate_glass")
WARM, COOL, DEEP = (168, 160, 152), (92, 104, 122), (52, 54, 64)

PENS = {
    "outline": ((1.1, 0.38, 40.0), (1.1, 0.34, 22.0), (3.0, 1.0, 8.0)),
    "edge": ((1.1, 0.36, 60.0), (1.0, 0.32, 30.0), (2.1, 0.9, 9.0)),
    "glass": ((1.0, 0.36, 14.0), (1.9, 0.9, 4.0)),
    "arch": ((1.0, 0.36, 10.0), (2.6, 1.0, 2.0)),
    "lamp": ((1.0, 0.36, 9.0), (1.8, 0.9, 3.0)),
    "tyre": ((1.0, 0.36, 6.0), (2.5, 1.0, 3.0)),
    "rim": ((1.0, 0.36, 4.0), (1.8, 0.9, 2.0)),
    "part": ((1.3, 0.75, 2.0),),
    "cut": ((1.0, 0.30, 16.0), (1.5, 0.75, 4.0)),
    "crease": ((1.0, 0.30, 34.0), (1.0, 0.28, 18.0), (1.5, 0.62, 8.0)),
    "fine": ((1.1, 0.5, 3.0),),
    "construction": ((1.0, 0.32, 60.0), (0.9, 0.24, 30.0)),
}
"""Strokes that each kind of line is drawn with: width px, darkness, overshoot px."""


def main(names: list[str]) -> int:
    """Draw all cars, or those that are named."""
    CARS.mkdir(exist_ok=True)
    for name in names or TEMPLATES:
        network, cameras = car_designs.truth(bundled(name))
        car = Car.of(network)
        views, lines = [], []
        for number, camera in enumerate(cameras):
            seen = Seen.of(car, camera)
            file = f"{name}-{number + 1}.png" if number else f"{name}.png"
            draw(seen, name, generator(file), CARS / file)
            rng = generator(f"{file} marks")
            views.append(
                {
                    "kind": "auto",
                    "image": dict(zip(("file", "width", "height"), (file, *car_designs.SIZE))),
                    "marks": marks_of(seen, rng),
                    "strokes": strokes_of(seen, rng),
                }
            )
            lines += styling_of(seen, number, rng) if not number else []
        record = {"image": views[0]["image"], "template": name, "views": views}
        record["dimensions"] = {"WB": float(np.ptp(car.wheels[:, 0]))}
        record["styling"] = lines
        (CARS / f"{name}.json").write_text(written(record), "utf-8")
    return 0


def generator(words: str) -> np.random.Generator:
    """The same numbers for the same words."""
    return np.random.default_rng(zlib.crc32(words.encode()))


def written(record: dict[str, object]) -> str:
    """JSON with a line for each list of numbers."""
    text = json.dumps(record, indent=1)
    pair = re.compile(r"\[\s+(-?[\d.]+),\s+(-?[\d.]+)\s+\]")
    text = pair.sub(r"[\1, \2]", text)
    return re.sub(r"\],\s+\[", "], [", text) + "\n"


def draw(seen: Seen, name: str, rng: np.random.Generator, path: Path) -> None:
    """One picture."""
    sheet = Sheet(*car_designs.SIZE, rng)
    tones(sheet, seen, name)
    lines(sheet, seen)
    sheet.save(path)
    print(f"wrote {path.name}, {path.stat().st_size // 1000} kB")


# -- tones ---


def soft(mask: Array, by: float = 1.2) -> Array:
    return np.asarray(gaussian_filter(mask.astype(float), by))


def filled(seen: Seen, points: Array) -> Array:
    """Pixels inside an outline in space."""
    points = points[np.isfinite(points).all(axis=1)]
    height, width = seen.depth.shape
    image = Image.new("L", (width, height))
    if len(points) > 2:
        ImageDraw.Draw(image).polygon([tuple(p) for p in seen.camera.project(points)[0]], fill=1)
    return np.asarray(image, bool)


def tones(sheet: Sheet, seen: Seen, name: str) -> None:
    car, accent = seen.car, ACCENTS[name]
    empty = ~np.isfinite(seen.depth)
    sheet.fill(backdrop(sheet, seen) * soft(empty, 1.0), accent, 0.40, LEVEL)
    shadow(sheet, seen, empty)
    body = seen.patch >= 0
    up = gaussian_filter(np.where(body, seen.normal[..., 2], 0.0), 3.0)
    up /= np.maximum(gaussian_filter(body.astype(float), 3.0), 1e-3)
    sheet.fill(soft(body & (up < 0.62) & (up > -2)), accent, 0.16, 62.0)
    sheet.fill(soft(body & (up < 0.16), 2.0), accent, 0.34, 62.0)
    sheet.fill(soft(body & (up < 0.06) & (up > -0.35), 2.5), accent, 0.34, 62.0)
    sheet.fill(soft(body & (up < -0.02) & (up > -0.16), 3.0), DEEP, 0.20, 62.0)
    screens = [n for n in car.body.patch_names if n.split(".")[0] in
               ("windscreen", "backlight", "tailgate_glass")]
    glass = seen.on_patches(screens)
    for pane in side_windows(car):
        outline = from_side(car, polygon(pane, 200))
        for mirror in (1.0, -1.0):
            places = outline * (1.0, mirror, 1.0)
            side = ".R" if mirror > 0 else ".L"
            own = [n for n in car.body.patch_names if n.startswith("glass") and n.endswith(side)]
            glass |= filled(seen, places) & seen.on_patches(own)
    sheet.fill(soft(glass), COOL, 0.50, 62.0)
    across = sheet.places @ np.array([1.0, 0.55])
    streak = (np.mod(across, 330.0) > 105.0) & (np.mod(across, 330.0) < 300.0)
    sheet.fill(soft(glass & streak, 2.0), COOL, 0.42, 62.0)
    sheet.fill(soft(glass & (up < 0.32)), DEEP, 0.30, 62.0)
    tyres = seen.wheel >= 0
    rims = np.zeros(body.shape, bool)
    for number, wheel in enumerate(car.wheels):
        rims |= filled(seen, circle(wheel, 0.72 * wheel[2], TYRE - 4.0)) & (seen.wheel == number)
    sheet.fill(soft(seen.housing, 0.8), (26, 27, 34), 0.88, 80.0)
    sheet.fill(soft(tyres & ~rims, 0.8), DEEP, 0.78, 80.0)
    spoked = np.zeros(body.shape, bool)
    for number, wheel in enumerate(car.wheels):
        for outline in [*spokes(wheel), circle(wheel, 0.15 * wheel[2], 12.0)]:
            spoked |= filled(seen, outline) & (seen.wheel == number)
    sheet.fill(soft(rims & ~spoked, 0.8), DEEP, 0.62, 62.0)
    sheet.fill(soft(spoked & rims, 0.8), WARM, 0.18, 62.0)
    for line in front_lines(car):
        if line.role == "lamp":
            on = filled(seen, line.points) & seen.on_patches(["front_fascia.R", "front_fascia.L"])
            sheet.fill(soft(on), DEEP, 0.55, 80.0)
    for line in both(lamp_lines(car)):
        side = ".R" if np.nanmean(line.points[:, 1]) > 0 else ".L"
        front = np.nanmean(line.points[:, 0]) < 2000.0
        middle = ["front_fascia.R", "front_fascia.L"]
        if not front:
            middle = [n for n in car.body.patch_names if n.split(".")[0] in TAIL]
        lamped = [*middle, ("fender" if front else "quarter") + side, "d_pillar" + side]
        if line.role == "lamp" and seen.shows(line.points).mean() > 0.5:
            on = filled(seen, line.points) & seen.on_patches(lamped)
            sheet.fill(soft(on), COOL if front else (176, 34, 38), 0.30 if front else 0.7, 62.0)


def backdrop(sheet: Sheet, seen: Seen) -> Array:
    """Some broad strokes behind the car."""
    rng, (height, width) = sheet.rng, seen.depth.shape
    rows = np.flatnonzero((seen.patch >= 0).any(axis=1))
    band, _ = sheet.bands(LEVEL)
    slope = (sheet.places[..., 0] - 0.5 * width) * np.tan(np.radians(LEVEL))
    y = sheet.places[..., 1] - slope
    tall = (y > rows[0] - 75) & (y < rows[0] + 0.52 * (rows[-1] - rows[0]))
    count = band.max() + 1
    drift = np.cumsum(rng.normal(0.0, 9.0, (2, count)), axis=1)
    starts = width * 0.13 + drift[0] + rng.normal(0.0, 16.0, count)
    ends = width * 0.88 + drift[1] + rng.normal(0.0, 16.0, count)
    x = sheet.places[..., 0]
    return soft(tall & (x > starts[band]) & (x < ends[band]), 0.9)


def shadow(sheet: Sheet, seen: Seen, empty: Array) -> None:
    """What the car casts on the ground below it."""
    car = seen.car
    low, high = car.network.positions.min(axis=0), car.network.positions.max(axis=0)
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    half = 0.5 * (high - low)
    x = np.abs(np.cos(turn)) ** 0.35 * np.sign(np.cos(turn)) * half[0] * 0.99 + 0.5 * (low + high)[0]
    y = np.abs(np.sin(turn)) ** 0.35 * np.sign(np.sin(turn)) * half[1] * 0.99
    spot = np.column_stack((x, y, np.zeros(len(x))))
    if seen.camera.kind == "orthographic":
        spot[:, 2] = np.where(np.sin(turn) > 0, 14.0, -26.0)
    on = filled(seen, spot) & empty
    sheet.fill(soft(on, 2.0), DEEP, 0.62, 2.0)
    inner = filled(seen, (spot - spot.mean(axis=0)) * (0.93, 0.86, 1.0) + spot.mean(axis=0)) & empty
    sheet.fill(soft(inner, 3.0), (30, 30, 38), 0.55, 2.0)


# -- lines ---


def lines(sheet: Sheet, seen: Seen) -> None:
    car = seen.car
    for line in construction(car):
        sheet_line(sheet, seen.camera.project(line)[0], "construction")
    for path in outlines(seen):
        sheet_line(sheet, path, "outline")
    every = both(iter([*glass_lines(car), *door_lines(car), *lamp_lines(car), *arch_lines(car)]))
    every += [*front_lines(car), *rear_lines(car)]
    for wheel in car.wheels:
        every += wheel_lines(car, wheel)
    for line in every:
        for path in seen.drawn(line.points, on_body=line.on_body):
            sheet_line(sheet, path, line.role)
    for line, role in body_lines(car):
        for path in seen.drawn(line):
            sheet_line(sheet, path, role)
    for line in styling(car).values():
        for mirror in (1.0, -1.0):
            for path in seen.drawn(line * (1.0, mirror, 1.0)):
                sheet_line(sheet, path, "crease")
                sheet.line(path - (0.5, 3.0), 2.2, 0.75, overshoot=-12.0, white=True)
    for outline in mirrors(car, seen.camera.axes[2]):
        if seen.shows(outline).mean() > 0.9:
            inside = soft(filled(seen, outline), 0.7)
            sheet.clear(inside)
            low = seen.camera.project(outline)[0]
            half = sheet.places[..., 1] > low[:, 1].mean() + 4.0
            sheet.fill(inside, ACCENTS[car.network.template.id], 0.30, 62.0)
            sheet.fill(inside * soft(half), ACCENTS[car.network.template.id], 0.50, 62.0)
            sheet_line(sheet, low, "glass")


def sheet_line(sheet: Sheet, path: Array, role: str) -> None:
    for width, dark, beyond in PENS[role]:
        loose = 1.3 if dark < 0.4 else 0.55
        sheet.line(path, width, dark, tremor=loose, overshoot=beyond)


def body_lines(car: Car):
    sedan = car.network.template.id == "sedan"
    for s in "RL":
        tail = ("S4", "S5") if sedan else ("S4", "S6")
        yield edge_points(car, *(f"{n}.{s}" for n in ("S1", "S2", "S3", *tail))), "edge"
        yield edge_points(car, *(f"{n}.{s}" for n in ("S2", "R1", "R2", "R3", "S4" if sedan else "S5"))), "edge"
        yield edge_points(car, *(f"{n}.{s}" for n in ("B1", "B2", "B3", "B4", "B5"))), "edge"
        yield edge_points(car, "C0", f"B1.{s}"), "cut"
        yield edge_points(car, "C8", f"B5.{s}"), "cut"
    for c, s in (("C1", "S1"), ("C2", "S2"), ("C3", "R1"), ("C5", "R3"), ("C6", "S4" if sedan else "S5"),
                 ("C7", "S5" if sedan else "S6")):
        half = edge_points(car, c, f"{s}.R")
        yield np.concatenate((half[::-1] * (1, -1, 1), half)), "edge" if c != "C3" else "glass"


def construction(car: Car):
    middle = edge_points(car, *(f"C{k}" for k in range(9)))
    yield middle
    front, rear = car.wheels[0], car.wheels[2]
    for y in (front[1], -front[1]):
        yield np.linspace((front[0] - 1500, y, 0), (rear[0] + 1300, y, 0), 60)
    for x in (front[0], rear[0]):
        yield np.linspace((x, -1500, 0), (x, 1500, 0), 40)
        yield np.linspace((x, front[1] + TYRE, front[2] - 520), (x, front[1] + TYRE, front[2] + 520), 40)


def outlines(seen: Seen) -> list[Array]:
    from skimage.measure import find_contours
    body = gaussian_filter((seen.patch >= 0).astype(float), 1.6)
    found = []
    for ring in find_contours(body, 0.5):
        if len(ring) < 200:
            continue
        path = ring[:, ::-1] + 0.5
        smooth = np.stack([gaussian_filter(path[:, k], 3.0, mode="wrap") for k in (0, 1)], axis=1)
        way = np.gradient(smooth, axis=0)
        angle = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
        bend = np.abs(angle[12:] - angle[:-12])
        corners = [0]
        for k in np.argsort(bend)[::-1]:
            if bend[k] < 0.7:
                break
            if all(abs(k + 6 - c) > 40 for c in corners):
                corners.append(int(k + 6))
        corners = sorted(corners) + [len(smooth) - 1]
        for a, b in zip(corners, corners[1:]):
            for part in np.array_split(np.arange(a, b + 1), max(1, (b - a) // 900)):
                if len(part) > 12:
                    found.append(smooth[max(part[0] - 10, a) : part[-1] + 10])
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
