"""Figures: verdicts by bounds and texts, keys with units, and what a modeler may say."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.plugin import Figure
from bozzetto.plugin.figures import UNITS, figure_of, without_unit
from bozzetto.plugin.guard.answer_validation import sound_figures, sound_first_parameters
from bozzetto.plugin.guard.checked_values import Unsound
from bozzetto_silhouette.model.state import Part, SilhouetteState

numbers = st.floats(allow_nan=False, allow_infinity=False, width=32)


@given(numbers, numbers, numbers)
def test_bounds_that_change_places_turn_the_verdict_round(good, bad, value):
    """And between them nothing is said."""
    if good == bad:
        return
    verdict = Figure("Gap", "How wide.", good=good, bad=bad).verdict(value)
    other = Figure("Gap", "How wide.", good=bad, bad=good).verdict(value)
    assert other is (None if verdict is None else not verdict)
    assert (verdict is None) is (min(good, bad) < value < max(good, bad))


@given(numbers, st.floats(0.0, 1e9))
def test_better_is_never_called_worse(value, gain):
    order = {False: 0, None: 1, True: 2}
    figure = Figure("Match", "How well.", good=10.0, bad=-10.0)
    assert order[figure.verdict(value + gain)] >= order[figure.verdict(value)]


@pytest.mark.parametrize(
    ("value", "fine"),
    [
        ([0.0, 5.0], None),
        ([0.0, 9.0], False),
        ([0.0, 1.0], True),
        ([], None),
        (["sound"], True),
        ("sound", True),
        ("broken", False),
        ("new", None),
        (None, None),
        (math.nan, None),
        ({"a": 0.0}, None),
    ],
)
def test_a_list_is_as_good_as_the_worst_of_it(value, fine):
    verdicts = {"sound": True, "broken": False}
    assert Figure("Gap", "How wide.", good=1.0, bad=8.0, verdicts=verdicts).verdict(value) is fine


def test_without_bounds_nothing_is_judged():
    assert Figure("Gap", "How wide.").verdict(3.0) is None


@pytest.mark.parametrize("unit", UNITS)
def test_keys_may_end_in_a_unit(unit):
    figures = {"gap": Figure("Gap", "How wide."), "way_s": Figure("Way", "How long.")}
    assert without_unit(f"gap_{unit}") == ("gap", UNITS[unit])
    assert figure_of(f"gap_{unit}", figures) is figure_of("gap", figures) is figures["gap"]
    assert figure_of("way_s", figures) is figures["way_s"]
    assert figure_of("way", figures) is None
    for bare in (unit, f"_{unit}", f"gap{unit}"):
        assert without_unit(bare) == (bare, "")


@pytest.mark.parametrize(
    ("figures", "words"),
    [
        ([], "a mapping"),
        ({1: Figure("A", "B")}, "the key 1"),
        ({"a": "Gap"}, "a: str where a Figure"),
        ({"a": Figure("Gap")}, "Figure.help is empty: say"),
        ({"a": Figure("Gap", "How wide.", unit=3)}, "Figure.unit"),
        ({"a": Figure("Gap", "How wide.", digits=1000)}, "Figure.digits"),
        ({"a": Figure("Gap", "How wide.", factor=math.inf)}, "Figure.factor"),
        ({"a": Figure("Gap", "How wide.", good=1.0)}, "a: give good and bad"),
        ({"a": Figure("Gap", "How wide.", good=1.0, bad=1.0)}, "a: give good and bad"),
        ({"a": Figure("Gap", "How wide.", good=1.0, bad=math.nan)}, "Figure.bad"),
        ({"a": Figure("Gap", "How wide.", values={"a": 1})}, "Figure.values"),
        ({"a": Figure("Gap", "How wide.", verdicts={"a": "good"})}, "Figure.verdicts"),
    ],
)
def test_what_cannot_be_said_is_refused_by_its_key(figures, words):
    with pytest.raises(Unsound, match=words):
        sound_figures(figures)


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["inflation"], "a tuple"),
        (("inflation", "inflation"), "each once"),
        (("inflation", "blend", "surface", "operation"), "3 at most"),
        (("inflatoin",), "no parameter 'inflatoin'"),
        (("kernel",), "advanced"),
    ],
)
def test_first_parameters_are_parameters(names, words):
    with pytest.raises(Unsound, match=words):
        sound_first_parameters(names, (SilhouetteState, Part))


def test_first_parameters_are_of_the_state_or_its_parts():
    names = ("inflation", "inner")
    assert sound_first_parameters(names, (SilhouetteState, Part)) == names
    assert sound_first_parameters((), ()) == ()
