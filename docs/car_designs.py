"""Three cars of our own: nodes in places, and edges with tangents, that no template has.

`truth` gives the network of a car; nothing of it stands in the marks files of the gallery.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bozzetto.view import Camera
from bozzetto_car.chains import annealed
from bozzetto_car.default_shape import pulled_out
from bozzetto_car.edges import Network, edge_called, with_tangents
from bozzetto_car.template import Template

Array = NDArray[np.float64]
Point = tuple[float, float, float]

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
"""Right and middle nodes, mm."""


def placed(template: Template) -> Array:
    """All nodes of a design, (n, 3) mm."""
    found = []
    for name in template.names:
        half, _, side = name.partition(".")
        x, y, z = NODES[template.id][half]
        found.append((x, -y if side == "L" else y, z))
    return np.array(found, float)


def turned(network: Network) -> Network:
    """Tangents turned and stretched with the chords of their edges."""
    template = network.template
    old = np.diff(template.positions[template.edges], axis=1)[:, 0]
    new = np.diff(network.ends, axis=1)[:, 0]
    tangents = {}
    for edge, (a, b) in enumerate(zip(old, new, strict=True)):
        grown = np.linalg.norm(b) / np.linalg.norm(a)
        one, other = a / np.linalg.norm(a), b / np.linalg.norm(b)
        half = one + other
        for end in (0, 1):
            own = template.tangents[edge, end]
            half_turn = 2.0 * half * (half @ own) / (half @ half) - own  # about the half-way line
            flipped = 2.0 * other * (other @ half_turn) - half_turn
            tangents[edge, end] = grown * flipped
    return with_tangents(network, tangents)


def sped(network: Network) -> Network:
    """Chains with the directions of Catmull and Rom's spline at their smooth nodes.

    Its parameter runs with the chords (Barry and Goldman 1988), so that no edge bulges where a
    long one meets a short one.
    """
    tangents = {}
    for chain in network.template.chains:
        for node in chain.smooth:
            at = chain.nodes.index(node)
            ways = np.diff(network.positions[list(chain.nodes[at - 1 : at + 2])], axis=0)
            if ways[0, 1] * ways[1, 1] > 0.0 and node in network.template.centre:
                continue  # over the middle: across the car, as it is
            before, after = np.linalg.norm(ways, axis=1)
            speed = (ways[0] / before * after + ways[1] / after * before) / (before + after)
            for edge, end, length in (
                (chain.edges[at - 1], 1, before), (chain.edges[at], 0, after)
            ):  # fmt: skip
                own, sense = (edge, 1.0) if edge >= 0 else (~edge, -1.0)
                tangents[own, end if edge >= 0 else 1 - end] = sense * speed * length
    return with_tangents(network, tangents)


CORNERS: Mapping[str, Mapping[str, tuple[float, float, float, float, float]]] = {
    "sedan": {
        "S1": (0.75, 0.66, 0.05, 420, 700), "B1": (0.8, 0.6, 0.0, 420, 700),
        "S5": (-0.8, 0.6, -0.05, 300, 420), "B5": (-0.8, 0.6, 0.0, 420, 700),
    },
    "hatchback": {
        "S1": (0.75, 0.66, 0.05, 420, 650), "B1": (0.8, 0.6, 0.0, 420, 650),
        "S6": (-0.85, 0.5, 0.15, 300, 600), "B5": (-0.8, 0.6, 0.0, 420, 700),
    },
    "minivan": {
        "S1": (0.75, 0.66, 0.05, 420, 600), "B1": (0.8, 0.6, 0.0, 420, 700),
        "S6": (-0.85, 0.5, 0.1, 300, 800), "B5": (-0.8, 0.6, 0.0, 420, 700),
    },
}  # fmt: skip
"""Ways round the corners of nose and tail, from the middle outward, with the lengths of the tangents
of both edges there, mm: so that the body goes round its corners without a crease."""


def cornered(network: Network) -> Network:
    """The corners of nose and tail turned smoothly."""
    template = network.template
    tangents = {}
    for half, (x, y, z, inner, outer) in CORNERS[template.id].items():
        node = template.node[f"{half}.R"]
        way = np.array([x, y, z]) / np.linalg.norm([x, y, z])
        for edge, (start, end) in enumerate(template.edges.tolist()):
            if node not in (start, end):
                continue
            other = end if node == start else start
            if other in template.centre:
                tangents[edge, 1 if node == end else 0] = way * inner * (1 if node == end else -1)
            elif any(edge in (abs_edge(e) for e in chain.edges) for chain in template.chains):
                tangents[edge, 0 if node == start else 1] = (
                    way * outer * (1 if node == start else -1)
                )
    return with_tangents(network, tangents)


def abs_edge(edge): return max(edge, ~edge)
WAYS = {
    "sedan": {},
    "hatchback": {
        "S4": (1.0, 0.0, -0.10, 800, 700),
    },
    "minivan": {
        "C3": (1.0, 0.0, 0.30, 1100, 900), "C4": (1.0, 0.0, 0.0, 1000, 1700), "C5": (1.0, 0.0, -0.42, 900, 520),
        "R1": (1.0, -0.06, 0.28, 1050, 900), "R2": (1.0, 0.0, 0.01, 950, 1500), "R3": (1.0, 0.0, -0.42, 900, 520),
        "S4": (1.0, 0.0, -0.08, 1100, 700),
    },
}
def led(network: Network) -> Network:
    template = network.template
    tangents = {}
    for chain in template.chains:
        if chain.nodes[0] in template.centre or chain.name.endswith(".R"):
            for node in chain.smooth:
                half = template.names[node].partition(".")[0]
                if half in WAYS[template.id] and chain.nodes[1] != node or half in WAYS[template.id] and len(chain.nodes) > 3:
                    at = chain.nodes.index(node)
                    x, y, z, before, after = WAYS[template.id][half]
                    way = np.array([x, y, z]) / np.linalg.norm([x, y, z])
                    for edge, end, length in ((chain.edges[at - 1], 1, before), (chain.edges[at], 0, after)):
                        own, sense = (edge, 1.0) if edge >= 0 else (~edge, -1.0)
                        tangents[own, end if edge >= 0 else 1 - end] = sense * way * length
    return with_tangents(network, tangents)
SIZE = (1600, 1000)
FILLED = (0.77, 0.66)
VIEWS = {
    "sedan": ((40.0, 8.0, 8.0), (142.0, 13.0, 8.5)),
    "hatchback": ((-36.0, 11.0, 7.0),),
    "minivan": ((-90.0, 0.0, None), (47.0, 10.0, 9.5)),
}


def camera(car: Array, azimuth: float, elevation: float, away: float | None) -> Camera:
    turn, rise = np.radians((azimuth, elevation))
    toward = np.array([-np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    middle = 0.5 * (car.min(axis=0) + car.max(axis=0))
    kind = "perspective" if away else "orthographic"
    opening, height = 30.0, 4000.0
    for _ in range(8):
        eye = tuple((middle + 1000.0 * (away or 9.0) * toward).tolist())
        made = Camera(kind, eye, tuple(middle.tolist()), fov_y=opening, height=height, viewport=SIZE)
        places = made.project(car)[0]
        low, high = places.min(axis=0), places.max(axis=0)
        off = (0.5 * (low + high) - 0.5 * np.array(SIZE)) / made.pixels_per_mm
        middle = middle + off[0] * made.axes[0] - off[1] * made.axes[1]
        share = float(((high - low) / (FILLED * np.array(SIZE))).max())
        opening = 2.0 * np.degrees(np.arctan(np.tan(np.radians(0.5 * opening)) * share))
        height *= share
    return made


def truth(template: Template) -> tuple[Network, tuple[Camera, ...]]:
    network = cornered(led(sped(turned(Network.of(template, placed(template))))))
    network = pulled_out(network)
    return network, tuple(camera(network.positions, *view) for view in VIEWS[template.id])
