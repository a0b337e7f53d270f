"""What the simulated hand draws of a sandal: a sole under a foot, and two straps over it."""

from __future__ import annotations

import numpy as np
from product_hand import Board, Body, Hand, board

from bozzetto.arrays import Array
from bozzetto_product.model.rough_shapes import RoughShape

LEATHER, SUEDE = (178, 74, 44), (120, 62, 44)
CORK, FOAM, RUBBER = (214, 178, 130), (240, 234, 222), (52, 50, 52)

GROUND, WELT, BED, TUCKED = 0.0, 9.0, 24.0, 16.0
"""Heights of the outlines of the sole, and of the ends of straps, which are tucked into it, mm."""

OUTLINE = (
    (137.0, -4.0),
    (122.0, 36.0),
    (84.0, 57.0),
    (44.0, 61.0),
    (-6.0, 57.0),
    (-60.0, 46.0),
    (-112.0, 40.0),
    (-138.0, 0.0),
    (-112.0, -40.0),
    (-60.0, -47.0),
    (-6.0, -54.0),
    (44.0, -58.0),
    (84.0, -59.0),
    (120.0, -42.0),
)
"""The footbed seen from above, round from the toe, mm."""

STRAPS = {"Vamp": (82.0, 42.0), "Instep": (18.0, -8.0)}
"""Where straps begin and end along the foot, mm."""

SIDES = {"inside": 0.8, "outside": 5.3}
"""Distance of both sides of a strap from the foot, mm."""


def sandal() -> Hand:
    """A sandal on a foot: cork on foam on rubber, and two straps of leather, each a solid."""
    foot = Body(
        RoughShape(kind="shoe last", length=250.0, width=96.0, height=110.0, centre=(0, 0, 77.0))
    )
    middle = np.array((0.0, 0.0, 60.0))
    plans = {
        name: board("z", z, (290.0, 140.0, 0.0), middle)
        for name, z in (("Ground", GROUND), ("Welt", WELT), ("Bed", BED))
    }
    under = board("z", TUCKED, (290.0, 140.0, 0.0), middle)
    ends = {
        f"{name} {which}": board("x", x, (0.0, 130.0, 120.0), middle)
        for name, places in STRAPS.items()
        for which, x in zip(("front", "back"), places, strict=True)
    }
    outlines = {"Ground": outline(0.955), "Welt": outline(0.985), "Bed": outline(1.0)}
    toe, heel = (
        board("y", float(outlines["Bed"][at][0, 1]), (290.0, 0.0, 60.0), np.array((0.0, 0.0, 12.0)))
        for at in (slice(0, 1), slice(400, 401))
    )
    bodies = [foot, *plans.values(), under, *ends.values(), toe, heel]
    hand = Hand("sandal", bodies, settings={"mirror": False, "controls": 14})
    draw_sole(hand, plans, outlines, (toe, heel))
    for name, places in STRAPS.items():
        draw_strap(hand, name, foot, places, ends, under)
    hand.only()
    paint(hand, foot, outlines["Bed"])
    return hand


def outline(share: float) -> Array:
    """The outline of the sole, so large as a share of the footbed, (801, 2); at 400 is the heel."""
    from scipy.interpolate import CubicSpline

    row = np.array((*OUTLINE, OUTLINE[0]))
    heel = 7
    at = np.concatenate((np.linspace(0.0, 1.0, heel + 1), np.linspace(1.0, 2.0, 15 - heel)[1:]))
    return share * np.asarray(CubicSpline(at, row, bc_type="periodic")(np.linspace(0.0, 2.0, 801)))


def draw_sole(
    hand: Hand, plans: dict[str, Board], outlines: dict[str, Array], sides: tuple[Board, Board]
) -> None:
    """Draw three outlines, and what joins them at the toe and at the heel."""
    heights = {"Ground": GROUND, "Welt": WELT, "Bed": BED}
    for name, z in heights.items():
        hand.only(plans[name])
        above = hand.view(-90.0, 90.0)
        ring = np.column_stack((outlines[name], np.full(801, z)))
        hand.draw(name, ring, above, edge="crease")
    hand.step(controls=4)
    # From between the sides: from the right alone an outline is seen end on there.
    for word, side, number, azimuth in (
        ("toe", sides[0], 0, -45.0),
        ("heel", sides[1], 400, -135.0),
    ):
        hand.only(side)
        for low, high in (("Ground", "Welt"), ("Welt", "Bed")):
            ends = [(*outlines[name][number], heights[name]) for name in (low, high)]
            near = hand.closer(hand.view(azimuth, 0.0), np.mean(ends, axis=0), 2.0)
            hand.draw(f"{high} {word}", between(*ends), near)


