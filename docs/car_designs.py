"""Ten cars of our own: nodes in places, and edges with tangents, that no template has.

A wedge of a saloon whose roof runs down to a short tail, a tall round hatchback, and a long van
that is one box are laid out node by node; a long low coupé, a raked estate, a square SUV, a pickup
with a short cab, a short van with a bonnet, a bubble of a city car and a formal limousine by the
ways of their nodes from a template's.
`truth` gives the network of a car and the cameras of its drawings; nothing of it stands in the
marks files of the gallery, so that what is found from these can be judged by it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.view import Camera
from bozzetto_car.body.default_shape import pull_out_panels
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, edge_called, junctions, with_tangents

Array = NDArray[np.float64]
Point = tuple[float, float, float]
Way = tuple[Point, float, float]

SIZE: Final = (1600, 1000)
"""Of the drawings, px."""

FILLED: Final = (0.77, 0.66)
"""Shares of the width and of the height that a car takes up at most."""

VIEWS: Mapping[str, tuple[tuple[float, float, float], ...]] = {
    "sedan": ((40.0, 8.0, 8.0), (142.0, 13.0, 8.5)),
    "hatchback": ((-36.0, 11.0, 7.0),),
    "minivan": ((-90.0, 0.0, np.inf), (47.0, 10.0, 9.5)),
    "coupe": ((-42.0, 9.0, 7.5),),
    "estate": ((138.0, 14.0, 9.0),),
    "suv": ((38.0, 11.0, 8.0),),
    "pickup": ((-46.0, 12.0, 10.0),),
    "van": ((52.0, 9.0, 10.0),),
    "city_car": ((-40.0, 12.0, 6.5),),
    "limousine": ((36.0, 9.0, 10.5),),
}
"""From where cars are drawn: azimuth (0 looks at the nose, 90 at the right side) and elevation,
degrees, and distance, m; from infinity it is an orthographic drawing."""

PHOTOGRAPHED: Mapping[str, tuple[float, float, float]] = {
    "coupe": (34.0, 7.0, 6.5),
    "estate": (-44.0, 10.0, 8.5),
}
"""The same of the pictures that look like photographs, one a car."""

NODES: Mapping[str, Mapping[str, Point]] = {
    "sedan": {  # a wedge: low nose, long bonnet, the roof runs down to a short upswept tail
        "C0": (60, 0, 185), "C1": (85, 0, 640), "C2": (1380, 0, 905), "C3": (2180, 0, 1290),
        "C4": (2720, 0, 1335), "C5": (3300, 0, 1285), "C6": (4250, 0, 1060), "C7": (4690, 0, 1065),
        "C8": (4670, 0, 300),
        "S1": (430, 700, 655), "S2": (1480, 870, 895), "S3": (2650, 905, 925),
        "S4": (4000, 860, 1000), "S5": (4530, 690, 1020),
        "R1": (2240, 570, 1240), "R2": (2780, 585, 1288), "R3": (3330, 550, 1238),
        "B1": (330, 810, 200), "B2": (1290, 895, 175), "B3": (2500, 900, 172),
        "B4": (3330, 898, 182), "B5": (4440, 800, 325),
        "WF": (890, 805, 345), "WR": (3770, 820, 345),
    },
    "hatchback": {  # tall and round: short nose, high roof, a tail that leans forward
        "C0": (60, 0, 210), "C1": (75, 0, 780), "C2": (850, 0, 1060), "C3": (1520, 0, 1500),
        "C4": (2150, 0, 1560), "C5": (3240, 0, 1500), "C6": (3730, 0, 1090), "C7": (3900, 0, 700),
        "C8": (3870, 0, 300),
        "S1": (340, 650, 790), "S2": (980, 815, 1035), "S3": (2120, 870, 1010),
        "S4": (3060, 850, 1060), "S5": (3610, 610, 1090), "S6": (3750, 740, 710),
        "R1": (1580, 590, 1445), "R2": (2190, 620, 1512), "R3": (3140, 570, 1448),
        "B1": (280, 765, 220), "B2": (1150, 855, 200), "B3": (2080, 860, 200),
        "B4": (2890, 855, 205), "B5": (3730, 770, 310),
        "WF": (760, 775, 325), "WR": (3290, 785, 325),
    },
    "minivan": {  # one long box: the windscreen goes on where the bonnet ends
        "C0": (70, 0, 205), "C1": (90, 0, 790), "C2": (820, 0, 1075), "C3": (1850, 0, 1640),
        "C4": (2950, 0, 1705), "C5": (4880, 0, 1600), "C6": (5120, 0, 1130), "C7": (5230, 0, 760),
        "C8": (5200, 0, 310),
        "S1": (400, 760, 800), "S2": (1010, 905, 1060), "S3": (2520, 960, 1060),
        "S4": (4040, 950, 1120), "S5": (5020, 770, 1130), "S6": (5080, 870, 750),
        "R1": (1960, 690, 1570), "R2": (3000, 735, 1645), "R3": (4760, 690, 1545),
        "B1": (340, 870, 225), "B2": (1420, 950, 185), "B3": (2720, 955, 180),
        "B4": (3790, 948, 190), "B5": (5010, 870, 330),
        "WF": (1010, 860, 350), "WR": (4210, 875, 350),
    },
}  # fmt: skip
"""Nodes on the right and in the middle, mm."""

WAYS: Mapping[str, Mapping[str, Point]] = {
    "coupe": {  # lower and longer before the windscreen, the tail turned up
        "C0": (-20, 0, 5), "C1": (-35, 0, -35), "C2": (80, 0, -20), "C3": (95, 0, -35),
        "C4": (90, 0, -40), "C5": (140, 0, -30), "C6": (120, 0, 15), "C7": (45, 0, 55),
        "C8": (25, 0, 10),
        "S1": (-25, 5, -25), "S2": (80, 15, -12), "S3": (60, 18, -4), "S4": (70, 16, 20),
        "S5": (45, 5, 50), "R1": (95, -12, -35), "R2": (90, -14, -40), "R3": (130, -10, -28),
        "B1": (-15, 8, 0), "B2": (45, 15, -4), "B3": (30, 18, -4), "B4": (45, 16, 0),
        "B5": (35, 8, 15), "WF": (-25, 14, 8), "WR": (60, 18, 8),
    },
    "estate": {  # long and low, the tailgate lies down
        "C0": (0, 0, 5), "C1": (-15, 0, -30), "C2": (60, 0, -25), "C3": (90, 0, -45),
        "C4": (70, 0, -50), "C5": (-60, 0, -70), "C6": (70, 0, -5), "C7": (90, 0, 15),
        "C8": (85, 0, 10),
        "S1": (-10, 15, -25), "S2": (60, 25, -20), "S3": (40, 28, -12), "S4": (60, 24, 5),
        "S5": (70, 15, -5), "S6": (85, 18, 15), "R1": (90, -5, -45), "R2": (75, -8, -52),
        "R3": (-40, -10, -68), "B1": (0, 15, 0), "B2": (30, 25, -6), "B3": (30, 28, -6),
        "B4": (60, 25, -4), "B5": (75, 18, 10), "WF": (0, 20, 10), "WR": (90, 24, 10),
    },
    "suv": {  # square: upright at both ends, flat on top
        "C0": (15, 0, 15), "C1": (-10, 0, 45), "C2": (-20, 0, 55), "C3": (-70, 0, 50),
        "C4": (-40, 0, 25), "C5": (130, 0, 60), "C6": (25, 0, 40), "C7": (10, 0, 25),
        "C8": (15, 0, 10),
        "S1": (-40, 30, 45), "S2": (-20, 25, 50), "S3": (0, 25, 40), "S4": (40, 28, 40),
        "S5": (20, 45, 35), "S6": (10, 35, 25), "R1": (-65, 25, 55), "R2": (-30, 25, 35),
        "R3": (125, 35, 60), "B1": (-20, 22, 10), "B2": (0, 25, 5), "B3": (0, 25, 5),
        "B4": (20, 25, 5), "B5": (15, 28, 10), "WF": (-10, 24, 14), "WR": (20, 26, 14),
    },
    "pickup": {  # a short cab far forward, a long bed
        "C0": (0, 0, -20), "C1": (10, 0, -40), "C2": (-60, 0, -25), "C3": (-110, 0, -50),
        "C4": (-150, 0, -65), "C5": (-190, 0, -60), "C6": (-160, 0, -40), "C7": (60, 0, -35),
        "C8": (60, 0, -25),
        "S1": (10, 10, -35), "S2": (-60, 14, -30), "S3": (-110, 16, -30), "S4": (-150, 18, -30),
        "S5": (60, 12, -35), "R1": (-110, 0, -52), "R2": (-150, -5, -64), "R3": (-190, -5, -58),
        "B1": (0, 12, -20), "B2": (-30, 14, -25), "B3": (-90, 16, -25), "B4": (-110, 16, -25),
        "B5": (60, 14, -25), "WF": (-20, 16, 0), "WR": (40, 18, 0),
    },
    "van": {  # shorter, with a bonnet before the windscreen
        "C0": (0, 0, 5), "C1": (-25, 0, 15), "C2": (90, 0, 10), "C3": (150, 0, -60),
        "C4": (-60, 0, -90), "C5": (-420, 0, -70), "C6": (-400, 0, -30), "C7": (-380, 0, 0),
        "C8": (-380, 0, 5),
        "S1": (-5, 10, 10), "S2": (90, 18, 10), "S3": (40, 20, 5), "S4": (-250, 18, 5),
        "S5": (-390, 10, -25), "S6": (-380, 14, 0), "R1": (150, -10, -60), "R2": (90, -12, -85),
        "R3": (-400, -8, -70), "B1": (0, 12, 5), "B2": (30, 18, 0), "B3": (0, 20, 0),
        "B4": (-190, 18, 0), "B5": (-370, 14, 5), "WF": (0, 16, 6), "WR": (-240, 18, 6),
    },
    "city_car": {  # a bubble: the nose short and high, the roof round, the tail upright
        "C0": (10, 0, 10), "C1": (5, 0, 35), "C2": (-50, 0, 40), "C3": (-60, 0, 45),
        "C4": (-30, 0, 60), "C5": (35, 0, 20), "C6": (45, 0, -15), "C7": (30, 0, 0),
        "C8": (25, 0, 5),
        "S1": (0, 22, 30), "S2": (-50, 26, 35), "S3": (0, 30, 20), "S4": (35, 26, -5),
        "S5": (40, 22, -15), "S6": (30, 20, 0), "R1": (-60, 14, 42), "R2": (-30, 18, 55),
        "R3": (35, 12, 22), "B1": (5, 20, 5), "B2": (-20, 26, 0), "B3": (0, 28, 0),
        "B4": (20, 26, 0), "B5": (25, 20, 10), "WF": (-15, 22, 10), "WR": (20, 22, 10),
    },
    "limousine": {  # low and formal: a longer bonnet, an upright rear window, a flat tail
        "C0": (-30, 0, -5), "C1": (-45, 0, -20), "C2": (70, 0, -15), "C3": (60, 0, -25),
        "C4": (40, 0, -15), "C5": (90, 0, 10), "C6": (20, 0, 15), "C7": (60, 0, 5),
        "C8": (45, 0, 0),
        "S1": (-30, 15, -15), "S2": (70, 22, -10), "S3": (40, 25, -5), "S4": (20, 24, 10),
        "S5": (55, 15, 5), "R1": (60, 8, -25), "R2": (40, 10, -15), "R3": (85, 8, 10),
        "B1": (-20, 15, 0), "B2": (30, 22, -5), "B3": (30, 25, -5), "B4": (40, 22, -5),
        "B5": (50, 15, 5), "WF": (-15, 20, 6), "WR": (55, 22, 6),
    },
}  # fmt: skip
"""Ways of nodes from those of the template, mm."""

LIKE: Mapping[str, str] = {
    "coupe": "sedan",
    "estate": "hatchback",
    "suv": "hatchback",
    "pickup": "sedan",
    "van": "minivan",
    "city_car": "hatchback",
    "limousine": "sedan",
}
"""Cars whose corners, lamps and gaps are those of another one."""

JOINTS: Mapping[str, Mapping[str, Way]] = {
    "sedan": {},
    "hatchback": {"S4": ((1.0, 0.0, -0.10), 800, 700)},
    "minivan": {
        "C3": ((1.0, 0.0, 0.30), 1100, 900), "R1": ((1.0, -0.06, 0.28), 1050, 900),
        "C4": ((1.0, 0.0, 0.0), 1000, 1700), "R2": ((1.0, 0.0, 0.01), 950, 1500),
        "C5": ((1.0, 0.0, -0.42), 900, 520), "R3": ((1.0, 0.0, -0.42), 900, 520),
        "S4": ((1.0, 0.0, -0.08), 1100, 700),
    },
    "suv": {  # the roof runs on level and bends down at its end alone
        "C3": ((1.0, 0.0, 0.21), 610, 690), "R1": ((1.0, 0.02, 0.20), 590, 615),
        "C4": ((1.0, 0.0, 0.0), 650, 1240), "R2": ((1.0, -0.01, 0.0), 615, 1140),
        "C5": ((1.0, 0.0, -0.16), 1260, 640), "R3": ((1.0, -0.03, -0.16), 1180, 640),
        "S4": ((1.0, -0.06, 0.02), 1200, 725),
    },
    "estate": {  # as that of the SUV, and so are the next three
        "C4": ((1.0, 0.0, 0.0), 600, 1560), "R2": ((1.0, 0.0, 0.0), 605, 1410),
        "C5": ((1.0, 0.0, -0.18), 1560, 560), "R3": ((1.0, -0.05, -0.18), 1410, 560),
    },
    "pickup": {
        "C4": ((1.0, 0.0, 0.0), 540, 710), "R2": ((1.0, 0.0, 0.0), 500, 660),
        "C5": ((1.0, 0.0, -0.30), 710, 500), "R3": ((1.0, -0.06, -0.30), 660, 500),
    },
    "city_car": {
        "C4": ((1.0, 0.0, 0.0), 610, 1220), "R2": ((1.0, 0.0, 0.0), 580, 1085),
        "C5": ((1.0, 0.0, -0.25), 1220, 560), "R3": ((1.0, -0.06, -0.25), 1085, 560),
    },
    "limousine": {
        "C4": ((1.0, 0.0, 0.0), 730, 965), "R2": ((1.0, 0.0, 0.0), 735, 905),
        "C5": ((1.0, 0.0, -0.13), 965, 730), "R3": ((1.0, -0.07, -0.14), 905, 730),
    },
    "van": {
        "C4": ((1.0, 0.0, 0.0), 880, 2400), "R2": ((1.0, 0.02, 0.0), 560, 2000),
        "C5": ((1.0, 0.0, -0.35), 1080, 510), "R3": ((1.0, -0.03, -0.25), 1110, 540),
        "S4": ((1.0, -0.02, 0.014), 1700, 850),
    },
}  # fmt: skip
"""Directions of chains at some nodes, and the lengths of the tangents before and after, mm."""

CORNERS: Mapping[str, Mapping[str, tuple[Point, Point]]] = {
    "sedan": {
        "S1": ((230, 350, 20), (640, 265, 55)), "B1": ((240, 340, 0), (640, 250, 0)),
        "S5": ((-140, 265, -10), (-400, 125, -20)), "B5": ((-220, 360, 0), (-650, 230, 0)),
    },
    "hatchback": {
        "S1": ((230, 350, 20), (600, 240, 60)), "B1": ((240, 340, 0), (600, 230, 0)),
        "S6": ((-150, 260, 20), (-560, 180, 120)), "B5": ((-220, 360, 0), (-650, 230, 0)),
    },
    "minivan": {
        "S1": ((230, 350, 20), (550, 230, 55)), "B1": ((240, 340, 0), (650, 240, 0)),
        "S6": ((-140, 265, 15), (-760, 210, 110)), "B5": ((-220, 360, 0), (-660, 220, 0)),
    },
}  # fmt: skip
"""Ways outward at the corners of nose and tail, mm: tangents of the edge from the middle, and of
the one along the side. The body goes round its corners softer than the templates do, though not
quite smoothly: with both ways in one direction a patch would have no corner."""

SCREENS: Mapping[str, Mapping[str, tuple[int, Point]]] = {
    "sedan": {},
    "hatchback": {},
    "minivan": {
        "C5-C6": (1, (60.548, 0.0, -572.995)),
        "S5.R-R3.R": (0, (-223.484, -109.38, 574.998)),
    },
}
"""Tangents at the foot of the rear window, mm, at the start (0) or the end (1) of an edge: it
bulges more than that of the template."""


def truth(template: Template) -> tuple[Network, tuple[Camera, ...]]:
    """The car that was drawn on a template's topology, and the cameras it was drawn through."""
    network = turned(Network.of(template, placed(template)))
    feet = SCREENS.get(template.id, {}).items()
    network = with_tangents(
        network, {(edge_called(template, edge), end): way for edge, (end, way) in feet}
    )
    network = pull_out_panels(cornered(streamlined(network)))
    return network, tuple(camera(network.positions, *view) for view in VIEWS[template.id])


