"""How often open boxes with flaps are read right, on seeds that nothing was tuned on.

``python -m tests.plugins.polyhedron.figures_open_boxes [drawings]`` prints a Markdown table.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.answers import answers_of
from tests.plugins.polyhedron.objects import (
    CAMERA,
    Polyhedron,
    graph_of,
    in_eye_frame,
    is_right,
    view,
)
from tests.plugins.polyhedron.write_samples import folding_box

FIRST_SEED = 81_000
SIDES = ((0, 1, 2, 3), (0, 2), (1, 3), (1, 2, 3))
"""Sides of the rim at which flaps hang, from the front round."""


def open_box(seed: int, sides: tuple[int, ...]) -> Polyhedron:
    """Return a random box with flaps at some sides."""
    rng = np.random.default_rng((31, seed))
    size = rng.uniform(1.0, 2.0, 3)
    return folding_box(size, rng.uniform(0.5, 0.9), rng.uniform(20.0, 60.0), sides)


def lidded_box(seed: int) -> Polyhedron:
    """Return a random box that is not high, with a lid that is as large as what it covers."""
    rng = np.random.default_rng((32, seed))
    size = rng.uniform(1.0, 2.0, 3) * (1.0, 1.0, 0.5)
    return folding_box(size, float(size[1]), rng.uniform(40.0, 70.0), (2,))


def face_sets(faces: Sequence[Rings]) -> set[frozenset[frozenset[int]]]:
    """Return faces without the order of their corners."""
    return {frozenset(map(frozenset, face)) for face in faces}


def main(count: int) -> None:
    print("| open boxes | faces right | shape right, first answer |")
    print("| --- | --- | --- |")
    for name, noise, lid in (
        ("with flaps", 0.0, False),
        ("with flaps, 1 % of jitter", 0.01, False),
        ("with a lid, 1 % of jitter", 0.01, True),
    ):
        faces, shapes = [], []
        for seed in range(FIRST_SEED, FIRST_SEED + count):
            solid = lidded_box(seed) if lid else open_box(seed, SIDES[seed % len(SIDES)])
            seen = view(solid, seed)
            if seen is None:
                continue
            graph, _ = graph_of(seen, noise, seed)
            first = answers_of(graph, CAMERA)[0]
            faces.append(face_sets(first.faces) == solid.face_sets())
            shapes.append(is_right(seen, in_eye_frame(first.vertices, CAMERA), noise))
        print(f"| {name} | {sum(faces)} of {len(faces)} | {sum(shapes)} of {len(shapes)} |")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 60)
