"""What the simulated hand draws for the gallery: curves that were designed on rough shapes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from product_hand import Body, Hand
from product_head import FILE, DrawnHead, head_record
from product_lamp import lamp as lamp
from product_sandal import sandal as sandal
from product_shaver import shaver as shaver

from bozzetto.arrays import Array
from bozzetto_product.model.rough_shapes import RoughShape

NAMES = ("mouse", "remote", "helmet", "shaver", "lamp", "sandal")

WHITE, SAND = (236, 234, 229), (222, 212, 196)
GRAPHITE, INK = (58, 61, 66), (28, 30, 34)
CORAL = (226, 88, 62)


def path(body: Body, *places: tuple[float, float], count: int = 400) -> Array:
    """A smooth curve on a body through places (ring, turn)."""
    from scipy.interpolate import PchipInterpolator

    row = np.array(places, float)
    along = np.linspace(0.0, 1.0, len(row))
    ring, turn = PchipInterpolator(along, row)(np.linspace(0.0, 1.0, count)).T
    return body.at(ring, turn)


def over(body: Body, places: Array, *, up: float = 1.0) -> Array:
    """Places (n, 2) in plan, dropped on a body from above, or from below (-1); (n, 3), mm."""
    from bozzetto.scene import Layer, Scene, Shaded, cast_rays
    from bozzetto.view import Rays

    origins = np.column_stack((places, np.full(len(places), 1000.0 * up)))
    ways = np.tile((0.0, 0.0, -up), (len(places), 1))
    scene = Scene((Layer("body", (Shaded(body.mesh),)),))
    hits = cast_rays(scene, Rays(origins, ways))
    return hits.points[hits.hit]


def bent(*places: tuple[float, ...], count: int = 400) -> Array:
    """A smooth curve through places."""
    from scipy.interpolate import CubicSpline

    row = np.array(places, float)
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(row, axis=0), axis=1))))
    return np.asarray(CubicSpline(along, row)(np.linspace(0.0, along[-1], count)))


def ring_at(body: Body, height: float) -> float:
    """The ring of a body at a height, mm."""
    return float(np.interp(height, body.grid[:, 0, 2], np.arange(len(body.grid))))


def mouse() -> Hand:
    """A computer mouse: graphite sides, a coral line, a white shell with two buttons."""
    body = Body(
        RoughShape(kind="mouse", length=122.0, width=66.0, height=40.0, centre=(0.0, 0.0, 20.0))
    )
    hand = Hand("mouse", [body], settings={"mirror": True, "controls": 12})
    side, below, above = hand.view(-90.0, 0.0), hand.view(-90.0, -90.0), hand.view(-90.0, 90.0)
    low, rail, line = 2.8, 9.0, 10.6
    front, back = 0.0, -0.5
    spine = np.vstack(
        (path(body, (low, front), (20.5, front)), path(body, (20.5, back), (low, back)))
    )
    hand.draw("Spine", spine, side)
    hand.command("in-plane")
    hand.draw("Base", path(body, (low, front), (low, back)), below, edge="crease")
    hand.draw("Sole", over(body, bent((57.5, 0.0), (-57.5, 0.0)), up=-1.0), below)
    hand.draw("Rail", path(body, (rail, front), (rail + 1.5, -0.25), (rail, back)), above)
    hand.draw("Line", path(body, (line, front), (line + 2.0, -0.25), (line, back)), above)
    hand.step(controls=7)
    for name, turn in (("Front", -0.1), ("Back", -0.37)):
        course = path(body, (low, turn), (line + 1.3, turn))
        hand.draw(name, course, hand.view(360.0 * turn, -14.0))
    hand.draw("Buttons", over(body, bent((6.0, 0.0), (8.0, -10.0), (22.0, -24.6))), above)
    hand.draw(
        "Wheel",
        over(body, bent((46.0, 0.0), (41.0, -3.6), (34.0, -4.6), (27.0, -3.6), (22.0, 0.0))),
        above,
    )
    hand.command("hide-rough")
    near, tail = hand.view(-55.0, 28.0), hand.view(-150.0, 24.0)
    for x, y in ((30.0, -12.0), (-20.0, -12.0)):
        hand.paint(over(body, np.array([[x, y]]))[0], above, color=WHITE, finish="gloss")
    hand.paint(over(body, np.array([[34.0, -2.5]]))[0], above, color=INK, finish="gloss")
    for turn, view in ((-0.05, near), (-0.24, near), (-0.45, tail)):
        hand.paint(body.at(6.0, turn)[0], view, color=GRAPHITE, finish="rubber")
        hand.paint(
            body.at((rail + line + 2.0) / 2.0 + (0.9 if turn == -0.24 else -0.2), turn)[0],
            view,
            color=CORAL,
            finish="gloss",
        )
    hand.paint(np.array((0.0, -12.0, 0.0)), below, color=INK)
    return hand


def remote() -> Hand:
    """A remote control: a slim bar, its face in two tones, a round pad and a lens at its front."""
    body = Body(
        RoughShape(kind="rounded box", length=168.0, width=44.0, height=19.0, centre=(0, 0, 9.5))
    )
    hand = Hand("remote", [body], settings={"mirror": True, "controls": 14})
    side, below, above = hand.view(-90.0, 0.0), hand.view(-90.0, -90.0), hand.view(-90.0, 90.0)
    foot, edge, inlay = 10.0, 22.5, 29.0
    rise = path(body, (foot, 0.0), (34.5, 0.0))
    fall = path(body, (34.5, -0.5), (foot, -0.5))
    hand.draw("Spine", np.vstack((rise, fall)), side)
    hand.command("in-plane")
    hand.draw("Foot", path(body, (foot, 0.0), (foot, -0.5)), below, edge="crease")
    hand.draw("Sole", over(body, bent((77.4, 0.0), (-77.4, 0.0)), up=-1.0), below)
    hand.draw("Edge", path(body, (edge, 0.0), (edge, -0.5)), above, edge="crease")
    hand.draw("Inlay", path(body, (inlay, 0.0), (inlay, -0.5)), above, edge="crease")
    hand.step(controls=7)
    for name, turn, azimuth in (
        ("Front", -0.1, -58.0),
        ("Side", -0.246, -90.0),
        ("Back", -0.4, -122.0),
    ):
        hand.draw(name, path(body, (foot, turn), (edge, turn)), hand.view(azimuth, 0.0))
        hand.draw(f"{name} rim", path(body, (edge, turn), (inlay, turn)), hand.view(azimuth, 50.0))
    arc = np.linspace(0.0, np.pi, 60)
    pads = hand.closer(above, np.array((34.0, 0.0, 19.0)), 4.0)
    keys = hand.closer(above, np.array((-8.0, 0.0, 19.0)), 2.5)
    for name, middle, radius in (("Pad", 34.0, 12.5), ("Centre", 34.0, 5.5)):
        ring = np.column_stack((middle + radius * np.cos(arc), -radius * np.sin(arc)))
        hand.draw(name, over(body, ring), pads)
    hand.draw("Pad line", over(body, bent((34.0, -12.5), (34.0, -16.6))), pads)
    hand.draw("Cross", over(body, bent((12.6, 0.0), (12.6, -16.7))), keys)
    hand.draw(
        "Rocker",
        over(
            body,
            bent(
                (2.0, 0),
                (0.6, -3),
                (-3.0, -4.6),
                (-14.0, -5.0),
                (-25.0, -4.6),
                (-28.6, -3),
                (-30.0, 0),
            ),
        ),
        keys,
    )
    hand.command("hide-rough")
    top = {
        "Glass": (INK, ((55.0, -8.0), (20.0, -10.0))),
        "Pad": (SAND, ((34.0, -9.0),)),
        "Centre": (CORAL, ((34.0, -2.5),)),
        "Face": (SAND, ((-50.0, -10.0),)),
        "Rocker": (INK, ((-15.0, -2.5),)),
    }
    for color, places in top.values():
        for place in places:
            hand.paint(over(body, np.array([place]))[0], above, color=color, finish="gloss")
    for turn, azimuth in ((-0.04, -20.0), (-0.2, -90.0), (-0.3, -90.0), (-0.46, -160.0)):
        hand.paint(body.at(17.0, turn)[0], hand.view(azimuth, 0.0), color=GRAPHITE, finish="rubber")
        hand.paint(body.at(25.5, turn)[0], hand.view(azimuth, 60.0, near=1.2), color=SAND)
    hand.paint(np.array((20.0, -9.0, 0.0)), below, color=GRAPHITE)
    return hand


def helmet() -> Hand:
    """A bicycle helmet on a drawn head: a brim, ridges from brow to neck, vents along them."""
    head = DrawnHead()
    hand = Hand("helmet", [head], settings={"mirror": True, "controls": 10})
    hand.facts["on"] = {"drawing": {"file": FILE}}
    hand.beside[FILE] = head_record()
    side = hand.view(-90.0, 0.0)
    brow, neck = ring_at(head, 176.0), ring_at(head, 126.0)

    def brim(turn: float) -> float:
        share = np.clip(turn / -0.5, 0.0, 1.0) ** 1.2
        return brow + (neck - brow) * 0.5 * (1.0 - np.cos(np.pi * share))

    def along(first: float, last: float) -> Array:
        turns = np.linspace(first, last, 400)
        return head.at(np.array([brim(turn) for turn in turns]), turns)

    top = 37.0
    spine = (path(head, (brow, 0.0), (top, 0.0)), path(head, (top, -0.5), (neck, -0.5)))
    hand.draw("Spine", np.vstack(spine), side)
    hand.command("in-plane")
    ends = along(0.0, -0.5)[[0, -1]]
    share = np.linspace(0.0, 1.0, 200)[:, None]
    hand.draw("Under", (1.0 - share) * ends[0] + share * ends[1], side)
    hand.command("in-plane")
    for name, first, last, azimuth in (
        ("Brow", 0.0, -0.13, -22.0),
        ("Temple", -0.13, -0.36, -90.0),
        ("Neck", -0.36, -0.5, -156.0),
    ):
        hand.draw(name, along(first, last), hand.view(azimuth, 8.0), edge="crease")
    hand.step(controls=7)
    for name, x, azimuth in (("Fore", 48.0, -62.0), ("Mid", -6.0, -90.0), ("Aft", -58.0, -118.0)):
        course = crosswise(head, x, along(0.0, -0.5))
        hand.draw(f"{name} arc", course, hand.view(azimuth, 38.0))
    hand.step(controls=12)
    flank, ridge = (np.vstack(lengthwise(head, wide, brim)) for wide in (55.0, 27.0))
    hand.draw("Flank", flank, hand.view(-90.0, 34.0))
    ridge = ridge[(ridge[:, 0] <= 48.0) & (ridge[:, 0] >= -58.0)]
    hand.draw("Ridge", ridge, hand.view(-90.0, 62.0))
    hand.command("hide-rough")
    shell, channel = {"color": WHITE, "finish": "gloss"}, {"color": CORAL, "finish": "gloss"}
    for x in (66.0, 20.0, -30.0, -78.0):
        for y, facts in (
            (-10.0, shell),
            (-38.0 if abs(x) < 60 else -34.0, channel),
            (-64.0, shell),
        ):
            place = over(head, np.array([[x, y if y > -60.0 or abs(x) < 60 else -51.0]]))[0]
            hand.paint(place, hand.view(-90.0, 60.0), **facts)
    hand.paint(np.array((0.0, -20.0, 150.0)), hand.view(-90.0, -60.0), color=INK)
    for x, y, long in VENTS:
        vent(hand, head, x, y, long)
    return hand


VENTS = ((22.0, -40.0, 19.0), (-32.0, -41.0, 18.0), (20.0, -13.0, 20.0), (-30.0, -13.0, 20.0))
"""Middles of vents on the right side, seen from above, and half their lengths, mm."""


def vent(hand: Hand, head: Body, x: float, y: float, long: float) -> None:
    """Press a long round into the helmet, and its mirror image into the other side."""
    turn = np.linspace(0.0, 2.0 * np.pi, 160)
    wide = 0.24 * long
    # Fuller than an ellipse at its ends.
    along = np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** 0.8
    across = np.sign(np.sin(turn)) * np.abs(np.sin(turn)) ** 0.8
    round_ = over(head, np.column_stack((x + long * along, y + wide * across)))
    view = hand.closer(hand.view(-90.0, 62.0), round_.mean(axis=0), 3.0)
    hand.round(round_, view, kind="in", depth=6.0, draft=12.0, mirrored=True, color=INK)


def crosswise(body: Body, x: float, brim: Array) -> Array:
    """A curve across a body, on the right side, from the middle down to its brim, (n, 3)."""
    top = over(body, np.column_stack((np.full(300, x), np.linspace(0.0, -200.0, 300))))
    turns = np.linspace(0.0, -0.5, 600)
    rows = [body.at(ring, turns) for ring in np.linspace(37.0, 12.0, 400)]
    side = np.array([row[int(np.argmax(row[:, 0] <= x))] for row in rows])
    course = np.vstack((top, side[side[:, 2] < top[-1, 2]]))
    low = np.interp(x, brim[::-1, 0], brim[::-1, 2])
    return course[course[:, 2] >= low]


def lengthwise(body: Body, wide: float, brim: Callable[[float], float]) -> tuple[Array, Array]:
    """Both halves of a curve over a body, lengthwise, on the right side so far from the middle.

    It draws nearer to the middle at its ends.
    """
    halves = []
    for low, high in ((0.0, -0.25), (-0.5, -0.25)):
        turns = np.linspace(low, high, 300)
        row = []
        for ring in np.linspace(37.0, 12.0, 300):
            points = body.at(ring, turns)
            off = -points[:, 1] - wide * (0.72 + 0.28 * (ring - 12.0) / 25.0)
            if off.max() < 0.0:
                continue
            number = int(np.argmax(off >= 0.0))
            if ring < brim(turns[number]):
                break
            row.append(points[number])
        halves.append(np.array(row))
    ahead, behind = halves
    join = 0.5 * (ahead[:1] + behind[:1])
    return np.vstack((ahead[:2:-1], join)), np.vstack((join, behind[3:]))
