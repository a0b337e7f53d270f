"""Templates that plugins bring: the worked example of the author's guide, and broken ones."""

from __future__ import annotations

import importlib
import json
import re
import shutil
import sys
from pathlib import Path

import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin.host.manifest import ManifestError, read_manifest
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing.lint import check_package
from bozzetto.workbench.workbench import Workbench
from bozzetto_car.template.kept_templates import plugin_template
from bozzetto_car.template.schema import LARGEST_FILE

DOCS = Path(__file__).resolve().parents[4] / "docs"
EXAMPLE = DOCS / "examples" / "bozzetto_roadsters"
CAR = "bozzetto.car"
NAME = "example.roadsters/roadster"


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A copy of the example, as an installed package; its file of the template."""
    shutil.copytree(EXAMPLE / "bozzetto_roadsters", tmp_path / "bozzetto_roadsters")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    yield tmp_path / "bozzetto_roadsters" / "templates" / "roadster.json"
    sys.modules.pop("bozzetto_roadsters", None)


def registry() -> Registry:
    return Registry(extra=("bozzetto_roadsters",))


def test_the_guide_prints_the_example():
    guide = (DOCS / "plugin-authors-guide.md").read_text("utf-8")
    printed = re.findall(r"<!-- example: (\S+) -->\n```\w+\n(.*?)```\n", guide, re.S)
    assert [name for name, _ in printed] == ["bozzetto_roadsters/plugin.toml"]
    for name, text in printed:
        assert (EXAMPLE / name).read_text("utf-8") == text


def test_the_example_is_in_order(package):
    assert check_package("bozzetto_roadsters") == []
    (info,) = [one for one in registry().plugins() if one.id == "example.roadsters"]
    assert (info.status, info.fault) == ("ready", "")


def test_a_marks_file_begins_with_it(package, tmp_path):
    marks = {"C1": [9.0, 9.0]}
    view = {"image": {"width": 99, "height": 99}, "marks": marks}
    path = tmp_path / "car.json"
    path.write_text(json.dumps({"template": NAME, "views": [view]}))
    bench = Workbench(registry())
    model = bench.sources.from_drawing(CAR, read_drawing(path), {})
    assert model.state.template == "own"
    assert json.loads(model.state.own) == json.loads(package.read_text())
    path.write_text(json.dumps({"template": "example.none/roadster", "views": [view]}))
    with pytest.raises(UserError, match=NAME):
        bench.sources.from_drawing(CAR, read_drawing(path), {})


DAMAGED = {
    "cut off": (lambda text: text[:300], "JSON"),
    "a key": (lambda text: text.replace('"patches"', '"patchse"', 1), "patchse"),
    "a node": (lambda text: text.replace('"C2.x', '"C99.x', 1), "C99"),
    "no text": (lambda text: "\ud800", "UTF-8"),
    "large": (lambda text: " " * (LARGEST_FILE + 1), "larger"),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_a_broken_one_is_told_by_its_plugin(package, case):
    damage, told = DAMAGED[case]
    package.write_bytes(damage(package.read_text()).encode("utf-8", "surrogatepass"))
    (file,) = registry().templates(CAR)
    with pytest.raises(UserError, match="Roadsters") as caught:
        plugin_template(file)
    assert "roadster.json" in caught.value.message
    assert told in caught.value.message
    findings = check_package("bozzetto_roadsters")
    assert findings
    assert all(one.serious and one.where == "templates/roadster.json" for one in findings)


def test_a_missing_one_is_told(package):
    package.unlink()
    (file,) = registry().templates(CAR)
    with pytest.raises(UserError, match="Roadsters"):
        plugin_template(file)
    assert [str(one) for one in check_package("bozzetto_roadsters")] == [
        "error: templates/roadster.json: this template is missing"
    ]


def test_a_plugin_that_is_switched_off_brings_none(package):
    made = registry()
    made.set_disabled("example.roadsters", True)
    assert made.templates(CAR) == ()


def test_a_modeler_that_is_not_there_is_a_note(package):
    manifest = package.parents[1] / "plugin.toml"
    manifest.write_text(manifest.read_text().replace("bozzetto.car", "example.boats"))
    (finding,) = check_package("bozzetto_roadsters")
    assert not finding.serious
    assert "no plugin here has this modeler" in finding.message


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("", "neither a \\[\\[modeler\\]\\] nor \\[templates\\]"),
        ('[templates]\n"bozzetto.car" = []', "templates"),
        ('[templates]\n"bozzetto.car" = "t.json"', "templates"),
        ('[templates]\ncar = ["t.json"]', "id such as"),
        ('[templates]\n"bozzetto.car" = ["../t.json"]', "inside the package"),
        ('[templates]\n"bozzetto.car" = ["t.exe"]', "ends with .json"),
    ],
)
def test_a_manifest_that_makes_no_sense_is_refused(tmp_path, line, told):
    head = 'id = "a.b"\ntitle = "T"\nversion = "1"\napi = ">=2,<3"\n'
    (tmp_path / "plugin.toml").write_text(head + line)
    with pytest.raises(ManifestError, match=told):
        read_manifest(tmp_path)
