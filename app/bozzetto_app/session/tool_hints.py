"""The gesture that the active tool expects next, for the selected model as it is now.

One answer, `NextStep`, for every place that shows it.
"""

from __future__ import annotations

from PySide6.QtCore import QObject

from bozzetto.document.model import Model
from bozzetto.plugin.job import Job
from bozzetto.plugin.next_step import NextStep
from bozzetto.workbench.workbench import Workbench
from bozzetto_app.session.document_model import DocumentModel
from bozzetto_app.session.notices import Notices
from bozzetto_app.session.selection import Selection
from bozzetto_app.session.toolbox import Toolbox
from bozzetto_app.workers.channel import Channel, Request

__all__ = ["ToolHints"]

HINT_LIMIT = 10.0
"""Seconds a tool may take to name the next gesture before it counts as hung."""

Question = tuple[Model, str] | None
"""The model that the next gesture changes, and the active tool; None for nothing to ask."""


class ToolHints(QObject):
    """Keeps the hint at the gesture that is expected next.

    Attributes
    ----------
    channel : Channel
        The work of asking tools.
    """

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
        self.channel = Channel("hint", time_limit=HINT_LIMIT, parent=self)
        self._workbench, self._selection = workbench, selection
        self._toolbox, self._notices = toolbox, notices
        self._asked: Question = None
        self._failed: set[str] = set()
        for signal in (drawing.changed, selection.changed, toolbox.tool_changed):
            signal.connect(self.look)

    def look(self) -> None:
        """Ask again if the model, its state or the tool differs."""
        question = self._question()
        if _same(question, self._asked):
            return
        before, self._asked = self._asked, question
        self.channel.cancel()
        toolbox, bench = self._toolbox, self._workbench
        if question is None:
            if before is not None:
                self._notices.say_hint(toolbox.hint_of(toolbox.tool))
            return
        model, tool = question

        def work(job: Job) -> NextStep:
            return bench.next_step(model, bench.tool(model.modeler, tool))

        def done(step: NextStep) -> None:
            if _same(question, self._asked):
                # A tool with nothing special to say leaves room for what else can be done.
                usual = step.sentence == toolbox.hint_of(tool)
                self._notices.say_hint(toolbox.hint_and_more(tool) if usual else step.sentence)

        def failed(problem: BaseException) -> None:
            """Report one fault and ask no more: it would return with every stroke."""
            self._failed.add(model.modeler)
            self._notices.complain(problem)

        self.channel.submit(Request(work, done, failed))

    def _question(self) -> Question:
        model, tool = self._selection.target(self._toolbox.modeler), self._toolbox.active
        if model is None or tool is None or model.modeler in self._failed:
            return None
        return model, tool.id


def _same(one: Question, other: Question) -> bool:
    """Return whether two questions are about the very same objects; states are not compared."""
    if one is None or other is None:
        return one is other
    return one[0].state is other[0].state and one[1] == other[1]
