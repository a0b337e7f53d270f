"""What the drawn cars have and no template knows: glass, doors, lamps, grille, mirrors, wheels.

Lines are given by places near the body, seen from the side (x, z) or ahead (y, z), and laid on it.
They are made for the right side; `both` adds the left one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
from car_designs import NODES, kind_of
from car_seen import TYRE, Car, Line, circle
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline
from shapely import LineString, Polygon

from bozzetto.geometry.patches.patch import grid

Array = NDArray[np.float64]

INWARD = np.array([0.0, -1.0, 0.0])
"""From the right onto the car; ahead and aslant likewise."""

AHEAD = np.array([1.0, 0.0, 0.0])
ASLANT = np.array([1.0, -1.0, 0.0])

FRAME = 46.0
"""Width of the frame round the side windows, mm."""

PILLAR = 62.0
"""Width of the pillar between the doors, mm."""

SPOKES = 5
"""Pairs of spokes of a wheel."""


def both(lines: Iterable[Line]) -> list[Line]:
    """Lines and their mirror images."""
    own = list(lines)
    return own + [Line(line.points * (1, -1, 1), line.role, line.on_body) for line in own]


def curve(points: ArrayLike, count: int = 160, closed: bool = False) -> Array:
    """A smooth line through places in any number of dimensions."""
    points = np.asarray(points, float)
    if closed:
        points = np.vstack((points, points[:1]))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = np.concatenate(([0.0], np.cumsum(np.sqrt(steps))))
    spline = CubicSpline(at, points, bc_type="periodic" if closed else "natural")
    return np.asarray(spline(np.linspace(0.0, at[-1], count)))


def polygon(points: ArrayLike, count: int = 160) -> Array:
    """A closed line with straight sides, evenly sampled."""
    points = np.asarray(points, float)
    points = np.vstack((points, points[:1]))
    at = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    even = np.linspace(0.0, at[-1], count)
    return np.column_stack([np.interp(even, at, points[:, k]) for k in range(points.shape[1])])


def from_side(car: Car, flat: Array) -> Array:
    """A line (k, 2) of x, z laid on the right side."""
    return car.laid(np.insert(flat, 1, 900.0, axis=1), INWARD)


def from_ahead(car: Car, flat: Array) -> Array:
    """A line (k, 2) of y, z laid on the nose."""
    return car.laid(np.insert(flat, 0, 0.0, axis=1), AHEAD)


def from_behind(car: Car, flat: Array) -> Array:
    """A line (k, 2) of y, z laid on the tail."""
    return car.laid(np.insert(flat, 0, 5000.0, axis=1), -AHEAD)


def at_corner(car: Car, node: str, flat: Array, rear: bool) -> Array:
    """A line of (way round the corner, height) from a node, laid on a corner of the body."""
    along = np.array([-1.0 if rear else 1.0, 1.0, 0.0]) / np.sqrt(2.0)
    way = ASLANT * (-1.0, 1.0, 1.0) if rear else ASLANT
    points = car.node(node) + flat[:, :1] * along + flat[:, 1:] * (0.0, 0.0, 1.0)
    return car.laid(points, way)


# -- glass -----------------------------------------------------------------------------------------


def edge_points(car: Car, *names: str) -> Array:
    """Edges in a row, (k, 3) mm."""
    template = car.network.template
    at = np.linspace(0.0, 1.0, 40)[:, None]
    found = []
    for start, end in pairwise(names):
        edge = template.edge_between[template.node[start], template.node[end]]
        a, b, c, d = car.network.control_points[max(edge, ~edge)]
        line = (1 - at) ** 3 * a + 3 * (1 - at) ** 2 * at * b + 3 * (1 - at) * at**2 * c + at**3 * d
        found.append(line if edge >= 0 else line[::-1])
    return np.concatenate(found)


def side_windows(car: Car) -> list[Array]:
    """Outlines of the side windows, (k, 2) of x and z."""
    upper = edge_points(car, "S2.R", "R1.R", "R2.R", "R3.R", "S4.R")
    lower = edge_points(car, "S4.R", "S3.R", "S2.R")
    around = Polygon(np.concatenate((upper, lower))[:, [0, 2]]).buffer(0.0)
    glass = around.buffer(-FRAME - 34.0).buffer(34.0)
    top, foot = car.node("R2.R")[[0, 2]], car.node("S3.R")[[0, 2]]
    beyond = top - foot
    pillar = LineString([foot - beyond, top + beyond]).buffer(0.5 * PILLAR)
    panes = glass.difference(pillar)
    return [
        np.array(pane.buffer(-12.0).buffer(12.0).exterior.coords)
        for pane in getattr(panes, "geoms", [panes])
        if pane.area > 2e4
    ]


def glass_lines(car: Car) -> Iterator[Line]:
    """Panes of the side, their common frame, and a second line within the screens' borders."""
    for pane in side_windows(car):
        yield Line(from_side(car, polygon(pane, 260)), "glass")
    upper = edge_points(car, "S2.R", "R1.R", "R2.R", "R3.R", "S4.R")[:, [0, 2]]
    lower = edge_points(car, "S4.R", "S3.R", "S2.R")[:, [0, 2]]
    around = Polygon(np.concatenate((upper, lower))).buffer(0.0).buffer(-50.0).buffer(28.0)
    yield Line(from_side(car, polygon(around.exterior.coords, 300)), "fine")
    names = car.body.patch_names
    inner = np.linspace(0.03, 0.95, 60)
    for word, near in (("windscreen", 0.93), ("backlight", 0.9), ("tailgate_glass", 0.88)):
        if f"{word}.R" in names:
            net = car.body.nets[[names.index(f"{word}.R")]]
            yield Line(grid(net, inner, np.array([near]))[0, :, 0], "fine")
            for end in (0.04, 0.95):
                yield Line(grid(net, np.array([end]), np.linspace(0, near, 60))[0, 0], "fine")


