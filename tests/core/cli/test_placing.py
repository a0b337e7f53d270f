"""Objects are put somewhere else on the command line, as in the window."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from bozzetto.cli.placing import placed
from bozzetto.document import edit
from bozzetto.document.model import Document, Model, Underlay
from bozzetto.document.underlay_place import place_of
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement

TURNED = Placement(scale=2.0, offset=(1.0, 2.0, 3.0)).headed(30.0)


@pytest.fixture
def document():
    state = SimpleNamespace()
    one = Model("a", "Car", "acme.cars", state)
    two = Model("b", "Car = 2", "acme.cars", state, placement=TURNED)
    return Document((one, two))


def test_an_object_is_put_where_it_is_said(document):
    made = placed(document, ["Car=0,2500,-10.5"])
    assert made.model("a").placement == Placement(offset=(0.0, 2500.0, -10.5))
    assert made.model("b") is document.model("b")


def test_only_a_turn_that_is_told_turns(document):
    """A name may have the sign in it: numbers come after the last one."""
    moved = placed(document, ["Car = 2=5,6,7"]).model("b").placement
    assert moved.heading == pytest.approx(30.0)
    turned = placed(document, ["Car = 2=5,6,7,90"]).model("b").placement
    assert (turned.heading, turned.scale) == (pytest.approx(90.0), 2.0)
    assert moved.offset == turned.offset == (5.0, 6.0, 7.0)


def test_it_is_the_edit_of_the_window(document):
    by_hand, _ = edit.place_model(document, "b", TURNED.headed(45.0))
    told = placed(document, ["Car = 2=1,2,3,45"])
    assert told.model("b").placement == by_hand.model("b").placement


@pytest.mark.parametrize("words", ["Car", "Car=1,2", "Car=1,2,x", "Car=1,2,inf", "Car=1,2,3,4,5"])
def test_what_is_no_place_is_refused(document, words):
    with pytest.raises(UserError, match=r"NAME=X,Y,Z"):
        placed(document, [words])


def test_a_wrong_name_tells_the_right_ones(document):
    with pytest.raises(UserError, match=r"no object called “Bus”.*“Car”, “Car = 2”"):
        placed(document, ["Bus=1,2,3"])


@pytest.fixture
def traced(document):
    pixels = np.zeros((2, 3, 4), np.uint8)
    lies = ((-60.0, 0.0, 80.0), (120.0, 0.0, 0.0), (0.0, 0.0, -80.0))
    return edit.add_underlay(document, Underlay("u", "photo", pixels, *lies)).document


def test_an_underlay_is_put_by_its_middle_and_what_is_not_told_stays(traced):
    for words, turn, width in (("1,2,3", 0.0, 120.0), ("1,2,3,30", 30.0, 120.0)):
        (made,) = placed(traced, [f"photo={words}"]).underlays
        place = place_of(made)
        assert place.middle == pytest.approx((1.0, 2.0, 3.0))
        assert (place.width, place.turn) == (pytest.approx(width), pytest.approx(turn))
    (made,) = placed(traced, ["photo=1,2,3,30,60"]).underlays
    assert place_of(made).width == pytest.approx(60.0)
    with pytest.raises(UserError, match="wide"):
        placed(traced, ["photo=1,2,3,30,0"])
    with pytest.raises(UserError, match="“photo”"):
        placed(traced, ["Bus=1,2,3"])


def test_a_locked_object_stays(document):
    locked, _ = edit.lock_model(document, "a", True)
    with pytest.raises(UserError, match="locked"):
        placed(locked, ["Car=1,2,3"])
