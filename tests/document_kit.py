"""Documents and a pretended registry for the tests of the document's room."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.document.history import History
from bozzetto.document.model import Document, Model, NamedView, OpaqueState, Underlay
from bozzetto.document.waiting_ink import Waiting, WaitingStroke
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.placement import Placement
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.parameters import Parameter
from bozzetto.view.camera import Camera

CAMERA = Camera()
SIDE = Camera(kind="orthographic", eye=(500.0, 0.0, 0.0), viewport=(800.0, 600.0))


@dataclass(frozen=True)
class Disc:
    """One of two things that a mark can be."""

    radius: float
    at: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Line:
    """The other one; it has the same fields."""

    radius: float
    at: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Tree:
    """A type that holds itself."""

    name: str
    children: tuple[Tree, ...] = ()


@dataclass(frozen=True)
class Everything:
    """A state with every kind of field that documents keep."""

    strokes: Strokes = Strokes()
    softness: Annotated[float, Parameter("Softness", 1.25, 2.0)] = 1.4
    cells: Annotated[int, Parameter("Cells", 8, 512)] = 64
    kind: Literal["round", "flat"] = "round"
    closed: bool = False
    note: str = ""
    marks: tuple[Disc | Line, ...] = ()
    best: Stroke | None = None
    camera: Camera = CAMERA
    placement: Placement = Placement()
    mesh: Mesh | None = None
    weights: NDArray[np.float64] = field(default_factory=lambda: frozen([], np.float64))
    flags: NDArray[np.uint8] | None = None
    tree: Tree = Tree("root")
    pair: tuple[int, str | None] = (0, None)


@dataclass(frozen=True)
class Ink:
    """A small state."""

    strokes: Strokes = Strokes()
    thickness: Annotated[float, Parameter("Thickness", 0.0, 10.0)] = 1.0


class FakeRegistry:
    """Knows the two state types above, and whatever else it is given."""

    def __init__(self, **more: tuple[type[Any], int] | None) -> None:
        self.known: dict[str, tuple[type[Any], int] | None] = {
            "test.everything": (Everything, 1),
            "test.ink": (Ink, 1),
        }
        self.known |= {name.replace("__", "."): value for name, value in more.items()}

    def state_type(self, modeler_id: str) -> tuple[type[Any], int] | None:
        return self.known.get(modeler_id)

    def upgrade(self, modeler_id: str, state: dict[str, Any], version: int) -> dict[str, Any]:
        return {**state, "upgraded_from": version}

    def sources(self, modeler_id: str, state: Any) -> tuple[str, ...]:
        return ()


def stroke(seed: int = 0, count: int = 12, camera: Camera = CAMERA, **more: Any) -> Stroke:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0, 900, (2, count))
    return Stroke(x, y, camera, **more)


def full_stroke(seed: int = 0, count: int = 9) -> Stroke:
    rng = np.random.default_rng(seed)
    return stroke(
        seed,
        count,
        SIDE,
        pressure=rng.uniform(0, 1, count),
        t=np.sort(rng.uniform(0, 2, count)),
        tilt_x=rng.uniform(-60, 60, count),
        tilt_y=rng.uniform(-60, 60, count),
        twist=rng.uniform(0, 360, count),
        tool="eraser",
        color=(1, 2, 250),
        group="rim",
    )


def mesh(seed: int = 0) -> Mesh:
    rng = np.random.default_rng(seed)
    return Mesh(
        rng.normal(0, 50, (7, 3)).astype(np.float32),
        rng.integers(0, 7, (5, 3)).astype(np.int32),
        colors=rng.integers(0, 256, (7, 4)).astype(np.uint8),
    )


def everything(seed: int = 0) -> Everything:
    best = full_stroke(seed)
    return Everything(
        Strokes([stroke(seed + 1), best, stroke(seed + 2, 1)]),
        1.75,
        17,
        "flat",
        True,
        "naïve “text” ✎ \u0000",
        (Disc(1.5), Line(2.5, (-0.0, 5e-324)), Disc(1e300)),
        best,
        SIDE,
        Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.0, (1.0, 2.0, 3.0)),
        mesh(seed),
        frozen([[0.1, 1 / 3], [1e-300, -7.0]], np.float64),
        frozen([1, 0, 255], np.uint8),
        Tree("a", (Tree("b"), Tree("c", (Tree("d"),)))),
        (-(2**63) + 1, "x"),
    )


def underlay(name: str = "Scan") -> Underlay:
    pixels = np.random.default_rng(5).integers(0, 256, (6, 9, 4)).astype(np.uint8)
    corners = (0.0, 0.0, 90.0), (90.0, 0.0, 0.0), (0.0, 0.0, -60.0)
    return Underlay("scan", name, pixels, *corners, opacity=0.25, visible=False)


def waiting_ink(seed: int = 50) -> Waiting:
    """One stroke of every status; the modeler of one is absent."""
    return (
        WaitingStroke(full_stroke(seed), "test.ink", "draw"),
        WaitingStroke(stroke(seed + 1), "test.ink", "draw", "unfinished", "Close it."),
        WaitingStroke(
            stroke(seed + 2, 3),
            "absent.modeler",
            "cut",
            "refused",
            "It crosses itself at “x”.",
            ((0.1, 1 / 3), (-7.0, 1e6)),
        ),
        WaitingStroke(stroke(seed + 3, 1), "", "", "failed", "“Test” made a mistake."),
    )


def rich_document() -> Document:
    """Every kind of part, a model of an absent plugin among them."""
    opaque = OpaqueState(
        7, b'{ "odd" :  [1e2, null] }', (full_stroke(40),), (frozen([1.5, 2.5], np.float32),)
    )
    return Document(
        (
            Model("m1", "Body", "test.everything", everything()),
            Model("m2", "Handle", "absent.modeler", opaque, locked=True, state_version=7),
            Model(
                "m3", "Ink", "test.ink", Ink(Strokes([stroke(9)])), visible=False, color=(9, 8, 7)
            ),
        ),
        (NamedView("Side", SIDE), NamedView("Front", CAMERA)),
        (underlay(),),
        SIDE,
        (("notes/readme.txt", b"not ours"), ("plugins/absent.modeler/m2/extra.bin", b"\x00\xff")),
        waiting_ink(),
    )


def same_state(first: Any, second: Any) -> bool:
    """Equality that looks into arrays, meshes and closed states."""
    if isinstance(first, Stroke):
        return bool(first == second)
    if isinstance(first, np.ndarray):
        return (
            isinstance(second, np.ndarray)
            and first.dtype == second.dtype
            and first.shape == second.shape
            and first.tobytes() == second.tobytes()
        )
    if type(first) is not type(second):
        return False
    if hasattr(first, "__dataclass_fields__"):
        return all(
            same_state(getattr(first, name), getattr(second, name))
            for name in first.__dataclass_fields__
        )
    if isinstance(first, tuple):
        return len(first) == len(second) and all(map(same_state, first, second))
    if isinstance(first, float):
        return first.hex() == second.hex()
    return bool(first == second)


def same_document(first: Document, second: Document) -> bool:
    return (
        len(first) == len(second)
        and all(map(same_state, first, second))
        and same_state(first.views, second.views)
        and same_state(first.underlays, second.underlays)
        and same_state(first.camera, second.camera)
        and sorted(first.foreign) == sorted(second.foreign)
        and same_state(first.waiting, second.waiting)
    )


def documents_of(history: History) -> list[Document]:
    """All snapshots of a history, in the order of its entries; where it stands does not change."""
    walker = copy(history)
    return [walker.go_to(place) for place in range(len(history.entries))]
