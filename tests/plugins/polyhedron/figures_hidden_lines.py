"""Solids of which only visible lines are drawn: how often their hidden lines are guessed.

    python -m tests.plugins.polyhedron.figures_hidden_lines [--count 80] [--first 20000]

Prisms, blocks with a hole through them, solids of several boxes, and solids with corners cut, in
views that nothing was tuned on: parallel ones, and from 5, 2 and 1.2 sizes away, on a sheet that
has no perspective itself. Of the last two kinds, those count of which the visible lines tell the
rest, for two lines lead from what is seen to each hidden corner. A guess is right if the
drawing with its lines added is the graph of the solid; first answers are those of this drawing, as
`figures_end_to_end` asks.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.hidden_lines import hidden_lines
from bozzetto_polyhedron.solve.completion import completed
from tests.plugins.polyhedron.figures_end_to_end import is_whole, share
from tests.plugins.polyhedron.fine_parts import fine_part
from tests.plugins.polyhedron.graph_truth import graph_of, is_right
from tests.plugins.polyhedron.hand import SIZE, Hand, strokes_of
from tests.plugins.polyhedron.objects import (
    CAMERA,
    TO_CANVAS,
    Polyhedron,
    View,
    hidden_places,
    made,
    view,
)

PRISMS = ("rectilinear prism", "stairs", "letter prism", "slanted prism", "slanted step")

KINDS: dict[str, Callable[[int], Polyhedron | None]] = {
    "prisms": lambda seed: made(seed, PRISMS),
    "blocks with a hole": lambda seed: fine_part("frame", seed),
    "several boxes": lambda seed: made(seed, ("boxes", "notched box")),
    "cut corners": lambda seed: made(seed, ("chamfered",)),
}

ROWS = (
    ("prisms", 0.0, None),
    ("prisms", 0.01, None),
    ("prisms", 0.01, 5.0),
    ("prisms", 0.01, 2.0),
    ("prisms", 0.01, 1.2),
    ("blocks with a hole", 0.01, None),
    ("blocks with a hole", 0.01, 2.0),
    ("several boxes", 0.0, None),
    ("several boxes", 0.01, None),
    ("several boxes", 0.01, 2.0),
    ("cut corners", 0.01, None),
    ("cut corners", 0.01, 2.0),
)
"""Kind, jitter, and distance of the eye in sizes; none in a parallel view."""

TOLD = ("several boxes", "cut corners")
"""Kinds of which only those count that visible lines tell: nobody sees a notch in the back."""

SAMPLES = 200

SHORTEST = 0.03
"""Share of the diagonal under which nobody draws what is seen of an edge."""


def visible_lines(seen: View) -> tuple[Array, list[tuple[int, int]]]:
    """Ends of the visible stretches of edges, (2 k, 2) diagonals, and pairs of them."""
    at = (np.arange(SAMPLES) + 0.5) / SAMPLES
    places = [*(seen.plane * TO_CANVAS)]
    lines = []
    for (first, second), behind in zip(seen.solid.edges, hidden_places(seen, at), strict=True):
        for low, high in stretches(~behind):
            ends = []
            for place, corner, is_end in (
                (low / SAMPLES, first, low == 0),
                (high / SAMPLES, second, high == SAMPLES),
            ):
                if is_end:
                    ends.append(int(corner))
                else:
                    ends.append(len(places))
                    places.append(places[first] + place * (places[second] - places[first]))
            if np.linalg.norm(places[ends[0]] - places[ends[1]]) > SHORTEST:
                lines.append((ends[0], ends[1]))
    return np.array(places), lines


def stretches(seen: np.ndarray) -> Iterator[tuple[int, int]]:
    """First sample of each run that is seen, and the one behind its last."""
    steps = np.diff(np.concatenate(([0], seen.astype(int), [0])))
    yield from zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1), strict=True)


def is_told(seen: View) -> bool:
    """Whether two lines or more lead from what is seen to each corner that is wholly hidden."""
    visible = seen.solid.edges[seen.hidden < 1.0]
    known = np.zeros(len(seen.plane), bool)
    for (one, two), behind in zip(visible, seen.hidden[seen.hidden < 1.0], strict=True):
        known[[one, two]] |= behind == 0.0
    partly = {tuple(pair) for pair in visible.tolist()}
    leads = np.zeros(len(known), int)
    for one, two in seen.solid.edges.tolist():
        for here, there in ((one, two), (two, one)):
            leads[here] += bool(known[there] or (one, two) in partly)
    return bool((known | (leads >= 2)).all())


def drawing(
    seed: int, hand: Hand, distance: float | None = None, kind: str = "prisms"
) -> tuple[View, tuple[Stroke, ...]] | None:
    """Draw the visible lines of a solid, seen in perspective from a distance in sizes."""
    solid = KINDS[kind](seed)
    seen = None if solid is None else view(solid, seed, distance)
    if seen is None or (kind in TOLD and not is_told(seen)):
        return None
    places, lines = visible_lines(seen)
    return seen, strokes_of(places, lines, hand, seed)


def outcome(
    seed: int, hand: Hand, distance: float | None = None, kind: str = "prisms"
) -> tuple[list[bool], bool] | None:
    """Whether each guess is right, and whether the first answer of the right one is the solid."""
    drawn = drawing(seed, hand, distance, kind)
    if drawn is None:
        return None
    seen, strokes = drawn
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    places = seen.plane * TO_CANVAS * SIZE + 200.0
    right, whole = [], False
    for guess in hidden_lines(searched(strokes, only_visible=True).graph, CAMERA):
        graph = graph_of(completed(strokes, guess))
        right.append(is_right(graph, places, edges))
        if right[-1]:
            numbers = np.linalg.norm(graph.places[:, None] - places, axis=2).argmin(axis=1)
            whole = is_whole(answers_of(graph, CAMERA)[0], numbers, seen, graph)
            break
    return right, whole


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=80)
    parser.add_argument("--first", type=int, default=20_000)
    asked = parser.parse_args()
    print("| visible lines | first guess right | among three | then exact solid first | no guess |")
    print("| --- | --- | --- | --- | --- |")
    seeds = range(asked.first, asked.first + asked.count)
    for kind, jitter, distance in ROWS:
        hand = Hand(jitter=jitter, wobble=0.6 * jitter)
        found = [
            each for seed in seeds if (each := outcome(seed, hand, distance, kind)) is not None
        ]
        first = [bool(right[:1] and right[0]) for right, _ in found]
        three = [any(right) for right, _ in found]
        seen = "parallel" if distance is None else f"eye at {distance:g} sizes"
        print(
            f"| {kind}, {100 * jitter:g} % of jitter, {seen} | {share(first)} | {share(three)} "
            f"| {share([whole for _, whole in found])} "
            f"| {share([not right for right, _ in found])} |"
        )
    print("\nAsked: 70 % of prisms among three.")


if __name__ == "__main__":
    main()
