"""The drawing tool: the curve that grows under the pen, and what is said after each stroke."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink, Job, Tap
from bozzetto.scene import Lines, Scene
from bozzetto.view import Camera
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.draw_curve import DrawCurve, rungs
from bozzetto_symmetry.view.hints import FIRST
from tests.plugins.symmetry import scenes as s
from tests.previews import preview_of

VIEW = s.camera(35, 20)
RAIL = s.PAIRS["roof rail"]
TOOL = DrawCurve()


def gesture(curve: np.ndarray, view: Camera = VIEW, share: float = 1.0, **hand) -> Ink:
    pixels = s.drawn(curve, view, **hand)
    pixels = pixels[: max(2, round(share * len(pixels)))]
    return Ink((Stroke(pixels[:, 0], pixels[:, 1], view),))


def after(state: SymmetryState, ink: Ink) -> SymmetryState:
    return TOOL.apply(state, ink, Context(camera=VIEW))


def preview(state: SymmetryState, ink: Ink) -> Scene:
    return preview_of(TOOL, state, ink, Context(camera=VIEW))


def layer(scene: Scene, name: str) -> tuple[Lines, ...]:
    (items,) = (layer.items for layer in scene.layers if layer.name == name)
    return items


@pytest.fixture(scope="module")
def waiting() -> SymmetryState:
    return after(SymmetryState(), gesture(RAIL))


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("share", [0.4, 1.0])
def test_the_curve_grows_in_space_while_its_second_side_is_drawn(waiting, sense, share) -> None:
    scene = preview(waiting, gesture(RAIL * MIRROR, sense=sense, share=share))
    near, far = (item.points for item in layer(scene, "heat"))
    assert np.median(s.distances(near, RAIL)) < 0.005 * s.DIAGONAL
    assert np.allclose(far, near * MIRROR, atol=1e-4)
    length = np.linalg.norm(np.diff(near, axis=0), axis=1).sum()
    whole = np.linalg.norm(np.diff(RAIL, axis=0), axis=1).sum()
    assert length == pytest.approx(share * whole, rel=0.2)


def test_what_has_grown_depends_on_the_ink_alone(waiting) -> None:
    """However often it was asked for, and also where the pen was somewhere else before."""
    whole, other = gesture(RAIL * MIRROR), gesture(RAIL * MIRROR + [0.0, 0.0, 6.0])
    shares = [gesture(RAIL * MIRROR, share=share) for share in (0.2, 0.5, 0.8)]
    growing = TOOL.begin(waiting, Context(camera=VIEW))
    for ink in (*shares, whole, other, shares[0], whole):
        shown, anew = growing.update(ink), preview(waiting, ink)
        assert shown.layers
        for name in ("ghost", "heat"):
            for one, two in zip(layer(shown, name), layer(anew, name), strict=True):
                assert np.array_equal(one.points, two.points)


def test_rungs_are_square_to_the_plane_and_end_on_the_curve(waiting) -> None:
    scene = preview(waiting, gesture(RAIL * MIRROR))
    (ladder,) = layer(scene, "ghost")
    ends = ladder.points.reshape(-1, 2, 3)
    assert len(ends) >= 6
    assert np.allclose(ends[:, 0], ends[:, 1] * MIRROR, atol=1e-4)
    near, _ = (item.points for item in layer(scene, "heat"))
    away = np.linalg.norm(ends[:, 0, None] - near, axis=2).min(axis=1)
    assert away.max() < 1e-4
    assert np.allclose(ends[[0, -1], 0], near[[0, -1]], atol=1e-4)


def test_rungs_stand_at_even_ways_however_the_places_lie() -> None:
    along = np.sort(np.random.default_rng(4).uniform(0.0, 100.0, 2000))
    line = np.column_stack((along, np.full(2000, 7.0), np.zeros(2000)))
    found = rungs(line, 10.0)
    assert np.allclose(np.diff(found[:, 0, 0]), 10.0, atol=1.5)
    assert np.all(found[:, 0, 1] == -found[:, 1, 1])


def test_rungs_of_a_still_pen() -> None:
    assert len(rungs(np.ones((3, 3)), 10.0)) >= 1


def test_nothing_grows_from_another_view_or_a_hidden_curve_or_the_eraser(waiting) -> None:
    assert not preview(waiting, gesture(RAIL * MIRROR, s.camera(50, 20))).layers
    nodes = tuple(replace(n, visible=False) for n in waiting.nodes)
    hidden = replace(waiting, nodes=nodes, snapping=False)
    assert not preview(hidden, gesture(RAIL * MIRROR)).layers
    (stroke,) = gesture(RAIL * MIRROR).strokes
    rubbed = Stroke(stroke.x, stroke.y, VIEW, tool="eraser")
    assert not preview(waiting, Ink((rubbed,))).layers
    assert not preview(waiting, Tap(3.0, 4.0, VIEW)).layers


def test_a_curve_is_solved_once_however_many_ask_for_it(waiting, monkeypatch) -> None:
    from bozzetto_symmetry.modeler import Symmetry
    from bozzetto_symmetry.solve import curve_solver as trace

    random = np.random.default_rng(8)
    again = gesture(RAIL, noise=1.0, random=random)
    state = after(waiting, again)
    assert len(state.curves) == 1
    asked: list[str] = []
    views_of = trace.views_of
    monkeypatch.setattr(trace, "views_of", lambda *some: asked.append("") or views_of(*some))
    Symmetry().solve(state, Job())
    said(state)
    assert asked == []


def test_a_tap_is_no_curve(waiting) -> None:
    with pytest.raises(UserError, match=TOOL.hint):
        TOOL.apply(waiting, Tap(3.0, 4.0, VIEW), Context(camera=VIEW))


# -- what is said -------------------------------------------------------------------------------


def said(state: SymmetryState) -> str:
    return TOOL.next_step(state).sentence


def test_an_empty_box_asks_for_the_first_side() -> None:
    assert said(SymmetryState()) == FIRST == TOOL.hint


def test_one_side_asks_for_its_mirror_image(waiting) -> None:
    assert "draw its mirror image" in said(waiting).lower()
    (curve,) = waiting.curves
    asked = waiting.with_node(replace(curve, reading="half"))
    words = said(asked).lower()
    assert words.startswith("one side")
    assert words.count("draw its mirror image") == 1


def test_both_sides_are_said_to_belong_together(waiting) -> None:
    both = after(waiting, gesture(RAIL * MIRROR))
    assert "Left and right belong together." in said(both)
    assert "mirror image" not in said(both)


def test_the_keys_that_are_named_are_those_of_the_commands(waiting) -> None:
    from bozzetto_symmetry.commands import all_commands
    from bozzetto_symmetry.view.hints import OTHERWISE, UNDECIDED

    keys = {command.id: command.key for command in all_commands()}
    assert f"Press {keys['switch-reading']} " in OTHERWISE
    assert f"Press {keys['other-matching']} " in UNDECIDED


def test_where_no_curve_is_chosen_or_it_is_hidden_the_first_words_are_said(waiting) -> None:
    assert said(replace(waiting, selected="")) == FIRST
    hidden = replace(waiting, nodes=tuple(replace(n, visible=False) for n in waiting.nodes))
    assert said(hidden) == FIRST


def test_warnings_come_first(waiting) -> None:
    (curve,) = waiting.curves
    (far,) = gesture(RAIL * MIRROR, trimmed=0.4).strokes
    both = replace(curve, strokes=curve.strokes.extended((far,)), reading="pair")
    short = waiting.with_node(both)
    warnings = trace_of(short.curves[0], short).warnings
    assert warnings
    assert said(short).startswith(warnings[0])


def test_what_cannot_be_is_said_with_what_to_do_instead() -> None:
    aside = s.camera(0, 20)  # the eye is on the plane
    state = after(SymmetryState(), gesture(RAIL, aside))
    (curve,) = state.curves
    wrong = state.with_node(replace(curve, reading="pair"))
    with pytest.raises(UserError) as refused:
        trace_of(wrong.curves[0], wrong)
    assert said(wrong) == refused.value.message


def test_rungs_of_a_curve_beyond_all_bounds_are_not_beyond_number() -> None:
    """What is drawn at an extreme zoom may be as long as the way to the sun."""
    line = np.column_stack((np.linspace(0.0, 1.5e14, 60), np.full(60, 3.0), np.zeros(60)))
    assert 2 <= len(rungs(line, 20.0)) <= 60
