"""The walls between the rooms: each contract catches what it is there to catch."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("core", "app", "plugins")
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGES = sorted(path.parent for room in ROOMS for path in ROOT.glob(f"{room}/*/__init__.py"))
PLUGINS = [package.name for package in PACKAGES if package.parent.name == "plugins"]


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the sources that a test may spoil."""
    copy = tmp_path_factory.mktemp("rooms")
    shutil.copy(ROOT / "pyproject.toml", copy)
    for room in ROOMS:
        shutil.copytree(ROOT / room, copy / room, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def lint(rooms: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(str(rooms / room) for room in ROOMS)
    lint_imports = Path(sys.executable).with_name("lint-imports")
    return subprocess.run(
        [lint_imports, "--no-cache"],
        cwd=rooms,
        env={**os.environ, "PYTHONPATH": path, "COLUMNS": "200"},
        capture_output=True,
        text=True,
    )


def test_the_sources_keep_all_contracts(rooms: Path) -> None:
    done = lint(rooms)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("package", "statement", "contract"),
    [
        ("core/bozzetto", "import PySide6.QtCore", "The core knows neither"),
        ("core/bozzetto", "import pyqtgraph", "The core knows neither"),
        ("core/bozzetto", "import bozzetto_app", "The core knows neither"),
        ("app/bozzetto_app", "import bozzetto_silhouette", "The shell knows no plugin"),
        ("plugins/bozzetto_mesh", "import bozzetto_app", "A plugin uses the public contract"),
        (
            "plugins/bozzetto_mesh",
            "from bozzetto.ink.curves.resample import resample",
            "A plugin uses the public contract",
        ),
        ("plugins/bozzetto_mesh", "import bozzetto.workbench", "A plugin uses the public contract"),
        ("plugins/bozzetto_mesh", "import bozzetto_silhouette", "No plugin knows another"),
    ],
)
def test_an_import_through_a_wall_is_caught(
    rooms: Path, package: str, statement: str, contract: str
) -> None:
    intruder = rooms / package / "intruder.py"
    intruder.write_text(f"def late() -> None:\n    {statement}\n")
    try:
        done = lint(rooms)
    finally:
        intruder.unlink()
    assert done.returncode == 1, done.stdout + done.stderr
    (broken,) = [line for line in done.stdout.splitlines() if " BROKEN" in line]
    assert broken.startswith(contract)


def test_types_come_through_the_doors_too() -> None:
    """import-linter passes over imports for type checkers only."""
    (public,) = (c for c in PROJECT["tool"]["importlinter"]["contracts"] if "ignore_imports" in c)
    doors = {line.removeprefix("** -> ") for line in public["ignore_imports"]}
    found = {
        (door, path.relative_to(ROOT).as_posix())
        for path in (ROOT / "plugins").rglob("*.py")
        for door in re.findall(
            r"^\s*from (bozzetto(?:\.\w+)*) import", path.read_text(encoding="utf-8"), re.MULTILINE
        )
    }
    assert {door for door, _ in found} >= {"bozzetto.plugin", "bozzetto.ink"}
    assert not {(door, path) for door, path in found if door not in doors}


def test_every_package_stands_in_every_list() -> None:
    """A new plugin is forgotten by none of the places that name all of them."""
    names = [package.name for package in PACKAGES]
    wheel = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert sorted(wheel) == sorted(str(each.relative_to(ROOT).as_posix()) for each in PACKAGES)
    listed = PROJECT["project"]["entry-points"]["bozzetto.plugins"].values()
    assert sorted(listed) == [
        name for name in PLUGINS if (ROOT / f"plugins/{name}/plugin.toml").exists()
    ]
    linter = PROJECT["tool"]["importlinter"]
    assert sorted(linter["root_packages"]) == sorted(names)
    core, shell, public, independent, *layers = linter["contracts"]
    assert set(core["forbidden_modules"]) >= set(names) - {"bozzetto"}
    for named in (shell["forbidden_modules"], public["source_modules"], independent["modules"]):
        assert sorted(named) == PLUGINS
    assert {each["type"] for each in layers} == {"layers"}


@pytest.mark.parametrize(
    "contract",
    [each for each in PROJECT["tool"]["importlinter"]["contracts"] if each["type"] == "layers"],
    ids=lambda each: each["containers"][0],
)
def test_every_room_has_its_layer(contract) -> None:
    """import-linter does not look at rooms that a contract leaves out."""
    (name,) = contract["containers"]
    (package,) = (each for each in PACKAGES if each.name == name)
    rooms = {path.stem for path in package.glob("*.py")} | {
        path.parent.name for path in package.glob("*/__init__.py")
    }
    named = {room for layer in contract["layers"] for room in layer.split(" | ")}
    assert named == rooms - {"__init__", "__main__"}


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_every_package_is_typed(package: Path) -> None:
    assert (package / "py.typed").is_file()
