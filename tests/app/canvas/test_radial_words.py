"""Icons and titles in the radial menu stay inside their sectors."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPointF
from PySide6.QtGui import QFont

from bozzetto_app.canvas.radial_menu import RADIUS, entry_places, sector_centre, sector_path
from bozzetto_app.main_window import RADIAL
from bozzetto_app.style.theme import small_font

TITLES = ("Undo", "Redo", "Show all", "Front", "Right", "Three-quarter", "Finish the stroke")


@pytest.mark.parametrize("pixels", [10, 11, 12, 13])
@pytest.mark.parametrize("index", range(8))
def test_an_entry_lies_in_its_sector_whatever_the_size_of_type(qapp, index, pixels):
    font = QFont(qapp.font())
    font.setPixelSize(pixels)
    middle = QPointF(RADIUS, RADIUS)
    sector, centre = sector_path(middle, index, 8), sector_centre(middle, index, 8)
    for title in TITLES:
        for has_icon in (True, False):
            places = entry_places(sector, centre, font, title, has_icon=has_icon)
            assert places.are_inside(sector), title
            assert places.words.top() >= places.icon.bottom() or not has_icon


def test_every_entry_of_the_menu_lies_in_its_sector(make_window):
    window = make_window()
    menu, entries = window.canvas.menu, window.canvas.menu_entries()
    assert len(entries) == len(RADIAL)
    middle = QPointF(menu.width() / 2, menu.height() / 2)
    for index, entry in enumerate(entries):
        sector = sector_path(middle, index, len(entries))
        centre = sector_centre(middle, index, len(entries))
        font = small_font(menu.font())
        places = entry_places(sector, centre, font, entry.title, has_icon=not entry.icon.isNull())
        assert places.are_inside(sector), entry.title
