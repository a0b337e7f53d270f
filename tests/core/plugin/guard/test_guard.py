from __future__ import annotations

import logging
import re
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.storage.state_codec import state_digest
from bozzetto.errors import Cancelled, Unfinished, UserError
from bozzetto.geometry import Mesh, Shapes, Surface
from bozzetto.ink import Drawing, Strokes
from bozzetto.plugin import Ink, Job
from bozzetto.plugin.guard.guard import MOST_FAULTS, Guard, PluginFault
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Handle, Label, Layer, Lines, Scene, Shaded
from bozzetto.testing import Pen
from bozzetto.view import Camera

DRAWING = Drawing(Strokes([Pen().circle()]), Camera(), facts={"marks": [1, 2]})

# What the program does with a modeler, by the function that it reaches.
CALLS = {
    "create": lambda shell: shell.open("faulty.modeler"),
    "tools": lambda shell: shell.tools(),
    "preview": lambda shell: shell.draw(Pen().circle()),
    "apply": lambda shell: shell.draw(Pen().circle()),
    "solve": lambda shell: shell.workbench.solve(shell.model, Job(quality="preview")),
    "scene": lambda shell: shell.scene(),
    "shapes": lambda shell: shell.shapes(),
    "report": lambda shell: shell.workbench.report(shell.model, Job()),
    "read_drawing": lambda shell: shell.workbench.sources.from_drawing(
        "faulty.modeler", DRAWING, {}
    ),
    "read_shapes": lambda shell: shell.workbench.sources.from_shapes(
        "faulty.modeler", Shapes(), "x"
    ),
    "upgrade": lambda shell: shell.registry.upgrade("faulty.modeler", {"size": 1.0}, 1),
    "panel": lambda shell: shell.registry.panel("faulty.modeler", None, None),
}


class Mute(Exception):
    def __str__(self):
        raise RuntimeError("no words")


def deep(*_):
    return deep(*_)


def raising(problem):
    def misdeed(*_):
        raise problem

    return misdeed


FAILURES = {
    "ValueError": raising(ValueError("out of\nluck")),
    "an exception without words": raising(Mute()),
    "SystemExit": raising(SystemExit(1)),
    "GeneratorExit": raising(GeneratorExit()),
    "MemoryError": raising(MemoryError()),
    "RecursionError": deep,
    "BaseException": raising(BaseException("rough")),
    "StopIteration": raising(StopIteration()),
    "a group": raising(ExceptionGroup("several", [UserError("one")])),
}


@pytest.fixture
def drawn(workshop):
    workshop.draw(Pen().circle())
    return workshop


def unchanged(shell):
    """A function that asserts that the document is what it is now."""
    document, position = shell.document, shell.history.position
    digests = [state_digest(model.state) for model in document]

    def check():
        assert shell.document is document
        assert shell.history.position == position
        assert [state_digest(model.state) for model in shell.document] == digests

    return check


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("failure", FAILURES)
def test_failures_become_faults(drawn, faulty, call, failure):
    check = unchanged(drawn)
    faulty.misdeeds[call] = FAILURES[failure]
    with pytest.raises(PluginFault) as caught:
        CALLS[call](drawn)
    check()
    assert caught.value.plugin == "faulty.plugin"
    assert {"apply": "draw.draw"}.get(call, call) in caught.value.what
    assert "Traceback" in caught.value.details
    assert __file__ in caught.value.details
    assert "\n" not in str(caught.value)
    faulty.misdeeds.clear()
    CALLS[call](drawn)  # once is forgiven


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize(
    "passing", [UserError("do it again"), Unfinished("go on"), Cancelled(), KeyboardInterrupt()]
)
def test_what_may_pass_passes(drawn, faulty, call, passing):
    faulty.misdeeds[call] = raising(passing)
    if call == "preview" and isinstance(passing, UserError | Unfinished):
        CALLS[call](drawn)  # what has just begun may still become something
    else:
        with pytest.raises(type(passing)):
            CALLS[call](drawn)
    assert drawn.registry.guard.faults("faulty.plugin") == 0


def crooked(kind, **fields):
    """An object of a type that skipped its own checks."""
    made = object.__new__(kind)
    for name, value in fields.items():
        object.__setattr__(made, name, value)
    return made


NAN_POINTS = np.frombuffer(np.full((2, 3), np.nan, np.float32).tobytes(), np.float32).reshape(2, 3)


def scene_of(*items):
    return Scene((Layer("x", items),))


