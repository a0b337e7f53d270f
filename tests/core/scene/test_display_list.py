"""The display list: what of it is looked at when a scene is framed."""

from __future__ import annotations

import numpy as np

from bozzetto.scene import Image, Layer, Lines, Points, Scene


def test_a_picture_behind_things_is_not_framed_with_them():
    pixels = np.zeros((2, 2, 4), np.uint8)
    image = Image(pixels, (-900.0, 500.0, 900.0), (1800.0, 0.0, 0.0), (0.0, 0.0, -1800.0))
    line = Lines(np.array([[0, 0, 0], [10, 0, 5]], np.float32))
    handle = Points(np.array([[400, 0, 0]], np.float32))
    alone = Scene((Layer("underlay", (image,)),))
    assert np.ptp(alone.points(), axis=0).tolist() == [1800.0, 0.0, 1800.0]
    both = alone + Scene((Layer("curve", (line,)), Layer("marks", (handle,), tool="mark")))
    assert np.ptp(both.points(), axis=0).tolist() == [10.0, 0.0, 5.0]


def test_lines_may_be_none_at_all():
    """As a modeler makes them that has nothing to show: no points, and no beginnings."""
    nothing = Lines(np.zeros((0, 3), np.float32), np.zeros(0, np.int32))
    assert list(nothing.pieces()) == []
    assert list(Lines(np.zeros((0, 3), np.float32)).pieces()) == []
