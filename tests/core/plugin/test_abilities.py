"""What a modeler may do besides, without a window: commands, view advice, curves, shapes read."""

from __future__ import annotations

import importlib
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.geometry import Placement, Shapes
from bozzetto.ink import Drawing, Strokes
from bozzetto.ink.steps import CommandStep, DrawStep
from bozzetto.plugin import Command, Figure, NextStep, ViewAdvice
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Layer, Points, Scene
from bozzetto.testing import Pen, Shell
from bozzetto.testing.abilities import ABILITIES
from bozzetto.testing.checks import CHECKS
from bozzetto.testing.subject import Broken, Subject
from bozzetto.view import Camera
from bozzetto.workbench.workbench import Workbench
from tests import adviser, linked_boxes, plugin_package
from tests.adviser import MODELER
from tests.core.plugin.conftest import GOOD_MANIFEST

LINE = Pen().along([(300, 300), (500, 400)])
TURNED = Placement((1.0, 0, 0, 0, 0, -1.0, 0, 1.0, 0), 2.0, (5.0, -3.0, 1.0))
"""A quarter about x, twice as large, elsewhere."""

marks = plugin_package.fixture_of("tests.adviser", "Marks")


@pytest.fixture
def shell(marks, tmp_path):
    made = Shell(Registry(extra=[marks.package]), tmp_path)
    made.open(MODELER)
    return made


# -- commands ---------------------------------------------------------------------------------


def test_a_command_makes_a_new_state(shell):
    before = shell.draw(LINE).state
    shell.run("flip")
    assert np.allclose(np.array(shell.state.marks), np.array(before.marks) * (-1, 1, 1))
    shell.undo()
    assert shell.state is before


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("flip", "“Flip” cannot be done here now. Exchange left and right."),
        ("refuse", "This cannot be done. Do something else."),
        ("fly", "Marks has no command 'fly'; there are: flip, refuse."),
    ],
)
def test_refusals_are_told_in_words(shell, command, words):
    with pytest.raises(UserError) as told:
        shell.run(command)
    assert told.value.message == words


def test_a_locked_model_is_not_changed(shell):
    model = replace(shell.draw(LINE), locked=True)
    commands = shell.workbench.commands
    flip = commands.find(MODELER, "flip")
    assert not commands.can_run(model, flip)
    with pytest.raises(UserError, match="is locked"):
        commands.run(model, flip, shell.context())


def listed(marks):
    """Commands of a modeler with one that writes a file."""

    def written(state, context):
        text = f"{context.file}: {len(state.marks)}"
        return text.encode()

    whole = adviser.Marks.commands(marks)
    return lambda: [*whole, Command("list", "List", "Writes how many.", written, writes=".txt")]


def test_a_command_that_writes_changes_nothing_and_knows_its_file(
    shell, marks, monkeypatch, tmp_path
):
    monkeypatch.setattr(marks, "commands", listed(marks))
    model = shell.draw(LINE)
    commands = shell.workbench.commands
    found = commands.find(MODELER, "list")
    target = tmp_path / "Two marks.txt"
    target.write_text("older")
    commands.write(replace(model, locked=True), found, shell.context(), target)
    assert target.read_text() == "Two marks: 1"
    with pytest.raises(UserError, match="writes a file, and changes nothing"):
        commands.run(model, found, shell.context())
    with pytest.raises(UserError, match=r"writes a \.txt file"):
        commands.write(model, found, shell.context(), tmp_path / "a.md")
    with pytest.raises(UserError, match="writes no file"):
        commands.content(model, commands.find(MODELER, "flip"), shell.context(), "a")
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".md"] == []


def test_an_ending_that_only_a_command_writes_names_the_command(
    shell, marks, monkeypatch, tmp_path, capsys
):
    from bozzetto.cli.main import main

    monkeypatch.setattr(marks, "commands", listed(marks))
    monkeypatch.setattr("bozzetto.cli.export.workbench", lambda: shell.workbench)
    shell.draw(LINE)
    drawn = str(shell.save())
    target = tmp_path / "marks.txt"
    assert main(["export", drawn, "-o", str(target)]) != 0
    assert "add --command list" in capsys.readouterr().err
    assert main(["export", drawn, "-o", str(target), "--command", "list"]) == 0
    assert target.read_text() == "marks: 1"
    assert main(["export", drawn, "-o", str(tmp_path / "marks.zzz")]) != 0
    assert "Use one of" in capsys.readouterr().err
    assert main(["export", drawn, "-o", str(target), "--command", "lsit"]) != 0
    assert "No object has a command 'lsit'; files are written by: list." in capsys.readouterr().err


