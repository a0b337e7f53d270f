"""Sliders of the bundled samples, dragged in the real window."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from bozzetto.testing.machine_speed import slowness
from tests.slider_drags import close, drag, open_sample

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("modeler", "stem", "key"),
    [
        ("bozzetto.silhouette", "horse", ("part", "inflation")),
        ("bozzetto.silhouette", "horse", ("part", "blend")),
        ("bozzetto.symmetry", "boat", ("", "length")),
        ("bozzetto.symmetry", "boat", ("", "restitution")),
        ("bozzetto.car", "hatchback", ("", "length")),
    ],
)
def test_a_drag_shows_its_values_in_order_and_ends_with_the_last(
    modeler, stem, key, qapp, tmp_path
):
    window = open_sample(modeler, stem, tmp_path / "recovery")
    try:
        found = drag(window, key, 2.0)
    finally:
        close(window)
    assert found.steps == 1
    assert found.in_order
    assert found.last_is_shown
    # Frames by what they cost: how fast a machine that others use as well shows them is its own.
    assert found.frames >= 1
    assert found.processor / found.frames < 0.5 * slowness()


def test_a_car_over_its_sketch_follows_a_drag_and_is_not_solved_for_advice(
    qapp, tmp_path, monkeypatch
):
    """The layers over a sketch are the advice's: where they lag behind, nothing seems to move."""
    from bozzetto_car.body import build

    solve, solved_in = build.solve_car, []

    def solve_car(*arguments):
        solved_in.append(threading.current_thread().name)
        return solve(*arguments)

    window = open_sample("bozzetto.car", "hatchback", tmp_path / "recovery")
    try:
        session = window.session
        assert session.advice.holds_eye(session.view.camera)
        monkeypatch.setattr(build, "solve_car", solve_car)
        found = drag(window, ("", "length"), 2.0)
        assert session.advice.holds_eye(session.view.camera)
        own, over = (
            places(shown.layers) for shown in (session.scene.visible, session.scene.advice)
        )
    finally:
        close(window)
    assert found.last_is_shown
    assert not [name for name in solved_in if "advice" in name]
    assert len(own)
    assert np.array_equal(own, over)


def places(layers):
    """The vertices of the body, in an order of their own: its panels are one mesh or several."""
    meshes = [item.mesh for layer in layers if layer.name == "body" for item in layer.items]
    return np.unique(np.concatenate([mesh.vertices for mesh in meshes]), axis=0)
