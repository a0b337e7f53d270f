"""Kinds of cars that are no template's, and pictures as people draw them.

Outer dimensions are rounded ones of cars that are built; what is between has been moved by hand,
and bulges by chance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bozzetto_car.state import CarState, Mark
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from tests.plugins.car.marked_points import Marked, marked
from tests.plugins.car.sketched import FRONT_QUARTER, PICTURE, View

Array = NDArray[np.float64]

BULGES = 25.0
"""Of each node, mm, per coordinate, smooth over 600 mm."""


@dataclass(frozen=True)
class Kind:
    """A kind of car: the template it is marked with, its dimensions, and what else is different.

    Attributes
    ----------
    template : str
    size : (float, float, float)
        Length, width, height, mm.
    overhang, wheelbase : float
        mm.
    moved : dict of str to (float, float)
        By node, both sides: rearward and upward, mm, after all has been scaled.
    """

    template: str
    size: tuple[float, float, float]
    overhang: float
    wheelbase: float
    moved: dict[str, tuple[float, float]]


KINDS = {
    "off-road car": Kind(
        "hatchback",
        (4880.0, 1985.0, 1710.0),
        900.0,
        2900.0,
        {
            "C1": (0.0, 90.0),
            "S1": (0.0, 90.0),
            "C2": (-40.0, 60.0),
            **{name: (0.0, 120.0) for name in ("B1", "B2", "B3", "B4", "B5", "C0", "C8")},
        },
    ),
    "limousine": Kind(
        "sedan",
        (5290.0, 1920.0, 1500.0),
        880.0,
        3220.0,
        {"S3": (160.0, 0.0), "B3": (160.0, 0.0), "R2": (120.0, 0.0), "C4": (120.0, 0.0)},
    ),
    "city car": Kind(
        "hatchback",
        (3570.0, 1630.0, 1490.0),
        710.0,
        2300.0,
        {"C2": (-90.0, 20.0), "S2": (-90.0, 20.0), "C1": (0.0, 60.0), "C5": (60.0, 10.0)},
    ),
    "coupé": Kind(
        "sedan",
        (4520.0, 1850.0, 1300.0),
        930.0,
        2450.0,
        {
            "C2": (120.0, -20.0),
            "S2": (120.0, -20.0),
            "C4": (-60.0, 10.0),
            "C5": (-150.0, -30.0),
            "R3": (-150.0, -40.0),
            "C6": (160.0, -40.0),
            "S4": (160.0, -30.0),
        },
    ),
    "short roof": Kind(
        "hatchback",
        (5300.0, 1860.0, 1800.0),
        900.0,
        3230.0,
        {
            "C5": (-450.0, 0.0),
            "R3": (-450.0, 0.0),
            "C4": (-200.0, 0.0),
            "R2": (-180.0, 0.0),
            "S3": (-100.0, 0.0),
            "C6": (-420.0, -60.0),
            "S4": (-300.0, 0.0),
        },
    ),
    "van": Kind(
        "minivan",
        (4900.0, 1905.0, 1980.0),
        890.0,
        3000.0,
        {"C2": (-200.0, 60.0), "S2": (-200.0, 40.0), "C3": (-120.0, 0.0), "R1": (-120.0, 0.0)},
    ),
}

WIDE: View = ((30.0, 55.0), (5.0, 20.0), (3.4, 4.2))
"""From so near that the car fills an angle of 60 to 90 degrees."""


def unseen(kind: Kind, seed: int) -> Array:
    """A car of a kind, (n, 3) mm."""
    template = bundled(kind.template)
    car = template.positions.copy()
    length, width, height = kind.size
    body = np.delete(car, template.wheels.ravel(), axis=0)
    front, rear = car[template.wheels[:, 0], 0]
    was = [body[:, 0].min(), front, rear, body[:, 0].max()]
    car[:, 0] = np.interp(
        car[:, 0], was, [0.0, kind.overhang, kind.overhang + kind.wheelbase, length]
    )
    car[:, 1] *= width / np.ptp(body[:, 1])
    car[:, 2] *= height / body[:, 2].max()
    for name, node in template.node.items():
        car[node, [0, 2]] += kind.moved.get(name.split(".")[0], (0.0, 0.0))
    rng = np.random.default_rng(seed)
    near = np.exp(-(((car[:, None] - car) / 600.0) ** 2).sum(axis=2))
    bulges = near @ rng.normal(0.0, BULGES, car.shape) / np.sqrt((near**2).sum(axis=1))[:, None]
    image = bulges[template.mirrored] * [1.0, -1.0, 1.0]
    return np.asarray(car + (bulges + image) / np.sqrt(2.0))


def exaggerated(case: Marked, rng: np.random.Generator, share: float = 0.015) -> Marked:
    """The sketch as if drawn by hand: places off by a share of the diagonal, smoothly."""
    waves = rng.uniform(-1.0, 1.0, (4, 2)) * 2.0 * np.pi
    phases = rng.uniform(0.0, 2.0 * np.pi, (4, 2))
    size = share * np.hypot(*PICTURE) * rng.normal(0.0, 1.0, (4, 2)) / np.sqrt(2.0)

    def bent(places: Array) -> Array:
        along = places / PICTURE[0] @ waves.T
        return np.asarray(places + (np.sin(along[:, :, None] + phases) * size).sum(axis=1))

    (sketch,) = case.state.sketches
    marks = bent(np.array([(mark.u, mark.v) for mark in sketch.marks])).tolist()
    moved = tuple(Mark(m.node, u, v) for m, (u, v) in zip(sketch.marks, marks, strict=True))
    state: CarState = case.state.with_node(replace(sketch, marks=moved))
    return replace(case, state=state, places=(bent(case.places[0]),))


PICTURES = {
    "perspective": (FRONT_QUARTER, "perspective", 0.0),
    "orthographic": (FRONT_QUARTER, "orthographic", 0.0),
    "wide angle": (WIDE, "perspective", 0.0),
    "by hand": (FRONT_QUARTER, "perspective", 0.015),
}
"""View, kind of the camera, and by what share of its diagonal the drawing is off."""


def pictured(name: str, picture: str, seed: int) -> tuple[Template, Array, Marked]:
    """A car of a kind by chance, and a sketch of it, marked with 2 px of noise."""
    kind = KINDS[name]
    template, car = bundled(kind.template), unseen(kind, seed)
    view, camera, share = PICTURES[picture]
    case = marked(template, car, (view,), seed, 2.0, kind=camera)
    if share:
        case = exaggerated(case, np.random.default_rng(seed), share)
    return template, car, case
