"""A car as points, pictures of it, and marks on them: what the tests of calibration share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.view import Camera

PICTURE = (1200.0, 800.0)

CENTRE = {
    "C0": (80, 0, 200), "C1": (100, 0, 740), "C2": (1220, 0, 990), "C3": (2000, 0, 1400),
    "C4": (2600, 0, 1460), "C5": (3250, 0, 1400), "C6": (4000, 0, 1100), "C7": (4620, 0, 1050),
    "C8": (4600, 0, 270),
}  # fmt: skip

RIGHT = {
    "S1": (300, 720, 710), "S2": (1300, 770, 970), "S3": (2550, 840, 950),
    "S4": (3880, 740, 1060), "S5": (4520, 680, 990), "R1": (2030, 560, 1360),
    "R2": (2650, 590, 1420), "R3": (3270, 550, 1360), "B1": (300, 780, 200),
    "B2": (1350, 880, 200), "B3": (2500, 900, 200), "B4": (3220, 880, 210),
    "B5": (4460, 780, 280), "WF": (900, 785, 325), "WR": (3650, 785, 325),
}  # fmt: skip

NODES = {
    **{name: np.array(place, float) for name, place in CENTRE.items()},
    **{f"{name}.R": np.array(place, float) for name, place in RIGHT.items()},
    **{f"{name}.L": np.array(place, float) * (1, -1, 1) for name, place in RIGHT.items()},
}
"""The 39 fiducial points of a sedan, mm: x rearward from the nose, y right, z up."""

NAMES = list(NODES)
POINTS = np.array(list(NODES.values()))

VIEWS = {
    "three-quarter": ((20, 70), (5, 25)),
    "side": ((84, 90), (2, 12)),
    "front": ((0, 8), (5, 20)),
}
"""Degrees from the nose and above the ground, from … to."""


@dataclass(frozen=True)
class Shot:
    """A camera, what it sees of the car, and which points a person would mark."""

    camera: Camera
    places: np.ndarray
    marked: np.ndarray

    @property
    def hidden(self) -> np.ndarray:
        return np.setdiff1d(np.arange(len(POINTS)), self.marked)


def shot(rng, view="three-quarter", count=99, kind="perspective", points=POINTS) -> Shot:
    """A random view that fills three quarters of the picture's width.

    Marked are the points of the near side and the centre and the far edge of the roof, 27, or
    as many of them as are asked for.
    """
    (low, high), (down, up) = VIEWS[view]
    around = np.radians(rng.uniform(low, high) * rng.choice((-1, 1)) + rng.choice((0, 180)))
    above = np.radians(rng.uniform(down, up))
    away = np.array(
        (-np.cos(around) * np.cos(above), np.sin(around) * np.cos(above), np.sin(above))
    )
    target = points.mean(axis=0) + rng.normal(0, 150, 3)
    eye = target + rng.uniform(6000, 12000) * away
    wide = Camera(kind, tuple(eye), tuple(target), fov_y=30, height=4000, viewport=PICTURE)
    share = np.ptp(wide.project(points)[0][:, 0]) / (0.75 * PICTURE[0])
    opening = 2 * np.degrees(np.arctan(share * np.tan(np.radians(15))))
    camera = Camera(
        kind, tuple(eye), tuple(target), fov_y=opening, height=4000 * share, viewport=PICTURE
    )
    near = "R" if away[1] > 0 else "L"
    seen = [
        at
        for at, name in enumerate(NAMES)
        if "." not in name or name.endswith(near) or name.startswith("R")
    ]
    marked = rng.permutation(seen)[:count]
    return Shot(camera, camera.project(points)[0], marked)


def rms(differences) -> float:
    """Root mean square length of rows."""
    return float(np.sqrt(np.mean(np.sum(np.square(differences), axis=1))))


def turned_by(camera, other) -> float:
    """Angle between the frames of two cameras, degrees."""
    cosine = 0.5 * (np.sum(camera.axes * other.axes) - 1.0)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def thrown(rng, length: float) -> np.ndarray:
    """A step of a length in a random direction of the picture."""
    angle = rng.uniform(0, 2 * np.pi)
    return length * np.array((np.cos(angle), np.sin(angle)))
