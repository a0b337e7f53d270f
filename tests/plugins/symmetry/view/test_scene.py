"""What is shown: curves and images, how sure they are, and what waits for its other side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Job
from bozzetto.scene import Lines, Scene
from bozzetto_symmetry.model.state import Curve, SymmetryState, Trim
from bozzetto_symmetry.modeler import Symmetry
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import scenes as s

VIEW = s.camera(35, 20)
RAIL = s.PAIRS["roof rail"]


def curve(name: str, *drawn: np.ndarray, **facts) -> Curve:
    strokes = [Stroke(*VIEW.project(one)[0].T, VIEW) for one in drawn]
    return Curve(id=name, name=name, strokes=Strokes(strokes), **facts)


@pytest.fixture(scope="module")
def state() -> SymmetryState:
    """A pair (chosen), a curve across, and a side that waits."""
    made = SymmetryState()
    for one in (
        curve("screen", s.ACROSS["windscreen base"], color=(1, 2, 3)),
        curve("arch", s.PAIRS["wheel arch"], reading="half"),
        curve("rail", RAIL, RAIL * MIRROR),
    ):
        made = made.with_node(one)
    return made


def shown(state: SymmetryState) -> Scene:
    modeler = Symmetry()
    return modeler.scene(state, modeler.solve(state, Job()))


def lines(scene: Scene, name: str) -> list[Lines]:
    return [i for layer in scene.layers if layer.name == name for i in layer.items]


def test_a_pair_is_two_lines_that_mirror_each_other(state) -> None:
    near, far = lines(shown(state), "chosen curve")
    assert (near.color, far.color) == ("accent", "second")
    assert np.allclose(far.points, near.points * MIRROR, atol=1e-3)
    assert np.median(s.distances(near.points, RAIL)) < 5e-4 * s.DIAGONAL


def test_lines_are_smooth_from_all_sides(state) -> None:
    """Also where the view in which the curve was drawn foreshortens its bends."""
    near = lines(shown(state), "chosen curve")[0].points
    steps = np.diff(near.astype(float), axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    bends = np.degrees(np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1.0, 1.0)))
    assert bends.max() < 6.0


def test_a_curve_has_its_colour_and_while_it_is_chosen_a_wider_line_over_it(state) -> None:
    scene = shown(replace(state, selected="screen"))
    (own,) = (item for item in lines(scene, "curves") if item.color == (1, 2, 3))
    (over,) = lines(scene, "chosen curve")
    assert over.color == "accent"
    assert over.width > own.width
    assert np.array_equal(over.points, own.points)
    names = [layer.name for layer in scene.layers]
    assert names.index("chosen curve") > names.index("curves")
    assert all(layer.chosen for layer in scene.layers if layer.name == "chosen curve")


def test_only_the_chosen_curve_shows_how_sure_it_is(state) -> None:
    points = np.concatenate([item.points for item in lines(shown(state), "heat")])
    both = np.vstack((RAIL, RAIL * MIRROR))
    away = np.linalg.norm(points[:, None] - both, axis=2).min(axis=1)
    assert away.max() < 0.01 * s.DIAGONAL
    assert not lines(shown(replace(state, selected="")), "heat")
    assert not lines(shown(replace(state, selected="arch")), "heat")


def test_a_side_that_waits_shows_the_rays_on_which_it_must_lie(state) -> None:
    ink, rays = lines(shown(state), "waiting")
    pixels = VIEW.project(s.PAIRS["wheel arch"])[0]
    for item in (ink, rays):
        seen = VIEW.project(item.points.astype(float))[0]
        off = np.linalg.norm(seen[:, None] - pixels, axis=2).min(axis=1)
        assert off.max() < 1.5, "every ray is a point where it was drawn"
    ends = rays.points.reshape(-1, 2, 3)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min() > 20.0


def test_ink_without_a_partner_is_shown_where_it_was_drawn() -> None:
    short = (RAIL * MIRROR)[:180]
    made = SymmetryState().with_node(curve("rail", RAIL, short, reading="pair"))
    (loose,) = lines(shown(made), "loose ends")
    assert loose.color == "warning"
    ink = VIEW.project(RAIL)[0]
    seen = VIEW.project(loose.points.astype(float))[0]
    assert np.linalg.norm(seen[:, None] - ink, axis=2).min(axis=1).max() < 1.5
    assert np.linalg.norm(seen[:, None] - ink[-1], axis=2).min() < 1.5, "up to the ink's end"
    length = np.linalg.norm(np.diff(seen, axis=0), axis=1).sum()
    whole = np.linalg.norm(np.diff(ink[180:], axis=0), axis=1).sum()
    assert length == pytest.approx(whole, rel=0.25)
    (bare,) = made.curves
    trimmed = made.with_node(replace(bare, edits=(Trim(0.0, 0.5),)))
    assert not lines(shown(trimmed), "loose ends"), "what was cut off is not loose"


def test_a_curve_that_matches_has_no_loose_ends(state) -> None:
    assert not lines(shown(state), "loose ends")


def test_hidden_curves_are_not_shown(state) -> None:
    hidden = replace(state, nodes=tuple(replace(n, visible=False) for n in state.nodes))
    names = {layer.name for layer in shown(hidden).layers}
    assert not names & {"curves", "heat", "ghost", "waiting"}


def test_before_it_is_solved_there_is_the_box_alone(state) -> None:
    names = [layer.name for layer in Symmetry().scene(state, None).layers]
    assert "box" in names
    assert "curves" not in names


def test_a_box_of_which_nothing_is_said_stands_on_the_ground() -> None:
    from bozzetto.plugin import Context

    def low(facts: dict) -> float:
        made = Symmetry().create(Context(camera=VIEW, facts=facts))
        return made.centre[2] - 0.5 * made.height

    assert low({}) == 0.0
    assert low({"box": [60, 40, 20]}) == -10.0
    assert low({"box": {"center": [0, 0, 7], "size": [60, 40, 20]}}) == -3.0
