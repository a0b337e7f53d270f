"""A car's body as a network of edges: 28 patches over 35 nodes, open below with a rim of 12."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

CENTRE = {
    "C0": (80, 0, 200), "C1": (100, 0, 740), "C2": (1220, 0, 990), "C3": (2000, 0, 1400),
    "C4": (2600, 0, 1460), "C5": (3250, 0, 1400), "C6": (4000, 0, 1100), "C7": (4620, 0, 1050),
    "C8": (4600, 0, 270),
}  # fmt: skip
RIGHT = {
    "S1": (300, 720, 710), "S2": (1300, 770, 970), "S3": (2550, 840, 950), "S4": (3880, 740, 1060),
    "S5": (4520, 680, 990), "R1": (2030, 560, 1360), "R2": (2650, 590, 1420),
    "R3": (3270, 550, 1360), "B1": (300, 780, 200), "B2": (1350, 880, 200), "B3": (2500, 900, 200),
    "B4": (3220, 880, 210), "B5": (4460, 780, 280),
}  # fmt: skip
NODES = CENTRE | {f"{n}.{s}": (x, y if s == "R" else -y, z)
                  for n, (x, y, z) in RIGHT.items() for s in "RL"}  # fmt: skip
QUADS = {
    "front_fascia": "C0 C1 S1 B1", "hood": "C1 C2 S2 S1", "windscreen": "C2 C3 R1 S2",
    "roof_front": "C3 C4 R2 R1", "roof_rear": "C4 C5 R3 R2", "backlight": "C5 C6 S4 R3",
    "deck": "C6 C7 S5 S4", "rear_fascia": "C7 C8 B5 S5", "glass_front": "S2 R1 R2 S3",
    "glass_rear": "S3 R2 R3 S4", "fender": "S1 S2 B2 B1", "door_front": "S2 S3 B3 B2",
    "door_rear": "S3 S4 B4 B3", "quarter": "S4 S5 B5 B4",
}  # fmt: skip
CHAINS = ("C2 C3 C4 C5 C6", "S2 R1 R2 R3 S4", "S1 S2 S3 S4 S5", "B1 B2 B3 B4 B5")
ARCHES = ("B1 C0", "S1 C1", "S2 C2", "R1 C3", "R2 C4", "R3 C5", "S4 C6", "S5 C7", "B5 C8")


def joints_of_chain(row):
    """The joints of edges that follow each other, ``~e`` where against their sense."""
    return tuple((~edge, after) for edge, after in pairwise(row))


def side(node, letter):
    return node if node in CENTRE else f"{node}.{letter}"


def network():
    """Names of edges by their ends, sides of the patches, and the names of these.

    Seen from outside, with x to the rear and y to the right, the quads of the right half run
    against the clock as they stand; their images are run the other way.
    """
    edges, sides, names = {}, [], []
    for letter in "RL":
        for name, quad in QUADS.items():
            nodes = [side(n, letter) for n in quad.split()]
            if letter == "L":
                nodes = [nodes[1], nodes[0], nodes[3], nodes[2]]
            row = []
            for a, b in zip(nodes, nodes[1:] + nodes[:1], strict=True):
                if (b, a) in edges:
                    row.append(~edges[b, a])
                else:
                    row.append(edges.setdefault((a, b), len(edges)))
            sides.append(row)
            names.append(f"{name}.{letter}")
    return edges, np.array(sides), tuple(names)


def chain_edges(edges, names):
    """Signed edges along a row of nodes."""
    return [edges[a, b] if (a, b) in edges else ~edges[b, a]
            for a, b in pairwise(names)]  # fmt: skip


def mirror_images():
    """The image of every edge in y = 0; ``~edge`` where it runs the other way."""
    ends, _, _ = network()
    letters = {"R": "L", "L": "R"}
    found = {}
    for (a, b), number in ends.items():
        a, b = (n if n in CENTRE else n[:-1] + letters[n[-1]] for n in (a, b))
        found[number] = ends[a, b] if (a, b) in ends else ~ends[b, a]
    return found


def body(seed=None, spread=0.0, symmetric=False):
    """Edges, sides, names of patches and the joints of smooth lines.

    With a spread the lengths of tangents in joints are multiplied by random factors up to
    1 + spread or down to its inverse.
    """
    ends, sides, names = network()
    curves = np.zeros((len(ends), 4, 3))
    for (a, b), number in ends.items():
        p, q = np.array(NODES[a], float), np.array(NODES[b], float)
        curves[number] = p, p + (q - p) / 3, q + (p - q) / 3, q
    rng, factors, joints = np.random.default_rng(seed), {}, []
    for row in smooth_rows():
        joints += joints_of_chain(chain_edges(ends, row))
        for a, b, c in zip(row, row[1:], row[2:], strict=False):
            before, middle, after = (np.array(NODES[n], float) for n in (a, b, c))
            along = (after - before) / np.linalg.norm(after - before)
            for other, sense in ((a, -1), (c, 1)):
                key = (b[:2], other[:2]) if symmetric else (b, other)
                factor = factors.setdefault(key, (1 + spread) ** rng.uniform(-1, 1))
                length = factor * np.linalg.norm(np.array(NODES[other], float) - middle) / 3
                (edge,) = chain_edges(ends, [b, other])
                curves[(edge, 1) if edge >= 0 else (~edge, 2)] = middle + sense * length * along
    return curves, sides, names, tuple(joints)


def smooth_rows():
    """Nodes along every smooth line; the roof's lies in the plane of symmetry."""
    rows = [[side(n, letter) for n in chain.split()] for chain in CHAINS for letter in "RL"]
    arches = [[side(a, "R"), c, side(a, "L")] for a, c in map(str.split, ARCHES)]
    return rows[1:] + arches
