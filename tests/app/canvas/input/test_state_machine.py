from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from bozzetto_app.canvas.input.state_machine import (
    NEAR_TIME,
    PALM_TIME,
    TAP_TIME,
    TAP_TRAVEL,
    Button,
    GestureMachine,
    Keys,
    Mode,
    Motion,
    Outcome,
    Press,
)


def press(pointer="pen", button=Button.TIP, t=0.0, **more):
    return Press(pointer, button, 100.0, 100.0, t, **more)


@pytest.mark.parametrize(
    ("given_press", "mode"),
    [
        (press(), Mode.INKING),
        (press("mouse"), Mode.INKING),
        (press("touch"), Mode.NAVIGATING),
        (press(eraser=True), Mode.ERASING),
        (press(eraser=True, handle="h"), Mode.ERASING),
        (press(handle="h"), Mode.DRAGGING),
        (press(takes="tap"), Mode.TAPPING),
        (press(takes="drag", handle="h"), Mode.DRAGGING),
        (press(takes="drag"), Mode.TAPPING),
        (press(takes="tap", aims=True), Mode.AIMING),
        (press(takes="drag", aims=True), Mode.AIMING),
        (press(takes="drag", aims=True, handle="h"), Mode.DRAGGING),
        (press(takes="ink", aims=True), Mode.INKING),
        (press(button=Button.TURN), Mode.NAVIGATING),
        (press(button=Button.MENU), Mode.CHOOSING),
        (press(keys=Keys(alt=True)), Mode.NAVIGATING),
        (press(keys=Keys(space=True)), Mode.NAVIGATING),
        (press(keys=Keys(shift=True)), Mode.INKING),
        (press(keys=Keys(ctrl=True)), Mode.ERASING),
        (press("mouse", keys=Keys(ctrl=True)), Mode.ERASING),
        (press(keys=Keys(ctrl=True), handle="h"), Mode.DRAGGING),
        (press(keys=Keys(ctrl=True), takes="tap"), Mode.TAPPING),
        (press(keys=Keys(ctrl=True, alt=True)), Mode.NAVIGATING),
        (press(keys=Keys(alt=True), handle="h"), Mode.NAVIGATING),
    ],
)
def test_what_a_press_means(given_press, mode):
    machine = GestureMachine()
    assert machine.begin(given_press) is (mode is not Mode.IDLE)
    assert machine.mode is mode


def test_an_aimed_tap_is_where_it_lifts_after_any_time():
    machine = GestureMachine()
    machine.begin(press(takes="tap", aims=True))
    assert machine.place == (100.0, 100.0)
    machine.move(300.0, 40.0)
    machine.move(280.0, 50.0)
    assert machine.release("mouse", Button.TIP, 1.0) is Outcome.NOTHING
    assert machine.place == (280.0, 50.0)
    assert machine.release("pen", Button.TIP, 60.0) is Outcome.TAP
    assert machine.mode is Mode.IDLE


@pytest.mark.parametrize(
    ("aims", "travel", "lasted", "outcome"),
    [
        (True, 0.0, 60.0, Outcome.TAP),
        (True, 1.5, 60.0, Outcome.TAP),
        (True, 3.0, 0.2, Outcome.TAP),
        (True, 3.0, 1.0, Outcome.DROP),
        (True, 30.0, 0.1, Outcome.DROP),
        (False, 0.0, 0.1, Outcome.DROP),
    ],
)
def test_a_tap_on_a_handle_of_a_tool_that_aims_is_a_tap_and_a_drag_moves_it(
    aims, travel, lasted, outcome
):
    machine = GestureMachine()
    down = press(takes="drag", aims=aims, handle="h")
    machine.begin(down)
    machine.move(100.0 + travel, 100.0)
    machine.move(100.0, 100.0)
    assert machine.release("pen", Button.TIP, down.t + lasted) is outcome


@pytest.mark.parametrize(
    ("keys", "motion"),
    [
        (Keys(alt=True), Motion.ORBIT),
        (Keys(alt=True, shift=True), Motion.PAN),
        (Keys(space=True, ctrl=True), Motion.ZOOM),
    ],
)
def test_which_way_the_view_moves(keys, motion):
    machine = GestureMachine()
    machine.begin(press(keys=keys))
    assert machine.motion is motion


