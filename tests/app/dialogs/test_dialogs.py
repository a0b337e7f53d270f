"""Recovery, plugins, preferences, pen tester, keys, about."""

from __future__ import annotations

import math
import time
from collections import deque
from pathlib import Path

import pytest
from msgspec import structs
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, Qt, QTimer
from PySide6.QtGui import QGuiApplication, QInputDevice, QPointingDevice, QTabletEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QMainWindow, QPushButton

from bozzetto.document.recovery.recovery import CrashedSession
from bozzetto.plugin.host.switched_off import switched_off
from bozzetto_app.actions.registry import Action, ActionRegistry
from bozzetto_app.canvas.input.stroke_samples import PressureCurve
from bozzetto_app.dialogs.about import AboutDialog
from bozzetto_app.dialogs.fault_details import FaultDetails
from bozzetto_app.dialogs.pen_pad import rate_of
from bozzetto_app.dialogs.pen_tester import PRESSURE_CURVE, PenTester
from bozzetto_app.dialogs.plugin_manager import PluginManager
from bozzetto_app.dialogs.preferences import BACKUPS, RECENT, THEME, PreferencesDialog
from bozzetto_app.dialogs.pressure_editor import MARGIN
from bozzetto_app.dialogs.recovery import RecoveryDialog
from bozzetto_app.dialogs.shortcuts import ShortcutsDialog
from bozzetto_app.settings import settings
from bozzetto_app.style.theme import Theme
from bozzetto_app.toolkit.panel_scroll import PanelScroll
from bozzetto_app.widgets.toggle import Toggle
from tests.app.seen import button, part


@pytest.fixture
def shown(qtbot):
    def show(dialog):
        qtbot.addWidget(dialog)
        dialog.show()
        return dialog

    return show


def said(dialog) -> str:
    return "\n".join(label.text() for label in dialog.findChildren(QLabel))


# -- recovery --


@pytest.fixture
def crashed():
    noon = time.mktime((2026, 1, 2, 14, 32, 7, 0, 0, -1))
    return [
        CrashedSession("a", "Horse", Path("/drawings/Horse.bozz"), noon - 60, time.time()),
        CrashedSession("b", "Untitled", None, noon - 60, noon),
    ]


def test_every_drawing_is_offered(shown, crashed):
    crashed[0] = CrashedSession("a", "Horse", None, 0.0, _today_at(0, 0, 7))
    dialog = shown(RecoveryDialog(crashed, nothing, nothing))
    assert "Bozzetto closed unexpectedly." in said(dialog)
    assert "Your drawing “Horse” is here, complete to 00:00:07." in said(dialog)
    assert "Your drawing “Untitled” is here, complete to " in said(dialog)
    assert "14:32" in said(dialog).replace(".", ":")


@pytest.mark.parametrize("count", [1, 30])
def test_no_words_are_cut_off_however_many_drawings_there_are(shown, qtbot, count):
    many = [
        CrashedSession(str(k), f"A horse with a long name, number {k}", None, 0.0, time.time())
        for k in range(count)
    ]
    dialog = shown(RecoveryDialog(many, nothing, nothing))
    qtbot.waitUntil(lambda: dialog.height() <= dialog.screen().availableGeometry().height())
    for words in dialog.findChildren(QLabel):
        assert words.height() >= words.heightForWidth(words.width())


def _today_at(hour, minute, second):
    now = time.localtime()
    return time.mktime((*now[:3], hour, minute, second, 0, 0, -1))


def nothing(crashed, ended):
    """Do what the dialog asks for, without an end."""


@pytest.fixture
def asked():
    """What a dialog asked for: (verb, session, callback)."""
    return []


@pytest.fixture
def offer(shown, crashed, asked):
    def show():
        return shown(
            RecoveryDialog(
                crashed,
                lambda one, ended: asked.append(("open", one, ended)),
                lambda one, ended: asked.append(("discard", one, ended)),
            )
        )

    return show


