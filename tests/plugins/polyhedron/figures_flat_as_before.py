"""Drawings of flat faces of which something is read as round: there should be none.

    python -m tests.plugins.polyhedron.figures_flat_as_before [--count 60] [--first 64000]

Where nothing of a drawing is round, its strokes go on as they were drawn, and all that comes of it
is the same as if ellipses were not read. Families and hands are those of `figures_end_to_end`, and
parts with narrow bevels, at 1 and 2 % of jitter, lines bowed as there.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from bozzetto_polyhedron.rounds.reading import read
from tests.plugins.polyhedron.cad_parts import PARTS, part
from tests.plugins.polyhedron.fine_parts import FINE, fine_part
from tests.plugins.polyhedron.hand import CLEAN, UNTIDY, Hand, strokes_of
from tests.plugins.polyhedron.machine_parts import MACHINE, machine_part
from tests.plugins.polyhedron.objects import TO_CANVAS, Polyhedron, made, view
from tests.plugins.polyhedron.workshop_parts import WORKSHOP, workshop_part

FAMILIES = ("random", "parts", "workshop", "machine", "fine")


def rounds_in(solid: Polyhedron, seed: int, hand: Hand) -> list[int] | None:
    """Return how many rims and bends are read in the drawing of a solid; None without a view."""
    seen = view(solid, seed)
    if seen is None:
        return None
    edges = [(int(a), int(b)) for a, b in solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    reading = read(strokes_of(seen.plane * TO_CANVAS, edges, hand, seed, hidden), "clear")
    return [0, 0] if reading is None else [len(reading.rims), len(reading.bends)]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--first", type=int, default=64_000)
    parser.add_argument("--families", nargs="*", default=FAMILIES)
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.count)
    views = seeds[: max(1, asked.count // 30)]
    families = {
        "random": (("any",), lambda _, seed: made(seed), seeds),
        "parts": (PARTS, part, views),
        "workshop": (WORKSHOP, workshop_part, views),
        "machine": (MACHINE, machine_part, views),
        "fine": (FINE, fine_part, views),
    }
    hands = {
        "1 %": CLEAN,
        "2 %": replace(CLEAN, jitter=0.02),
        "1 %, untidy": replace(UNTIDY, overshot=0.3),
        "2 %, untidy": replace(UNTIDY, overshot=0.3, jitter=0.02),
    }
    print("| drawings | jitter | with a rim | with a rounded edge |")
    print("| --- | --- | --- | --- |")
    for word in asked.families:
        names, maker, numbers = families[word]
        for told, hand in hands.items():
            found = []
            for name in names:
                for seed in numbers:
                    solid = maker(name, seed)
                    each = None if solid is None else rounds_in(solid, seed, hand)
                    if each is not None:
                        found.append(each)
            rims, bends = (np.array(found) > 0).sum(axis=0)
            print(
                f"| {word} | {told} | {rims} of {len(found)} | {bends} of {len(found)} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
