"""Hidden corners that other hidden corners lead to, and lines where two hidden faces meet."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import CrossSection

from bozzetto.arrays import Array
from bozzetto_polyhedron.reconstruction.directions import SAME_WAY, Directions
from tests.plugins.polyhedron.objects import Polyhedron, box, polyhedron_of
from tests.plugins.polyhedron.test_hidden_edges import guessed_pairs, seen_graph


def notched_angle() -> Polyhedron:
    """Return an angle with a notch in its lying leg, to whose back corners few lines lead."""
    angle = box((3.0, 2.4, 0.6)) + box((0.6, 2.4, 2.2))
    solid = polyhedron_of(angle - box((0.9, 1.0, 2.0), (1.5, -0.2, -0.5)), "notched angle", 0.03)
    assert solid is not None
    return solid


def wedge_on_plate() -> Polyhedron:
    """Return a plate with a wedge upon it, as deep as three quarters of it."""
    outline = CrossSection([np.array([(0.0, 0.0), (1.8, 0.0), (1.8, 1.2)])])
    wedge = outline.extrude(1.5).rotate((90.0, 0.0, 0.0)).translate((0.6, 1.5, 0.6))
    solid = polyhedron_of(box((3.0, 2.0, 0.61)) + wedge, "wedge on plate", 0.03)
    assert solid is not None
    return solid


def is_guessed(solid: Polyhedron, seed: int) -> bool:
    """Return whether a guess adds all hidden lines of a solid and no other lines."""
    seen, graph = seen_graph(solid, seed)
    edges = {tuple(sorted(pair)) for pair in solid.edges.tolist()}
    hidden = {
        tuple(sorted(pair))
        for pair, share in zip(solid.edges.tolist(), seen.hidden, strict=True)
        if share == 1.0
    }
    found = guessed_pairs(seen, graph)
    return any(each is not None and hidden <= each <= edges for each in found)


@pytest.mark.parametrize("seed", [2, 4, 33])
def test_a_line_waits_for_a_corner_that_others_find(seed: int) -> None:
    assert is_guessed(notched_angle(), seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", [19, 25, 30])
def test_a_line_waits_for_a_corner_seen_from_other_sides(seed: int) -> None:
    assert is_guessed(notched_angle(), seed)


@pytest.mark.parametrize("seed", [1, 2, 4, 6])
def test_lines_that_close_to_no_solid_do_not_end_the_search(seed: int) -> None:
    assert is_guessed(wedge_on_plate(), seed)


def class_of(way: Array) -> Array:
    """Return a direction as classes are kept: of length 1 on the sheet, to the right."""
    return np.asarray(way / np.hypot(*way[:2]) * np.sign(way[0]))


@pytest.mark.parametrize("seed", range(12))
def test_the_third_line_of_a_corner_lies_in_both_other_faces(seed: int) -> None:
    """The faces have chance normals; their sides are chance lines in them."""
    rng = np.random.default_rng(seed)
    shared, one, two = rng.normal(size=(3, 3))
    lines = np.cross((one, two), shared)
    in_shared, in_one, in_two = np.cross((shared, one, two), rng.normal(size=3))
    ways = np.array([class_of(each) for each in (*lines, in_shared, in_one, in_two)])
    directions = Directions(np.zeros(0, np.intp), ways, [0, 1, 2, 3, 4], np.zeros((0, 3)))
    thirds = directions.thirds(0, (2, 3), 1, (2, 4))
    meant = class_of(np.cross(one, two))
    off = np.abs(directions.ways[list(thirds)] - meant).max(axis=1).min()
    assert off < 1e-9 or np.abs(ways - meant).max(axis=1).min() < 2.0 * SAME_WAY


def test_where_no_slopes_are_told_the_third_line_is_any_other() -> None:
    ways = np.array([(1.0, 0.0, np.nan), (0.6, 0.8, np.nan), (0.0, 1.0, np.nan)])
    directions = Directions(np.zeros(0, np.intp), ways, [2, 0, 1], np.zeros((0, 3)))
    assert directions.thirds(0, (1, 2), 1, (0, 2)) == (2,)
