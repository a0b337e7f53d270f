"""The brush in the window: its ring under a hovering pen, and its keys."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from bozzetto.scene import DARK, LIGHT, Lines, Palette
from bozzetto.scene.contrast import contrast
from bozzetto.testing import Pen
from bozzetto_app.testing import WindowShell


def seen_least(rings: list[Lines], palette: Palette) -> float:
    """Return the contrast of what is seen best of lines, on the paint on which it is seen least."""
    steps = np.linspace(0, 255, 8).astype(int).tolist()
    return min(
        max(contrast(palette.color(ring.color), paint) for ring in rings)
        for paint in product(steps, repeat=3)
    )


def test_the_ring_of_the_brush_is_seen_and_keys_size_it(window: WindowShell, pen: Pen) -> None:
    window.open("bozzetto.silhouette")
    window.draw(pen.circle(600, 450, 220))
    window.take("brush")
    sizes = []
    for keys in ((), ("]", "]"), ("[",)):
        for key in keys:
            window.press(key)
        window.hover(560.0, 430.0)
        (layer,) = (one for one in window.shown().layers if one.name == "brush")
        rings = [item for item in layer.items if isinstance(item, Lines)]
        for ring in rings:
            pixels = window.session.view.camera.project(ring.points)[0]
            away = np.linalg.norm(pixels - (560.0, 430.0), axis=1)
            assert away == pytest.approx(0.5 * window.state.brush_size, abs=0.05)
        assert rings[0].width > rings[-1].width, "the rim of the line is seen on both sides of it"
        assert seen_least(rings, LIGHT) > 3.0
        assert seen_least(rings, DARK) > 3.0
        sizes.append(window.state.brush_size)
    assert sizes[0] < sizes[2] < sizes[1]
    window.draw(pen.along([(500, 400), (640, 470)]))
    assert len(window.state.parts[0].paint_strokes) == 1
    assert not window.notices
