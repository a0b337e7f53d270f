"""Commands on the chosen curve: other readings, the other matching, and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context
from bozzetto_symmetry.commands import all_commands
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import scenes as s

VIEW = s.camera(35, 20)


def command(name: str):
    (found,) = (one for one in all_commands() if one.id == name)
    return found


def run(name: str, state: SymmetryState) -> SymmetryState:
    return command(name).run(state, Context(camera=VIEW))


def model(*curves: np.ndarray) -> SymmetryState:
    strokes = [Stroke(*VIEW.project(curve)[0].T, VIEW) for curve in curves]
    return SymmetryState().with_node(Curve(id="a", name="A", strokes=Strokes(strokes)))


def reading(state: SymmetryState) -> str:
    return trace_of(state.curves[0], state).reading


def test_every_command_has_words_and_no_key_twice() -> None:
    keys = [one.key for one in all_commands() if one.key]
    assert len(set(keys)) == len(keys)
    assert all(one.title and one.help.endswith(".") for one in all_commands())


def test_commands_on_a_curve_need_a_chosen_one() -> None:
    state = model(s.ACROSS["hood U"])
    for one in all_commands():
        assert one.enabled(state)
        if one.id not in ("trim-ends", "snapping", "new-curves-lie"):
            assert not one.enabled(replace(state, selected=""))
    with pytest.raises(UserError, match="No curve is chosen"):
        run("switch-reading", replace(state, selected="gone"))
    bare = state.with_node(replace(state.curves[0], strokes=Strokes(())))
    with pytest.raises(UserError, match="has no ink"):
        run("switch-reading", bare)


def test_the_key_goes_through_what_the_ink_allows_and_comes_back() -> None:
    state = model(s.ACROSS["hood U"])
    assert reading(state) == "self"
    found = []
    for _ in range(4):
        state = run("switch-reading", state)
        found.append(reading(state))
        if found[-1] == "self":
            break
    assert found[-1] == "self"
    assert len(set(found)) == len(found) >= 2
    assert "half" in found


@pytest.mark.parametrize("name", ["hood U", "wavy bumper", "wheel"])
def test_the_key_takes_what_is_likeliest_next(name: str) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    wheel = 30.0 * np.column_stack((np.cos(turn), np.zeros(200), np.sin(turn)))
    state = model(wheel if name == "wheel" else s.ACROSS[name])
    found = trace_of(state.curves[0], state).views[0].reader.read("auto", state.bounds)
    costs = {read.reading: read.cost for read in reversed(found)}
    seen = [reading(state)]
    while len(seen) < len(costs):
        state = run("switch-reading", state)
        seen.append(reading(state))
    assert seen == sorted(costs, key=lambda kind: costs[kind])
    assert name != "wheel" or seen[:2] == ["plane", "self"]


def test_both_sides_may_be_read_otherwise_and_are_a_pair_again() -> None:
    side = s.PAIRS["roof rail"]
    state = model(side, side * MIRROR)
    assert reading(state) == "pair"
    other = run("switch-reading", state)
    assert reading(other) != "pair"
    for _ in range(3):
        if reading(other) != "pair":
            other = run("switch-reading", other)
    assert reading(other) == "pair"


def test_switching_does_not_touch_the_ink_nor_other_curves() -> None:
    state = model(s.ACROSS["hood U"])
    beside = replace(state.curves[0], id="b", name="B")
    state = replace(state.with_node(beside), selected="a")
    changed = run("switch-reading", state)
    assert changed.node("a").strokes == state.node("a").strokes
    assert changed.node("b") == beside


def test_the_other_matching_is_another_curve_and_goes_back() -> None:
    state = model(s.ACROSS["hood U"])
    if trace_of(state.curves[0], state).choices < 2:
        pytest.skip("this ink allows one curve only")
    other = run("other-matching", state)
    assert other.curves[0].other
    assert reading(other) != "half"
    first, second = (trace_of(st.curves[0], st).points for st in (state, other))
    assert s.distances(second, first).max() > 1.0
    assert run("other-matching", other) == state


def test_without_another_matching_that_is_said() -> None:
    side = s.PAIRS["roof rail"]
    state = replace(model(side), selected="a")
    (curve,) = state.curves
    alone = state.with_node(replace(curve, reading="half"))
    with pytest.raises(UserError, match="no other way"):
        run("other-matching", alone)