def photographed(template: Template) -> tuple[Network, Camera]:
    """The car of a picture that looks like a photograph, and its camera."""
    network, _ = truth(template)
    return network, camera(network.positions, *PHOTOGRAPHED[template.id])


def kind_of(template: Template) -> str:
    """Whose corners, lamps and gaps a car on this template has."""
    return LIKE.get(template.id, template.id)


# -- shape -----------------------------------------------------------------------------------------


def placed(template: Template) -> Array:
    """All nodes of a design, (n, 3) mm."""
    found = []
    for name in template.names:
        half, _, side = name.partition(".")
        if template.id in NODES:
            x, y, z = NODES[template.id][half]
        else:
            own = template.positions[template.node[half if half in template.node else f"{half}.R"]]
            x, y, z = (own + WAYS[template.id].get(half, (0.0, 0.0, 0.0))).tolist()
        found.append((x, -y if side == "L" else y, z))
    return np.array(found, float)


def turned(network: Network) -> Network:
    """Tangents of the template turned and stretched with the chords of their edges."""
    template = network.template
    old = np.diff(template.positions[template.edges], axis=1)[:, 0]
    new = np.diff(network.ends, axis=1)[:, 0]
    tangents = {}
    for edge, (before, after) in enumerate(zip(old, new, strict=True)):
        sizes = np.linalg.norm(before), np.linalg.norm(after)
        to = after / sizes[1]
        half = before / sizes[0] + to
        for end in (0, 1):
            # Two half-turns, about the half-way line and the new chord, make the turn from the
            # old chord to the new one.
            own = template.tangents[edge, end]
            over = 2.0 * half * (half @ own) / (half @ half) - own
            tangents[edge, end] = sizes[1] / sizes[0] * (2.0 * to * (to @ over) - over)
    return with_tangents(network, tangents)


