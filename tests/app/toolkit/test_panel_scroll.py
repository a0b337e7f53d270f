"""A panel that is scrolled keeps the width of its content, whatever height that has."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QSize
from PySide6.QtWidgets import QSizePolicy, QVBoxLayout, QWidget

from bozzetto_app.toolkit import PanelScroll


class Picture(QWidget):
    """Lower where it is narrower, by much."""

    def __init__(self):
        super().__init__()
        policy = QSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self.widths = []

    def sizeHint(self):
        return QSize(200, self.heightForWidth(200))

    def hasHeightForWidth(self):
        return True

    def heightForWidth(self, width):
        return 2 * width

    def resizeEvent(self, event):
        self.widths.append(self.width())


@pytest.fixture
def scrolled(qtbot):
    panel, inside, picture = PanelScroll(), QWidget(), Picture()
    column = QVBoxLayout(inside)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(picture)
    panel.setWidget(inside)
    qtbot.addWidget(panel)
    panel.resize(300, 400)
    panel.show()
    qtbot.wait(20)
    return panel, picture


def test_the_content_keeps_its_width_at_every_height(scrolled, qtbot):
    # Between the heights with and without a bar Qt never came to an end: its stack overflowed.
    panel, picture = scrolled
    wide = picture.width()
    picture.widths.clear()
    for height in range(540, 640):
        panel.resize(300, height)
        qtbot.wait(1)
    assert set(picture.widths) <= {wide}
    assert len(picture.widths) < 300


def test_the_bar_is_for_use_only_where_something_is_to_be_scrolled(scrolled, qtbot):
    panel, picture = scrolled
    for height, scrolls in ((300, True), (900, False), (320, True)):
        panel.resize(300, height)
        qtbot.waitUntil(lambda wanted=scrolls: panel.verticalScrollBar().isEnabled() is wanted)
    assert picture.width() < 300