def test_nothing_happens_to_what_is_kept(offer, asked):
    dialog = offer()
    words = {button.text().replace("&", "") for button in dialog.findChildren(QPushButton)}
    assert words == {"Open", "Discard…", "Keep for later"}
    dialog.keep.click()
    assert asked == []
    assert not dialog.isVisible()


@pytest.mark.parametrize("leave", ["escape", "close"])
def test_leaving_it_keeps_everything(offer, asked, leave):
    dialog = offer()
    if leave == "escape":
        QTest.keyClick(dialog, Qt.Key.Key_Escape)
    else:
        dialog.close()
    assert asked == []
    assert not dialog.isVisible()


def test_each_is_opened_once_and_the_rest_stays_on_offer(offer, crashed, asked):
    dialog = offer()
    first, second = (b for b in dialog.findChildren(QPushButton) if b.text() == "Open")
    first.click()
    first.click()
    assert [(verb, one) for verb, one, _ in asked] == [("open", crashed[0])]
    assert first.text() == "Opening…"
    asked[0][2](True)
    assert first.text() == "Opened"
    assert dialog.isVisible()
    second.click()
    asked[1][2](True)
    assert not dialog.isVisible()


def test_what_could_not_be_opened_is_offered_again(offer, asked):
    dialog = offer()
    first = next(b for b in dialog.findChildren(QPushButton) if b.text() == "Open")
    first.click()
    asked[0][2](False)
    assert (first.text(), first.isEnabled()) == ("Open", True)


@pytest.mark.parametrize("sure", [True, False])
def test_nothing_is_discarded_by_who_is_not_sure(offer, asked, sure):
    dialog = offer()
    answer = "Discard" if sure else "Keep"
    QTimer.singleShot(0, lambda: button(part(dialog, "discard"), answer).click())
    next(b for b in dialog.findChildren(QPushButton) if b.text() == "Discard…").click()
    assert [verb for verb, *_ in asked] == ["discard"] * sure


def test_the_plugin_that_was_at_work_is_named_and_can_be_switched_off(shown, crashed):
    off = []
    dialog = shown(
        RecoveryDialog(
            crashed, nothing, nothing, suspect="Lathe", switch_off=lambda: off.append(True)
        )
    )
    assert "The plugin “Lathe” was at work" in said(dialog)
    button = dialog.findChild(QPushButton, "switch-off-suspect")
    assert dialog.focusWidget().text() == "Open"
    button.click()
    assert off == [True]
    assert not button.isEnabled()


def test_where_none_was_at_work_none_is_named(shown, crashed):
    dialog = shown(RecoveryDialog(crashed, nothing, nothing))
    assert dialog.findChild(QPushButton, "switch-off-suspect") is None


@pytest.mark.parametrize("moment", [-1e300, 1e300, float("nan"), 0.0])
def test_times_without_sense_stop_nobody(shown, crashed, moment):
    crashed[0] = CrashedSession("a", "Horse", None, moment, moment, "attic")
    words = said(shown(RecoveryDialog(crashed, nothing, nothing)))
    assert "Your drawing “Horse” is here, complete to" in words
    assert "It was open on “attic”" in words


# -- plugins --


def test_states_are_said_in_words(shown, fake_session):
    dialog = shown(PluginManager(fake_session))
    for words in ("Silhouette", "0.1.0", "in use", "cannot be used", "No module named 'acme_core'"):
        assert words in said(dialog)


def test_switching_off_is_done_and_remembered(qtbot, shown, fake_session):
    dialog = shown(PluginManager(fake_session))
    toggle = dialog.findChild(Toggle, "maria.lathe")
    with qtbot.waitSignal(dialog.switched) as switched:
        toggle.click()
    assert switched.args == ["maria.lathe", False]
    assert fake_session.registry.disabled == {"maria.lathe": True}
    assert switched_off() == {"maria.lathe"}
    assert "switched off" in said(dialog)


