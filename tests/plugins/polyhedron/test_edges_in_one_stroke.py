"""Several edges that are drawn in one stroke are cut at their corners; arcs are not."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.graph.segments import is_curved, pieces_of
from tests.plugins.polyhedron.graph_truth import is_right
from tests.plugins.polyhedron.hand import CLEAN, SIZE, stroke, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS, TO_CANVAS, view

NOWHERE = np.zeros((0, 2))


def path(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return corners of a stroke of several edges, short ones beside long ones, diagonals."""
    corners = [np.zeros(2)]
    heading = rng.uniform(0.0, 2.0 * np.pi)
    for _ in range(count):
        length = rng.choice((rng.uniform(0.06, 0.12), rng.uniform(0.2, 0.5)))
        corners.append(corners[-1] + length * np.array([np.cos(heading), np.sin(heading)]))
        heading += rng.choice((-1.0, 1.0)) * np.radians(rng.uniform(40.0, 140.0))
    return np.array(corners)


def in_one_stroke(
    corners: np.ndarray, rng: np.random.Generator, round_by: int = 2, bow: float = 0.006
):
    """Draw edges one after the other: bowed, with a tremor, round at the corners."""
    made = []
    for start, end in pairwise(corners):
        length = float(np.linalg.norm(end - start))
        x = np.linspace(0.0, 1.0, max(8, int(250 * length)))
        across = np.array([-(end - start)[1], (end - start)[0]]) / length
        bowed = rng.normal(0.0, bow) * length * np.sin(np.pi * x)
        made.append(start + (end - start) * x[:, None] + bowed[:, None] * across)
    points = np.concatenate(made)
    for _ in range(round_by):
        points[1:-1] = (points[:-2] + 2.0 * points[1:-1] + points[2:]) / 4.0
    points += rng.normal(0.0, 0.0008, points.shape)
    return stroke(points * SIZE + 200.0)


@pytest.mark.parametrize("count", [2, 3, 4, 6, 8])
def test_every_edge_of_a_stroke_is_a_piece_and_ends_at_its_corners(count: int) -> None:
    right = []
    for seed in range(60):
        rng = np.random.default_rng((seed, count))
        corners = path(rng, count)
        found = pieces_of(in_one_stroke(corners, rng), SIZE, NOWHERE)
        wanted = np.stack((corners[:-1], corners[1:]), axis=1) * SIZE + 200.0
        right.append(
            len(found.ends) == count and float(np.abs(found.ends - wanted).max()) < 0.02 * SIZE
        )
    assert np.mean(right) >= 0.9


@pytest.mark.parametrize("sweep", [60.0, 90.0, 180.0, 270.0])
@pytest.mark.parametrize("radius", [0.08, 0.15, 0.3])
def test_an_arc_is_no_row_of_edges(radius: float, sweep: float) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        turn = np.radians(np.linspace(0.0, sweep, 60) + rng.uniform(0.0, 360.0))
        points = radius * np.column_stack((np.cos(turn), rng.uniform(0.5, 1.0) * np.sin(turn)))
        drawn = stroke((points + rng.normal(0.0, 0.0008, points.shape)) * SIZE + 400.0)
        found = pieces_of(drawn, SIZE, NOWHERE)
        assert found.curved == is_curved(drawn, SIZE)
        assert len(found.ends) <= 1


@pytest.mark.parametrize("name", ["L", "U", "stairs", "house", "T", "plus", "hole"])
def test_a_solid_whose_faces_are_drawn_round_in_one_stroke_each_has_its_graph(name: str) -> None:
    solid = OBJECTS[name]
    for seed in range(3):
        seen = view(solid, 5_000 + seed)
        assert seen is not None
        places = seen.plane * TO_CANVAS
        rng = np.random.default_rng((seed, 3))
        edges = [(int(a), int(b)) for a, b in solid.edges]
        outlines = sorted((face[0] for face in solid.faces), key=len)[-2:]
        drawn, done = [], set()
        for ring in outlines:
            aimed = places[[*ring, ring[0]]] + rng.normal(0.0, 0.004, (len(ring) + 1, 2))
            drawn.append(in_one_stroke(aimed, rng))
            done |= {frozenset(pair) for pair in zip(ring, (*ring[1:], ring[0]), strict=True)}
        rest = [pair for pair in edges if frozenset(pair) not in done]
        drawn += strokes_of(places, rest, replace(CLEAN, jitter=0.008), seed)
        graph = searched(tuple(drawn)).graph
        assert is_right(graph, places * SIZE + 200.0, edges)


def test_corners_between_bowed_edges_are_where_the_pen_turned() -> None:
    """A long edge that bows takes no samples of the short one beside it."""
    off = []
    for seed in range(60):
        rng = np.random.default_rng((seed, 7))
        corners = path(rng, int(rng.integers(2, 6)))
        found = pieces_of(in_one_stroke(corners, rng, bow=0.015), SIZE, NOWHERE)
        if len(found.ends) == len(corners) - 1:
            wanted = np.stack((corners[:-1], corners[1:]), axis=1) * SIZE + 200.0
            off.append(np.abs(found.ends - wanted).max() / SIZE)
    assert len(off) >= 57
    assert np.percentile(off, 95) < 0.006
