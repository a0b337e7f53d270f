"""What the simulated hand draws of a lamp: a vase on a bottle, its pleated shade on another."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from product_hand import Body, Hand, board

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_product.model.rough_shapes import RoughShape

LINEN, CLAY, BRASS, INK = (246, 234, 210), (38, 84, 92), (202, 164, 92), (40, 40, 44)

BASE, BELLY, COLLAR, NECK, RIM, CAP = 6.0, 100.0, 186.0, 234.0, 240.0, 342.0
"""Heights of the rings, mm."""

PLEATS = (30.0, 60.0, 90.0, 120.0, 150.0)
"""Where the pleats of one side are, degrees round from the front."""


def lamp() -> Hand:
    """A lamp for a table: twelve pleats of linen, that air fills, over a smooth vase."""
    vase = Body(
        RoughShape(kind="bottle", length=136.0, width=136.0, height=270.0, centre=(0, 0, 135))
    )
    bell = Body(
        RoughShape(kind="bottle", length=260.0, width=260.0, height=330.0, centre=(0, 0, 233.0))
    )
    middle = np.array((0.0, 0.0, 178.0))
    side, across = (board(axis, 0.0, (270.0, 270.0, 370.0), middle) for axis in "yx")
    heights = {"Base": BASE, "Belly": BELLY, "Collar": COLLAR, "Neck": NECK, "Rim": RIM, "Cap": CAP}
    plans = {name: board("z", z, (260.0, 260.0, 0.0), middle) for name, z in heights.items()}
    hand = Hand("lamp", [vase, bell, side, across, *plans.values()], settings={"mirror": True})
    reach = {
        name: radius(bell if name in ("Rim", "Cap") else vase, z) for name, z in heights.items()
    }
    hand.only(side)
    right = hand.view(-90.0, 0.0)
    stem, dome = profile(vase, BASE, NECK), profile(bell, RIM, CAP)
    under = np.array([(reach["Neck"], NECK), (reach["Rim"], RIM)])
    share = np.linspace(0.0, 1.0, 60)[:, None]
    under = (1.0 - share) * under[0] + share * under[1]
    flat = (1.0, 0.0), (-1.0, 0.0)
    hand.step(controls=10)
    meridians(hand, "stem", stem, right, flat)
    hand.step(controls=7)
    meridians(hand, "shade", dome, right, flat, edge="crease")
    hand.only(across)
    hand.step(controls=10)
    meridians(hand, "stem", stem, hand.view(0.0, 0.0), ((0.0, -1.0),))
    hand.step(controls=9)
    turn = np.linspace(0.0, np.pi, 240)
    for name, z in heights.items():
        hand.only(plans[name])
        wide = reach[name]
        ring = np.column_stack((wide * np.cos(turn), -wide * np.sin(turn), z + 0.0 * turn))
        above = hand.view(-90.0, 90.0)
        edge = "auto" if name in ("Belly", "Collar") else "crease"
        hand.draw(name, ring, above, edge=edge)
    hand.step(controls=4)
    hand.only(side)
    meridians(hand, "under", under, right, flat)
    hand.only(across)
    meridians(hand, "under", under, hand.view(0.0, 0.0), ((0.0, -1.0),))
    hand.only(bell)
    hand.step(controls=7)
    for number, angle in enumerate(PLEATS, 1):
        a = np.radians(angle)
        course = np.column_stack((dome[:, 0] * np.cos(a), -dome[:, 0] * np.sin(a), dome[:, 1]))
        hand.draw(f"Pleat {number}", course, hand.view(-angle, 24.0), edge="crease")
    hand.only()
    paint(hand, reach)
    return hand


def meridians(
    hand: Hand,
    name: str,
    line: Array,
    camera: Camera,
    ways: Iterable[tuple[float, float]],
    **facts: str,
) -> None:
    """Draw half a section, radius and height (n, 2), out from the middle along ways in plan."""
    words = {(1.0, 0.0): "Front", (-1.0, 0.0): "Back", (0.0, -1.0): "Side"}
    for x, y in ways:
        course = np.column_stack((x * line[:, 0], y * line[:, 0], line[:, 1]))
        hand.draw(f"{words[x, y]} {name}", course, camera, **facts)


def radius(body: Body, z: float) -> float:
    """How wide a round body is at a height, mm."""
    return float(np.interp(z, body.grid[:, 0, 2], body.grid[:, 0, 0]))


def profile(body: Body, low: float, high: float) -> Array:
    """Half a section of a round body between heights: radius and height (n, 2), mm."""
    from scipy.interpolate import CubicSpline

    rows = body.grid[:, 0]
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1))))
    fine = CubicSpline(run, rows[:, [0, 2]])(np.linspace(0.0, run[-1], 4000))
    kept = fine[(fine[:, 1] >= low) & (fine[:, 1] <= high)]
    return np.asarray(kept[np.linspace(0, len(kept) - 1, 300).astype(int)])


def paint(hand: Hand, reach: dict[str, float]) -> None:
    """Colour the surfaces, and let air into the pleats."""
    for angle in (15.0, 45.0, 75.0, 105.0, 135.0, 165.0):
        a = np.radians(-angle)
        place = np.array((118.0 * np.cos(a), 118.0 * np.sin(a), 280.0))
        hand.paint(place, hand.view(-angle, 10.0), color=LINEN, pressure=0.1)
    for angle in (45.0, 135.0):
        a = np.radians(-angle)
        for z, wide in ((50.0, 68.0), (150.0, 66.0), (210.0, 40.0)):
            place = np.array((wide * np.cos(a), wide * np.sin(a), z))
            hand.paint(place, hand.view(-angle, 0.0), color=CLAY, finish="gloss")
        low = 0.5 * (reach["Rim"] + reach["Neck"])
        place = np.array((low * np.cos(a), low * np.sin(a), 217.0))
        hand.paint(place, hand.view(-angle, -40.0), color=LINEN)
    top = np.array((0.0, 0.0, CAP))
    hand.paint(top, hand.view(-90.0, 90.0), color=BRASS, finish="metal", pressure=0.25)
    hand.paint(np.zeros(3), hand.view(-90.0, -90.0), color=INK)
