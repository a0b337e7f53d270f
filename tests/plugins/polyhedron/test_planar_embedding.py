"""Faces of planar graphs, against Euler, another library, and pieces that are turned over."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.graph.planar_embedding import (
    components,
    embedded_faces,
    flipped,
    neighbors_of,
    shared_pairs,
)
from tests.plugins.polyhedron.objects import OBJECTS, UNIONS, made


def directed(faces: tuple[tuple[int, ...], ...]) -> list[tuple[int, int]]:
    return [pair for face in faces for pair in zip(face, (*face[1:], face[0]), strict=True)]


@pytest.mark.parametrize("seed", range(40))
def test_faces_run_through_each_line_in_both_directions(seed: int) -> None:
    solid = made(3000 + seed)
    neighbors = neighbors_of(solid.edges)
    for part in components(neighbors):
        faces = embedded_faces({corner: neighbors[corner] for corner in part})
        if faces is None:
            continue
        ways = directed(faces)
        assert len(set(ways)) == len(ways)
        assert {(b, a) for a, b in ways} == set(ways)
        assert len(part) - len(ways) // 2 + len(faces) == 2


@pytest.mark.parametrize("name", sorted(OBJECTS))
def test_the_faces_of_connected_solids_are_those_of_the_solid(name: str) -> None:
    solid = OBJECTS[name]
    if solid.parts > 1:
        return
    faces = embedded_faces(neighbors_of(solid.edges))
    assert faces is not None
    assert shared_pairs(faces) == []
    assert {frozenset(face) for face in faces} == {frozenset(face[0]) for face in solid.faces}


def test_graphs_that_are_not_planar_have_no_faces() -> None:
    five = [(a, b) for a in range(5) for b in range(a)]
    utilities = [(a, b) for a in range(3) for b in range(3, 6)]
    assert embedded_faces(neighbors_of(five)) is None
    assert embedded_faces(neighbors_of(utilities)) is None


def test_what_hangs_on_one_corner_has_no_faces() -> None:
    bow = [(0, 1), (1, 2), (0, 2), (2, 3), (3, 4), (2, 4)]
    assert embedded_faces(neighbors_of(bow)) is None
    assert embedded_faces(neighbors_of([(0, 1), (1, 2)])) is None


def test_a_piece_between_two_corners_can_be_turned_over() -> None:
    solid = UNIONS["flush boss"]
    faces = embedded_faces(neighbors_of(solid.edges))
    assert faces is not None
    pairs = shared_pairs(faces)
    assert pairs
    found = set()
    for pair in pairs:
        other = flipped(faces, pair)
        lines = sorted(tuple(sorted(way)) for way in directed(other))
        assert lines == sorted(tuple(sorted(way)) for way in directed(faces))
        found.add(frozenset(frozenset(face) for face in other))
        back = flipped(other, pair)
        assert {frozenset(face) for face in back} == {frozenset(face) for face in faces}
    found.add(frozenset(frozenset(face) for face in faces))
    assert frozenset(frozenset(face[0]) for face in solid.faces) in found


def test_many_lines_are_no_trouble() -> None:
    count = 66
    around = [(k, (k + 1) % count) for k in range(count)]
    lines = around + [(a + count, b + count) for a, b in around]
    lines += [(k, k + count) for k in range(count)]
    faces = embedded_faces(neighbors_of(np.array(lines)))
    assert faces is not None
    assert len(faces) == count + 2
