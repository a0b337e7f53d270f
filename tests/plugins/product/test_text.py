"""Text on surfaces: laid by a touch, moved, turned and sized, kept and erased."""

from __future__ import annotations

from dataclasses import replace

import manifold3d
import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Ink, Job, Tap
from bozzetto.scene import Handle, Label
from bozzetto.view import Camera
from bozzetto_product.details.emblem_places import anchored
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.lettering.text_outlines import text_outlines
from bozzetto_product.model.details import Detail
from bozzetto_product.model.emblems import Emblem, FlatOutlines
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.tools.emblem import LayText
from bozzetto_product.tools.erase import Erase
from tests.plugins.product.detail_kit import RADIUS, ball, ball_curves, body, grounds, manifold

PRODUCT = ProductModeler()
TOOL = LayText()
FRONT = Camera(eye=(300.0, 0.0, 0.0), target=(0.0, 0.0, 0.0))
MIDDLE = FRONT.project(np.zeros((1, 3)))[0][0]


def signed_area(row: np.ndarray) -> float:
    x, y = row.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def touched(text: str = "I") -> ProductState:
    """The ball with a text that was laid by a touch, small and named."""
    state = TOOL.tap(ball(), Tap(*MIDDLE, FRONT), Context())
    emblem = state.chosen_of(Emblem)
    assert emblem is not None
    return state.with_node(replace(emblem, text=text, height=8.0, depth=1.0))


def test_letters_have_the_height_of_capitals_and_their_holes() -> None:
    found = text_outlines("HO")
    assert not found.missing
    assert [np.sign(signed_area(row)) for row in found.rows[1:]] in ([-1, 1], [1, -1])
    assert np.ptp(found.rows[0][:, 1]) == pytest.approx(1.0)
    assert len(found.rows) == 3
    assert (found.rows[1].min(axis=0) > found.rows[0].max(axis=0) * (1, -1)).all()


def test_straight_sides_of_letters_are_straight_and_their_ends_corners() -> None:
    (row,) = text_outlines("I").rows
    (corners,) = text_outlines("I").corners
    assert corners.sum() == 4
    assert abs(signed_area(row)) == pytest.approx(np.prod(np.ptp(row, axis=0)))


def test_pairs_of_letters_come_together() -> None:
    width = [np.ptp(np.concatenate(text_outlines(text).rows)[:, 0]) for text in ("AV", "AHV")]
    alone = np.ptp(np.concatenate(text_outlines("H").rows)[:, 0])
    assert width[0] < width[1] - alone


@pytest.mark.parametrize("text", ["", "   ", "漢字", "\n"])
def test_a_text_without_letters_has_no_outlines(text: str) -> None:
    assert text_outlines(text).rows == ()


def test_a_touch_lays_a_text_upright_under_the_pen() -> None:
    state = touched("I")
    emblem = state.chosen_of(Emblem)
    assert emblem is not None
    assert emblem.places is not None
    at, above = emblem.places.points
    np.testing.assert_allclose(at, (RADIUS, 0.0, 0.0), atol=1e-3 * RADIUS)
    assert (above - at)[2] / np.linalg.norm(above - at) > 0.999
    volumes = []
    around = manifold3d.Manifold.cube((20.0, 24.0, 24.0), True).translate((RADIUS, 0.0, 0.0))
    for kind in ("in", "raised"):
        made = manifold(body(state.with_node(replace(emblem, kind=kind))).mesh)
        assert made.status() == manifold3d.Error.NoError
        # Around the letter alone: elsewhere both have other triangles, and so another volume.
        volumes.append((made ^ around).volume())
    (row,) = text_outlines("I").rows
    # The walls lean by three degrees: a letter is about a fifth as wide as it is high.
    floor = np.prod(np.ptp(row, axis=0) * 8.0 - 2.0 * np.tan(np.radians(3.0)))
    assert 2.0 * floor < volumes[1] - volumes[0] < 2.0 * abs(signed_area(row)) * 8.0**2


def test_a_touch_beside_all_surfaces_says_so() -> None:
    with pytest.raises(UserError, match="Touch a surface"):
        TOOL.tap(ball(), Tap(2.0, 2.0, FRONT), Context())


def handles(state: ProductState) -> dict[str, Handle]:
    scene = PRODUCT.scene(state, PRODUCT.solve(state, Job("preview")))
    (layer,) = (layer for layer in scene.layers if layer.name == "text handles")
    return {item.id: item for item in layer.items if isinstance(item, Handle)}


def dragged(state: ProductState, handle: str, goal: np.ndarray) -> ProductState:
    start = FRONT.project(np.array([handles(state)[handle].point]))[0][0]
    path = np.stack((start, goal))
    return TOOL.drag(state, Drag(handle, Stroke(path[:, 0], path[:, 1], FRONT)), Context())


def test_the_middle_moves_a_text_over_the_surface() -> None:
    state = touched()
    goal = MIDDLE + np.array((60.0, -40.0))
    moved = handles(dragged(state, "text middle", goal))["text middle"].point
    assert np.linalg.norm(moved) == pytest.approx(RADIUS, rel=1e-3)
    np.testing.assert_allclose(FRONT.project(np.array([moved]))[0][0], goal, atol=0.5)


