"""Inking: what the hand does becomes a new state of a model, or waits, or is refused.

A stroke is waiting ink of the document from the moment the pen is lifted, and stays so until
a tool takes it. One gesture at a time is worked on, in the order in which they were made, each
on the document as it is by then; if the document moves on meanwhile, the gesture is worked on
again. Ink that was refused, or whose plugin failed, waits with a mark.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Model
from bozzetto.document.waiting_ink import (
    WaitingStatus,
    WaitingStroke,
    marked,
    touched,
    without,
)
from bozzetto.errors import Unfinished, UserError
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Scene
from bozzetto_app.i18n import tr
from bozzetto_app.session.ink_choice import ink_to_try
from bozzetto_app.session.notices import notice_of
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["Inking"]

APPLY_LIMIT = 15.0
"""Seconds a tool may take over one gesture before it counts as hung."""

PREVIEW_LIMIT = 10.0
"""Seconds a live preview may take before it counts as hung."""


ERASER_REACH = 18.0
"""Half the width of the eraser, pixels: waiting ink nearer to its path is erased."""


@dataclass(frozen=True)
class _Answer:
    """What became of a gesture: `model` in the place of `base`, or a new one.

    `changed` is False where the gesture did nothing at all to `base`.
    """

    gesture: Gesture
    base: Model | None
    model: Model
    label: str
    tool: str
    only_chosen: bool
    changed: bool


class _NotTaken(Exception):
    """Ink that a tool did not take, and what it said.

    Attributes
    ----------
    problem : UserError, Unfinished or PluginFault
    tool : str
    strokes : tuple of Stroke
        Those that it concerns.
    """

    def __init__(self, problem: BaseException, tool: str, strokes: tuple[Stroke, ...]) -> None:
        super().__init__(str(problem))
        self.problem, self.tool, self.strokes = problem, tool, strokes


class Inking(QObject):
    """What is shown while the pen is down, and the work on gestures.

    Attributes
    ----------
    live : Scene
        What is shown only until something better is there.

    Signals
    -------
    progressed : float, str; busy_changed : bool
        A modeler's work on a gesture advances; it has one in hand, or none any more.
    """

    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.live = Scene()
        self._pen_is_down = False
        self._awaited = ""
        self._unpreviewable: set[tuple[str, str]] = set()
        self._edits = Channel(
            "apply", keep_all=True, time_limit=APPLY_LIMIT, is_patient=True, parent=self
        )
        self._edits.slow.connect(session.tell_slow)
        self._previews = Channel("preview", time_limit=PREVIEW_LIMIT, parent=self)
        self._edits.progressed.connect(self.progressed)
        self._edits.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether a gesture is being worked on."""
        return self.at_the_modeler or self._previews.busy

    @property
    def at_the_modeler(self) -> bool:
        """Whether a modeler has a gesture in hand, or one waits for its turn."""
        return self._edits.busy

    # -- strokes --

    def moved(self, stroke: Stroke) -> None:
        """Show what the stroke so far would make."""
        self._awaited = ""
        self._pen_is_down = True
        if stroke.tool == "eraser":
            self._preview(Ink((stroke,)))
            return
        modeler, tool = self._hand
        before = [
            one.stroke
            for one in self._session.document.waiting
            if one.is_for(modeler, tool) and not one.is_marked
        ]
        self._preview(Ink((*before, stroke)))

    def lifted(self, stroke: Stroke) -> None:
        """Keep a complete stroke, and let the tool try the ink."""
        self._pen_is_down = False
        session = self._session
        if stroke.tool == "eraser":
            self._erase(stroke)
            return
        modeler, tool = self._hand
        one = WaitingStroke(stroke, modeler, tool)
        session.take_ink(tr("Session", "Stroke"), (*session.document.waiting, one), drawn=True)
        if self._may_edit():
            self._apply_ink(stroke, committed=False)

    def cancelled(self) -> None:
        """Forget the stroke that was being drawn."""
        self._pen_is_down = False
        self._show_nothing()

    def commit(self) -> None:
        """Say that the strokes that wait are all."""
        if not self._may_edit():
            return
        session = self._session
        active = [tool for tool in session.tools if tool.id == session.active_tool]
        if active and active[0].gesture != "ink":
            said = tr("Session", "{tool} does not draw. Take a tool that does, then press Enter.")
            session.complain(UserError(said.format(tool=active[0].title)))
            return
        self._apply_ink(session.document.waiting[-1].stroke, committed=True)

    def drop_last(self) -> None:
        """Take back the newest stroke that waits."""
        self._drop(tr("Session", "Take back a stroke"), self._session.pending[-1:])

    def clear(self) -> None:
        """Take back all strokes that wait."""
        self._drop(tr("Session", "Take back the waiting ink"), self._session.pending)

    def hand_changed(self) -> None:
        """Another tool is in the hand: what the last one showed for a moment goes."""
        if not self._pen_is_down and not self._edits.busy:
            self._show_nothing()

    def restart(self) -> None:
        """Drop all work: there is another document, with ink of its own."""
        self._edits.cancel()
        self.cancelled()

    def stop(self) -> bool:
        """Stop what the modeler has in hand; its ink waits, marked. Whether there was ink."""
        if not self._edits.busy:
            return False
        self._edits.cancel()
        self._show_nothing()
        new = [one for one in self._session.document.waiting if one.status == "new"]
        said = tr("Session", "This stroke was stopped. Press Enter to try it again.")
        for one in new:
            self._mark((one.stroke,), "failed", said, modeler=one.modeler, tool=one.tool)
        return bool(self._session.document.waiting)

    def go_on(self) -> None:
        """The person jumped in the history: only ink that has no answer yet is still meant."""
        self._edits.cancel()
        self._awaited = ""
        for one in self._session.document.waiting:
            if one.status == "new" and one.is_for(*self._hand):
                self._apply_ink(one.stroke, committed=False)

    def _drop(self, label: str, strokes: Sequence[Stroke]) -> None:
        session = self._session
        session.take_ink(label, without(session.document.waiting, strokes))
        self._show_nothing()

    def _erase(self, eraser: Stroke) -> None:
        """Rub out waiting ink; where there is none under the eraser, it is the tool's."""
        found = touched(self._session.document.waiting, eraser, ERASER_REACH)
        if found:
            self._drop(tr("Session", "Erase waiting ink"), found)
        elif self._may_edit():
            self._submit_at_once(Ink((eraser,)), self._hand[1])

    # -- other gestures --

    def tap_moved(self, tap: Tap) -> None:
        """Show what a tap that is still being aimed would make."""
        self._awaited = ""
        self._pen_is_down = True
        self._preview(tap)

    def tapped(self, tap: Tap) -> None:
        """A short touch with a tool that takes taps, or the end of one that was aimed."""
        aimed, self._pen_is_down = self._pen_is_down, False
        if self._may_edit():
            self._submit_at_once(tap, self._session.toolbox.tool_for("tap"), clear=aimed)

    def handle_moved(self, drag: Drag) -> None:
        """Show what a handle dragged so far would make."""
        self._awaited = ""
        self._pen_is_down = True
        self._preview(drag)

    def handle_released(self, drag: Drag) -> None:
        """A handle was let go."""
        self._pen_is_down = False
        if self._may_edit():
            self._submit_at_once(drag, self._session.toolbox.tool_for("drag"))

    def _submit_at_once(self, gesture: Gesture, tool: str, *, clear: bool = True) -> None:
        """Queue a gesture that nothing is kept of where it is refused."""

        def failed(problem: BaseException) -> None:
            if clear:
                self._show_nothing()
            self._session.complain(problem)

        self._submit(lambda: (gesture,), tool, failed)

    # -- what is shown for a moment --

    def show_live(self, scene: Scene) -> None:
        """Show something until something better is there."""
        if scene.layers or self.live.layers:
            self.live = scene
            self._session.live_changed.emit()

    def shape_shown(self, model_id: str) -> None:
        """A solved shape is on the sheet: the preview of its last gesture has done its work."""
        if self._pen_is_down or self._edits.busy or self._awaited not in ("", model_id):
            return
        self._show_nothing()

    def no_shape_comes(self) -> None:
        """A model has no solution: nothing will take the place of a preview."""
        if not self._pen_is_down:
            self._show_nothing()

    def _show_nothing(self) -> None:
        self._awaited = ""
        self._previews.cancel()
        self.show_live(Scene())

    def _preview(self, gesture: Gesture) -> None:
        session = self._session
        modeler = session.active_modeler
        kind: Literal["ink", "tap", "drag"] = "ink"
        if not isinstance(gesture, Ink):
            kind = "drag" if isinstance(gesture, Drag) else "tap"
        tool = session.toolbox.tool_for(kind)
        if not modeler or not tool or (modeler, tool) in self._unpreviewable:
            return
        context, target = session.context(), self.target(modeler)

        def work(job: Job) -> Scene:
            bench = session.workbench
            model = target or bench.create(modeler, context)
            return bench.preview(model, bench.tool(modeler, tool), gesture, context)

        def failed(problem: BaseException) -> None:
            """One fault is enough to know: the stroke itself need not suffer from it."""
            if not isinstance(problem, UserError | Unfinished):
                self._unpreviewable.add((modeler, tool))
                self._show_nothing()
                session.complain(problem)

        self._previews.submit(Request(work, self.show_live, failed, "preview"))

    # -- from gestures to states --

    @property
    def _hand(self) -> tuple[str, str]:
        """The modeler and the tool that ink is for now."""
        return self._session.active_modeler, self._session.toolbox.tool_for("ink")

    def _apply_ink(self, until: Stroke, *, committed: bool) -> None:
        """Let the tool in the hand try the strokes that wait, up to one of them."""
        modeler, tool = self._hand

        def gestures() -> tuple[Ink, ...]:
            """The ink as it is when its turn comes: earlier strokes may have found a home."""
            waiting = self._session.document.waiting
            tries = ink_to_try(waiting, until, modeler, tool, committed=committed)
            return tuple(Ink(strokes, committed) for strokes in tries)

        def failed(problem: BaseException) -> None:
            self._previews.cancel()
            self.show_live(Scene())
            if isinstance(problem, _NotTaken):
                self._not_taken(problem, modeler)
                return
            notice = notice_of(problem, self._session.registry.guard)
            for ink in gestures()[:1]:
                self._mark(ink.strokes, "failed", notice.text, modeler=modeler, tool=tool)
                self._say_what_can_be_done()
            self._session.noticed.emit(notice)

        self._submit(gestures, tool, failed)

    def _not_taken(self, answer: _NotTaken, modeler: str) -> None:
        """Let ink wait that a tool did not take, with what is to be done."""
        problem, strokes, session = answer.problem, answer.strokes, self._session
        waits = set(map(id, session.pending))
        is_meant = any(id(stroke) in waits for stroke in strokes)
        if isinstance(problem, Unfinished):
            self._mark(strokes, "unfinished", problem.hint, modeler=modeler, tool=answer.tool)
            if is_meant:
                session.say_hint(problem.hint)
            return
        is_refused = isinstance(problem, UserError)
        if is_refused and not is_meant:
            return  # taken back meanwhile: nobody wants to know any more
        notice = notice_of(problem, session.registry.guard)
        self._mark(
            strokes,
            "refused" if is_refused else "failed",
            notice.text,
            modeler=modeler,
            tool=answer.tool,
            places=notice.places,
        )
        if is_meant and not is_refused:
            self._say_what_can_be_done()
        session.noticed.emit(notice)

    def _say_what_can_be_done(self) -> None:
        self._session.say_hint(
            tr("Session", "The ink waits. Enter tries it again, Backspace takes it back.")
        )

    def _mark(
        self, strokes: tuple[Stroke, ...], status: WaitingStatus, reason: str, **more: Any
    ) -> None:
        self._session.revise_ink(
            lambda waiting: marked(waiting, strokes, status, reason=reason, **more)
        )

    def queue(self, request: Request) -> None:
        """Have other work on the document done in its turn among the gestures."""
        self._edits.submit(request)

    def target(self, modeler_id: str) -> Model | None:
        """The model that the next gesture of a modeler changes, or None for a new one."""
        model = self._session.selected_model
        if model is None or model.modeler != modeler_id or model.locked or not model.visible:
            return None
        return model

    def _may_edit(self) -> bool:
        if not self._session.active_modeler:
            self._session.say_hint(tr("Session", "Choose a modeler first."))
            return False
        return True

    def _submit(
        self,
        gestures_now: Callable[[], Sequence[Gesture]],
        tool_id: str,
        failed: Callable[[BaseException], None],
    ) -> None:
        """Queue a gesture.

        Parameters
        ----------
        gestures_now : callable
            Gives the gesture when its turn comes, and others to try where it is not taken;
            none where there is nothing left to do.
        tool_id : str
            "" is the modeler's first tool: the person was quicker than its import.
        failed : callable
        """
        session = self._session
        modeler_id, context = session.active_modeler, session.context()

        def work(job: Job) -> _Answer | None:
            gestures = gestures_now()
            if not gestures:
                return None
            return self._first_taken(gestures, modeler_id, tool_id, context, job)

        def answered(answer: _Answer | None) -> None:
            if answer is None:
                return
            used = answer.gesture.strokes if isinstance(answer.gesture, Ink) else ()
            waits = set(map(id, session.pending))
            is_waiting = all(stroke.tool == "eraser" or id(stroke) in waits for stroke in used)
            base = answer.base
            is_known = base is None or any(base is known for known in session.document)
            if not (is_waiting and is_known):
                self._submit(gestures_now, tool_id, failed)
                return
            if not answer.changed:
                hint = session.toolbox.hint_of(answer.tool)
                self._mark(used, "refused", hint, modeler=modeler_id, tool=answer.tool)
                self._show_nothing()
                session.say_nothing_changed(hint)
                return
            self._previews.cancel()
            self._awaited = answer.model.id
            session.take_drawn(
                answer.label,
                answer.model,
                is_new=base is None,
                only_chosen=answer.only_chosen,
                used=tuple(stroke for stroke in used if id(stroke) in waits),
            )
            # The tool in the hand speaks, whichever tool took the drag of a handle.
            if not session.toolbox.tells_next(session.active_tool):
                session.say_hint(session.toolbox.hint_and_more(session.active_tool))

        self._edits.submit(Request(work, answered, failed))

    def _first_taken(
        self,
        gestures: Sequence[Gesture],
        modeler_id: str,
        tool_id: str,
        context: Context,
        job: Job,
    ) -> _Answer:
        """In the worker: what becomes of the first gesture that the tool takes."""
        said: list[_NotTaken] = []
        for gesture in gestures:
            try:
                return self._worked_out(gesture, modeler_id, tool_id, context, job)
            except (UserError, Unfinished, PluginFault) as problem:
                if not isinstance(gesture, Ink) or gesture.strokes[-1].tool == "eraser":
                    raise
                said.append(_NotTaken(problem, tool_id, gesture.strokes))
                if isinstance(problem, PluginFault):
                    break
        faults = [answer for answer in said if isinstance(answer.problem, PluginFault)]
        unfinished = [answer for answer in said if isinstance(answer.problem, Unfinished)]
        raise (faults or unfinished or said)[-1]

    def _worked_out(
        self, gesture: Gesture, modeler_id: str, tool_id: str, context: Context, job: Job
    ) -> _Answer:
        """In the worker: the state after a gesture."""
        bench = self._session.workbench
        base = self.target(modeler_id)
        if base is None and not isinstance(gesture, Ink):
            self._refuse_closed(modeler_id)
        model = base or bench.create(modeler_id, context)
        if tool_id:
            tool = bench.tool(modeler_id, tool_id)
        else:
            tools = bench.tools(modeler_id)
            if not tools:
                raise UserError(
                    tr("Session", "{title} takes no ink. Choose another modeler.",
                       title=self._session.registry.info(modeler_id).title)
                )  # fmt: skip
            tool = tools[0]
        job.checkpoint(0.0, tool.title)
        changed = bench.apply(model, tool, gesture, context)
        only_chosen = base is not None and bench.parts.only_choice_differs(base, changed)
        differs = base is None or bench.differs(base, changed, only_chosen=only_chosen)
        return _Answer(gesture, base, changed, tool.title, tool.id, only_chosen, differs)

    def _refuse_closed(self, modeler_id: str) -> None:
        """Refuse touches and drags while what they are meant for is locked or hidden.

        Raises
        ------
        UserError
            Ink may still start a new object; a touch can mean the selected one only.
        """
        model = self._session.selected_model
        if model is None or model.modeler != modeler_id:
            return
        if model.locked:
            raise UserError(tr("Session", "This object is locked. Unlock it to change it."))
        if not model.visible:
            raise UserError(tr("Session", "This object is hidden. Show it to change it."))
