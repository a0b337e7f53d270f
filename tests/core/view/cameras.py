"""Cameras for tests to be drawn from."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from bozzetto.view.camera import Camera

coordinate = st.floats(-1000, 1000)
point = st.tuples(coordinate, coordinate, coordinate)
angle = st.floats(-np.pi, np.pi)


@st.composite
def cameras(draw, kinds=("perspective", "orthographic"), upright=False):
    target = np.array(draw(point))
    around, above = draw(angle), draw(st.floats(-1.5, 1.5))
    away = np.array((np.cos(above) * np.cos(around), np.cos(above) * np.sin(around), np.sin(above)))
    distance = 10.0 ** draw(st.floats(-1, 4))
    up = (0, 0, 1) if upright else draw(st.sampled_from([(0, 0, 1), (0, 1, 0), (1, 0.3, -2)]))
    return Camera(
        draw(st.sampled_from(kinds)),
        tuple(target + distance * away),
        tuple(target),
        up,
        draw(st.floats(5, 120)),
        10.0 ** draw(st.floats(-1, 4)),
        (draw(st.integers(50, 3000)), draw(st.integers(50, 3000))),
    )
