"""A typed length changes what it is typed for, and nothing else that need not change."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.model.state import Dimension
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solve.measured_edges import faces_apart
from tests.plugins.polyhedron.true_bodies import (
    all_bodies,
    drawn,
    of_prism,
    parallel_camera,
    random_turn,
)

CHANNEL = of_prism(
    "channel", [(0, 0), (90, 0), (90, 60), (72, 60), (72, 25), (18, 25), (18, 60), (0, 60)], 50
)
"""Like the U, with thinner legs."""

BODIES = {body.name: body for body in (*all_bodies(), CHANNEL)}
RIGHT = [name for name, body in BODIES.items() if body.orthogonal and body.genus is not None]
PRISMS = ["box", "L", "U", "stairs", "wedge", "house", "hexagon", "hole"]


def before_and_after(name, seed, pairs, factor, share=0.01):
    """A body that was drawn, the same with lengths typed, and both their corners in its axes."""
    rng = np.random.default_rng(seed)
    turn = random_turn(rng)
    answer, noise, _ = drawn(BODIES[name], share, rng, turn=turn)
    up = tuple(turn[:, 2])
    options = {"noise": noise, "camera": parallel_camera(), "up": up}
    body = exact_body(answer, **options)
    typed = [Dimension(pair, factor * apart(body, pair)) for pair in pairs]
    other = exact_body(answer, **options, dimensions=typed)
    frame = np.eye(3) if body.frame is None else body.frame
    return body, other, body.vertices @ frame.T, other.vertices @ frame.T


def apart(body, pair):
    one, two = pair
    sign = np.sign(body.normals[one] @ body.normals[two])
    return abs(float(body.offsets[one] - sign * body.offsets[two]))


def measurable(name):
    """Every two parallel faces that a person can measure, at an edge between them."""
    answer, _, _ = drawn(BODIES[name], 0.0, np.random.default_rng(0))
    pairs = [faces_apart(answer, tuple(edge)) for edge in edges_of(answer.faces)]
    return sorted({tuple(sorted(pair)) for pair in pairs if pair is not None})


@pytest.mark.parametrize("factor", [0.9, 1.4])
@pytest.mark.parametrize("name", RIGHT)
def test_the_two_other_ways_across_stay_as_they_are(name, factor):
    for number, pair in enumerate(measurable(name)):
        body, _, was, now = before_and_after(name, 8100 + number, [pair], factor)
        along = int(np.abs(body.frame @ body.normals[pair[0]]).argmax())
        others = [axis for axis in range(3) if axis != along]
        assert np.abs(was[:, others] - now[:, others]).max() < 1e-9
        assert np.abs(was[:, along] - now[:, along]).max() > 0.5


@pytest.mark.parametrize("name", RIGHT)
def test_one_typed_length_moves_as_few_planes_as_can_be(name):
    """But where lengths are alike, and share what changes."""
    for number, pair in enumerate(measurable(name)):
        body, other, _, _ = before_and_after(name, 8200 + number, [pair], 1.2)
        moved = np.abs(other.offsets - body.offsets) > 1e-9
        if name not in ("stairs", "U"):
            assert moved[list(pair)].sum() == 1
        assert moved.sum() < len(moved) / 2


@pytest.mark.parametrize("seed", [8301, 8302])
@pytest.mark.parametrize("name", PRISMS)
def test_the_floor_of_what_stands_stays(name, seed):
    body, other, _, _ = before_and_after(name, seed, [(0, 1)], 1.7)
    foot, top = (sorted(set(body.faces[k][0])) for k in (0, 1))
    assert np.abs(other.vertices[foot] - body.vertices[foot]).max() < 1e-9
    ways = other.vertices[top] - body.vertices[top]
    assert np.abs(ways - 0.7 * apart(body, (0, 1)) * body.normals[1]).max() < 1e-9


def test_a_leg_stays_as_thick_as_it_was():
    """Of an L: 80 wide, its leg 35; of a channel: 90 wide, its legs 18."""
    for name, outer, kept in (("L", (3, 7), [(5, 7)]), ("channel", (3, 9), [(7, 9), (3, 5)])):
        body, other, _, _ = before_and_after(name, 8400, [outer], 1.3)
        assert apart(other, outer) == pytest.approx(1.3 * apart(body, outer), rel=1e-12)
        for pair in kept:
            assert apart(other, pair) == pytest.approx(apart(body, pair), rel=1e-9)


def test_steps_of_stairs_share_what_their_height_gains():
    body, other, _, _ = before_and_after("stairs", 8500, [(2, 8)], 1.5, share=0.004)
    steps = [(2, 4), (4, 6), (6, 8)]
    gains = [apart(other, step) - apart(body, step) for step in steps]
    assert np.ptp(gains) < 1e-6
    assert sum(gains) == pytest.approx(0.5 * apart(body, (2, 8)), rel=1e-9)


def test_several_lengths_hold_and_leave_the_rest():
    pairs = [(0, 1), (3, 7)]
    body, other, _, _ = before_and_after("L", 8600, pairs, 1.25)
    for pair in pairs:
        assert apart(other, pair) == pytest.approx(1.25 * apart(body, pair), rel=1e-12)
    for pair in [(5, 7), (2, 4), (2, 6)]:
        assert apart(other, pair) == pytest.approx(apart(body, pair), rel=1e-9)


def test_what_cannot_keep_its_slant_gives_way_as_a_whole():
    """A frustum whose height is typed keeps its base and its slopes as long as it can."""
    body, other, _, _ = before_and_after("frustum4", 8700, [(0, 1)], 1.1)
    assert apart(other, (0, 1)) == pytest.approx(1.1 * apart(body, (0, 1)), rel=1e-12)
    assert np.abs(np.abs((other.normals * body.normals).sum(axis=1)) - 1.0).max() < 1e-9


@pytest.mark.parametrize("name", ["open box", "folded"])
def test_corners_of_sheets_that_only_one_plane_holds_go_along(name):
    """Their edges keep their directions, which are not square to one another."""
    for number, pair in enumerate(measurable(name)):
        body, _, was, now = before_and_after(name, 8800 + number, [pair], 1.3)
        along = int(np.abs(body.frame @ body.normals[pair[0]]).argmax())
        others = [axis for axis in range(3) if axis != along]
        gain = 0.3 * apart(body, pair)
        assert np.abs(was[:, others] - now[:, others]).max() < 0.1 * gain
