"""Texts beside points: where they begin, and that they are to be read at the border, too."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.scene import DARK, LIGHT, Label, Layer, Scene
from bozzetto.scene.contrast import LEGIBLE, contrast
from bozzetto.scene.palette import ROLES
from bozzetto.scene.renderer import render
from bozzetto.view import Camera

SIZE = (300, 120)
FRONT = Camera("orthographic", height=120.0, viewport=SIZE)
"""A millimetre is a pixel; the middle of the sheet is the origin."""


def columns(x: float, text: str = "Front wheel") -> np.ndarray:
    """Columns of the sheet in which something of a text is seen."""
    label = Label((x, 0.0, 0.0), text, color=(255, 0, 0))
    picture = render(Scene((Layer("a", (label,)),)), FRONT, LIGHT, size=SIZE)
    return np.flatnonzero((picture[..., 0].astype(int) - picture[..., 1] > 120).any(axis=0))


def test_a_text_stands_right_of_its_point():
    seen = columns(-50.0)
    assert seen.min() > 100
    assert seen.max() < 200


@pytest.mark.parametrize("x", [100.0, 130.0, 149.0])
def test_at_the_right_border_it_stands_left_of_it(x):
    seen, usual = columns(x), columns(-50.0)
    assert seen.max() < 150.0 + x
    assert np.ptp(seen) == np.ptp(usual)


@pytest.mark.parametrize("x", [-20.0, 0.0, 30.0])
def test_where_there_is_room_on_neither_side_it_is_seen_as_a_whole(x):
    text = "A-pillar, foot: this mark disagrees"
    seen, usual = columns(x, text), columns(-146.0, text)
    assert np.ptp(usual) > 150, "neither half of the sheet has room for it"
    assert np.ptp(seen) == np.ptp(usual)


def test_what_is_wider_than_the_sheet_can_be_read_from_its_beginning():
    seen = columns(0.0, "A text that is much longer than the sheet is wide, whatever one does")
    assert seen.min() < 12
    assert seen.max() > SIZE[0] - 12


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=lambda palette: palette.name)
@pytest.mark.parametrize("paint", [*ROLES, (250, 240, 120), (40, 30, 90)])
def test_a_text_is_legible_in_every_colour(palette, paint):
    """The heart of a large letter is as far from the paper as text has to be (WCAG 1.4.3)."""
    label = Label((-140.0, 0.0, -30.0), "███", color=paint, size=40.0)
    picture = render(Scene((Layer("a", (label,)),)), FRONT, palette, size=SIZE)
    drawn = {tuple(map(int, color)) for color in np.unique(picture[..., :3].reshape(-1, 3), axis=0)}
    assert max(contrast(color, palette.paper) for color in drawn) >= LEGIBLE
    assert palette.letters(paint) in drawn
