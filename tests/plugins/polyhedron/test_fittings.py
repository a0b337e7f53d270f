"""Linkages drawn with the pen: bars, links, springs, guides, motors and traces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.arrays import frozen
from bozzetto.errors import UserError
from bozzetto.plugin import Context, Ink, Job
from bozzetto_polyhedron.commands.motion import swing
from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.model.fittings import Coil, Link, Trace
from bozzetto_polyhedron.model.state import Recording
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.solve.paths import path_of
from bozzetto_polyhedron.solve.recording import MOST_POSES
from bozzetto_polyhedron.tools.fittings import (
    DrawCrank,
    DrawHinge,
    DrawLink,
    DrawSlider,
    DrawSpring,
)
from bozzetto_polyhedron.tools.move import Move
from tests.plugins.polyhedron.linkages import (
    FOUR_BAR,
    FOUR_BAR_LINES,
    linkage,
    places,
    played,
    straight,
    traced,
    with_motor,
)

MODELER = PolyhedronModeler()


def four_bar(**how: object):
    state = linkage(FOUR_BAR, FOUR_BAR_LINES, held="ad")
    return with_motor(state, FOUR_BAR["a"], FOUR_BAR["b"], **how) if how else state


def freedoms(state) -> int:
    machine = moving(state).machine
    return mobility_of(machine.assembly, machine.rest).degrees


def test_a_four_bar_has_one_freedom_and_its_motor_takes_it():
    assert freedoms(four_bar()) == 1
    assert freedoms(four_bar(speed=90.0)) == 0


def test_a_motor_turns_by_its_angle_and_the_bars_keep_their_lengths():
    state = played(four_bar(speed=90.0), 1.0)
    now = places(state, FOUR_BAR)
    crank = np.array(FOUR_BAR["b"]) - FOUR_BAR["a"]
    turned = now["b"] - now["a"]
    cosine = crank @ turned / np.linalg.norm(crank) ** 2
    assert cosine == pytest.approx(0.0, abs=1e-4)
    for one, other in FOUR_BAR_LINES:
        drawn = np.linalg.norm(np.subtract(FOUR_BAR[one], FOUR_BAR[other]))
        assert np.linalg.norm(now[one] - now[other]) == pytest.approx(drawn, rel=1e-4)


def test_what_swings_comes_back_after_its_period():
    state = four_bar(drive="swing", angle=40.0, period=0.5)
    away = places(played(state, 0.125), FOUR_BAR)["c"]
    again = places(played(state, 0.5), FOUR_BAR)["c"]
    rest = places(state, FOUR_BAR)["c"]
    assert np.linalg.norm(away - rest) > 5.0
    assert again == pytest.approx(rest, abs=0.01)


def test_a_motor_that_cannot_go_round_says_so_and_nothing_tears():
    corners = {**FOUR_BAR, "b": (450, 480)}
    state = with_motor(linkage(corners, FOUR_BAR_LINES, held="ad"), corners["a"], corners["b"])
    with pytest.raises(UserError, match="stuck"):
        state = played(state, 4.0)
    made = moving(state)
    assert made.stepper.largest_gap(made.motion(state.moved)) < 1e-3


def test_a_trace_is_where_the_corner_was():
    state = played(traced(four_bar(speed=360.0), FOUR_BAR["c"]), 1.0)
    (trace,) = state.of_kind(Trace)
    path = path_of(trace, state, moving(state))
    assert len(path) == 61  # with where it began
    rocker = np.linalg.norm(path - moving(state).machine.shapes[0].vertices[-1], axis=1)
    assert np.ptp(rocker) < 1e-4 * rocker.mean()
    assert np.linalg.norm(path[-1] - path[0]) < 0.1 * np.ptp(path[:, 0])
    (curve,) = MODELER.curves(state, MODELER.solve(state, Job()))
    assert curve.control_points == pytest.approx(path)


def test_links_come_and_go_while_it_moves():
    state = linkage(FOUR_BAR, FOUR_BAR_LINES, held="a")
    state = replace(state, gravity=True, damping=0.0)
    state = played(state, 0.2)
    before = places(state, FOUR_BAR)
    apart = np.linalg.norm(before["d"] - before["b"])
    linked = DrawLink().draw(state, Ink((straight(before["b"], before["d"]),)), Context())
    (link,) = linked.of_kind(Link)
    after = places(played(linked, 0.3), FOUR_BAR)
    assert np.linalg.norm(after["d"] - after["b"]) == pytest.approx(apart, rel=1e-3)
    free = places(played(linked.without_nodes(link.id), 0.3), FOUR_BAR)
    assert abs(np.linalg.norm(free["d"] - free["b"]) - apart) > 1.0


def test_a_hanging_weight_stretches_its_spring_as_hooke_says():
    """One bar on two springs, straight down: each carries half the weight."""
    corners = {"a": (400, 500), "b": (700, 500)}
    state = linkage(corners, ("ab",))
    state = replace(state, gravity=True, damping=8.0)
    for x, _ in corners.values():
        state = DrawSpring().draw(state, Ink((straight((x, 500), (x, 300)),)), Context())
    first, _ = springs = state.of_kind(Coil)
    for spring in springs:
        state = state.with_node(replace(spring, stiffness=4.0))
    mass = moving(state).machine.assembly.masses.sum()
    sunk = places(played(state, 2.5), corners)
    expected = 0.5 * mass * 9.81 / 4.0 * 1e3
    px = 900.0 / 2.0 / (500.0 * np.tan(np.radians(35.0 / 2.0)))
    assert sunk["a"][1] - 500.0 == pytest.approx(px * expected, rel=0.03)
    assert first.length == pytest.approx(200.0 / px, rel=0.01)


def test_a_guided_corner_stays_on_its_line():
    corners = {"a": (400, 600), "b": (430, 540), "c": (700, 600)}
    state = linkage(corners, ("ab", "bc"), held="a")
    state = DrawSlider().draw(state, Ink((straight(corners["c"], (800, 600)),)), Context())
    state = with_motor(state, corners["a"], corners["b"], speed=360.0)
    assert freedoms(state) == 0
    reached = [places(played(state, share), corners)["c"] for share in (0.25, 0.5, 0.75)]
    crank = np.linalg.norm(np.subtract(corners["b"], corners["a"]))
    assert np.array(reached)[:, 1] == pytest.approx(np.full(3, 600.0), abs=0.01)
    assert np.ptp(np.array(reached)[:, 0]) > crank


def test_what_makes_no_sense_is_refused_with_what_to_do():
    state = four_bar()
    with pytest.raises(UserError, match="no corner at either end"):
        DrawLink().draw(state, Ink((straight((50, 50), (90, 90)),)), Context())
    with pytest.raises(UserError, match="no bar between"):
        DrawCrank().draw(state, Ink((straight(FOUR_BAR["a"], FOUR_BAR["c"]),)), Context())
    with pytest.raises(UserError, match="Back to rest"):
        DrawHinge().draw(
            played(state, 0.1), Ink((straight(FOUR_BAR["a"], FOUR_BAR["b"]),)), Context()
        )
    with pytest.raises(UserError, match="nothing to join"):
        DrawLink().draw(MODELER.create(Context()), Ink((straight((0, 0), (9, 9)),)), Context())


def test_the_eraser_takes_links_and_what_hangs_on_a_body():
    state = DrawLink().draw(
        four_bar(speed=90.0), Ink((straight(FOUR_BAR["b"], FOUR_BAR["d"]),)), Context()
    )
    tool = DrawLink()
    less = tool.erase(state, Ink((straight(FOUR_BAR["b"], FOUR_BAR["d"]),)), Context())
    assert not less.of_kind(Link)
    for line in FOUR_BAR_LINES:
        ends = FOUR_BAR[line[0]], FOUR_BAR[line[1]]
        less = tool.erase(less, Ink((straight(*ends),)), Context())
    assert less.nodes == ()


def test_what_is_free_is_told_and_swings_when_asked():
    state = four_bar()
    assert "can move in 1 way." in Move().next_step(state).sentence
    pushed = swing(state, Context())
    before, after = places(state, FOUR_BAR), places(played(pushed, 0.2), FOUR_BAR)
    assert np.linalg.norm(after["b"] - before["b"]) > 1.0
    assert after["a"] == pytest.approx(before["a"], abs=1e-3)
    driven = four_bar(speed=90.0)
    assert "motor" in Move().next_step(driven).sentence
    with pytest.raises(UserError, match="Nothing is free"):
        swing(driven, Context())


def test_each_swing_is_another_one_until_all_were_seen():
    state = linkage({"a": (400, 500), "b": (500, 400), "c": (600, 500)}, ("ab", "bc"), held="a")
    seen = []
    for _ in range(3):
        state = swing(state, Context())
        seen.append(state.moved.velocities / np.linalg.norm(state.moved.velocities))
    assert abs(float((seen[0] * seen[1]).sum())) < 0.9
    assert abs(float((seen[0] * seen[2]).sum())) > 0.9


def test_a_motor_at_a_free_corner_turns_a_bar_against_its_neighbour():
    corners = {"a": (400, 500), "b": (600, 500), "c": (600, 400)}
    state = linkage(corners, ("ab", "bc"))
    state = with_motor(state, corners["b"], corners["c"], speed=90.0)
    now = places(played(state, 1.0), corners)
    long, short = now["a"] - now["b"], now["c"] - now["b"]
    assert abs(long @ short) == pytest.approx(
        np.linalg.norm(long) * np.linalg.norm(short), rel=1e-4
    )
    with pytest.raises(UserError, match="hangs free"):
        with_motor(linkage(corners, ("ab", "bc")), corners["c"], corners["b"])


def test_a_recording_that_is_full_is_said_and_grows_no_more():
    state = played(four_bar(speed=90.0), 0.05)
    kept, count = state.recorded, len(moving(state).machine.rest.places)
    many = MOST_POSES - len(kept.seconds)
    full = Recording(
        frozen(np.vstack((np.full((many, 1), -1.0), kept.seconds)), np.float64, 1),
        frozen(np.vstack((np.tile(kept.places[:count], (many, 1)), kept.places)), np.float64, 3),
        frozen(np.vstack((np.tile(kept.turns[: 3 * count], (many, 1)), kept.turns)), np.float64, 3),
    )
    state = played(replace(state, recorded=full), 0.05)
    assert len(state.recorded.seconds) == MOST_POSES
    said = [each.message for each in MODELER.cautions(state, MODELER.solve(state, Job()))]
    assert any("recording is full" in text for text in said)