@given(travel=st.floats(0, 20), lasted=st.floats(0, 1))
def test_a_tap_is_short_in_both_senses(travel, lasted):
    machine = GestureMachine()
    machine.begin(press(takes="tap"))
    machine.move(100.0 + travel, 100.0)
    machine.move(100.0, 100.0)  # coming back does not make it short again
    outcome = machine.release("pen", Button.TIP, lasted)
    assert (outcome is Outcome.TAP) == (machine_travel_ok(travel) and lasted < TAP_TIME)


def machine_travel_ok(travel):
    return (100.0 + travel) - 100.0 < TAP_TRAVEL


def test_a_dot_is_no_ink_but_a_dab_erases():
    machine = GestureMachine()
    machine.begin(press())
    assert machine.release("pen", Button.TIP, 0.1) is Outcome.NOTHING
    machine.begin(press(eraser=True))
    assert machine.release("pen", Button.TIP, 0.1) is Outcome.STROKE


def test_the_pen_takes_over_from_a_finger_that_turns_the_view():
    machine = GestureMachine()
    machine.begin(press("touch"))
    assert machine.begin(press("pen"))
    assert machine.mode is Mode.INKING
    assert not machine.begin(press("touch"))
    assert not machine.begin(press("mouse", Button.TURN))


def test_palms_are_ignored_near_the_pen_and_a_moment_after():
    machine = GestureMachine()
    assert machine.listens_to_touch(0.0)
    machine.see_pen(1.0)
    assert not machine.listens_to_touch(1.5)
    machine.lose_pen(2.0)
    assert not machine.listens_to_touch(2.0 + 0.9 * PALM_TIME)
    assert machine.listens_to_touch(2.0 + 1.1 * PALM_TIME)


def test_a_pen_that_never_says_goodbye_does_not_kill_touch():
    machine = GestureMachine()
    machine.see_pen(1.0)
    assert machine.listens_to_touch(1.0 + 1.1 * NEAR_TIME)


pointers = st.sampled_from(["pen", "mouse", "touch"])
buttons = st.sampled_from(list(Button))


class AnySequence(RuleBasedStateMachine):
    """Whatever events come, in whatever order."""

    def __init__(self):
        super().__init__()
        self.machine = GestureMachine()
        self.open = 0  # gestures begun and not ended
        self.now = 0.0

    @rule(
        pointer=pointers,
        button=buttons,
        eraser=st.booleans(),
        handle=st.sampled_from(["", "h"]),
        takes=st.sampled_from(["ink", "tap", "drag"]),
        alt=st.booleans(),
    )
    def presses(self, pointer, button, eraser, handle, takes, alt):
        before = self.machine.mode
        begun = self.machine.begin(
            Press(pointer, button, 0, 0, self.now, Keys(alt=alt), eraser, handle, takes)
        )
        if begun:
            # Only the pen interrupts, and only a turn of the view.
            assert before is Mode.IDLE or (before is Mode.NAVIGATING and pointer == "pen")
            self.open = 1
            if pointer == "touch":
                assert self.machine.mode is Mode.NAVIGATING
        else:
            assert self.machine.mode is before

    @rule(x=st.floats(-50, 50), y=st.floats(-50, 50))
    def moves(self, x, y):
        self.now += 0.01
        self.machine.move(x, y)

    @rule(pointer=pointers, button=buttons)
    def releases(self, pointer, button):
        owned = self.machine.owns(pointer, button)
        outcome = self.machine.release(pointer, button, self.now)
        if owned:
            self.open = 0
            assert self.machine.mode is Mode.IDLE
        else:
            assert outcome is Outcome.NOTHING

    @rule()
    def cancels(self):
        self.machine.cancel()
        self.open = 0
        assert self.machine.mode is Mode.IDLE

    @invariant()
    def one_gesture_at_most_and_none_when_idle(self):
        assert (self.machine.mode is Mode.IDLE) == (self.machine.press is None)
        assert (self.machine.mode is not Mode.IDLE) == bool(self.open)

    def teardown(self):
        press = self.machine.press
        if press is not None:
            self.machine.release(press.pointer, press.button, self.now)
        assert self.machine.mode is Mode.IDLE


TestAnySequence = AnySequence.TestCase
