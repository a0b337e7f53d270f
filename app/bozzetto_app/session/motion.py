"""Motion: a tool moves the model on in time, while it is held or plays.

A worker takes one step after the other, each on the model as the last one left it and with the pen
where it is by then: the motion never runs behind the pen, and a slow picture does not slow it down.
The window takes the newest state whenever it gets round to it. All steps from the touch to the stop
are one step of the history, and what is shown of them is the solver's: a motion looks to it like a
slider that somebody drags.
"""

from __future__ import annotations

import itertools
from functools import partial
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Final, NamedTuple

from PySide6.QtCore import QObject, Signal

from bozzetto.errors import UserError
from bozzetto_app.session.selection import why_locked
from bozzetto_app.workers.channel import Channel, Request
from bozzetto_app.workers.main_thread import call_on_main_thread

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.gesture import Drag
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.solver import Solver
    from bozzetto_app.session.toolbox import Toolbox

__all__ = ["Motion"]

INTERVAL: Final = 1.0 / 60.0
"""Least time between the beginnings of two steps, seconds."""

LONGEST: Final = 0.05
"""Most time that one step stands for, seconds: after a pause nothing jumps."""

BEHIND: Final = 0.9
"""Seconds moved per second passed below which a motion counts as slow."""

MEASURED: Final = 0.5
"""Time over which that is measured, seconds."""

STEP_LIMIT: Final = 5.0
"""Seconds a step may take before it counts as hung."""


class _Hand(NamedTuple):
    """Hand as the worker knows it: replaced as a whole, never changed."""

    held: Drag | None
    lifted: bool
    context: Context


def _beginning(drag: Drag | None) -> tuple[float, float] | None:
    """Return where a drag began, px: what it took hold of, it took hold of there."""
    return None if drag is None else (float(drag.path.x[0]), float(drag.path.y[0]))


class _Course:
    """One motion, between the window and its worker.

    Attributes
    ----------
    hand : _Hand
        As it is now; written by the window.
    start : tuple of int and Model
        The model to go on from, counted: another one where somebody else changed it meanwhile;
        written by the window.
    newest : tuple of int and Model
        The model as the last step left it, and from which start; written by the worker.
    taken : Model
        As the document has it.
    title : str
        Of the step of the history: that of the tool, also when other tools are in the rail by now.
    key : str
        Of the step of the history.
    plays : bool
        Whether it goes on without a hand.
    pace : float
        Seconds moved per second passed, lately; written by the worker.
    """

    def __init__(
        self, model: Model, tool: str, title: str, key: str, hand: _Hand, *, plays: bool
    ) -> None:
        self.model_id, self.tool, self.title, self.key = model.id, tool, title, key
        self.plays = plays
        self.hand = hand
        self.start = self.newest = (0, model)
        self.taken = model
        self.is_told = False
        self.changed = False
        self.pace = 1.0