def test_the_corner_turns_and_sizes_a_text() -> None:
    state = touched()
    corner = FRONT.project(np.array([handles(state)["text corner"].point]))[0][0]
    way = corner - MIDDLE
    # On the sheet y points down: a quarter turn to the left.
    goal = MIDDLE + 1.5 * np.array((way[1], -way[0]))
    emblem = dragged(state, "text corner", goal).chosen_of(Emblem)
    assert emblem is not None
    assert emblem.turn == pytest.approx(90.0, abs=0.5)
    assert emblem.height == pytest.approx(1.5 * 8.0, rel=5e-3)


def test_a_drag_off_the_surface_is_refused() -> None:
    with pytest.raises(UserError, match="Touch a surface"):
        dragged(touched(), "text middle", np.array((2.0, 2.0)))


def test_outlines_are_kept_whatever_letters_there_are() -> None:
    drawn = FlatOutlines(np.eye(3)[:, :2], np.ones(3, np.uint8), np.zeros(1, np.int32), "I")
    emblem = Emblem(text="I", flat=drawn)
    assert emblem.flat is drawn
    changed = replace(emblem, text="A").flat
    assert changed is not None
    assert changed.text == "A"
    assert replace(emblem, text="").flat is None


def test_letters_that_are_missing_are_told_and_the_rest_is_carved() -> None:
    (one,) = PRODUCT.solve(touched("I漢"), Job()).detailed.details
    assert not one.problem
    assert "漢" in one.told
    (none,) = PRODUCT.solve(touched("漢"), Job()).detailed.details
    assert "Type a text" in none.problem


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_text_that_hangs_over_is_seen_where_it_is_and_says_so(mirrored: bool) -> None:
    """Of a text as wide as the ball is neither carved nor hidden: lines and a label are shown."""
    state = touched("WWWW")
    emblem = state.chosen_of(Emblem)
    assert emblem is not None
    state = state.with_node(replace(emblem, height=0.6 * RADIUS, mirrored=mirrored))
    result = PRODUCT.solve(state, Job())
    told = result.detailed.details
    assert [one.mirrored for one in told] == [False, True][: 1 + mirrored]
    for one in told:
        assert "beside the surfaces" in one.problem
        points = np.concatenate(one.outlines)
        np.testing.assert_allclose(points[:, 0], RADIUS, rtol=1e-3)  # the tangent plane
        assert np.ptp(points[:, 2]) == pytest.approx(0.6 * RADIUS, rel=1e-6)
        for row in one.outlines:
            np.testing.assert_array_equal(row[0], row[-1])
    layer = next(one for one in PRODUCT.scene(state, result).layers if one.name == "outlines")
    labels = [item.text for item in layer.items if isinstance(item, Label)]
    assert labels == ["A part of it is beside the surfaces"] * len(told)


def test_a_file_lays_a_text() -> None:
    text = {"text": "I", "at": [RADIUS, 0, 0], "up": [0, 0, 1], "height": 8, "depth": 1}
    state = product_of_network({"network": {"curves": ball_curves(), "details": [text]}})
    result = PRODUCT.solve(state, Job())
    (one,) = result.detailed.details
    assert not one.problem
    assert np.ptp(np.concatenate(one.outlines)[:, 2]) == pytest.approx(8.0, rel=0.02)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"text": ""}, "text"),
        ({"text": "I" * 61}, "characters"),
        ({"text": 3}, "text"),
        ({"text": "I"}, "height"),
        ({"text": "I", "height": 8, "up": [0, 0, 0]}, "no length"),
        ({"text": "I", "height": 8, "turn": 999}, "turn"),
    ],
)
def test_a_text_in_a_file_that_makes_no_sense_is_refused(given: dict, sentence: str) -> None:
    detail = {"at": [RADIUS, 0, 0], **given}
    with pytest.raises(UserError, match=sentence):
        product_of_network({"network": {"curves": ball_curves(), "details": [detail]}})


def test_the_eraser_takes_what_it_goes_over_and_no_detail_behind() -> None:
    way = np.ones(3) / np.sqrt(3.0)
    camera = Camera(eye=tuple(300.0 * way), target=(0.0, 0.0, 0.0))
    state, up = ball(), np.array((0.0, 0.0, 1.0))
    for sense in (1.0, -1.0):
        places = anchored(grounds(ball()), sense * RADIUS * way, up)
        emblem = Emblem(state.unused_id(), state.unused_name("Text"), text="I", places=places)
        state = state.with_node(emblem)
    middle = camera.project(RADIUS * way[None])[0][0]
    across = middle + np.column_stack((np.linspace(-9.0, 9.0, 20), np.linspace(-9.0, 9.0, 20)))
    over = Stroke(across[:, 0], across[:, 1], camera)
    after = Erase().draw(state, Ink((over,)), Context())
    assert [one.name for one in after.of_kind(Detail)] == ["Text 2"]
    lit = Erase().preview(state, Ink((over,)), Context())
    assert len(lit.layers[0].items) == 1
    aside = Stroke(across[:, 0] + 30.0, across[:, 1], camera)
    with pytest.raises(UserError, match="no curve and no detail"):
        Erase().draw(state, Ink((aside,)), Context())
