"""The window: the sheet in the middle, everything else around it and out of its way."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import QByteArray, QEvent, QObject, Qt, QTimer
from PySide6.QtGui import QCloseEvent, QIcon, QImage, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QApplication,
    QHBoxLayout,
    QLineEdit,
    QMainWindow,
    QMenuBar,
    QSizePolicy,
    QStatusBar,
    QWidget,
)

from bozzetto.cached_properties import cached_property
from bozzetto.errors import UserError
from bozzetto.view.standard_views import standard_view
from bozzetto_app.actions.dynamic_menus import ChangingMenus
from bozzetto_app.actions.menu_actions import commands_of, number_keys, tool_key_at
from bozzetto_app.actions.registry import ActionRegistry
from bozzetto_app.canvas.canvas import Canvas
from bozzetto_app.canvas.framing import Framing
from bozzetto_app.canvas.input.state_machine import Mode
from bozzetto_app.dialogs.file_dialogs import FileQuestions
from bozzetto_app.dialogs.window_dialogs import Dialogs
from bozzetto_app.i18n import tr
from bozzetto_app.panels.docks import Docks
from bozzetto_app.panels.modeler_bar import ModelerBar
from bozzetto_app.panels.status_line import StatusLine
from bozzetto_app.panels.tool_rail import ToolRail
from bozzetto_app.panels.welcome_strip import WelcomeStrip
from bozzetto_app.paths import recovery_folder
from bozzetto_app.session.recent_files import recent_files
from bozzetto_app.session.replay import Replays
from bozzetto_app.session.view_state import FIRST_VIEW
from bozzetto_app.settings import settings
from bozzetto_app.style.theme import FRAME, Theme, apply_theme, current_palette, palette_for

if TYPE_CHECKING:
    from bozzetto.document.recovery.recovery import CrashedSession
    from bozzetto.view.camera import Camera
    from bozzetto_app.session.autosave import Keeper
    from bozzetto_app.session.session import Session

__all__ = ["Window"]

AFTER_PAINT = 300
"""When what the first object needs is made ready, ms after the window is: all is painted then."""

LAYOUT_VERSION = 3
"""Raised when docks come or go, so that an old layout is not forced on a new window."""

FIRST_SIZE = (1280, 800)
"""Of the window at the first start, if the screen is large enough, pixels."""

THEME = "view/theme"
RADIAL = (
    "edit.undo",
    "edit.redo",
    "view.fit",
    "view.front",
    "view.right",
    "view.three-quarter",
    "edit.commit",
    "object.delete",
)
"""What the radial menu offers, clockwise from the top."""


class _MenuEntry(NamedTuple):
    """An action as the radial menu wants it."""

    title: str
    icon: QIcon
    enabled: bool
    registry: ActionRegistry
    action: str

    def trigger(self) -> None:
        self.registry.run(self.action)


def _thumbnail_of(path: Path) -> QImage | None:
    """Return the small picture of a drawing; readers are imported once one is wanted."""
    from bozzetto_app.dialogs.thumbnails import thumbnail_of

    return thumbnail_of(path)


def top_row(menus: QMenuBar, modelers: QWidget) -> QWidget:
    """Return a bar with menus on the left, and modelers in the room that they leave."""
    top = QWidget()
    top.setObjectName("top")
    menus.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Preferred)
    row = QHBoxLayout(top)
    row.setContentsMargins(4, 0, 0, 0)
    row.setSpacing(16)
    row.addWidget(menus, 0, Qt.AlignmentFlag.AlignVCenter)
    row.addWidget(modelers, 1)
    return top


def _make_style_classes() -> None:
    """Let PySide make the classes of the style, forty enums, before the first object needs them."""
    from PySide6.QtWidgets import QStyle  # noqa: F401  # it is the import that makes them


class Window(QMainWindow):
    """The one window of the program.

    Parameters
    ----------
    session : Session
    recovery : Path, optional
        Folder of the recovery data; default the program's own.
    """

    def __init__(self, session: Session, recovery: Path | None = None) -> None:
        super().__init__()
        self.setObjectName("window")
        self.session = session
        self.files = FileQuestions(session, self)
        self.dialogs = Dialogs(self)
        self._recovery = recovery
        self._dress(Theme(settings().value(THEME, Theme.SYSTEM.value)))
        self.canvas = Canvas(session, current_palette(), self)
        self.actions_ = ActionRegistry(self, self.canvas)
        self.canvas.menu_entries = self._radial_entries
        self._framing = Framing(session, self)
        self.canvas.hand.pressed.connect(self._framing.end)
        self.replays = Replays(session, self)
        self.replays.began.connect(self._replay_began)
        self.replays.inked.connect(self.canvas.waiting.follow)
        self._closing = False
        self._said_first = ""
        self._is_guided = False

        self.status = StatusLine(session)
        self.status.faults.lie_over(self.canvas)
        self.status.details_wanted.connect(self.dialogs.open_details)
        self.status.switched_off.connect(self.dialogs.keep_off)
        self.modelers = ModelerBar(session)
        self.setCentralWidget(self._middle())
        self.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)
        self.setDockOptions(QMainWindow.DockOption.AnimatedDocks)
        self.docks = Docks(self, session)
        self.docks.reading_wanted.connect(self.dialogs.open_readings)
        self.canvas.viewports.first_painted.connect(self.docks.fill)
        session.hints.changed.connect(self._show_what_guides)
        self.docks.plugin_panel.changed.connect(self._show_what_guides)
        self.canvas.hand.mode_changed.connect(self._show_what_guides)
        self.welcome = self._welcome()
        self.actions_.register(*commands_of(self), *number_keys(self))
        self.changing_menus = ChangingMenus(self, self.actions_)
        self.actions_.refused.connect(lambda why: session.notices.complain(UserError(why)))
        self.actions_.is_so.connect(session.notices.tell)
        self.canvas.menu_refused.connect(lambda entry: self.actions_.refuse(entry.action))
        self.setMenuWidget(self._top())
        self.setStatusBar(self._bottom())

        session.drawing.changed.connect(lambda: self.keeper, Qt.ConnectionType.SingleShotConnection)
        session.drawing.changed.connect(self._show_title)
        session.drawing.waiting_changed.connect(self._show_title)
        for signal in (
            session.drawing.changed,
            session.selection.changed,
            session.drawing.waiting_changed,
            session.view.style_changed,
            session.toolbox.modeler_changed,
        ):
            signal.connect(self.actions_.refresh)
        session.files.exchange.imported.connect(self._imported)
        session.drawing.opened.connect(self.replays.stop)
        session.files.busy_changed.connect(self._saving_ended)
        session.toolbox.modeler_changed.connect(self._say_what_first)
        session.files.exchange.busy_changed.connect(self._say_what_first_once_read)
        session.files.when_safe = self.files.when_safe
        self.canvas.hand.ink_began.connect(self._ink_began)
        self._restore_layout()
        self._show_title()
        if session.toolbox.modelers and not session.toolbox.modeler:
            session.toolbox.prefer(session.toolbox.modelers[0].id)
            self.canvas.viewports.first_painted.connect(session.toolbox.ask_for_tools)
        QTimer.singleShot(AFTER_PAINT, self, _make_style_classes)
        self._say_what_first()
        self.canvas.setFocus()

    @cached_property
    def keeper(self) -> Keeper:
        """The writer of recovery data; made after the first paint, or once something is drawn."""
        from bozzetto_app.session.autosave import Keeper

        return Keeper(self.session, self._recovery or recovery_folder())

    # -- putting it together --

    def _top(self) -> QWidget:
        """Return the bar with the menus on the left and the modelers on the right."""
        menus = QMenuBar()
        menus.setObjectName("menus")
        self.actions_.attach(menus)
        return top_row(menus, self.modelers)

    def _middle(self) -> QWidget:
        """Return the tool rail and the sheet, side by side."""
        middle = QWidget()
        row = QHBoxLayout(middle)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addWidget(ToolRail(self.session))
        row.addWidget(self.canvas, 1)
        return middle

    def _bottom(self) -> QStatusBar:
        """Return the status line over the whole width."""
        bar = QStatusBar()
        bar.setSizeGripEnabled(False)
        bar.setContentsMargins(0, 0, 0, 0)
        bar.addPermanentWidget(self.status, 1)
        return bar

    def _welcome(self) -> WelcomeStrip:
        """Return the strip over the left of the sheet; when it closes, the ink does not move."""
        strip = WelcomeStrip(self.session, recent_files(), _thumbnail_of, self.canvas)
        strip.setAttribute(Qt.WidgetAttribute.WA_NoMousePropagation)
        strip.setCursor(Qt.CursorShape.ArrowCursor)
        strip.sample_chosen.connect(self._open_sample)
        strip.sample_watched.connect(self.watch)
        strip.recent_chosen.connect(self.open)
        strip.closed.connect(strip.hide)
        strip.closed.connect(self.canvas.setFocus)  # not the next widget, with a ring around it
        strip.installEventFilter(self)
        self.canvas.installEventFilter(self)
        return strip

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.canvas and event.type() == QEvent.Type.Resize:
            self.welcome.lie_on(self.canvas.size())
        elif watched is self.welcome and event.type() in (QEvent.Type.Show, QEvent.Type.Hide):
            shown = event.type() == QEvent.Type.Show
            self.canvas.leave_room(self.welcome.width() if shown else 0)
        return False

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Do what a key means on the sheet, where nothing with the focus wanted it."""
        keys = QKeySequence(event.keyCombination()).toString(
            QKeySequence.SequenceFormat.PortableText
        )
        again = event.isAutoRepeat()
        wishes = (keys, tool_key_at(event))
        typed = event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter)
        if typed and isinstance(self.focusWidget(), QLineEdit):
            super().keyPressEvent(event)  # Enter has taken what was typed
        elif not any(self.actions_.take_key(key, again=again) for key in wishes):
            super().keyPressEvent(event)

    def _radial_entries(self) -> Sequence[_MenuEntry]:
        self.actions_.refresh()
        entries = []
        for name in RADIAL:
            made = self.actions_.qaction(name)
            title = made.text().replace("&", "").split(",")[0]
            glyph = self.actions_.icon(name)
            entries.append(_MenuEntry(title, glyph, made.isEnabled(), self.actions_, name))
        return entries

    # -- the layout is remembered --

    def _restore_layout(self) -> None:
        free = self.screen().availableGeometry().size()
        room = free.width() - FRAME[0], free.height() - FRAME[1]
        self.resize(min(FIRST_SIZE[0], room[0]), min(FIRST_SIZE[1], room[1]))
        kept = settings()
        geometry, state = kept.value("window/geometry"), kept.value("window/state")
        if isinstance(geometry, QByteArray):
            self.restoreGeometry(geometry)
        restored = isinstance(state, QByteArray) and self.restoreState(state, LAYOUT_VERSION)
        if not restored:
            self.docks.take_first_heights()
        self.docks.show_plugin_dock()
        self.welcome.setVisible(not len(self.session.drawing.document))

    def closeEvent(self, event: QCloseEvent) -> None:
        if not self._closing and self.session.drawing.is_modified:
            event.ignore()
            QTimer.singleShot(0, lambda: self.files.when_safe(self.close_without_asking))
        elif self.session.files.saving:
            event.ignore()
            self._closing = True
            self.hide()
        else:
            self._leave()
            event.accept()

    def close_without_asking(self) -> None:
        """Close the window although changes may be in no file; a save under way ends first."""
        self._closing = True
        self.close()

    def _leave(self) -> None:
        kept = settings()
        self.docks.give_room_back()
        kept.setValue("window/geometry", self.saveGeometry())
        kept.setValue("window/state", self.saveState(LAYOUT_VERSION))
        self.replays.stop()
        self.session.cancel_all()
        self.session.files.close()
        self.canvas.viewports.release()
        self.keeper.close()

    def _saving_ended(self) -> None:
        if self._closing and not self.session.files.saving:
            self.close()

    # -- documents --

    def expect_document(self) -> None:
        """Do not ask for a first stroke: a document is on its way onto the sheet."""
        self.welcome.hide()
        self.canvas.show_hint("")

    def open(self, path: Path) -> None:
        """Open a document once unsaved work is safe."""
        self.session.files.open_safely(path)

    def _open_sample(self, modeler_id: str, path: Path, title: str) -> None:
        self.session.toolbox.take_modeler(modeler_id)
        self.session.files.exchange.import_file(path, title)
        self.canvas.setFocus()

    def _imported(self, drawn_in: Camera | None) -> None:
        """Bring what came from a file into view, once there is something to see.

        What comes to an empty sheet is seen as it was drawn, or else three-quarter.
        """
        if not self.session.drawing.document.models:
            size = self.session.view.camera.viewport
            view = drawn_in or standard_view(FIRST_VIEW, "three-quarter")
            self.session.view.set_camera(view.with_viewport(*size))
        self.session.solver.settled.connect(
            lambda _: self.canvas.views.show_news(), Qt.ConnectionType.SingleShotConnection
        )

    def watch(self, modeler_id: str, path: Path) -> None:
        """Replay a recorded drawing, stroke by stroke, on an empty sheet."""
        self.files.when_safe(lambda: self.replays.watch(modeler_id, path))

    def _replay_began(self) -> None:
        self.welcome.hide()
        self.canvas.show_hint("")

    def offer_recovery(self) -> None:
        """Ask about drawings that a crash left behind, if there are any."""

        def found(crashed: list[CrashedSession]) -> None:
            if crashed:
                from bozzetto_app.dialogs.recovery import RecoveryDialog

                keeper = self.keeper
                suspect = self.session.registry.plugin_at(keeper.files_at_crash)
                plugin, title = ("", "") if suspect is None else (suspect.id, suspect.title)
                dialog = RecoveryDialog(
                    crashed,
                    keeper.recover,
                    keeper.discard,
                    self,
                    suspect=title,
                    switch_off=lambda: self.dialogs.switch_off(plugin),
                )
                self.dialogs.show(dialog)

        self.keeper.find_crashed(found)
        self.session.files.tidy()

    # -- what the commands need --

    def keep_view(self) -> None:
        """Keep the view that is shown now, with the document."""
        self.changing_menus.keep_view()

    @property
    def panels_shown(self) -> bool:
        """Whether any dock is open."""
        return self.docks.are_shown

    def toggle_panels(self) -> None:
        """Hide all docks, or show them again."""
        shown = not self.panels_shown
        self.docks.show(shown)
        if not shown:
            self.welcome.hide()

    def _show_what_guides(self) -> None:
        """Show the modeler's own panel, once, where the next step is done there.

        Not while the pen is down, and not over a panel that has the keyboard.
        """
        wanted = self.session.hints.step.panel and self.docks.plugin_panel.is_filled
        if wanted == self._is_guided or self.canvas.hand.machine.mode is not Mode.IDLE:
            return
        self._is_guided = wanted
        if wanted:
            self.docks.raise_plugin_panel()

    @property
    def is_dark(self) -> bool:
        """Whether the dark theme is on."""
        return current_palette().name == "dark"

    def toggle_theme(self) -> None:
        """Change between the light and the dark theme, and remember it."""
        self.set_theme(Theme.LIGHT if self.is_dark else Theme.DARK)

    def set_theme(self, theme: Theme) -> None:
        """Use a theme, and remember it."""
        settings().setValue(THEME, theme.value)
        self._dress(theme)
        self.canvas.set_palette(current_palette())

    def _dress(self, theme: Theme) -> None:
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        apply_theme(application, palette_for(theme))

    # -- small things --

    def _ink_began(self) -> None:
        self.welcome.hide()
        self.status.went_on()
        self.replays.stop()

    def _say_what_first(self) -> None:
        """Show on an empty sheet what the active modeler wants to have drawn first."""
        modeler = self.session.toolbox.modeler
        if modeler == self._said_first:
            return
        self._said_first = modeler
        drawn = (
            len(self.session.drawing.document)
            or self.session.drawing.pending
            or self.replays.current is not None
        )
        if modeler and not drawn:
            self.canvas.show_hint(self.session.hints.step.sentence)

    def _say_what_first_once_read(self, reads: bool) -> None:
        """Ask for nothing on an empty sheet while a file is read that is to lie there."""
        if reads:
            self.canvas.show_hint("")
        else:
            self._said_first = ""
            self._say_what_first()

    def _show_title(self) -> None:
        if len(self.session.drawing.document):
            self.canvas.show_hint("")
        drawing = self.session.drawing
        title = drawing.title
        if drawing.read_only:
            title = tr("Window", "{title} (read only)", title=title)
        self.setWindowTitle(f"{title}[*] — Bozzetto")
        self.setWindowModified(self.session.drawing.is_modified)
