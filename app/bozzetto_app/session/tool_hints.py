"""Expecting: what the tool in the hand waits for, as the selected model is now.

Only tools that say so themselves are asked; for the others their hint stands.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from bozzetto.document.model import Model
from bozzetto.plugin.job import Job
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["Expecting"]

HINT_LIMIT = 10.0
"""Seconds a tool may take to say what comes next before it counts as hung."""

Question = tuple[Model, str] | None
"""The model that the next gesture changes, and the tool in the hand; None for nothing to ask."""


class Expecting(QObject):
    """Keeps the hint of the session at what is to be done next."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._asked: Question = None
        self._failed: set[str] = set()
        self._channel = Channel("hint", time_limit=HINT_LIMIT, parent=self)
        for signal in (
            session.document_changed,
            session.selection_changed,
            session.tool_changed,
            session.rested,
        ):
            signal.connect(self.look)

    @property
    def busy(self) -> bool:
        """Whether a tool is still being asked."""
        return self._channel.busy

    def look(self) -> None:
        """See whether there is another model, another state of it, or another tool.

        Not while a value is dragged: the answer would be overtaken by the next tick.
        """
        if self._session.is_dragging:
            return
        question = self._question()
        if _same(question, self._asked):
            return
        before, self._asked = self._asked, question
        self._channel.cancel()
        session = self._session
        if question is None:
            if before is not None:
                session.say_hint(session.toolbox.hint_of(session.active_tool))
            return
        model, tool = question
        bench = session.workbench

        def work(job: Job) -> str:
            return bench.next_hint(model, bench.tool(model.modeler, tool))

        def done(hint: str) -> None:
            if _same(question, self._asked):
                # A tool with nothing special to say leaves room for what else can be done.
                usual = hint == session.toolbox.hint_of(tool)
                session.say_hint(session.toolbox.hint_and_more(tool) if usual else hint)

        def failed(problem: BaseException) -> None:
            """One fault is enough to know: it would come back with every stroke."""
            self._failed.add(model.modeler)
            session.complain(problem)

        self._channel.submit(Request(work, done, failed))

    def _question(self) -> Question:
        session = self._session
        model = session.inking.target(session.active_modeler)
        told = session.toolbox.tells_next(session.active_tool)
        if model is None or not told or model.modeler in self._failed:
            return None
        return model, session.active_tool


def _same(one: Question, other: Question) -> bool:
    """Whether two questions are about the very same things; states are not compared."""
    if one is None or other is None:
        return one is other
    return one[0].state is other[0].state and one[1] == other[1]
