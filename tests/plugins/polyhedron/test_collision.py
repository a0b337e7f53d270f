"""Laws of bodies that meet: what stands stands, nothing passes through, nothing gains energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from bozzetto_polyhedron.mechanism.assembly import GROUND, spherical
from bozzetto_polyhedron.mechanism.collision import Placed, gap_between, touch_within
from bozzetto_polyhedron.mechanism.convex_parts import MOST_CORNERS, convex_parts, polytope_of
from bozzetto_polyhedron.mechanism.stepper import Pull, Stepper
from bozzetto_polyhedron.mechanism.touches import jointed, lying_in_one_another
from tests.plugins.polyhedron.solid_pieces import box, chair, dropped, mesh_of, random_polytope

FRAME = 1.0 / 60.0


def volume(corners: np.ndarray) -> float:
    return float(Manifold.hull_points(corners).volume())


@pytest.mark.parametrize(
    ("body", "most"),
    [
        (box((40, 30, 20)), 1),
        (chair(), 8),
        (box((30, 30, 10)) - box((10, 10, 20)), 4),
        (Manifold.cylinder(20, 8, 8, 24), 1),
    ],
)
def test_convex_parts_fill_a_body_and_nothing_else(body, most):
    parts = convex_parts(mesh_of(body))
    assert len(parts) <= most
    assert sum(volume(part.corners) for part in parts) == pytest.approx(body.volume(), rel=3e-3)
    for part in parts:
        heights = part.corners @ part.normals.T - part.offsets
        assert heights.max() < 1e-5
        for ring, normal in zip(part.rings, part.normals, strict=True):
            corners = part.corners[list(ring)]
            spin = np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0])
            assert spin.sum(axis=0) @ normal > 0.0


def test_round_parts_are_bounded_and_flat_ones_are_none():
    (ball,) = convex_parts(mesh_of(Manifold.sphere(20, 64)))
    assert len(ball.corners) <= MOST_CORNERS
    assert volume(ball.corners) > 0.85 * Manifold.sphere(20, 64).volume()
    assert polytope_of(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])) is None


def separable(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether a plane lies between two sets of points, by a linear programme."""
    rows = np.vstack((np.c_[one, np.ones(len(one))], -np.c_[other, np.ones(len(other))]))
    found = linprog(np.zeros(4), rows, -np.ones(len(rows)), bounds=(None, None))
    return bool(found.status == 0)


def still(part, place=(0.0, 0.0, 0.0), turn=None, velocity=(0.0, 0.0, 0.0)) -> Placed:
    turn = np.eye(3) if turn is None else turn
    return Placed(part, np.array(place, float), turn, np.array(velocity, float), np.zeros(3))


@pytest.mark.parametrize("seed", range(4))
def test_polytopes_overlap_where_no_plane_lies_between_them(seed):
    rng = np.random.default_rng((9100, seed))
    seen = set()
    for _ in range(12):
        one, other = still(random_polytope(rng)), random_polytope(rng)
        turn = Rotation.random(random_state=rng).as_matrix()
        second = still(other, rng.normal(size=3) * 0.06, turn)
        apart = separable(one.corners, second.corners)
        assert (gap_between(one, second) >= 0.0) == apart
        seen.add(apart)
    assert seen == {True, False}


@pytest.mark.parametrize("seed", range(4))
def test_a_meeting_is_foreseen_and_a_miss_is_none(seed):
    """Judged by small steps of the same flight."""
    rng = np.random.default_rng((9200, seed))
    for _ in range(4):
        one = still(random_polytope(rng))
        turn = Rotation.random(random_state=rng).as_matrix()
        start = rng.normal(size=3)
        start *= 0.25 / np.linalg.norm(start)
        velocity = (rng.normal(size=3) * 0.06 - start) * 30.0
        second = still(random_polytope(rng), start, turn, velocity)
        flight = [gap_between(one, second.later(t)) for t in np.linspace(0.0, 0.06, 400)]
        touch = touch_within(one, second, 0.06, 1e-5)
        if min(flight) < -1e-3:
            assert touch is not None
            gaps = (touch.on_second - touch.on_first) @ touch.normal
            assert (gaps > 0.0).all()
            assert (gaps < -(velocity @ touch.normal) * 0.06).all()
        elif min(flight) >= 0.0:
            assert touch is None


def test_a_box_on_a_box_touches_in_four_places_and_slides_off_a_corner():
    part = polytope_of(np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1.0)]))
    touch = touch_within(still(part), still(part, (0.5, 0.3, 2.0)), 0.0, 1e-6)
    assert touch.normal == pytest.approx([0.0, 0.0, 1.0])
    low, high = np.sort(touch.on_first[:, :2], axis=0)[[0, -1]]
    assert len(touch.on_first) == 4
    assert (low, high) == (pytest.approx([-0.5, -0.7]), pytest.approx([1.0, 1.0]))
    beside = still(part, (2.01, 0.0, 2.5), velocity=(0.0, 0.0, -10.0))
    assert touch_within(still(part), beside, 0.2, 1e-6) is None


def test_a_stack_of_two_boxes_stands():
    size = (100, 60, 40)
    assembly, motion = dropped([box(size), box(size)], [(0, 0, 0.021), (0.02, 0.01, 0.08)])
    stepper = Stepper(assembly)
    for _ in range(120):
        motion = stepper.advanced(motion, FRAME)
    assert motion.places == pytest.approx(np.array([[0, 0, 0.02], [0.02, 0.01, 0.06]]), abs=2e-5)
    assert np.abs(motion.velocities).max() < 1e-6
    assert np.abs(motion.turns - np.eye(3)).max() < 1e-5