def draw_strap(
    hand: Hand,
    name: str,
    foot: Body,
    places: tuple[float, float],
    ends: dict[str, Board],
    plan: Board,
) -> None:
    """Draw the four arcs of a strap over the foot, and where its ends are tucked into the sole."""
    hand.step(controls=12)
    arcs: dict[tuple[str, str], Array] = {}
    for which, x in zip(("front", "back"), places, strict=True):
        hand.only(ends[f"{name} {which}"])
        ahead = hand.view(0.0, 0.0)
        for side, gap in SIDES.items():
            arc = arcs[which, side] = over_foot(foot, x, gap)
            hand.draw(f"{name} {which} {side}", arc, ahead, edge="crease")
        # What is narrow and bent to a U is two surfaces.
        hand.step(controls=4)
        tops = [highest(arcs[which, side]) for side in SIDES]
        tops[1] = np.array((x, tops[0][1], tops[1][2]))
        near = hand.closer(ahead, np.mean(tops, axis=0), 3.0)
        hand.draw(f"{name} {which} top", between(*tops), near)
        hand.step(controls=12)
    hand.step(controls=4)
    hand.only(plan)
    above = hand.view(-90.0, 90.0)
    for end, word in ((0, "right"), (-1, "left")):
        corner = {key: arc[end] for key, arc in arcs.items()}
        near = hand.closer(above, np.mean(list(corner.values()), axis=0), 2.5)
        for which in ("front", "back"):
            line = between(corner[which, "inside"], corner[which, "outside"])
            hand.draw(f"{name} {word} {which}", line, near, edge="crease")
        for side in SIDES:
            line = between(corner["front", side], corner["back", side])
            hand.draw(f"{name} {word} {side}", line, near, edge="crease")


def between(first: Array, last: Array) -> Array:
    """A straight line between two places, (60, 3)."""
    share = np.linspace(0.0, 1.0, 60)[:, None]
    return (1.0 - share) * np.asarray(first) + share * np.asarray(last)


def over_foot(foot: Body, x: float, gap: float) -> Array:
    """An arc across a foot, so far from it, from its right side over it to its left, (n, 3), mm.

    It goes straight down from where the foot is widest.
    """
    import shapely
    from scipy.ndimage import gaussian_filter1d

    from bozzetto_product.rough_shapes.shapes import rough_mesh

    mesh = rough_mesh(foot.shape)
    points = mesh.vertices.astype(float)
    edges = np.concatenate([mesh.faces[:, [k, (k + 1) % 3]] for k in range(3)])
    one, two = points[edges[:, 0]], points[edges[:, 1]]
    crossed = (one[:, 0] - x) * (two[:, 0] - x) < 0.0
    one, two = one[crossed], two[crossed]
    share = ((x - one[:, 0]) / (two[:, 0] - one[:, 0]))[:, None]
    section = ((1.0 - share) * one + share * two)[:, 1:]
    feet = [(end, TUCKED - 20.0) for end in (section[:, 0].min(), section[:, 0].max())]
    hull = shapely.MultiPoint(np.vstack((section, feet))).convex_hull.buffer(gap, quad_segs=32)
    ring = np.asarray(hull.exterior.segmentize(0.2).coords)[:-1]
    ring = np.roll(ring, -int(np.argmin(ring[:, 1])), axis=0)
    if ring[len(ring) // 4, 0] > 0.0:
        ring = ring[::-1]
    ring = np.stack([gaussian_filter1d(ring[:, k], 25.0, mode="wrap") for k in (0, 1)], axis=1)
    kept = ring[ring[:, 1] > TUCKED]
    first, last = kept[0].copy(), kept[-1].copy()
    first[1] = last[1] = TUCKED
    row = np.vstack((first, kept, last))
    return np.column_stack((np.full(len(row), x), row))[:: max(len(row) // 400, 1)]


def paint(hand: Hand, foot: Body, bed: Array) -> None:
    """Colour the surfaces."""
    hand.corners = np.column_stack((np.repeat(bed[::20], 2, 0), np.tile((0.0, 100.0), 41)))
    above, below = hand.view(-90.0, 90.0), hand.view(-90.0, -90.0)
    hand.paint(np.array((-90.0, 0.0, BED)), above, color=CORK, finish="matt")
    hand.paint(np.array((-90.0, 0.0, GROUND)), below, color=RUBBER, finish="rubber")
    for azimuth, number in ((90.0, 250), (-90.0, 550)):
        x, y = bed[number]
        for low, high, facts in (
            (WELT, BED, {"color": FOAM, "finish": "matt"}),
            (GROUND, WELT, {"color": RUBBER, "finish": "rubber"}),
        ):
            place = np.array((x, y, 0.5 * (low + high)))
            hand.paint(place, hand.view(azimuth, 0.0), **facts)
    for front, back in STRAPS.values():
        paint_strap(hand, foot, front, back)


def paint_strap(hand: Hand, foot: Body, front: float, back: float) -> None:
    """Colour the sides of a strap that are seen."""
    middle = 0.5 * (front + back)
    inside, outside = (over_foot(foot, middle, gap) for gap in SIDES.values())
    leather, suede = {"color": LEATHER, "finish": "gloss"}, {"color": SUEDE, "finish": "matt"}
    hand.paint(highest(outside), hand.view(-90.0, 90.0), **leather)
    hand.paint(highest(inside), hand.view(0.0, -10.0), **suede)
    for x, azimuth in ((front, 0.0), (back, 180.0)):
        arcs = [over_foot(foot, x, gap) for gap in SIDES.values()]
        for share in (0.42, 0.58):
            place = np.mean([arc[int(share * len(arc))] for arc in arcs], axis=0)
            hand.paint(place, hand.view(azimuth, 12.0), **suede)


def highest(arc: Array) -> Array:
    """The highest place of an arc, (3,)."""
    return np.asarray(arc[int(np.argmax(arc[:, 2]))])
