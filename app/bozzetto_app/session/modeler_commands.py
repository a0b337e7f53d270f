"""The commands that a modeler offers for the selected model.

A worker asks which commands there are, and which of them apply now. A command itself runs in
the queue of the gestures, so that it finds the model as the last stroke left it. Some write a
file and change nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Model
from bozzetto.errors import UserError
from bozzetto.plugin.commands import Command
from bozzetto.plugin.job import Job
from bozzetto.workbench.workbench import Workbench
from bozzetto_app.i18n import tr
from bozzetto_app.session.document_model import DocumentModel
from bozzetto_app.session.gesture_context import GestureContext
from bozzetto_app.session.notices import Notices
from bozzetto_app.session.selection import Selection
from bozzetto_app.workers.channel import Channel, Request

__all__ = ["ModelerCommands"]

COMMANDS_LIMIT = 20.0
"""Seconds a plugin may take to name its commands: it may have to be imported first."""


@dataclass(frozen=True)
class _Outcome:
    """The result of a command; `differs` is False if it changed nothing."""

    base: Model
    made: Model
    title: str
    only_chosen: bool
    differs: bool


class ModelerCommands(QObject):
    """The commands of the selected model.

    Attributes
    ----------
    modeler : str
        Id of the modeler that offers them; "" while none are known.
    commands : tuple of Command
    channel : Channel
        The work of asking for commands.

    Signals
    -------
    changed
        There are other commands.
    enabled_changed
        Other commands apply.
    place_wanted : Command
        A command that writes a file was chosen: ask where it goes, and call `write`.
    """

    changed = Signal()
    enabled_changed = Signal()
    place_wanted = Signal(object)

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        context: GestureContext,
        edits: Channel,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.modeler = ""
        self.commands: tuple[Command, ...] = ()
        self.channel = Channel("commands", time_limit=COMMANDS_LIMIT, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._context, self._edits, self._notices = context, edits, notices
        self._enabled: frozenset[str] = frozenset()
        self._asked: Model | None = None
        self._failed: set[str] = set()
        for signal in (drawing.changed, selection.changed):
            signal.connect(self.look)

    def is_enabled(self, command_id: str) -> bool:
        """Return whether a command applied to the model when it was last asked."""
        return command_id in self._enabled

    def look(self) -> None:
        """Ask again if another model is selected, or its state differs."""
        model = self._selection.model
        if model is self._asked:
            return
        self._asked = model
        foreign = model is None or self._workbench.is_foreign(model)
        if model is None or foreign or model.modeler in self._failed:
            self.channel.cancel()
            self._take("", (), frozenset())
            return
        commands = self._workbench.commands
        known = self.commands if model.modeler == self.modeler else None

        def work(job: Job) -> tuple[tuple[Command, ...], frozenset[str]]:
            row = commands.of(model.modeler) if known is None else known
            return row, frozenset(one.id for one in row if commands.can_run(model, one))

        def done(answer: tuple[tuple[Command, ...], frozenset[str]]) -> None:
            if model is self._asked:
                self._take(model.modeler, *answer)

        def failed(problem: BaseException) -> None:
            """Report one fault and ask no more: it would return with every stroke."""
            self._failed.add(model.modeler)
            self._take("", (), frozenset())
            self._notices.complain(problem)

        self.channel.submit(Request(work, done, failed))

    def run(self, command_id: str) -> None:
        """Run a command on the selected model, as one step of the history.

        One that writes a file waits for its place; see `place_wanted`.
        """
        model = self._selection.model
        if model is None:
            return
        known = self.commands if model.modeler == self.modeler else ()
        writer = next((one for one in known if one.id == command_id and one.writes), None)
        if writer is not None:
            self.place_wanted.emit(writer)
            return
        modeler, context = model.modeler, self._context.now()
        bench = self._workbench

        def work(job: Job, base: Model | None) -> _Outcome | None:
            if base is None or base.modeler != modeler:
                return None
            command = bench.commands.find(modeler, command_id)
            made = bench.commands.run(base, command, context)
            only_chosen = bench.parts.only_choice_differs(base, made)
            differs = bench.differs(base, made, only_chosen=only_chosen)
            return _Outcome(base, made, command.title, only_chosen, differs)

        def done(answer: _Outcome | None) -> None:
            if answer is None:
                return
            if not answer.differs:
                said = tr("Object", "“{title}” is done already.", title=answer.title)
                self._notices.say_nothing_changed(said)
            elif all(answer.base is not known for known in self._drawing.document):
                self.run(command_id)  # the document changed meanwhile
            else:
                try:
                    self._drawing.document.refuse_circle(answer.made)
                except UserError as problem:
                    self._notices.complain(problem)
                    return
                self._drawing.apply_model(
                    answer.title, answer.made, is_new=False, only_chosen=answer.only_chosen
                )

        self._edits.submit(
            Request(work, done, self._notices.complain, inputs=lambda: self._selection.model)
        )

    def write(self, command_id: str, path: Path) -> None:
        """Write the file of a command for the selected model, as the last stroke left it."""
        model = self._selection.model
        if model is None:
            return
        modeler, context = model.modeler, self._context.now()
        commands = self._workbench.commands

        def work(job: Job, base: Model | None) -> bool:
            if base is None or base.modeler != modeler:
                return False
            commands.write(base, commands.find(modeler, command_id), context, path)
            return True

        def done(is_written: bool) -> None:
            if is_written:
                self._notices.tell(tr("Files", "Saved “{name}”.", name=path.name))

        self._edits.submit(
            Request(work, done, self._notices.complain, inputs=lambda: self._selection.model)
        )

    def _take(self, modeler: str, commands: tuple[Command, ...], enabled: frozenset[str]) -> None:
        others = modeler != self.modeler or commands is not self.commands
        self.modeler, self.commands = modeler, commands
        if others:
            self._enabled = enabled
            self.changed.emit()
        elif enabled != self._enabled:
            self._enabled = enabled
            self.enabled_changed.emit()
