"""Commanding: what the selected model's modeler can do to it at one word.

Which commands there are, and which of them mean something now, is asked in a worker; a command
itself runs in the row of the gestures, so that it finds the model as the last stroke left it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Model
from bozzetto.plugin.commands import Command
from bozzetto.plugin.job import Job
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["Commanding"]

COMMANDS_LIMIT = 20.0
"""Seconds a plugin may take to name its commands: it may have to be imported first."""


class Commanding(QObject):
    """The commands of the selected model.

    Attributes
    ----------
    modeler : str
        Whose commands they are; "" while none are known.
    commands : tuple of Command

    Signals
    -------
    changed
        There are other commands.
    enabled_changed
        Others of them mean something.
    """

    changed = Signal()
    enabled_changed = Signal()

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.modeler = ""
        self.commands: tuple[Command, ...] = ()
        self._enabled: frozenset[str] = frozenset()
        self._asked: Model | None = None
        self._failed: set[str] = set()
        self._channel = Channel("commands", time_limit=COMMANDS_LIMIT, parent=self)
        session.document_changed.connect(self.look)
        session.selection_changed.connect(self.look)
        session.rested.connect(self.look)

    @property
    def busy(self) -> bool:
        """Whether a modeler is still being asked."""
        return self._channel.busy

    def is_enabled(self, command_id: str) -> bool:
        """Whether a command meant something to the model when it was last asked."""
        return command_id in self._enabled

    def look(self) -> None:
        """See whether another model is selected, or the same one has another state.

        Not while a value is dragged: the answer would be overtaken by the next tick.
        """
        session = self._session
        if session.is_dragging:
            return
        model = session.selected_model
        if model is self._asked:
            return
        self._asked = model
        if model is None or session.workbench.is_foreign(model) or model.modeler in self._failed:
            self._channel.cancel()
            self._take("", (), frozenset())
            return
        commands = session.workbench.commands
        known = self.commands if model.modeler == self.modeler else None

        def work(job: Job) -> tuple[tuple[Command, ...], frozenset[str]]:
            row = commands.of(model.modeler) if known is None else known
            return row, frozenset(one.id for one in row if commands.can_run(model, one))

        def done(answer: tuple[tuple[Command, ...], frozenset[str]]) -> None:
            if model is self._asked:
                self._take(model.modeler, *answer)

        def failed(problem: BaseException) -> None:
            """One fault is enough to know: it would come back with every stroke."""
            self._failed.add(model.modeler)
            self._take("", (), frozenset())
            session.complain(problem)

        self._channel.submit(Request(work, done, failed))

    def run(self, command_id: str) -> None:
        """Do it to the selected model, as one step of the history."""
        session = self._session
        model = session.selected_model
        if model is None:
            return
        modeler, context = model.modeler, session.context()
        commands, parts = session.workbench.commands, session.workbench.parts

        def work(job: Job) -> tuple[Model, Model, str, bool, bool] | None:
            base = session.selected_model
            if base is None or base.modeler != modeler:
                return None
            command = commands.find(modeler, command_id)
            made = commands.run(base, command, context)
            only_chosen = parts.only_choice_differs(base, made)
            differs = session.workbench.differs(base, made, only_chosen=only_chosen)
            return base, made, command.title, only_chosen, differs

        def done(answer: tuple[Model, Model, str, bool, bool] | None) -> None:
            if answer is None:
                return
            base, made, title, only_chosen, differs = answer
            if not differs:
                session.say_nothing_changed(tr("Object", "“{title}” is done already.", title=title))
                return
            if all(base is not known for known in session.document):
                self.run(command_id)  # the document moved on meanwhile
                return
            session.take_drawn(title, made, is_new=False, only_chosen=only_chosen)

        session.inking.queue(Request(work, done, session.complain))

    def _take(self, modeler: str, commands: tuple[Command, ...], enabled: frozenset[str]) -> None:
        others = modeler != self.modeler or commands is not self.commands
        self.modeler, self.commands = modeler, commands
        if others:
            self._enabled = enabled
            self.changed.emit()
        elif enabled != self._enabled:
            self._enabled = enabled
            self.enabled_changed.emit()
