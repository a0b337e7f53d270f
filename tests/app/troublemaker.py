"""A modeler of boxes that behaves, except where a test has something else for it to do."""

from __future__ import annotations

import textwrap
import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from bozzetto.errors import Unfinished
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto.ink import Strokes
from bozzetto.plugin import Modeler, Parameter, Tool
from bozzetto.scene import Layer, Lines, Scene, Shaded
from tests import plugin_package

MODELER = "trouble.boxes"
PLUGIN = "trouble.plugin"

UNLUCKY = 13.0
"""A size within the range of its parameter that the state itself does not take."""

OPEN_GAP = 60.0
"""Distance between a stroke's ends from which it counts as open, pixels."""

MANIFEST = f"""
id = "{PLUGIN}"
title = "Troublemaker"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "{MODELER}"
title = "Boxes"
icon = "icon.svg"
hint = "Draw around a box."
abilities = ["panel", "read_shapes"]
order = 90
"""

CODE = """
from bozzetto.plugin import hookimpl

given = []

@hookimpl
def bozzetto_modelers():
    return given

@hookimpl
def bozzetto_panel(modeler_id, parent):
    return given[0].do("panel", lambda: None, modeler_id, parent)
"""


def write_package(folder: Path, name: str) -> None:
    """Write the plugin's package, without its modeler."""
    plugin_package.write(folder, name, MANIFEST, textwrap.dedent(CODE))


@dataclass(frozen=True)
class BoxesState:
    strokes: Strokes = Strokes()
    size: Annotated[float, Parameter("Size", 1.0, 100.0)] = 10.0
    table: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.size == UNLUCKY:
            raise ZeroDivisionError("a size that the author did not think of")


def box(size: float, at: float) -> Mesh:
    """An axis-aligned closed box whose faces look outwards."""
    corners = np.array(
        [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)], np.float32
    )
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    offset = np.array((at, 0.0, 0.0), np.float32)
    return Mesh(np.float32(size) * corners + offset, np.array(faces, np.int32))


class DrawBox(Tool[BoxesState]):
    """A closed stroke is a box."""

    id, title, icon, hint, gesture = "draw", "Draw", "", "Draw around a box.", "ink"

    def __init__(self, owner: Boxes) -> None:
        self.owner = owner

    def preview(self, state, gesture, context):
        def well():
            return Scene((Layer("preview", (Lines(np.zeros((2, 3), np.float32)),)),))

        return self.owner.do("preview", well, state, gesture, context)

    def erase(self, state, gesture, context):
        return self.draw(state, gesture, context)

    def tap(self, state, gesture, context):
        return self.owner.do("apply", lambda: state, state, gesture, context)

    def draw(self, state, gesture, context):
        def well():
            first, last = gesture.strokes[0].points[0], gesture.strokes[-1].points[-1]
            if not gesture.committed and np.hypot(*(last - first)) > OPEN_GAP:
                raise Unfinished("Close the box, or press Enter.")
            return BoxesState(state.strokes.extended(gesture.strokes), state.size)

        return self.owner.do("apply", well, state, gesture, context)


class Boxes(Modeler[BoxesState, list[Mesh]]):
    """The modeler. `misdeeds` maps the name of a function to what it does instead."""

    id, state_type, state_version = MODELER, BoxesState, 2

    def __init__(self) -> None:
        self.misdeeds: dict[str, Callable[..., Any]] = {}
        self.calls: Counter[str] = Counter()
        self.threads: set[threading.Thread] = set()

    def do(self, what: str, well: Callable[[], Any], *arguments: Any) -> Any:
        self.calls[what] += 1
        self.threads.add(threading.current_thread())
        return self.misdeeds[what](*arguments) if what in self.misdeeds else well()

    def create(self, context):
        return self.do("create", BoxesState, context)

    def tools(self):
        return self.do("tools", lambda: (DrawBox(self),))

    def read_drawing(self, drawing, context, job):
        return self.do("read_drawing", lambda: BoxesState(drawing.strokes), drawing, context, job)

    def read_shapes(self, shapes):
        return self.do("read_shapes", BoxesState, shapes)

    def solve(self, state, job):
        def well():
            return [box(state.size, 2.0 * state.size * k) for k in range(len(state.strokes))]

        return self.do("solve", well, state, job)

    def scene(self, state, result):
        def well():
            ghost = Layer("ink", (Lines(np.zeros((2, 3), np.float32), color="ghost"),))
            shape = Layer("shape", tuple(Shaded(mesh) for mesh in result or ()))
            return Scene((shape, ghost) if len(state.strokes) else ())

        return self.do("scene", well, state, result)

    def shapes(self, state, result):
        def well():
            return Shapes(solids=tuple(Solid(mesh) for mesh in result))

        return self.do("shapes", well, state, result)

    def report(self, state, result, job):
        return self.do("report", lambda: {"boxes": len(result)}, state, result, job)

    def upgrade(self, state, version):
        return self.do("upgrade", lambda: state, state, version)