def test_build_names_the_command_that_writes_an_ending(shell, marks, monkeypatch, tmp_path, capsys):
    from bozzetto.cli.main import main

    monkeypatch.setattr(marks, "commands", listed(marks))
    monkeypatch.setattr("bozzetto.cli.build.workbench", lambda: shell.workbench)
    shell.draw(LINE)
    build = ["build", MODELER, str(shell.save()), "-o"]
    assert main([*build, str(tmp_path / "marks.txt")]) != 0
    assert "“.txt” is written by a command: add --command list." in capsys.readouterr().err
    assert main([*build, str(tmp_path / "marks.zzz")]) != 0
    assert "Use one of" in capsys.readouterr().err


@pytest.mark.parametrize("content", [None, "text", b"", adviser.MarksState()])
def test_what_a_command_writes_is_checked(shell, marks, monkeypatch, tmp_path, content):
    def run(state, context):
        return content

    made = Command("list", "List", "Writes how many.", run, writes=".txt")
    monkeypatch.setattr(marks, "commands", lambda: [made])
    model = shell.draw(LINE)
    with pytest.raises(PluginFault):
        shell.workbench.commands.write(model, made, shell.context(), tmp_path / "a.txt")
    assert not (tmp_path / "a.txt").exists()


@pytest.mark.parametrize("ending", ["txt", ".TXT", "./../x", ".t t"])
def test_a_wrong_ending_of_a_command_is_the_plugins_fault(shell, marks, monkeypatch, ending):
    made = Command("list", "List", "Writes.", lambda state, context: b"1", writes=ending)
    monkeypatch.setattr(marks, "commands", lambda: [made])
    with pytest.raises(PluginFault):
        shell.workbench.commands.of(MODELER)


def test_a_command_sees_the_world_from_the_models_frame(shell, monkeypatch):
    seen = []
    look = Command("look", "Look", "Looks.", lambda state, context: seen.append(context) or state)
    model = replace(shell.draw(LINE), placement=TURNED)
    shell.workbench.commands.run(model, look, shell.context())
    there = seen[0].camera
    assert np.allclose(TURNED.points(there.eye), shell.camera.eye)
    assert np.allclose(
        TURNED.points(seen[0].curves[0].control_points), shell.context().curves[0].control_points
    )


@pytest.mark.parametrize(
    "wrong",
    [
        7,
        [7],
        [Command("", "T", "H", adviser.flip)],
        [Command("a", "", "H", adviser.flip)],
        [Command("a", "T", None, adviser.flip)],
        [Command("a", "T", "H", "run")],
        [Command("a", "T", "H", adviser.flip, key=3)],
        [Command("a", "T", "H", adviser.flip, menu=None)],
        [Command("a", "T", "H", adviser.flip, enabled=True)],
        [Command("a", "T", "H", adviser.flip)] * 2,
        [Command(f"a{k}", "T", "H", adviser.flip) for k in range(201)],
    ],
)
def test_commands_that_are_none_are_a_fault(shell, marks, monkeypatch, wrong):
    monkeypatch.setattr(marks, "commands", lambda: wrong)
    with pytest.raises(PluginFault, match="commands gave what cannot be used"):
        shell.commands()


@pytest.mark.parametrize("made", [None, 42, object()])
def test_a_command_that_makes_no_state_is_a_fault(shell, marks, monkeypatch, made):
    command = Command("a", "T", "H", lambda state, context: made)
    monkeypatch.setattr(marks, "commands", lambda: [command])
    before = shell.state
    with pytest.raises(PluginFault):
        shell.run("a")
    assert shell.state is before


def test_a_modeler_without_commands_has_none(tmp_path):
    shell = Shell(Registry(), tmp_path)
    shell.open("bozzetto.mesh")
    assert shell.commands() == ()
    assert shell.advice() is None


