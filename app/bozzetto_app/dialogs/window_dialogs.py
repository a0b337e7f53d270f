"""The dialogs that a window opens; each is imported when it is first wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog

from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.session.recent_files import recent_files
from bozzetto_app.settings import keep_plugin_disabled

if TYPE_CHECKING:
    from bozzetto_app.main_window import Window
    from bozzetto_app.session.notices import Notice

__all__ = ["Dialogs"]


class Dialogs:
    """Opens dialogs over a window, and carries out what they change."""

    def __init__(self, window: Window) -> None:
        self._window = window

    def open_palette(self) -> None:
        """Find a command by name."""
        from bozzetto_app.dialogs.command_palette import CommandPalette

        palette = CommandPalette(
            self._window.actions_,
            self._window.session,
            self._window,
            recent=recent_files,
            open_document=self._window.open,
            focus_parameter=self._window.docks.parameters.focus_parameter,
        )
        palette.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        palette.open_over(self._window)

    def open_readings(self, model_id: str = "") -> None:
        """Ask other modelers what they make of ink, and choose one; see `InkReadings.ink`.

        Parameters
        ----------
        model_id : str
            The object with the ink; "" for what waits, or else the selected one.
        """
        from bozzetto_app.dialogs.read_ink import ReadInkDialog

        session = self._window.session
        readings, document = session.readings, session.drawing.document
        ink = readings.ink_of(document.model(model_id)) if model_id else readings.ink
        if ink is not None:
            self.show(ReadInkDialog(session, ink, self._window))

    def open_trace(self) -> None:
        """Trace the newest visible underlay into ink; where there is none, ask for a picture."""
        from bozzetto_app.dialogs.trace_picture import TraceDialog

        window = self._window
        source = window.session.pictures.tracing.underlay or window.files.ask_picture(
            tr("Trace", "Trace a picture into ink")
        )
        if source is not None:
            self.show(TraceDialog(window.session, source, window))

    def open_guide(self) -> None:
        """Show the guide beside the sheet."""
        from bozzetto_app.dialogs.guide import GuideDialog

        self.show(GuideDialog(self._window))

    def open_shortcuts(self) -> None:
        """List keys and gestures."""
        from bozzetto_app.dialogs.shortcuts import ShortcutsDialog

        self.show(ShortcutsDialog(self._window.actions_, self._window))

    def open_preferences(self) -> None:
        """Change what the program remembers."""
        from bozzetto_app.dialogs.preferences import PreferencesDialog

        dialog = PreferencesDialog(self._window)
        dialog.theme_chosen.connect(self._window.set_theme)
        dialog.changed.connect(self._window.canvas.read_settings)
        dialog.changed.connect(self._window.changing_menus.show_recent)
        dialog.pen_tester_wanted.connect(self.open_pen_tester)
        self.show(dialog)

    def open_pen_tester(self) -> None:
        """Try the pen."""
        from bozzetto_app.dialogs.pen_tester import PenTester

        dialog = PenTester(self._window)
        dialog.finished.connect(self._window.canvas.read_settings)
        self.show(dialog)

    def open_plugins(self) -> None:
        """See the plugins, switch them on and off."""
        from bozzetto_app.dialogs.plugin_manager import PluginManager

        dialog = PluginManager(self._window.session, self._window)
        dialog.switched.connect(self.plugin_switched)
        self.show(dialog)

    def open_about(self) -> None:
        """Show the names and versions of the software."""
        from bozzetto_app.dialogs.about import AboutDialog

        self.show(AboutDialog(self._window.canvas.describe_viewport(), self._window))

    def open_details(self, notice: Notice) -> None:
        """Show the traceback of a fault."""
        from bozzetto_app.dialogs.fault_details import FaultDetails

        self.show(FaultDetails(notice.text, notice.details, self._window))

    def show(self, dialog: QDialog) -> None:
        """Show a dialog beside the sheet, which can still be used; delete it when it closes."""
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setModal(False)
        dialog.show()

    # -- plugins --

    def switch_off(self, plugin: str) -> None:
        """Switch a plugin off, now and at the next start."""
        self._window.session.registry.set_disabled(plugin, True)
        self.keep_off(plugin)

    def keep_off(self, plugin: str) -> None:
        """Keep a plugin switched off, also at the next start."""
        try:
            keep_plugin_disabled(plugin, True)
        except UserError as problem:
            self._window.session.notices.complain(problem)
        self.plugin_switched(plugin, False)

    def plugin_switched(self, plugin: str, on: bool) -> None:
        """Stop drawing with a plugin that was switched off; its objects stay as they are."""
        toolbox = self._window.session.toolbox
        self._window.modelers.refresh()
        self._window.actions_.refresh()
        self._window.docks.parameters.refresh()
        if not on:
            toolbox.drop_if_gone()
        elif toolbox.modelers and not toolbox.modeler:
            toolbox.take_modeler(toolbox.modelers[0].id)