# -- doors -----------------------------------------------------------------------------------------


def door_lines(car: Car) -> Iterator[Line]:
    """Gaps round the doors, the rear one going round the wheel arch, and their handles."""
    foot, waist, sill = car.node("S2.R"), car.node("S3.R"), car.node("B3.R")
    rear = car.wheels[2]
    low = sill[2] + 62.0
    ahead, gap = foot[0] + 75.0, car.arch(rear) + 55.0
    front = [(ahead + 20, foot[2] - 25), (ahead - 30, 0.55 * foot[2] + 90), (ahead - 8, low + 130)]
    front += [(ahead + 60, low + 20), (ahead + 170, low), (sill[0] - 60, low)]
    yield Line(from_side(car, curve(front, 220)), "cut")
    middle = [(waist[0] + 12, waist[2] - 12), (waist[0], 0.6 * waist[2] + 60)]
    yield Line(from_side(car, curve([*middle, (sill[0] + 30, low)])), "cut")
    turn = np.radians([172.0, 150.0, 128.0])
    round_arch = [(rear[0] + gap * np.cos(t), rear[2] + gap * np.sin(t)) for t in turn]
    close = min(rear[0] - 40.0, car.node("S4.R")[0] - 30.0)
    back = [(sill[0] + 60, low), (rear[0] - gap - 90, low), *round_arch]
    back += [(close + 10, 0.5 * (round_arch[-1][1] + car.node("S4.R")[2]) + 60)]
    back += [(close + 30, car.node("S4.R")[2] - 20)]
    yield Line(from_side(car, curve(back, 240)), "cut")
    for x in (waist[0] - 150.0, close - 150.0):
        turn = np.linspace(0.0, 2.0 * np.pi, 40)
        z = waist[2] - 56.0 + 0.02 * (x - waist[0])
        handle = np.column_stack((x + 88 * np.cos(turn), z + 15 * np.sin(turn)))
        yield Line(from_side(car, handle), "part")


MIRROR_SHAPE = [(-70, -62), (60, -58), (128, -30), (150, 20), (120, 62), (0, 66), (-60, 34)]
"""Outline of an outside mirror: outward and up, mm."""


def mirrors(car: Car, toward: Array) -> list[Array]:
    """Outlines of the outside mirrors, as a camera in that direction sees them."""
    across = np.cross((0.0, 0.0, 1.0), toward)
    across /= np.linalg.norm(across)
    foot = car.node("S2.R") + np.array([260.0, 70.0, 112.0])
    shape = curve(MIRROR_SHAPE, 80, closed=True)
    found = []
    for side in (1.0, -1.0):
        out = np.sign(across[1]) * side
        found.append(
            foot * (1.0, side, 1.0)
            + shape[:, :1] * out * across
            + shape[:, 1:] * np.array([0.0, 0.0, 1.0])
        )
    return found


# -- nose and tail ---------------------------------------------------------------------------------

