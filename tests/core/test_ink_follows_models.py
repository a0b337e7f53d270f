"""Ink that was laid on a model's shape, while the model is edited, moved, saved and opened."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Placement, closest_on_mesh
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import follow, located, project_stroke, surface_mesh
from bozzetto.testing import Pen, Shell

MOVED = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.0, (10.0, 20.0, 30.0))


def ellipse(width, height):
    turn = np.linspace(0.0, 2 * np.pi, 60)
    return Pen().along(np.column_stack((600 + width * np.cos(turn), 450 + height * np.sin(turn))))


@pytest.fixture
def inked(tmp_path):
    """A solid of an outline, and ink across the front of it."""
    shell = Shell(Registry(), tmp_path)
    shell.open("silhouette")
    shell.draw(ellipse(180, 120))
    ink = project_stroke(Pen().along([(460, 430), (600, 450), (740, 470)]), shell.scene())
    (run,) = ink.runs
    assert ink.breaks == ()
    return shell, run


def test_what_is_handed_over_has_the_triangles_that_are_shown(inked):
    """So a modeler that solves with another model's shapes finds its ink there."""
    shell, run = inked
    (solid,) = shell.shapes().solids
    assert run.places.fit(solid.mesh)
    points = follow(run.places, solid.mesh, solid.mesh).points
    np.testing.assert_allclose(points, run.points, atol=1e-6)


def test_ink_goes_along_with_a_slider_a_move_and_a_file(inked):
    shell, run = inked
    shell.set(inflation=1.5)
    fuller = located(run.places, shell.scene())
    assert fuller is not None
    assert not fuller.distance.any()
    assert (fuller.points[:, 1] < run.points[:, 1]).all()  # nearer to the eye
    np.testing.assert_allclose(fuller.points[:, [0, 2]], run.points[:, [0, 2]], atol=2.0)
    model = replace(shell.model, placement=MOVED)
    shell.history.apply("move", shell.document.with_model(model))
    moved = located(run.places, shell.scene())
    assert moved is not None
    np.testing.assert_allclose(moved.points, MOVED.points(fuller.points), atol=1e-4)
    shell.save()
    shell.reopen()
    again = located(run.places, shell.scene())
    assert again is not None
    np.testing.assert_array_equal(again.points, moved.points)


def test_ink_on_a_surface_that_is_made_anew_goes_to_the_closest_place(inked):
    """A hole in the middle: what lay there goes to its rim, and tells how far."""
    shell, run = inked
    before = surface_mesh(run.places, shell.scene())
    assert before is not None
    shell.draw(ellipse(30, 30))
    assert located(run.places, shell.scene()) is None
    after = surface_mesh(run.places, shell.scene())
    assert after is not None
    now = located(run.places, shell.scene(), before)
    assert now is not None
    assert closest_on_mesh(after, now.points).distances.max() < 1e-9
    away = np.linalg.norm(now.points - run.points, axis=1)
    np.testing.assert_allclose(away, now.distance, atol=1e-5)
    pixels, _ = Pen().camera.project(run.points)
    in_the_hole = np.hypot(*(pixels - (600, 450)).T) < 20
    assert now.distance[in_the_hole].min() > 1.0
    assert (np.hypot(*(Pen().camera.project(now.points)[0] - (600, 450)).T) > 24).all()
    assert located(now.places, shell.scene()) is not None
