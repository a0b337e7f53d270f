"""The examples of the author's guide, as somebody else would have and install them."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import sysconfig
import tokenize
import venv
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import ModelerContract, Shell
from bozzetto.testing.checks import check_elsewhere
from bozzetto.testing.lint import check_package
from bozzetto.testing.subject import Broken, Subject

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"
EXAMPLE = EXAMPLES / "bozzetto_ribbon"
NAMES = ("bozzetto_ribbon", "bozzetto_lathe")

RIBBON_QUICK = ("bozzetto_ribbon", pytest.param("bozzetto_lathe", marks=pytest.mark.slow))
"""The lathe does the same once more, with more to compute: in the long tests."""

MOST_LINES = {"bozzetto_ribbon": 280, "bozzetto_lathe": 290}
"""Lines of code that an example may have, its tests among them."""

MOST_NAMES = {"bozzetto_ribbon": 24, "bozzetto_lathe": 18}
"""Public names of the program that an example may need."""


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch):
    for package in NAMES:
        monkeypatch.syspath_prepend(EXAMPLES / package)
    yield
    for name in [name for name in sys.modules if name.partition(".")[0] in NAMES]:
        del sys.modules[name]


class TestRibbon(ModelerContract):
    modeler = "example.ribbon"
    packages = ("bozzetto_ribbon",)


class TestLathe(ModelerContract):
    modeler = "example.lathe"
    packages = ("bozzetto_lathe",)

    def sketch(self, shell, pen):
        shell.draw(pen.along([(700, 250), (760, 450), (680, 650)]))


@pytest.mark.parametrize("package", RIBBON_QUICK)
def test_check_has_nothing_to_say(package):
    assert check_package(package) == []


def names_used(folder: Path) -> set[str]:
    """Names that the modules of a package import from the program."""
    return {
        f"{node.module}.{alias.name}"
        for path in folder.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] == "bozzetto"
        for alias in node.names
    }


def code_lines(folder: Path) -> int:
    """Lines with code: without imports, docstrings, comments and empty ones."""
    return sum(len(_code_of(path)) for path in folder.rglob("*.py"))


def _code_of(path: Path) -> set[int]:
    text = path.read_text("utf-8")
    with path.open("rb") as file:
        tokens = [token for token in tokenize.tokenize(file.readline) if token.type not in EMPTY]
    lines = {line for token in tokens for line in range(token.start[0], token.end[0] + 1)}
    for node in ast.walk(ast.parse(text)):
        told = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if told or isinstance(node, ast.Import | ast.ImportFrom):
            lines -= set(range(node.lineno, node.end_lineno + 1))
    return lines


EMPTY = (
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENDMARKER, tokenize.ENCODING,
)  # fmt: skip


@pytest.mark.parametrize("package", NAMES)
def test_what_an_author_writes_and_must_know(package):
    used, lines = names_used(EXAMPLES / package / package), code_lines(EXAMPLES / package)
    print(f"{package}: {lines} lines of code, {len(used)} names of the program")
    assert len(used) <= MOST_NAMES[package], sorted(used)
    assert lines <= MOST_LINES[package]
    rooms = {name.rpartition(".")[0] for name in used}
    assert rooms <= {f"bozzetto.{room}" for room in ROOMS}, "and nothing deeper"


ROOMS = ("plugin", "ink", "view", "geometry", "scene", "errors")


def test_the_lathe_reaches_step_exactly(tmp_path):
    """The sample is one solid of rational surfaces, and no triangle is in the file."""
    from bozzetto.exchange.export import export
    from bozzetto.exchange.import_file import read_drawing

    shell = Shell(Registry(extra=["bozzetto_lathe"]), tmp_path)
    info = shell.registry.info("example.lathe")
    shell.open("lathe")
    drawing = read_drawing(info.samples[0])
    shell.put(shell.workbench.sources.from_drawing("example.lathe", drawing, {}).state)
    path = tmp_path / "vase.step"
    export(shell.shapes(), path)
    told = path.read_text("ascii")
    assert told.count("MANIFOLD_SOLID_BREP") == 1
    assert "RATIONAL_B_SPLINE_SURFACE" in told
    assert "POLY_LOOP" not in told
    assert "TRIANGULATED" not in told


@pytest.mark.slow
@pytest.mark.parametrize("package", NAMES)
def test_strict_mypy_finds_nothing(package, tmp_path):
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", os.devnull, package]
    cache = {"MYPY_CACHE_DIR": str(tmp_path)}
    assert "no issues" in run(*command, cwd=EXAMPLES / package, env=os.environ | cache)


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


@pytest.mark.parametrize("package", RIBBON_QUICK)
def test_its_own_tests_pass_where_it_is_installed(tmp_path, package):
    """Installed in the eyes of importlib.metadata: a package beside its metadata."""
    site, name = tmp_path / "site", package.removeprefix("bozzetto_")
    shutil.copytree(EXAMPLES / package / package, site / package)
    shutil.copytree(EXAMPLES / package / "tests", tmp_path / "tests")
    metadata = site / f"{package}-1.0.0.dist-info"
    metadata.mkdir()
    said = f"Metadata-Version: 2.1\nName: bozzetto-{name}\nVersion: 1\n"
    (metadata / "METADATA").write_text(said)
    (metadata / "entry_points.txt").write_text(f"[bozzetto.plugins]\n{name} = {package}\n")
    others = [entry for entry in sys.path if entry and not Path(entry).is_relative_to(EXAMPLES)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), *others])}
    quick = ["-m", "not slow"]
    tests = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        *kit(),
        *quick,
        "tests",
    ]
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
