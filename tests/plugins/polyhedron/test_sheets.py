"""Drawings of folded sheets: their border is no face."""

from __future__ import annotations

import pytest

from bozzetto_polyhedron.reconstruction.answers import answers_of
from tests.plugins.polyhedron.figures_open_boxes import face_sets
from tests.plugins.polyhedron.objects import CAMERA, graph_of, in_eye_frame, is_right, view
from tests.plugins.polyhedron.sheets import sheets


@pytest.mark.parametrize("number", range(5))
@pytest.mark.parametrize("seed", range(90_000, 90_003))
def test_a_folded_sheet_has_its_faces_and_no_others(number: int, seed: int) -> None:
    solid = sheets(seed)[number]
    seen = view(solid, seed)
    assert seen is not None
    for noise in (0.0, 0.01):
        graph, _ = graph_of(seen, noise, seed)
        first = answers_of(graph, CAMERA)[0]
        assert face_sets(first.faces) == solid.face_sets()
        assert not first.closed
        assert is_right(seen, in_eye_frame(first.vertices, CAMERA), noise)
