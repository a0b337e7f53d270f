"""Motors against closed forms: curves of angles and places, and where they begin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from bozzetto.cli.main import main
from bozzetto.document.history import History
from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.errors import UserError
from bozzetto.parameters import set_parameters
from bozzetto.plugin import Context, Ink
from bozzetto.plugin.host.registry import Registry
from bozzetto_polyhedron.commands.motion import at_rest
from bozzetto_polyhedron.mechanism.drives import JOINING, Drive, Keyed, Swing
from bozzetto_polyhedron.model.fittings import Crank, Hinge, Slider
from bozzetto_polyhedron.model.motor_curves import typed_keys, written_keys
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.solve.recording import at_time, recorded_times
from bozzetto_polyhedron.tools.fittings import DrawSlider
from tests.plugins.polyhedron.figures_open_boxes import lidded_box
from tests.plugins.polyhedron.linkages import (
    FOUR_BAR,
    FOUR_BAR_LINES,
    linkage,
    played,
    straight,
    with_motor,
)
from tests.plugins.polyhedron.test_folds import folds, hinged, read

CRANK = {"a": (400.0, 600.0), "b": (470.0, 530.0), "c": (760.0, 600.0)}

values = st.floats(-400.0, 400.0)
steps = st.floats(0.05, 3.0)


def keyed(gaps, heights, again: bool) -> Keyed:
    times = np.concatenate(([0.0], np.cumsum(gaps)))
    return Keyed(tuple(zip(times.tolist(), heights[: len(times)], strict=True)), again)


@settings(max_examples=60, deadline=None)
@given(st.lists(steps, min_size=1, max_size=6), st.lists(values, min_size=7, max_size=7))
@pytest.mark.parametrize("again", [True, False])
def test_a_curve_is_never_beyond_its_keys_and_meets_them(again, gaps, heights):
    course = keyed(gaps, heights, again)
    for (begin, one), (end, other) in zip(course.keys, course.keys[1:], strict=False):
        assert course.at(begin) == pytest.approx(one, abs=1e-9)
        between = [course.at(time) for time in np.linspace(begin, end, 30, endpoint=False)]
        assert min(one, other) - 1e-9 <= min(between)
        assert max(between) <= max(one, other) + 1e-9


@pytest.mark.parametrize("again", [True, False])
def test_rates_are_slopes_and_have_no_jumps(again):
    course = keyed([0.4, 1.0, 0.3, 0.8], [10.0, 50.0, 70.0, -20.0, 30.0], again)
    step = 1e-6
    for time in np.linspace(-1.0, 6.0, 701) + 0.0003:
        slope = (course.at(time + step) - course.at(time - step)) / (2.0 * step)
        assert course.rate(time) == pytest.approx(slope, abs=1e-3)
    for time, _ in (*course.keys, (course.keys[-1][0] + 0.4, 0.0)):
        assert course.rate(time - 1e-9) == pytest.approx(course.rate(time + 1e-9), abs=1e-3)


def test_between_inner_keys_it_is_the_curve_of_another_program():
    course = keyed([0.4, 1.0, 0.3, 0.8, 0.5], [10.0, 50.0, 70.0, -20.0, 30.0, 31.0], again=False)
    times, heights = np.array(course.keys).T
    other = PchipInterpolator(times, heights)
    for time in np.linspace(times[1], times[-2], 50):
        assert course.at(time) == pytest.approx(float(other(time)), abs=1e-9)


def test_what_begins_again_goes_on_from_its_last_value():
    course = Keyed(((0.0, 0.0), (1.0, 100.0), (2.0, 360.0)), again=True)
    assert course.at(5.0) == pytest.approx(820.0)
    assert course.at(-1.0) == pytest.approx(-260.0)
    once = replace(course, again=False)
    assert (once.at(5.0), once.at(-1.0)) == (360.0, 0.0)
    assert (once.rate(5.0), once.rate(-1.0)) == (0.0, 0.0)


def test_a_motor_comes_to_its_course_without_a_jump():
    drive = Drive(Swing(0.5, 3.0), since=2.0, offset=0.7)
    assert drive.at(2.0) == pytest.approx(0.7)
    assert drive.rate(2.0) == pytest.approx(1.5)
    late = 2.0 + JOINING
    assert drive.at(late) == pytest.approx(0.5 * np.sin(3.0 * JOINING))
    step = 1e-6
    for time in np.linspace(1.5, 3.5, 41) + 0.001:
        slope = (drive.at(time + step) - drive.at(time - step)) / (2.0 * step)
        assert drive.rate(time) == pytest.approx(slope, abs=1e-4)


# -- what is typed --


@pytest.mark.parametrize(
    "text", ["0: 0, 1: 90, 2: 0", "0:0;1:90;2:0", "0 s: 0°\n1 s: 90°\n2.0: 0.0", "0:0,1:9e1,2:-0,"]
)
def test_rows_are_read_as_they_are_typed(text):
    assert typed_keys(text) == ((0.0, 0.0), (1.0, 90.0), (2.0, 0.0))
    assert typed_keys(written_keys(typed_keys(text))) == typed_keys(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "2 to"),
        ("0: 0", "2 to"),
        ("0: 0, 1; 2", "no time with its value"),
        ("0: 0, 1: nan", "no time with its value"),
        ("0: 0, 1: inf", "no time with its value"),
        ("0: 0, 2: 1, 1: 3", "order of time"),
        ("0: 0, 0: 5", "order of time"),
        ("-1: 0, 1: 5", "from 0 to"),
        ("0: 0, 1e9: 5", "from 0 to"),
        ("0: 0, 1: 1e9", "at most"),
        (", ".join(f"{k}: {k}" for k in range(100)), "2 to"),
    ],
)
@pytest.mark.parametrize("kind", [Crank, Hinge, Slider])
def test_what_is_no_curve_is_refused_with_what_to_write(kind, text, said):
    with pytest.raises(UserError, match=said):
        set_parameters(kind(id="m"), {"curve": text})


# -- motions --


def four_bar(**how):
    state = linkage(FOUR_BAR, FOUR_BAR_LINES, held="ad")
    return with_motor(state, FOUR_BAR["a"], FOUR_BAR["b"], **how)


def angle(state) -> float:
    """Return by how much the driven bar or plate is turned against the other one, °."""
    made = moving(state)
    joints = made.machine.assembly.joints
    ((row, _),) = joints.drives
    turns = np.concatenate((made.motion(state.moved).turns, np.eye(3)[None]))
    turn = turns[joints.second[row]].T @ turns[joints.first[row]]
    axis = joints.direction[row]
    skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return float(np.degrees(np.arctan2(0.5 * skew @ axis, 0.5 * (np.trace(turn) - 1.0))))


def shift(state) -> float:
    """Return how far the guided corner of the crank has slid, mm."""
    made = moving(state)
    shape = made.machine.shapes[0]
    corner = int(np.argmax(shape.vertices[:, 0]))
    now = made.machine.moved(0, made.motion(state.moved))
    return float((now - shape.vertices)[corner, 0])


def piston(**how):
    """Return a bar whose end slides, and one that it turns."""
    state = linkage(CRANK, ("ab", "bc"), held="a")
    begin = np.array(CRANK["c"])
    state = DrawSlider().draw(
        state, Ink((straight(begin, begin + np.array([60.0, 0.0])),)), Context()
    )
    (slider,) = state.of_kind(Slider)
    return state.with_node(replace(slider, **how))


CURVE = {"drive": "curve", "curve": "0: 0, 0.5: 40, 1.2: -20, 1.5: 0"}


def expected(time: float, again: bool = True) -> float:
    return Keyed(typed_keys(CURVE["curve"]), again).at(time)


def test_a_crank_follows_its_curve():
    state = four_bar(**CURVE)
    for _ in range(20):
        state = played(state, 0.1)
        wanted = expected(state.moved.seconds)
        assert angle(state) == pytest.approx(wanted, abs=1e-3)
    assert moving(state).stepper.largest_gap(moving(state).motion(state.moved)) < 1e-6


def test_a_curve_that_happens_once_stays():
    state = played(four_bar(**CURVE | {"curve": "0: 0, 0.4: 25", "repeats": "once"}), 1.0)
    assert angle(state) == pytest.approx(25.0, abs=1e-3)
    assert np.abs(state.moved.velocities).max() < 1e-6


def test_a_slider_is_pushed_along_its_line():
    state = piston(**CURVE | {"curve": "0: 0, 0.5: -12, 1: 8, 1.5: 0"})
    course = Keyed(typed_keys("0: 0, 0.5: -12, 1: 8, 1.5: 0"), again=True)
    for _ in range(20):
        state = played(state, 0.1)
        assert shift(state) == pytest.approx(course.at(state.moved.seconds), abs=1e-3)
    swung = played(piston(drive="swing", travel=-9.0, period=1.0), 0.25)
    assert shift(swung) == pytest.approx(-9.0, abs=1e-3)


def test_a_place_that_lengths_do_not_reach_is_told():
    state = piston(drive="curve", curve="0: 0, 0.5: 200")
    with pytest.raises(UserError, match="motor is stuck"):
        played(state, 1.0)


def test_the_end_is_the_same_at_30_and_120_frames():
    ends = [played(piston(drive="swing", travel=9.0), 1.9, rate).moved.places for rate in (30, 120)]
    extent = np.linalg.norm(np.ptp(ends[0], axis=0))
    assert np.abs(ends[0] - ends[1]).max() < 0.01 * extent


def test_what_a_motor_does_is_the_same_each_time_and_in_any_order():
    state = four_bar(**CURVE)
    one, again = (played(state, 0.7) for _ in range(2))
    assert np.array_equal(one.moved.places, again.moved.places)
    crank, body = state.of_kind(Crank)[0], state.nodes[0]
    turned = played(replace(state, nodes=(crank, body)), 0.7)
    assert np.abs(turned.moved.places - one.moved.places).max() < 1e-9


# -- where they begin --


def largest_step(states) -> float:
    """Return the largest turn between two frames, °."""
    angles = np.unwrap(np.radians([angle(each) for each in states]))
    return float(np.degrees(np.abs(np.diff(angles)).max()))


@pytest.mark.parametrize(
    "how",
    [
        {"drive": "steady", "speed": -60.0},
        {"drive": "swing", "angle": 30.0, "period": 2.0},
        {"drive": "curve", "curve": "0: 0, 1: 30, 2: 0"},
        {"drive": "curve", "curve": "0: 50, 1: 20, 2: 50"},
    ],
)
def test_a_motor_on_a_lid_that_was_moved_takes_it_from_where_it_is(how):
    """It turned by 80° within the first frame."""
    state = read(lidded_box(80_100))
    (fold,) = folds(state)
    state = hinged(state, fold)
    (hinge,) = state.of_kind(Hinge)
    lifted = state.with_node(replace(hinge, drive="curve", curve="0: 0, 1: 80", repeats="once"))
    lifted = played(lifted, 1.2)
    assert abs(angle(lifted)) == pytest.approx(80.0, abs=0.01)
    (hinge,) = lifted.of_kind(Hinge)
    state = lifted.with_node(replace(hinge, repeats="again", **how))
    seen = [lifted]
    for _ in range(90):
        seen.append(played(seen[-1] if len(seen) > 1 else state, 1 / 60))
    assert largest_step(seen) < 4.0
    assert state.selected == seen[-1].selected
    if how["drive"] == "curve":
        late = seen[-1].moved.seconds - seen[-1].of_kind(Hinge)[0].since
        wanted = Keyed(typed_keys(how["curve"]), again=True).at(late)
        assert angle(seen[-1]) == pytest.approx(wanted, abs=0.01)
    if how["drive"] == "steady":
        assert angle(seen[-1]) - angle(lifted) == pytest.approx(-90.0, abs=0.1)
    rest = at_rest(seen[-1], Context()).of_kind(Hinge)[0]
    assert (rest.since, rest.offset) == (0.0, 0.0)


def test_a_speed_that_is_changed_while_it_turns_makes_no_jump():
    state = played(four_bar(speed=90.0), 1.0)
    (crank,) = state.of_kind(Crank)
    faster = state.with_node(replace(crank, speed=-45.0))
    assert angle(played(faster, 1 / 60)) == pytest.approx(angle(state) - 0.75, abs=1e-3)
    assert angle(played(faster, 1.0)) == pytest.approx(angle(state) - 45.0, abs=1e-3)


def test_a_replay_that_was_stopped_goes_on_from_there():
    state = played(four_bar(drive="swing", angle=20.0, period=2.0), 1.3)
    back = at_time(state, 0.4)
    assert len(recorded_times(state)) > 10
    onward = played(back, 0.1)
    assert angle(onward) == pytest.approx(20.0 * np.sin(np.pi * 0.5), abs=1e-3)


def test_what_a_motor_does_is_saved_undone_and_made_a_film(tmp_path):
    state = played(four_bar(**CURVE), 0.6)
    (crank,) = state.of_kind(Crank)
    begun = played(state.with_node(replace(crank, drive="steady", speed=30.0)), 0.3)
    model = Model("m1", "Linkage", PolyhedronModeler.id, begun, state_version=2)
    history = History(Document((model,)))
    history.apply("Play", Document((replace(model, state=played(begun, 0.2)),)))
    (before,) = history.undo()
    assert before.state.of_kind(Crank) == begun.of_kind(Crank)
    assert before.state.moved.seconds == begun.moved.seconds
    path = tmp_path / "four.bozz"
    write_document(Document((model,)), path)
    (again,) = read_document(path, Registry())[0]
    assert again.state.of_kind(Crank) == begun.of_kind(Crank)
    assert np.array_equal(played(again.state, 0.4).moved.places, played(begun, 0.4).moved.places)
    film = tmp_path / "film.glb"
    assert main(["simulate", str(path), "-o", str(film), "--seconds", "0.3", "--rate", "10"]) == 0
    assert film.read_bytes()[:4] == b"glTF"
