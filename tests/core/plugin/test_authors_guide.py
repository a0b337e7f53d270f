"""What the guide says is so: its files are the example's, its pieces of code run."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest

from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin import API_VERSION, Modeler, PanelHost, PartsModeler, PartsState, Tool, hooks
from bozzetto.plugin.hooks import hookimpl
from bozzetto.plugin.host.manifest import read_manifest
from bozzetto.testing import ModelerContract, Pen, Shell
from bozzetto.testing.checks import CHECKS
from bozzetto.view import Camera

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / "docs" / "examples" / "bozzetto_ribbon"
GUIDE = (ROOT / "docs" / "plugin-authors-guide.md").read_text("utf-8")
FILES = dict(re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```\n", GUIDE, re.S))
PIECES = re.findall(r"(?<!-->\n)```python\n(.*?)```", GUIDE, re.S)


@pytest.mark.parametrize("name", FILES)
def test_printed_files_are_the_examples(name):
    assert (EXAMPLE / name).read_text("utf-8") == FILES[name]


def test_code_imports_from_doors_alone():
    """What the guide and both examples import is promised by the toolkit's table of doors."""
    toolkit = (ROOT / "docs" / "toolkit.md").read_text("utf-8")
    doors = set(re.findall(r"^\| `([\w.]+)` \| ", toolkit.partition("## All names")[0], re.M))
    assert "bozzetto.geometry.patches" in doors
    doors |= {"bozzetto.plugin", "bozzetto.testing", "bozzetto_app.testing"}
    sources = [path.read_text("utf-8") for path in EXAMPLE.parent.rglob("*.py")]
    for code in (*PIECES, *sources):
        for name in re.findall(r"^\s*from (bozzetto(?:_app)?(?:\.\w+)*) import", code, re.M):
            assert name in doors, name


def test_every_source_file_is_printed():
    sources = {
        path.relative_to(EXAMPLE).as_posix()
        for ending in ("py", "toml")
        for path in EXAMPLE.rglob(f"*.{ending}")
    }
    assert set(FILES) == sources


def test_every_method_of_a_modeler_and_a_tool_is_explained():
    for kind in (Modeler, PartsModeler, PartsState, Tool):
        for name, member in vars(kind).items():
            if not name.startswith("_") and inspect.isfunction(member):
                assert re.search(rf"\b{name}\b", GUIDE), f"{kind.__name__}.{name}"


def test_checks_hooks_and_helpers_are_explained():
    for check in CHECKS:
        assert f"* `{check.name}`:" in GUIDE
    for name in dir(hooks):
        if name.startswith("bozzetto_"):
            assert name in GUIDE
    for kind in (Pen, Shell):
        for name, member in vars(kind).items():
            if not name.startswith("_") and inspect.isfunction(member):
                assert re.search(rf"\b{name}\b", GUIDE), name


def test_manifest_keys_are_explained(tmp_path):
    """A manifest made of the keys in the guide's table is read without a warning."""
    table = GUIDE.partition("| key | meaning |")[2].partition("\n\n")[0]
    keys = set(re.findall(r"`(\w+)`", "\n".join(r.split("|")[1] for r in table.splitlines()[2:])))
    values = {
        "id": '"a.b"',
        "title": '"T"',
        "version": '"1"',
        "summary": '"S"',
        "api": '">=2,<3"',
        "checks_files": "true",
        "icon": '"i.svg"',
        "hint": '"H"',
        "samples": '["s.json"]',
        "order": "1",
        "listed": "false",
        "abilities": '["panel", "read_shapes"]',
        "facts": '"template"',
        "sides": '{ front = "left", left = "front" }',
        "replaces": "true",
        "templates": '{ "bozzetto.car" = ["t.json"] }',
    }
    assert keys == values.keys()
    top = ("id", "title", "version", "summary", "api", "checks_files", "templates")
    inner = tuple(key for key in values if key not in top or key in ("id", "title"))
    text = "\n".join(f"{key} = {values[key]}" for key in top)
    text += "\n[[modeler]]\n" + "\n".join(f"{key} = {values[key]}" for key in inner)
    (tmp_path / "plugin.toml").write_text(text)
    assert read_manifest(tmp_path).warnings == ()


def test_ink_file_can_be_read(tmp_path):
    (piece,) = re.findall(r"<!-- ink -->\n```json\n(.*?)```", GUIDE, re.S)
    path = tmp_path / "drawing.json"
    path.write_text(piece, encoding="utf-8")
    (stroke,) = read_drawing(path).strokes
    assert stroke.camera == Camera()
    assert stroke.has_pressure


def test_what_each_version_of_the_contract_added_is_told():
    """An author learns from it which version to ask for; the manifest takes the newest."""
    rows = re.findall(r"^\| (2\.\d+) \| ", GUIDE.partition("### Versions of the contract")[2], re.M)
    major, minor = API_VERSION
    assert rows == [f"{major}.{number}" for number in range(1, minor + 1)]


def test_panel_host_is_explained():
    for name in vars(PanelHost):
        if not name.startswith("_"):
            assert f"`host.{name}" in GUIDE


def test_short_pieces_of_code_run():
    assert PIECES
    for piece in PIECES:
        exec(piece, {"hookimpl": hookimpl, "ModelerContract": ModelerContract})  # noqa: S102