HEADLAMPS = {
    "sedan": [(-340, -30), (-150, -18), (70, -10), (400, 34), (290, -62), (30, -112), (-190, -108)],
    "hatchback": [(-120, -62), (10, -46), (125, -74), (160, -155), (90, -232), (-60, -236),
                  (-152, -160)],
    "minivan": [(-260, -45), (-90, -30), (110, 0), (330, 75), (260, -90), (60, -170), (-170, -150)],
}  # fmt: skip
"""Outlines: way round the corner and height, mm, from the bonnet's corner."""

TAIL_LAMPS = {
    "sedan": ("S5.R", [(-260, -40), (-60, -30), (230, -20), (280, -60), (60, -110), (-250, -95)]),
    "hatchback": ("S6.R", [(-60, 215), (60, 175), (130, 60), (70, -40), (-80, -50), (-90, 90)]),
    "minivan": ("S6.R", [(-60, 330), (40, 300), (90, 120), (70, -20), (-90, -30), (-80, 150)]),
}
"""The node from which a lamp is laid out, and its outline likewise."""

GRILLES = {
    "sedan": [(0, 580), (310, 572), (400, 515), (310, 430), (0, 420)],
    "hatchback": [(0, 600), (300, 610), (355, 575), (290, 530), (0, 520)],
    "minivan": [(0, 690), (330, 700), (390, 640), (300, 560), (0, 545)],
}
"""Right halves, y and z, mm; the intake below likewise."""

INTAKES = {
    "sedan": [(0, 365), (420, 370), (520, 330), (420, 265), (0, 255)],
    "hatchback": [(0, 420), (380, 425), (440, 360), (350, 300), (0, 290)],
    "minivan": [(0, 430), (430, 440), (520, 370), (400, 300), (0, 290)],
}


def whole(half: list[tuple[float, float]]) -> Array:
    """A closed outline from its right half."""
    right = np.array(half, float)
    left = right[::-1] * (-1.0, 1.0)
    return np.concatenate((right, left[1:-1] if right[0, 0] == 0 else left))


def lamp_lines(car: Car) -> Iterator[Line]:
    """The right headlamp and tail lamp, with what is inside them."""
    kind = kind_of(car.network.template)
    lamp = np.array(HEADLAMPS[kind], float)
    outline = curve(lamp, 120, closed=True) if kind == "hatchback" else polygon(lamp, 120)
    yield Line(at_corner(car, "S1.R", outline, rear=False), "lamp")
    inner = outline.mean(axis=0) + 0.72 * (outline - outline.mean(axis=0))
    yield Line(at_corner(car, "S1.R", inner, rear=False), "fine")
    eye = np.linspace(0.0, 2.0 * np.pi, 50)
    size = 34.0 if kind == "sedan" else 58.0
    ring = lamp.mean(axis=0) + size * np.column_stack((np.cos(eye), np.sin(eye)))
    yield Line(at_corner(car, "S1.R", ring, rear=False), "part")
    node, tail = TAIL_LAMPS[kind]
    yield Line(at_corner(car, node, polygon(tail, 120), rear=True), "lamp")
    part = np.array(tail, float)
    part = part.mean(axis=0) + 0.7 * (part - part.mean(axis=0))
    yield Line(at_corner(car, node, polygon(part, 120), rear=True), "fine")


def front_lines(car: Car) -> Iterator[Line]:
    """Grille and intake with their bars, and a lip below; both sides."""
    kind = kind_of(car.network.template)
    above = car.node("C1")[2] - NODES[kind]["C1"][2]
    for half in (GRILLES[kind], INTAKES[kind]):
        outline = whole(half) + np.array([0.0, above])
        yield Line(from_ahead(car, polygon(outline, 260)), "lamp")
        low, high = outline[:, 1].min(), outline[:, 1].max()
        for z in np.linspace(low, high, 6)[1:-1]:
            reach = LineString([(-900, z), (900, z)]).intersection(Polygon(outline)).bounds
            bar = np.column_stack((np.linspace(reach[0] + 12, reach[2] - 12, 60), np.full(60, z)))
            yield Line(from_ahead(car, bar), "fine")
    lip = car.node("C0")[2] + 42.0
    y = np.linspace(-640.0, 640.0, 140)
    yield Line(from_ahead(car, np.column_stack((y, lip + 30.0 * (y / 640.0) ** 2))), "fine")


