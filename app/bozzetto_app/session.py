"""The session: what the window is about, without a widget in it.

One document with its history, the active modeler, model and tool, the ink that waits to be
committed, the view, and the work that is under way. Widgets read it, call its methods and
listen to its signals; they never change a document themselves. Everything that enters a
plugin runs in a worker (`bozzetto_app.jobs`), so that no plugin can hold up the window.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from PySide6.QtCore import QObject, Signal

from bozzetto.document import edit
from bozzetto.document.edit import Edit
from bozzetto.document.history import History
from bozzetto.document.model import Document, Model, Underlay
from bozzetto.errors import Unfinished, UserError
from bozzetto.geometry.placement import Placement
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.guard import PluginFault
from bozzetto.plugin.job import Job
from bozzetto.plugin.parameters import Field, parameter_fields
from bozzetto.plugin.registry import ModelerInfo, Registry
from bozzetto.scene.display_list import Layer, Lines, Scene
from bozzetto.view.camera import Camera
from bozzetto.workbench import Workbench
from bozzetto_app.files import Files
from bozzetto_app.jobs import Channel, Request
from bozzetto_app.showing import Showing
from bozzetto_app.words import tr

__all__ = ["Notice", "Session", "ToolInfo"]

log = logging.getLogger(__name__)

APPLY_LIMIT = 5.0
"""Seconds a tool may take over one gesture before it counts as hung."""

PREVIEW_LIMIT = 2.0
"""Seconds a live preview may take before it counts as hung."""

FIRST_VIEW = Camera(eye=(0.0, -500.0, 90.0), target=(0.0, 0.0, 90.0))
"""From the front, with the ground below the middle of the sheet."""

GHOST_LAYER = "ink"
"""Name of the layers that hold processed ink; they can be hidden together."""

Shading = Literal["clay", "zebra", "curvature", "normals", "xray"]


@dataclass(frozen=True)
class Notice:
    """Something to tell the person.

    Attributes
    ----------
    kind : {"hint", "info", "error", "fault"}
        "hint" is the next expected gesture; "error" is a `UserError`; "fault" a plugin's.
    places : tuple of (x, y)
        Canvas positions to light up.
    plugin : str
        Id of the plugin at fault.
    details : str
        A traceback, for the Details button only.
    """

    kind: Literal["hint", "info", "error", "fault"]
    text: str
    places: tuple[tuple[float, float], ...] = ()
    plugin: str = ""
    details: str = ""


@dataclass(frozen=True)
class ToolInfo:
    """A tool as the rail shows it."""

    id: str
    title: str
    icon: Path | None
    hint: str
    gesture: Literal["ink", "tap", "drag"]


class Session(QObject):
    """The one object that every widget talks to.

    Signals
    -------
    document_changed
        The snapshot was replaced, or its name or saved state.
    selection_changed, modeler_changed, tool_changed, parameters_changed
        Another model is selected; another modeler or tool is active; values differ.
    scene_changed, live_changed
        The display list, or what is shown only while the pen is down, differs.
    pending_changed
        Strokes waiting to be committed differ.
    camera_changed, view_style_changed
        The view moved; shading, grid or ghost ink were switched.
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
    """

    document_changed = Signal()
    selection_changed = Signal()
    modeler_changed = Signal()
    tool_changed = Signal()
    parameters_changed = Signal()
    scene_changed = Signal()
    live_changed = Signal()
    pending_changed = Signal()
    camera_changed = Signal()
    view_style_changed = Signal()
    noticed = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)
    report_changed = Signal()
    settled = Signal(str)
    opened = Signal()

    def __init__(self, registry: Registry, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.registry = registry
        self.workbench = Workbench(registry)
        self.history = History(Document())
        self.path: Path | None = None
        self.read_only = False
        self.camera = FIRST_VIEW
        self.pending: tuple[Stroke, ...] = ()
        self.live_scene = Scene()
        self.report: dict[str, Any] = {}
        self.hint = ""
        self.shading: Shading = "clay"
        self.show_grid = True
        self.show_ghost_ink = True
        self.active_modeler = ""
        self.active_tool = ""
        self.tools: tuple[ToolInfo, ...] = ()
        self._selected: str | None = None
        self._recovered = False
        self._scene: Scene | None = None
        self.files = Files(self)

        self._edits = Channel("apply", keep_all=True, time_limit=APPLY_LIMIT, parent=self)
        self._previews = Channel("preview", time_limit=PREVIEW_LIMIT, parent=self)
        self._showing = Showing(self.workbench, self)
        self._showing.changed.connect(self._model_shown)
        self._showing.settled.connect(self.settled)
        self._showing.reported.connect(self._take_report)
        self._showing.failed.connect(self.complain)
        self._showing.progressed.connect(self.progressed)
        self._showing.busy_changed.connect(self.busy_changed)

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
        return self._recovered or self.history.is_modified or bool(self.pending)

    @property
    def modelers(self) -> tuple[ModelerInfo, ...]:
        """All modelers that can be drawn with, in order."""
        return tuple(info for info in self.registry.modelers() if info.listed)

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
    def parameters(self) -> tuple[tuple[Field, Any], ...]:
        """The selected model's parameters with their values."""
        model = self.selected_model
        if model is None or not hasattr(model.state, "__dataclass_fields__"):
            return ()
        return tuple(
            (field, getattr(model.state, field.name))
            for field in parameter_fields(type(model.state))
        )

    @property
    def scene(self) -> Scene:
        """Everything visible, in the world."""
        if self._scene is None:
            layers = [*self.workbench.underlay_layers(self.document), *self._showing.layers()]
            if not self.show_ghost_ink:
                layers = [layer for layer in layers if layer.name != GHOST_LAYER]
            self._scene = Scene(tuple(layers))
        return self._scene

    def context(self) -> Context:
        """The world around a gesture made now."""
        return Context(camera=self.camera, scene=self.scene)

    # -- modelers and tools --

    def activate_modeler(self, modeler_id: str) -> None:
        """Draw with another modeler; pending ink stays."""
        if modeler_id == self.active_modeler:
            return
        self.active_modeler = modeler_id
        self.tools, self.active_tool = (), ""
        self.modeler_changed.emit()
        info = self.registry.info(modeler_id)
        self._say_hint(info.hint)

        def found(tools: tuple[ToolInfo, ...]) -> None:
            if self.active_modeler == modeler_id:
                self.tools = tools
                self.modeler_changed.emit()
                if tools and not self.active_tool:
                    self.activate_tool(tools[0].id)

        def work(job: Job) -> tuple[ToolInfo, ...]:
            return tuple(
                ToolInfo(
                    tool.id,
                    tool.title,
                    info.folder / tool.icon if tool.icon else None,
                    tool.hint,
                    tool.gesture,
                )
                for tool in self.workbench.tools(modeler_id)
            )

        self._edits.submit(Request(work, found, self.complain))

    def activate_tool(self, tool_id: str) -> None:
        """Take another tool of the active modeler."""
        for tool in self.tools:
            if tool.id == tool_id:
                self.active_tool = tool_id
                self.tool_changed.emit()
                self._say_hint(tool.hint)

    def _say_hint(self, text: str) -> None:
        self.hint = text
        self.noticed.emit(Notice("hint", text))

    # -- the pen --

    def pen_moved(self, stroke: Stroke) -> None:
        """Show what the stroke so far would make."""
        self._preview(Ink((*self.pending, stroke)))

    def pen_lifted(self, stroke: Stroke) -> None:
        """Take a complete stroke and let the tool try the ink."""
        if not self._may_edit():
            return
        self.pending = (*self.pending, stroke)
        self.pending_changed.emit()
        self._apply_ink(committed=False)

    def pen_cancelled(self) -> None:
        """Forget the stroke that was being drawn."""
        self._previews.cancel()
        self._set_live(Scene())

    def commit_pending(self) -> None:
        """Say that the pending strokes are all; with none, start a new object next time."""
        if self.pending:
            self._apply_ink(committed=True)
        else:
            self.select(None)
            self._say_hint(tr("Session", "The next stroke starts a new object."))

    def drop_last_pending(self) -> None:
        """Take back the newest pending stroke."""
        if self.pending:
            self.pending = self.pending[:-1]
            self.pending_changed.emit()
            self.pen_cancelled()

    def clear_pending(self) -> None:
        """Take back all pending strokes."""
        if self.pending:
            self.pending = ()
            self.pending_changed.emit()
        self.pen_cancelled()

    def tapped(self, x: float, y: float, *, shift: bool = False, ctrl: bool = False) -> None:
        """A short touch with a tool that takes taps."""
        if self._may_edit():
            self._apply(Tap(x, y, self.camera, shift, ctrl), self.active_tool)

    def handle_moved(
        self, handle: str, path: Stroke, *, shift: bool = False, ctrl: bool = False
    ) -> None:
        """Show what a handle dragged so far would make."""
        self._preview(Drag(handle, path, shift, ctrl))

    def handle_released(
        self, handle: str, path: Stroke, *, shift: bool = False, ctrl: bool = False
    ) -> None:
        """A handle was let go."""
        if self._may_edit():
            self._apply(Drag(handle, path, shift, ctrl), self._tool_for_drags())

    def _tool_for_drags(self) -> str:
        takers = [tool.id for tool in self.tools if tool.gesture == "drag"]
        return takers[0] if takers else self.active_tool

    def _target(self) -> Model | None:
        """The model that the next gesture changes, or None for a new one."""
        model = self.selected_model
        usable = model is not None and model.modeler == self.active_modeler
        return model if usable and model and not model.locked and model.visible else None

    def _may_edit(self) -> bool:
        if not self.active_modeler:
            self._say_hint(tr("Session", "Choose a modeler first."))
            return False
        return True

    def _preview(self, gesture: Gesture) -> None:
        modeler, tool = self.active_modeler, self.active_tool
        if isinstance(gesture, Drag):
            tool = self._tool_for_drags()
        if not modeler or not tool:
            return
        context, target = self.context(), self._target()

        def work(job: Job) -> Scene:
            model = target or self.workbench.create(modeler, context)
            return self.workbench.preview(
                model, self.workbench.tool(modeler, tool), gesture, context
            )

        self._previews.submit(Request(work, self._set_live, self._preview_failed, "preview"))

    def _preview_failed(self, problem: BaseException) -> None:
        if not isinstance(problem, UserError | Unfinished):
            self.complain(problem)

    def _set_live(self, scene: Scene) -> None:
        if scene.layers or self.live_scene.layers:
            self.live_scene = scene
            self.live_changed.emit()

    def _apply_ink(self, *, committed: bool) -> None:
        strokes = self.pending

        def failed(problem: BaseException) -> None:
            if isinstance(problem, Unfinished):
                self._say_hint(problem.hint)
                return
            if self.pending[: len(strokes)] == strokes:
                self.pending = self.pending[len(strokes) :]
                self.pending_changed.emit()
            self._previews.cancel()
            self._set_live(_refused(strokes) if isinstance(problem, UserError) else Scene())
            self.complain(problem)

        def done() -> None:
            if self.pending[: len(strokes)] == strokes:
                self.pending = self.pending[len(strokes) :]
                self.pending_changed.emit()

        self._apply(Ink(strokes, committed), self.active_tool, done=done, failed=failed)

    def _apply(
        self,
        gesture: Gesture,
        tool_id: str,
        *,
        done: Callable[[], None] = lambda: None,
        failed: Callable[[BaseException], None] | None = None,
    ) -> None:
        modeler_id = self.active_modeler
        context = self.context()

        def work(job: Job) -> tuple[Model | None, Model, str]:
            base = self._target()
            model = base or self.workbench.create(
                modeler_id,
                context,
                name=self.document.unused_name(self.registry.info(modeler_id).title),
            )
            tool = self.workbench.tool(modeler_id, tool_id)
            return base, self.workbench.apply(model, tool, gesture, context), tool.title

        def applied(answer: tuple[Model | None, Model, str]) -> None:
            base, model, title = answer
            if base is not None and all(base is not known for known in self.document):
                return
            done()
            self._previews.cancel()
            self._showing.await_final(model.id)
            self._commit(title, self.document.with_model(model))
            if self._selected != model.id:
                self.select(model.id)
            self._say_hint(self._hint_of(tool_id))

        def not_applied(problem: BaseException) -> None:
            (failed or self.complain)(problem)

        self._edits.submit(Request(work, applied, not_applied))

    def _hint_of(self, tool_id: str) -> str:
        for tool in self.tools:
            if tool.id == tool_id:
                return tr(
                    "Session",
                    "{hint} Middle button or Alt + pen turns. Enter starts a new object.",
                ).format(hint=tool.hint)
        return self.hint

    # -- editing --

    def _commit(self, label: str, document: Document, merge_key: str | None = None) -> None:
        """Make a new snapshot the document, as one undo step."""
        self.history.apply(label, document, merge_key)
        self._document_replaced()

    def edit(
        self, change: Callable[..., Edit], *details: Any, merge_key: str | None = None
    ) -> None:
        """Make an edit of `bozzetto.document.edit` that may refuse; each is one undo step."""
        try:
            document, label = change(self.document, *details)
        except UserError as problem:
            self.complain(problem)
            return
        self._commit(label, document, merge_key)

    def undo(self) -> None:
        """Take back the newest pending stroke, or else the last step."""
        if self.pending:
            self.drop_last_pending()
            return
        self._edits.cancel()
        self._set_live(Scene())
        self.history.undo()
        self._document_replaced()

    def redo(self) -> None:
        """Do again what was taken back."""
        self.history.redo()
        self._document_replaced()

    def go_to(self, index: int) -> None:
        """Jump to a step of the history."""
        self._edits.cancel()
        self.history.go_to(index)
        self._document_replaced()

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
            self._showing.show(self.document, model)

    def set_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        """Change one parameter of the selected model; a slider's drag is one step."""
        model = self.selected_model
        if model is None:
            return
        try:
            if model.locked:
                raise UserError(tr("Session", "This object is locked. Unlock it to change it."))
            changed = self.workbench.set_parameters(model, {name: value})
        except UserError as problem:
            self.complain(problem)
            return
        label = next(
            (field.parameter.label for field, _ in self.parameters if field.name == name), name
        )
        key = f"parameter {model.id} {name}" if dragging else None
        self._commit(label, self.document.with_model(changed), key)

    def end_drag(self) -> None:
        """A slider was let go: the next change is a step of its own."""
        self.history.end_merge()

    def set_placement(self, model_id: str, placement: Placement) -> None:
        """Move a model."""
        self.edit(edit.place_model, model_id, placement)

    def rename(self, model_id: str, name: str) -> None:
        """Call a model something else."""
        self.edit(edit.rename_model, model_id, name)

    def set_visible(self, model_id: str, visible: bool) -> None:
        """Show or hide a model."""
        self.edit(edit.show_model, model_id, visible)

    def set_locked(self, model_id: str, locked: bool) -> None:
        """Lock or unlock a model."""
        self.edit(edit.lock_model, model_id, locked)

    def set_color(self, model_id: str, color: tuple[int, int, int] | None) -> None:
        """Give a model a colour, or the clay again."""
        self.edit(edit.color_model, model_id, color)

    def delete(self, model_id: str) -> None:
        """Take a model out of the document."""
        self.edit(edit.delete_models, [model_id])

    def duplicate(self, model_id: str) -> None:
        """Put a copy of a model beside it."""
        self.edit(edit.duplicate_model, model_id)

    def set_underlay_opacity(
        self, underlay_id: str, opacity: float, *, dragging: bool = False
    ) -> None:
        """Let an underlay shine through more or less."""
        key = f"underlay {underlay_id}" if dragging else None
        self._change_underlay(underlay_id, key, opacity=opacity)

    def set_underlay_visible(self, underlay_id: str, visible: bool) -> None:
        """Show or hide an underlay."""
        self._change_underlay(underlay_id, None, visible=visible)

    def delete_underlay(self, underlay_id: str) -> None:
        """Take an underlay away."""
        self.edit(edit.delete_underlay, underlay_id)

    def _change_underlay(self, underlay_id: str, key: str | None, **changes: Any) -> None:
        for underlay in self.document.underlays:
            if underlay.id == underlay_id:
                self.edit(edit.change_underlay, replace(underlay, **changes), merge_key=key)

    def move_to(self, model_id: str, index: int) -> None:
        """Change a model's place in the list."""
        self.edit(edit.move_model, model_id, index)

    # -- the view --

    def set_camera(self, camera: Camera) -> None:
        """Look from elsewhere."""
        if camera != self.camera:
            self.camera = camera
            self.camera_changed.emit()

    def set_shading(self, shading: Shading) -> None:
        """Show surfaces differently."""
        self.shading = shading
        self.view_style_changed.emit()

    def set_show_grid(self, shown: bool) -> None:
        """Show or hide the ground."""
        self.show_grid = shown
        self.view_style_changed.emit()

    def set_show_ghost_ink(self, shown: bool) -> None:
        """Show or hide processed ink."""
        self.show_ghost_ink = shown
        self._scene = None
        self.view_style_changed.emit()
        self.scene_changed.emit()

    # -- files --

    def open(self, path: Path) -> None:
        """Open a document."""
        self.files.open(path)

    def import_file(self, path: Path) -> None:
        """Bring a drawing, a mesh or a picture onto the sheet."""
        self.files.import_file(path)

    def take_in(self, thing: Model | Underlay, label: str) -> None:
        """Put something new into the document, and select it."""
        if isinstance(thing, Underlay):
            self.edit(edit.add_underlay, thing)
            return
        named = replace(thing, name=self.document.unused_name(thing.name))
        self._showing.await_final(named.id)
        self._commit(label, self.document.with_model(named))
        self.select(named.id)

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
            Ink that was waiting to be committed.
        """
        self._edits.cancel()
        self._previews.cancel()
        self._showing.forget()
        self.history = History(document)
        self._recovered = not saved
        self.path = path
        self.read_only = read_only
        self.pending = pending
        self._selected = None
        self.report = {}
        if document.camera is not None:
            self.set_camera(document.camera.with_viewport(*self.camera.viewport))
        self.pending_changed.emit()
        self._set_live(Scene())
        self._document_replaced()
        self.select(document.models[-1].id if document.models else None)
        self.selection_changed.emit()
        self.opened.emit()

    def saved_as(self, path: Path, snapshot: Document) -> None:
        """Note that a snapshot is on the disk."""
        self.path = path
        self.read_only = False
        self.history.mark_saved(snapshot)
        self._recovered = False
        self.document_changed.emit()

    # -- solving and showing --

    def cancel_work(self) -> None:
        """Stop what is being solved; what was shown stays."""
        self._showing.cancel()
        self.noticed.emit(Notice("info", tr("Session", "Stopped. Nothing was changed.")))

    @property
    def busy(self) -> bool:
        """Whether any work is under way."""
        channels = (self._edits, self._previews, self._showing, self.files)
        return any(channel.busy for channel in channels)

    def _document_replaced(self) -> None:
        if self._selected is not None and self.selected_model is None:
            self._selected = None
            self.report = {}
            self.selection_changed.emit()
            self.report_changed.emit()
        self._scene = None
        self.document_changed.emit()
        self.parameters_changed.emit()
        self._showing.show(self.document, self.selected_model)
        self.scene_changed.emit()

    def _model_shown(self) -> None:
        self._scene = None
        self._set_live(Scene())
        self.scene_changed.emit()

    def _take_report(self, model: Model, report: dict[str, Any]) -> None:
        if model is self.selected_model:
            self.report = report
            self.report_changed.emit()

    # -- saying things --

    def tell(self, text: str) -> None:
        """Say that something went well."""
        self.noticed.emit(Notice("info", text))

    def complain(self, problem: BaseException) -> None:
        """Tell the person about a problem, each kind in its own way."""
        if isinstance(problem, UserError):
            self.noticed.emit(Notice("error", problem.message, problem.places))
        elif isinstance(problem, PluginFault):
            self._set_live(Scene())
            self.noticed.emit(
                Notice("fault", str(problem), plugin=problem.plugin, details=problem.details)
            )
        elif isinstance(problem, TimeoutError):
            self._set_live(Scene())
            fault = self.registry.guard.blame(self.active_modeler, str(problem))
            self.noticed.emit(
                Notice("fault", str(fault), plugin=fault.plugin, details=fault.details)
            )
        else:
            log.error("a bug in the program itself", exc_info=problem)
            self.noticed.emit(
                Notice(
                    "fault",
                    tr("Session", "Bozzetto made a mistake; your drawing is safe."),
                    details="".join(_traceback(problem)),
                )
            )


def _refused(strokes: tuple[Stroke, ...]) -> Scene:
    """Ink that was not understood, in the colour of warnings, until the next stroke."""
    lines = []
    for stroke in strokes:
        camera = stroke.camera
        _, _, forward = camera.axes
        on_sheet = camera.on_plane(stroke.points, camera.target, forward)
        lines.append(Lines(on_sheet, color="warning", width=1.5, hidden="show"))
    return Scene((Layer("refused", tuple(lines)),))


def _traceback(problem: BaseException) -> list[str]:
    import traceback

    return traceback.format_exception(problem)
