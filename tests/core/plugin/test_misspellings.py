"""Every kind of misspelling in a plugin is told by name: by `plugins check`, and by mypy."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import pytest

from tests.core.plugin.conftest import messages

MANIFEST = """
id = "{author}.plugin"
title = "Misspelt"
version = "1.0"
api = ">=2,<3"
sumary = "A summary."

[[modeler]]
id = "{author}.modeler"
title = "Misspelt"
icon = "icon.svg"
hint = "Draw."
sampels = []
ordre = 3
"""

CODE = """
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from bozzetto.geometry import Shapes
from bozzetto.plugin import (
    Context, Drag, Gesture, Ink, Job, Modeler, Parameter, Part, PartsModeler, PartsState, Preview,
    Tap, Tool, hookimpl, override,
)
from bozzetto.scene import Scene

@dataclass(frozen=True)
class State(PartsState):
    nodes: tuple[Part, ...] = ()
    width: Annotated[float, Parameter("Width", 0.0, 9.0)] = 1.0

class Draw(Tool[State]):
    id, title = "draw", "Draw"
    hnit = "Draw a line."
    Gesture = "ink"
    @override
    def apply(self, state: State, gesture: Gesture, context: Context) -> State:
        return state
    @override
    def draw(self, state: State, ink: Ink) -> State:
        return state
    @override
    def earse(self, state: State, ink: Ink, context: Context) -> State:
        return state
    @override
    def taps(self, state: State, tap: Tap, context: Context) -> State:
        return state
    @override
    def darg(self, state: State, drag: Drag, context: Context) -> State:
        return state
    @override
    def begn(self, state: State, context: Context) -> Preview[State]:
        return Preview(self, state, context)
    @override
    def nextstep(self, state: State) -> Any:
        return None
    @override
    def preview(self, state: State, gesture: Gesture, context: Context, more: int) -> Scene:
        return Scene()

class Growing(Preview[State]):
    @override
    def updates(self, gesture: Gesture) -> Scene:
        return Scene()

class Misspelt(PartsModeler[State, float]):
    id, state_type, part_types = __name__ + ".modeler", State, (Part,)
    state_verison = 2
    first_parameters = ("widht",)
    figure = {}
    @override
    def tools(self) -> Sequence[Tool[State]]:
        return (Draw(),)
    @override
    def solve(self, state: State, job: Job, fast: bool) -> float:
        return 1.0
    @override
    def scene(self, state: State) -> Scene:
        return Scene()
    @override
    def shapes(self, state: State, result: float) -> Shapes:
        return Shapes()
    @override
    def reports(self, state: State, result: float) -> Any:
        return {}
    @override
    def with_part(self, state: State, nodes: tuple[Part, ...], selected: str) -> State:
        return state
    @override
    def newgroup(self, state: State) -> Any:
        return None
    @override
    def relased(self, part: Any, group: Any) -> Any:
        return part
    @override
    def view_advise(self, state: State, camera: Any) -> Any:
        return None

@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    return [Misspelt()]
"""

LOOKS_LIKE = {
    "hnit": "hint",
    "Gesture": "gesture",
    "earse": "erase",
    "taps": "tap",
    "darg": "drag",
    "begn": "begin",
    "nextstep": "next_step",
    "updates": "update",
    "state_verison": "state_version",
    "figure": "figures",
    "reports": "report",
    "with_part": "with_parts",
    "newgroup": "new_group",
    "relased": "released",
    "view_advise": "view_advice",
}

OTHERWISE = (
    "Draw: 'apply' is final; override the methods that it calls: tap, drag, erase, draw",
    "Draw: draw(self, state, ink) must take draw(self, state, ink, context)",
    "Draw: preview(self, state, gesture, context, more) must take "
    "preview(self, state, gesture, context)",
    "Misspelt: solve(self, state, job, fast) must take solve(self, state, job)",
    "Misspelt: scene(self, state) must take scene(self, state, result)",
    "'first_parameters' names 'widht', which is no parameter; perhaps width",
    "“sumary” is not known and was ignored. It looks like “summary”.",
    "“sampels” of modeler {author}.modeler is not known and was ignored. It looks like “samples”.",
    "“ordre” of modeler {author}.modeler is not known and was ignored. It looks like “order”.",
)


def test_every_misspelling_is_told_by_name(make_package):
    package = make_package(CODE, MANIFEST)
    told = messages(package)
    for name, meant in LOOKS_LIKE.items():
        assert f"{name!r} looks like {meant!r}" in told, name
    for sentence in OTHERWISE:
        assert sentence.replace("{author}", package) in told, sentence
    assert told.count(" looks like '") == len(LOOKS_LIKE), "and nothing else is"


HALF = """
from bozzetto.plugin import Modeler, Tool, hookimpl
from dataclasses import dataclass
from bozzetto.geometry import Shapes
from bozzetto.scene import Scene

