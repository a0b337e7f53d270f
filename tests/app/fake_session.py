"""A session without plugins, threads or files: it only notes what it is asked to do."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Document, Model, Underlay
from bozzetto.parameters import Parameter, parameter_fields, set_parameters
from bozzetto.plugin.host.registry import ModelerInfo, PluginInfo
from bozzetto.plugin.part_tree import PartTree
from bozzetto.view.camera import Camera


@dataclass(frozen=True)
class Notice:
    kind: str
    text: str
    places: tuple = ()
    plugin: str = ""
    details: str = ""


@dataclass(frozen=True)
class ToolInfo:
    id: str
    title: str
    icon: Path | None
    hint: str
    gesture: str = "ink"
    tells_next: bool = False
    aims: bool = False


@dataclass(frozen=True)
class State:
    inflation: Annotated[
        float,
        Parameter("Inflation", 0.0, 2.0, 0.01, help="How far the shape swells off the sheet."),
    ] = 1.0
    length: Annotated[float, Parameter("Length", 10.0, 400.0, 1.0, "mm")] = 120.0
    parts: Annotated[int, Parameter("Parts", 1, 12, help="How often the part is repeated.")] = 3
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
            replace(info, status="disabled") if self.disabled.get(info.id) else info
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
    """What the session was asked to do: (name, arguments, keywords)."""

    made: list[tuple[str, tuple, dict]] = field(default_factory=list)

    def named(self, name: str) -> list[tuple[tuple, dict]]:
        return [(args, kwargs) for called, args, kwargs in self.made if called == name]


RECORDED = frozenset(
    "tell undo redo go_to select activate_modeler activate_tool end_drag rename set_visible "
    "set_locked set_color delete duplicate move_to set_underlay_opacity set_underlay_visible "
    "select_part rename_part set_part_visible delete_part duplicate_part move_part group_parts "
    "ungroup_part delete_several delete_underlay cancel_work commit_pending clear_pending "
    "open import_file set_shading".split()
)


class FakeUsing:
    """Two modelers take shapes; what they are given is noted."""

    def __init__(self, icons: Path, calls: _Calls) -> None:
        self.calls = calls
        self.takers = tuple(
            ModelerInfo(f"bozzetto.{name.lower()}", name, "", "", icons, icons)
            for name in ("Mesh", "Symmetry")
        )

    def use(self, *args: object) -> None:
        self.calls.made.append(("use", args, {}))


class FakeSession(QObject):
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

    def __init__(self, icons: Path) -> None:
        super().__init__()
        self.calls = _Calls()
        self.using = FakeUsing(icons, self.calls)
        self.state = State()
        self.history = FakeHistory()
        self.registry = FakeRegistry()
        self.camera = Camera()
        self.pending: tuple = ()
        self.marked_ink: tuple = ()
        self.path: Path | None = None
        self.title = "Horse"
        self.hint = "Draw a closed outline."
        edges = ((0.0, 0.0, 0.0), (80.0, 0.0, 0.0), (0.0, 0.0, -60.0))
        self.document = Document(
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
        self.selected: str | None = "m1"
        self.trees: dict[str, PartTree] = {}
        """Parts by the id of their model; all of one kind of `Piece`."""
        self.modelers = tuple(
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
        self.active_modeler = "bozzetto.silhouette"
        self.tools = (
            ToolInfo("outline", "Outline", icons / "drawing.svg", "Draw a closed outline."),
            ToolInfo("skeleton", "Skeleton", icons / "curvature.svg", "Draw the spine."),
            ToolInfo("cut", "Cut", None, "Draw across the shape to cut it."),
            ToolInfo("erase", "Erase", icons / "eraser.svg", "Draw over what is to go."),
        )
        self.active_tool = "outline"
        self.report: dict[str, Any] = {
            "watertight": True,
            "volume_mm3": 48213.52,
            "outline_deviation_px": 0.41,
            "parts": [
                {"name": "Body", "genus": 0, "closed": True},
                {"name": "Ear", "genus": 1, "closed": False},
            ],
        }

    @property
    def parameters(self) -> tuple:
        if self.selected is None:
            return ()
        return tuple((f, getattr(self.state, f.name)) for f in parameter_fields(State))

    def parts_of(self, model_id: str) -> PartTree | None:
        return self.trees.get(model_id)

    @property
    def chosen_part(self) -> Any:
        tree = self.trees.get(self.selected or "")
        return tree.part(tree.selected) if tree is not None and tree.selected else None

    @property
    def part_parameters(self) -> tuple:
        part = self.chosen_part
        if part is None:
            return ()
        return tuple((f, getattr(part, f.name)) for f in parameter_fields(type(part)))

    def set_part_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        self.calls.made.append(("set_part_parameter", (name, value), {"dragging": dragging}))
        tree = self.trees[self.selected]
        self.trees[self.selected] = tree.valued(tree.selected, {name: value})
        self.parameters_changed.emit()

    def set_parameter(self, name: str, value: object, *, dragging: bool = False) -> None:
        self.calls.made.append(("set_parameter", (name, value), {"dragging": dragging}))
        self.state = set_parameters(self.state, {name: value})
        self.parameters_changed.emit()

    def __getattr__(self, name: str) -> Any:
        if name not in RECORDED:
            raise AttributeError(name)

        def call(*args: object, **kwargs: object) -> None:
            self.calls.made.append((name, args, kwargs))

        return call
