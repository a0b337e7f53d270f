from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pytest

from bozzetto.plugin import Parameter
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.testing.lint import check_package, icon_fault
from tests.core.plugin.conftest import GOOD_MANIFEST, Faulty, FaultyState, messages

from_svg = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">{}</svg>'
)

DANGEROUS = {
    "script": "<script>alert(1)</script>",
    "script in another case": "<SCRIPT/>",
    "script with a prefix": '<s:script xmlns:s="http://www.w3.org/2000/svg"/>',
    "handler": '<path onload="alert(1)"/>',
    "handler in another case": '<path onClick="x()"/>',
    "link": '<a href="javascript:alert(1)"/>',
    "outside image": '<image xlink:href="http://example.org/x.png"/>',
    "outside use": '<use xlink:href="file:///etc/passwd#x"/>',
    "foreign content": "<foreignObject><b/></foreignObject>",
    "style sheet": "<style>@import url(http://example.org/x.css)</style>",
    "outside paint": '<path fill="url(http://example.org/x.svg#a)"/>',
}


@pytest.mark.parametrize("content", DANGEROUS.values(), ids=DANGEROUS)
def test_icons_must_not_do_anything(tmp_path, content):
    path = tmp_path / "icon.svg"
    path.write_text(from_svg.format(content))
    assert "must not contain" in icon_fault(path)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"not xml",
        b"<svg>",
        b"<html/>",
        b"<svg/><svg/>",
        b"\x89PNG\r\n",
        b'<!DOCTYPE svg [<!ENTITY a "b">]><svg/>',
        b'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg>&a;</svg>',
        b"<svg>" + b" " * 100_000 + b"</svg>",
    ],
)
def test_what_is_no_icon(tmp_path, content):
    path = tmp_path / "icon.svg"
    path.write_bytes(content)
    assert icon_fault(path)


def test_a_plain_icon_is_fine(tmp_path):
    path = tmp_path / "icon.svg"
    path.write_text(from_svg.format('<defs><path id="a" d="M0 0h9"/></defs><use href="#a"/>'))
    assert icon_fault(path) == ""
    assert "missing" in icon_fault(tmp_path / "none.svg")


def test_findings_name_the_place(make_package, faulty):
    assert "error: nowhere_at_all" in messages("nowhere_at_all")
    assert "plugin.toml" in messages(make_package("", None))
    assert "ZeroDivisionError" in messages(make_package("1 / 0"))


def test_a_plugin_under_development_is_checked_whole(faulty, monkeypatch):
    from bozzetto.testing import checks
    from bozzetto.testing import lint as check

    # A process of its own knows nothing of this modeler.
    rest = [entry for entry in checks.CHECKS if entry.name not in ("elsewhere", "fresh_process")]
    monkeypatch.setattr(checks, "CHECKS", rest)
    assert check.check_package(faulty.package) == []
    faulty.misdeeds["shapes"] = lambda state, result: None
    findings = check.check_package(faulty.package)
    (finding,) = findings
    assert finding.serious
    assert finding.where.startswith("faulty.modeler, empty, drawing and ")


FAILING = """
from bozzetto.plugin import Modeler, hookimpl
from bozzetto.scene import Scene
from dataclasses import dataclass

@dataclass(frozen=True)
class State:
    pass

class Failing(Modeler):
    id, state_type = __name__ + ".modeler", State
    def solve(self, state, job):
        return {}["here"]
    def scene(self, state, result):
        return Scene()
    shapes = solve

@hookimpl
def bozzetto_modelers():
    return [Failing()]
"""


def test_one_fault_is_told_once_and_with_its_line(make_package):
    package = make_package(FAILING)
    line = 1 + FAILING.splitlines().index('        return {}["here"]')
    told = messages(package)
    assert told.count(f"__init__.py, line {line})") == 1
    assert told.count("solve failed") == 2, "here, and in another process"


@pytest.mark.parametrize(
    ("wrong", "line", "told"),
    [
        ("from bozzetto.geometry import Shapez", None, "cannot import name 'Shapez'"),
        ("class Failing(Modeler)", "clas Failing(Modeler)", "SyntaxError"),
        ("@dataclass(frozen=True)", "1 / 0", "ZeroDivisionError"),
    ],
)
def test_what_cannot_be_imported_is_told_with_its_line(make_package, wrong, line, told):
    code = f"{wrong}\n{FAILING}" if line is None else FAILING.replace(wrong, line)
    number = code.splitlines().index(line or wrong) + 1 if line != "clas Failing(Modeler)" else 10
    (finding,) = check_package(make_package(code))
    assert told in finding.message
    assert finding.message.endswith(f"__init__.py, line {number})")
    assert "tell its author" not in finding.message, "its author reads it"


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("@dataclass(frozen=True)\n", "", "state_type must be a frozen dataclass"),
        ("    pass", "    size: Annotated[int, Parameter(least=1)] = 3", "argument 'least'"),
    ],
)
def test_a_state_that_cannot_be_read_is_told_and_ends_nothing(make_package, right, wrong, told):
    code = "from typing import Annotated\nfrom bozzetto.plugin import Parameter\n"
    assert told in messages(make_package(code + FAILING.replace(right, wrong)))


