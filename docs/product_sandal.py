"""What the simulated hand draws of a sandal: a strap on a foot, and a sole under it.

The strap is a closed band: its far side is drawn on the foot, its near side on a larger one, and
it grows out of the sole.
"""

from __future__ import annotations

import numpy as np
from product_hand import Board, Body, Hand, board

from bozzetto.arrays import Array
from bozzetto_product.model.state import RoughShape

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


def last(size: tuple[float, float, float], middle: float) -> Body:
    """A foot of a size, its middle at a height, mm: its sole is a little below the footbed."""
    length, width, height = size
    centre = (0.0, 0.0, middle)
    return Body(
        RoughShape(kind="shoe last", length=length, width=width, height=height, centre=centre)
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
    return ring[int(np.argmin(np.linalg.norm(ring[:, :2] - place[:2], axis=1)))].copy()


def upright(top: Array, low: Array, waist: Array, count: int = 80) -> Array:
    """A line down the side of the sole, drawn in by a way at its middle (n, 3), mm."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    return straight(top, low, count) + waist * 4.0 * share * (1.0 - share)


def sandal() -> Hand:
    """A sandal: a sole of cork with a broad strap."""
    inner, outer = last((250.0, 95.0, 90.0), 60.0), last((258.0, 105.0, 104.0), 66.0)
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
    stations = {"Rear": -70.0, "Waist": -12.0, "Ball": 50.0}
    sections = {name: board("x", x, (0.0, 130.0, 60.0), middle) for name, x in stations.items()}
    boards = [inner, outer, bed, ground, *sections.values()]
    hand = Hand("sandal", boards, settings={"controls": 18})
    rim, floor = outline(outer), outline(outer, 4.0)
    floor[:, 2] = 0.0

    hand.only(bed)
    above = hand.view(-90.0, 90.0)
    hand.draw("Rim", rim, above, edge="crease")
    hand.only(ground)
    hand.draw("Ground", floor, hand.view(-90.0, 90.0), edge="crease")
    hand.step(controls=5)
    for name, x in stations.items():
        hand.only(sections[name])
        front = hand.view(0.0, 0.0)
        for word, side in (("left", 1.0), ("right", -1.0)):
            top, low = (at_station(ring, x, side) for ring in (rim, floor))
            line = upright(top, low, np.array((0.0, -2.0 * side, 0.0)))
            hand.draw(f"{name} {word}", line, front)
    roots = {
        (edge, side): across(inner, along, side)[0]
        for edge, along in (("front", FRONT), ("back", BACK))
        for side in (1.0, -1.0)
    }
    hand.only(bed)
    stand(hand, roots, rim)
    hand.only()
    paint_sole(hand, roots, rim)
    strap(hand, inner, outer)
    hand.only()
    paint_strap(hand, inner, outer)
    return hand


def at_station(ring: Array, x: float, side: float) -> Array:
    """Where a ring crosses a section on one side (3,), mm."""
    half = ring[ring[:, 1] * side > 0.0]
    half = half[np.argsort(half[:, 0])]
    return np.array([np.interp(x, half[:, 0], half[:, k]) if k else x for k in range(3)])


def stand(hand: Hand, roots: dict[tuple[str, float], Array], rim: Array) -> None:
    """Draw where the strap stands on the footbed: lines across, and its far side's ends."""
    above = hand.view(-90.0, 90.0)
    for edge in ("front", "back"):
        ends = [roots[edge, side] for side in (1.0, -1.0)]
        tips = [nearest(rim, place) for place in ends]
        course = np.vstack(
            (straight(tips[0], ends[0], 20), straight(*ends), straight(ends[1], tips[1], 20))
        )
        hand.draw(f"Across {edge}", course, above, edge="crease")
    for word, side in (("left", 1.0), ("right", -1.0)):
        course = straight(roots["front", side], roots["back", side])
        hand.draw(f"Root {word}", course, hand.closer(above, course[50], 2.0), edge="crease")


def strap(hand: Hand, inner: Body, outer: Body) -> None:
    """Draw both sides of the strap, half by half."""
    for word, body in (("Near", outer), ("Far", inner)):
        hand.only(body)
        hand.step(controls=8)
        for edge, along in (("front", FRONT), ("back", BACK)):
            for side, azimuth in ((1.0, 90.0), (-1.0, -90.0)):
                name = f"{word} {edge}" + (" half" if side > 0.0 else "")
                late = (word, edge, side) == ("Far", "front", -1.0)
                course = across(body, along, side, top=TOES if late else TOP)
                rise = 44.0 if edge == "front" else 28.0
                hand.draw(name, course, hand.view(azimuth, rise))
            hand.command("join")
            hand.steps.append({"rename": f"{word} {edge}"})
            hand.steps.append({"set": {"edge": "crease"}})
            hand.steps.append({"select": ""})


def paint_sole(hand: Hand, roots: dict[tuple[str, float], Array], rim: Array) -> None:
    """Colour the sole, and leave open what the strap is to stand on."""
    hand.corners = rim
    above, below = hand.view(-90.0, 90.0), hand.view(-90.0, -90.0)
    for side in (1.0, -1.0):
        root = 0.5 * (roots["front", side] + roots["back", side])
        hand.touch("loop", 0.5 * (root + nearest(rim, root)), hand.closer(above, root))
    for x in (110.0, 50.0, -60.0):
        hand.paint(np.array((x, 0.0, float(footbed(x)))), above, color=SUEDE)
    hand.paint(np.zeros(3), below, color=RUBBER, finish="rubber")
    for x, y, azimuth in ((200.0, 0.0, 0.0), (-200.0, 0.0, 180.0)):
        hand.paint(edge_of(rim, np.array((x, y))), hand.view(azimuth, 0.0), color=CORK)
    for x in (-40.0, 20.0):
        for y, azimuth in ((200.0, 90.0), (-200.0, -90.0)):
            hand.paint(edge_of(rim, np.array((x, y))), hand.view(azimuth, 0.0), color=CORK)


def edge_of(rim: Array, toward: Array) -> Array:
    """A place on the side of the sole, nearest to one far beside it (3,), mm."""
    place = nearest(rim, toward)
    place[2] *= 0.5
    return place


def paint_strap(hand: Hand, inner: Body, outer: Body) -> None:
    """Colour the strap."""
    hand.corners = outer.grid.reshape(-1, 3)
    leather = {"color": LEATHER, "finish": "gloss"}
    hand.paint(across(outer, (50.0, 60.0), 1.0)[-1], hand.view(90.0, 60.0), **leather)
    hand.paint(across(inner, (60.0, 70.0), 1.0)[-1], hand.view(0.0, -15.0), color=SUEDE)
    for along, azimuth in ((FRONT, 0.0), (BACK, 180.0)):
        ends = [across(body, along, 1.0)[-1] for body in (inner, outer)]
        hand.paint(0.5 * (ends[0] + ends[1]), hand.view(azimuth, 10.0), **leather)
