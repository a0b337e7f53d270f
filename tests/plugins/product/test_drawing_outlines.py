"""Outlines of SVG files as details: laid by a command, by a step, and by a network's file."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Context, Drag, Job, Tap
from bozzetto.plugin.host.registry import Registry
from bozzetto.view import Camera
from bozzetto.workbench.play_steps import steps_taken
from bozzetto.workbench.workbench import Workbench
from bozzetto_product.details.drawing_outlines import drawing_outlines
from bozzetto_product.details.emblem_places import emblem_outlines
from bozzetto_product.model.emblems import Emblem
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.tools.emblem import LayText
from tests.plugins.product.detail_kit import RADIUS, ball, ball_curves, body, grounds, manifold

PRODUCT = ProductModeler()
FRONT = Camera(eye=(300.0, 0.0, 0.0), target=(0.0, 0.0, 0.0))
MIDDLE = FRONT.project(np.zeros((1, 3)))[0][0]

RING = (
    '<svg xmlns="http://www.w3.org/2000/svg"><path fill-rule="evenodd" '
    'd="M-8 0A8 8 0 1 0 8 0A8 8 0 1 0 -8 0ZM-4 0A4 4 0 1 0 4 0A4 4 0 1 0 -4 0Z"/></svg>'
)
PLATE = (
    '<svg xmlns="http://www.w3.org/2000/svg">'
    '<path d="M0 2A2 2 0 0 1 2 0H10A2 2 0 0 1 12 2V6H0Z"/></svg>'
)


@pytest.fixture
def svg(tmp_path):
    """A function that writes an SVG file and reads it."""

    def read(text: str, name: str = "logo.svg") -> Drawing:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return read_drawing(path)

    return read


def area(row: np.ndarray) -> float:
    x, y = row.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def added(drawing: Drawing, state=None):
    made = PRODUCT.add_drawing(ball() if state is None else state, drawing, Context(camera=FRONT))
    emblem = made.chosen_of(Emblem)
    assert emblem is not None
    return made, emblem


def test_outlines_have_the_form_and_the_size_of_the_file(svg) -> None:
    flat, height = drawing_outlines(svg(RING).strokes, "ring")
    assert height == pytest.approx(16.0, rel=1e-3)
    areas = sorted(area(row) * height**2 for row in flat.rows)
    assert areas == pytest.approx([np.pi * 16.0, np.pi * 64.0], rel=5e-3)
    assert not flat.corners.any(), "a circle has none"


def test_a_straight_side_has_corners_at_its_ends_and_a_point_between(svg) -> None:
    flat, height = drawing_outlines(svg(PLATE).strokes, "plate")
    (row,) = flat.rows
    assert flat.corners.sum() == 6
    assert area(row) * height**2 == pytest.approx(12 * 6 - 2 * (4 - np.pi), rel=1e-3)
    assert row[:, 1].max() > 0 > row[:, 1].min(), "y up, about the middle"
    top = row[row[:, 1] > row[:, 1].max() - 1e-6]
    assert np.ptp(top[:, 0]) * height == pytest.approx(8.0, rel=1e-3), "rounded at the top"


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_the_unit_of_a_file_does_not_change_its_form(svg, factor) -> None:
    strokes = svg(PLATE).strokes
    larger = Strokes(
        [
            Stroke(one.points[:, 0] * factor, one.points[:, 1] * factor, one.camera)
            for one in strokes
        ]
    )
    one, two = drawing_outlines(strokes, "a")[0], drawing_outlines(larger, "a")[0]
    np.testing.assert_allclose(one.points, two.points, atol=1e-4)
    assert (one.corners == two.corners).all()


def test_a_drawing_comes_to_the_middle_of_the_sheet_and_is_carved(svg) -> None:
    state, emblem = added(svg(RING))
    assert emblem.name == "logo 1"
    assert emblem.height == pytest.approx(16.0, rel=1e-3)
    outlines = emblem_outlines(emblem, grounds(state))
    for row in outlines:
        # They are let down on triangles.
        np.testing.assert_allclose(np.linalg.norm(row, axis=1), RADIUS, rtol=6e-3)
        assert row[:, 0].min() > 0.5 * RADIUS, "on the side that is seen"
    volumes = []
    for kind in ("in", "raised"):
        made = manifold(body(state.with_node(replace(emblem, kind=kind, depth=1.0))).mesh)
        volumes.append(made.volume())
    ring = np.pi * (64.0 - 16.0)
    # Walls lean by three degrees; what is laid flat is larger on the ball.
    assert 0.9 * ring < 0.5 * (volumes[1] - volumes[0]) < 1.1 * ring, "with its hole"


def test_the_chosen_surface_gets_it_wherever_it_is_seen_from(svg) -> None:
    state = ball()
    for ground in grounds(state)[:3]:
        chosen = replace(state, selected=ground.patch)
        _, emblem = added(svg(RING), chosen)
        at = emblem.places.points[0]
        low, high = ground.fill.mesh.bounds
        assert (at >= low - 1e-6).all()
        assert (at <= high + 1e-6).all()


def test_what_is_larger_than_its_surface_is_made_smaller(svg) -> None:
    _, emblem = added(svg(RING.replace("<path", '<path transform="scale(50)"')))
    assert emblem.height < RADIUS


def test_handles_move_turn_and_size_it_as_a_text(svg) -> None:
    state, before = added(svg(PLATE))
    goal = MIDDLE + np.array((40.0, -30.0))
    path = np.stack((MIDDLE, goal))
    moved = LayText().drag(
        state, Drag("text middle", Stroke(path[:, 0], path[:, 1], FRONT)), Context()
    )
    emblem = moved.chosen_of(Emblem)
    assert emblem is not None
    np.testing.assert_allclose(FRONT.project(emblem.places.points[:1])[0][0], goal, atol=0.5)
    np.testing.assert_array_equal(emblem.flat.points, before.flat.points)


def test_a_touch_lays_the_chosen_drawing_once_more(svg) -> None:
    state, first = added(svg(PLATE))
    place = MIDDLE + np.array((30.0, 25.0))
    again = LayText().tap(state, Tap(*place, FRONT), Context())
    second = again.chosen_of(Emblem)
    assert second is not None
    assert second.id != first.id
    assert second.flat is first.flat
    assert [one.name for one in again.of_kind(Emblem)] == ["logo 1", "logo 2"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('<path d="M0 0L10 0L5 8" fill="none" stroke="#000"/>', "1 of 1 lines"),
        ('<path d="M0 0H9V9Z"/><path d="M20 0H30" stroke="#000"/>', "1 of 2 lines"),
        ('<path d="M0 0H10H0Z" stroke="#000"/>', "no closed outline"),
        ('<g stroke="#000">' + '<path d="M0 0H9V9Z"/>' * 300 + "</g>", "outlines"),
    ],
)
def test_what_cannot_be_laid_says_why(svg, text, words) -> None:
    drawing = svg(f'<svg xmlns="http://www.w3.org/2000/svg">{text}</svg>')
    strokes = drawing.strokes
    if "300" in text or words == "outlines":
        strokes = Strokes([*strokes] * (300 // len(strokes) + 1))
    with pytest.raises(UserError, match=words):
        added(replace(drawing, strokes=strokes))


def test_beside_all_surfaces_it_says_to_choose_one(svg) -> None:
    away = replace(FRONT, target=(0.0, 500.0, 0.0))
    with pytest.raises(UserError, match="No surface is chosen"):
        PRODUCT.add_drawing(ball(), svg(RING), Context(camera=away))


def file_of(tmp_path, **values):
    detail = {"drawing": {"file": "logo.svg"}, "at": [RADIUS, 0, 0], "height": 12.0, **values}
    network = {"curves": ball_curves(), "details": [detail]}
    path = tmp_path / "ball.json"
    path.write_text(json.dumps({"network": network}), encoding="utf-8")
    return path


def read(path):
    drawing = read_drawing(path)
    context = Context(facts=drawing.facts, drawings=drawing.drawings)
    return PRODUCT.read_drawing(drawing, context, Job())


def test_a_network_names_a_drawing_that_lies_beside_it(svg, tmp_path) -> None:
    svg(RING)
    state = read(file_of(tmp_path, kind="raised", depth=1.0, turn=30.0))
    (emblem,) = state.of_kind(Emblem)
    assert (emblem.name, emblem.kind, emblem.turn) == ("logo 1", "raised", 30.0)
    assert emblem.height == 12.0
    _, by_hand = added(svg(RING))
    np.testing.assert_array_equal(emblem.flat.points, by_hand.flat.points)
    assert not PRODUCT.solve(state, Job()).detailed.details[0].problem


def test_a_step_of_an_ink_file_adds_a_drawing_that_lies_beside_it(svg, tmp_path) -> None:
    svg(RING)
    canvas = {"width": 800, "height": 600}
    camera = {
        "kind": "perspective",
        "eye": [300, 0, 0],
        "target": [0, 0, 0],
        "up": [0, 0, 1],
        "fov_y": 30.0,
    }
    steps = [{"add": "logo.svg"}, {"set": {"height": 5.0}, "part": "logo 1"}]
    record = {"format": "bozzetto-ink/1", "canvas": canvas, "camera": camera}
    path = tmp_path / "steps.json"
    path.write_text(json.dumps({**record, "strokes": [], "steps": steps}), encoding="utf-8")
    drawing = read_drawing(path)
    bench = Workbench(Registry())
    model = bench.new_model("bozzetto.product", ball(), "ball")
    context = Context(camera=drawing.camera)
    made = list(steps_taken(bench, model, drawing, context))[-1].model
    (emblem,) = made.state.of_kind(Emblem)
    assert emblem.height == 5.0
    np.testing.assert_allclose(emblem.places.points[0], (RADIUS, 0.0, 0.0), atol=1e-2)
    with pytest.raises(UserError, match=r"Step 1.*not there"):
        list(steps_taken(bench, model, replace(drawing, drawings={}), context))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"drawing": {"file": "gone.svg"}}, "gone.svg"),
        ({"drawing": {"file": "../logo.svg"}}, "folder"),
        ({"drawing": "logo.svg"}, "drawing"),
        ({"text": "A"}, "either"),
        ({"height": None}, "height"),
    ],
)
def test_a_file_that_makes_no_sense_names_the_place(svg, tmp_path, values, words) -> None:
    svg(RING)
    with pytest.raises((UserError, FormatError), match=words):
        read(file_of(tmp_path, **values))
