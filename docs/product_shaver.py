"""What the simulated hand draws of an electric shaver: planar curves on boards, then on surfaces.

The head is at -x. The form that is meant is one of sections: half a width, a top and a bottom at
each place along it, between them superellipses.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from product_hand import Board, Hand, board

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_product.model.rough_shapes import RoughShape

GRAPHITE, INK, STEEL = (52, 55, 61), (26, 28, 32), (196, 200, 205)
SILVER, TEAL, GREEN = (222, 224, 225), (16, 118, 128), (126, 226, 150)

ROUND = 2.5
"""Exponent of the sections: 2 is an ellipse."""

RIM, BEZEL, TAIL = -70.0, -77.0, 84.0
"""Where the head and the handle end, and the face of the foils is, along x, mm."""

LOW = -5.0
"""Height of the lower rail, mm."""

SECTIONS = {"Head": -56.0, "Neck": -42.0, "Grip": -14.0, "Palm": 22.0, "Heel": 56.0, "Cap": 74.0}

RIBS = (-9.0, -1.0, 7.0, 15.0, 25.0, 33.0, 41.0, -39.0, -31.0, -23.0)
"""Where the lines across the rubber begin, mm."""

PADS = (-39.5, -32.5, -24.5, -17.0, -10.0, -2.5, 5.5, 13.5, 20.0, 24.7, 31.5, 39.5, 50.0)
"""Places between them, mm."""

#             along, half width, top, bottom
FORM = (
    (RIM, 31.0, 17.5, -16.5),
    (-56.0, 29.8, 16.6, -15.6),
    (-42.0, 26.0, 13.6, -13.4),
    (-14.0, 25.6, 15.6, -15.4),
    (22.0, 28.0, 18.6, -17.0),
    (56.0, 29.0, 17.6, -16.6),
    (TAIL, 29.2, 15.4, -15.4),
)


def form(x: Array) -> tuple[Array, Array, Array]:
    """Half width, top and bottom at places along the body, mm; it closes at its tail."""
    from scipy.interpolate import CubicSpline

    table = np.array(FORM)
    wide, top, bottom = CubicSpline(table[:, 0], table[:, 1:])(np.ravel(x)).T
    far = np.clip((np.ravel(x) - 10.0) / (TAIL - 10.0), 0.0, 1.0)
    close = (1.0 - far**2.7) ** (1.0 / 2.7)
    low = 1.0 - 2.0 * far**2
    return wide * close, (top + low) * close - low, (bottom + low) * close - low


def half_width(x: Array, z: Array) -> Array:
    """How far the body reaches from the middle at a place along it and a height, mm."""
    wide, top, bottom = form(x)
    share = np.clip(np.ravel(z) / np.where(np.ravel(z) > 0.0, top, bottom), 0.0, 1.0)
    return np.asarray(wide * (1.0 - share**ROUND) ** (1.0 / ROUND))


def section(x: float, *, inset: float = 0.0, count: int = 300) -> Array:
    """The right half of a section from the top to the bottom (n, 3), mm."""
    (wide,), (top,), (bottom,) = form(np.array([x]))
    turn = np.linspace(0.0, np.pi, count)
    out, up = np.abs(np.sin(turn)) ** (2.0 / ROUND), np.abs(np.cos(turn)) ** (2.0 / ROUND)
    z = np.where(turn < 0.5 * np.pi, (top - inset) * up, (bottom + inset) * up)
    return np.column_stack((np.full(count, x), -(wide - inset) * out, z))


def rail(height: Array, x: Array) -> Array:
    """The right half of a line round the body at heights that go with x (n, 3), mm."""
    return np.column_stack((x, -half_width(x, height), height))


def shaver() -> Hand:
    """An electric shaver: two shells, a wedge of rubber between them, and a head of foils."""
    middle = np.array((3.0, 0.0, 0.0))
    side = board("y", 0.0, (172.0, 0.0, 50.0), middle)
    wedge = Board(RoughShape(kind="wedge", length=180.0, width=80.0, height=10.0, centre=(0, 0, 4)))
    flat = board("z", LOW, (172.0, 76.0, 0.0), middle)
    across = {name: board("x", x, (0.0, 74.0, 48.0), middle) for name, x in SECTIONS.items()}
    rim, face = (board("x", x, (0.0, 74.0, 48.0), middle) for x in (RIM, BEZEL))
    boards = [side, wedge, flat, *across.values(), rim, face]
    hand = Hand("shaver", boards, settings={"mirror": True, "controls": 16})

    hand.only(side)
    right = hand.view(-90.0, 0.0)
    along = TAIL - (TAIL - RIM) * np.linspace(1.0, 0.0, 400) ** 2
    _, top, bottom = form(along)
    upper, lower = (np.column_stack((along, 0.0 * along, z)) for z in (top, bottom))
    hand.draw("Spine", np.vstack((upper, lower[::-1])), right)
    hand.step(controls=5)
    for name, up, inset in (("Brow", top[0], -3.0), ("Chin", bottom[0], 3.0)):
        hand.draw(name, lip((RIM, 0.0, up), (BEZEL, 0.0, up + inset)), close(hand, right, up))

    hand.step(controls=12)
    above = hand.view(-90.0, 90.0)
    hand.only(wedge)
    hand.draw("Upper rail", rail_to(upper_height), above)
    hand.only(flat)
    hand.draw("Lower rail", rail_to(lambda x: LOW + 0.0 * x), above)

    hand.step(controls=10)
    for name, x in SECTIONS.items():
        hand.only(across[name])
        hand.draw(name, section(x), hand.view(0.0, 0.0))
    hand.only(rim)
    hand.draw("Rim", section(RIM), hand.view(0.0, 0.0), edge="crease")
    hand.only(face)
    back = hand.view(0.0, 0.0)
    bezel = section(RIM, inset=3.0) + np.array((BEZEL - RIM, 0.0, 0.0))
    hand.draw("Bezel", bezel, back, edge="crease")
    hand.step(controls=4)
    for name, z in (("Foil", 2.4), ("Trimmer", -2.4)):
        reach = float(np.interp(z, bezel[::-1, 2], -bezel[::-1, 1]))
        line = np.array((BEZEL, 0.0, z)) - np.linspace(0.0, reach, 60)[:, None] * (0.0, 1.0, 0.0)
        hand.draw(name, line, back, edge="crease")
    hand.only()
    seams(hand)
    paint(hand)
    return hand


def seams(hand: Hand) -> None:
    """Draw on the surfaces that are there: seams, the grip, and the buttons."""
    hand.corners = np.vstack([section(x) for x in (RIM, TAIL - 1.0)] + [[(BEZEL, 0.0, 0.0)]])
    above, below = hand.view(-90.0, 90.0), hand.view(-90.0, -90.0)
    hand.step(controls=8)
    neck, heel = SECTIONS["Neck"], SECTIONS["Heel"]
    hand.draw("Crown", on_top(lengthwise(neck, heel, 0.6)), above)
    hand.draw("Sole", on_top(lengthwise(neck, heel, 0.6), up=-1.0), below)
    hand.step(controls=4)
    for number, x in enumerate(RIBS[:7], 1):
        rib(hand, number, x)
    hand.step(controls=8)
    for name, middle, half, wide in (
        ("Ring", 4.0, 14.5, 10.5),
        ("Power", 4.0, 11.0, 7.5),
        ("Lock", -27.0, 7.0, 4.5),
        ("Lamp", 34.0, 6.0, 2.4),
    ):
        near = hand.closer(above, np.array((middle, 0.0, 15.0)), 3.0)
        hand.draw(name, on_top(oval(middle, half, wide)), near)
    near = hand.closer(below, np.array((39.0, 0.0, -15.0)), 3.0)
    hand.draw("Label", on_top(oval(39.0, 9.0, 6.5), up=-1.0), near)
    hand.step(controls=4)
    for number, x in enumerate(RIBS[7:], 8):
        rib(hand, number, x)


def rib(hand: Hand, number: int, x: float) -> None:
    """Draw a line across the rubber, from near by."""
    line = slanted(x)
    hand.draw(f"Rib {number}", line, hand.closer(hand.view(-90.0, 0.0), line[30], 4.0))


def paint(hand: Hand) -> None:
    """Colour the surfaces, and press out those of the foils."""
    front, right = hand.view(180.0, 0.0), hand.view(-90.0, 0.0)
    above, below = hand.view(-90.0, 90.0), hand.view(-90.0, -90.0)
    half_above, half_below = hand.view(-90.0, 40.0), hand.view(-90.0, -40.0)
    gloss, matt = {"color": SILVER, "finish": "gloss"}, {"color": GRAPHITE, "finish": "matt"}
    for x in (-63.0, -49.0, 65.0, 79.0):
        hand.paint(shell(x, 0.5), above, **gloss)
        hand.paint(shell(x, 0.5, up=-1.0), below, **matt)
        hand.paint(belt(x), right, color=INK, finish="rubber")
    for x in (-32.0, 20.0, 46.0):
        hand.paint(shell(x, 0.4), above, color=TEAL, finish="gloss")
        hand.paint(shell(x, 0.8), half_above, **gloss)
        hand.paint(shell(x, 0.3, up=-1.0), below, **matt)
        hand.paint(shell(x, 0.85, up=-1.0), half_below, **matt)
    for number, x in enumerate(PADS):
        hand.paint(belt(x), right, color=INK if number % 2 else TEAL, finish="rubber")
    for (x, y), facts in (
        ((16.7, -1.5), {"color": STEEL, "finish": "metal"}),
        ((4.0, -3.0), {"color": INK, "finish": "gloss"}),
        ((-27.0, -2.0), {"color": INK, "finish": "rubber"}),
        ((34.0, -1.0), {"color": GREEN, "finish": "gloss"}),
    ):
        hand.paint(on_top(np.array([(x, y)]))[0], above, **facts)
    hand.paint(on_top(np.array([(39.0, -2.0)]), up=-1.0)[0], below, color=STEEL, finish="metal")
    hand.paint(np.array((0.4 * RIM + 0.6 * BEZEL, -30.0, 2.0)), right, color=STEEL, finish="metal")
    for z in (8.0, -8.0):
        place = np.array((BEZEL, -5.0, z))
        hand.paint(place, front, color=STEEL, finish="metal", pressure=0.16)
    hand.paint(np.array((BEZEL, -5.0, 0.0)), front, color=INK, pressure=0.1)


def shell(x: float, share: float, *, up: float = 1.0) -> Array:
    """A place so far from the middle, as a share of the width, of a shell (3,), mm."""
    return on_top(lengthwise(x, x, share)[:1], up=up)[0]


def belt(x: float) -> Array:
    """A place half-way between the rails (3,), mm."""
    at = np.array([x])
    return rail(0.5 * (upper_height(at) + LOW), at)[0]


def lip(first: tuple[float, float, float], last: tuple[float, float, float]) -> Array:
    """A quarter of a round between two places, leaving the first one lengthwise (n, 3)."""
    turn = np.linspace(0.0, 0.5 * np.pi, 60)[:, None]
    start, end = np.array(first), np.array(last)
    way = end - start
    return start + way * np.where(np.arange(3) == 0, np.sin(turn), 1.0 - np.cos(turn))


def close(hand: Hand, camera: Camera, up: float) -> Camera:
    """A view of the edge of the head."""
    return hand.closer(camera, np.array((BEZEL, 0.0, up)), 3.0)


def rail_to(height: Callable[[Array], Array], count: int = 400) -> Array:
    """A rail from the rim to where it meets the spine at the tail (n, 3), mm."""
    from scipy.optimize import brentq

    def room(x: float) -> float:
        _, (top,), (bottom,) = form(np.array([x]))
        z = float(height(np.array([x]))[0])
        return float(min(top - z, z - bottom))

    end = brentq(room, 0.0, TAIL)
    x = end - (end - RIM) * np.linspace(1.0, 0.0, 4000) ** 4
    points = rail(height(x), x)
    points[-1, 1] = 0.0
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    at = np.linspace(0.0, run[-1], count)
    return np.stack([np.interp(at, run, points[:, k]) for k in range(3)], axis=1)


def on_top(places: Array, *, up: float = 1.0) -> Array:
    """Places (n, 2) in plan, on the upper side, or the lower one (-1); (n, 3), mm."""
    wide, top, bottom = form(places[:, 0])
    share = np.clip(np.abs(places[:, 1]) / wide, 0.0, 1.0)
    rise = (1.0 - share**ROUND) ** (1.0 / ROUND)
    return np.column_stack((places, rise * (top if up > 0.0 else bottom)))


def oval(middle: float, half: float, wide: float) -> Array:
    """The right half of an oval about a place on the spine, in plan (n, 2), mm."""
    turn = np.linspace(0.0, np.pi, 120)
    round_ = 2.0 / 2.4
    out, along = np.sin(turn) ** round_, np.abs(np.cos(turn)) ** round_ * np.sign(np.cos(turn))
    return np.column_stack((middle + half * along, -wide * out))


def lengthwise(first: float, last: float, share: float) -> Array:
    """A line along the body that far from its middle, as a share of its width, in plan (n, 2)."""
    x = np.linspace(first, last, 200)
    return np.column_stack((x, -share * form(x)[0]))


def upper_height(x: Array) -> Array:
    """Height of the upper rail, mm: it falls towards the tail."""
    return np.asarray(9.0 - 0.85 * 10.0 / 180.0 * (x + 90.0))


def slanted(x: float) -> Array:
    """A line across the rubber, from the lower rail up to the upper one (n, 3), mm."""
    along = x + np.linspace(0.0, 5.0, 60)
    z = LOW + (upper_height(along[-1:]) - LOW) * np.linspace(0.0, 1.0, 60)
    return rail(z, along)