def streamlined(network: Network) -> Network:
    """Chains smooth at their nodes: as `JOINTS` has it, or with Catmull and Rom's directions.

    The parameter of their spline runs with the chords (Barry and Goldman 1988), so that no edge
    bulges where a long one meets a short one.
    """
    template = network.template
    tangents = {}
    for joint in junctions(template):
        half, _, side = template.names[joint.node].partition(".")
        if joint.crosses or side == "L":
            continue
        if half in JOINTS.get(template.id, {}):
            way, *lengths = JOINTS[template.id][half]
            speed = np.array(way) / np.linalg.norm(way)
        else:
            back, ahead = joint.neighbours
            ways = np.diff(network.positions[[back, joint.node, ahead]], axis=0)
            lengths = np.linalg.norm(ways, axis=1).tolist()
            speed = ways[0] / lengths[0] * lengths[1] + ways[1] / lengths[1] * lengths[0]
            speed /= sum(lengths)
        for end, sense, length in zip(
            (joint.before, joint.after), joint.senses, lengths, strict=True
        ):
            tangents[end] = sense * length * speed
    return with_tangents(network, tangents)


def cornered(network: Network) -> Network:
    """The corners of nose and tail as `CORNERS` has them."""
    template = network.template
    chained = {max(edge, ~edge) for chain in template.chains for edge in chain.edges}
    tangents = {}
    for half, (inner, outer) in CORNERS[kind_of(template)].items():
        node = template.node[f"{half}.R"]
        for edge in chained:
            start, end = template.edges[edge]
            if node not in (start, end):
                continue
            arrives = node == end
            inside = (start if arrives else end) in template.centre
            # Outward is along an edge that comes from the middle, and away from the corner.
            sense = 1.0 if arrives == inside else -1.0
            tangents[edge, int(arrives)] = sense * np.array(inner if inside else outer, float)
    return with_tangents(network, tangents)


# -- views -----------------------------------------------------------------------------------------


def camera(car: Array, azimuth: float, elevation: float, away: float) -> Camera:
    """A camera with the nodes of a car (n, 3) in the middle of its picture."""
    turn, rise = np.radians((azimuth, elevation))
    toward = np.array([-np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    middle = 0.5 * (car.min(axis=0) + car.max(axis=0))
    flat = not np.isfinite(away)
    opening, height = 30.0, 4000.0
    for _ in range(8):
        made = Camera(
            "orthographic" if flat else "perspective",
            eye=tuple((middle + 1000.0 * (9.0 if flat else away) * toward).tolist()),
            target=tuple(middle.tolist()),
            fov_y=opening,
            height=height,
            viewport=SIZE,
        )
        places = made.project(car)[0]
        low, high = places.min(axis=0), places.max(axis=0)
        off = (0.5 * (low + high) - 0.5 * np.array(SIZE)) / made.pixels_per_mm
        middle = middle + off[0] * made.axes[0] - off[1] * made.axes[1]
        share = float(((high - low) / (FILLED * np.array(SIZE))).max())
        opening = 2.0 * np.degrees(np.arctan(np.tan(np.radians(0.5 * opening)) * share))
        height *= share
    return made
