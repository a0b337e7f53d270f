"""A plugin's own panel: shown while an object of its modeler is selected."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.workbench.links import with_state
from bozzetto_app.i18n import tr
from bozzetto_app.session.selection import why_locked
from bozzetto_app.workers.time_limit import in_time

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.plugin.commands import Command
    from bozzetto.plugin.host.listing import TemplateFile
    from bozzetto.plugin.next_step import NextStep
    from bozzetto_app.session.session import Session

__all__ = ["PluginPanel"]


AFTER_FORM: Final = 20
"""When a plugin's widget is made after an object of its is chosen, ms."""


class _Host:
    """The panel's door to the selected object; see `bozzetto.plugin.PanelHost`."""

    def __init__(self, session: Session, modeler: str) -> None:
        self._session = session
        self._modeler = modeler
        self._callbacks: list[Callable[[], None]] = []
        self._shown: tuple[Any, NextStep] | None = None
        self._going = ""

    @property
    def state(self) -> Any | None:
        model = self._model
        return None if model is None else model.state

    @property
    def next_step(self) -> NextStep:
        from bozzetto.plugin.next_step import NextStep

        toolbox = self._session.toolbox
        if toolbox.modeler == self._modeler:
            return self._session.hints.step
        title = self._session.registry.info(self._modeler).title
        return NextStep(tr("PluginPanel", "Take {title} at the top right to go on.", title=title))

    @property
    def templates(self) -> tuple[TemplateFile, ...]:
        return self._session.registry.templates(self._modeler)

    def change(self, state: Any, label: str, *, going: bool = False) -> None:
        session, model = self._session, self._model
        try:
            if model is None:
                raise UserError(tr("PluginPanel", "Choose an object to change it."))
            if model.locked:
                raise UserError(why_locked())
            session.registry.guarded(self._modeler).check_state(state, "its panel")
            changed = with_state(session.registry, model, state)
            document = session.drawing.document.with_model(changed)
        except (UserError, PluginFault) as problem:
            session.notices.complain(problem)
            return
        key = f"panel {model.id} {label}"
        session.drawing.commit(label, document, key if going or key == self._going else None)
        if self._going and not going:
            session.objects.end_drag()
        self._going = key if going else ""

    def run(self, command: Command) -> None:
        from bozzetto.plugin.commands import Command

        if self._is(command, Command, "run") and self._model is not None:
            self._session.commands.run_of_panel(command)

    def complain(self, problem: UserError) -> None:
        if self._is(problem, UserError, "complain"):
            self._session.notices.complain(problem)

    def on_change(self, callback: Callable[[], None]) -> None:
        if self._is(callback, Callable, "on_change"):
            self._callbacks.append(callback)

    def _is(self, given: object, kind: Any, method: str) -> bool:
        """Whether a method was given what it takes; else that is a fault of the plugin."""
        if isinstance(given, kind):
            return True
        wrong = f"its panel gave {method} {type(given).__name__} where {kind.__name__} belongs"
        guard = self._session.registry.guard
        where = "".join(traceback.format_stack())
        self._session.notices.complain(guard.blame(self._modeler, wrong, where))
        return False

    def tell(self) -> None:
        """Call the panel back if the state, or what is next, is another than before."""
        shown, self._shown = self._shown, (self.state, self.next_step)
        if shown is not None and shown[0] is self.state and shown[1] == self.next_step:
            return
        guard = self._session.registry.guard
        for callback in tuple(self._callbacks):
            try:
                in_time(
                    guard,
                    self._modeler,
                    "its panel",
                    partial(guard.call, self._modeler, "its panel", callback),
                )
            except (UserError, PluginFault) as problem:
                self._callbacks.remove(callback)
                self._session.notices.complain(problem)

    @property
    def _model(self) -> Model | None:
        model = self._session.selection.model
        return model if model is not None and model.modeler == self._modeler else None


class PluginPanel(QWidget):
    """Holds the widget that the selected object's plugin makes for it.

    Signals
    -------
    changed : str
        Another modeler's widget is here: its title, or the modeler's; "" where there is none.
    """

    changed = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("plugin-panel")
        self._session = session
        self._modeler = ""
        self._title = ""
        self._host: _Host | None = None
        # Not in one turn with the form of the parameters: it may have much to import.
        self._soon = QTimer(self, singleShot=True, interval=AFTER_FORM)
        self._soon.timeout.connect(self._fill)
        self._made: QWidget | None = None
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(12, 8, 12, 12)
        changes = (session.selection.changed, session.drawing.models_changed, session.hints.changed)
        for signal in changes:
            signal.connect(self.refresh)

    @property
    def is_filled(self) -> bool:
        """Whether there is a plugin's widget to show."""
        return self._made is not None

    @property
    def is_ready(self) -> bool:
        """Whether the widget of the selected object is there, if it has one; it is made soon."""
        return not self._soon.isActive()

    @property
    def comes_first(self) -> bool:
        """Whether the widget is to be seen at once; see `bozzetto.plugin.hooks.bozzetto_panel`."""
        return self._made is not None and not self._made.property("behind")

    def refresh(self) -> None:
        """Show what belongs to the selected object, and tell it of changes."""
        model = self._session.selection.model
        known = model is not None and not self._session.workbench.is_foreign(model)
        modeler = model.modeler if model is not None and known else ""
        if modeler != self._modeler:
            self._modeler = modeler
            self._take_away()
            if modeler:
                self._soon.start()
            else:
                self._soon.stop()
                self._fill()
        if self._host is not None:
            self._host.tell()

    def _take_away(self) -> None:
        old, self._made, self._host = self._made, None, None
        if old is not None:
            old.hide()
            old.deleteLater()

    def _fill(self) -> None:
        """Make the widget of the selected object's modeler, and say what is here by now."""
        if self._modeler:
            self._make(self._modeler)
        title = ""
        if self._made is not None:
            title = self._made.windowTitle() or self._session.registry.info(self._modeler).title
        if title or self._title:
            self._title = title
            self.changed.emit(title)
        if self._host is not None:
            self._host.tell()

    def _make(self, modeler: str) -> None:
        registry, host = self._session.registry, _Host(self._session, modeler)
        try:
            made = in_time(
                registry.guard,
                modeler,
                "bozzetto_panel",
                lambda: registry.panel(modeler, self, host),
            )
            if made is not None and not isinstance(made, QWidget):
                wrong = type(made).__name__
                raise registry.guard.blame(
                    modeler, f"bozzetto_panel gave {wrong} where a QWidget belongs"
                )
        except (UserError, PluginFault) as problem:
            self._session.notices.complain(problem)
            return
        if made is not None:
            self._made, self._host = made, host
            self._column.addWidget(made)
