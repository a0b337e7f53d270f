"""What lines and faces leave open is found by regularity; loose parts tell of their body."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.graph.likelihood import PASSES, passing_cost
from bozzetto_polyhedron.reconstruction.affine_depth import affine_depth
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.drawing import Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses
from tests.plugins.polyhedron.cad_parts import part
from tests.plugins.polyhedron.objects import CAMERA, View, graph_of, in_eye_frame, is_right, view

OPEN = ("pyramid on box", "cut pyramid on plate", "anvil")
"""Parts with a height that no parallel line and no plane tells."""

TIED = ("wedge with hole", "cut pyramid with pocket")
"""Parts of which the pocket tells the tilt."""

VIEW = 4
"""One in which no slanted line looks parallel to another one by chance."""


def seen(name: str, seed: int) -> View:
    solid = part(name, seed)
    assert solid is not None
    found = view(solid, seed)
    assert found is not None
    return found


def true_classes(drawn: View, drawing: Drawing) -> ParallelClasses:
    """Return the classes of lines that are parallel in space."""
    ways = drawn.space[drawing.lines[:, 1]] - drawn.space[drawing.lines[:, 0]]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    labels = (np.abs(ways @ ways.T) > 1.0 - 1e-9).argmax(axis=1)
    first, labels = np.unique(labels, return_inverse=True)
    flat = drawing.spans[first] / drawing.lengths[first, None]
    return ParallelClasses(labels, flat)


@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize("name", [*OPEN, *TIED])
def test_the_first_answer_is_the_part(name: str, noise: float) -> None:
    drawn = seen(name, VIEW)
    graph, _ = graph_of(drawn, noise, VIEW, 0.0)
    answer = answers_of(graph, CAMERA)[0]
    faces = {frozenset(frozenset(ring) for ring in face) for face in answer.faces}
    assert faces == drawn.solid.face_sets()
    assert is_right(drawn, in_eye_frame(answer.vertices, CAMERA), noise, mirrored=False)


@pytest.mark.parametrize(("name", "count"), [(OPEN[0], 1), (OPEN[1], 1), ("t slot", 0)])
def test_open_changes_keep_lines_and_faces_and_move_few_corners(name: str, count: int) -> None:
    drawn = seen(name, VIEW)
    graph, _ = graph_of(drawn, 0.0, VIEW, 0.0)
    drawing = drawing_of(graph)
    corners = tuple(range(len(drawing.points)))
    found = affine_depth(drawing, true_classes(drawn, drawing), corners, drawn.solid.faces)
    assert found.basis.shape == (len(corners), 1 + count)
    for change in found.basis.T[1:]:
        assert np.abs(change).max() == pytest.approx(1.0)
        assert (np.abs(change) < 1e-6).sum() >= len(corners) // 2
    true = np.column_stack((found.basis, drawing.points, np.ones(len(corners))))
    off = true @ np.linalg.lstsq(true, drawn.space[:, 2], rcond=None)[0] - drawn.space[:, 2]
    assert np.abs(off).max() < 1e-6


@pytest.mark.parametrize(
    ("angles", "pairs"),
    [
        ((0, 120, 240), 0),
        ((0, 180, 90, 300), 0),
        ((0, 180, 70, 250), 2),
        ((0, 180, 40, 100, 250), 1),
        ((5, 180, 40, 100, 250), 1),
        ((20, 180, 40, 100, 250), 0),
    ],
)
def test_lines_that_pass_a_corner_cost_whatever_their_order_and_turn(
    angles: tuple[float, ...], pairs: int
) -> None:
    for turn in (0.0, 33.0, 179.0):
        for shift in range(len(angles)):
            each = np.radians(np.roll(angles, shift) + turn)
            ways = np.angle(np.exp(1j * each)).tolist()
            assert passing_cost(ways) == PASSES * pairs
