"""What the simulated hand draws of a sandal: a strap on a foot, and a sole under it.

The strap is a closed band: its far side is drawn on the foot, its near side on a larger one, and
it grows out of the sole.
"""

from __future__ import annotations

import numpy as np
from product_hand import Board, Body, Hand, board

from bozzetto.arrays import Array
from bozzetto_product.model.rough_shapes import RoughShape

CORK, SUEDE, LEATHER, RUBBER = (206, 168, 122), (226, 205, 176), (36, 74, 88), (44, 42, 40)

HEEL, TOE = 30.0, 18.0
"""Height of the footbed at both ends of its board, mm."""

LONG = 280.0
"""Length of that board, mm."""

FRONT, BACK = (78.0, 96.0), (22.0, 26.0)
"""Where the edges of the strap are along the foot: at the sole, and on top; mm."""

TOP, TOES = 0.25, 0.2535
"""Share of a turn at which halves of the strap end: on top. By the toes the second one goes on
until the first, which ends before."""


def footbed(x: Array) -> Array:
    """Height of the footbed, mm."""
    return np.asarray(HEEL + (TOE - HEEL) * (np.asarray(x) / LONG + 0.5))


def last(grow: float) -> Body:
    """A foot that stands a little below the footbed, so much larger all round, mm."""
    size = np.array((250.0, 95.0, 90.0)) + 2.0 * grow
    length, width, height = map(float, size)
    return Body(
        RoughShape(kind="shoe last", length=length, width=width, height=height, centre=(0, 0, 60))
    )


def outline(body: Body, inset: float = 0.0, count: int = 500) -> Array:
    """Where the footbed ends, round the foot from the toe (n, 3), mm."""
    from scipy.interpolate import CubicSpline

    stations = np.array((-112.0, -85.0, -50.0, -10.0, 30.0, 65.0, 92.0, 112.0))
    left, right = (np.array([beside(body, x, side)[1] for x in stations]) for side in (1.0, -1.0))
    reach = float(body.grid[:, :, 0].max())
    ring = np.vstack(
        (
            [(reach + 4.0, 0.6)],
            np.column_stack((stations, left))[::-1],
            [(-reach - 4.0, 0.0)],
            np.column_stack((stations, right)),
            [(reach + 4.0, 0.6)],
        )
    )
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1) ** 0.6)))
    spline = CubicSpline(run, ring, bc_type="periodic")
    at = np.linspace(0.0, run[-1], count)
    plan, way = spline(at), spline(at, 1)
    way = way / np.linalg.norm(way, axis=1)[:, None]
    plan = plan + inset * np.column_stack((-way[:, 1], way[:, 0]))
    return np.column_stack((plan, footbed(plan[:, 0])))


def beside(body: Body, x: float, side: float) -> Array:
    """The place on the left side (1) or the right one (-1) of a foot at the footbed (3,), mm."""
    course = across(body, (x, x), side, top=0.2)
    return course[0]


def across(
    body: Body, along: tuple[float, float], side: float, *, top: float = 0.25, count: int = 200
) -> Array:
    """A course on a foot from the footbed up to the top, or a share of a turn before (n, 3), mm."""
    turns = np.linspace(-0.2, top, 2000)
    x = np.interp(turns, (-0.05, 0.25), along)
    rings = np.interp(x, body.grid[:, 16, 0], np.arange(len(body.grid)))
    places = body.at(rings, turns if side > 0.0 else 0.5 - turns)
    first = int(np.argmax(places[:, 2] >= footbed(places[:, 0])))
    places = places[first:]
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    at = np.linspace(0.0, run[-1], count)
    return np.stack([np.interp(at, run, places[:, k]) for k in range(3)], axis=1)


def straight(first: Array, end: Array, count: int = 100) -> Array:
    """Places on a line (n, 3), mm."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    return (1.0 - share) * first + share * end


def nearest(ring: Array, place: Array) -> Array:
    """The place of a ring nearest to one in plan (3,), mm."""
    return np.asarray(ring[int(np.argmin(np.linalg.norm(ring[:, :2] - place[:2], axis=1)))])


def upright(top: Array, low: Array, waist: Array, count: int = 80) -> Array:
    """A line down the side of the sole, drawn in by a way at its middle (n, 3), mm."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    return straight(top, low, count) + waist * 4.0 * share * (1.0 - share)


