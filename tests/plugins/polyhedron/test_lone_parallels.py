"""Slopes that are taken from lines which look parallel by chance."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.graph.planar_embedding import components, neighbors_of
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.cautions import BY_LOOKS
from bozzetto_polyhedron.reconstruction.drawing import Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.lifting import Lifting, liftings
from bozzetto_polyhedron.reconstruction.lone_parallels import borne_out, without_lone_parallels
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.readings import readings
from tests.plugins.polyhedron.objects import (
    CAMERA,
    OBJECTS,
    View,
    graph_of,
    in_eye_frame,
    is_right,
    view,
)
from tests.plugins.polyhedron.test_open_heights import seen, true_classes

NOISE = 0.005

CHANCE = [("pyramid on box", 6), ("pyramid on box", 21)]
"""Parts, and views in which a slanted line runs like another one."""


def drawn(shown: View, seed: int, noise: float = NOISE) -> Drawing:
    return drawing_of(graph_of(shown, noise, seed, 0.0)[0])


def lifted(drawing: Drawing) -> list[Lifting]:
    """Return the first lifting of each part of a drawing, the largest part first."""
    neighbors = neighbors_of(drawing.lines)
    parts = sorted(components(neighbors), key=len, reverse=True)
    classes = parallel_classes(drawing)
    return [liftings(drawing, classes, neighbors, each)[0] for each in parts]


@pytest.mark.parametrize(("name", "seed"), CHANCE)
def test_slanted_lines_stand_alone_and_parallels_of_faces_together(name: str, seed: int) -> None:
    shown = seen(name, seed)
    drawing = drawn(shown, seed)
    classes, true = parallel_classes(drawing), true_classes(shown, drawing).labels
    single = np.bincount(true)[true] == 1
    fused = np.bincount(classes.labels)[classes.labels] > 1
    assert (single & fused).any()  # by chance, in this view
    found = borne_out(drawing, classes, shown.solid.faces)
    sizes = np.bincount(found.labels)[found.labels]
    assert (sizes[single] == 1).all()
    assert (sizes[~single] > 1).mean() > 0.9  # a line that went to a slanted one's class is lost
    along = (drawing.spans * found.directions[found.labels]).sum(1)
    assert np.abs(along) == pytest.approx(drawing.lengths, rel=0.02)


@pytest.mark.parametrize(("name", "seed"), CHANCE)
def test_the_other_answer_is_offered(name: str, seed: int) -> None:
    shown = seen(name, seed)
    graph, _ = graph_of(shown, NOISE, seed, 0.0)
    found = readings(drawing_of(graph))
    assert {each.by_looks for each in found} == {True, False}
    right = [
        is_right(shown, in_eye_frame(each.vertices, CAMERA), NOISE, mirrored=False)
        for each in answers_of(graph, CAMERA)
    ]
    assert any(right[:3])


@pytest.mark.parametrize("name", list(OBJECTS))
def test_where_nothing_hangs_on_looks_there_is_one_way_and_nothing_is_told(name: str) -> None:
    shown = view(OBJECTS[name], 5)
    assert shown is not None
    drawing = drawn(shown, 5, 0.0)
    assert without_lone_parallels(drawing, parallel_classes(drawing), lifted(drawing)) is None
    first = answers_of(graph_of(shown, 0.0, 5, 0.0)[0], CAMERA)[0]
    assert BY_LOOKS not in first.warnings


@pytest.mark.parametrize("seed", [26, 29, 38])
def test_a_doubtful_slope_is_told_with_every_answer(seed: int) -> None:
    shown = seen("cut pyramid on plate", seed)
    found = answers_of(graph_of(shown, NOISE, seed, 0.0)[0], CAMERA)
    assert len(found) > 1
    assert all(BY_LOOKS in each.warnings for each in found)