def test_a_drawing_that_the_front_view_refuses_is_tried_from_the_better_one(faulty):
    from bozzetto.errors import UserError
    from bozzetto.plugin import ViewAdvice
    from bozzetto.testing.subject import Subject
    from bozzetto.view import look_along

    def advise(state, camera, job):
        if camera.axes[2][2] < -0.5:
            return ViewAdvice("good", "")
        return ViewAdvice("refuse", "Too flat", better=look_along(camera, (0.0, 0.0, -1.0)))

    def draw(state, ink, context):
        if ink.camera.axes[2][2] > -0.5:
            raise UserError("Look from above.")
        return type(state)(state.strokes.extended(ink.strokes))

    faulty.misdeeds["apply"] = draw
    with (
        pytest.raises(UserError, match="above"),
        Subject("faulty.modeler", (faulty.package,)).drawn(),
    ):
        pass
    type(faulty).view_advice = staticmethod(advise)
    try:
        with Subject("faulty.modeler", (faulty.package,)).drawn() as shell:
            assert shell.state.strokes[0].camera.axes[2][2] < -0.5
    finally:
        del type(faulty).view_advice


def test_the_id_of_an_installed_plugin_does_as_well(monkeypatch):
    from bozzetto.testing import checks

    monkeypatch.setattr(checks, "CHECKS", ())
    assert check_package("bozzetto.mesh") == check_package("bozzetto_mesh") == []


def test_a_person_sees_which_check_is_at_work(faulty, monkeypatch):
    from bozzetto.testing import checks

    chosen = [entry for entry in checks.CHECKS if entry.name in ("announced", "empty")]
    monkeypatch.setattr(checks, "CHECKS", chosen)
    told = []
    assert check_package(faulty.package, told.append) == []
    assert told == ["faulty.modeler, announced (1 of 2)", "faulty.modeler, empty (2 of 2)"]


def test_what_was_found_is_told_before_the_next_modeler_is_tried(make_package, monkeypatch):
    from bozzetto.testing import checks
    from bozzetto.testing.lint import findings_in

    chosen = [entry for entry in checks.CHECKS if entry.name == "empty"]
    monkeypatch.setattr(checks, "CHECKS", chosen)
    second = GOOD_MANIFEST.split("[[modeler]]")[1].replace("}.modeler", "}.second")
    code = FAILING.replace(
        "[Failing()]", '[Failing(), type("Second", (Failing,), {"id": second})()]'
    )
    package = make_package(
        "second = __name__ + '.second'" + code, f"{GOOD_MANIFEST}[[modeler]]{second}"
    )
    begun: list[str] = []
    found = findings_in(package, begun.append)
    assert next(found).where.startswith(f"{package}.modeler")
    assert begun == [f"{package}.modeler, empty (1 of 1)"]
    assert [one.where.partition(",")[0] for one in found] == [f"{package}.second"]


