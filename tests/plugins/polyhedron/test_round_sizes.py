"""Diameters and depths of what was drawn round, typed at its rim."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink, Job, Tap
from bozzetto.scene import Label
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.cylinders import walls_of
from bozzetto_polyhedron.model.round_sizes import RimSize, RoundSize
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.solve.round_lines import round_lines
from bozzetto_polyhedron.tools.dimension import DimensionTool
from bozzetto_polyhedron.tools.erase import Erase
from tests.plugins.polyhedron.test_exact_planes import off_planes
from tests.plugins.polyhedron.test_round_things_in_the_window import drawn, drum, turned
from tests.plugins.polyhedron.test_rounds import ink_of, state_of

MODELER = PolyhedronModeler()
ASIDE = Camera(eye=(300.0, -200.0, 250.0))
EXACT = 1e-12


def solid(state):
    (body,) = state.of_kind(Body)
    return solved(body, state)


def touched(state, number: int = 0, view: Camera | None = None):
    """Touch a rim or an arc with *Dimension* where it is seen."""
    (body,) = state.of_kind(Body)
    lines = [line for line in round_lines(body, solid(state)) if len(line.points)]
    view = view or body.strokes[0].camera
    x, y = view.project(lines[number].points[:1])[0][0]
    return DimensionTool().tap(state, Tap(float(x), float(y), view), Context())


def typed(state, **sizes):
    (size,) = state.of_kind(RoundSize)
    return state.with_node(replace(size, **sizes))


def wall_of(state):
    """Return radius and length of the only cylinder, mm."""
    made = solid(state).changed
    (wall,), cut = walls_of(made.body, made.circles)
    assert cut == 0
    return wall.circle.radius, wall.heights[1] - wall.heights[0]


@pytest.mark.parametrize("view", [None, ASIDE])
def test_a_cylinder_has_the_diameter_and_the_height_that_are_typed(view):
    state = touched(turned(drawn(drum())), view=view)
    (size,) = state.of_kind(RimSize)
    radius, height = wall_of(state)
    assert size.diameter == pytest.approx(2.0 * radius, abs=1e-6)
    assert size.depth == pytest.approx(height, abs=1e-6)
    state = typed(state, diameter=83.7, depth=31.3)
    radius, height = wall_of(state)
    assert radius == pytest.approx(83.7 / 2.0, rel=EXACT)
    assert height == pytest.approx(31.3, rel=EXACT)
    assert off_planes(solid(state).body) < 1e-9


@pytest.mark.parametrize("seed", [7301, 7302, 7303])
@pytest.mark.parametrize("name", ["round pocket", "cylinder on a box"])
def test_only_what_is_typed_changes(name, seed):
    state = touched(state_of(ink_of(name, seed)))
    before = solid(state)
    (old,) = before.changed.circles
    (size,) = state.of_kind(RimSize)
    for sizes in ({"diameter": 0.8 * size.diameter}, {"depth": 0.7 * size.depth}):
        state = typed(touched(state_of(ink_of(name, seed))), **sizes)
        found = solid(state)
        (circle,) = found.changed.circles
        radius, height = wall_of(state)
        assert 2.0 * radius == pytest.approx(sizes.get("diameter", size.diameter), rel=EXACT)
        assert height == pytest.approx(sizes.get("depth", size.depth), rel=EXACT)
        assert np.allclose(circle.center, old.center, rtol=0.0, atol=1e-9)
        assert np.allclose(found.base.vertices, before.base.vertices, rtol=0.0, atol=0.0)


def test_a_hole_through_stays_one_and_a_typed_depth_gives_it_a_floor():
    state = touched(state_of(ink_of("hole in a box", 7301)))
    (size,) = state.of_kind(RimSize)
    assert size.depth == 0.0
    wall = wall_of(state)[1]
    wider = typed(state, diameter=1.1 * size.diameter)
    assert wall_of(wider) == pytest.approx((0.55 * size.diameter, wall), rel=1e-9)
    blind = typed(state, depth=0.4 * wall)
    assert wall_of(blind)[1] == pytest.approx(0.4 * wall, rel=EXACT)
    assert len(solid(blind).body.faces) == len(solid(state).body.faces) + 1


def test_an_arc_has_the_diameter_that_is_typed():
    state = touched(state_of(ink_of("rounded edge", 7301)))
    (size,) = state.of_kind(RoundSize)
    assert not isinstance(size, RimSize)
    state = typed(state, diameter=0.6 * size.diameter)
    (circle,) = solid(state).changed.circles
    assert circle.radius == pytest.approx(0.3 * size.diameter, rel=EXACT)


def test_what_was_typed_is_touched_again_shown_and_erased():
    state = typed(touched(turned(drawn(drum()))), diameter=20.0, depth=500.0)
    again = touched(replace(state, selected=""), 1)
    (size,) = again.of_kind(RoundSize)
    assert again.selected == size.id
    scene = MODELER.scene(again, MODELER.solve(again, Job()))
    labels = [
        item.text for layer in scene.layers for item in layer.items if isinstance(item, Label)
    ]
    assert labels == ["diameter 20 mm, depth 500 mm"]
    (body,) = state.of_kind(Body)
    line = round_lines(body, solid(state))[0]
    path = ASIDE.project(line.points)[0]
    assert not Erase().draw(state, Ink((Stroke(*path.T, ASIDE),)), Context()).of_kind(Body)


def test_a_rim_drawn_anew_has_the_size_that_was_typed():
    """The name is a place on the curve: strokes may come and go before it."""
    state = typed(touched(state_of(ink_of("cylinder on a box", 7301))), diameter=12.0)
    (body,) = state.of_kind(Body)
    other = replace(body, strokes=type(body.strokes)(list(body.strokes)[::-1]))
    assert wall_of(state.with_node(other))[0] == pytest.approx(6.0, rel=EXACT)


def test_a_size_that_leaves_nothing_is_told_and_the_rest_stays():
    state = typed(touched(state_of(ink_of("rounded edge", 7301))), diameter=1e6)
    found = solid(state)
    assert not found.changed.circles
    assert any("arc is left out" in each for each in found.changed.told)


def test_a_round_end_is_as_wide_as_its_body():
    state = state_of(ink_of("rounded end", 7300))
    with pytest.raises(UserError, match="as wide as its body"):
        touched(state)
