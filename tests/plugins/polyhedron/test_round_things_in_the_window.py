"""Round things as a person meets them: drawn, touched at a rim, shown, erased."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink, Job, Tap
from bozzetto.scene import LIGHT, Points
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.panel.answer_pictures import gallery_of
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.solve.round_lines import round_lines
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.erase import Erase
from bozzetto_polyhedron.tools.turn_solid import TurnSolid
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.test_folds import read
from tests.plugins.polyhedron.test_rounds import ink_of

MODELER = PolyhedronModeler()
ALONE = Context(alone=True)
RIM = (600.0, 350.0)
ASIDE = Camera(eye=(300.0, -200.0, 250.0))


def ring(center, wide: float, high: float) -> np.ndarray:
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    return np.column_stack((center[0] + wide * np.cos(turn), center[1] + high * np.sin(turn)))


def drum() -> list[np.ndarray]:
    """Return a cylinder that stands: two level ellipses, and two sides."""
    sides = [np.linspace((x, 300.0), (x, 600.0), 40) for x in (450.0, 750.0)]
    return [ring((600.0, 300.0), 150.0, 50.0), ring((600.0, 600.0), 150.0, 50.0), *sides]


def drawn(paths, camera: Camera | None = None):
    camera = camera or Camera()
    state = MODELER.create(Context())
    for path in paths:
        stroke = path if isinstance(path, Stroke) else Stroke(*path.T, camera)
        state = DrawLines().draw(state, Ink((stroke,)), ALONE)
    return state


def turned(state, place=RIM, camera: Camera | None = None):
    return TurnSolid().tap(state, Tap(*place, camera or Camera()), ALONE)


def solid(state):
    (body,) = state.of_kind(Body)
    return solved(body, state)


def test_a_touch_on_the_rim_turns_a_cylinder_in_the_window(window):
    window.open("polyhedron")
    pen = Pen()
    window.draw(*(pen.along(path) for path in drum()))
    assert "Touch a rim" in window.hint
    window.take("turn")
    window.tap(*RIM)
    state = window.state
    assert state.nodes[0].choice is not None
    (circle,) = solid(state).changed.circles
    assert np.abs(circle.axis) == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
    assert solid(state).body.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    window.undo()
    assert window.state.nodes[0].choice is None


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
@pytest.mark.parametrize("elevation", [0.0, 0.4, 1.0])
def test_what_was_drawn_upright_stands_wherever_the_eye_was(kind, elevation):
    eye = 900.0 * np.array([0.3, -np.cos(elevation), np.sin(elevation) + 1e-3])
    camera = Camera(kind, eye=tuple(eye), height=300.0)
    found = solid(turned(drawn(drum(), camera), camera=camera))
    (circle,) = found.changed.circles
    assert np.abs(circle.axis) == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
    assert found.body.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)


def test_nothing_is_drawn_of_the_box_about_a_cylinder():
    state = drawn(drum())
    scene = MODELER.scene(state, MODELER.solve(state, Job()))
    (lines,) = (layer for layer in scene.layers if layer.name == "lines")
    assert not any(isinstance(item, Points) for item in lines.items)
    assert len(lines.items) == 4


@pytest.mark.parametrize("view", [Camera(), ASIDE])
def test_a_rim_is_touched_again_for_the_next_answer(view):
    state = turned(drawn(drum()))
    (body,) = state.of_kind(Body)
    line = round_lines(body, solid(state))[0]
    place = view.project(line.points[:1])[0][0]
    again = turned(state, place, view)
    assert again.of_kind(Body)[0].answer == 2
    with pytest.raises(UserError, match="a corner or a rim"):
        turned(state, (5.0, 5.0), view)


def tones(state) -> list[int]:
    """Return how many tones each picture of the answers has across its middle."""
    found = []
    for each in gallery_of(state, LIGHT, (192, 160)).pictures:
        solid_rows = np.flatnonzero((each.pixels[:, :, 3] > 128).any(axis=1))
        row = each.pixels[int(np.median(solid_rows))]
        found.append(len(np.unique(row[row[:, 3] == 255][:, 0] // 4)))
    return found


def test_answers_are_shown_round():
    """A cylinder is shaded all across; the box about it had a tone a face, and edges."""
    boxes = tones(read(OBJECTS["box"]))
    assert len(tones(drawn(drum()))) == 2
    assert min(tones(drawn(drum()))) > 1.5 * max(boxes)


@pytest.mark.parametrize("view", [Camera(), ASIDE])
@pytest.mark.parametrize("name", ["hole in a box", "cylinder on a box", "rounded edge"])
def test_round_ink_is_erased_once_turned(name, view):
    ink = list(ink_of(name, 7301))
    state = drawn(ink)
    (body,) = state.of_kind(Body)
    corner = solved(body, state).graph.places[0]
    state = turned(state, corner, ink[0].camera)
    (body,) = state.of_kind(Body)
    before = solid(state)
    assert before.changed.circles
    lines = [line for line in round_lines(body, before) if len(line.points) > 4]
    own = max(lines, key=lambda line: len(line.points))
    path = view.project(own.points)[0]
    after = Erase().draw(state, Ink((Stroke(*path.T, view),)), Context())
    assert not solid(after).changed.circles
    left = {id(stroke) for stroke in after.of_kind(Body)[0].strokes}
    kept = [k for k, stroke in enumerate(body.strokes) if id(stroke) not in left]
    assert set(kept) >= set(own.curve.strokes)
