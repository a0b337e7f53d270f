from __future__ import annotations

import pytest

from bozzetto.testing.lint import check_package, icon_fault

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


def messages(package):
    return "\n".join(map(str, check_package(package)))


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


@pytest.mark.parametrize("is_a_person", [True, False])
def test_progress_goes_to_a_screen_and_not_into_a_file(is_a_person, capsys, monkeypatch):
    from bozzetto.cli.output import say_on_screen

    monkeypatch.setattr("sys.stderr.isatty", lambda: is_a_person)
    say_on_screen("author.thing, ranges (13 of 26)")
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == ("author.thing, ranges (13 of 26) …\n" if is_a_person else "")


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
