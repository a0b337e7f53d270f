"""Pyramids and frusta, which have few right angles: equal angles and mirror planes tell them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold

from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.perspective import parallel_view
from tests.plugins.polyhedron.cad_parts import regular
from tests.plugins.polyhedron.objects import (
    CAMERA,
    Polyhedron,
    graph_of,
    in_eye_frame,
    is_right,
    polyhedron_of,
    view,
)

HEIGHT = 2.2 * (2.0 / 3.0) ** 0.5
"""Of a regular tetrahedron with sides of 2.2."""

SOLIDS = {
    "tetrahedron": Manifold.hull_points(
        [(0, 0, 0), (2.2, 0, 0), (1.1, 1.1 * 3**0.5, 0), (1.1, 1.1 / 3**0.5, HEIGHT)]
    ),
    "hexagonal frustum": CrossSection([regular(6, 1.5)]).extrude(1.6, scale_top=(0.55, 0.55)),
    "pyramid": Manifold.hull_points(
        [(-1.5, -1, 0), (1.5, -1, 0), (1.5, 1, 0), (-1.5, 1, 0), (0, 0, 1.9)]
    ),
}


def seen_solid(name: str, seed: int):
    solid = polyhedron_of(SOLIDS[name], name, 0.04)
    assert isinstance(solid, Polyhedron)
    seen = view(solid, seed)
    assert seen is not None
    return seen


def right(name: str, seeds: Sequence[int], first: int) -> float:
    """Return the share of drawings with a right answer among the first ones."""
    found = []
    for seed in seeds:
        seen = seen_solid(name, seed)
        graph, _ = graph_of(seen, 0.005, seed, 0.0)
        answers = answers_of(graph, CAMERA)[:first]
        shapes = [in_eye_frame(each.vertices, CAMERA) for each in answers]
        found.append(any(is_right(seen, shape, 0.005) for shape in shapes))
    return float(np.mean(found))


@pytest.mark.parametrize(
    ("name", "first", "least"),
    [("tetrahedron", 1, 0.8), ("hexagonal frustum", 1, 0.8), ("pyramid", 3, 0.8)],
)
def test_what_is_symmetric_is_found_without_right_angles(
    name: str, first: int, least: float
) -> None:
    assert right(name, range(91_000, 91_010), first) >= least


def test_six_lines_that_some_perspective_explains_are_no_perspective() -> None:
    for seed in range(91_000, 91_010):
        graph, _ = graph_of(seen_solid("tetrahedron", seed), 0.01, seed, 0.0)
        assert parallel_view(drawing_of(graph), CAMERA).perspective == 0.0