WRONG_SCENES = {
    "nothing": None,
    "a list": [],
    "no layers": crooked(Scene, layers=[]),
    "a layer that is none": Scene((3,)),
    "a mesh as an item": scene_of(Mesh(np.eye(3), [[0, 1, 2]])),
    "points not finite": scene_of(Lines(NAN_POINTS)),
    "a width not finite": scene_of(Lines(np.zeros((2, 3)), width=float("nan"))),
    "a width below zero": scene_of(Lines(np.zeros((2, 3)), width=-1.0)),
    "starts outside": scene_of(Lines(np.zeros((2, 3)), starts=np.array([0, 7]))),
    "starts going back": scene_of(Lines(np.zeros((9, 3)), starts=np.array([5, 2]))),
    "opacity": scene_of(Lines(np.zeros((2, 3)), opacity=7.0)),
    "another way to hide": scene_of(Lines(np.zeros((2, 3)), hidden="sometimes")),
    "a mesh that is none": scene_of(Shaded(None)),
    "a mesh without fields": scene_of(Shaded(crooked(Mesh))),
    "a label nowhere": scene_of(Label((0.0, float("inf"), 0.0), "x")),
    "a label on the plane": scene_of(Label((0.0, 0.0), "x")),
    "a label without text": scene_of(Label((0.0, 0.0, 0.0), None)),
    "a long label": scene_of(Label((0.0, 0.0, 0.0), "x" * 100_000)),
    "half a character": scene_of(Label((0.0, 0.0, 0.0), "a\udcff")),
    "a handle without id": scene_of(Handle("", (0.0, 0.0, 0.0))),
    "too many labels": scene_of(*[Label((0.0, 0.0, 0.0), "x")] * 5000),
    "too many items": scene_of(*[Lines(np.zeros((2, 3)))] * 50_000),
}

TRIANGLE = Mesh(np.eye(3), [[0, 1, 2]])

WRONG_SHAPES = {
    "nothing": None,
    "a list": [],
    "a mesh as a solid": Shapes(solids=(TRIANGLE,)),
    "a surface as a solid": Shapes(solids=(Surface(TRIANGLE),)),
    "a list of surfaces": Shapes(surfaces=[Surface(TRIANGLE)]),
    "a name that is none": Shapes(surfaces=(Surface(TRIANGLE, name=3),)),
    "half a character": Shapes(surfaces=(Surface(TRIANGLE, name="a\udcff"),)),
    "not finite": Shapes(
        surfaces=(Surface(crooked(Mesh, vertices=NAN_POINTS, faces=None, normals=None)),)
    ),
}


@pytest.mark.parametrize("scene", WRONG_SCENES.values(), ids=WRONG_SCENES)
@pytest.mark.parametrize("call", ["preview", "scene"])
def test_wrong_scenes(drawn, faulty, call, scene):
    check = unchanged(drawn)
    faulty.misdeeds[call] = lambda *_: scene
    with pytest.raises(PluginFault, match="cannot be used"):
        CALLS[call](drawn)
    check()


@pytest.mark.parametrize("shapes", WRONG_SHAPES.values(), ids=WRONG_SHAPES)
def test_wrong_shapes(drawn, faulty, shapes):
    faulty.misdeeds["shapes"] = lambda *_: shapes
    with pytest.raises(PluginFault, match="cannot be used"):
        drawn.shapes()


def wrong_states():
    from dataclasses import dataclass

    @dataclass(frozen=True)
    class Other:
        size: float = 1.0

    yield "nothing", lambda state: None
    yield "a dict", lambda state: {"size": 1.0}
    yield "another type", lambda state: Other()
    yield "the type itself", lambda state: type(state)
    yield "not a number", lambda state: replace(state, size=float("nan"))
    yield "out of range", lambda state: replace(state, size=11.0)
    yield "a text for a number", lambda state: replace(state, size="1")
    yield "a list for a tuple", lambda state: replace(state, table=[1.0])
    yield "infinity within", lambda state: replace(state, table=(1.0, float("inf")))
    yield "an array for a tuple", lambda state: replace(state, table=np.ones(3))
    yield "a function", lambda state: replace(state, table=(print,))
    yield "a list of strokes", lambda state: replace(state, strokes=list(state.strokes))


@pytest.mark.parametrize(
    "change", [c for _, c in wrong_states()], ids=[n for n, _ in wrong_states()]
)
@pytest.mark.parametrize("call", ["create", "apply", "read_drawing", "read_shapes"])
def test_wrong_states(drawn, faulty, call, change):
    check = unchanged(drawn)
    start = drawn.state
    faulty.misdeeds[call] = lambda *_: change(start)
    with pytest.raises(PluginFault, match="cannot be used"):
        CALLS[call](drawn)
    check()