@pytest.mark.parametrize(
    ("faces", "told"),
    [
        ([], "is without triangles"),
        ([(0, 2, 1), (0, 1, 3), (1, 2, 3)], "is not closed: 3 of its edges"),
        (
            [(0, 1, 2), (0, 3, 1), (1, 3, 2), (0, 2, 3)],
            "is inside out or flat: its volume is -166.7 mm³",
        ),
    ],
    ids=["nothing", "open", "inside out"],
)
def test_what_is_wrong_with_a_solid_is_told(faulty, monkeypatch, faces, told):
    from bozzetto.geometry import Mesh, Shapes, Solid
    from bozzetto.testing import checks

    chosen = [entry for entry in checks.CHECKS if entry.name == "drawing"]
    monkeypatch.setattr(checks, "CHECKS", chosen)
    corners = [(0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (0.0, 10.0, 0.0), (0.0, 0.0, 10.0)]
    mesh = Mesh(corners, np.reshape(np.array(faces, np.int32), (-1, 3)))
    faulty.misdeeds["shapes"] = lambda state, result: Shapes(solids=(Solid(mesh, "box"),))
    (finding,) = check_package(faulty.package)
    assert f"the solid 'box' {told}" in finding.message


@pytest.mark.parametrize("is_a_person", [True, False])
def test_progress_goes_to_a_screen_and_not_into_a_file(is_a_person, capsys, monkeypatch):
    from bozzetto.cli.output import say_on_screen

    monkeypatch.setattr("sys.stderr.isatty", lambda: is_a_person)
    say_on_screen("author.thing, ranges (13 of 26)")
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == ("author.thing, ranges (13 of 26) …\n" if is_a_person else "")


@dataclass(frozen=True)
class Wide(FaultyState):
    width: Annotated[float, Parameter("Width", 0.0, 1.0, tools=("drow",))] = 0.5


def test_a_parameter_of_a_tool_that_is_not_there_is_told(faulty, monkeypatch):
    from bozzetto.testing import checks

    chosen = [entry for entry in checks.CHECKS if entry.name == "announced"]
    monkeypatch.setattr(checks, "CHECKS", chosen)
    assert check_package(faulty.package) == []
    monkeypatch.setattr(Faulty, "state_type", Wide)
    faulty.misdeeds["create"] = lambda context: Wide()
    (finding,) = check_package(faulty.package)
    assert "width: tools names 'drow'" in finding.message


def test_a_panel_that_is_announced_and_missing_is_found(make_package, faulty, monkeypatch):
    from bozzetto.testing import checks

    monkeypatch.setattr(checks, "CHECKS", ())
    package = make_package(FAILING, GOOD_MANIFEST + 'abilities = ["panel"]\n')
    assert "no hook bozzetto_panel" in messages(package)
    assert check_package(faulty.package) == []


def test_a_drawing_that_is_not_plain_is_only_a_note(faulty, monkeypatch):
    from bozzetto.errors import UserError
    from bozzetto.testing import checks
    from bozzetto.testing import lint as check

    def refuse(*_):
        raise UserError("Draw two circles.")

    rest = [entry for entry in checks.CHECKS if entry.name == "drawing"]
    monkeypatch.setattr(checks, "CHECKS", rest)
    faulty.misdeeds["apply"] = refuse
    (finding,) = check.check_package(faulty.package)
    assert not finding.serious
    assert "Draw two circles." in finding.message


def test_files_of_a_plugins_own_are_checked_by_it(tmp_path, capsys):
    from importlib.resources import files

    from bozzetto.cli.main import main

    sedan = files("bozzetto_car").joinpath("templates/sedan.json").read_bytes()
    good, bad, other = (tmp_path / name for name in ("good.json", "bad.json", "other.json"))
    good.write_bytes(sedan)
    bad.write_bytes(sedan.replace(b'"C3.x >= C2.x', b'"C9.x >= C2.x'))
    other.write_text("{}")
    assert main(["plugins", "check", str(good)]) == 0
    assert "in order" in capsys.readouterr().out
    assert main(["plugins", "check", str(bad)]) != 0
    assert "C9" in capsys.readouterr().out
    assert main(["plugins", "check", str(other)]) != 0
    assert "No plugin knows" in capsys.readouterr().err


def test_a_call_that_never_answers_is_named_and_the_rest_is_left(faulty, monkeypatch):
    from bozzetto.testing import call_watch

    def hang(*_):
        while True:
            pass

    monkeypatch.setattr(call_watch, "LONGEST_CALL", 0.5)
    faulty.misdeeds["apply"] = hang
    (finding,) = check_package(faulty.package)
    assert finding.serious
    assert "draw.draw gave no answer for 0.5 s" in finding.message
    assert "checks were not tried" in finding.message


def test_what_an_import_could_not_bring_is_not_told_besides(make_package):
    told = f'{GOOD_MANIFEST}abilities = ["panel"]\n'
    (finding,) = check_package(make_package("def f(:", told))
    assert "SyntaxError" in finding.message


STEPPING = """
from dataclasses import dataclass, replace
from bozzetto.geometry import Shapes
from bozzetto.plugin import Modeler, Tool, UserError, hookimpl
from bozzetto.scene import Scene

@dataclass(frozen=True)
class State:
    height: float = 0.0

class Pull(Tool):
    id, title, hint, gesture, grabs, plays = "pull", "Pull", "Pull it.", "drag", True, True
    def step(self, state, held, seconds, context):
        return GIVES

class Stepping(Modeler):
    id, state_type = __name__ + ".modeler", State
    def tools(self):
        return (Pull(),)
    def solve(self, state, job):
        return 0
    def scene(self, state, result):
        return Scene()
    def shapes(self, state, result):
        return Shapes()

@hookimpl
def bozzetto_modelers():
    return [Stepping()]
"""


@pytest.mark.parametrize(
    ("gives", "told"),
    [
        ("replace(state, height=state.height + seconds)", ""),
        ("None", "pull.step gave what cannot be used"),
        ("held.path", "pull.step failed (AttributeError"),
        ("replace(state, height=__import__('random').random())", "second time"),
    ],
)
def test_steps_in_time_are_checked(make_package, gives, told):
    from bozzetto.testing.motion_checks import check_steps
    from bozzetto.testing.subject import Broken, Subject

    package = make_package(STEPPING.replace("GIVES", gives))
    subject = Subject(f"{package}.modeler", (package,))
    if not told:
        check_steps(subject)
        return
    with pytest.raises((Broken, PluginFault)) as problem:
        check_steps(subject)
    assert told in str(problem.value)


def test_a_tool_that_plays_without_a_step_is_told(make_package):
    from bozzetto.testing.motion_checks import check_steps
    from bozzetto.testing.subject import Broken, Subject

    package = make_package(STEPPING.replace("def step", "def stepp").replace("GIVES", "state"))
    with pytest.raises(Broken, match="plays, and has no step"):
        check_steps(Subject(f"{package}.modeler", (package,)))
