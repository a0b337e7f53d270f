"""Plugins made up for tests: packages on a disk, and a modeler that misbehaves on demand."""

from __future__ import annotations

import importlib
import itertools
import sys
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest

from bozzetto.geometry import Mesh, Shapes, Surface
from bozzetto.ink import Strokes
from bozzetto.plugin import Ink, Modeler, Parameter, Tool
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Layer, Lines, Scene
from bozzetto.testing import Shell
from bozzetto.testing.lint import check_package
from bozzetto.testing.subject import Subject

_numbers = itertools.count(1)

GOOD_MANIFEST = """
id = "{author}.plugin"
title = "Plugin"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "{author}.modeler"
title = "Modeler"
icon = "icon.svg"
hint = "Draw."
"""

ICON = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 20 20"><path d="M2 2h16"/></svg>'


@pytest.fixture
def make_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A function that writes a package of a fresh name and gives that name."""
    root = tmp_path / "packages"
    root.mkdir(exist_ok=True)
    monkeypatch.syspath_prepend(root)
    made: list[str] = []

    def make(code: str = "", manifest: str | None = GOOD_MANIFEST, name: str = "") -> str:
        name = name or f"made_up_{next(_numbers)}"
        folder = root / name
        folder.mkdir()
        (folder / "__init__.py").write_text(textwrap.dedent(code))
        (folder / "icon.svg").write_text(ICON)
        if manifest is not None:
            (folder / "plugin.toml").write_text(manifest.replace("{author}", name))
        importlib.invalidate_caches()
        made.append(name)
        return name

    yield make
    for name in made:
        sys.modules.pop(name, None)


@dataclass(frozen=True)
class FaultyState:
    strokes: Strokes = Strokes()
    size: Annotated[float, Parameter("Size", 0.0, 10.0)] = 1.0
    table: tuple[float, ...] = (1.0, 2.0)


class FaultyTool(Tool[FaultyState]):
    id, title, icon, hint, gesture = "draw", "Draw", "", "Draw.", "ink"

    def __init__(self, owner: Faulty) -> None:
        self.owner = owner

    def preview(self, state, gesture, context):
        return self.owner.do("preview", Scene, state, gesture, context)

    def draw(self, state, gesture, context):
        def well():
            assert isinstance(gesture, Ink)
            return FaultyState(state.strokes.extended(gesture.strokes), state.size)

        return self.owner.do("apply", well, state, gesture, context)


class Faulty(Modeler[FaultyState, float]):
    """A modeler that does well, except where `misdeeds` has something else for it to do."""

    id, state_type, state_version = "faulty.modeler", FaultyState, 2

    def __init__(self) -> None:
        self.misdeeds: dict[str, Callable[..., Any]] = {}

    def do(self, what: str, well: Callable[[], Any], *arguments: Any) -> Any:
        return self.misdeeds[what](*arguments) if what in self.misdeeds else well()

    def create(self, context):
        return self.do("create", FaultyState, context)

    def tools(self):
        return self.do("tools", lambda: (FaultyTool(self),))

    def solve(self, state, job):
        return self.do("solve", lambda: state.size * len(state.strokes), state, job)

    def scene(self, state, result):
        def well():
            layer = Layer("all", (Lines(np.zeros((2, 3))),)) if len(state.strokes) else Layer("")
            return Scene((layer,))

        return self.do("scene", well, state, result)

    def shapes(self, state, result):
        def well():
            if not len(state.strokes):
                return Shapes()
            return Shapes(surfaces=(Surface(Mesh(result * np.eye(3), [[0, 1, 2]])),))

        return self.do("shapes", well, state, result)

    def report(self, state, result, job):
        return self.do("report", lambda: {"size": result}, state, result, job)

    def read_shapes(self, shapes):
        return self.do("read_shapes", FaultyState, shapes)

    def upgrade(self, state, version):
        return self.do("upgrade", lambda: state, state, version)


class ReadingFaulty(Faulty):
    def read_drawing(self, drawing, context, job):
        return self.do("read_drawing", lambda: FaultyState(drawing.strokes), drawing, context, job)


FAULTY_MANIFEST = """
id = "faulty.plugin"
title = "Faulty"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "faulty.modeler"
title = "Faulty"
icon = "icon.svg"
hint = "Draw."
abilities = ["panel", "read_shapes"]
"""

FAULTY_CODE = """
from bozzetto.plugin import hookimpl

given = []

@hookimpl
def bozzetto_modelers():
    return given

@hookimpl
def bozzetto_panel(modeler_id, parent):
    return given[0].do("panel", lambda: (modeler_id, parent))
"""


@pytest.fixture
def faulty(make_package) -> ReadingFaulty:
    """A modeler in a package of its own; `faulty.package` is its name."""
    package = make_package(FAULTY_CODE, FAULTY_MANIFEST)
    modeler = ReadingFaulty()
    importlib.import_module(package).given.append(modeler)
    modeler.package = package
    return modeler


@pytest.fixture
def workshop(faulty: Faulty, tmp_path: Path) -> Shell:
    """A shell with an empty model of the faulty modeler."""
    folder = tmp_path / "documents"
    folder.mkdir()
    shell = Shell(Registry(extra=[faulty.package]), folder)
    shell.open("faulty.modeler")
    return shell


@pytest.fixture
def subject(faulty):
    return Subject("faulty.modeler", (faulty.package,))


def messages(package: str) -> str:
    """What a check of a package says, a line a finding."""
    return "\n".join(map(str, check_package(package)))