@pytest.mark.parametrize("tools", [None, 3, "draw", [object()], [None], {"draw": 1}])
def test_wrong_tools(drawn, faulty, tools):
    faulty.misdeeds["tools"] = lambda: tools
    with pytest.raises(PluginFault, match="cannot be used"):
        drawn.tools()


def test_two_tools_of_one_id(drawn, faulty):
    (tool,) = drawn.tools()
    faulty.misdeeds["tools"] = lambda: [tool, tool]
    with pytest.raises(PluginFault, match="draw"):
        drawn.tools()


ENDLESS: list[object] = []
ENDLESS.append(ENDLESS)


@pytest.mark.parametrize(
    "report",
    [None, 3, ["a"], "text", {"a": ["\udcff"]}, {"\udcff": 1}, {"a": ENDLESS}, {"a": [object()]}],
    ids=["none", "number", "list", "text", "half a character", "half a key", "endless", "object"],
)
def test_wrong_reports(drawn, faulty, report):
    faulty.misdeeds["report"] = lambda *_: report
    with pytest.raises(PluginFault, match="cannot be used"):
        CALLS["report"](drawn)


def test_numbers_of_numpy_are_reported_as_plain_ones(drawn, faulty):
    told = {"a": np.float32(0.5), "b": [np.int64(3), None], "c": np.arange(2), "d": np.bool_(True)}
    faulty.misdeeds["report"] = lambda *_: told
    assert CALLS["report"](drawn) == {"a": 0.5, "b": [3, None], "c": [0, 1], "d": True}


@pytest.mark.parametrize("refusal", [UserError(""), UserError(" \n"), Unfinished("")])
def test_a_refusal_without_a_word_is_a_fault(drawn, faulty, refusal):
    def refuse(*_):
        raise refusal

    faulty.misdeeds["apply"] = refuse
    with pytest.raises(PluginFault, match=r"draw\.draw refused without a word"):
        drawn.draw(Pen().circle())


def test_an_upgrade_that_gives_no_dict(drawn, faulty):
    faulty.misdeeds["upgrade"] = lambda *_: None
    with pytest.raises(PluginFault, match="upgrade"):
        CALLS["upgrade"](drawn)


def test_a_failing_upgrade_leaves_the_object_closed_and_the_document_open(drawn, faulty, tmp_path):
    from bozzetto.document.model import OpaqueState
    from bozzetto.document.storage.bozz_file import read_document, write_document

    old = drawn.document.with_model(replace(drawn.model, state_version=1))
    write_document(old, tmp_path / "old.bozz")
    faulty.misdeeds["upgrade"] = raising(ValueError("cannot"))
    document, report = read_document(tmp_path / "old.bozz", drawn.registry)
    if not isinstance(document.models[0].state, OpaqueState):
        pytest.fail("the state was opened without its upgrade")
    assert report.warnings


def test_an_upgrade_that_changes_its_dict_and_fails_costs_nothing(drawn, faulty, tmp_path):
    from zipfile import ZipFile

    from bozzetto.document.storage.bozz_file import read_document, write_document

    def misdeed(state, version):
        state.clear()
        raise ValueError("half done")

    old = drawn.document.with_model(replace(drawn.model, state_version=1))
    write_document(old, tmp_path / "old.bozz")
    faulty.misdeeds["upgrade"] = misdeed
    document, _ = read_document(tmp_path / "old.bozz", drawn.registry)
    write_document(document, tmp_path / "again.bozz")
    before, after = ZipFile(tmp_path / "old.bozz"), ZipFile(tmp_path / "again.bozz")
    (name,) = [entry for entry in before.namelist() if entry.endswith("state.json")]
    assert after.read(name) == before.read(name)


def overwrite(target, **values):
    for name, value in values.items():
        object.__setattr__(target, name, value)


def spoil_context(context):
    overwrite(context.camera, eye=(9.0, 9.0, 9.0))
    overwrite(context.scene.layers[0], items=())


MUTATIONS = {
    "preview": lambda state, gesture, context: overwrite(state, size=9.0),
    "apply": lambda state, gesture, context: overwrite(gesture.strokes[0], x=gesture.strokes[0].y),
    "solve": lambda state, job: overwrite(state.strokes[0], group="changed", camera=None),
    "scene": lambda state, result: overwrite(state.strokes[0].camera, fov_y=1.0),
    "shapes": lambda state, result: overwrite(state, strokes=Strokes()),
    "report": lambda state, result, job: overwrite(state, table=()),
    "read_drawing": lambda drawing, context, job: drawing.facts["marks"].append(3),
    "create": spoil_context,
}