# -- steps of ink files ------------------------------------------------------------------------


def test_a_step_runs_a_command_and_facts_reach_create(shell, tmp_path):
    from bozzetto.exchange.ink.ink_json import write_drawing

    drawing = Drawing(
        Strokes([LINE, LINE]),
        Camera(),
        facts={"box": 12.5},
        steps=(DrawStep("mark", (0,)), CommandStep("flip"), DrawStep("mark", (1,))),
    )
    (tmp_path / "made.json").write_bytes(write_drawing(drawing))
    read = read_drawing(tmp_path / "made.json")
    assert read.steps == drawing.steps
    made = shell.workbench.sources.from_drawing(MODELER, read, {}).state
    assert made.box == 12.5
    (first,), (second,) = made.marks[:1], made.marks[1:]
    assert np.allclose(np.array(first), np.array(second) * (-1, 1, 1))
    assert made.seen == 1, "the second mark saw the curve of the first"
    plain = replace(read, steps=(), strokes=Strokes([LINE]))
    assert shell.workbench.sources.from_drawing(MODELER, plain, {}).state.box == 12.5


@pytest.mark.parametrize("name", ["fly", "flip", "refuse"])
def test_a_command_that_cannot_be_run_is_named_with_its_step(shell, name):
    drawing = Drawing(Strokes([LINE]), Camera(), steps=(CommandStep(name),))
    with pytest.raises(UserError, match="Step 1: "):
        shell.workbench.sources.from_drawing(MODELER, drawing, {})


# -- view advice -------------------------------------------------------------------------------


def test_advice_is_given_in_the_world(shell):
    """A moved model seen from the same side of itself gets the same advice, moved."""
    plain = shell.workbench.view_advice(shell.model, shell.camera)
    moved = shell.workbench.view_advice(
        replace(shell.model, placement=TURNED), shell.camera.moved(TURNED)
    )
    assert (moved.level, moved.message) == (plain.level, plain.message)
    assert np.allclose(moved.better.eye, TURNED.points(plain.better.eye))
    assert np.allclose(moved.scene.points(), TURNED.points(plain.scene.points()), atol=1e-4)
    assert {layer.owner for layer in moved.scene.layers} == {shell.model.id}


NAN = Points(np.zeros((1, 3), np.float32))
object.__setattr__(NAN, "points", np.full((1, 3), np.nan, np.float32))


@pytest.mark.parametrize(
    "wrong",
    [
        "good",
        ViewAdvice("fine", "x"),
        ViewAdvice("good", None),
        ViewAdvice("good", "x" * 1000),
        ViewAdvice("good", "x", better=(0, 0, 0)),
        ViewAdvice("good", "x", scene=None),
        ViewAdvice("good", "x", scene=Scene((Layer("l", (NAN,)),))),
    ],
)
def test_advice_that_cannot_be_shown_is_a_fault(shell, marks, wrong):
    marks.advise = lambda state, camera: wrong
    with pytest.raises(PluginFault, match="view_advice gave what cannot be used"):
        shell.advice()


def test_no_advice_is_an_answer(shell, marks):
    marks.advise = lambda state, camera: None
    assert shell.advice() is None


# -- curves, shapes as input -------------------------------------------------------------------


def test_curves_follow_the_model_and_nothing_is_solved_for_them(shell, marks, monkeypatch):
    model, bench = shell.draw(LINE), shell.workbench
    assert bench.curves.of([model]) == ()
    shell.solve()
    (own,) = bench.curves.of([model])
    monkeypatch.setattr(marks, "solve", None)
    (moved,) = bench.curves.of([replace(model, placement=TURNED)])
    assert np.allclose(moved.control_points, TURNED.points(own.control_points))
    assert bench.curves.of([replace(model, visible=False)]) == ()
    assert bench.curves.of([replace(model, state=replace(model.state, box=1.0))]) == ()


@pytest.mark.parametrize("wrong", [7, ["no curve"], Shapes()])
def test_curves_that_are_none_do_not_cost_the_shape(shell, marks, monkeypatch, wrong):
    monkeypatch.setattr(marks, "curves", lambda state, result: wrong)
    shell.draw(LINE)
    assert shell.solve() == shell.state.marks
    assert shell.registry.guard.faults(shell.registry.info(MODELER).plugin) == 1
    assert shell.workbench.curves.of([shell.model]) == ()


