"""Everyone can find every control: names, tips, focus, and room on small screens."""

from __future__ import annotations

import itertools
import time
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    QListWidget,
    QMainWindow,
    QScrollBar,
)

from bozzetto.document.recovery.recovery import CrashedSession
from bozzetto.scene.palette import DARK, LIGHT
from bozzetto_app.actions.registry import Action, ActionRegistry
from bozzetto_app.style.theme import apply_theme


def make(name, session, window):
    from bozzetto_app.dialogs.about import AboutDialog
    from bozzetto_app.dialogs.command_palette import CommandPalette
    from bozzetto_app.dialogs.fault_details import FaultDetails
    from bozzetto_app.dialogs.pen_tester import PenTester
    from bozzetto_app.dialogs.plugin_manager import PluginManager
    from bozzetto_app.dialogs.preferences import PreferencesDialog
    from bozzetto_app.dialogs.recovery import RecoveryDialog
    from bozzetto_app.dialogs.shortcuts import ShortcutsDialog
    from bozzetto_app.panels.history import HistoryPanel
    from bozzetto_app.panels.modeler_bar import ModelerBar
    from bozzetto_app.panels.objects.panel import ObjectsPanel
    from bozzetto_app.panels.properties.form import ParametersPanel
    from bozzetto_app.panels.status_line import StatusLine
    from bozzetto_app.panels.tool_rail import ToolRail
    from bozzetto_app.panels.welcome_strip import WelcomeStrip
    from bozzetto_app.widgets.swatch import Swatch

    registry = ActionRegistry(window)
    registry.register(Action("file.save", "Save", print, "save", ("Ctrl+S",), ("File",)))
    crash = CrashedSession("a", "Horse", None, 0.0, time.time())
    session.drawing.pending = (object(),)
    swatch = Swatch(window)
    return {
        "history": lambda: HistoryPanel(session),
        "modelers": lambda: ModelerBar(session),
        "objects": lambda: ObjectsPanel(session),
        "parameters": lambda: ParametersPanel(session),
        "status": lambda: StatusLine(session),
        "tools": lambda: ToolRail(session),
        "welcome": lambda: WelcomeStrip(session, [Path("/x/Lamp.bozz")]),
        "chart": swatch.open_chart,
        "about": lambda: AboutDialog("Software"),
        "palette": lambda: CommandPalette(registry, session, window),
        "fault-details": lambda: FaultDetails("It stopped.", "Traceback"),
        "pen-tester": PenTester,
        "plugins": lambda: PluginManager(session),
        "preferences": PreferencesDialog,
        "recovery": lambda: RecoveryDialog([crash], print, print),
        "shortcuts": lambda: ShortcutsDialog(registry),
    }[name]()


PANELS = ["history", "modelers", "objects", "parameters", "status", "tools", "welcome"]
DIALOGS = ["about", "palette", "fault-details", "pen-tester", "plugins", "preferences"]
DIALOGS += ["recovery", "shortcuts"]


@pytest.fixture
def window(qtbot):
    made = QMainWindow()
    qtbot.addWidget(made)
    return made


@pytest.mark.parametrize("name", [*PANELS, *DIALOGS, "chart"])
def test_every_control_has_a_name(qtbot, window, fake_session, name):
    widget = make(name, fake_session, window)
    qtbot.addWidget(widget)
    kinds = (QAbstractButton, QAbstractSlider, QAbstractSpinBox, QComboBox, QLineEdit, QListWidget)
    for kind in kinds:
        for control in widget.findChildren(kind):
            if isinstance(control, QScrollBar) or control.objectName().startswith("qt_"):
                continue
            named = control.accessibleName() or (
                isinstance(control, QAbstractButton) and control.text()
            )
            assert named, f"{name}: {control}"


@pytest.mark.parametrize("name", [*PANELS, "chart"])
def test_every_button_without_words_has_a_tip(qtbot, window, fake_session, name):
    from PySide6.QtWidgets import QPushButton

    from bozzetto_app.widgets.section import Section

    widget = make(name, fake_session, window)
    qtbot.addWidget(widget)
    for button in widget.findChildren(QAbstractButton):
        is_heading = isinstance(button.parentWidget(), Section)
        if not is_heading and not isinstance(button, QPushButton):
            assert button.toolTip(), f"{name}: {button.accessibleName()}"


@pytest.mark.parametrize("name", [*PANELS, *DIALOGS])
def test_it_has_a_title_and_an_object_name(qtbot, window, fake_session, name):
    widget = make(name, fake_session, window)
    qtbot.addWidget(widget)
    assert widget.objectName() == name
    assert widget.windowTitle()
    assert widget.accessibleName()


@pytest.mark.parametrize("name", PANELS)
def test_a_dock_stays_narrow(qtbot, qapp, window, fake_session, name):
    """Two docks and the sheet fit on 800 px (a 13-inch display held portrait)."""
    apply_theme(qapp, LIGHT)
    widget = make(name, fake_session, window)
    qtbot.addWidget(widget)
    if name not in ("status", "modelers"):
        assert max(widget.minimumWidth(), widget.minimumSizeHint().width()) <= 280


@pytest.mark.parametrize("name", DIALOGS)
def test_a_dialog_fits_a_small_screen_at_200_percent(qtbot, qapp, window, fake_session, name):
    apply_theme(qapp, LIGHT)
    widget = make(name, fake_session, window)
    qtbot.addWidget(widget)
    least = widget.minimumSizeHint()
    assert least.width() <= 1280 // 2
    assert least.height() <= 800 * 3 // 4


@pytest.mark.parametrize("name", [*PANELS, *DIALOGS])
@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=lambda p: p.name)
def test_it_can_be_painted_in_both_themes(qtbot, qapp, window, fake_session, name, palette):
    apply_theme(qapp, palette)
    widget = make(name, fake_session, window)
    qtbot.addWidget(widget)
    widget.resize(max(280, widget.sizeHint().width()), 480)
    image = widget.grab().toImage()
    places = ((x, y) for x in range(0, 280, 3) for y in range(0, image.height(), 5))
    shades = {image.pixelColor(x, y).rgb() for x, y in places}
    assert len(shades) > 3


@pytest.mark.parametrize("name", ["objects", "parameters", "preferences"])
def test_tab_goes_down_the_page(qtbot, window, fake_session, name):
    widget = make(name, fake_session, window)
    qtbot.addWidget(widget)
    widget.resize(600 if name == "preferences" else 264, 900)
    widget.show()
    qtbot.waitUntil(lambda: getattr(widget, "is_ready", True))
    places = []
    start = widget
    here = start.nextInFocusChain()
    while here is not start:
        inner = isinstance(here.parent(), QAbstractSpinBox | QComboBox)
        reachable = here.focusPolicy() & Qt.FocusPolicy.TabFocus
        if reachable and not inner and here.isVisible() and widget.isAncestorOf(here):
            places.append(here.mapTo(widget, QPoint(0, 0)).y())
        here = here.nextInFocusChain()
    assert len(places) > 3
    backwards = sum(b < a - 16 for a, b in itertools.pairwise(places))
    assert backwards == 0, places
