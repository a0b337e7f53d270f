"""Gestures of the person: previews while the pen is down, and their effect on the document.

A stroke is waiting ink of the document from the moment the pen is lifted, until a tool takes
it. One gesture at a time is worked on, in the order in which they were made, each on the
document as it is by then; if the document changes meanwhile, the gesture is tried again. Ink
that was refused, or whose plugin failed, keeps waiting with a mark.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

from PySide6.QtCore import QObject

from bozzetto.document.waiting_ink import (
    WaitingStatus,
    WaitingStroke,
    marked,
    strokes_of,
    touched,
    without,
)
from bozzetto.errors import Unfinished, UserError
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.scene.display_list import Scene
from bozzetto_app.i18n import tr
from bozzetto_app.session.gesture_application import (
    Attempt,
    NotTaken,
    Outcome,
    apply_first,
    ink_to_try,
)
from bozzetto_app.workers.channel import LATE_AFTER, Channel, Request

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.ink.stroke import Stroke
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.previews import ModelPreview
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.motion import Motion
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.scene_model import SceneModel
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.solver import Solver
    from bozzetto_app.session.toolbox import Toolbox

__all__ = ["Gestures"]

APPLY_LIMIT = 15.0
"""Seconds a tool may take over one gesture before it counts as hung."""


ERASER_REACH = 18.0
"""Half the width of the eraser, pixels: waiting ink nearer to its path is erased."""


class Gestures(QObject):
    """Takes what the person draws, taps and drags.

    Attributes
    ----------
    edits, previews : Channel
        The work on complete gestures, in their order, and on the newest preview. Other work
        on the document takes its turn in `edits`.
    context : GestureContext
        The surroundings of a gesture.
    motion : Motion
        What a tool moves, while it is held or plays.
    """

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        toolbox: Toolbox,
        solver: Solver,
        scene: SceneModel,
        context: GestureContext,
        motion: Motion,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.edits = Channel(
            "apply", keep_all=True, time_limit=APPLY_LIMIT, is_patient=True, parent=self
        )
        self.previews = Channel("preview", time_limit=LATE_AFTER, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._toolbox, self._scene = toolbox, scene
        self.context, self.motion, self._notices = context, motion, notices
        self._pen_is_down = False
        self._awaited = ""
        self._touch_counted = False
        self._live: _LivePreview | None = None
        self._unpreviewable: set[tuple[str, str]] = set()
        notices.watch(self.edits)
        toolbox.modeler_changed.connect(self._tool_changed)
        toolbox.tool_changed.connect(self._tool_changed)
        drawing.closing.connect(self.restart)
        drawing.jumped.connect(self._go_on)
        solver.changed.connect(self._model_shown)
        solver.failed.connect(self._no_shape_comes)

    # -- strokes --

    def stroke_moved(self, stroke: Stroke) -> None:
        """Show the effect of the stroke so far."""
        before: tuple[Stroke, ...] = ()
        if stroke.tool != "eraser":
            modeler, tool = self._ink_tool
            waiting = self._drawing.document.waiting
            before = strokes_of(
                tuple(one for one in waiting if one.is_for(modeler, tool) and not one.is_marked)
            )
        self._preview(Ink((*before, stroke)))

    def stroke_lifted(self, stroke: Stroke) -> None:
        """Keep a complete stroke, and let the tool try the ink."""
        self._pen_is_down = False
        if stroke.tool == "eraser":
            self._erase(stroke)
            return
        one = WaitingStroke(stroke, *self._ink_tool)
        waiting = (*self._drawing.document.waiting, one)
        self._drawing.set_waiting(tr("Session", "Stroke"), waiting, drawn=True)
        if self._has_modeler():
            self._apply_ink(stroke, committed=False)

    def cancel(self) -> None:
        """Forget the gesture under way."""
        self._pen_is_down = False
        if self.motion.is_held:
            self.motion.cancel()
        self._clear_preview()

    def undo(self) -> None:
        """Take back what the hand did last: what has no answer yet, else the last step."""
        if not self.edits.withdraw_newest():
            self._drawing.undo()
            return
        self._clear_preview()
        self._notices.tell(tr("Session", "Taken back before it was done."))

    def commit(self) -> None:
        """Try the waiting ink as it is (Enter); without any, the next stroke starts an object."""
        if not self._drawing.pending:
            self._selection.select(None)
            self._notices.tell(tr("Session", "The next stroke starts a new object."))
            return
        if not self._has_modeler():
            return
        tool = self._toolbox.active
        if tool is not None and tool.gesture != "ink":
            said = tr("Session", "{tool} does not draw. Take a tool that does, then press Enter.")
            self._notices.complain(UserError(said.format(tool=tool.title)))
            return
        self._apply_ink(self._drawing.pending[-1], committed=True)

    def drop_last(self) -> None:
        """Take back the newest waiting stroke."""
        self._drop(tr("Session", "Take back a stroke"), self._drawing.pending[-1:])

    def clear(self) -> None:
        """Take back all waiting strokes."""
        self._drop(tr("Session", "Take back the waiting ink"), self._drawing.pending)

    def explain(self, meant: Literal["turn", "tap", "stroke"]) -> None:
        """Say what is missing in a press that had no effect.

        Parameters
        ----------
        meant : {"turn", "tap", "stroke"}
            The gesture that it was taken for.
        """
        if meant == "turn":
            self._notices.say_nothing_changed(tr("Session", "Drag to turn the view."))
            return
        tool = self._toolbox.active
        if meant == "stroke":
            wish = tr("Session", "That was too short for a stroke.")
        elif tool is not None and tool.touches:
            wish = tr("Session", "This tool wants a short tap in one place.")
        else:
            wish = ""  # a tool of handles alone: its hint says which
        hint = self._toolbox.hint_of(self._toolbox.tool)
        self._notices.say_nothing_changed(f"{wish} {hint}".strip())

    def restart(self) -> None:
        """Drop all work: another document comes, with ink of its own."""
        self.motion.stop()
        self.edits.cancel()
        self.cancel()

    def stop(self) -> bool:
        """Stop motions and the work on gestures; return whether ink waits, marked."""
        self.motion.stop()
        if not self.edits.busy:
            return False
        self.edits.cancel()
        self._clear_preview()
        waiting = self._drawing.document.waiting
        said = tr("Session", "This stroke was stopped. Press Enter to try it again.")
        for one in [one for one in waiting if one.status == "new"]:
            self._mark((one.stroke,), "failed", said, modeler=one.modeler, tool=one.tool)
        return bool(waiting)

    def _go_on(self, returned: list[str], models_differ: bool) -> None:
        """Try ink without an answer anew: the person jumped in the history.

        What else has no answer is dropped, but not where only ink was taken back: a drag that was
        made before a stroke goes on without it.
        """
        self.edits.cancel(only_kept=not models_differ)
        self._awaited = ""
        self._scene.show_preview(Scene())
        for one in self._drawing.document.waiting:
            if one.status == "new" and one.is_for(*self._ink_tool):
                self._apply_ink(one.stroke, committed=False)

    def _drop(self, label: str, strokes: Sequence[Stroke]) -> None:
        if strokes:
            self._drawing.set_waiting(label, without(self._drawing.document.waiting, strokes))
            self._clear_preview()

    def _erase(self, eraser: Stroke) -> None:
        """Erase waiting ink; if there is none under the eraser, the tool gets its path."""
        found = touched(self._drawing.document.waiting, eraser, ERASER_REACH)
        if found:
            self._drop(tr("Session", "Erase waiting ink"), found)
        elif self._has_modeler():
            self._submit_at_once(lambda: (Ink((eraser,)),), self._ink_tool[1])

    # -- taps and drags --

    def hovered(self, tap: Tap) -> None:
        """Show what a pen near the sheet would touch, for tools that want to know."""
        self._preview(tap)
        self._pen_is_down = False

    def tap_moved(self, tap: Tap) -> None:
        """Show the effect of a tap that is still being aimed."""
        self._preview(tap)

    def tap(self, tap: Tap, *, again: bool = False) -> None:
        """Take a short touch, or the end of one that was aimed.

        Parameters
        ----------
        tap : Tap
            Where, with its keys.
        again : bool
            Whether it is the second one of a double click, which counts only where the first one
            changed nothing but what is chosen: else it would undo a switch that was touched, or
            go past the answer that was asked for.
        """
        aimed, self._pen_is_down = self._pen_is_down, False
        if not self._has_modeler():
            return

        def touch() -> tuple[Tap, ...]:
            """Return the touch, if it counts, once the one before it is answered."""
            if again and self._touch_counted:
                self._notices.tell(tr("Session", "A double click counts as one touch."))
                return ()
            self._touch_counted = False
            return (tap,)

        self._submit_at_once(touch, self._toolbox.tool_for("tap"), clear=aimed)

    def handle_moved(self, drag: Drag) -> None:
        """Show the effect of a drag so far, or let the tool move what it holds."""
        tool = self._toolbox.tool_for("drag")
        if self.motion.takes(tool):
            self.motion.hold(drag, tool)
        else:
            self._preview(drag)

    def handle_released(self, drag: Drag) -> None:
        """Take the drag of a handle."""
        self._pen_is_down = False
        tool = self._toolbox.tool_for("drag")
        if self.motion.takes(tool):
            self.motion.hold(drag, tool, lifted=True)
        elif self._has_modeler():
            self._submit_at_once(lambda: (drag,), tool)

    def _submit_at_once(
        self, gesture_now: Callable[[], tuple[Gesture, ...]], tool: str, *, clear: bool = True
    ) -> None:
        """Queue a gesture of which nothing is kept if it is refused."""

        def failed(problem: BaseException) -> None:
            if clear:
                self._clear_preview()
            self._notices.complain(problem)

        self._submit(gesture_now, tool, failed)

    # -- previews --

    def _tool_changed(self) -> None:
        """Remove the preview of the last tool."""
        if not self._pen_is_down and not self.edits.busy:
            self._clear_preview()

    def _model_shown(self, model_id: str, solved: bool) -> None:
        """Remove the preview of a gesture whose solved shape is shown."""
        if not solved or self._pen_is_down or self.edits.busy:
            return
        if self._awaited in ("", model_id):
            self._clear_preview()

    def _no_shape_comes(self) -> None:
        if not self._pen_is_down:
            self._clear_preview()

    def _clear_preview(self) -> None:
        self._awaited = ""
        self._live = None
        self.previews.cancel()
        self._scene.show_preview(Scene())

    def _preview(self, gesture: Gesture) -> None:
        if not self._pen_is_down:
            self._live = None
        self._awaited = ""
        self._pen_is_down = True
        bench, modeler = self._workbench, self._toolbox.modeler
        kind: Literal["ink", "tap", "drag"] = "ink"
        if not isinstance(gesture, Ink):
            kind = "drag" if isinstance(gesture, Drag) else "tap"
        tool = self._toolbox.tool_for(kind)
        if not modeler or not tool or (modeler, tool) in self._unpreviewable:
            return
        context, target = self.context.now(), self._selection.target(modeler)
        known = self._live
        if known is None or not known.is_for(modeler, tool, target, context.scene):
            known = self._live = _LivePreview(bench, modeler, tool, target, context)

        def work(job: Job) -> Scene:
            return known.update(gesture)

        def failed(problem: BaseException) -> None:
            """Report one fault and preview no more; the stroke itself may still succeed."""
            if not isinstance(problem, UserError | Unfinished):
                self._unpreviewable.add((modeler, tool))
                self._clear_preview()
                self._notices.complain(problem)

        self.previews.submit(Request(work, self._scene.show_preview, failed, "preview"))

    # -- from gestures to models --

    @property
    def _ink_tool(self) -> tuple[str, str]:
        """The modeler and the tool that get ink now."""
        return self._toolbox.modeler, self._toolbox.tool_for("ink")

    def _has_modeler(self) -> bool:
        if not self._toolbox.modeler:
            self._notices.complain(UserError(tr("Session", "Choose a modeler first.")))
            return False
        return True

    def _apply_ink(self, until: Stroke, *, committed: bool) -> None:
        """Let the active tool try the waiting strokes up to one of them."""
        modeler, tool = self._ink_tool

        def gestures() -> tuple[Ink, ...]:
            """Return the ink as it is now: earlier strokes may have been taken."""
            waiting = self._drawing.document.waiting
            tries = ink_to_try(waiting, until, modeler, tool, committed=committed)
            return tuple(Ink(strokes, committed) for strokes in tries)

        def failed(problem: BaseException) -> None:
            self.previews.cancel()
            self._scene.show_preview(Scene())
            if isinstance(problem, NotTaken):
                self._not_taken(problem, modeler)
                return
            notice = self._notices.of_problem(problem)
            for ink in gestures()[:1]:
                self._mark(ink.strokes, "failed", notice.text, modeler=modeler, tool=tool)
            self._notices.send(notice)

        self._submit(gestures, tool, failed, is_kept=not committed)

    def _not_taken(self, answer: NotTaken, modeler: str) -> None:
        """Let ink wait that a tool did not take, marked with what is to be done."""
        problem, strokes = answer.problem, answer.strokes
        waits = set(map(id, self._drawing.pending))
        is_meant = any(id(stroke) in waits for stroke in strokes)
        if isinstance(problem, Unfinished):
            self._mark(strokes, "unfinished", problem.hint, modeler=modeler, tool=answer.tool)
            return
        is_refused = isinstance(problem, UserError)
        if is_refused and not is_meant:
            return  # taken back meanwhile: nobody wants to know any more
        notice = self._notices.of_problem(problem)
        self._mark(
            strokes,
            "refused" if is_refused else "failed",
            notice.text,
            modeler=modeler,
            tool=answer.tool,
            places=notice.places,
        )
        self._notices.send(notice)

    def _mark(
        self, strokes: tuple[Stroke, ...], status: WaitingStatus, reason: str, **more: Any
    ) -> None:
        self._drawing.revise_waiting(
            lambda waiting: marked(waiting, strokes, status, reason=reason, **more)
        )

    def _submit(
        self,
        gestures_now: Callable[[], tuple[Gesture, ...]],
        tool_id: str,
        failed: Callable[[BaseException], None],
        *,
        is_kept: bool = False,
    ) -> None:
        """Queue a gesture.

        Parameters
        ----------
        gestures_now : callable
            Called when its turn comes; returns the gesture, and others to try if it is not
            taken. None if there is nothing left to do.
        tool_id : str
            See `Attempt.tool`.
        failed : callable
            Called with the problem if the gesture was not taken.
        is_kept : bool
            See `Request.is_kept`.
        """
        bench, drawing = self._workbench, self._drawing
        modeler_id, context = self._toolbox.modeler, self.context.now()

        def attempt() -> Attempt:
            return Attempt(gestures_now(), self._selection.model, modeler_id, tool_id, context)

        def work(job: Job, attempt: Attempt) -> Outcome | None:
            return apply_first(bench, attempt, job) if attempt.gestures else None

        def answered(answer: Outcome | None) -> None:
            if answer is None:
                return
            used = answer.gesture.strokes if isinstance(answer.gesture, Ink) else ()
            waits = set(map(id, drawing.pending))
            is_waiting = all(stroke.tool == "eraser" or id(stroke) in waits for stroke in used)
            base = answer.base
            is_known = base is None or any(base is known for known in drawing.document)
            if not (is_waiting and is_known):
                self._submit(gestures_now, tool_id, failed, is_kept=is_kept)
                return
            if not answer.changed:
                hint = self._toolbox.hint_of(answer.tool)
                self._mark(used, "refused", hint, modeler=modeler_id, tool=answer.tool)
                self._clear_preview()
                self._notices.say_nothing_changed(hint)
                return
            try:
                drawing.document.refuse_circle(answer.model)
            except UserError as problem:
                failed(NotTaken(problem, answer.tool, used) if used else problem)
                return
            self.previews.cancel()
            self._awaited = answer.model.id
            self._touch_counted = isinstance(answer.gesture, Tap) and not answer.only_chosen
            drawing.apply_model(
                answer.label,
                answer.model,
                is_new=base is None,
                only_chosen=answer.only_chosen,
                used=tuple(stroke for stroke in used if id(stroke) in waits),
            )

        self.edits.submit(Request(work, answered, failed, inputs=attempt, is_kept=is_kept))


class _LivePreview:
    """The preview of one gesture; it is begun and updated in the worker of the previews."""

    def __init__(
        self, bench: Workbench, modeler: str, tool: str, target: Model | None, context: Context
    ) -> None:
        self._bench, self._modeler, self._tool = bench, modeler, tool
        self._target, self._context = target, context
        self._preview: ModelPreview | None = None

    def is_for(self, modeler: str, tool: str, target: Model | None, scene: Scene) -> bool:
        """Whether the gesture goes on in the same world."""
        same_tool = (modeler, tool) == (self._modeler, self._tool)
        return same_tool and target is self._target and scene is self._context.scene

    def update(self, gesture: Gesture) -> Scene:
        """Return what to show of the gesture so far."""
        bench, context = self._bench, self._context
        if self._preview is None:
            model = self._target or bench.create(self._modeler, context)
            self._preview = bench.begin(model, bench.tool(self._modeler, self._tool), context)
        return self._preview.update(gesture)
