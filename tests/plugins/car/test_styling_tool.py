"""The Style tool, its preview and commands, and what is shown of styling curves."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import bozzetto_car
from bozzetto.errors import UserError
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.plugin import Context, Tap, Tool
from bozzetto.scene import Lines
from bozzetto_car.state import CarState, Group
from bozzetto_car.styling.commands import styling_commands
from bozzetto_car.styling.curve import mirror_curve
from bozzetto_car.styling.live_preview import Growing
from bozzetto_car.styling.picking import target_of
from bozzetto_car.styling.scene import chosen_styling, shown_styling, styling_items
from bozzetto_car.tools.draw_style import Style
from tests.plugins.car.styled_body import (
    ABOVE,
    QUARTER,
    SHOULDER,
    assert_sound,
    dense,
    ink,
    off_surface,
    styled,
    template_body,
    through,
)
from tests.plugins.car.traced_car import view
from tests.previews import preview_of

Array = NDArray[np.float64]

STROKE = through(QUARTER, SHOULDER)
CONTEXT = Context(camera=QUARTER)
tool: Tool[CarState] = Style()


def drawn(stroke: Array = STROKE, state: CarState | None = None) -> CarState:
    return tool.apply(state or CarState(), ink(stroke, QUARTER), CONTEXT)


def bulge(height: float = 9.0) -> Array:
    part = STROKE[60:190].copy()
    part[:, 1] -= height * np.sin(np.linspace(0.0, np.pi, len(part)))
    return part


# -- drawing ---------------------------------------------------------------------------------------


def test_a_stroke_is_a_curve_with_a_name_that_is_chosen() -> None:
    state = drawn()
    (curve,) = state.styling
    assert state.selected == curve.id
    assert curve.name == "Styling 1"
    assert curve.both
    assert_sound(curve, template_body())


def test_a_stroke_elsewhere_is_another_curve() -> None:
    for other in (STROKE + np.array([0.0, 28.0]), STROKE[::-1] - [0.0, 28.0]):
        state = drawn(other, drawn())
        assert [curve.name for curve in state.styling] == ["Styling 1", "Styling 2"]


def test_a_stroke_across_a_curve_is_another_curve() -> None:
    body = template_body()
    across = through(QUARTER, [[2300, 890, 450], [2310, 890, 600], [2320, 880, 750]])
    state = drawn(across, drawn())
    assert len(state.styling) == 2
    assert_sound(state.styling[1], body)


def test_a_stroke_beside_a_curve_bends_it() -> None:
    body, before = template_body(), drawn()
    for stroke in (bulge(), bulge()[::-1]):
        state = drawn(stroke, before)
        (curve,) = state.styling
        assert curve.id == before.selected
        assert_sound(curve, body)
        seen = QUARTER.project(dense(curve, body))[0]
        assert np.median(distances_to_polyline(stroke, seen)) < 0.5


def test_a_stroke_beside_the_mirror_image_bends_the_curve_itself() -> None:
    body, before = template_body(), drawn()
    left = ink(bulge() * [-1.0, 1.0] + [1200.0, 0.0], view(-50.0, 15.0))
    (image,) = tool.apply(before, left, CONTEXT).styling
    (own,) = drawn(bulge(), before).styling
    assert dense(image, body)[:, 1].mean() > 0.0
    assert np.abs(dense(image, body, 100) - dense(own, body, 100)).max() < 0.01


def test_what_is_on_one_side_only_is_not_meant_on_the_other() -> None:
    body = template_body()
    curve = replace(styled(body), both=False)
    left = bulge() * [-1.0, 1.0] + [1200.0, 0.0]
    assert target_of([curve], body, left, view(-50.0, 15.0)) is None
    assert target_of([mirror_curve(curve)], body, left, view(-50.0, 15.0)) is not None


def test_curves_that_are_switched_off_or_behind_the_body_are_not_meant() -> None:
    before = drawn()
    hidden = replace(before, nodes=(replace(before.styling[0], visible=False),))
    assert len(drawn(bulge(), hidden).styling) == 2
    body = template_body()
    far = mirror_curve(replace(styled(body), both=False))
    pixels = QUARTER.project(dense(far, body, 100))[0]
    assert target_of([far], body, pixels, QUARTER) is None


def test_of_two_curves_the_nearer_one_is_meant_and_the_chosen_one_sooner() -> None:
    body = template_body()
    low = styled(body, QUARTER, np.array(SHOULDER) - [0.0, 0.0, 60.0], number="n2")
    curves = [styled(body), low]
    pixels = [QUARTER.project(dense(curve, body, 100))[0] for curve in curves]
    gap = float(np.median(pixels[1][:, 1] - pixels[0][:, 1]))
    assert 6.0 < gap < 20.0
    for share, chosen, meant in ((0.3, "", "n1"), (0.7, "", "n2"), (0.45, "n2", "n2")):
        target = target_of(curves, body, pixels[0] + [0.0, share * gap], QUARTER, chosen)
        assert target is not None
        assert target.curve.id == meant


def test_several_strokes_of_one_gesture_settle() -> None:
    rng = np.random.default_rng(2)
    strokes = tuple(ink(STROKE + rng.normal(0.0, 1.5, 2), QUARTER).strokes[0] for _ in range(3))
    state = tool.apply(CarState(), replace(ink(STROKE, QUARTER), strokes=strokes), CONTEXT)
    (curve,) = state.styling
    assert_sound(curve, template_body())


def test_the_eraser_takes_a_curve_away() -> None:
    assert tool.apply(drawn(), ink(STROKE, QUARTER, "eraser"), CONTEXT).styling == ()


@pytest.mark.parametrize("stroke", [[[600.0, 400.0]], [[5.0, 5.0], [300.0, 8.0]]])
def test_what_is_no_line_on_the_body_is_refused(stroke: list[list[float]]) -> None:
    with pytest.raises(UserError):
        drawn(np.array(stroke))
    with pytest.raises(UserError):
        tool.apply(drawn(), ink(stroke, QUARTER, "eraser"), CONTEXT)


def test_a_tap_is_no_line() -> None:
    with pytest.raises(UserError):
        tool.apply(CarState(), Tap(1.0, 1.0, QUARTER), CONTEXT)
    assert preview_of(tool, CarState(), Tap(1.0, 1.0, QUARTER), CONTEXT).layers == ()


def test_the_icon_is_of_the_set() -> None:
    folder = Path(bozzetto_car.__file__).parent
    own, other = (ET.parse(folder / name).getroot() for name in (tool.icon, "icons/mark.svg"))
    for key in ("viewBox", "stroke-width", "stroke", "fill"):
        assert own.get(key) == other.get(key)


# -- while it is drawn -----------------------------------------------------------------------------


def test_the_preview_lies_on_the_body_under_the_ink() -> None:
    body = template_body()
    preview = tool.begin(CarState(), CONTEXT)
    for last in (3, 40, 41, 42, 120, 240):
        scene = preview.update(ink(STROKE[:last], QUARTER))
    (layer,) = scene.layers
    (line,) = layer.items
    assert isinstance(line, Lines)
    points = line.points.astype(float)
    assert off_surface(points, body).max() < 0.01
    assert distances_to_polyline(QUARTER.project(points)[0], STROKE).max() < 0.1
    assert distances_to_polyline(STROKE, QUARTER.project(points)[0]).max() < 8.0


def test_a_gap_in_the_ink_is_none_in_what_is_off_the_body() -> None:
    growing = Growing(template_body().nets, QUARTER)
    off = np.linspace([5.0, 5.0], [300.0, 8.0], 50)
    assert growing.lines(off) == []
    assert len(growing.lines(np.concatenate((off, STROKE)))) == 1


def test_the_answer_is_the_same_however_the_pen_was_asked() -> None:
    body = template_body()
    often, seldom = Growing(body.nets, QUARTER), Growing(body.nets, QUARTER)
    for last in range(1, len(STROKE) + 1):
        by_one = often.lines(STROKE[:last])
    at_once = seldom.lines(STROKE)
    near = distances_to_polyline(by_one[0], at_once[0])
    assert near.max() < 3.0


def test_odd_ink_has_a_preview_too() -> None:
    for stroke in ([[600.0, 400.0]], [[1e7, 0.0], [600.0, 400.0]], [[600.0, 400.0]] * 5):
        preview_of(tool, CarState(), ink(stroke, QUARTER), CONTEXT)
    assert preview_of(tool, drawn(), ink(STROKE, QUARTER, "eraser"), CONTEXT).layers == ()


# -- commands --------------------------------------------------------------------------------------


def test_smoothing_and_mirroring_by_command() -> None:
    body, state = template_body(), drawn()
    by_id = {command.id: command for command in styling_commands()}
    smooth = by_id["smooth-styling"].run(state, CONTEXT)
    assert len(smooth.styling) == 1
    assert_sound(smooth.styling[0], body)
    made = by_id["mirror-styling"].run(state, CONTEXT)
    own, image = made.styling
    assert not own.both
    assert not image.both
    assert made.selected == image.id != own.id
    assert np.abs(dense(image, body, 50) - dense(own, body, 50) * [1.0, -1.0, 1.0]).max() < 1e-6


def test_commands_need_a_chosen_curve() -> None:
    for state in (CarState(), replace(drawn(), selected="")):
        for command in styling_commands():
            assert not command.enabled(state)
            with pytest.raises(UserError, match="chosen"):
                command.run(state, CONTEXT)
    assert all(command.enabled(drawn()) for command in styling_commands())


# -- shown -----------------------------------------------------------------------------------------


def test_curves_are_shown_with_their_mirror_images() -> None:
    body = template_body()
    one, other = styled(body), replace(styled(body, number="n2"), both=False, color=(1, 2, 3))
    state = CarState(nodes=(one, other), selected="n1")
    items, over = styling_items(state, body), chosen_styling(state, body)
    assert all(isinstance(item, Lines) for item in (*items, *over))
    image, chosen, plain = (item for item in items if isinstance(item, Lines))
    assert (chosen.color, image.color, plain.color) == ("ink", "second", (1, 2, 3))
    assert [item.color for item in over] == ["second", "accent"]
    for wider, own in zip(over, (image, chosen), strict=True):
        assert wider.width > own.width
        assert np.array_equal(wider.points, own.points)
    assert not chosen_styling(replace(state, selected=""), body)
    assert np.array_equal(chosen.points * np.array([1, -1, 1], np.float32), image.points)
    assert off_surface(chosen.points.astype(float)[::7], body).max() < 0.01


def test_what_is_switched_off_is_not_shown() -> None:
    body = template_body()
    curve = styled(body)
    grouped = replace(curve, within="g")
    group = Group("g", "Group")
    assert len(shown_styling(CarState(nodes=(group, grouped)))) == 1
    for nodes in ((replace(curve, visible=False),), (replace(group, visible=False), grouped)):
        assert styling_items(CarState(nodes=nodes), body) == ()


def test_a_curve_over_the_middle_is_one_line() -> None:
    body = template_body()
    curve = styled(body, ABOVE, [[700, 600, 900], [500, 0, 900], [700, -600, 900]])
    line = styling_items(CarState(nodes=(curve,)), body)[0]
    assert isinstance(line, Lines)
    assert len(list(line.pieces())) == 1
    steps = np.linalg.norm(np.diff(line.points.astype(float), axis=0), axis=1)
    assert steps.max() < 6.0
