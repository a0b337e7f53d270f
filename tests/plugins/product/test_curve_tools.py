"""The tools on curves by pen and by steps: redraw, split, join, and the plane of new curves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import distances_to_polyline
from bozzetto.plugin import Context, Job, Tap
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen, Shell
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.rough_shapes import FollowedShape, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.operations.meetings import spline_of, splines_of
from bozzetto_product.projection.planes import heights
from bozzetto_product.projection.views import seen_at
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.all_tools import all_tools
from bozzetto_product.tools.draw_curve import DrawCurve
from bozzetto_product.tools.move import Move
from tests.plugins.product.drawn_curves import misses
from tests.plugins.product.pen_strokes import FRONT, TOP_EDGES, draw_along, draw_rectangle, straight
from tests.plugins.product.test_product_ink import BOX, RECTANGLE, built, stroke

PEN = Pen(tremor=0.4, seed=2024)

TOP = 60.0
"""Height of the top of the box, mm."""


@pytest.fixture
def shell(tmp_path: Path) -> Shell:
    made = Shell(Registry(), tmp_path)
    made.open("bozzetto.product")
    made.camera = FRONT
    return made


def _at(*place: float) -> list[float]:
    x, y = seen_at(FRONT, [place])[0]
    return [float(x), float(y)]


def _curve(state: ProductState, name: str) -> Curve:
    return next(curve for curve in state.of_kind(Curve) if curve.name == name)


def test_a_stretch_is_drawn_anew_and_the_surface_stays(shell: Shell) -> None:
    """The front edge gets a dent; what was not drawn over is where it was, and undo brings all."""
    draw_rectangle(shell, PEN)
    before = shell.state
    dent = straight((-20.0, -30.0, TOP), (20.0, -30.0, TOP), 60)
    dent[:, 1] += 12.0 * np.sin(np.linspace(0.0, np.pi, 60)) ** 0.5
    draw_along(shell, PEN, dent, tool="redraw")
    after = shell.state
    image = seen_at(FRONT, _curve(after, "Curve 1").spline.sampled(600))
    assert distances_to_polyline(seen_at(FRONT, dent[8:-8]), image).max() <= 4.0
    assert len(after.of_kind(Patch)) == len(before.of_kind(Patch)) == 1
    assert misses(after) == 0.0
    old, new = (_curve(state, "Curve 1").spline for state in (before, after))
    ends = [0.0, 0.03, 0.97, 1.0]
    assert np.abs(old.value(ends) - new.value(ends)).max() <= 1e-9
    shell.undo()
    assert shell.state == before


def test_a_touch_cuts_a_curve_there(shell: Shell) -> None:
    draw_rectangle(shell, PEN)
    before = shell.state
    shell.tap(*_at(10.0, -30.0, TOP), tool="split")
    after = shell.state
    assert len(after.of_kind(Curve)) == 5
    assert misses(after) == 0.0
    assert len(after.of_kind(Patch)) == 1
    cut = spline_of(after, _curve(before, "Curve 1").id).control_points[-1]
    assert np.linalg.norm(cut - (10.0, -30.0, TOP)) <= 1.5
    with pytest.raises(UserError, match="no curve here"):
        shell.tap(5.0, 5.0, tool="split")


def test_who_draws_on_another_object_is_told_how_surfaces_within_it_are_seen(shell: Shell) -> None:
    draw = DrawCurve()
    draw_rectangle(shell, PEN)
    assert shell.state.of_kind(Patch)
    own = draw.next_step(shell.state).sentence
    followed = shell.state.with_node(FollowedShape("f1", "Drawn on", source="m1"))
    assert "Hide" in draw.next_step(followed).sentence
    assert "Hide" not in own
    (rough,) = shell.state.of_kind(RoughShape)
    only_drawn_on = shell.state.without_nodes(rough.id)  # on an object that it does not follow
    assert "within what they were drawn on" in draw.next_step(only_drawn_on).sentence


def test_ends_that_nearly_meet_are_offered_and_joined(shell: Shell) -> None:
    """The last edge stops 6 mm before the corner: too far for the magnet."""
    shell.camera = FRONT
    for start, end in TOP_EDGES[:3]:
        draw_along(shell, PEN, straight(start, end))
    start, end = (np.array(place) for place in TOP_EDGES[3])
    draw_along(shell, PEN, straight(start, end - 0.1 * (end - start)))
    before = shell.state
    assert not before.of_kind(Patch)
    step = DrawCurve().next_step(before)
    assert step.tool == "join"
    assert step.place is not None
    shell.tap(*_at(*(end - 0.09 * (end - start))), tool="join")
    after = shell.state
    assert len(after.joints) == len(before.joints) + 1
    assert misses(after) == 0.0
    assert len(after.of_kind(Patch)) == 1
    with pytest.raises(UserError, match="nearly meets"):
        shell.tap(*_at(*end), tool="join")


def test_curves_are_drawn_in_the_plane_of_three_places(tmp_path: Path) -> None:
    """A slanting plane through two corners of the top and the foot of the box, by steps."""
    places = [(-50.0, -30.0, TOP), (50.0, -30.0, TOP), (0.0, -40.0, 10.0)]
    normal = np.cross(np.subtract(places[1], places[0]), np.subtract(places[2], places[0]))
    across = straight((-30.0, -33.0, 40.0), (30.0, -33.0, 40.0))
    steps = [*({"tool": "plane", "tap": _at(*place)} for place in places)]
    _, model = built(tmp_path, [*steps, {"tool": "draw", "strokes": [4]}], [stroke(across)])
    (curve,) = model.state.of_kind(Curve)
    assert model.state.lay == "plane"
    assert curve.plane is not None
    assert abs(np.dot(curve.plane.normal, normal / np.linalg.norm(normal))) >= 1.0 - 1e-4
    assert np.abs(heights(curve.spline.control_points, curve.plane)).max() <= 1e-9
    again = [*steps, {"set": {"lay": "surface"}}, {"tool": "draw", "strokes": [4]}]
    _, model = built(tmp_path, again, [stroke(across)])
    (curve,) = model.state.of_kind(Curve)
    assert curve.plane is None
    assert np.abs(curve.spline.control_points[:, 1] + 40.0).max() <= 0.1  # on the box's front


def test_a_plane_needs_three_places_beside_one_another(shell: Shell) -> None:
    for share in (-40.0, 0.0):
        shell.tap(*_at(share, -30.0, TOP), tool="plane")
    with pytest.raises(UserError, match="on a line"):
        shell.tap(*_at(0.0, -30.0, TOP), tool="plane")
    with pytest.raises(UserError, match="nothing here"):
        shell.tap(4.0, 4.0, tool="plane")
    assert len(shell.state.plane_places) == 2
    shell.undo()
    assert len(shell.state.plane_places) == 1


def test_a_curve_stands_upright_on_the_surface(tmp_path: Path) -> None:
    """An arch over the top of the box, from place to place of it."""
    arch = straight((-30.0, -10.0, TOP), (30.0, 10.0, TOP), 60)
    arch[:, 2] += 40.0 * np.sin(np.linspace(0.0, np.pi, 60))
    steps = [{"set": {"lay": "upright"}}, {"tool": "draw", "strokes": [4]}]
    _, model = built(tmp_path, steps, [stroke(arch)])
    (curve,) = model.state.of_kind(Curve)
    assert curve.plane is not None
    assert abs(curve.plane.normal[2]) <= 1e-6
    off = np.linalg.norm(curve.spline.sampled(200)[:, None] - arch, axis=2).min(axis=1)
    assert off.max() <= 3.0


def test_a_curve_over_an_edge_is_cut_there_and_lies_on_both_faces(tmp_path: Path) -> None:
    down = np.vstack((straight((0, 10, TOP), (0, -40, TOP)), straight((0, -40, TOP), (0, -40, 20))))
    steps = [{"tool": "draw", "strokes": [4]}, {"command": "split-creases"}]
    _, model = built(tmp_path, steps, [stroke(down)])
    assert len(model.state.of_kind(Curve)) == 2
    assert misses(model.state) == 0.0
    top, front = splines_of(model.state).values()
    assert np.abs(top.sampled(60)[:, 2] - TOP).max() <= 0.5
    assert np.abs(front.sampled(60)[:, 1] + 40.0).max() <= 0.5


@pytest.mark.parametrize("command", ["split-creases", "straighten", "planar", "in-plane"])
def test_what_was_guessed_of_a_curve_is_not_said_once_it_is_laid_anew(
    tmp_path: Path, command: str
) -> None:
    down = np.vstack((straight((0, 10, TOP), (0, -40, TOP)), straight((0, -40, TOP), (9, -40, 20))))
    drawing = {"tool": "draw", "strokes": [4]}
    _, before = built(tmp_path, [drawing], [stroke(down)])
    (curve,) = before.state.of_kind(Curve)
    assert "over an edge" in curve.told[0]
    _, after = built(tmp_path, [drawing, {"command": command}], [stroke(down)])
    assert all(curve.told == () for curve in after.state.of_kind(Curve))
    assert after.state.selected == before.state.selected


@pytest.mark.parametrize("command", ["offset", "fillet"])
def test_what_was_guessed_of_a_curve_is_not_said_of_another_made_of_it(
    tmp_path: Path, command: str
) -> None:
    down = np.vstack((straight((0, 10, TOP), (0, -40, TOP)), straight((0, -40, TOP), (0, -40, 20))))
    side = straight((0, 10, TOP), (40, 10, TOP))
    steps = [
        {"tool": "draw", "strokes": [4]},
        {"tool": "draw", "strokes": [5]},
        {"select": "Curve 1"},
        {"set": {"rounding": 1.0, "spacing": 1.0}},
        {"command": command},
    ]
    _, model = built(tmp_path, steps, [stroke(down), stroke(side)])
    known = {curve.name: curve.told for curve in model.state.of_kind(Curve)}
    assert sorted(known) == ["Curve 1", "Curve 2", "Curve 3"]
    assert "over an edge" in known["Curve 1"][0]
    assert known["Curve 3"] == ()


def test_make_planar_takes_the_plane_that_is_set(tmp_path: Path) -> None:
    places = [(-50.0, -30.0, TOP), (50.0, -30.0, TOP), (0.0, -40.0, 10.0)]
    steps = [
        *RECTANGLE,
        *({"tool": "plane", "tap": _at(*place)} for place in places),
        {"select": "Curve 2"},
        {"command": "planar"},
    ]
    _, model = built(tmp_path, steps, template=BOX)
    curve = _curve(model.state, "Curve 2")
    assert curve.plane is not None
    assert abs(curve.plane.normal[2]) < 0.5
    assert misses(model.state) == 0.0


def test_every_tool_has_its_icon_and_says_what_to_do() -> None:
    folder = Path(__file__).parents[3] / "plugins" / "bozzetto_product"
    for tool in all_tools():
        assert (folder / tool.icon).is_file()
        assert tool.next_step(ProductState()).sentence


def test_a_curve_behind_a_surface_is_not_touched(shell: Shell) -> None:
    """Seen from above, a curve beneath the surface of the rectangle is hidden by it."""
    draw_rectangle(shell, PEN)
    under = Spline.uniform(np.linspace((-60.0, 95.0, 5.0), (-10.0, 95.0, 5.0), 5))
    hidden = Curve(id="hidden", name="Hidden", spline=under)
    state = shell.state.with_node(hidden)
    scene = ProductModeler().scene(state, solve_product(state, Job()))
    context = Context(camera=FRONT, scene=scene)
    x, y = _at(-35.0, 95.0, 5.0)
    touched = Move().tap(state, Tap(x, y, FRONT), context)
    assert isinstance(touched.node(touched.selected), Patch)
    bare = state.without_nodes(*(patch.id for patch in state.of_kind(Patch)))
    scene = ProductModeler().scene(bare, solve_product(bare, Job()))
    touched = Move().tap(bare, Tap(x, y, FRONT), Context(camera=FRONT, scene=scene))
    assert touched.selected == "hidden"
