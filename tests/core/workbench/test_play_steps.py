"""Steps of a drawing, taken one by one: everything the pen can do, without a pen."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.document.storage.bozz_file import read_document
from bozzetto.errors import Cancelled, UserError
from bozzetto.exchange.ink.ink_json import write_drawing
from bozzetto.geometry import Placement
from bozzetto.ink import Drawing, Strokes
from bozzetto.ink.steps import (
    DeleteStep,
    DragStep,
    DrawStep,
    DuplicateStep,
    GroupStep,
    MoveStep,
    RenameStep,
    SelectStep,
    SetStep,
    ShowStep,
    TapStep,
)
from bozzetto.plugin import Job
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen, Shell
from bozzetto.view import Camera
from bozzetto.workbench.workbench import Workbench

EXAMPLE = Path(__file__).resolve().parents[3] / "docs" / "examples" / "bozzetto_ribbon"


def drawing(strokes, *steps):
    return Drawing(Strokes(strokes), Camera(), "made", steps=steps)


@pytest.fixture
def shell(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLE)
    yield Shell(Registry(extra=["bozzetto_ribbon"]), tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] == "bozzetto_ribbon"]:
        del sys.modules[name]


LINES = (
    Pen().along([(300, 450), (900, 450)]),
    Pen().along([(300, 600), (900, 600)]),
    Pen().along([(300, 450), (300, 300)]),
)

GESTURES = (
    DrawStep("draw", (0, 1)),
    DragStep("move", "0", 2),
    SetStep({"width": 20.0}),
    TapStep("erase", (600.0, 602.0)),
)


def test_steps_make_what_the_hand_makes(shell):
    made = shell.workbench.sources.from_drawing("example.ribbon", drawing(LINES, *GESTURES), {})
    shell.open("ribbon")
    shell.draw(*LINES[:2])
    shell.drag("0", LINES[2])
    shell.set(width=20.0)
    shell.tap(600.0, 602.0)
    assert made.state == shell.state
    assert len(made.state.bands) == 1


def test_ink_is_laid_on_what_earlier_steps_made(shell):
    """The scene between two steps is solved, so that rays meet surfaces."""
    above = Camera(eye=(0.0, -500.0, 200.0))
    wide = Pen().along([(300, 450), (900, 450)])
    there = Pen(above).along([(560, 430), (640, 440)])
    made = shell.workbench.sources.from_drawing(
        "example.ribbon",
        drawing([wide, there], DrawStep("draw", (0,)), SetStep({"width": 100.0}),
                DrawStep("draw", (1,))),
        {},
    )  # fmt: skip
    through = made.state.bands[1].through
    assert abs(through[1]) < 1e-6, "the ribbon's plane is y = 0"
    assert np.abs(through[2]) > 1.0, "and not the target of the view"


def counted(modeler, monkeypatch):
    """Let a modeler's solves be counted; return the states that it was asked for."""
    asked, solve = [], modeler.solve

    def counting(state, job):
        asked.append(state)
        return solve(state, job)

    monkeypatch.setattr(modeler, "solve", counting)
    return asked


def test_nothing_is_solved_for_steps_that_look_at_nothing(shell, monkeypatch):
    asked = counted(shell.workbench.registry.modeler("example.ribbon"), monkeypatch)
    steps = GESTURES[1:], (DrawStep("draw", (0, 1)),)
    # The pen of a ribbon looks at what is under it; moving and taking away do not.
    shell.workbench.sources.from_drawing("example.ribbon", drawing(LINES, *steps[1], *steps[0]), {})
    assert len(asked) == 1


def test_curves_are_learnt_when_a_gesture_asks_for_them(shell, monkeypatch):
    """And then they are those of the state that it meets, so that it can snap to them."""
    modeler = shell.workbench.registry.modeler("example.ribbon")
    monkeypatch.setattr(
        type(modeler), "curves", lambda self, state, result: self.shapes(state, result).curves,
        raising=False,
    )  # fmt: skip
    asked = counted(modeler, monkeypatch)
    tool = type(next(tool for tool in modeler.tools() if tool.id == "erase"))
    snapped, tap = [], tool.tap

    def looking(self, state, gesture, context):
        context = replace(context, camera=gesture.camera).moved(Placement(offset=(5.0, 0.0, 0.0)))
        before = len(asked)
        snapped.append((len(context.curves), len(asked) - before))
        return tap(self, state, gesture, context)

    monkeypatch.setattr(tool, "tap", looking)
    shell.workbench.sources.from_drawing("example.ribbon", drawing(LINES, *GESTURES), {})
    assert snapped == [(2, 1)], "solved then, and not before"
    assert len(asked) == 2, "the pen of a ribbon looks at what is under it"


