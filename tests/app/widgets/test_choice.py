"""Choices: words side by side where there is room for them, else a list."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from bozzetto_app.widgets.choice import ChoiceBox, Segments, make_choice

OPTIONS = [("round", "Round all over"), ("flat", "Flat at the back")]


def test_words_lie_side_by_side_where_there_is_room(qtbot):
    around = QWidget()
    qtbot.addWidget(around)
    assert isinstance(make_choice("Shape", OPTIONS, 1000, around), Segments)


def test_of_words_without_room_nothing_is_left_beside_the_list(qtbot):
    """Whoever looks into the row finds only what stays: the others are gone a moment later."""
    around = QWidget()
    qtbot.addWidget(around)
    box = make_choice("Shape", OPTIONS, 40, around)
    assert isinstance(box, ChoiceBox)
    assert around.findChildren(QWidget, "") != []
    assert around.findChildren(Segments) == []
    assert set(around.children()) == {box}
