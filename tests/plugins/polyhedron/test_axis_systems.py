"""Axes that lines run along: several systems, perspective, and what has none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.reconstruction.axis_systems import axis_system, axis_systems
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from tests.plugins.polyhedron.objects import OBJECTS, Polyhedron, View, graph_of, view


def seen(name: str, seed: int = 1, distance: float | None = None) -> View:
    found = view(OBJECTS[name], seed, distance)
    assert found is not None
    return found


def true_axes(shown: View) -> np.ndarray:
    """The directions of the edges of an orthogonal solid, in the frame of the eye."""
    spans = np.diff(shown.space[shown.solid.edges], axis=1)[:, 0]
    spans /= np.linalg.norm(spans, axis=1, keepdims=True)
    kept: list[np.ndarray] = []
    for span in spans:
        if all(abs(span @ other) < 0.5 for other in kept):
            kept.append(span)
    return np.array(kept)


@pytest.mark.parametrize("name", ["box", "L", "stairs", "plus", "hole"])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_the_axes_of_orthogonal_solids_are_found(name: str, noise: float) -> None:
    shown = seen(name)
    graph, _ = graph_of(shown, noise, 3)
    first = axis_systems(graph)[0]
    assert np.allclose(first.axes @ first.axes.T, np.eye(3), atol=1e-9)
    assert first.share > 0.9
    true = true_axes(shown)
    best = max(np.abs((first.axes * (1, 1, side)) @ true.T).max(1).min() for side in (1.0, -1.0))
    assert best > np.cos(np.radians(1e-3 if noise == 0.0 else 8.0))


def test_a_second_system_is_found_in_what_the_first_leaves() -> None:
    first, second = seen("box", 1), seen("box", 6)
    count = len(first.plane)
    both = Polyhedron(
        np.vstack((first.space, second.space)),
        np.vstack((first.solid.edges, second.solid.edges + count)),
        (),
    )
    shown = View(both, both.vertices, np.vstack((first.plane, second.plane + np.array((1.5, 0.0)))))
    graph, _ = graph_of(replace(shown, hidden=np.zeros(24)), 0.0, 1)
    systems = axis_systems(graph)
    assert len(systems) >= 2
    assert systems[0].share >= systems[1].share
    assert sum(each.share for each in systems[:2]) > 0.8


@pytest.mark.parametrize("distance", [1.2, 2.0, 3.0])
def test_perspective_is_found(distance: float) -> None:
    shown = seen("L", 2, distance)
    drawing = drawing_of(graph_of(shown, 0.0, 2)[0])
    every = np.ones(len(drawing.lines))
    system = axis_system(drawing, every, perspective=True, starts=(0.15, 0.6))
    assert system is not None
    assert system.perspective == pytest.approx(shown.perspective, rel=0.15)


def test_lines_of_one_direction_have_no_axes() -> None:
    places = np.array([(0, 0), (100, 0), (0, 50), (100, 50), (0, 90), (100, 90), (0, 9), (99, 9)])
    lines = np.array([(0, 1), (2, 3), (4, 5), (6, 7)])
    graph = LineGraph(places.astype(float), lines, np.zeros(4), ((0,),) * 4, (), 1.0, ())
    assert axis_systems(graph) == ()


def test_nothing_has_no_axes() -> None:
    empty = LineGraph(np.zeros((0, 2)), np.zeros((0, 2), np.intp), np.zeros(0), (), (), 1.0, ())
    assert axis_systems(empty) == ()


def test_size_and_place_do_not_matter() -> None:
    graph, _ = graph_of(seen("U"), 0.01, 2)
    other = replace(graph, places=1000.0 * graph.places - 77.0, noise=1000.0 * graph.noise)
    one, two = axis_systems(graph)[0], axis_systems(other)[0]
    assert np.allclose(one.axes, two.axes, atol=1e-6)
    assert one.share == pytest.approx(two.share)
