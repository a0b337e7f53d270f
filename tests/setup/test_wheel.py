"""The wheel holds the program, all of it, and it runs from there."""

from __future__ import annotations

import email
import email.message
import os
import subprocess
import sys
import tomllib
import venv
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PLUGINS = PROJECT["entry-points"]["bozzetto.plugins"]


def run(*command: object, **options: Any) -> str:
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, **options)
    assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory, outside: dict[str, str]) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    build = ["-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT]
    run(sys.executable, *build, env=outside)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="session")
def unpacked(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="session")
def metadata(unpacked: Path) -> email.message.Message:
    (file,) = unpacked.glob("*.dist-info/METADATA")
    return email.message_from_string(file.read_text("utf-8"))


def by_name(requirements: Iterable[Requirement]) -> dict[str, SpecifierSet]:
    return {canonicalize_name(each.name): each.specifier for each in requirements}


def sources() -> set[str]:
    """Return every file below a package folder, named as the wheel should name it."""
    return {
        path.relative_to(room).as_posix()
        for room in (ROOT / "core", ROOT / "app", ROOT / "plugins")
        for path in room.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def test_holds_every_file_of_the_packages_and_nothing_else(unpacked: Path) -> None:
    packed = {path.relative_to(unpacked).as_posix() for path in unpacked.rglob("*")}
    files = {name for name in packed if (unpacked / name).is_file() and ".dist-info/" not in name}
    guide = {name for name in files if name.startswith("bozzetto_app/guide/")}
    assert files - guide == sources()
    assert "bozzetto_app/guide/guide.md" in guide


@pytest.mark.parametrize("package", PLUGINS.values())
def test_holds_what_a_plugin_needs_besides_code(unpacked: Path, package: str) -> None:
    manifest = tomllib.loads((unpacked / package / "plugin.toml").read_text("utf-8"))
    for modeler in manifest["modeler"]:
        assert (unpacked / package / modeler["icon"]).is_file()
        for sample in modeler.get("samples", ()):
            assert (unpacked / package / sample["file"]).is_file()


def test_metadata(unpacked: Path, metadata: email.message.Message) -> None:
    from bozzetto import __version__

    assert metadata["Name"] == "bozzetto"
    assert metadata["Version"] == __version__
    assert metadata["License-Expression"] == "Apache-2.0"
    required = [Requirement(each) for each in metadata.get_all("Requires-Dist", [])]
    runtime = [each for each in required if not each.marker]
    assert by_name(runtime) == by_name(Requirement(each) for each in PROJECT["dependencies"])
    (licence,) = unpacked.glob("*.dist-info/licenses/LICENSE")
    assert "Apache License" in licence.read_text("utf-8")


def test_groups_and_extras_name_the_same_tools() -> None:
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text())["dependency-groups"]
    assert groups["test"] == PROJECT["optional-dependencies"]["test"]


def test_the_unpacked_wheel_lists_its_plugins(unpacked: Path, tmp_path: Path) -> None:
    """With the libraries of this environment, but the program from the wheel alone."""
    environment = {**os.environ, "PYTHONPATH": str(unpacked)}
    where = "import bozzetto, bozzetto_app; print(bozzetto.__file__, bozzetto_app.__file__)"
    for file in run(sys.executable, "-c", where, cwd=tmp_path, env=environment).split():
        assert Path(file).is_relative_to(unpacked)
    start = [sys.executable, "-m", "bozzetto_app", "plugins"]
    listed = run(*start, cwd=tmp_path, env=environment)
    assert all(f"bozzetto.{name}" in listed for name in PLUGINS), listed


@pytest.mark.slow
def test_installs_into_a_clean_environment(
    wheel: Path, tmp_path: Path, outside: dict[str, str]
) -> None:
    """Everything from the package index, nothing from the checkout."""
    place = tmp_path / "clean"
    venv.create(place, with_pip=True)
    programs = place / ("Scripts" if os.name == "nt" else "bin")
    bare = {name: value for name, value in outside.items() if not name.startswith("PYTHON")}
    pip = [programs / "python", "-m", "pip", "--disable-pip-version-check"]
    run(*pip, "install", "--quiet", wheel, env=bare)
    run(*pip, "check", env=bare)
    listed = run(programs / "bozzetto", "plugins", cwd=tmp_path, env=bare)
    assert all(f"bozzetto.{name}" in listed for name in PLUGINS), listed
    everything = "import " + ", ".join(["bozzetto", "bozzetto_app", *PLUGINS.values()])
    where = f"{everything}; print(bozzetto.__file__)"
    found = run(programs / "python", "-c", where, cwd=tmp_path, env=bare)
    assert Path(found.strip()).is_relative_to(place)