def test_a_model_starts_from_another(shell):
    before = shell.draw(LINE).state
    shell.use("marks")
    assert np.allclose(np.array(shell.state.marks), np.array(before.marks))
    assert len(shell.document) == 2


def test_what_has_no_shape_and_what_takes_none_is_refused(shell):
    with pytest.raises(UserError, match="has no shape to start from"):
        shell.use("marks")
    shell.draw(LINE)
    with pytest.raises(UserError, match="cannot start from what is there"):
        shell.use("silhouette")


# -- the test kit ------------------------------------------------------------------------------


def failing(marks):
    subject = Subject(MODELER, (marks.package,), lambda shell, pen: shell.draw(LINE))
    found = set()
    for check in ABILITIES:
        try:
            check(subject)
        except (Broken, PluginFault, UserError):
            found.add(check.__name__.removeprefix("check_"))
    return found


def test_a_good_modeler_passes(marks):
    assert failing(marks) == set()


def test_what_is_wrong_is_found(marks, monkeypatch):
    advise = marks.advise
    marks.advise = lambda state, camera: replace(
        advise(state, camera), better=Camera(eye=(0.0, -1.0, 0.0))
    )
    assert failing(marks) == {"view_advice"}, "what is called better is worse"
    marks.advise = lambda state, camera: ViewAdvice("warn", " ")
    assert failing(marks) == {"view_advice"}
    marks.advise = advise
    with monkeypatch.context() as changed:
        changed.setattr(marks, "commands", lambda: [Command("a", "T", " ", adviser.flip)])
        assert failing(marks) == {"commands"}
        changed.setattr(marks, "commands", lambda: [Command("a", "T", "H", lambda s, c: 1 / 0)])
        assert failing(marks) == {"commands"}
    for said in (NextStep(" "), NextStep("Go.", tool="none"), NextStep("Go.", (1.0, 2.0)), 42):
        with monkeypatch.context() as changed:
            changed.setattr(marks, "next_step", lambda state, tool, said=said: said)
            assert failing(marks) == {"next_step"}
    with monkeypatch.context() as changed:
        changed.setattr(marks, "read_shapes", lambda shapes: 1 / 0)
        assert failing(marks) == {"read_shapes"}
    with monkeypatch.context() as changed:
        changed.setattr(marks, "curves", lambda state, result: 1 / 0)
        assert "curves" in failing(marks)


SPREAD, WORDS = Figure("Gaps", "How wide.", spread=True), Figure("Kind", "What.", values={"a": "A"})


@pytest.mark.parametrize(
    ("report", "figures", "fits"),
    [
        ({"gaps_mm": [1.0, 2.0], "kind": "a"}, {"gaps": SPREAD, "kind": WORDS}, True),
        (
            {"parts": [{"gaps": {"one": 1.0}}, {"kind": None}]},
            {"gaps": SPREAD, "kind": WORDS},
            True,
        ),
        ({}, {"gaps": SPREAD}, True),
        ({"gaps": ["a"]}, {"gaps": SPREAD}, False),
        ({"parts": [{"kind": "b"}]}, {"kind": WORDS}, False),
        ({"gaps_mm": [1.0]}, {"gapps": SPREAD}, False),
        ({"gaps_mm³": [1.0]}, {"gaps": SPREAD}, False),
    ],
)
def test_figures_must_fit_the_report(marks, monkeypatch, report, figures, fits):
    monkeypatch.setattr(adviser.Marks, "report", lambda self, state, result: report)
    monkeypatch.setattr(adviser.Marks, "figures", figures)
    assert ("figures" in failing(marks)) is not fits


def test_facts_are_only_lent(shell):
    facts = {"box": 3.0}
    drawing = Drawing(Strokes([LINE]), Camera(), facts=facts, steps=(DrawStep("mark", (0,)),))
    shell.workbench.sources.from_drawing(MODELER, drawing, {})
    assert facts == {"box": 3.0}


# -- following ---------------------------------------------------------------------------------

