"""The session: what the window is about, without a widget in it.

One document with its history, the active modeler, model and tool, the ink that waits to be
committed, the view, and the work that is under way. Widgets read it, call its methods and
listen to its signals; they never change a document themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import QObject, Signal

__all__ = ["Notice", "Session"]


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


class Session(QObject):
    """STUB: signatures only; being implemented.

    Signals
    -------
    document_changed   the snapshot was replaced (also: saved state, path, title)
    selection_changed  another model is selected (or none)
    modeler_changed    another modeler is active (its tools are other ones)
    tool_changed       another tool is active
    parameters_changed the selected model's parameters differ
    scene_changed      the display list differs
    live_changed       what is shown only while the pen is down differs (`live_scene`)
    pending_changed    strokes waiting for commitment differ
    camera_changed     the view moved
    view_style_changed shading, grid, ghost ink, uncertainty switched
    noticed(Notice)    something to say
    progressed(float, str)  long work advanced;  busy_changed(bool)
    report_changed     figures of the selected model's result (`report`)
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

    # -- reading ---------------------------------------------------------------------------
    # document: Document                    the snapshot shown now
    # history: bozzetto.document.history.History   (entries, undo_label, redo_label …)
    # registry: bozzetto.plugin.registry.Registry
    # workbench: bozzetto.workbench.Workbench
    # path: Path | None; title: str; is_modified: bool; read_only: bool
    # modelers: tuple[ModelerInfo, ...]     id, title, icon (Path to svg), hint, samples
    # active_modeler: str ("" = none)
    # tools: tuple[ToolInfo, ...]           id, title, icon (Path | None), hint, gesture
    # active_tool: str
    # selected: str | None                  model id
    # camera: Camera
    # scene: Scene; live_scene: Scene
    # pending: tuple[Stroke, ...]
    # parameters: tuple[(Field, value), ...] of the selected model (else of none)
    # report: dict[str, Any]
    # hint: str
    # shading: "clay"|"zebra"|"curvature"|"normals"|"xray"; show_grid; show_ghost_ink: bool

    # -- the pen (called by the canvas) ------------------------------------------------------
    # pen_moved(stroke: Stroke)             the stroke so far, at most 30 times a second
    # pen_lifted(stroke: Stroke)            the stroke is complete
    # pen_cancelled()                       Esc, or navigation took over
    # tapped(x, y, *, shift, ctrl)
    # handle_moved(handle_id, path: Stroke, *, shift, ctrl);  handle_released(…same…)
    # commit_pending(); drop_last_pending(); clear_pending()

    # -- the panels (each is one undo step, or refuses with a notice) -------------------------
    # undo(); redo(); go_to(index)
    # select(model_id | None); activate_modeler(id); activate_tool(id)
    # set_parameter(name, value, *, dragging: bool)   a drag of a slider is one step
    # end_drag()
    # rename(model_id, name); set_visible(model_id, bool); set_locked(model_id, bool)
    # set_color(model_id, rgb | None); delete(model_id); duplicate(model_id)
    # move_to(model_id, index)
    # set_underlay_opacity(id, value, *, dragging); set_underlay_visible; delete_underlay
    # set_shading(name); set_show_grid(bool); set_show_ghost_ink(bool)
    # set_camera(camera); look(name) ("front", "right", …, animated by the canvas); fit()
    # cancel_work()

    # -- files --------------------------------------------------------------------------------
    # new(); open(path); save(path | None) -> bool; export(path); import_file(path)
    # open_sample(path); play_sample(path)
