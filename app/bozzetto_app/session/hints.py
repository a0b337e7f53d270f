"""The next step: the one answer that every place shows.

The status line, the words over the sheet, the plugin's panel, the tool rail and the ring on the
sheet all read `Hints.step`, so they cannot disagree. Ink that waits comes first, then what the
modeler says of the selected model, or of the one that the next gesture would begin, then the hint
of the tool; on an empty sheet with the first tool in the hand, that of the modeler.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.errors import UserError
from bozzetto.plugin.next_step import NextStep
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import LATE_AFTER, Channel, Request

if TYPE_CHECKING:
    from bozzetto.document import Document
    from bozzetto.document.model import Model
    from bozzetto.plugin.context import Context
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.toolbox import Toolbox

__all__ = ["Hints"]


@dataclass(frozen=True, eq=False)
class _Question:
    """What a modeler is asked.

    Attributes
    ----------
    modeler, tool : str
        Those in the hand.
    model : Model, optional
        The model that the next gesture changes; without one it begins a new one.
    document : Document
        Around it.
    """

    modeler: str
    tool: str
    model: Model | None
    document: Document

    def is_same(self, other: _Question | None) -> bool:
        """Return whether another one is about the very same objects; states are not compared."""
        if other is None or (self.modeler, self.tool) != (other.modeler, other.tool):
            return False
        one, two = self.model, other.model
        if one is None or two is None:
            return one is two and self.document is other.document
        return one.state is two.state and one.placement == two.placement and one.id == two.id

    def is_of_same_object(self, other: _Question | None) -> bool:
        """Return whether an answer to the other one may stand until this one is answered."""
        if other is None or self.model is None or other.model is None:
            return False
        return self.model.id == other.model.id


class Hints(QObject):
    """Keeps what is next.

    Attributes
    ----------
    step : NextStep
        Its place is in the world.
    channel : Channel
        The work of asking modelers.

    Signals
    -------
    changed
        `step` is another one.
    """

    changed = Signal()

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        toolbox: Toolbox,
        context: GestureContext,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.step = NextStep("")
        self.channel = Channel("hint", time_limit=LATE_AFTER, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._toolbox, self._context, self._notices = toolbox, context, notices
        self._asked: _Question | None = None
        self._answer: NextStep | None = None
        self._failed: set[str] = set()
        self._wish = ""
        for signal in (
            drawing.changed,
            drawing.waiting_changed,
            selection.changed,
            toolbox.modeler_changed,
            toolbox.tool_changed,
        ):
            signal.connect(self.look)
        self.look()

    def look(self) -> None:
        """Ask again if the model, its state or the tool differs."""
        question = self._question()
        if question is None or not question.is_same(self._asked):
            self._ask(question)
        self._show()

    def wish(self, words: str) -> None:
        """Say what to touch for something other than a tool; "" when that is done."""
        self._wish = words
        self._show()

    def _ask(self, question: _Question | None) -> None:
        """Ask the modeler; its last answer stands meanwhile if it is about the same object."""
        before, self._asked = self._asked, question
        self.channel.cancel()
        if question is None or not question.is_of_same_object(before):
            self._answer = None
        if question is None:
            return
        bench, model = self._workbench, question.model

        def of_model(model: Model) -> NextStep:
            return bench.next_step(model, bench.tool(question.modeler, question.tool))

        def of_begun(context: Context) -> NextStep:
            begun = bench.create(question.modeler, context)
            return replace(of_model(begun), place=None)  # it is not on the sheet

        if model is None:
            told = partial(of_begun, self._context.now())
        else:
            told = partial(of_model, model)

        def done(step: NextStep) -> None:
            if question is self._asked:
                self._answer = self._with_more(step, question)
                self._show()

        def failed(problem: BaseException) -> None:
            """Report one fault and ask no more: it would return with every stroke."""
            if isinstance(problem, UserError):
                done(NextStep(problem.message))
                return
            self._failed.add(question.modeler)
            self._answer = None
            self._notices.complain(problem)
            self.look()

        self.channel.submit(Request(lambda job: told(), done, failed))

    def _question(self) -> _Question | None:
        """Return what to ask; of an object that the first tool would begin its hint says enough."""
        modeler, tool = self._toolbox.modeler, self._toolbox.active
        if tool is None or modeler in self._failed:
            return None
        model = self._selection.target(modeler)
        if model is None and self._toolbox.has_first_tool:
            return None
        return _Question(modeler, tool.id, model, self._drawing.document)

    def _show(self) -> None:
        step = self._now()
        if step != self.step:
            self.step = step
            self.changed.emit()

    def _now(self) -> NextStep:
        toolbox = self._toolbox
        if self._wish:
            return NextStep(self._wish)
        if not toolbox.modeler:
            return NextStep(tr("Session", "Choose a modeler first."))
        waiting = self._for_waiting_ink()
        if waiting is not None:
            return waiting
        tool = toolbox.active
        if self._answer is not None:
            return self._answer
        if tool is None or (toolbox.has_first_tool and not len(self._drawing.document)):
            return NextStep(self._workbench.registry.info(toolbox.modeler).hint)
        return NextStep(tool.hint)

    def _with_more(self, step: NextStep, question: _Question) -> NextStep:
        """Return a step; of an object, a tool with nothing special to say leaves room for more."""
        tool = question.tool
        if question.model is None or step.sentence != self._toolbox.hint_of(tool):
            return step
        return replace(step, sentence=self._toolbox.hint_and_more(tool))

    def _for_waiting_ink(self) -> NextStep | None:
        """Return what is to be done with ink that waits for the tool in the hand."""
        hand = self._toolbox.modeler, self._toolbox.tool
        for one in reversed(self._drawing.document.waiting):
            if one.is_for(*hand) and one.status in ("unfinished", "refused"):
                return NextStep(one.reason)
            if one.is_for(*hand) and one.status == "failed":
                return NextStep(
                    tr("Session", "The ink waits. Enter tries it again, Backspace takes it back.")
                )
        return None
