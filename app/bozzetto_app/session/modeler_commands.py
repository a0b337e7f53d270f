"""The commands that a modeler offers for the selected model, or for one that is still to be drawn.

A worker asks which commands there are, and which of them apply now. A command itself runs in
the queue of the gestures, so that it finds the model as the last stroke left it. Some write a
file and change nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import QObject, Signal

from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import LATE_AFTER, Channel, Request

if TYPE_CHECKING:
    from pathlib import Path

    from bozzetto.document.model import Document, Model
    from bozzetto.plugin.commands import Command
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.toolbox import Toolbox

__all__ = ["ModelerCommands"]


class _Outcome(NamedTuple):
    """The result of a command: `made` replaces `base`, or is new if there is none.

    `differs` is False if it neither changed nor began anything.
    """

    base: Model | None
    made: Model
    title: str
    only_chosen: bool
    differs: bool


class ModelerCommands(QObject):
    """The commands of the selected model; while none is, those of the active modeler.

    One that means something on an empty object begins one.

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
    begun
        A command began an object.
    place_wanted : Command
        A command that writes a file was chosen: ask where it goes, and call `write`.
    """

    changed = Signal()
    enabled_changed = Signal()
    begun = Signal()
    place_wanted = Signal(object)

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        toolbox: Toolbox,
        context: GestureContext,
        edits: Channel,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.modeler = ""
        self.commands: tuple[Command, ...] = ()
        self.channel = Channel("commands", time_limit=LATE_AFTER, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._toolbox = toolbox
        self._context, self._edits, self._notices = context, edits, notices
        self._enabled: frozenset[str] = frozenset()
        self._asked: Model | str | None = None
        self._failed: set[str] = set()
        for signal in (drawing.changed, selection.changed, toolbox.modeler_changed):
            signal.connect(self.look)

    def is_enabled(self, command_id: str) -> bool:
        """Return whether a command applied to the model when it was last asked."""
        return command_id in self._enabled

    @property
    def is_for_none(self) -> bool:
        """Whether the commands are those of an object that is still to be drawn."""
        return isinstance(self._asked, str)

    def look(self) -> None:
        """Ask again if another model is selected, its state differs, or another one may begin."""
        model, modeler = self._selection.model, self._toolbox.modeler
        if model is not None:
            modeler = "" if self._workbench.is_foreign(model) else model.modeler
        elif not self._toolbox.tools:
            modeler = ""  # its plugin is not imported yet
        asked = modeler if model is None else model
        if asked is self._asked or (model is None and asked == self._asked):
            return
        self._asked = asked
        if not modeler or modeler in self._failed:
            self.channel.cancel()
            self._take("", (), frozenset())
            return
        bench, context = self._workbench, self._context.now()
        commands = bench.commands
        known = self.commands if modeler == self.modeler else None

        def work(job: Job) -> tuple[tuple[Command, ...], frozenset[str]]:
            row = commands.of(modeler) if known is None else known
            if not row:
                return row, frozenset()
            now = bench.create(modeler, context) if model is None else model
            return row, frozenset(one.id for one in row if commands.can_run(now, one))

        def done(answer: tuple[tuple[Command, ...], frozenset[str]]) -> None:
            if asked is self._asked:
                self._take(modeler, *answer)

        def failed(problem: BaseException) -> None:
            """Report one fault and ask no more: it would return with every stroke."""
            self._failed.add(modeler)
            self._take("", (), frozenset())
            self._notices.complain(problem)

        self.channel.submit(Request(work, done, failed))

    def run(self, command_id: str) -> None:
        """Run a command on the selected model, or on one that it begins, as one step.

        One that writes a file waits for its place; see `place_wanted`.
        """
        writer = next((one for one in self.commands if one.id == command_id and one.writes), None)
        if writer is not None:
            self.place_wanted.emit(writer)
        else:
            self._submit(command_id, begins=self._selection.model is None)

    def run_of_panel(self, command: Command) -> None:
        """Run a command that a plugin's panel has made on the selected model, as one step."""
        self._submit(command, begins=False)

    def _submit(self, wanted: Command | str, *, begins: bool) -> None:
        """Queue a command; what was to be changed and is gone meanwhile is not begun anew."""
        model = self._selection.model
        modeler = self.modeler if model is None else model.modeler
        if not modeler or (model is None and not begins):
            return
        bench, context = self._workbench, self._context.now()

        def work(job: Job, given: tuple[Model | None, Document]) -> _Outcome | None:
            base, document = given
            if base is None and not begins:
                return None
            begun = base or bench.create(modeler, context)
            if begun.modeler != modeler:
                return None
            command = bench.commands.find(modeler, wanted) if isinstance(wanted, str) else wanted
            made = bench.commands.run(begun, command, context)
            if base is None and not made.sources:
                made = bench.sources.beside(made, document, job)
            only_chosen = base is not None and bench.parts.only_choice_differs(base, made)
            differs = base is None or bench.differs(begun, made, only_chosen=only_chosen)
            return _Outcome(base, made, command.title, only_chosen, differs)

        def done(answer: _Outcome | None) -> None:
            if answer is None:
                return
            if not answer.differs:
                said = tr("Object", "“{title}” is done already.", title=answer.title)
                self._notices.say_nothing_changed(said)
            elif answer.base is not None and all(
                answer.base is not known for known in self._drawing.document
            ):
                self._submit(wanted, begins=begins)  # the document changed meanwhile
            else:
                try:
                    self._drawing.document.refuse_circle(answer.made)
                except UserError as problem:
                    self._notices.complain(problem)
                    return
                self._drawing.apply_model(
                    answer.title,
                    answer.made,
                    is_new=answer.base is None,
                    only_chosen=answer.only_chosen,
                )
                if answer.base is None:
                    self.begun.emit()

        self._edits.submit(
            Request(
                work,
                done,
                self._notices.complain,
                inputs=lambda: (self._selection.model, self._drawing.document),
            )
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
