"""A plugin that is begun with ``bozzetto plugins new`` is whole as it stands."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from bozzetto.cli.main import main
from bozzetto.plugin.host.manifest import read_manifest
from bozzetto.testing.lint import icon_fault


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_everything_is_written_with_its_name(here, capsys):
    assert main(["plugins", "new", "osaka.wire_frame"]) == 0
    assert "bozzetto plugins check bozzetto_wire_frame" in capsys.readouterr().out
    root = here / "bozzetto_wire_frame"
    package = root / "bozzetto_wire_frame"
    (modeler,) = read_manifest(package).modelers
    assert (modeler.id, modeler.title) == ("osaka.wire_frame", "Wire frame")
    assert icon_fault(package / modeler.icon) == ""
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    assert project["name"] == "bozzetto-wire-frame"
    assert project["entry-points"]["bozzetto.plugins"] == {"wire_frame": "bozzetto_wire_frame"}
    assert project["license"] == "MIT"
    assert "Permission is hereby granted" in (root / "LICENSE").read_text()
    written = [path for path in root.rglob("*") if path.is_file()]
    assert {".github", "tests", "README.md", ".gitignore"} <= {path.name for path in root.iterdir()}
    for path in written:
        assert "{{" not in path.read_text("utf-8")
        assert not path.name.endswith(".txt")


def test_without_a_licence(here):
    assert main(["plugins", "new", "osaka.wire", "--license", "none"]) == 0
    assert not (here / "bozzetto_wire" / "LICENSE").exists()
    project = tomllib.loads((here / "bozzetto_wire" / "pyproject.toml").read_text())["project"]
    assert "license" not in project


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["wire"], "is no id for a plugin"),
        (["Osaka.Wire"], "is no id for a plugin"),
        (["osaka.wire-frame"], "is no id for a plugin"),
        (["osaka.wire\n"], "is no id for a plugin"),
        (["../osaka.wire"], "is no id for a plugin"),
        (["osaka." + "w" * 80], "is no id for a plugin"),
        (["osaka.silhouette"], "installed already"),
        (["osaka.app"], "installed already"),
        (["osaka.wire", "--license", "GPL"], "no licence 'GPL'"),
        ([], "such as author.thing"),
    ],
)
def test_names_that_cannot_be_are_refused(here, capsys, words, told):
    assert main(["plugins", "new", *words]) != 0
    assert told in capsys.readouterr().err
    assert list(here.iterdir()) == []


def test_what_is_there_is_not_written_over(here, capsys):
    mine = here / "bozzetto_wire" / "mine.txt"
    mine.parent.mkdir()
    mine.write_text("mine")
    assert main(["plugins", "new", "osaka.wire"]) != 0
    assert "is there already" in capsys.readouterr().err
    assert [path.name for path in mine.parent.iterdir()] == ["mine.txt"]


def test_a_folder_that_cannot_be_written_is_told(here, capsys, monkeypatch):
    def refuse(self, *arguments, **options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", refuse)
    assert main(["plugins", "new", "osaka.wire"]) != 0
    assert "Permission denied" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("thing", ["wire_frame", "tool", "modeler"])
def test_it_passes_the_check_its_own_tests_and_strict_mypy(here, thing):
    assert main(["plugins", "new", f"osaka.{thing}"]) == 0
    root = here / f"bozzetto_{thing}"
    # Installed in the eyes of importlib.metadata: a package beside its metadata.
    metadata = root / f"bozzetto_{thing}-0.1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: bozzetto-{thing}\nVersion: 1\n"
    )
    (metadata / "entry_points.txt").write_text(f"[bozzetto.plugins]\n{thing} = bozzetto_{thing}\n")
    announced = any(e.value == "bozzetto.testing.fixtures" for e in entry_points(group="pytest11"))
    kit = [] if announced else ["-p", "bozzetto.testing.fixtures"]
    path = os.pathsep.join([str(root), *(entry for entry in sys.path if entry)])
    for words, told in (
        (["bozzetto.cli.main", "plugins", "check", f"bozzetto_{thing}"], "in order"),
        (["pytest", "-q", "-p", "no:cacheprovider", *kit, "tests"], " passed"),
        (["mypy", "--strict", f"bozzetto_{thing}", "tests"], "no issues found"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", *words],
            capture_output=True,
            text=True,
            check=False,
            cwd=root,
            env=os.environ | {"PYTHONPATH": path},
        )
        assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
        assert told in done.stdout