FOLLOWER = """
from dataclasses import dataclass, replace

from bozzetto.geometry import Curve, Shapes
from bozzetto.ink import Strokes
from bozzetto.plugin import Modeler, Tool, hookimpl
from bozzetto.scene import Scene

asked = []

@dataclass(frozen=True)
class State:
    sources: tuple[str, ...] = ()
    strokes: Strokes = Strokes()

class Draw(Tool):
    id, title, hint = "draw", "Draw", "Draw a path."
    def draw(self, state, ink, context):
        return replace(state, strokes=state.strokes.extended(ink.strokes))

class Row(Modeler):
    id, state_type = __name__ + ".modeler", State
    def tools(self):
        return (Draw(),)
    def follow(self, sources):
        return State(tuple(sources))
    def sources(self, state):
        return state.sources
    def with_sources(self, state, sources):
        return replace(state, sources=tuple(sources))
    def solve(self, state, job):
        if not len(state.strokes):
            return ()
        asked.append(state.sources)
        return (Curve(1, [0, 0, 1, 1], [[0, 0, 0], [LENGTH, 0, 0]]),)
    def scene(self, state, result):
        return Scene()
    def shapes(self, state, result):
        return Shapes(curves=result)

@hookimpl
def bozzetto_modelers():
    return [Row()]
"""


@pytest.mark.parametrize(
    ("length", "fault"),
    [
        ("1", ""),
        ("len(asked)", "other shapes the second time"),
        ("len(state.sources[0])", "ids of sources change"),
    ],
)
def test_a_follower_that_needs_ink_is_followed_with_ink(make_package, length, fault):
    manifest = GOOD_MANIFEST + 'abilities = ["follow"]\n'
    package = make_package(FOLLOWER.replace("LENGTH", length), manifest)
    subject = Subject(f"{package}.modeler", (package,))
    (check,) = (check.run for check in CHECKS if check.name == "follow")
    if fault:
        with pytest.raises(Broken, match=fault):
            check(subject)
    else:
        check(subject)
    assert importlib.import_module(package).asked


def test_a_source_is_changed_and_its_follower_chosen_again(tmp_path, monkeypatch):
    linked_boxes.write_package(tmp_path / "packages", "boxes_in_a_row")
    monkeypatch.syspath_prepend(tmp_path / "packages")
    shell = Shell(Registry(extra=["boxes_in_a_row"]), tmp_path)
    shell.open(linked_boxes.MODELER)
    source = shell.set(edge=10.0)
    follower = shell.use(linked_boxes.MODELER)
    before = shell.shapes().solids[0].mesh.bounds
    shell.choose(source.id)
    shell.set(edge=20.0)
    assert shell.choose(follower.id).state == follower.state
    assert shell.shapes().solids[0].mesh.bounds == pytest.approx(2.0 * before)
    with pytest.raises(KeyError, match="nobody"):
        shell.choose("nobody")


# -- files of facts ---------------------------------------------------------------------------


TELLING = """
from dataclasses import dataclass
from bozzetto.geometry import Shapes
from bozzetto.plugin import Modeler, hookimpl
from bozzetto.scene import Scene

@dataclass(frozen=True)
class State:
    height: float = 0.0

class Telling(Modeler):
    id, state_type = __name__ + ".modeler", State
    def create(self, context):
        return State(float(context.facts.get("cup", 0.0)))
    def solve(self, state, job):
        return 0
    def scene(self, state, result):
        return Scene()
    def shapes(self, state, result):
        return Shapes()

@hookimpl
def bozzetto_modelers():
    return [Telling()]
"""


def test_a_file_of_facts_is_read_by_create_alone(make_package):
    package = make_package(TELLING, f'{GOOD_MANIFEST}facts = "cup"\n')
    other = make_package(TELLING, f'{GOOD_MANIFEST}facts = "vase"\n')
    sources = Workbench(Registry(extra=[package, other])).sources
    cup = Drawing(Strokes(), Camera(), "cup", facts={"cup": 4.5})
    assert sources.from_drawing(f"{package}.modeler", cup, {}).state.height == 4.5
    with pytest.raises(UserError, match="is a file of Modeler"):
        sources.from_drawing(f"{other}.modeler", cup, {})
    with pytest.raises(UserError, match="takes no ink"):
        sources.from_drawing(f"{other}.modeler", Drawing(Strokes(), Camera(), facts={"x": 1}), {})