def rear_lines(car: Car) -> Iterator[Line]:
    """Number plate, bumper, and the boot's gap; both sides."""
    kind = kind_of(car.network.template)
    top = car.node("C7")[2]
    plate = top - (300.0 if kind == "sedan" else 60.0)
    corners = [(-260, plate), (260, plate), (260, plate - 112), (-260, plate - 112)]
    yield Line(from_behind(car, polygon(corners, 200)), "part")
    low = car.node("C8")[2] + 130.0
    y = np.linspace(-680.0, 680.0, 140)
    yield Line(from_behind(car, np.column_stack((y, low + 40.0 * (y / 680.0) ** 2))), "fine")
    if kind == "sedan":
        lid = [(-500, top - 40), (-440, top - 330), (0, top - 370), (440, top - 330)]
        yield Line(from_behind(car, curve([*lid, (500, top - 40)], 200)), "cut")


# -- styling lines ---------------------------------------------------------------------------------


def styling(car: Car) -> dict[str, Array]:
    """Lines that a designer draws on the right side of the body, by name, (k, 3) mm."""
    foot, waist = car.node("S2.R"), car.node("S3.R")
    front, rear = car.wheels[0], car.wheels[2]
    tail = car.node("S5.R" if kind_of(car.network.template) == "sedan" else "S6.R")
    start = front[0] + car.arch(front) + 20.0
    fall = [(tail[0] - 120, min(waist[2] - 70, tail[2] + 40)), (rear[0], waist[2] - 95)]
    fall += [(waist[0], waist[2] - 165), (start, 0.62 * foot[2] + 120)]
    gap = car.arch(rear) + 30.0
    sill = car.node("B3.R")[2]
    rocker = [(start - 5, sill + 175), (0.5 * (start + rear[0] - gap), sill + 128)]
    rocker += [(rear[0] - gap - 120, sill + 190), (rear[0] - gap + 8, sill + 320)]
    nose, cowl = car.node("S1.R"), car.node("C2")
    bonnet = [(cowl[0] + 20, 0.66 * foot[1]), (0.5 * (cowl[0] + nose[0]), 0.6 * foot[1])]
    bonnet += [(nose[0] - 90, 0.60 * nose[1])]
    above = np.column_stack((curve(bonnet), np.full(160, 1200.0)))
    return {
        "falling line": from_side(car, curve(fall)),
        "rocker": from_side(car, curve(rocker)),
        "bonnet line": car.laid(above, (0.0, 0.0, -1.0)),
    }


# -- wheels ----------------------------------------------------------------------------------------


def spokes(wheel: Array) -> list[Array]:
    """Outlines of a rim's spokes, (k, 3) mm each."""
    radius, side = float(wheel[2]), np.sign(wheel[1])
    share = np.linspace(0.0, 1.0, 30)
    found = []
    for spoke in range(SPOKES):
        for lean in (-1.0, 1.0):  # twin spokes
            middle = 2.0 * np.pi * spoke / SPOKES + 0.5 + lean * (0.10 + 0.16 * share)
            edges = []
            for half in (-1.0, 1.0):
                turn = middle + half * (0.30 - 0.22 * share)
                reach = radius * (0.15 + 0.535 * share)
                out = wheel[1] + side * (12.0 + (TYRE - 30.0) * share)
                x, z = wheel[0] + reach * np.cos(turn), wheel[2] + reach * np.sin(turn)
                edges.append(np.column_stack((x, out, z)))
            found.append(np.concatenate((edges[0], edges[1][::-1])))
    return found


def wheel_lines(wheel: Array) -> Iterator[Line]:
    """A wheel, from the tread to the hub; the hub is the wheel's centre."""
    radius = float(wheel[2])
    yield Line(circle(wheel, radius - 1.0, TYRE - 12.0), "tyre", False)
    yield Line(circle(wheel, 0.93 * radius, TYRE), "fine", False)
    yield Line(circle(wheel, 0.735 * radius, TYRE - 4.0), "rim", False)
    yield Line(circle(wheel, 0.69 * radius, TYRE - 20.0), "fine", False)
    yield Line(circle(wheel, 0.13 * radius, 12.0), "part", False)
    yield Line(circle(wheel, 0.04 * radius, 0.0), "fine", False)
    for outline in spokes(wheel):
        yield Line(outline[:30], "fine", False)
        yield Line(outline[30:], "fine", False)


def arch_lines(car: Car) -> Iterator[Line]:
    """Wheel arches of the right side, each with a lip."""
    for wheel in car.wheels[[0, 2]]:
        for radius, role in ((car.arch(wheel) + 1.0, "arch"), (car.arch(wheel) + 17.0, "fine")):
            turn = np.linspace(-0.35, np.pi + 0.35, 200)
            flat = np.column_stack(
                (wheel[0] + radius * np.cos(turn), wheel[2] + radius * np.sin(turn))
            )
            yield Line(from_side(car, flat), role)
