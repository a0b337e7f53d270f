"""A swatch opens its chart where all of it can be seen."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QRect, QSize

from bozzetto_app.widgets.swatch import place_beside

CHART = QSize(208, 80)


@pytest.mark.parametrize("screen", [QRect(0, 0, 800, 800), QRect(-1280, 25, 1280, 695)])
@pytest.mark.parametrize("across", [-0.02, 0.0, 0.5, 0.97, 1.01])
@pytest.mark.parametrize("down", [0.0, 0.5, 0.97])
def test_the_chart_is_on_the_screen_and_beside_the_disc(screen, across, down):
    corner = QPoint(round(across * screen.width()), round(down * (screen.height() - 24)))
    disc = QRect(screen.topLeft() + corner, QSize(24, 24))
    place = QRect(place_beside(disc, CHART, screen), CHART)
    assert screen.contains(place)
    assert not place.intersects(disc)
    assert place.adjusted(-24, -1, 24, 1).intersects(disc)
