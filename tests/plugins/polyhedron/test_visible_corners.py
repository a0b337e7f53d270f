"""Corners of two lines that hardly turn, at the outline of what is drawn without hidden lines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_polyhedron.graph.likelihood import Fits, Spread
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.graph.segments import Segments
from tests.plugins.polyhedron.graph_truth import is_right
from tests.plugins.polyhedron.hand import CLEAN, SIZE, Hand, strokes_of


def bent_prism(turn: float, short: float) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Return what is seen of a prism whose left side bends above a short edge; diagonals."""
    bend = np.array([0.0, short])
    up = (0.35 - short) * np.array([np.tan(np.radians(turn)), 1.0])
    front = np.array([(0.0, 0.0), (0.5, 0.0), (0.5, 0.35), bend + up, bend])
    places = np.concatenate((front, front[1:4] + np.array([0.22, 0.14]))) * (1.0, -1.0)
    lines = [(k, (k + 1) % 5) for k in range(5)] + [(1, 5), (2, 6), (3, 7), (5, 6), (6, 7)]
    return places / np.linalg.norm(np.ptp(places, axis=0)), lines


def right(turn: float, short: float, hand: Hand, seed: int) -> bool:
    places, lines = bent_prism(turn, short)
    graph = searched(strokes_of(places, lines, hand, seed), only_visible=True).graph
    return is_right(graph, places * SIZE + 200.0, lines)


@pytest.mark.parametrize("turn", [0.0, 10.0, 20.0])
def test_outer_ends_of_a_joined_line_pay_for_their_distance_from_it(turn: float) -> None:
    """By the angle alone: both segments meet in one place."""
    way = np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    ends = np.array([[(0.0, 0.0), (0.4, 0.0)], [(0.4, 0.0), (0.4, 0.0) + 0.08 * way]])
    segments = Segments(ends, np.full(2, 0.8), np.array([0, 5]), np.zeros(2))
    spread = Spread(0.005, 0.0065, 0.0)
    fits = Fits(segments, spread)
    line = fits.line((0, 1))
    middle = np.mean((line.start, line.stop), axis=0)
    along = (np.array(line.stop) - line.start) / line.length
    off = (ends.reshape(-1, 2) - middle) @ (-along[1], along[0])
    straight = Fits(in_one_line(segments), spread).line((0, 1))
    added = line.misfit - straight.misfit
    assert added == pytest.approx(float((off**2).sum()) / (2.0 * 0.005**2), abs=0.05)


def in_one_line(segments: Segments) -> Segments:
    """Return the same segments in one line."""
    ends = segments.ends.copy()
    ends[1, 1] = ends[1, 0] + (0.08, 0.0)
    return replace(segments, ends=ends)


def test_short_edges_that_turn_by_little_are_edges() -> None:
    found = [right(turn, 0.06, CLEAN, seed) for turn in (16.0, 20.0) for seed in range(10)]
    assert np.mean(found) >= 0.6


@pytest.mark.parametrize("seed", range(4))
def test_a_line_drawn_in_two_pieces_is_one(seed: int) -> None:
    assert right(30.0, 0.2, replace(CLEAN, split=0.5), seed)
