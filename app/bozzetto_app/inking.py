"""Inking: what the hand does becomes a new state of a model, or waits, or is refused.

Strokes wait until a tool understands them. One gesture at a time is worked on, in the
order in which they were made, each on the document as it is by then; if the document moves
on meanwhile, the gesture is worked on again. What is taken back before its answer comes
leaves nothing behind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from PySide6.QtCore import QObject

from bozzetto.document.model import Model
from bozzetto.errors import Unfinished, UserError
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Layer, Lines, Scene
from bozzetto_app.jobs import Channel, Request
from bozzetto_app.words import tr

if TYPE_CHECKING:
    from bozzetto_app.session import Session

__all__ = ["Inking"]

APPLY_LIMIT = 15.0
"""Seconds a tool may take over one gesture before it counts as hung."""

PREVIEW_LIMIT = 10.0
"""Seconds a live preview may take before it counts as hung."""


@dataclass(frozen=True)
class _Answer:
    """What became of a gesture: `model` in the place of `base`, or a new one."""

    gesture: Gesture
    base: Model | None
    model: Model
    label: str
    tool: str
    only_chosen: bool


class Inking(QObject):
    """The ink that waits, what is shown while the pen is down, and the work on gestures.

    Attributes
    ----------
    pending : tuple of Stroke
        Strokes that no tool has understood yet.
    live : Scene
        What is shown only until something better is there.
    """

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.pending: tuple[Stroke, ...] = ()
        self.live = Scene()
        self._pen_is_down = False
        self._awaited = ""
        self._unpreviewable: set[tuple[str, str]] = set()
        self._edits = Channel(
            "apply", keep_all=True, time_limit=APPLY_LIMIT, is_patient=True, parent=self
        )
        self._edits.slow.connect(session.tell_slow)
        self._previews = Channel("preview", time_limit=PREVIEW_LIMIT, parent=self)

    @property
    def busy(self) -> bool:
        """Whether a gesture is being worked on."""
        return self._edits.busy or self._previews.busy

    # -- strokes --

    def moved(self, stroke: Stroke) -> None:
        """Show what the stroke so far would make."""
        self._awaited = ""
        self._pen_is_down = True
        self._preview(Ink((*self.pending, stroke)))

    def lifted(self, stroke: Stroke) -> None:
        """Take a complete stroke and let the tool try the ink."""
        self._pen_is_down = False
        if self._may_edit():
            self._await_ink((*self.pending, stroke))
            self._apply_ink(until=stroke, committed=False)

    def cancelled(self) -> None:
        """Forget the stroke that was being drawn."""
        self._pen_is_down = False
        self._show_nothing()

    def commit(self) -> None:
        """Say that the strokes that wait are all."""
        self._apply_ink(until=self.pending[-1], committed=True)

    def drop_last(self) -> None:
        """Take back the newest stroke that waits."""
        self._await_ink(self.pending[:-1])
        self._show_nothing()

    def restart(self, pending: tuple[Stroke, ...] = ()) -> None:
        """Drop all work and ink: there is another document, with ink of its own."""
        self._edits.cancel()
        self._await_ink(pending)
        self.cancelled()

    def stop(self) -> None:
        """Stop working on gestures; ink that was not understood yet waits on."""
        self._edits.cancel()
        self._show_nothing()

    def go_on(self) -> None:
        """The person jumped in the history: only the ink that waits is still meant."""
        self._edits.cancel()
        self._awaited = ""
        if self.pending:
            self._apply_ink(until=self.pending[-1], committed=False)

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
            tool = self._session.toolbox.tool_for("tap")

            def failed(problem: BaseException) -> None:
                if aimed:
                    self._show_nothing()
                self._session.complain(problem)

            self._submit(lambda: tap, tool, failed)

    def handle_moved(self, drag: Drag) -> None:
        """Show what a handle dragged so far would make."""
        self._awaited = ""
        self._pen_is_down = True
        self._preview(drag)

    def handle_released(self, drag: Drag) -> None:
        """A handle was let go."""
        self._pen_is_down = False
        if self._may_edit():
            tool = self._session.toolbox.tool_for("drag")

            def failed(problem: BaseException) -> None:
                self._show_nothing()
                self._session.complain(problem)

            self._submit(lambda: drag, tool, failed)

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

    def _await_ink(self, pending: tuple[Stroke, ...]) -> None:
        if pending != self.pending:
            self.pending = pending
            self._session.pending_changed.emit()

    def _apply_ink(self, *, until: Stroke, committed: bool) -> None:
        """Let the tool try the strokes that wait, up to one of them."""

        def gesture() -> Ink | None:
            """The ink as it is when its turn comes: earlier strokes may have found a home."""
            pending = self.pending
            places = [place for place, stroke in enumerate(pending, 1) if stroke is until]
            return Ink(pending[: places[0]], committed) if places else None

        def failed(problem: BaseException) -> None:
            if isinstance(problem, Unfinished):
                self._session.say_hint(problem.hint)
                return
            refused = gesture()
            if refused is not None:
                self._await_ink(self._without(refused.strokes))
                self._previews.cancel()
                self.show_live(_warning(refused.strokes))
            self._session.complain(problem)

        self._submit(gesture, self._session.toolbox.tool_for("ink"), failed)

    def _without(self, strokes: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
        taken = set(map(id, strokes))
        return tuple(stroke for stroke in self.pending if id(stroke) not in taken)

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
        gesture_now: Callable[[], Gesture | None],
        tool_id: str,
        failed: Callable[[BaseException], None],
    ) -> None:
        """Queue a gesture.

        Parameters
        ----------
        gesture_now : callable
            Gives the gesture when its turn comes; None where there is nothing left to do.
        tool_id : str
            "" is the modeler's first tool: the person was quicker than its import.
        failed : callable
        """
        session = self._session
        modeler_id, context = session.active_modeler, session.context()

        def work(job: Job) -> _Answer | None:
            gesture = gesture_now()
            if gesture is None:
                return None
            return self._worked_out(gesture, modeler_id, tool_id, context)

        def answered(answer: _Answer | None) -> None:
            if answer is None or (isinstance(answer.gesture, Ink) and gesture_now() is None):
                return
            base = answer.base
            if base is not None and all(base is not known for known in session.document):
                self._submit(gesture_now, tool_id, failed)
                return
            # Ink and model change places at once: the journal must never miss a stroke.
            used = answer.gesture.strokes if isinstance(answer.gesture, Ink) else ()
            self.pending = self._without(used)
            self._previews.cancel()
            self._awaited = answer.model.id
            session.take_drawn(
                answer.label,
                answer.model,
                is_new=base is None,
                only_chosen=answer.only_chosen,
            )
            if used:
                session.pending_changed.emit()
            hint = session.toolbox.hint_of(answer.tool)
            if hint and not session.toolbox.tells_next(answer.tool):
                session.say_hint(
                    tr(
                        "Session",
                        "{hint} Middle button or Alt + pen turns. Enter starts a new object.",
                        hint=hint,
                    )
                )

        self._edits.submit(Request(work, answered, failed))

    def _worked_out(
        self, gesture: Gesture, modeler_id: str, tool_id: str, context: Context
    ) -> _Answer:
        """In the worker: the state after a gesture."""
        bench = self._session.workbench
        base = self.target(modeler_id)
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
        changed = bench.apply(model, tool, gesture, context)
        only_chosen = base is not None and bench.parts.only_choice_differs(base, changed)
        return _Answer(gesture, base, changed, tool.title, tool.id, only_chosen)


def _warning(strokes: tuple[Stroke, ...]) -> Scene:
    """Ink that was not understood, in the colour of warnings, until the next stroke."""
    lines = []
    for stroke in strokes:
        camera = stroke.camera
        _, _, forward = camera.axes
        on_sheet = camera.on_plane(stroke.points, camera.target, forward)
        lines.append(Lines(on_sheet.astype(np.float32), color="warning", width=1.5, hidden="show"))
    return Scene((Layer("refused", tuple(lines)),))