def without_revisions(scene):
    """What a scene says of itself, but for the numbers that each new layer counts on."""
    return re.sub(r"revision=\d+", "", repr(scene))


@pytest.mark.parametrize("call", MUTATIONS)
@pytest.mark.parametrize("ending", ["returns", "refuses"])
def test_arguments_are_put_back(drawn, faulty, call, ending):
    check, before = unchanged(drawn), repr(DRAWING.facts)
    scene = without_revisions(drawn.context().scene)

    def misdeed(*arguments):
        MUTATIONS[call](*arguments)
        if ending == "refuses":
            raise UserError("no")

    faulty.misdeeds[call] = misdeed
    with pytest.raises(PluginFault, match="changed its argument"):
        CALLS[call](drawn)
    check()
    assert repr(DRAWING.facts) == before
    if call not in ("solve", "scene"):
        faulty.misdeeds.clear()
        assert without_revisions(drawn.context().scene) == scene


def test_arguments_are_put_back_when_the_call_fails(drawn, faulty):
    check = unchanged(drawn)

    def misdeed(state, job):
        overwrite(state, size=9.0)
        object.__delattr__(state, "table")
        raise ValueError

    faulty.misdeeds["solve"] = misdeed
    with pytest.raises(PluginFault):
        CALLS["solve"](drawn)
    check()
    assert drawn.state.table == (1.0, 2.0)


def test_three_faults_switch_off_until_restart(drawn, faulty):
    registry = drawn.registry
    faulty.misdeeds["solve"] = raising(ValueError())
    for count in range(1, MOST_FAULTS + 1):
        with pytest.raises(PluginFault):
            CALLS["solve"](drawn)
        assert registry.guard.is_off("faulty.plugin") == (count == MOST_FAULTS)
    faulty.misdeeds.clear()
    for call in CALLS.values():
        if call is not CALLS["upgrade"]:
            with pytest.raises(UserError, match="switched off"):
                call(drawn)
    assert CALLS["upgrade"](drawn) == {"size": 1.0}
    assert registry.guard.faults("faulty.plugin") == MOST_FAULTS
    assert registry.guard.faults("faulty.plugin") == MOST_FAULTS
    (info,) = [info for info in registry.plugins() if info.id == "faulty.plugin"]
    assert info.status == "broken"
    assert not registry.guard.is_off("bozzetto.silhouette")
    assert registry.modeler("bozzetto.silhouette")


def test_a_tool_kept_from_before_is_refused_too(drawn, faulty):
    (tool,) = drawn.tools()
    for _ in range(MOST_FAULTS):
        drawn.registry.guard.blame("faulty.modeler", "did not answer")
    gesture = Ink((Pen().circle(),))
    with pytest.raises(UserError, match="switched off"):
        drawn.workbench.apply(drawn.model, tool, gesture, drawn.context())


def test_faults_are_logged_with_their_traceback(drawn, faulty, caplog):
    faulty.misdeeds["solve"] = FAILURES["ValueError"]
    with caplog.at_level(logging.ERROR, "bozzetto.plugin"), pytest.raises(PluginFault):
        CALLS["solve"](drawn)
    assert "out of\nluck" in caplog.text
    assert "Traceback" in caplog.text


def test_a_guard_without_a_registry_blames_the_modeler():
    with pytest.raises(PluginFault) as caught:
        Guard().call("a.b", "solve", lambda: 1 / 0)
    assert caught.value.plugin == "a.b"


def test_a_fault_names_its_plugin_as_the_window_does():
    """By title, and by the id with which a terminal switches it off."""
    registry = Registry()
    with pytest.raises(PluginFault, match=r"The plugin “Car” \(bozzetto\.car\) made a mistake"):
        registry.guard.call("bozzetto.car", "solve", lambda: 1 / 0)


def test_to_be_slow_is_told_as_slow_and_does_not_count(caplog):
    guard = Guard()
    for _ in range(5):
        found = guard.suspect("slow.modeler", "solve gave no answer within 60 s", "its stack")
    assert str(found) == "The plugin slow.modeler is slow: solve gave no answer within 60 s."
    assert "slow.modeler is slow" in caplog.text
    assert "mistake" not in caplog.text
    assert found.details == "its stack"
    assert guard.faults("slow.modeler") == 0
    assert not guard.is_off("slow.modeler")
