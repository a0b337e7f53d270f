"""Drawings go on while the view is moved over the sheet and enlarged, as every hand does it."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.ink import Stroke, on_sheet_of
from bozzetto.plugin import Job
from bozzetto.testing import Pen, Shell
from bozzetto.view import Camera, turn, with_kind
from bozzetto.view.navigation import pan, zoom
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.modeler import PolyhedronModeler
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.write_samples import hidden_edges

POLYHEDRON = "bozzetto.polyhedron"
MODELER = PolyhedronModeler()


def _strokes(name: str, **untidy: float) -> list[Stroke]:
    solid, vertices = OBJECTS[name], fitted(OBJECTS[name])
    hidden = hidden_edges(solid, vertices, VIEW)
    return strokes_of(vertices, solid.edges, hidden=hidden, **untidy)


def _moved(camera: Camera, chance: np.random.Generator) -> Camera:
    """Return a view that was moved over the sheet, and enlarged or made smaller."""
    camera = pan(camera, *chance.uniform(-300.0, 300.0, 2))
    place = tuple(chance.uniform(200.0, 700.0, 2))
    return zoom(camera, float(np.exp(chance.uniform(-1.2, 1.6))), place)


def _vertices(shell: Shell) -> np.ndarray:
    return np.array(MODELER.report(shell.state, shell.solve(), Job())["vertices"])


@pytest.mark.parametrize("name", ["box", "L", "house"])
def test_a_view_that_is_moved_and_enlarged_between_strokes_changes_nothing(shell, name):
    strokes = _strokes(name, jitter=2.0, seed=11001)
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes)
    shell.run("next-answer")
    before = _vertices(shell)

    chance = np.random.default_rng(11002)
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(strokes[0])
    for stroke in strokes[1:]:
        shell.camera = _moved(VIEW, chance)
        shell.draw(on_sheet_of(stroke, shell.camera))
    (body,) = shell.state.of_kind(Body)
    assert len(body.strokes) == len(strokes)
    shell.run("next-answer")
    extent = np.ptp(before, axis=0).max()
    assert np.abs(_vertices(shell) - before).max() < 1e-4 * extent


def test_a_corner_is_touched_where_it_is_seen_now(shell):
    strokes = _strokes("box")
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes)
    corner = strokes[0].points[0]
    shell.camera = zoom(pan(VIEW, 140.0, -60.0), 2.5, (500.0, 400.0))
    seen = shell.camera.project(VIEW.on_plane([corner], VIEW.target, VIEW.axes[2]))[0][0]
    shell.tap(*seen, tool="turn")
    assert shell.state.of_kind(Body)[0].choice is not None


def test_lines_go_on_flat_in_a_view_with_perspective_that_is_moved(shell):
    strokes = _strokes("L")
    seen = with_kind(VIEW, "perspective")
    chance = np.random.default_rng(11003)
    shell.open(POLYHEDRON)
    for number, stroke in enumerate(strokes):
        shell.camera = _moved(seen, chance) if number else seen
        shell.draw(on_sheet_of(stroke, shell.camera))
    (body,) = shell.state.of_kind(Body)
    assert len(body.strokes) == len(strokes)


def test_a_view_that_is_turned_begins_another_drawing(shell):
    strokes = _strokes("box")
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes[:4])
    shell.camera = turn(VIEW, 25.0, 5.0)
    shell.draw(Pen(shell.camera).along(strokes[5].points))
    assert len(shell.state.of_kind(Body)) == 2


@pytest.mark.parametrize("factor", [0.3, 4.0])
def test_the_eraser_takes_the_line_under_it_in_an_enlarged_view(shell, factor):
    strokes = _strokes("house")
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes)
    before = shell.state.of_kind(Body)[0].strokes
    shell.camera = zoom(VIEW, factor, tuple(strokes[3].points.mean(axis=0)))
    rubbed = on_sheet_of(strokes[3], shell.camera).points
    ends = rubbed[0] + np.outer((0.1, 0.9), rubbed[-1] - rubbed[0])
    shell.draw(Pen(shell.camera, tool="eraser").along(ends))
    (body,) = shell.state.of_kind(Body)
    gone = [k for k, stroke in enumerate(before) if stroke not in tuple(body.strokes)]
    assert gone == [3]


def test_lines_on_a_solid_in_an_enlarged_view_are_kept_as_they_met_it(shell):
    """An end that meets a corner in a small picture of a solid must meet it when it is solved."""
    strokes = _strokes("box")
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes)
    shell.run("next-answer")
    base = shell.solve().bodies["n1"].base.vertices
    for factor in (0.25, 3.0):
        shell.camera = zoom(VIEW, factor, (600.0, 450.0))
        corners = shell.camera.project(base)[0]
        low, high = corners[np.argsort(corners[:, 1])[[-1, 0]]]
        missed = low + np.array((4.0, 3.0))
        shell.draw(Pen(shell.camera).along([missed, 0.5 * (low + high)]))
        changed = shell.solve().bodies["n1"].changed
        met = np.linalg.norm(changed.points[:, None] - base, axis=2).min(axis=1)
        assert met.min() < 1e-9 * np.ptp(base)
        shell.undo()
