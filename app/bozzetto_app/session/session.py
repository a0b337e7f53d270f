"""The session: the state behind the window, without a widget in it.

The session builds its parts and connects them. Each part is a module of its own, and none of
them holds the session:

* the state: `document_model`, `selection`, `view_state`, `toolbox`, `scene_model`;
* the services that work on it: `gestures`, `motion`, `object_edits`, `part_edits`,
  `modeler_commands`, `from_shapes`, `ink_readings`, `pictures`, `drawing_input`, `files`,
  `solver`, `view_advice`, `hints`;
* `notices`, which tells the person about it.

Widgets read the parts, call their methods and listen to their signals; they never change a
document themselves. Every call into a plugin that can wait runs in a worker
(`bozzetto_app.workers.channel`), so that no plugin can hold up the window.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from PySide6.QtCore import QObject, Signal, SignalInstance

from bozzetto.workbench.workbench import Workbench
from bozzetto_app.i18n import tr
from bozzetto_app.session.document_model import DocumentModel
from bozzetto_app.session.drawing_input import DrawingInput
from bozzetto_app.session.exchange import Exchange
from bozzetto_app.session.files import Files
from bozzetto_app.session.from_shapes import ShapeInput
from bozzetto_app.session.gesture_context import GestureContext
from bozzetto_app.session.gestures import Gestures
from bozzetto_app.session.hints import Hints
from bozzetto_app.session.ink_readings import InkReadings
from bozzetto_app.session.modeler_commands import ModelerCommands
from bozzetto_app.session.motion import Motion
from bozzetto_app.session.notices import Notices
from bozzetto_app.session.object_clipboard import ObjectClipboard
from bozzetto_app.session.object_edits import ObjectEdits
from bozzetto_app.session.part_edits import ObjectParts
from bozzetto_app.session.pictures import PictureInput
from bozzetto_app.session.scene_model import SceneModel
from bozzetto_app.session.selection import Selection
from bozzetto_app.session.solver import Solver
from bozzetto_app.session.toolbox import Toolbox
from bozzetto_app.session.tracing import Tracing
from bozzetto_app.session.underlay_placing import UnderlayPlacing
from bozzetto_app.session.view_advice import ViewAdviser
from bozzetto_app.session.view_state import ViewState

if TYPE_CHECKING:
    from bozzetto.document.model import Document
    from bozzetto.plugin.host.registry import Registry

__all__ = ["Session"]


class _Busy(Protocol):
    """A service or channel that may be at work."""

    @property
    def busy(self) -> bool: ...


class _Work(_Busy, Protocol):
    """Work that the window shows."""

    progressed: SignalInstance
    busy_changed: SignalInstance


class Session(QObject):
    """The parts of one session, and the work under way in all of them.

    Parameters
    ----------
    registry : Registry
        The plugins.

    Signals
    -------
    progressed : float, str; busy_changed : bool
        Long work advances, starts, ends.
    """

    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, registry: Registry, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.registry = registry
        self.workbench = bench = Workbench(registry)
        self.notices = notices = Notices(registry.guard, self)
        self.drawing = drawing = DocumentModel(self)
        self.selection = selection = Selection(drawing, self)
        self.view = view = ViewState(self)
        self.toolbox = toolbox = Toolbox(bench, selection, notices, self)
        self.solver = solver = Solver(bench, drawing, selection, notices, self)
        self.scene = scene = SceneModel(bench, drawing, selection, view, toolbox, solver, self)
        self.advice = advice = ViewAdviser(
            bench, drawing, selection, view, toolbox, solver, scene, notices, self
        )
        context = GestureContext(bench, drawing, selection, view, toolbox, scene, advice)
        motion = Motion(bench, drawing, selection, toolbox, solver, context, notices, self)
        self.gestures = gestures = Gestures(
            bench, drawing, selection, toolbox, solver, scene, context, motion, notices, self
        )
        edits = gestures.edits
        self.objects = objects = ObjectEdits(bench, drawing, selection, view, solver, notices, self)
        self.parts = parts = ObjectParts(bench, drawing, selection, objects, notices)
        self.commands = ModelerCommands(
            bench, drawing, selection, toolbox, context, edits, notices, self
        )
        self.hints = Hints(bench, drawing, selection, toolbox, context, notices, self)
        self.shapes = ShapeInput(bench, drawing, parts, notices, self)
        self.readings = InkReadings(bench, drawing, selection, context, notices, self)
        tracing = Tracing(drawing, view, toolbox, notices, self)
        placing = UnderlayPlacing(drawing, selection, toolbox, scene, objects, notices, self)
        self.pictures = PictureInput(
            bench,
            drawing,
            selection,
            toolbox,
            objects,
            context,
            edits,
            tracing,
            placing,
            notices,
            self,
        )
        placing.changed.connect(lambda: self.hints.wish(placing.wish))
        drawings = DrawingInput(bench, drawing, selection, context, edits, notices, self)
        clipboard = ObjectClipboard(bench, drawing, selection, objects, notices, self)
        exchange = Exchange(
            bench,
            drawing,
            view,
            toolbox,
            context,
            self.pictures,
            drawings,
            clipboard,
            notices,
            self,
        )
        self.files = Files(bench, drawing, view, scene, exchange, notices, self)
        self._was_busy = False
        self._shown_work: tuple[_Work, ...] = (
            solver,
            edits,
            self.files,
            exchange,
            self.shapes.channel,
            self.pictures.channel,
            drawings.channel,
            clipboard.channel,
            tracing.channel,
        )
        for work in self._shown_work:
            work.progressed.connect(self.progressed)
            work.busy_changed.connect(self._update_busy)
        drawing.closing.connect(self._close)
        drawing.opened.connect(self._opened)

    @property
    def busy(self) -> bool:
        """Whether any work is under way."""
        hidden: tuple[_Busy, ...] = (
            self.toolbox.channel,
            self.gestures.previews,
            self.gestures.motion.channel,
            self.commands.channel,
            self.hints.channel,
            self.readings.channel,
            self.advice,
            self.scene,
        )
        return any(work.busy for work in (*self._shown_work, *hidden))

    def escape(self) -> bool:
        """Stop an alignment, a motion or the work on gestures, or take the waiting ink back (Esc).

        Returns
        -------
        bool
            Whether there was anything to stop or to take back.
        """
        if self.pictures.placing.end_alignment():
            self.notices.tell(tr("Session", "The picture stays where it was."))
        elif self.gestures.motion.is_moving:
            self.gestures.motion.stop()
        elif self.gestures.edits.busy:
            self.cancel_work()
        elif self.drawing.pending:
            self.gestures.clear()
            self.notices.tell(tr("Session", "The waiting ink is taken back. Undo brings it again."))
        else:
            return False
        return True

    def cancel_work(self) -> None:
        """Stop drawing, solving, reading and exporting; what was shown stays."""
        solving = self.solver.busy
        waits = self.gestures.stop()
        self.toolbox.stop()
        self._cancel_shown_work()
        if waits:
            self.notices.tell(tr("Session", "Stopped. The ink waits; Enter tries it again."))
        elif solving:
            self.notices.tell(
                tr(
                    "Session",
                    "Stopped. What you changed stays; the shape that is shown is an earlier one or "
                    "a draft.",
                )
            )
        else:
            self.notices.tell(tr("Session", "Stopped. Nothing was changed."))

    def cancel_all(self) -> None:
        """Stop everything but a save: the window closes."""
        self._cancel_shown_work()
        self.readings.cancel()
        self.gestures.restart()

    def _cancel_shown_work(self) -> None:
        for part in (
            self.solver,
            self.files,
            self.files.exchange,
            self.shapes.channel,
            self.pictures.channel,
            self.files.exchange.drawings.channel,
            self.files.exchange.clipboard.channel,
            self.pictures.tracing,
        ):
            part.cancel()

    def _update_busy(self) -> None:
        busy = any(work.busy for work in self._shown_work)
        if busy != self._was_busy:
            self._was_busy = busy
            self.busy_changed.emit(busy)

    def _close(self, coming: Document) -> None:
        """Drop the results of the old document, and show the new one as it was seen last."""
        self.workbench.forget_results()
        if coming.camera is not None:
            self.view.set_camera(coming.camera.with_viewport(*self.view.camera.viewport))

    def _opened(self) -> None:
        if self.drawing.document.waiting:
            self.notices.tell(
                tr("Session", "Ink is waiting. Enter tries it, the eraser takes it away.")
            )
