"""The pencil on the drawn cars: outlines, edges, details, and the lines that help to construct."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from car_designs import kind_of
from car_details import (
    arch_lines,
    both,
    door_lines,
    edge_points,
    front_lines,
    glass_lines,
    lamp_lines,
    mirrors,
    rear_lines,
    styling,
    wheel_lines,
)
from car_pencil import Sheet
from car_seen import TYRE, Car, Line, Seen
from car_tones import PAINTS, SLANT, filled, soft
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Array = NDArray[np.float64]

PENS: Final = {
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
"""Strokes that a line is drawn with, searching ones first: width px, darkness, overshoot px."""

SEARCHING: Final = 0.4
"""Darkness up to which a stroke searches for its line."""

TREMORS: Final = (1.9, 0.55)
"""Tremor of strokes that search, and of those that have found, px."""

GLEAM: Final = (-0.5, -3.0)
"""Where white stands beside a line that is pressed into the body, px."""

CORNER: Final = 0.7
"""Turn of an outline within a dozen px at which the pencil is lifted, radians."""

LONGEST: Final = 900
"""Longest stroke along an outline, px."""


def lines(sheet: Sheet, seen: Seen) -> None:
    """All that is drawn with the pencil."""
    car = seen.car
    for points in construction(car):
        pencil(sheet, seen.camera.project(points)[0], "construction")
    for path in outlines(seen):
        pencil(sheet, path, "outline")
    every = [*glass_lines(car), *door_lines(car), *lamp_lines(car), *arch_lines(car)]
    every = [*both(every), *front_lines(car), *rear_lines(car)]
    every += [line for wheel in car.wheels for line in wheel_lines(wheel)]
    for line in (*every, *edge_lines(car)):
        for path in seen.drawn(line.points, on_body=line.on_body):
            pencil(sheet, path, line.role)
    for line in both([Line(points, "crease") for points in styling(car).values()]):
        for path in seen.drawn(line.points):
            pencil(sheet, path, line.role)
            sheet.line(path + np.array(GLEAM), 2.2, 0.75, overshoot=-12.0, white=True)
    for outline in mirrors(car, seen.camera.axes[2]):
        if seen.shows(outline).mean() > 0.9:
            outside_mirror(sheet, seen, outline)


def pencil(sheet: Sheet, path: Array, role: str) -> None:
    """One line: strokes that search, and one that has found."""
    for width, dark, beyond in PENS[role]:
        tremor = TREMORS[0] if dark < SEARCHING and len(PENS[role]) > 1 else TREMORS[1]
        sheet.line(path, width, dark, tremor=tremor, overshoot=beyond)


def edge_lines(car: Car) -> Iterator[Line]:
    """Edges of the network that are lines on a car."""
    sedan = kind_of(car.network.template) == "sedan"
    corner, last = ("S4", "S5") if sedan else ("S5", "S6")
    for side in "RL":
        for row in (
            ("S1", "S2", "S3", "S4", last),
            ("S2", "R1", "R2", "R3", corner),
            ("B1", "B2", "B3", "B4", "B5"),
        ):
            yield Line(edge_points(car, *(f"{half}.{side}" for half in row)), "edge")
        yield Line(edge_points(car, "C0", f"B1.{side}"), "cut")
        yield Line(edge_points(car, "C8", f"B5.{side}"), "cut")
    for middle, half in (
        ("C1", "S1"), ("C2", "S2"), ("C3", "R1"), ("C5", "R3"), ("C6", corner), ("C7", last)
    ):  # fmt: skip
        right = edge_points(car, middle, f"{half}.R")
        across = np.concatenate((right[::-1] * (1.0, -1.0, 1.0), right))
        yield Line(across, "glass" if middle == "C3" else "edge")


def construction(car: Car) -> Iterator[Array]:
    """The middle of the body, and where wheels stand, (k, 3) mm each."""
    yield edge_points(car, *(f"C{number}" for number in range(9)))
    front, rear = car.wheels[0], car.wheels[2]
    for y in (front[1], -front[1]):
        yield np.linspace((front[0] - 1500.0, y, 0.0), (rear[0] + 1300.0, y, 0.0), 60)
    near = front[1] + TYRE
    for wheel in (front, rear):
        x, _, z = wheel
        yield np.linspace((x, -1500.0, 0.0), (x, 1500.0, 0.0), 40)
        yield np.linspace((x, near, z - 520.0), (x, near, z + 520.0), 40)


def outlines(seen: Seen) -> list[Array]:
    """The outline of the body, wheel arches left out, cut into strokes at its corners, px."""
    from skimage.measure import find_contours

    found = []
    for ring in find_contours(gaussian_filter((seen.patch >= 0).astype(float), 1.6), 0.5):
        if len(ring) < 200:
            continue
        path = gaussian_filter(ring[:, ::-1] + 0.5, (3.0, 0.0), mode="wrap")
        way = np.gradient(path, axis=0)
        angle = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
        bend = np.abs(angle[12:] - angle[:-12])
        corners = [0, len(path) - 1]
        for place in np.argsort(bend)[::-1]:
            if bend[place] < CORNER:
                break
            if all(abs(place + 6 - corner) > 40 for corner in corners):
                corners.append(int(place) + 6)
        corners.sort()
        for start, end in pairwise(corners):
            for part in np.array_split(np.arange(start, end + 1), 1 + (end - start) // LONGEST):
                found.append(path[max(part[0] - 10, start) : part[-1] + 10])
    return found


def outside_mirror(sheet: Sheet, seen: Seen, outline: Array) -> None:
    """A mirror, in front of everything."""
    paint = PAINTS[seen.car.network.template.id]
    inside = soft(filled(seen, outline), 0.7)
    path = seen.camera.project(outline)[0]
    sheet.clear(inside)
    sheet.fill(inside, paint, 0.30, SLANT)
    below = sheet.places[..., 1] > path[:, 1].mean() + 4.0
    sheet.fill(inside * soft(below), paint, 0.50, SLANT)
    pencil(sheet, path, "glass")
