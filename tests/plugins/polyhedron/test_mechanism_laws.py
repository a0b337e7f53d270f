"""Laws of mechanisms: lengths, energy, closed forms, freedoms, forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.mechanism.assembly import (
    GROUND,
    Assembly,
    Motion,
    Springs,
    hinge,
    motor,
    no_joints,
)
from bozzetto_polyhedron.mechanism.drives import Drive, Steady
from bozzetto_polyhedron.mechanism.rotations import rotations_by
from bozzetto_polyhedron.mechanism.stepper import Pull, Stepper
from tests.plugins.polyhedron.mechanisms import (
    LENGTH,
    MASS,
    bars,
    four_bar,
    linkage,
    plates,
    tensions,
)

FRAME = 1.0 / 120.0


@pytest.mark.parametrize("seconds", [2.0, pytest.param(10.0, marks=pytest.mark.slow)])
def test_double_pendulum_keeps_its_energy(seconds):
    assembly, motion = plates(2)
    stepper = Stepper(assembly, tolerance=1e-10)
    start, fall = stepper.energy(motion), MASS * 9.81 * 2 * LENGTH
    shares = []
    for _ in range(int(seconds / FRAME)):
        motion = stepper.advanced(motion, FRAME)
        shares.append((stepper.energy(motion) - start) / fall)
    assert max(np.abs(shares)) < 0.06
    assert stepper.largest_gap(motion) < 1e-9


def test_coupler_point_follows_its_closed_form():
    start = 1.0
    assembly, motion = linkage(start)
    stepper = Stepper(assembly, tolerance=1e-13)
    motion = stepper.settled(
        replace(motion, momenta=np.array([[0, -0.005, 0], [0, 0, 0], [0, 0, 0]]))
    )
    place = motion.turns[1].T @ (four_bar(start)[2] - motion.places[1])
    turned, worst = 0.0, 0.0
    crank = four_bar(start)[0]
    for _ in range(240):
        motion = stepper.advanced(motion, FRAME)
        now = motion.turns[0] @ crank
        turn = np.arctan2(now[2], now[0])
        turned = max(turned, abs(turn - start))
        seen = motion.places[1] + motion.turns[1] @ place
        worst = max(worst, float(np.abs(seen - four_bar(turn)[2]).max()))
    assert turned > 3.0
    assert worst < 1e-9


def test_joints_hold_when_the_pen_jerks():
    assembly, motion = plates(5)
    stepper = Stepper(assembly, damping=0.5, tolerance=0.5e-4 * LENGTH)
    rng = np.random.default_rng(9001)
    target, worst = np.array([0.5, 0.0, 0.0]), 0.0
    for _ in range(40):
        target = target + rng.normal(size=3) / np.sqrt(3) * 10.0 / 60.0
        pull = Pull(4, np.array([LENGTH / 2, 0, 0]), target, 25.0, 0.4, 20 * 5 * MASS * 9.81)
        motion = stepper.advanced(motion, 1 / 60, pull)
        worst = max(worst, stepper.largest_gap(motion))
        assert np.isfinite(motion.places).all()
    assert worst < 1e-4 * LENGTH


@pytest.mark.parametrize("angle", [-2.0, -0.4, 0.9])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_what_the_pen_holds_beyond_reach_rests(count, angle):
    """It swung about there like a pendulum: what damps it was limited with the pull."""
    assembly, motion = plates(count)
    stepper, mass = Stepper(assembly, damping=1.0), count * MASS
    stiffness = mass * (2.0 * np.pi / 0.12) ** 2
    hold, begin = np.array([LENGTH / 2, 0.0, 0.0]), np.array([count * LENGTH, 0.0, 0.0])
    end = 3.0 * count * LENGTH * np.array([np.cos(angle), 0.0, np.sin(angle)])
    seen = []
    for frame in range(120):
        target = begin + min(1.0, frame / 12) * (end - begin)
        damping, limit = 2.0 * np.sqrt(stiffness * mass), 8.0 * mass * 9.81
        pull = Pull(count - 1, hold, target, stiffness, damping, limit)
        motion = stepper.advanced(motion, 1 / 60, pull)
        seen.append(motion.places[-1] + motion.turns[-1] @ hold)
    moved = np.linalg.norm(np.diff(seen, axis=0), axis=1)
    assert moved[-30:].max() < 1e-3 * LENGTH
    assert seen[-1] == pytest.approx(end / 3.0, abs=0.1 * count * LENGTH)


def test_a_person_sees_the_same_end_at_30_and_120_frames_a_second():
    ends = []
    for rate in (30, 120):
        assembly, motion = plates(4)
        stepper = Stepper(assembly, damping=1.0)
        for frame in range(rate):
            share = (frame + 1) / rate
            target = np.array([0.4 - 0.2 * share, 0.0, 0.15 * share])
            pull = Pull(3, np.array([LENGTH / 2, 0, 0]), target, 60.0, 1.0, 30.0)
            motion = stepper.advanced(motion, 1 / rate, pull)
        ends.append(motion.places)
    assert np.abs(ends[0] - ends[1]).max() < 0.01 * 4 * LENGTH


def test_free_body_keeps_its_angular_momentum():
    inertia = np.diag([1.0, 2.0, 3.5])
    assembly = Assembly(np.ones(1), inertia[None], gravity=np.zeros(3))
    momentum = np.array([[0.3, 4.0, 0.2]])
    motion = replace(Motion.at_rest(np.zeros((1, 3))), momenta=momentum)
    stepper = Stepper(assembly)
    energy = stepper.energy(motion)
    for _ in range(240):
        motion = stepper.advanced(motion, FRAME)
    assert motion.momenta == pytest.approx(momentum, abs=1e-12)
    assert stepper.energy(motion) == pytest.approx(energy, rel=1e-3)
    assert motion.turns[0] @ motion.turns[0].T == pytest.approx(np.eye(3), abs=1e-12)


def test_falling_body_follows_the_parabola():
    assembly = Assembly(np.ones(1), np.eye(3)[None])
    motion = replace(Motion.at_rest(np.zeros((1, 3))), velocities=np.array([[2.0, 0.0, 3.0]]))
    motion = Stepper(assembly).advanced(motion, 0.5)
    assert motion.places[0] == pytest.approx([1.0, 0.0, 1.5 - 0.5 * 9.81 * 0.25], abs=1e-12)


def test_mass_on_a_spring_swings_in_its_period():
    springs = Springs(
        np.array([0]), np.array([GROUND]), np.zeros((1, 3)), np.zeros((1, 3)),
        np.array([0.5]), np.array([40.0]),
    )  # fmt: skip
    assembly = Assembly(np.ones(1), np.zeros((1, 3, 3)), springs=springs, gravity=np.zeros(3))
    stepper, motion = Stepper(assembly), Motion.at_rest(np.array([[0.6, 0.0, 0.0]]))
    period = 2 * np.pi / np.sqrt(40.0)
    for _ in range(100):
        motion = stepper.advanced(motion, period / 100)
    assert motion.places[0] == pytest.approx([0.6, 0.0, 0.0], abs=2e-3)


def test_motor_turns_at_its_rate():
    motion = Motion.at_rest(np.array([[0.05, 0.0, 0.0]]))
    begin, end = np.zeros(3), np.array([0.0, 0.0, 0.1])
    joints = hinge(motion, 0, GROUND, begin, end)
    joints += motor(motion, 0, GROUND, end - begin, Drive(Steady(2.0)))
    assembly = Assembly(np.ones(1), 1e-3 * np.eye(3)[None], joints)
    motion = Stepper(assembly, tolerance=1e-10).advanced(motion, 1.25)
    angle = np.arctan2(motion.turns[0][1, 0], motion.turns[0][0, 0])
    assert angle == pytest.approx(2.5, abs=1e-8)


@pytest.mark.parametrize("count", [1, 4, 10])
def test_each_hinge_is_one_freedom(count):
    found = mobility_of(*plates(count))
    assert (found.degrees, found.redundant) == (count, 0)


def test_four_bar_has_one_freedom_and_a_triangle_none():
    assert mobility_of(*linkage(0.7)).degrees == 1
    corners = np.array([[0, 0, 0], [1, 0, 0], [0.4, 0, 0.8], [0.4, 0.9, 0.2]])
    pairs = [(a, b) for a in range(4) for b in range(a)]
    assembly, motion, _ = bars(corners, pairs, fixed=set())
    assert mobility_of(assembly, motion).degrees == 6
    doubled, motion, _ = bars(corners, [*pairs, (0, 1)], fixed=set())
    assert mobility_of(doubled, motion).redundant == 1


def test_truss_carries_its_load_as_the_method_of_joints_says():
    """A bracket of two bars: F cot(angle) in the level one, F / sin(angle) in the strut."""
    angle, load = np.radians(35.0), 120.0
    places = np.array([[0, 0, 0], [0, 0, -np.tan(angle)], [1.0, 0, 0]])
    assembly, motion, _ = bars(places, [(0, 2), (1, 2)], fixed={0, 1})
    assembly = replace(assembly, planar=np.array([0.0, 1.0, 0.0]))
    level, strut = tensions(assembly, motion, np.array([[0.0, 0.0, -load]]))
    assert level == pytest.approx(load / np.tan(angle), rel=1e-9)
    assert strut == pytest.approx(-load / np.sin(angle), rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_forces_balance_at_every_joint_of_a_random_truss(seed):
    rng = np.random.default_rng((31, seed))
    places = rng.normal(size=(9, 3))
    fixed = {0, 1, 2}
    pairs = [(k, j) for k in range(3, 9) for j in rng.choice(k, 3, replace=False)]
    assembly, motion, free = bars(places, pairs, fixed)
    loads = rng.normal(size=(len(free), 3))
    forces = tensions(assembly, motion, loads)
    for number, corner in enumerate(free):
        total = loads[number].copy()
        for (a, b), force in zip(pairs, forces, strict=True):
            if corner in (a, b):
                other = b if corner == a else a
                along = places[other] - places[corner]
                total += force * along / np.linalg.norm(along)
        assert np.abs(total).max() < 1e-6 * max(1.0, np.abs(forces).max())


def test_motion_turns_with_the_world():
    assembly, motion = plates(3)
    turn = rotations_by(np.array([[0.3, -0.5, 0.9]]))[0]
    turned = replace(
        assembly,
        gravity=turn @ assembly.gravity,
        joints=_turned(assembly, turn),
    )
    other = replace(motion, places=motion.places @ turn.T, turns=turn @ motion.turns)
    for _ in range(60):
        motion = Stepper(assembly, tolerance=1e-11).advanced(motion, FRAME)
        other = Stepper(turned, tolerance=1e-11).advanced(other, FRAME)
    assert other.places == pytest.approx(motion.places @ turn.T, abs=1e-7)


def test_nothing_and_a_torn_assembly_stay_finite():
    empty = Assembly(np.zeros(0), np.zeros((0, 3, 3)))
    assert len(Stepper(empty).advanced(Motion.at_rest(np.zeros((0, 3))), 0.02).places) == 0
    assembly, motion = plates(3)
    torn = replace(motion, places=motion.places + np.diag([0.0, 9.0, 5.0]))
    end = Stepper(assembly).advanced(torn, 0.02)
    assert np.isfinite(end.places).all()
    assert (end.velocities == 0.0).all()


def test_the_same_steps_give_the_same_motion():
    assembly, motion = plates(4)
    ends = [Stepper(assembly).advanced(motion, 0.3).places for _ in range(2)]
    assert (ends[0] == ends[1]).all()


def _turned(assembly: Assembly, turn: np.ndarray):
    joints = assembly.joints
    grounded = (joints.second == GROUND)[:, None]
    return replace(
        joints,
        second_point=np.where(grounded, joints.second_point @ turn.T, joints.second_point),
        direction=np.where(grounded, joints.direction @ turn.T, joints.direction),
    )


def test_no_joints_is_the_neutral_sum():
    joints = plates(2)[0].joints
    assert len(no_joints() + joints) == len(joints)
