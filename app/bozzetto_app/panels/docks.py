"""The docks on the right: objects, parameters, history, and a plugin's own panel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QTabWidget, QWidget

from bozzetto.cached_properties import cached_property
from bozzetto_app.i18n import tr
from bozzetto_app.panels.plugin_panel import PluginPanel

if TYPE_CHECKING:
    from bozzetto_app.panels.history import HistoryPanel
    from bozzetto_app.panels.objects.panel import ObjectsPanel
    from bozzetto_app.panels.properties.form import ParametersPanel
    from bozzetto_app.session.session import Session

__all__ = ["Docks"]

RIGHT: Final = Qt.DockWidgetArea.RightDockWidgetArea

LEAST_WIDTH: Final = 264
"""Of the docks, pixels."""

FIRST_HEIGHTS: Final = (232, 390, 112)
"""Of objects, parameters and history at the first start, pixels."""

LEAST_HEIGHTS: Final = (174, 260, 98)
"""Of the same where a plugin has a panel of its own beside the parameters, pixels.

Three objects and two steps are legible; what a panel has beyond its height is scrolled to.
"""


class Docks(QObject):
    """Panels around the sheet, which are made once the window has been painted.

    Parameters
    ----------
    window : QMainWindow
        Holds the docks.
    session : Session

    Signals
    -------
    reading_wanted : str
        Other modelers are to read the ink of an object (id).

    Notes
    -----
    The docks stand at once, so that nothing moves when their panels come. A panel that is asked
    for earlier is made then.
    """

    reading_wanted = Signal(str)

    def __init__(self, window: QMainWindow, session: Session) -> None:
        super().__init__(window)
        self._window = window
        self._session = session
        self._objects_dock = self._dock("objects", tr("Objects", "Objects"))
        self._parameters_dock = self._dock("parameters", tr("Parameters", "Parameters"))
        self._history_dock = self._dock("history", tr("History", "History"))
        self._column = [self._objects_dock, self._parameters_dock, self._history_dock]
        self.plugin_panel = PluginPanel(session)
        self._plugin_dock = self._dock("plugin-panel", "")
        self._plugin_dock.setWidget(self.plugin_panel)
        self._room: tuple[tuple[int, int], tuple[int, int]] | None = None
        self._hidden: tuple[int, int] | None = None
        window.setTabPosition(RIGHT, QTabWidget.TabPosition.North)
        window.tabifyDockWidget(self._parameters_dock, self._plugin_dock)
        self.plugin_panel.changed.connect(self._show_plugin_panel)

    def _dock(self, name: str, title: str) -> QDockWidget:
        dock = QDockWidget(title, self._window)
        dock.setObjectName(f"dock-{name}")
        dock.setFeatures(QDockWidget.DockWidgetFeature.DockWidgetMovable)
        dock.setMinimumWidth(LEAST_WIDTH)
        self._window.addDockWidget(RIGHT, dock)
        return dock

    # -- the panels --

    @cached_property
    def objects(self) -> ObjectsPanel:
        """The objects of the drawing."""
        from bozzetto_app.panels.objects.panel import ObjectsPanel

        panel = ObjectsPanel(self._session)
        panel.reading_wanted.connect(self.reading_wanted)
        self._objects_dock.setWidget(panel)
        return panel

    @cached_property
    def parameters(self) -> ParametersPanel:
        """The values of the selected object."""
        from bozzetto_app.panels.properties.form import ParametersPanel

        panel = ParametersPanel(self._session)
        self._parameters_dock.setWidget(panel)
        return panel

    @cached_property
    def history(self) -> HistoryPanel:
        """The steps of the drawing."""
        from bozzetto_app.panels.history import HistoryPanel

        panel = HistoryPanel(self._session)
        self._history_dock.setWidget(panel)
        return panel

    def fill(self) -> None:
        """Make the panels that nobody has asked for yet."""
        for panel in (self.objects, self.parameters, self.history):
            panel.show()  # a dock that is visible does not show what it is given

    # -- which are shown --

    @property
    def are_shown(self) -> bool:
        """Whether any dock is open."""
        return any(not dock.isHidden() for dock in self._column)

    def show(self, shown: bool) -> None:
        """Show all docks, as high as they were, or hide them."""
        if self.are_shown and not shown:
            self._hidden = self.ends
        for dock in self._column:
            dock.setVisible(shown)
        self._plugin_dock.setVisible(shown and self.plugin_panel.is_filled)
        if shown:  # Qt gives the first what the others had
            QTimer.singleShot(0, self, self._take_ends_back)

    def _take_ends_back(self) -> None:
        """Give the docks the heights that they had when they were hidden."""
        ends, self._hidden = self._hidden, None
        if ends is not None and self.are_shown:
            self._resize_ends(ends)

    def show_plugin_dock(self) -> None:
        """Show the dock of a plugin's panel where there is something in it."""
        self._plugin_dock.setVisible(self.plugin_panel.is_filled and self.are_shown)

    def raise_plugin_panel(self) -> None:
        """Bring a plugin's panel before the parameters, unless these have the keyboard."""
        used = QApplication.focusWidget()
        if used is None or not self._parameters_dock.isAncestorOf(used):
            self._plugin_dock.raise_()

    def raise_parameters(self) -> None:
        """Bring the parameters before a plugin's panel."""
        self._parameters_dock.raise_()

    # -- their heights --

    def take_first_heights(self) -> None:
        """Give each panel the height of a first start."""
        self._resize(FIRST_HEIGHTS)

    def _show_plugin_panel(self, title: str) -> None:
        self._plugin_dock.setWindowTitle(title)
        self._plugin_dock.setVisible(bool(title) and self.are_shown)
        if self.plugin_panel.comes_first:
            self._plugin_dock.raise_()
            QTimer.singleShot(0, self, self._make_room)
            return
        if title:
            self.raise_parameters()
        self.give_room_back()

    def _make_room(self) -> None:
        """Give a plugin's panel the height that it asks for, and what is left to the objects."""
        objects, panel, history = LEAST_HEIGHTS
        room = max(panel, self._height() - objects - history)
        asked = min(max(panel, self.plugin_panel.sizeHint().height()), room)
        if self._plugin_dock.isVisible() and self._plugin_dock.height() < asked:
            before = self.ends
            objects = max(objects, self._height() - asked - history)
            self._resize((objects, asked, history))
            QTimer.singleShot(0, self, lambda: setattr(self, "_room", (before, self.ends)))

    def give_room_back(self) -> None:
        """Take back what a plugin's panel was given, unless a border was moved since."""
        room, self._room = self._room, None
        if room is not None and room[1] == self.ends:
            self._resize_ends(room[0])

    @property
    def ends(self) -> tuple[int, int]:
        """Heights of the objects and of the history, pixels; what is between has the rest."""
        return self._objects_dock.height(), self._history_dock.height()

    def _height(self) -> int:
        """Return the height of all docks, that of the middle beside them."""
        middle: QWidget = self._window.centralWidget() or self._window
        return middle.height()

    def _resize_ends(self, ends: tuple[int, int]) -> None:
        """Give the objects and the history heights, and what is between the rest."""
        objects, history = ends
        self._resize((objects, max(1, self._height() - objects - history), history))

    def _resize(self, heights: tuple[int, int, int]) -> None:
        self._window.resizeDocks(self._column, list(heights), Qt.Orientation.Vertical)