class Motion(QObject):
    """Moves the selected model by the active tool.

    Signals
    -------
    changed
        `is_playing` differs, or may be started or not.
    pace_changed : float or None
        How many seconds are moved in a second where steps take longer than they stand for; None
        where things move as fast as time, or stand.
    """

    changed = Signal()
    pace_changed = Signal(object)

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        toolbox: Toolbox,
        solver: Solver,
        context: GestureContext,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.channel = Channel("motion", time_limit=STEP_LIMIT, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._toolbox, self._solver = toolbox, solver
        self._context, self._notices = context, notices
        self._numbers = itertools.count(1)
        self._course: _Course | None = None
        self._pace: float | None = None
        drawing.closing.connect(self.stop)
        drawing.jumped.connect(self.stop)
        toolbox.tool_changed.connect(self._tool_changed)
        toolbox.modeler_changed.connect(self._tool_changed)
        selection.changed.connect(self._tool_changed)

    @property
    def is_moving(self) -> bool:
        """Whether something is held or plays."""
        return self._course is not None

    @property
    def is_held(self) -> bool:
        """Whether a drag moves something."""
        return self._course is not None and self._course.hand.held is not None

    @property
    def is_playing(self) -> bool:
        """Whether time goes on without a hand."""
        return self._course is not None and self._course.plays

    @property
    def can_play(self) -> bool:
        """Whether the tool in the hand can move the selected model without being held."""
        return self.player != "" and self.player == self._toolbox.tool

    @property
    def player(self) -> str:
        """The tool that moves the selected model without being held; "" if there is none.

        It is the one in the hand, or else the first of the active modeler.
        """
        if self._target is None:
            return ""
        able = [tool.id for tool in self._toolbox.tools if tool.plays and tool.moves]
        return self._toolbox.tool if self._toolbox.tool in able else next(iter(able), "")

    def takes(self, tool_id: str) -> bool:
        """Whether drags with a tool of the active modeler are motions."""
        known = any(tool.id == tool_id and tool.moves for tool in self._toolbox.tools)
        return known and self._target is not None

    # -- what the hand does --

    def hold(self, drag: Drag, tool_id: str, *, lifted: bool = False) -> None:
        """Begin to move what the drag took hold of, or follow the drag.

        Parameters
        ----------
        drag : Drag
            The drag so far.
        tool_id : str
            The tool that moves.
        lifted : bool
            Whether it ends here: one more step is taken with it, then it is let go.
        """
        hand = _Hand(drag, lifted, self._context.now())
        course = self._course
        if course is not None and course.tool == tool_id:
            course.hand = hand
        else:
            self._begin(tool_id, hand, plays=False)

    def cancel(self) -> None:
        """Drop the motion: everything goes back to where it was at the touch."""
        course = self._course
        self.stop()
        if course is not None and course.changed:
            self._drawing.undo()

    def play(self) -> None:
        """Let time go on, or stop it if it does; take the tool for it if another is in the hand."""
        if not self.is_playing and self.player and not self.can_play:
            self._toolbox.take_tool(self.player)
        course = self._course
        if course is not None and course.plays:
            self.stop()
        elif course is not None and self.can_play:
            course.plays = True
        elif self.can_play:
            self._begin(self._toolbox.tool, _Hand(None, False, self._context.now()), plays=True)
        self.changed.emit()

    def stop(self, *_: object) -> None:
        """End the motion here: what it came to stays, as one step of the history."""
        course = self._course
        if course is None:
            return
        self.channel.cancel()
        self._accept(course)
        self._course = None
        self._tell_pace(None)
        if course.changed:
            self._drawing.history.end_merge()
            self._solver.let_go()
        self.changed.emit()

    # -- steps --

    @property
    def _target(self) -> Model | None:
        return self._selection.target(self._toolbox.modeler)

    def _begin(self, tool_id: str, hand: _Hand, *, plays: bool) -> None:
        self.stop()
        model = self._target
        if model is None:
            return
        if model.locked:
            said = why_locked()
            self._notices.complain(UserError(said))
            return
        key = f"motion {next(self._numbers)}"
        title = next(tool.title for tool in self._toolbox.tools if tool.id == tool_id)
        course = self._course = _Course(model, tool_id, title, key, hand, plays=plays)

        def failed(problem: BaseException) -> None:
            self.stop()
            self._notices.complain(problem)

        def ended(_: None) -> None:
            if self._course is course:
                self.stop()

        work = partial(self._go_on, course)
        self.channel.submit(Request(work, ended, failed, "preview"))

    def _go_on(self, course: _Course, job: Job) -> None:
        """Take steps until nothing is held and nothing plays; in the worker.

        What plays goes on where a drag holds nothing, which is told: corners that move are missed.
        """
        bench = self._workbench
        count, model = course.start
        tool = bench.tool(model.modeler, course.tool)
        last = measured = perf_counter()
        moved = 0.0
        missed: tuple[float, float] | None = None
        while True:
            begun, hand = perf_counter(), course.hand
            if course.start[0] != count:
                count, model = course.start
            seconds, last = min(begun - last, LONGEST), begun
            moved += seconds
            if begun - measured > MEASURED:
                course.pace = moved / (begun - measured)
                moved, measured = 0.0, begun
            job.checkpoint(0.0, tool.title)
            held, began = hand.held, _beginning(hand.held)
            if began == missed:
                held = None
            try:
                model = bench.step(model, tool, held, seconds, hand.context)
            except UserError as problem:
                if held is None or not course.plays:
                    raise
                missed = began
                call_on_main_thread(self, self._notices.complain, problem)
                continue
            course.newest = (count, model)
            if not course.is_told:
                course.is_told = True
                call_on_main_thread(self, self._take, course)
            if hand.lifted and course.hand is hand:
                course.hand = _Hand(None, False, hand.context)
            if course.hand.held is None and not course.plays:
                return
            sleep(max(0.0, INTERVAL - (perf_counter() - begun)))

    def _take(self, course: _Course) -> None:
        """Take the newest step over; what is gone stops moving."""
        course.is_told = False
        if course is not self._course:
            return
        self._tell_pace(course.pace if course.pace < BEHIND else None)
        if not self._accept(course):
            self.stop()
        elif course.hand.held is None:
            course.hand = _Hand(None, False, self._context.now())

    def _tell_pace(self, pace: float | None) -> None:
        if pace != self._pace:
            self._pace = pace
            self.pace_changed.emit(pace)

    def _accept(self, course: _Course) -> bool:
        """Put the newest step into the document; say whether the model is still there.

        Where somebody else has changed the model meanwhile, the motion goes on from that.
        """
        present = self._present(course)
        if present is None:
            return False
        count, newest = course.newest
        if present is not course.taken:
            course.start, course.taken = (course.start[0] + 1, present), present
        elif count == course.start[0] and newest is not present:
            try:
                document = self._drawing.document.with_model(newest)
            except UserError as problem:  # it would follow itself
                self._notices.complain(problem)
                return False
            self._drawing.commit(course.title, document, course.key)
            course.taken, course.changed = self._present(course) or newest, True
        return True

    def _present(self, course: _Course) -> Model | None:
        """Return the model that moves, as the document has it; None if it is gone."""
        models = self._drawing.document
        return next((model for model in models if model.id == course.model_id), None)

    def _tool_changed(self) -> None:
        course, target = self._course, self._target
        if course is not None:
            gone = target is None or target.id != course.model_id
            if gone or (course.plays and self._toolbox.tool != course.tool):
                self.stop()
        self.changed.emit()
