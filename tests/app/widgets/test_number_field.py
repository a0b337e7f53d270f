"""Number fields: drag, type, compute, restore."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QEvent, QLocale, QPoint, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit

from bozzetto_app.widgets.number_field import NumberField, format_number, is_scale, sensible_step


@pytest.fixture
def field(qtbot):
    made = NumberField("Length", minimum=0, maximum=400, step=1, unit="mm")
    qtbot.addWidget(made)
    made.setValue(120)
    made.resize(96, 24)
    made.show()
    return made


@pytest.fixture
def edits(field):
    made: list[tuple[float, bool]] = []
    field.edited.connect(lambda value, going: made.append((value, going)))
    return made


def typed(field, text):
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)


def press(field, x):
    QTest.mousePress(field.lineEdit(), Qt.MouseButton.LeftButton, pos=QPoint(x, 10))


def drag(field, x, modifiers=Qt.KeyboardModifier.NoModifier):
    from PySide6.QtCore import QEvent, QPointF
    from PySide6.QtGui import QMouseEvent
    from PySide6.QtWidgets import QApplication

    edit = field.lineEdit()
    place = QPointF(x, 10)
    event = QMouseEvent(
        QEvent.Type.MouseMove,
        place,
        edit.mapToGlobal(place),
        Qt.MouseButton.NoButton,
        Qt.MouseButton.LeftButton,
        modifiers,
    )
    QApplication.sendEvent(edit, event)


def release(field, x):
    QTest.mouseRelease(field.lineEdit(), Qt.MouseButton.LeftButton, pos=QPoint(x, 10))


def test_a_sum_is_computed(field, edits):
    typed(field, "120/2+5")
    assert edits == [], "nothing changes before it is taken"
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert edits == [(65.0, False)]
    assert field.text() == "65 mm"


def test_the_unit_may_be_typed_or_left_out(field, edits):
    typed(field, "80 mm")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert edits == [(80.0, False)]


def test_another_unit_is_converted(field, edits):
    typed(field, "8 cm")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert edits == [(80.0, False)]
    assert field.text() == "80 mm"


def test_a_comma_is_what_it_is_in_the_country(field):
    default = QLocale()
    try:
        for country, value in ((QLocale("en_US"), 1234.0), (QLocale("de_DE"), 1.234)):
            QLocale.setDefault(country)
            assert field.valueFromText("1,234") == min(value, 400.0)
            assert field.valueFromText("1.5") == field.valueFromText("1,5") == 1.5
    finally:
        QLocale.setDefault(default)


def test_escape_restores(field, edits):
    typed(field, "9+")
    QTest.keyClick(field, Qt.Key.Key_Escape)
    assert field.text() == "120 mm"
    assert edits == []


def test_nonsense_stays_to_be_mended_and_changes_nothing(field, edits):
    typed(field, "9+")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert edits == []
    assert field.value() == 120
    assert field.lineEdit().text().startswith("9+")
    assert field.accessibleDescription()


def test_leaving_the_field_takes_a_sum_and_drops_nonsense(qtbot, field, edits):
    other = QLineEdit()
    qtbot.addWidget(other)
    other.show()
    typed(field, "7*7")
    field.clearFocus()
    assert edits == [(49.0, False)]
    typed(field, "7*")
    field.clearFocus()
    assert edits == [(49.0, False)]
    assert field.text() == "49 mm"


def test_values_outside_come_to_the_nearer_end(field, edits):
    typed(field, "9999")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert edits == [(400.0, False)]


def test_a_drag_changes_it_and_ends_once(field, edits):
    ends = []
    field.drag_ended.connect(lambda: ends.append(1))
    press(field, 10)
    for x in range(10, 41, 3):
        drag(field, x)
    release(field, 40)
    assert len(edits) > 3
    assert all(going for _, going in edits)
    assert edits[-1][0] == 130
    assert ends == [1]


def test_control_is_fine_and_shift_is_coarse(field, edits):
    press(field, 10)
    drag(field, 40, Qt.KeyboardModifier.ControlModifier)
    assert edits[-1] == (121.0, True)
    drag(field, 40, Qt.KeyboardModifier.ShiftModifier)
    assert edits[-1] == (220.0, True)
    release(field, 40)


def test_escape_ends_a_drag_where_it_began(field, edits):
    ends = []
    field.drag_ended.connect(lambda: ends.append(1))
    press(field, 10)
    drag(field, 70)
    QTest.keyClick(field, Qt.Key.Key_Escape)
    release(field, 70)
    assert field.value() == 120
    assert ends == [1]


def test_a_click_edits_and_is_no_drag(field, edits):
    press(field, 10)
    drag(field, 12)
    release(field, 12)
    assert edits == []
    assert field.lineEdit().selectedText() == "120"


def test_arrows_step(field, edits):
    field.setFocus()
    QTest.keyClick(field, Qt.Key.Key_Up)
    QTest.keyClick(field, Qt.Key.Key_Down, Qt.KeyboardModifier.ShiftModifier)
    assert edits == [(121.0, False), (111.0, False)]


def test_whole_numbers_stay_whole(qtbot):
    field = NumberField("Parts", minimum=1, maximum=12, whole=True)
    qtbot.addWidget(field)
    made = []
    field.edited.connect(lambda value, going: made.append(value))
    field.setValue(3)
    field.show()
    typed(field, "7/2")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert made == [4.0]
    assert field.text() == "4"


def test_a_value_from_elsewhere_does_not_disturb_typing(field):
    typed(field, "77")
    field.set_silently(5)
    assert field.lineEdit().text().startswith("77")


def test_it_says_its_name(field):
    assert field.accessibleName() == "Length"


# -- words for zero ---------------------------------------------------------------------------


@pytest.fixture
def given_or_not(qtbot):
    made = NumberField("Length", minimum=0, maximum=6000, step=1, unit="mm", zero="as drawn")
    qtbot.addWidget(made)
    made.resize(96, 24)
    made.show()
    made.heard = []
    made.edited.connect(lambda value, going: made.heard.append((value, going)))
    return made


def enter(field):
    QTest.keyClick(field, Qt.Key.Key_Return)


def test_words_stand_for_zero_and_typing_replaces_them(given_or_not):
    line = given_or_not.lineEdit()
    assert (line.text(), line.placeholderText()) == ("", "as drawn")
    typed(given_or_not, "4200")
    enter(given_or_not)
    assert given_or_not.heard == [(4200.0, False)]
    assert line.text() == "4200 mm"


@pytest.mark.parametrize("text", ["", "0", "0 mm", "  ", "mm"])
def test_clearing_the_field_is_zero(given_or_not, text):
    given_or_not.set_silently(4200.0)
    assert given_or_not.lineEdit().text() == "4200 mm"
    given_or_not.setFocus()
    given_or_not.selectAll()
    QTest.keyClick(given_or_not, Qt.Key.Key_Backspace)
    QTest.keyClicks(given_or_not, text)
    enter(given_or_not)
    assert given_or_not.heard == [(0.0, False)]
    assert given_or_not.lineEdit().text() == ""


def test_clearing_and_leaving_is_zero_too(given_or_not):
    given_or_not.set_silently(4200.0)
    given_or_not.setFocus()
    given_or_not.selectAll()
    QTest.keyClick(given_or_not, Qt.Key.Key_Delete)
    given_or_not.clearFocus()
    assert given_or_not.value() == 0.0
    assert given_or_not.lineEdit().text() == ""


def test_escape_brings_the_words_back(given_or_not):
    typed(given_or_not, "12")
    QTest.keyClick(given_or_not, Qt.Key.Key_Escape)
    assert given_or_not.lineEdit().text() == ""
    assert given_or_not.heard == []


def test_a_drag_does_not_begin_where_nothing_is_given(given_or_not):
    press(given_or_not, 20)
    drag(given_or_not, 60)
    release(given_or_not, 60)
    assert given_or_not.heard == []
    given_or_not.set_silently(4200.0)
    given_or_not.clearFocus()
    press(given_or_not, 20)
    drag(given_or_not, 50)
    release(given_or_not, 50)
    assert given_or_not.heard[-1] == (4210.0, True)


def test_fields_without_such_words_want_a_number(field, edits):
    field.setFocus()
    field.selectAll()
    QTest.keyClick(field, Qt.Key.Key_Backspace)
    enter(field)
    assert edits == []
    assert field.value() == 120


@given(st.floats(-1e5, 1e5), st.sampled_from([1.0, 0.5, 0.1, 0.01, 0.001]))
def test_what_is_shown_is_the_value_to_two_digits_below_the_step(value, step):
    shown = float(format_number(value, step))
    assert abs(shown - value) <= step / 100


@given(st.floats(-1e4, 1e4), st.floats(1e-3, 1e5))
def test_steps_are_one_two_or_five(low, span):
    step = sensible_step(low, low + span)
    mantissa = float(f"{step:e}".split("e")[0])
    assert round(mantissa, 6) in (1, 2, 5)
    assert 40 <= span / step <= 101


@pytest.mark.parametrize("value", [0.05, 0.8, 7.0, 120.0, 4500.0, 2e5])
def test_steps_in_a_range_that_is_no_scale_suit_the_value(qtbot, value):
    """A millimetre to a kilometre only keeps out nonsense: an arrow key is about a hundredth."""
    field = NumberField("Length", minimum=1e-3, maximum=1e6, usual=120.0, unit="mm")
    qtbot.addWidget(field)
    field.set_silently(value)
    field.stepBy(1)
    changed = field.value() - value
    assert 0.0 < changed <= 0.025 * max(value, 12.0)
    field.stepBy(-1)
    assert field.value() == pytest.approx(value, rel=0.03)


def test_a_scale_is_not_much_wider_than_what_is_usual():
    assert is_scale(0.0, 1.0, 0.0)
    assert is_scale(-180.0, 180.0, 0.0)
    assert is_scale(0.0, 1000.0, 0.0)
    assert is_scale(1000.0, 10_000.0, 4200.0)
    assert not is_scale(1e-3, 1e6, 120.0)
    assert not is_scale(-1e5, 1e5, 0.0)


@pytest.mark.parametrize("typing", [False, True])
@pytest.mark.parametrize("letter", [chr(code) for code in range(ord("A"), ord("Z") + 1)])
def test_the_key_of_a_command_reaches_it_from_a_field(field, letter, typing):
    """Lines of text take Ctrl+E, Ctrl+K, Ctrl+D and others on X11; a number has no use for them."""
    if typing:
        typed(field, "12")
    key = getattr(Qt.Key, f"Key_{letter}")
    event = QKeyEvent(
        QEvent.Type.ShortcutOverride, key, Qt.KeyboardModifier.ControlModifier, letter.lower()
    )
    event.ignore()
    QApplication.sendEvent(field, event)
    if letter in "ACVX" or (typing and letter == "Z"):
        assert event.isAccepted()
    elif letter != "Y":  # redo on some systems only
        assert not event.isAccepted()
