"""Linkages of the textbooks, drawn with the pen and as rods: their curves in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.mechanism.stepper import Stepper
from bozzetto_polyhedron.model.fittings import Pin, Trace
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.solve.paths import path_of
from bozzetto_polyhedron.view.fittings import seen_ends
from tests.plugins.polyhedron import known_linkages
from tests.plugins.polyhedron.linkages import SHEET, drawn, on_sheet, places, played, with_motor


def path(state) -> np.ndarray:
    """Return the trace of a state, px."""
    (trace,) = state.of_kind(Trace)
    return SHEET.project(path_of(trace, state, moving(state)))[0]


@pytest.mark.parametrize("name", ["four_bar", "peaucellier", "jansen", "scissor"])
def test_each_has_one_freedom_that_its_motor_takes(name):
    state, _ = drawn(getattr(known_linkages, name)())
    machine = moving(state).machine
    assert mobility_of(machine.assembly, machine.rest).degrees == 0
    free = moving(replace(state, nodes=state.nodes[:-2])).machine
    assert mobility_of(free.assembly, free.rest).degrees == 1


def test_peaucelliers_point_runs_on_a_straight_line_to_a_billionth_of_a_metre():
    known = known_linkages.peaucellier()
    assembly, motion, carriers = known_linkages.as_rods(known)
    stepper = Stepper(assembly, tolerance=1e-13)
    momenta = np.zeros_like(motion.momenta)
    momenta[known.bars.index("cp"), 1] = 3e-2
    motion = stepper.settled(replace(motion, momenta=momenta))
    rod, arm = carriers["q"]
    seen = []
    for _ in range(60):
        motion = stepper.advanced(motion, 1.0 / 120.0)
        seen.append(motion.places[rod] + motion.turns[rod] @ arm)
    across = np.array(seen)[:, 0] - known.corners["q"][0] / 1e3
    assert np.ptp(np.array(seen)[:, 2]) > 0.02
    assert np.abs(across).max() < 1e-9


def test_peaucelliers_point_is_drawn_straight_with_the_pen():
    state, corners = drawn(known_linkages.peaucellier())
    line = path(played(state, 1.0))
    assert np.ptp(line[:, 1]) > 100.0
    assert line[:, 0] == pytest.approx(np.full(len(line), corners["q"][0]), abs=1e-3)


def test_the_coupler_of_a_drawn_four_bar_follows_its_closed_form():
    known = known_linkages.four_bar()
    state, corners = drawn(known)
    scale = np.linalg.norm(np.subtract(corners["b"], corners["a"])) / 40.0
    seen = path(played(state, 2.0, rate=30))
    base = np.array([160.0, 0.0])
    closest = []
    for sign in (1.0, -1.0):
        angles = 1.1 + sign * np.pi * np.arange(61) / 30.0
        crank = 40.0 * np.column_stack((np.cos(angles), np.sin(angles)))
        elbow = np.array([known_linkages.meeting(each, 140.0, base, 100.0) for each in crank])
        along = (elbow - crank) / 140.0
        tip = crank + 90.0 * along + 70.0 * np.column_stack((-along[:, 1], along[:, 0]))
        there = np.array(corners["a"]) + tip * [scale, -scale]
        closest.append(np.abs(seen - there).max())
    assert min(closest) < 0.02


def test_jansens_foot_goes_level_over_the_ground_and_lifts():
    state, _ = drawn(known_linkages.jansen())
    foot = path(played(state, 2.0))
    height = foot[:, 1].max() - foot[:, 1]
    stride, lift = np.ptp(foot[:, 0]), height.max()
    assert 0.2 < lift / stride < 0.5
    assert (height < 0.03 * stride).mean() > 0.35


def test_a_scissor_lift_stays_level():
    state, corners = drawn(known_linkages.scissor())
    before = places(state, corners)
    now = places(played(state, 0.5), corners)
    for one, other in ("cd", "ef"):
        assert now[one][1] == pytest.approx(now[other][1], abs=0.05)
    assert abs(now["f"][1] - before["f"][1]) > 30.0
    assert now["b"][1] == pytest.approx(before["b"][1], abs=1e-3)


def test_bars_that_are_drawn_have_the_lengths_of_the_plan():
    known = known_linkages.jansen()
    state, corners = drawn(known)
    now = places(state, corners)
    assert all(np.abs(now[name] - corners[name]).max() < 0.01 for name in corners)
    assert len(state.of_kind(Body)) == 1
    assert on_sheet(known) == corners


def test_pins_stay_where_their_bars_cross():
    known = known_linkages.scissor()
    state, corners = drawn(known)
    end = played(state, 0.6)
    made, now = moving(end), places(end, corners)
    pins = [seen_ends(end, made, pin)[0] for pin in end.of_kind(Pin)]
    seen = SHEET.project(np.array(pins))[0]
    for pin, (one, other) in zip(seen, known.pins, strict=True):
        middle = np.mean([now[name] for name in one + other], axis=0)
        assert pin == pytest.approx(middle, abs=0.1)
    assert np.linalg.norm(now["f"] - corners["f"]) > 20.0


def test_every_joint_of_the_robot_arm_has_its_motor():
    known = known_linkages.robot_arm()
    state, corners = drawn(known)
    for bar, drive in known.more:
        state = with_motor(state, *(corners[name] for name in bar), **drive)
    machine = moving(state).machine
    assert mobility_of(machine.assembly, machine.rest).degrees == 0
    line = path(played(state, 2.0))
    assert np.ptp(line, axis=0).min() > 30.0


def test_what_has_no_pieces_has_no_freedoms() -> None:
    """As where all that moved was deleted, and only a spring or a trace is left."""
    machine = moving(PolyhedronState()).machine
    found = mobility_of(machine.assembly, machine.rest)
    assert (found.degrees, found.redundant, found.motions.shape) == (0, 0, (0, 0, 6))