def test_the_list_of_plugins_stays_where_it_was_when_one_is_switched(qtbot, shown, fake_session):
    registry = fake_session.registry
    registry.infos = [
        structs.replace(registry.infos[1], id=f"maria.lathe{k}", title=f"Lathe {k}")
        for k in range(30)
    ]
    dialog = shown(PluginManager(fake_session))
    bar = dialog.findChild(PanelScroll).verticalScrollBar()
    qtbot.waitUntil(lambda: bar.maximum() > 0)
    bar.setValue(bar.maximum() // 2)
    place = bar.value()
    dialog.findChild(Toggle, "maria.lathe15").click()
    qtbot.wait(50)
    assert bar.value() == place
    assert dialog.focusWidget().objectName() == "maria.lathe15"
    assert not dialog.findChild(Toggle, "maria.lathe15").isChecked()


def test_a_plugins_fault_can_be_copied(qtbot, shown, fake_session):
    dialog = shown(PluginManager(fake_session))
    details = shown(dialog.details_of(fake_session.registry.infos[2]))
    details.copy.click()
    copied = QGuiApplication.clipboard().text()
    assert "Foam 0.0.9" in copied
    assert "ModuleNotFoundError" in copied


def test_details_show_plain_text(shown):
    dialog = shown(FaultDetails("<b>x</b> stopped.", "Traceback"))
    assert dialog.findChild(QLabel).textFormat() == Qt.TextFormat.PlainText


# -- preferences --


def test_the_theme_is_kept_and_told(qtbot, shown):
    dialog = shown(PreferencesDialog())
    with qtbot.waitSignal(dialog.theme_chosen) as chosen:
        button(dialog.theme, "Dark").click()
    assert chosen.args == [Theme.DARK]
    assert settings().value(THEME) == "dark"


def test_switches_are_kept(qtbot, shown):
    dialog = shown(PreferencesDialog())
    with qtbot.waitSignal(dialog.changed):
        dialog.motion.click()
    with qtbot.waitSignal(dialog.changed):
        dialog.tilt.click()
    again = shown(PreferencesDialog())
    assert again.motion.isChecked()
    assert not again.tilt.isChecked()


def test_backups_and_recent_files(qtbot, shown):
    settings().setValue(RECENT, ["/a.bozz", "/b.bozz"])
    dialog = shown(PreferencesDialog())
    assert dialog.backups.value() == 3
    dialog.backups.stepBy(2)
    assert int(settings().value(BACKUPS)) == 5
    dialog.recent.click()
    assert not settings().contains(RECENT)
    assert not dialog.recent.isEnabled()


@pytest.mark.parametrize(
    ("key", "value"), [(THEME, "sepia"), (BACKUPS, "many"), ("view/settle_tilt", "perhaps")]
)
def test_a_spoiled_setting_does_not_stop_it(shown, key, value):
    settings().setValue(key, value)
    shown(PreferencesDialog())


# -- pen --


@pytest.fixture
def pen():
    capability = QInputDevice.Capability
    return QPointingDevice(
        "Test pen",
        7,
        QInputDevice.DeviceType.Stylus,
        QPointingDevice.PointerType.Pen,
        capability.Position | capability.Pressure | capability.XTilt | capability.YTilt,
        1,
        3,
    )


def pen_event(kind, device, widget, x, pressure, tilt):
    place = QPointF(x, 50)
    buttons = Qt.MouseButton.LeftButton
    event = QTabletEvent(
        kind,
        device,
        place,
        QPointF(widget.mapToGlobal(place)),
        pressure,
        tilt,
        -12.0,
        0.0,
        0.0,
        0.0,
        Qt.KeyboardModifier.NoModifier,
        buttons,
        buttons,
    )
    QApplication.sendEvent(widget, event)


def value(dialog, name):
    """What the label says that a screen reader calls so."""
    (label,) = (one for one in dialog.findChildren(QLabel) if one.accessibleName() == name)
    return label.text()


def test_the_tester_says_what_the_pen_says(shown, pen):
    dialog = shown(PenTester())
    pad = dialog.pad
    pen_event(QEvent.Type.TabletPress, pen, pad, 50, 0.25, 30.0)
    for x in range(60, 160, 10):
        pen_event(QEvent.Type.TabletMove, pen, pad, x, 0.75, 30.0)
    assert value(dialog, "Device") == "Test pen"
    assert value(dialog, "Tool") == "pen"
    assert value(dialog, "Pressure") == "0.750"
    assert value(dialog, "Tilt") == "30°, -12°"
    ink = pad.grab().toImage()
    middle = ink.pixelColor(100, 50)
    assert middle.lightness() != ink.pixelColor(100, 150).lightness(), "there is ink"


def test_a_mouse_has_no_pressure(shown):
    dialog = shown(PenTester())
    QTest.mousePress(dialog.pad, Qt.MouseButton.LeftButton, pos=QPoint(40, 40))
    assert value(dialog, "Pressure") == "none"


@pytest.mark.parametrize("rate", [60, 133, 250])
def test_the_rate_is_counted(rate):
    times = deque(k / rate for k in range(rate * 3))
    assert rate_of(times) == pytest.approx(rate, rel=0.02)
    assert len(times) <= rate + 2, "old times are dropped"
    assert rate_of(deque()) == 0.0
    assert rate_of(deque([1.0])) == 0.0


def test_the_curve_is_bent_kept_and_told(qtbot, shown):
    dialog = shown(PenTester())
    editor = dialog.editor
    room = QRectF(editor.rect()).adjusted(MARGIN, MARGIN, -MARGIN, -MARGIN)
    aim = QPointF(room.left() + room.width() * 0.5, room.bottom() - room.height() * 0.75)
    with qtbot.waitSignal(dialog.curve_changed) as told:
        QTest.mousePress(editor, Qt.MouseButton.LeftButton, pos=aim.toPoint())
    gamma = told.args[0]
    assert gamma == pytest.approx(math.log(0.75) / math.log(0.5), rel=0.05)
    kept = PressureCurve.from_setting(settings().value(PRESSURE_CURVE))
    assert kept.gamma == pytest.approx(gamma)
    assert kept(0.5) == pytest.approx(0.75, abs=0.02), "the curve goes where it was pulled"
    assert dialog.exponent.value() == pytest.approx(gamma, abs=1e-5)


def test_the_curve_stays_within_its_limits_and_straightens(shown):
    dialog = shown(PenTester())
    for place in (QPoint(20, 175), QPoint(170, 5), QPoint(-50, 500)):
        QTest.mousePress(dialog.editor, Qt.MouseButton.LeftButton, pos=place)
        assert PressureCurve.SOFTEST <= dialog.editor.gamma <= PressureCurve.HARDEST
    QTest.mouseDClick(dialog.editor, Qt.MouseButton.LeftButton)
    assert dialog.editor.gamma == 1.0


# -- keys, about --


@pytest.fixture
def keys(qtbot, shown):
    window = QMainWindow()
    qtbot.addWidget(window)
    registry = ActionRegistry(window)
    registry.register(
        Action("file.save", "&Save", print, keys=("Ctrl+S",), menu=("&File",)),
        Action("view.front", "Front", print, keys=("F5",), menu=("&View", "Look from")),
        Action("help.about", "About", print, menu=("&Help",)),
    )
    dialog = shown(ShortcutsDialog(registry))
    dialog.keep = window
    return dialog


def test_keys_are_listed_and_found_by_name_or_key(keys):
    assert {"Save", "Front", "Turn"} <= set(keys.shown())
    assert "About" not in keys.shown(), "it has no key"
    keys.field.setText("f5")
    assert keys.shown() == ["Front"]
    keys.field.setText("fro")
    assert keys.shown() == ["Front"]
    keys.field.setText("")
    assert "Save" in keys.shown()


def test_about_names_versions_for_a_report(shown):
    import numpy
    import PySide6

    dialog = shown(AboutDialog("Software (numpy z-buffer)"))
    for words in (numpy.__version__, PySide6.__version__, "Software (numpy z-buffer)", "Apache"):
        assert words in said(dialog)
    next(b for b in dialog.findChildren(QPushButton) if b.text().replace("&", "") == "Copy").click()
    assert "Renderer: Software" in QGuiApplication.clipboard().text()
