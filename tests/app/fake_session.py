"""Sessions without plugins, threads or files: they only note what they are asked to do."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import structs
from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Document, Model, Underlay
from bozzetto.errors import UserError
from bozzetto.parameters import Parameter, set_parameters
from bozzetto.plugin.figures import Figure
from bozzetto.plugin.host.registry import ModelerInfo, PluginInfo
from bozzetto.plugin.next_step import NextStep
from bozzetto.plugin.part_tree import PartTree
from bozzetto.scene.display_list import Scene
from bozzetto.view.camera import Camera
from bozzetto_app.session import tool_groups
from bozzetto_app.session.notices import Notice
from bozzetto_app.session.object_edits import fields_of
from bozzetto_app.session.view_state import ViewState

__all__ = ["EmptySession", "FakeSession", "Notice", "ToolInfo", "horse_parts"]


def ToolInfo(
    id: str, title: str, icon: Path | None, hint: str, gesture: Any = "ink", **more: Any
) -> tool_groups.ToolInfo:
    return tool_groups.ToolInfo(id, title, icon, hint, gesture, **more)


@dataclass(frozen=True)
class State:
    inflation: Annotated[
        float,
        Parameter("Inflation", 0.0, 2.0, 0.01, help="How far the shape swells off the sheet."),
    ] = 1.0
    length: Annotated[float, Parameter("Length", 10.0, 400.0, 1.0, "mm")] = 120.0
    parts: Annotated[
        int,
        Parameter(
            "Parts",
            1,
            12,
            help="How often the part is repeated.",
            idle_while=(("ends", ("open",)),),
        ),
    ] = 3
    mirrored: Annotated[bool, Parameter("Mirrored", help="Repeat the shape on the far side.")] = (
        True
    )
    ends: Annotated[
        Literal["round", "flat", "open"],
        Parameter("Ends", choices=(("round", "Round"), ("flat", "Flat"), ("open", "Open"))),
    ] = "round"
    material: Annotated[
        Literal["clay", "plaster of Paris", "wax", "bronze", "stone"], Parameter("Material")
    ] = "clay"
    note: Annotated[str, Parameter("Note")] = ""
    resolution: Annotated[
        int, Parameter("Resolution", 16, 256, 8, "cells", "Finer is slower.", advanced=True)
    ] = 64
    tolerance: Annotated[float, Parameter("Tolerance", 0.001, None, 0.001, "mm", advanced=True)] = (
        0.05
    )


@dataclass(frozen=True)
class Piece:
    id: str
    name: str
    visible: bool = True
    within: str = ""
    operation: Annotated[
        Literal["add", "merge", "carve", "intersect"],
        Parameter("Operation", choices=(("add", "Add"), ("carve", "Carve"))),
    ] = "add"
    color: Annotated[tuple[int, int, int] | None, Parameter("Colour", help="Of this part.")] = None
    softness: Annotated[float, Parameter("Softness", 0.0, 2.0, 0.05)] = 0.5
    kernel: Annotated[Literal["fine", "coarse"], Parameter("Kernel", advanced=True)] = "fine"


def horse_parts() -> PartTree:
    """Six parts and a group of two in them."""
    parts = (
        Piece("n1", "Body"),
        Piece("n2", "Head", operation="merge"),
        Piece("g1", "Legs"),
        Piece("n3", "Left leg", within="g1"),
        Piece("n4", "Right leg", within="g1", visible=False),
        Piece("n5", "Saddle pit", operation="carve"),
        Piece("n6", "Flank", operation="intersect"),
    )
    return PartTree(parts, frozenset({"g1"}), "n2")


class FakeHistory:
    def __init__(self) -> None:
        self.entries = ("New drawing", "Outline", "Ear", "Inflation")
        self.position = 2


class FakeRegistry:
    def __init__(self) -> None:
        self.disabled: dict[str, bool] = {}
        self.infos = [
            PluginInfo(
                "bozzetto.silhouette",
                "Silhouette",
                "A closed outline becomes a solid in the round.",
                "0.1.0",
                "bozzetto_silhouette",
                "loaded",
            ),
            PluginInfo(
                "maria.lathe",
                "Lathe",
                "A profile turns about an axis.",
                "1.3.2",
                "maria_lathe",
                "ready",
            ),
            PluginInfo(
                "acme.foam",
                "Foam",
                "Bubbles from dots.",
                "0.0.9",
                "acme_foam",
                "broken",
                "Its code could not be imported: No module named 'acme_core'.",
                "Traceback (most recent call last):\n  File …\nModuleNotFoundError: acme_core",
            ),
        ]

    def plugins(self) -> tuple[PluginInfo, ...]:
        return tuple(
            structs.replace(info, status="disabled") if self.disabled.get(info.id) else info
            for info in self.infos
        )

    def set_disabled(self, plugin_id: str, disabled: bool) -> None:
        self.disabled[plugin_id] = disabled


def _picture(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    pixels = np.full((60, 80, 4), 255, np.uint8)
    pixels[..., :3] = rng.integers(120, 220, 3)
    pixels[20:44, 16:60, :3] = rng.integers(40, 120, 3)
    return pixels


@dataclass
class _Calls:
    """What a session was asked to do: (part.method, arguments, keywords)."""

    made: list[tuple[str, tuple, dict]] = field(default_factory=list)

    def named(self, name: str) -> list[tuple[tuple, dict]]:
        return [(args, kwargs) for called, args, kwargs in self.made if called == name]


class Part(QObject):
    """A part of a session; every call of `recorded` is noted."""

    recorded = ""

    def __init__(self, calls: _Calls, **state: Any) -> None:
        super().__init__()
        self._calls = calls
        vars(self).update(state)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in type(self).recorded.split():
            raise AttributeError(name)

        def call(*args: object, **kwargs: object) -> None:
            self._calls.made.append((f"{type(self).__name__.lower()}.{name}", args, kwargs))

        return call


class Drawing(Part):
    changed = Signal()
    waiting_changed = Signal()
    opened = Signal()
    models_changed = Signal()
    taken = Signal(str, object)
    jumped = Signal(object)
    closing = Signal(object)
    recorded = "undo redo go_to"


class Selection(Part):
    changed = Signal()
    recorded = "select"

    @property
    def model(self) -> Model | None:
        found = getattr(self.drawing, "document", ())
        return next((model for model in found if model.id == self.id), None)


class Toolbox(Part):
    modeler_changed = Signal()
    tool_changed = Signal()
    recorded = "take_modeler take_tool"

    def __init__(self, *given: Any, **values: Any) -> None:
        super().__init__(*given, **values)
        self.last_used: dict[str, str] = {}

    def hold(self, held: bool) -> None:
        """Every end of a gesture calls it."""

    @property
    def groups(self) -> tuple[tool_groups.ToolGroup, ...]:
        return tool_groups.groups_of(self.tools)

    @property
    def active(self) -> Any:
        return next((tool for tool in self.tools if tool.id == self.tool), None)


class DisplayedScene(Part):
    changed = Signal()
    live_changed = Signal()

    def show(self, scene: Scene) -> None:
        self.visible = scene
        self.changed.emit()


class Advice(Part):
    """What a modeler says of the view: whatever a test wants."""

    changed = Signal()

    def holds_eye(self, camera: Camera) -> bool:
        return self.advice is not None and self.advice.pinned

    def say(self, advice: Any) -> None:
        self.advice = advice
        self.changed.emit()


class Solver(Part):
    changed = Signal(str, bool)
    busy_changed = Signal(bool)
    settled = Signal(str)
    report_changed = Signal()

    def expect_paint(self, paints: bool) -> None:
        pass

    def frame_painted(self) -> None:
        pass


class Hints(Part):
    changed = Signal()

    def say(self, sentence: str, **more: Any) -> None:
        self.step = NextStep(sentence, **more)
        self.changed.emit()


class Notices(Part):
    noticed = Signal(object)
    caught_up = Signal()
    recorded = "tell complain"


class Pictures(Part):
    taken = Signal(str)
    recorded = "take_file take_image take_underlay"
    sketch_taker = ""


class Placing(Part):
    """No underlay is chosen."""

    changed = Signal()
    recorded = "choose leave cancel touch begin_alignment handle_moved handle_released"
    underlay = place = None
    is_aligning = False
    wish = ""


class Work(Part):
    """A channel in which nothing is under way."""

    busy_changed = Signal(bool)
    busy = False


class Gestures(Part):
    recorded = (
        "stroke_moved stroke_lifted cancel commit clear drop_last explain tap tap_moved "
        "handle_moved handle_released"
    )


class Files(Part):
    recorded = "open open_safely"


class Exchange(Part):
    recorded = "import_file import_files"


class Motion(Part):
    """Nothing moves by itself."""

    changed = Signal()
    pace_changed = Signal(object)
    recorded = "play stop"


class Shapes(Part):
    """Two modelers take shapes."""

    recorded = "use"


class Objects(Part):
    copied = Signal()
    recorded = (
        "end_drag rename set_visible set_locked set_color delete duplicate move_to "
        "set_underlay_opacity set_underlay_visible delete_underlay set_placement"
    )

    @property
    def parameters(self) -> tuple:
        return fields_of(self.session.state) if self.session.selection.id is not None else ()

    def set_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        self._calls.made.append(("objects.set_parameter", (name, value), {"dragging": dragging}))
        self.session.state = set_parameters(self.session.state, {name: value})
        self.session.selection.changed.emit()


class Parts(Part):
    recorded = (
        "select rename set_visible delete duplicate move group ungroup delete_several set_value"
    )

    def of(self, model_id: str) -> PartTree | None:
        return self.session.trees.get(model_id)

    def of_model(self, model: Model) -> PartTree | None:
        return self.of(model.id)

    @property
    def chosen(self) -> Any:
        tree = self.session.trees.get(self.session.selection.id or "")
        return tree.part(tree.selected) if tree is not None and tree.selected else None

    @property
    def parameters(self) -> tuple:
        return fields_of(self.chosen)

    def set_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        self._calls.made.append(("parts.set_parameter", (name, value), {"dragging": dragging}))
        chosen, trees = self.session.selection.id, self.session.trees
        trees[chosen] = trees[chosen].valued(trees[chosen].selected, {name: value})
        self.session.selection.changed.emit()


PARTS = {
    "drawing": Drawing,
    "selection": Selection,
    "toolbox": Toolbox,
    "scene": DisplayedScene,
    "advice": Advice,
    "solver": Solver,
    "notices": Notices,
    "hints": Hints,
    "pictures": Pictures,
    "pictures.placing": Placing,
    "gestures": Gestures,
    "files": Files,
    "shapes": Shapes,
    "objects": Objects,
    "parts": Parts,
}
"""By the names that they have in a session."""


class _NoPlugins:
    """A registry without any plugin."""

    def info(self, modeler: str) -> ModelerInfo:
        raise UserError(f"There is no modeler called {modeler}.")


class EmptySession(QObject):
    """A session with nothing on its sheet, and three tools without a modeler."""

    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self) -> None:
        super().__init__()
        self.calls = calls = _Calls()
        self.registry: Any = _NoPlugins()
        self.view = ViewState()
        self.view.camera = Camera()
        self.view.show_grid = False
        self.drawing = Drawing(
            calls, document=Document(), pending=(), marked_ink=(), is_dragging=False
        )
        self.selection = Selection(calls, drawing=self.drawing, id=None)
        self.toolbox = Toolbox(
            calls,
            modeler="",
            tool="draw",
            tools=tuple(
                ToolInfo(id, id, None, "", gesture)
                for id, gesture in (("draw", "ink"), ("mark", "tap"), ("edit", "drag"))
            ),
        )
        self.scene = DisplayedScene(
            calls, visible=Scene(), live=Scene(), advice=Scene(), busy=False
        )
        self.advice = Advice(calls, advice=None, about=None, may_follow=False)
        self.solver = Solver(calls, report={}, figures={})
        self.notices, self.hints = Notices(calls), Hints(calls, step=NextStep(""))
        self.pictures, self.gestures, self.files = Pictures(calls), Gestures(calls), Files(calls)
        self.files.exchange, self.pictures.placing = Exchange(calls), Placing(calls)
        self.gestures.edits, self.hints.channel = Work(calls), Work(calls)
        self.gestures.motion = Motion(calls, is_playing=False, can_play=False, player="")

    def cancel_work(self) -> None:
        self.calls.made.append(("cancel_work", (), {}))

    def escape(self) -> bool:
        self.calls.made.append(("escape", (), {}))
        return bool(self.drawing.pending)

    def first(self, name: str) -> list[Any]:
        """The first arguments of all calls of a method."""
        return [args[0] for args, _ in self.calls.named(name)]

    @property
    def strokes(self) -> list[Any]:
        return self.first("gestures.stroke_lifted")


class FakeSession(EmptySession):
    """A session with four objects, two underlays and five modelers."""

    def __init__(self, icons: Path) -> None:
        super().__init__()
        calls = self.calls
        self.state = State()
        self.trees: dict[str, PartTree] = {}
        """Parts by the id of their model; all of one kind of `Piece`."""
        self.registry = FakeRegistry()
        self.objects = Objects(calls, session=self)
        self.parts = Parts(calls, session=self)
        self.shapes = Shapes(
            calls,
            takers=tuple(
                ModelerInfo(f"bozzetto.{name.lower()}", name, "", "", icons, icons)
                for name in ("Mesh", "Symmetry")
            ),
        )
        edges = ((0.0, 0.0, 0.0), (80.0, 0.0, 0.0), (0.0, 0.0, -60.0))
        self.drawing.history = FakeHistory()
        self.drawing.path, self.drawing.title = None, "Horse"
        self.hints.step = NextStep("Draw a closed outline.")
        self.drawing.document = Document(
            models=(
                Model("m1", "Horse", "bozzetto.silhouette", State()),
                Model("m2", "Saddle", "bozzetto.silhouette", State(), color=(0x9C, 0x5B, 0x3C)),
                Model("m3", "Rider", "bozzetto.silhouette", State(), visible=False),
                Model("m4", "Plinth", "bozzetto.silhouette", State(), locked=True),
            ),
            underlays=(
                Underlay("u1", "Side view.jpg", _picture(1), *edges, opacity=0.5),
                Underlay("u2", "Front.png", _picture(2), *edges, opacity=0.3, visible=False),
            ),
        )
        self.selection.id = "m1"
        self.toolbox.modelers = tuple(
            ModelerInfo(
                f"bozzetto.{name.lower()}",
                name,
                "Draw.",
                f"bozzetto.{name.lower()}",
                icons,
                icons / f"{glyph}.svg",
                samples=tuple(Path(f"/samples/{s.lower()}.json") for s in samples),
                sample_titles=samples,
            )
            for name, glyph, samples in (
                ("Silhouette", "drawing", ("Horse", "Fish", "Key")),
                ("Symmetry", "symmetry", ("Glasses", "Chair")),
                ("Car", "curvature", ("Coupé",)),
                ("Product", "cube", ()),
                ("Polyhedron", "perspective", ()),
            )
        )
        self.toolbox.modeler = "bozzetto.silhouette"
        self.toolbox.tools = (
            ToolInfo("outline", "Outline", icons / "drawing.svg", "Draw a closed outline."),
            ToolInfo("skeleton", "Skeleton", icons / "curvature.svg", "Draw the spine."),
            ToolInfo("cut", "Cut", None, "Draw across the shape to cut it."),
            ToolInfo("erase", "Erase", icons / "eraser.svg", "Draw over what is to go."),
        )
        self.toolbox.tool = "outline"
        self.solver.figures = {
            "watertight": Figure("Watertight", "Without a gap", good=True, bad=False),
            "genus": Figure("Holes", "Holes that go through it (genus)"),
        }
        self.solver.report = {
            "watertight": True,
            "volume_mm3": 48213.52,
            "outline_deviation_px": 0.41,
            "parts": [
                {"name": "Body", "genus": 0, "closed": True},
                {"name": "Ear", "genus": 1, "closed": False},
            ],
        }
