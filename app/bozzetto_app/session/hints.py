"""The next step: the one answer that every place shows.

The status line, the words over the sheet, the plugin's panel, the tool rail and the ring on the
sheet all read `Hints.step`, so they cannot disagree. Ink that waits comes first, then what the
modeler says of the selected model, then the hint of the tool; on an empty sheet that of the
modeler.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Model
from bozzetto.errors import UserError
from bozzetto.plugin.next_step import NextStep
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import LATE_AFTER, Channel, Request

if TYPE_CHECKING:
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.toolbox import Toolbox

__all__ = ["Hints"]

Question = tuple[Model, str] | None
"""The model that the next gesture changes, and the active tool; None for nothing to ask."""


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
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.step = NextStep("")
        self.channel = Channel("hint", time_limit=LATE_AFTER, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._toolbox, self._notices = toolbox, notices
        self._asked: Question = None
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
        if not _same(question, self._asked):
            self._ask(question)
        self._show()

    def wish(self, words: str) -> None:
        """Say what to touch for something other than a tool; "" when that is done."""
        self._wish = words
        self._show()

    def _ask(self, question: Question) -> None:
        """Ask the modeler; its last answer stands meanwhile if it is about the same object."""
        before, self._asked = self._asked, question
        self.channel.cancel()
        if question is None or before is None or question[0].id != before[0].id:
            self._answer = None
        if question is None:
            return
        bench, (model, tool) = self._workbench, question

        def work(job: Job) -> NextStep:
            return bench.next_step(model, bench.tool(model.modeler, tool))

        def done(step: NextStep) -> None:
            if _same(question, self._asked):
                self._answer = self._with_more(step, tool)
                self._show()

        def failed(problem: BaseException) -> None:
            """Report one fault and ask no more: it would return with every stroke."""
            if isinstance(problem, UserError):
                done(NextStep(problem.message))
                return
            self._failed.add(model.modeler)
            self._answer = None
            self._notices.complain(problem)
            self.look()

        self.channel.submit(Request(work, done, failed))

    def _question(self) -> Question:
        model, tool = self._selection.target(self._toolbox.modeler), self._toolbox.active
        if model is None or tool is None or model.modeler in self._failed:
            return None
        return model, tool.id

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
        is_first = tool is None or tool.id == toolbox.tools[0].id
        if tool is None or (is_first and not len(self._drawing.document)):
            return NextStep(self._workbench.registry.info(toolbox.modeler).hint)
        return NextStep(tool.hint)

    def _with_more(self, step: NextStep, tool: str) -> NextStep:
        """Return a step; a tool with nothing special to say leaves room for what can be done."""
        if step.sentence != self._toolbox.hint_of(tool):
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


def _same(one: Question, other: Question) -> bool:
    """Return whether two questions are about the very same objects; states are not compared."""
    if one is None or other is None:
        return one is other
    same_model = one[0].state is other[0].state and one[0].placement == other[0].placement
    return same_model and one[0].id == other[0].id and one[1] == other[1]
