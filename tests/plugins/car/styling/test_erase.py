"""The pen's other end on styling curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve import mirror_curve
from bozzetto_car.styling.erase import erase, without_stretch
from tests.plugins.car.styled_body import (
    QUARTER,
    SHOULDER,
    assert_sound,
    dense,
    ink,
    styled,
    template_body,
    through,
    whole,
)
from tests.plugins.car.traced_car import view

STROKE = through(QUARTER, SHOULDER)


def test_a_stretch_is_cut_out() -> None:
    body = template_body()
    curve = styled(body)
    left = without_stretch(curve, body, STROKE[100:130], QUARTER)
    assert len(left) == 2
    for part in left:
        assert_sound(part, body)
    gap = np.linalg.norm(
        QUARTER.project(dense(left[1], body)[:1])[0] - QUARTER.project(dense(left[0], body)[-1:])[0]
    )
    rubbed = np.linalg.norm(STROKE[129] - STROKE[100])
    assert abs(gap - rubbed - 18.0) < 3.0  # and half the eraser's width at either end
    lengths = [whole(part, body).length for part in left]
    assert sum(lengths) < whole(curve, body).length
    whole_line = dense(curve, body)
    for part in left:
        away = np.linalg.norm(dense(part, body, 50)[:, None] - whole_line, axis=2).min(axis=1)
        assert away.max() < 3.0


def test_an_end_is_cut_off() -> None:
    body = template_body()
    (left,) = without_stretch(styled(body), body, STROKE[:40], QUARTER)
    assert_sound(left, body)
    assert whole(left, body).length < 0.9 * whole(styled(body), body).length


def test_most_of_it_takes_all() -> None:
    body = template_body()
    assert without_stretch(styled(body), body, STROKE[20:220], QUARTER) == ()


def test_beside_it_nothing_goes() -> None:
    body = template_body()
    curve = styled(body)
    assert without_stretch(curve, body, STROKE + np.array([0.0, 30.0]), QUARTER) == (curve,)


def drawn(*curves: StylingCurve) -> CarState:
    return CarState(nodes=curves, selected=curves[0].id)


def test_parts_get_names_and_ids_of_their_own_in_the_place_of_the_curve() -> None:
    body = template_body()
    one, other = styled(body), replace(styled(body, number="n2"), visible=False)
    made = erase(drawn(one, other), body, ink(STROKE[100:130], QUARTER, "eraser").strokes[0])
    assert [node.id for node in made.nodes] == ["n1", "n3", "n2"]
    assert len({node.name for node in made.nodes}) == 3
    assert made.selected == "n1"


def test_a_mirror_image_is_rubbed_out_on_both_sides() -> None:
    body, camera = template_body(), view(-50.0, 15.0)
    rubber = STROKE[100:130] * [-1.0, 1.0] + [1200.0, 0.0]
    made = erase(drawn(styled(body)), body, ink(rubber, camera, "eraser").strokes[0])
    own = erase(drawn(styled(body)), body, ink(STROKE[100:130], QUARTER, "eraser").strokes[0])
    for one, other in zip(made.styling, own.styling, strict=True):
        assert np.abs(dense(one, body, 50) - dense(other, body, 50)).max() < 0.01


def test_what_is_on_one_side_only_is_not_rubbed_out_on_the_other() -> None:
    body = template_body()
    state = drawn(replace(mirror_curve(styled(body)), both=False))
    with pytest.raises(UserError, match="no styling curve"):
        erase(state, body, ink(STROKE[100:130], QUARTER, "eraser").strokes[0])


def test_curves_that_are_only_crossed_stay() -> None:
    body = template_body()
    one = styled(body)
    across = styled(
        body, QUARTER, [[2300, 890, 450], [2310, 890, 650], [2320, 880, 800]], number="n2"
    )
    rubber = ink(STROKE[60:190], QUARTER, "eraser").strokes[0]
    made = erase(drawn(one, across), body, rubber)
    assert any(node is across for node in made.nodes)


def test_without_the_last_curve_nothing_is_chosen() -> None:
    body = template_body()
    made = erase(drawn(styled(body)), body, ink(STROKE, QUARTER, "eraser").strokes[0])
    assert made.nodes == ()
    assert made.selected == ""
