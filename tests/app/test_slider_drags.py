"""Sliders of the bundled samples, dragged in the real window."""

from __future__ import annotations

import pytest

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
    assert found.processor / found.frames < 0.5
