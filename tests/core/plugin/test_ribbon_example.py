"""The example of the author's guide, as somebody else would have and install it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import ModelerContract, Shell
from bozzetto.testing.checks import check_elsewhere
from bozzetto.testing.lint import check_package
from bozzetto.testing.subject import Broken, Subject

EXAMPLE = Path(__file__).resolve().parents[3] / "docs" / "examples" / "bozzetto_ribbon"


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(EXAMPLE)
    yield
    for name in [name for name in sys.modules if name.partition(".")[0] == "bozzetto_ribbon"]:
        del sys.modules[name]


class TestRibbon(ModelerContract):
    modeler = "example.ribbon"
    packages = ("bozzetto_ribbon",)


def test_check_has_nothing_to_say():
    assert check_package("bozzetto_ribbon") == []


def test_sample_becomes_a_ribbon(tmp_path):
    from bozzetto.exchange.import_file import read_drawing

    shell = Shell(Registry(extra=["bozzetto_ribbon"]), tmp_path)
    info = shell.registry.info("example.ribbon")
    assert info.sample_titles == ("A wave",)
    shell.open("ribbon")
    drawing = read_drawing(info.samples[0])
    shell.put(
        shell.workbench.sources.from_drawing("example.ribbon", drawing, {"width": 12.0}).state
    )
    assert len(shell.shapes().surfaces) == 1


RESTLESS = """
from bozzetto.geometry import Placement
from bozzetto.plugin import hookimpl
from bozzetto_ribbon.modeler import Ribbon

class Restless(Ribbon):
    id = __name__ + ".modeler"
    title = "Modeler"
    def shapes(self, state, result):
        {misdeed}
        return super().shapes(state, result).placed(placement)

@hookimpl
def bozzetto_modelers():
    return [Restless()]
"""


@pytest.mark.parametrize(
    ("misdeed", "found"),
    [
        ("placement = Placement()", ""),
        ("placement = Placement(scale=1.0 + hash('a') % 1000)", "other shapes"),
        ("import PySide6; placement = Placement()", "PySide6"),
    ],
)
def test_what_shows_only_in_another_process(make_package, misdeed, found):
    package = make_package(RESTLESS.replace("{misdeed}", misdeed))
    subject = Subject(f"{package}.modeler", (package,))
    if not found:
        check_elsewhere(subject)
        return
    with pytest.raises(Broken, match=found):
        check_elsewhere(subject)


def run(*command: object, **options) -> str:
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def kit() -> list[str]:
    """Options that load the fixtures where the distribution does not yet announce them."""
    module = "bozzetto.testing.fixtures"
    announced = any(entry.value == module for entry in entry_points(group="pytest11"))
    return [] if announced else ["-p", module]


def test_its_own_tests_pass_where_it_is_installed(tmp_path):
    """Installed in the eyes of importlib.metadata: a package beside its metadata."""
    site = tmp_path / "site"
    shutil.copytree(EXAMPLE / "bozzetto_ribbon", site / "bozzetto_ribbon")
    shutil.copytree(EXAMPLE / "tests", tmp_path / "tests")
    metadata = site / "bozzetto_ribbon-1.0.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: bozzetto-ribbon\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text("[bozzetto.plugins]\nribbon = bozzetto_ribbon\n")
    path = os.pathsep.join([str(site), *(entry for entry in sys.path if entry)])
    environment = {**os.environ, "PYTHONPATH": path.replace(f"{EXAMPLE}{os.pathsep}", "")}
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *kit(), "tests"]
    assert "passed" in run(*tests, cwd=tmp_path, env=environment)


@pytest.mark.slow
def test_wheel_in_an_environment_of_its_own(tmp_path, outside):
    """Built, installed, listed, checked, used and tested, away from its sources.

    The environment sees the program and its libraries where they are installed for this
    test run; the plugin is installed into it from its wheel.
    """
    build = ["-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path, EXAMPLE]
    run(sys.executable, *build, env=outside)
    (wheel,) = tmp_path.glob("*.whl")

    place = tmp_path / "environment"
    venv.create(place, with_pip=False)
    python = place / ("Scripts" if os.name == "nt" else "bin") / "python"
    scheme = {"base": str(place), "platbase": str(place)}
    site = Path(sysconfig.get_path("purelib", "venv", vars=scheme))
    here = sysconfig.get_path("purelib")
    (site / "program.pth").write_text(f"import site; site.addsitedir({here!r})\n")
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index"]
    run(*pip, wheel, env=outside)

    work = tmp_path / "work"
    work.mkdir()
    shutil.copytree(EXAMPLE / "tests", work / "tests")
    options = {"cwd": work, "env": {k: v for k, v in outside.items() if k != "PYTHONPATH"}}
    where = run(python, "-c", "import bozzetto_ribbon; print(bozzetto_ribbon.__file__)", **options)
    assert Path(where.strip()).is_relative_to(site)
    command = [python, "-m", "bozzetto.cli.main"]
    assert "example.ribbon" in run(*command, "plugins", **options)
    assert "error" not in run(*command, "plugins", "check", "bozzetto_ribbon", **options)
    sample = site / "bozzetto_ribbon" / "samples" / "wave.json"
    build = ["build", "ribbon", sample, "-o", "wave.obj", "--set", "width=12"]
    run(*command, *build, "--report", "wave.report.json", **options)
    lines = (work / "wave.obj").read_text().splitlines()
    assert sum(line.startswith("v ") for line in lines) >= 400
    assert "length_mm" in (work / "wave.report.json").read_text()
    run(*command, "build", "ribbon", sample, "-o", "wave.bozz", **options)
    run(*command, "export", "wave.bozz", "-o", "wave.glb", **options)
    run(python, "-m", "pytest", "-q", "-p", "no:cacheprovider", *kit(), "tests", **options)
