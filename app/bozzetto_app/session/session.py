"""The session: what the window is about, without a widget in it.

One document with its history, the selected model, the view, and the work that is under
way. Widgets read it, call its methods and listen to its signals; they never change a
document themselves. Everything that enters a plugin runs in a worker
(`bozzetto_app.workers.channel`), so that no plugin can hold up the window. Its parts have
modules of their own: `view_state` the view, `toolbox` the modelers and tools, `pen_calls` and
`gestures` the gestures, `object_edits` the objects and `part_edits` what they are made of,
`modeler_commands` the modelers' commands, `view_advice` what they say of the view,
`from_shapes` shapes as input, `pictures` sketches that come in, `solver` the pictures, `files`
the disk.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

from PySide6.QtCore import QObject, Signal

from bozzetto.document.applied_ink import take
from bozzetto.document.history import History
from bozzetto.document.model import Document, Model
from bozzetto.document.waiting_ink import Waiting, WaitingStroke
from bozzetto.errors import UserError
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.context import Context
from bozzetto.plugin.host.registry import ModelerInfo, Registry
from bozzetto.scene.display_list import Image, Layer, Scene
from bozzetto.workbench.workbench import Workbench
from bozzetto_app.i18n import tr
from bozzetto_app.session.files import Files
from bozzetto_app.session.from_shapes import Using
from bozzetto_app.session.gestures import Inking
from bozzetto_app.session.modeler_commands import Commanding
from bozzetto_app.session.notices import Notice, notice_of, slow_notice
from bozzetto_app.session.object_edits import ObjectEdits
from bozzetto_app.session.part_edits import PartEditing
from bozzetto_app.session.pen_calls import PenCalls
from bozzetto_app.session.pictures import Picturing
from bozzetto_app.session.solver import Showing
from bozzetto_app.session.tool_hints import Expecting
from bozzetto_app.session.toolbox import Toolbox, ToolInfo
from bozzetto_app.session.view_advice import Advising
from bozzetto_app.session.view_state import Looking, Shading
from bozzetto_app.workers.channel import Hung

__all__ = ["Notice", "Session", "Shading", "ToolInfo"]

GHOST_LAYER = "ink"
"""Name of the layers that hold processed ink; they can be hidden together."""


def _at_once(then: Callable[[], None], refused: Callable[[], None] | None = None) -> None:
    then()


class _WhenSafe(Protocol):
    def __call__(
        self, then: Callable[[], None], refused: Callable[[], None] | None = None
    ) -> None: ...


class Session(ObjectEdits, PartEditing, PenCalls, Looking):
    """The one object that every widget talks to.

    Attributes
    ----------
    when_safe : callable
        Called with what would lose unsaved work, and with what to do if the person would
        rather stay; the window asks them first.
    is_dragging : bool
        Whether a value is being dragged, so that the document is another one in a moment.
    facts, pictures : mapping
        What the drawing that is being watched says beyond its strokes, and the pictures that
        it names; see `Context.facts`.

    Signals
    -------
    document_changed
        The snapshot was replaced, or its name or saved state.
    selection_changed, modeler_changed, tool_changed, parameters_changed
        Another model is selected; another modeler or tool is active; values differ.
    scene_changed, live_changed
        The display list, or what is shown only while the pen is down, differs.
    pending_changed
        The ink that waits differs, or what is known of it.
    noticed : Notice
        Something to say.
    progressed : float, str; busy_changed : bool
        Long work advances, starts, ends.
    report_changed
        Figures of the selected model's result differ.
    settled : str
        A model (id) that was just drawn has its first final shape.
    opened
        Another document is here.
    rested
        A drag of a value has ended, or rests.
    """

    document_changed = Signal()
    selection_changed = Signal()
    modeler_changed = Signal()
    tool_changed = Signal()
    parameters_changed = Signal()
    scene_changed = Signal()
    live_changed = Signal()
    pending_changed = Signal()
    noticed = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)
    report_changed = Signal()
    settled = Signal(str)
    opened = Signal()
    rested = Signal()

    def __init__(self, registry: Registry, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.registry = registry
        self.workbench = Workbench(registry)
        self.history = History(Document())
        self.path: Path | None = None
        self.read_only = False
        self.report: dict[str, Any] = {}
        self.facts: Mapping[str, Any] = {}
        self.pictures: Mapping[str, Picture] = {}
        self.hint = ""
        self.when_safe: _WhenSafe = _at_once
        self._selected: str | None = None
        self._recovered = False
        self._was_busy = False
        self.is_dragging = False
        self._scene: Scene | None = None
        self._last_scene = Scene()
        self._ghosts_in_scene = True
        self._waiting_told: Waiting = ()
        self.toolbox = Toolbox(self)
        self.inking = Inking(self)
        self.files = Files(self)
        self.using = Using(self)
        self.picturing = Picturing(self)
        self.advising = Advising(self)
        self.commanding = Commanding(self)
        self.expecting = Expecting(self)
        self.showing = Showing(self.workbench, self)
        self.showing.changed.connect(self._model_shown)
        self.showing.settled.connect(self.settled)
        self.showing.rested.connect(self._rest)
        self.showing.slow.connect(self.tell_slow)
        self.showing.reported.connect(self._take_report)
        self.showing.failed.connect(self._unsolved)
        self.showing.progressed.connect(self.progressed)
        self.showing.busy_changed.connect(self._look_who_is_busy)
        for part in (self.inking, self.files, self.using, self.picturing):
            part.progressed.connect(self.progressed)
            part.busy_changed.connect(self._look_who_is_busy)
        self.picturing.taken.connect(self.toolbox.take_first_tool)
        self.view_style_changed.connect(self._style_changed)
        self.tool_changed.connect(self._hand_changed)
        self.selection_changed.connect(self._hand_changed)

    # -- reading --

    @property
    def document(self) -> Document:
        """The snapshot shown now."""
        return self.history.document

    @property
    def title(self) -> str:
        """The document's name for the window's title."""
        return self.path.stem if self.path else tr("Session", "Untitled")

    @property
    def is_modified(self) -> bool:
        """Whether something would be lost by closing."""
        return self._recovered or self.history.is_modified

    @property
    def modelers(self) -> tuple[ModelerInfo, ...]:
        """All modelers that can be drawn with, in order."""
        return tuple(info for info in self.registry.modelers() if info.listed)

    @property
    def active_modeler(self) -> str:
        """Id of the modeler that is drawn with; "" where there is none."""
        return self.toolbox.modeler

    @property
    def active_tool(self) -> str:
        """Id of the tool in the hand; "" until the modeler's tools are known."""
        return self.toolbox.tool

    @property
    def tools(self) -> tuple[ToolInfo, ...]:
        """The active modeler's tools."""
        return self.toolbox.tools

    @property
    def selected(self) -> str | None:
        """Id of the selected model."""
        return self._selected

    @property
    def selected_model(self) -> Model | None:
        """The selected model itself."""
        for model in self.document:
            if model.id == self._selected:
                return model
        return None

    @property
    def scene(self) -> Scene:
        """Everything visible, in the world; the very same object while nothing else is seen."""
        if self._scene is None:
            layers = [*self.workbench.underlay_layers(self.document), *self.showing.layers()]
            seen = tuple(filter(self.is_seen, layers))
            if seen != self._last_scene.layers:  # a layer is equal to itself alone
                self._last_scene = Scene(seen)
            self._scene = self._last_scene
            self._ghosts_in_scene = self.show_ghost_ink
        return self._scene

    def is_seen(self, layer: Layer) -> bool:
        """Whether a layer is to be seen now, with the tool in the hand and what is switched off."""
        if layer.name == GHOST_LAYER and not self.show_ghost_ink:
            return False
        in_hand = layer.tool == self.active_tool and layer.owner == self._selected
        return in_hand or not layer.tool

    def context(self) -> Context:
        """The world around a gesture made now."""
        shown = self.workbench.underlay_layers(self.document)
        images = (item for layer in shown for item in layer.items if isinstance(item, Image))
        underlay = next(images, None)
        return Context(
            camera=self.camera,
            scene=self.scene,
            underlay=underlay,
            facts=self.facts,
            pictures=self.pictures,
            curves=self.workbench.curves.of(self.document),
            seen=self.advising.seen_states(self.inking.target(self.active_modeler)),
        )

    @property
    def busy(self) -> bool:
        """Whether any work is under way."""
        parts = (
            self.toolbox,
            self.inking,
            self.commanding,
            self.advising,
            self.expecting,
            self.using,
            self.picturing,
            self.showing,
            self.files,
        )
        return any(part.busy for part in parts)

    # -- modelers and tools --

    def activate_modeler(self, modeler_id: str) -> None:
        """Draw with another modeler; pending ink stays."""
        if modeler_id != self.active_modeler:
            self.toolbox.take_modeler(modeler_id)
            self.inking.hand_changed()

    def activate_tool(self, tool_id: str) -> None:
        """Take another tool of the active modeler."""
        self.toolbox.take_tool(tool_id)
        self.inking.hand_changed()

    # -- the document --

    def commit(self, label: str, document: Document, merge_key: str | None = None) -> None:
        """Make a new snapshot the document, as one undo step."""
        self.history.apply(label, document, merge_key)
        self._document_replaced(dragging=merge_key is not None)

    def amend(self, document: Document) -> None:
        """Put another snapshot in the place of the document, without an undo step."""
        self.history.amend(document)
        self._document_replaced()

    def take_ink(self, label: str, waiting: Waiting, *, drawn: bool = False) -> None:
        """Exchange the ink that waits, as one undo step; no shape changes."""
        self.history.apply(label, self.document.with_waiting(waiting), drawn=drawn)
        self._ink_replaced()

    def revise_ink(self, change: Callable[[Waiting], Waiting]) -> None:
        """Note what is known of ink that waits, wherever it waits; no step of the history."""
        self.history.revise(lambda document: document.with_waiting(change(document.waiting)))
        self._tell_of_ink()

    def take_drawn(
        self,
        label: str,
        model: Model,
        *,
        is_new: bool,
        only_chosen: bool = False,
        used: tuple[Stroke, ...] = (),
    ) -> None:
        """Take what came of a gesture into the document, and select it.

        A gesture that only chose another part is no step of the history.

        Parameters
        ----------
        label : str
        model : Model
        is_new : bool
        only_chosen : bool
        used : tuple of Stroke
            Ink that waited and is the model's now; see `bozzetto.document.applied_ink.take`.
        """
        if only_chosen and not used:
            self.amend(self.document.with_model(model))
            return
        if is_new:
            model = replace(model, name=self.document.unused_name(model.name))
        self.showing.await_final(model.id)
        take(self.history, label, model, used)
        self._document_replaced()
        self.select(model.id)

    def undo(self) -> None:
        """Take back the last step: a stroke, what came of it, or anything else."""
        self.go_to(self.history.position - 1)

    def redo(self) -> None:
        """Do again what was taken back."""
        self.go_to(self.history.position + 1)

    def go_to(self, index: int) -> None:
        """Jump to a step of the history; what comes back is selected where nothing is."""
        before = {model.id for model in self.document}
        self.history.go_to(index)
        self.inking.show_live(Scene())
        self._document_replaced()
        back = [model.id for model in self.document if model.id not in before]
        if back and self._selected is None:
            self.select(back[-1])
        self.inking.go_on()

    def select(self, model_id: str | None) -> None:
        """Select a model; its modeler becomes the active one."""
        if model_id == self._selected:
            return
        self._selected = model_id
        self.report = {}
        self.selection_changed.emit()
        self.parameters_changed.emit()
        self.report_changed.emit()
        model = self.selected_model
        if model is not None:
            if any(info.id == model.modeler for info in self.modelers):
                self.activate_modeler(model.modeler)
            self.showing.show(self.document, model)

    def show_document(
        self,
        document: Document,
        path: Path | None,
        *,
        read_only: bool = False,
        saved: bool = True,
        pending: tuple[Stroke, ...] = (),
    ) -> None:
        """Make another document the one on the sheet.

        Parameters
        ----------
        document : Document
        path : Path, optional
            Where it lies on the disk.
        read_only : bool
            Whether it must not be written over.
        saved : bool
            False for what was recovered: it is not on the disk as it is.
        pending : tuple of Stroke
            Ink that waited beside the document's own; see `Replay.pending`.
        """
        if pending:
            more = tuple(map(WaitingStroke, pending))
            document = document.with_waiting((*document.waiting, *more))
        self.showing.forget()
        self.workbench.forget_results()
        self.history = History(document)
        self._recovered = not saved
        self.path = path
        self.read_only = read_only
        self._selected = None
        self.report = {}
        self.inking.restart()
        if document.camera is not None:
            self.set_camera(document.camera.with_viewport(*self.camera.viewport))
        self._document_replaced()
        self.select(document.models[-1].id if document.models else None)
        self.selection_changed.emit()
        self.report_changed.emit()
        self.opened.emit()
        if document.waiting:
            self.tell(tr("Session", "Ink is waiting. Enter tries it, the eraser takes it away."))

    def saved_as(self, path: Path, snapshot: Document) -> None:
        """Note that a snapshot is on the disk."""
        self.path = path
        self.read_only = False
        self.history.mark_saved(snapshot)
        self._recovered = False
        self.document_changed.emit()

    def allow_saving(self) -> None:
        """The document's file may be written to from now on."""
        self.read_only = False
        self.document_changed.emit()

    def _document_replaced(self, *, dragging: bool = False) -> None:
        if self._selected is not None and self.selected_model is None:
            self._selected = None
            self.report = {}
            self.selection_changed.emit()
            self.report_changed.emit()
        self._scene = None
        self.is_dragging = dragging
        self._ink_replaced()
        self.showing.show(self.document, self.selected_model, dragging=dragging)
        self.scene_changed.emit()

    def _ink_replaced(self) -> None:
        """The snapshot is another one; its shapes may be the same."""
        self.document_changed.emit()
        self._tell_of_ink()

    def _tell_of_ink(self) -> None:
        if self.document.waiting is not self._waiting_told:
            self._waiting_told = self.document.waiting
            self.pending_changed.emit()

    # -- files --

    def open(self, path: Path) -> None:
        """Open a document once unsaved work is safe."""
        self.when_safe(lambda: self.files.open(path))

    def import_file(self, path: Path) -> None:
        """Bring a drawing, a mesh or a picture onto the sheet."""
        self.files.import_file(path)

    # -- work under way --

    def cancel_work(self) -> None:
        """Stop what is being drawn, solved, read or exported; what was shown stays."""
        waits = self.inking.stop()
        self.showing.cancel()
        self.toolbox.stop()
        self.files.cancel()
        self.using.cancel()
        self.picturing.cancel()
        if waits:
            self.tell(tr("Session", "Stopped. The ink waits; Enter tries it again."))
        else:
            self.tell(tr("Session", "Stopped. Nothing was changed."))

    def cancel_all(self) -> None:
        """Stop everything but a save: the window closes."""
        self.showing.cancel()
        self.files.cancel()
        self.using.cancel()
        self.picturing.cancel()
        self.inking.restart()

    def _look_who_is_busy(self) -> None:
        parts = (self.showing, self.files, self.using, self.picturing)
        busy = self.inking.at_the_modeler or any(part.busy for part in parts)
        if busy != self._was_busy:
            self._was_busy = busy
            self.busy_changed.emit(busy)

    def _rest(self) -> None:
        self.is_dragging = False
        self.rested.emit()

    def _model_shown(self, model_id: str, solved: bool) -> None:
        self._scene = None
        if solved:
            self.inking.shape_shown(model_id)
        self.scene_changed.emit()

    def _unsolved(self, problem: BaseException) -> None:
        self.inking.no_shape_comes()
        self.complain(problem)

    def _hand_changed(self) -> None:
        self._scene = None
        self.scene_changed.emit()

    def _style_changed(self) -> None:
        if self.show_ghost_ink != self._ghosts_in_scene:
            self._scene = None
            self.scene_changed.emit()

    def _take_report(self, model: Model, report: dict[str, Any]) -> None:
        selected = self.selected_model
        if selected is not None and model.state is selected.state:
            self.report = report
            self.report_changed.emit()

    # -- saying things --

    def say_hint(self, text: str) -> None:
        """Say what gesture is expected next."""
        self.hint = text
        self.noticed.emit(Notice("hint", text))

    def tell(self, text: str) -> None:
        """Say that something went well."""
        self.noticed.emit(Notice("info", text))

    def say_nothing_changed(self, why: str) -> None:
        """Say that what was just asked for changed nothing, and why or what to do instead."""
        self.complain(UserError(tr("Session", "Nothing changed. {why}", why=why).strip()))

    def tell_slow(self, problem: Hung) -> None:
        """Say that work goes on for long, and that it can be stopped."""
        self.noticed.emit(slow_notice(problem, self.registry.guard))

    def complain(self, problem: BaseException) -> None:
        """Tell the person about a problem, each kind in its own way."""
        self.noticed.emit(notice_of(problem, self.registry.guard))