def test_what_stands_over_the_edge_by_more_than_half_falls():
    size = (100, 60, 40)
    assembly, motion = dropped([box(size), box(size)], [(0, 0, 0.02), (0.06, 0, 0.06)])
    stepper = Stepper(assembly)
    for _ in range(90):
        motion = stepper.advanced(motion, FRAME)
    assert motion.places[1, 2] < 0.055
    assert depths(stepper, motion) < 2e-4


def depths(stepper: Stepper, motion) -> float:
    """Return how deep bodies lie in one another, m."""
    colliding = stepper.assembly.colliding
    placed = [
        still(part, motion.places[body], motion.turns[body])
        for body, part in zip(colliding.bodies, colliding.parts, strict=True)
    ]
    pairs = [
        (a, b)
        for k, (a, one) in enumerate(zip(placed, colliding.bodies, strict=True))
        for b, other in zip(placed[:k], colliding.bodies[:k], strict=True)
        if one != other
    ]
    return max(0.0, -min(gap_between(a, b) for a, b in pairs))


def test_a_dropped_chair_stands_on_its_legs_and_carries_a_box():
    turn = Rotation.from_euler("xyz", (0.1, -0.12, 0.4)).as_matrix()
    bodies = [chair(), box((20, 20, 20))]
    assembly, motion = dropped(
        bodies, [(0, 0, 0.05), (0.004, 0.0, 0.11)], [turn, np.eye(3)], friction=0.6
    )
    stepper = Stepper(assembly)
    for _ in range(150):
        motion = stepper.advanced(motion, FRAME)
    assert motion.turns[0, 2, 2] > 1.0 - 1e-6
    assert np.abs(motion.velocities).max() < 1e-4
    assert motion.places[1, 2] == pytest.approx(0.044 + 0.010, abs=2e-4)


@pytest.mark.parametrize("speed", [2.0, 10.0])
@pytest.mark.parametrize("seed", range(2))
def test_nothing_passes_through_a_thin_plate(speed, seed):
    rng = np.random.default_rng((9300, seed))
    turn = Rotation.random(random_state=rng).as_matrix()
    assembly, motion = dropped(
        [box((20, 16, 12)), box((2, 400, 400))],
        [(-0.3, 0.03, 0.02), (0, 0, 0)],
        [turn, np.eye(3)],
        ground=False,
    )
    assembly = replace(assembly, gravity=np.zeros(3))
    motion = replace(motion, velocities=np.array([[speed, 0, 0], [0, 0, 0.0]]))
    stepper, before = Stepper(assembly), -np.inf
    momentum = assembly.masses @ motion.velocities
    energies = [stepper.energy(motion)]
    for _ in range(30):
        motion = stepper.advanced(motion, FRAME)
        energies.append(stepper.energy(motion))
        way = motion.turns[1].T @ (motion.places[0] - motion.places[1])
        before = max(before, float(way[0]))
    assert before < 0.0
    assert assembly.masses @ motion.velocities == pytest.approx(momentum, rel=1e-9, abs=1e-12)
    assert max(np.diff(energies)) < 2e-3 * energies[0]
    assert motion.velocities[1, 0] > 0.0


def test_a_pen_that_jerks_at_10_metres_a_second_pulls_nothing_through_a_wall():
    assembly, motion = dropped(
        [box((20, 20, 20)), box((4, 300, 300))], [(-0.1, 0, 0.0), (0, 0, 0)], ground=False
    )
    wall = np.array([[0, 0.1, 0.1], [0, -0.1, 0.1], [0, 0, -0.1]])
    joints = assembly.joints
    for place in wall:
        joints += spherical(motion, 1, GROUND, place)
    assembly = replace(assembly, joints=joints)
    stepper = Stepper(assembly, damping=1.0)
    mass = float(assembly.masses.sum())
    stiffness = mass * (2.0 * np.pi / 0.12) ** 2
    for frame in range(40):
        target = np.array([-0.1 + min(10.0 * frame * FRAME, 0.4), 0.0, 0.0])
        damping = 2.0 * np.sqrt(stiffness * mass)
        pull = Pull(0, np.zeros(3), target, stiffness, damping, 8.0 * mass * 9.81)
        motion = stepper.advanced(motion, FRAME, pull)
        assert motion.places[0, 0] < -0.0119
    assert motion.places[0, 0] == pytest.approx(-0.012, abs=1e-4)
    assert np.abs(motion.places[1]).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_heap_comes_to_rest_without_gaining_energy(seed):
    rng = np.random.default_rng((9400, seed))
    sizes = rng.uniform(20, 50, (5, 3))
    places = [(*rng.uniform(-0.01, 0.01, 2), 0.05 + 0.06 * k) for k in range(5)]
    turns = Rotation.random(5, random_state=rng).as_matrix()
    assembly, motion = dropped([box(size) for size in sizes], places, turns)
    stepper = Stepper(assembly, damping=1.0)
    energies, deepest = [stepper.energy(motion)], 0.0
    for frame in range(150):
        motion = stepper.advanced(motion, FRAME)
        energies.append(stepper.energy(motion))
        if frame % 10 == 0:
            deepest = max(deepest, depths(stepper, motion))
    assert max(np.diff(energies)) < 2e-3 * energies[0]
    assert deepest < 2e-3
    assert np.abs(motion.velocities).max() < 0.02


def test_bodies_at_a_joint_and_those_drawn_in_one_another_pass():
    size = (40, 40, 40)
    places = [(0, 0, 0.02), (0.02, 0, 0.02), (0.0601, 0, 0.02)]
    assembly, motion = dropped([box(size)] * 3, places)
    assert lying_in_one_another(assembly.colliding, motion) == {(0, 1)}
    joints = spherical(motion, 2, 1, np.array([0.04, 0, 0])) + spherical(
        motion, 0, GROUND, np.zeros(3)
    )
    assert jointed(joints) == {(1, 2)}