def sandal() -> Hand:
    """A sandal: a sole of cork with a broad strap."""
    inner, outer = last(0.0), last(4.0)
    bed = Board(
        RoughShape(
            kind="wedge",
            length=LONG,
            width=130.0,
            height=(HEEL - TOE) / 0.85,
            centre=(0.0, 0.0, HEEL - 0.5 * (HEEL - TOE) / 0.85),
        )
    )
    middle = np.array((0.0, 0.0, 12.0))
    ground = board("z", 0.0, (290.0, 130.0, 0.0), middle)
    lengthwise = board("y", 0.0, (300.0, 0.0, 60.0), middle)
    stations = {"Rear": -70.0, "Waist": -12.0, "Ball": 50.0}
    sections = {name: board("x", x, (0.0, 130.0, 60.0), middle) for name, x in stations.items()}
    boards = [inner, outer, bed, ground, lengthwise, *sections.values()]
    hand = Hand("sandal", boards, settings={"controls": 18})
    rim, floor = outline(outer), outline(outer, 4.0)
    floor[:, 2] = 0.0

    hand.only(bed)
    above = hand.view(-90.0, 90.0)
    hand.draw("Rim", rim, above, edge="crease")
    hand.only(ground)
    hand.draw("Ground", floor, hand.view(-90.0, 90.0), edge="crease")
    hand.step(controls=5)
    hand.only(lengthwise)
    right = hand.view(-90.0, 0.0)
    for name, end in (("Toe", 1.0), ("Heel", -1.0)):
        top, low = (middle_end(ring, end) for ring in (rim, floor))
        hand.draw(name, upright(top, low, np.array((-1.5 * end, 0.0, 0.0))), right)
    for name, x in stations.items():
        hand.only(sections[name])
        front = hand.view(0.0, 0.0)
        for word, side in (("left", 1.0), ("right", -1.0)):
            place = np.array((x, 200.0 * side))
            top, low = (at_station(ring, x, side) for ring in (rim, floor))
            assert place[1] * top[1] > 0.0
            line = upright(top, low, np.array((0.0, -2.0 * side, 0.0)))
            hand.draw(f"{name} {word}", line, front)
    strap(hand, inner, outer, bed, rim)
    hand.only()
    paint(hand, outer)
    return hand


def middle_end(ring: Array, end: float) -> Array:
    """Where a ring crosses the middle at the toe (1) or the heel (-1) (3,), mm."""
    half = ring[ring[:, 0] * end > 0.0]
    place = half[int(np.argmin(np.abs(half[:, 1])))].copy()
    place[1] = 0.0
    return np.asarray(place)


def at_station(ring: Array, x: float, side: float) -> Array:
    """Where a ring crosses a section on one side (3,), mm."""
    half = ring[ring[:, 1] * side > 0.0]
    half = half[np.argsort(half[:, 0])]
    return np.array([np.interp(x, half[:, 0], half[:, k]) if k else x for k in range(3)])


def strap(hand: Hand, inner: Body, outer: Body, bed: Board, rim: Array) -> None:
    """Draw the strap: both its sides half by half, and where it stands on the footbed."""
    roots: dict[tuple[str, float], Array] = {}
    for word, body in (("Near", outer), ("Far", inner)):
        hand.only(body)
        hand.step(controls=8)
        for edge, along in (("front", FRONT), ("back", BACK)):
            for side, azimuth in ((1.0, 90.0), (-1.0, -90.0)):
                late = (word, edge, side) == ("Far", "front", -1.0)
                course = across(body, along, side, top=TOES if late else TOP)
                if word == "Far":
                    roots[edge, side] = course[0]
                name = f"{word} {edge}" + (" half" if side > 0.0 else "")
                hand.draw(name, course, hand.view(azimuth, 44.0))
            hand.command("join")
            hand.steps.append({"rename": f"{word} {edge}"})
            hand.steps.append({"set": {"edge": "crease"}})
            hand.steps.append({"select": ""})
    hand.only(bed)
    above = hand.view(-90.0, 90.0)
    hand.step(controls=5)
    for edge in ("front", "back"):
        ends = [roots[edge, side] for side in (1.0, -1.0)]
        tips = [nearest(rim, place) for place in ends]
        course = np.vstack(
            (straight(tips[0], ends[0], 20), straight(*ends), straight(ends[1], tips[1], 20))
        )
        hand.draw(f"Across {edge}", course, above, edge="crease")
    for word, side in (("left", 1.0), ("right", -1.0)):
        course = straight(roots["front", side], roots["back", side])
        hand.draw(f"Root {word}", course, above, edge="crease")


def paint(hand: Hand, outer: Body) -> None:
    """Colour the surfaces."""
    hand.corners = np.vstack((outer.grid.reshape(-1, 3), np.zeros((1, 3))))
    top = across(outer, (50.0, 60.0), 1.0)
    hand.paint(top[-1], hand.view(90.0, 60.0), color=LEATHER, finish="gloss")
