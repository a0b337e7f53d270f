"""Trays with thin floors and frames: a ring in a face or close beside it."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.reconstruction.answers import answers_of
from tests.plugins.polyhedron.fine_parts import fine_part
from tests.plugins.polyhedron.objects import CAMERA, View, box, graph_of, polyhedron_of, view


def tray(floor: float, seed: int) -> View:
    """See a tray 1 high whose floor is so thick; a frame where that is negative."""
    solid = polyhedron_of(
        box((3.0, 2.2, 1.0)) - box((2.2, 1.4, 4.0), (0.4, 0.4, floor)), "tray", 0.005
    )
    assert solid is not None
    seen = view(solid, seed)
    assert seen is not None
    return seen


def read(seen: View, noise: float, seed: int, marks: float | None = 0.0) -> tuple[Answer, ...]:
    """Read it; the share of hidden lines that are marked wrongly, or all lines alike."""
    return answers_of(graph_of(seen, noise, seed, marks)[0], CAMERA)


def has_faces(answer: Answer, seen: View) -> bool:
    faces = {frozenset(frozenset(ring) for ring in face) for face in answer.faces}
    return faces == seen.solid.face_sets()


def holes(answer: Answer) -> int:
    """Number of rings in faces: two of a hole, one of a pocket."""
    return sum(len(face) - 1 for face in answer.faces)


@pytest.mark.parametrize("floor", [0.08, 0.12, 0.2, 0.4, -1.0])
@pytest.mark.parametrize("seed", [11, 12, 13])
def test_without_noise_a_floor_is_seen_however_thin(floor: float, seed: int) -> None:
    seen = tray(floor, seed)
    assert has_faces(read(seen, 0.0, seed)[0], seen)


def test_a_floor_within_the_noise_and_a_hole_share_the_confidence() -> None:
    firsts, others = [], []
    for seed in range(11, 19):
        answers = read(tray(0.03, seed), 0.012, seed, None)
        kinds = [holes(each) for each in answers]
        assert {1, 2} <= set(kinds)
        other = next(k for k, kind in enumerate(kinds) if kind != kinds[0])
        firsts.append(answers[0].confidence)
        others.append(answers[other].confidence)
    assert np.mean(firsts) < 0.9
    assert np.mean(others) > 0.05


@pytest.mark.parametrize(("name", "least"), [("tray", 0.8), ("frame", 0.8)])
def test_most_trays_and_frames_are_read_as_such(name: str, least: float) -> None:
    right = []
    for seed in range(500, 520):
        solid = fine_part(name, seed)
        seen = None if solid is None else view(solid, seed)
        if seen is not None:
            right.append(has_faces(read(seen, 0.008, seed)[0], seen))
    assert len(right) > 15
    assert np.mean(right) >= least