def test_a_fault_of_a_scene_that_a_tool_looks_at_is_one_fault(shell, monkeypatch):
    registry = shell.workbench.registry
    modeler = registry.modeler("example.ribbon")

    def failing(state, job):
        raise ZeroDivisionError("ribbons")

    monkeypatch.setattr(modeler, "solve", failing)
    steps = DrawStep("draw", (0,)), DrawStep("draw", (1,))
    with pytest.raises(PluginFault, match=r"solve failed \(ZeroDivisionError: ribbons\)"):
        shell.workbench.sources.from_drawing("example.ribbon", drawing(LINES, *steps), {})
    assert registry.guard.faults("example.ribbon") == 1


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ([TapStep("erase", (10.0, 10.0))], "Step 1: There is no ribbon here"),
        ([DrawStep("draw", (0,)), DrawStep("paint", (0,))], "Step 2: .* has no tool 'paint'"),
        ([SetStep({"girth": 1.0})], "Step 1: There is no parameter"),
        ([SetStep({"width": 1e9})], "Step 1: Width goes from"),
        ([SelectStep("x")], "Step 1: .* not made of parts"),
    ],
)
def test_a_step_that_cannot_be_taken_is_named(shell, steps, words):
    with pytest.raises(UserError, match=words):
        shell.workbench.sources.from_drawing("example.ribbon", drawing(LINES, *steps), {})


CIRCLES = tuple(Pen().circle(x, 450, 60) for x in (300, 600, 900))

PARTS = (
    DrawStep("draw", (0,)),
    RenameStep("Head"),
    DrawStep("draw", (1,)),
    DrawStep("draw", (2,)),
    SetStep({"operation": "carve", "blend": 0.0}, "Part 2"),
    GroupStep(("Part 2", "Head")),
    RenameStep("Bust"),
    DuplicateStep("Head"),
    ShowStep(False, "Head 2"),
    MoveStep("Head 2", 0),
    SelectStep(""),
)


def outline(bench, made):
    tree = bench.parts.of(made)
    return [(part.name, depth) for part, depth in tree.rows()], tree


def test_parts_are_arranged_by_steps():
    bench = Workbench(Registry())
    made = bench.sources.from_drawing("bozzetto.silhouette", drawing(CIRCLES, *PARTS), {})
    rows, tree = outline(bench, made)
    third = next(part.name for part in tree.parts if part.name.startswith("Part") and
                 part.name != "Part 2")  # fmt: skip
    assert rows == [("Head 2", 0), ("Bust", 0), ("Head", 1), ("Part 2", 1), (third, 0)]
    assert tree.selected == ""
    assert not tree.part(tree.find("Head 2")).visible
    assert tree.part(tree.find("Part 2")).operation == "carve"
    deleted = bench.sources.from_drawing(
        "bozzetto.silhouette", drawing(CIRCLES, *PARTS, DeleteStep("Bust")), {}
    )
    assert outline(bench, deleted)[0] == [("Head 2", 0), (third, 0)]


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (RenameStep("X", "Nose"), "Step 2: There is no part “Nose”; there are: Part 1"),
        (SetStep({"detail": 1}, "Part 1"), "Step 2: There is no parameter 'detail'; “Part 1” has"),
        (MoveStep("Part 1", 0, "Part 1"), "Step 2: “Part 1” is not a group"),
        (ShowStep(True, ""), "Step 3: No part is chosen"),
    ],
)
def test_parts_that_are_not_there_are_named(step, words):
    steps = [DrawStep("draw", (0,)), step]
    if step == ShowStep(True, ""):
        steps.insert(1, SelectStep(""))
    with pytest.raises(UserError, match=words):
        Workbench(Registry()).sources.from_drawing(
            "bozzetto.silhouette", drawing(CIRCLES, *steps), {}
        )


def test_the_command_line_takes_steps_and_values_of_parts(tmp_path, monkeypatch, capsys):
    from bozzetto.cli.main import main

    monkeypatch.chdir(tmp_path)
    Path("steps.json").write_bytes(write_drawing(drawing(CIRCLES, *PARTS)))
    assert main(["build", "silhouette", "steps.json", "-o", "x.bozz", "--report", "r.json",
                 "--set", "Head.inflation=2", "--set", "Part 2.color=#102030"]) == 0  # fmt: skip
    assert json.loads(Path("r.json").read_text())
    bench = Workbench(Registry())
    document, _ = read_document(Path("x.bozz"), bench.registry)
    (model,) = document
    tree = bench.parts.of(model)
    assert {part.name: part.inflation for part in model.state.parts if part.inflation != 1.0} == {
        "Head": 2.0
    }
    assert tree.part(tree.find("Part 2")).color == (16, 32, 48)
    assert main(["export", "x.bozz", "-o", "x.stl"]) == 0
    capsys.readouterr()
    for assignment, words in (
        ("Nose.inflation=2", "no part “Nose”"),
        ("Head.resolution=64", "a part of Silhouette has"),
        ("Head.inflation=9", "0.2"),
    ):
        args = ["build", "silhouette", "steps.json", "-o", "y.stl", "--set", assignment]
        assert main(args) == 2
        assert words in capsys.readouterr().err
        assert not Path("y.stl").exists()


def test_steps_are_told_and_end_when_nobody_waits(shell):
    told = []
    made = drawing(LINES, *GESTURES)
    shell.workbench.sources.from_drawing(
        "example.ribbon",
        made,
        {},
        job=Job(progress=lambda share, words: told.append((share, words))),
    )
    assert [words for _, words in told] == [f"Step {k}" for k in (1, 2, 3, 4)]
    assert [share for share, _ in told] == [0.0, 0.25, 0.5, 0.75]
    asked = []
    enough = Job(cancelled=lambda: bool(asked.append(1)) or len(asked) > 2)
    with pytest.raises(Cancelled):
        shell.workbench.sources.from_drawing("example.ribbon", made, {}, job=enough)