@dataclass(frozen=True)
class State:
    pass

class Half(Modeler):
    id, state_type = __name__ + ".modeler", State
    def solve(self, state, job):
        return 0.0
    def scene(self, state, result):
        return Scene()
    def shapes(self, state, result):
        return Shapes()
    {more}

@hookimpl
def bozzetto_modelers():
    return [Half()]
"""

PLAIN = MANIFEST.replace("sumary", "summary").replace("sampels = []\nordre", "order")


@pytest.mark.parametrize(
    ("code", "manifest", "sentence"),
    [
        (HALF.replace("def solve", "def slove"), PLAIN, "Half: 'slove' looks like 'solve'"),
        (HALF.replace("state_type", "state_tpye"), PLAIN, "Half: 'state_tpye' looks like"),
        (HALF.replace("bozzetto_modelers", "bozzetto_modeler"), PLAIN, "bozzetto_modeler"),
        (HALF.replace("{more}", "def tools(self): return [Pen()]\nclass Pen(Tool):\n"
                      "    id, title, hnit = 'pen', 'Pen', 'Draw.'"), PLAIN,
         "Pen: 'hnit' looks like 'hint'"),
        (HALF.replace("{more}", "def read_shapes(self, shapes): return State()"), PLAIN,
         'Half has read_shapes: write abilities = ["read_shapes"]'),
        (HALF, PLAIN + 'abilities = ["add_picture"]', "can add_picture, and Half does not"),
        (HALF, PLAIN + 'abilities = ["add_pictures"]', "'add_pictures'"),
        (HALF, PLAIN + 'abilities = ["panel"]', "no hook bozzetto_panel"),
        (HALF + "def bozzetto_panel(): pass", PLAIN, 'does not say abilities = ["panel"]'),
        (HALF + "def bozzetto_faults(): pass", PLAIN, "does not say checks_files = true"),
        (HALF, "checks_files = true\n" + PLAIN, "no hook bozzetto_faults"),
        (HALF, PLAIN.replace("version", "verison"), "“verison” is not known and was ignored. It "
         "looks like “version”."),
        (HALF, PLAIN.replace("icon =", "icno ="), "It looks like “icon”."),
    ],
)  # fmt: skip
def test_what_keeps_a_plugin_from_loading_is_told_by_name(make_package, code, manifest, sentence):
    assert sentence in messages(make_package(code.replace("{more}", ""), manifest))


def test_a_name_that_only_an_instance_has(make_package):
    own = "def __init__(self): self.view_advise = None"
    told = messages(make_package(HALF.replace("{more}", own), PLAIN))
    assert "'view_advise' looks like 'view_advice'" in told


@pytest.mark.slow
def test_mypy_names_what_types_can_tell(make_package, tmp_path):
    """`--strict` finds each override that is none, and each with other arguments."""
    package = make_package(CODE, MANIFEST)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", os.devnull, "-p", package]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path / "packages",
        env=os.environ | {"MYPYPATH": "", "MYPY_CACHE_DIR": str(tmp_path / "cache")},
    )
    for name in LOOKS_LIKE.keys() - {"hnit", "Gesture", "state_verison", "figure"}:
        assert f'Method "{name}" is marked as an override' in done.stdout, name
    for name in ("draw", "preview", "solve", "scene"):
        assert re.search(rf'Signature of "{name}" incompatible', done.stdout), name
    assert 'Cannot override final attribute "apply"' in done.stdout
