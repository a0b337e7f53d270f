"""Laws of contact: what falls comes to rest, slides as far as Coulomb says, and gains nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.mechanism.contact import contact_impulses, in_cones, least_impulses
from bozzetto_polyhedron.mechanism.rotations import rotations_by
from bozzetto_polyhedron.mechanism.stepper import Stepper
from tests.plugins.polyhedron.known_linkages import walking
from tests.plugins.polyhedron.mechanisms import box_on_ground

FRAME = 1.0 / 120.0


def heights(stepper: Stepper, motion: Motion) -> np.ndarray:
    ground = stepper.assembly.ground
    arms = np.einsum("kij,kj->ki", motion.turns[ground.bodies], ground.points)
    return (motion.places[ground.bodies] + arms)[:, 2]


@pytest.mark.parametrize("turn", [(0.4, 0.7, 0.2), (0.0, 0.0, 0.0), (1.1, -0.3, 0.9)])
def test_a_dropped_box_comes_to_rest_on_a_face_and_gains_no_energy(turn):
    assembly, motion = box_on_ground(height=0.2, turn=turn)
    stepper = Stepper(assembly)
    energies, lowest = [stepper.energy(motion)], 0.0
    for _ in range(180):
        motion = stepper.advanced(motion, FRAME)
        energies.append(stepper.energy(motion))
        lowest = min(lowest, heights(stepper, motion).min())
    assert max(energies) <= energies[0] * (1.0 + 1e-9)
    assert max(np.diff(energies)) < 1e-3 * energies[0]
    assert lowest > -1e-5
    assert np.abs(motion.velocities).max() < 1e-4
    assert (np.abs(heights(stepper, motion)) < 1e-5).sum() == 4


@pytest.mark.parametrize("friction", [0.2, 0.5])
def test_a_box_slides_as_far_as_coulomb_says(friction):
    assembly, motion = box_on_ground(height=0.02, friction=friction)
    motion = replace(motion, velocities=np.array([[0.8, -0.6, 0.0]]))
    for _ in range(120):
        motion = Stepper(assembly).advanced(motion, FRAME)
    way = 1.0 / (2.0 * friction * 9.81)
    assert motion.places[0, :2] == pytest.approx([0.8 * way, -0.6 * way], rel=2e-3)


def test_a_box_on_a_leaning_ground_holds_below_the_angle_of_friction():
    """The ground is level; gravity leans: tan 20° < 0.5 < tan 30°."""
    for angle, holds in ((20.0, True), (30.0, False)):
        assembly, motion = box_on_ground(height=0.02, friction=0.5)
        lean = rotations_by(np.array([[0.0, np.radians(angle), 0.0]]))[0]
        stepper = Stepper(replace(assembly, gravity=lean @ assembly.gravity))
        for _ in range(60):
            motion = stepper.advanced(motion, FRAME)
        assert (np.hypot(*motion.places[0, :2]) < 1e-5) == holds


def test_impulses_do_not_depend_on_how_the_world_is_turned():
    rng = np.random.default_rng(9012)
    half = rng.normal(size=(12, 7))
    response, speeds = half @ half.T, rng.normal(size=(4, 3)) - [0.0, 0.0, 2.0]
    turn = rotations_by(np.array([[0.0, 0.0, 1.1]]))[0]
    every = np.kron(np.eye(4), turn)
    plain = contact_impulses(response, speeds, 0.4)
    turned = contact_impulses(every @ response @ every.T, speeds @ turn.T, 0.4)
    moved = speeds + (response @ plain.ravel()).reshape(-1, 3)
    again = speeds @ turn.T + (every @ response @ every.T @ turned.ravel()).reshape(-1, 3)
    assert again == pytest.approx(moved @ turn.T, abs=2e-2)


def test_cones_are_met_from_outside_and_left_alone_inside():
    rng = np.random.default_rng(9013)
    wild = rng.normal(size=(200, 3))
    made = in_cones(wild, 0.7)
    assert (np.hypot(made[:, 0], made[:, 1]) <= 0.7 * made[:, 2] + 1e-12).all()
    assert in_cones(made, 0.7) == pytest.approx(made, abs=1e-12)
    assert (((wild - made) * made).sum(axis=1)) == pytest.approx(np.zeros(200), abs=1e-12)


def walked(friction: float, rate: float) -> float:
    """Return how far the middle of all masses comes in a second, m."""
    assembly, motion = walking(friction, rate)
    stepper, share = Stepper(assembly, tolerance=1e-8), assembly.masses / assembly.masses.sum()
    begin = share @ motion.places
    for _ in range(40):
        motion = stepper.advanced(motion, 1.0 / 40.0)
    return float((share @ motion.places - begin)[0])


def test_a_walker_walks_by_friction_alone_and_turns_back_with_its_motor():
    forth, back = walked(0.8, -4.0), walked(0.8, 4.0)
    assert min(abs(forth), abs(back)) > 0.06
    assert forth * back < 0.0
    assert abs(walked(0.0, -4.0)) < 0.05 * abs(forth)


@pytest.mark.parametrize("seed", range(40))
def test_impulses_of_least_energy_leave_nothing_to_gain(seed):
    """Speeds lie in the dual cones and do no work, also where some places carry the same."""
    rng = np.random.default_rng(seed)
    count, friction = int(rng.integers(1, 9)), float(rng.uniform(0.05, 1.0))
    half = rng.normal(size=(3 * count, int(rng.integers(2, 3 * count + 1))))
    response = half @ half.T
    speeds = (half @ rng.normal(size=half.shape[1])).reshape(-1, 3)
    found = least_impulses(response, speeds, friction, np.zeros_like(speeds))
    after = speeds + (response @ found.ravel()).reshape(-1, 3)
    assert np.abs(in_cones(found, friction) - found).max() <= 1e-12 * (1.0 + np.abs(found).max())
    size = float(np.abs(speeds).max())
    assert (after[:, 2] - friction * np.hypot(after[:, 0], after[:, 1]) >= -1e-3 * size).all()
    assert abs(float((found * after).sum())) <= 1e-3 * size * float(np.abs(found).sum() + 1e-9)
