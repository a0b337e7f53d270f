"""The line on an empty sheet: where it lies, and how it is broken."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_app.canvas.overlay.empty_hint import BESIDE, SheetHint

LINE = "Draw the feature curves on the rough shape; areas that close get a surface."


def painted(qtbot, text, width, height):
    """Which pixels a hint covers, (h, w) bool."""
    hint = SheetHint()
    qtbot.addWidget(hint)
    hint.resize(width, height)
    hint.say(text)
    image = hint.grab().toImage()
    image = image.convertToFormat(image.Format.Format_RGB32)
    rows = np.frombuffer(image.constBits(), np.uint32).reshape(image.height(), -1)
    return rows[:, : image.width()] != rows[0, 0]


@pytest.mark.parametrize("width", [360, 600, 1200])
def test_it_lies_low_and_in_the_middle(qtbot, width):
    covered = painted(qtbot, LINE, width, 600)
    rows, columns = np.flatnonzero(covered.any(1)), np.flatnonzero(covered.any(0))
    assert rows[0] >= 360, "what a modeler shows first is above"
    assert columns[0] >= BESIDE // 2
    assert abs(columns[0] - (width - 1 - columns[-1])) <= 2


def test_no_line_is_a_lone_word(qtbot):
    """Half of a line at least is under the first one, whatever the width."""
    for width in range(420, 900, 40):
        covered = painted(qtbot, LINE, width, 600)
        plate = np.flatnonzero(covered.any(1))
        middle = (plate[0] + plate[-1]) // 2
        spans = []
        for rows in (slice(plate[0] + 8, middle), slice(middle, plate[-1] - 7)):
            dark = covered_by_words(qtbot, LINE, width, rows)
            spans.append(np.ptp(np.flatnonzero(dark)) if dark.any() else 0)
        if plate[-1] - plate[0] > 60:
            assert min(spans) > 0.5 * max(spans), width


def covered_by_words(qtbot, text, width, rows):
    """Columns in which words are, dark on their plate."""
    hint = SheetHint()
    qtbot.addWidget(hint)
    hint.resize(width, 600)
    hint.say(text)
    image = hint.grab().toImage()
    gray = image.convertToFormat(image.Format.Format_Grayscale8)
    values = np.frombuffer(gray.constBits(), np.uint8).reshape(gray.height(), -1)
    return (values[rows, :width] < 190).any(axis=0)
