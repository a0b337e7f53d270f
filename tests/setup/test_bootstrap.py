"""The two commands: what they decide, what they say, and what they leave behind."""

from __future__ import annotations

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
DEBIAN_12 = 'ID=debian\nVERSION_ID="12"\n# a comment\n'

posix = pytest.mark.skipif(os.name == "nt", reason="stands in for programs with shell scripts")


@pytest.fixture
def bootstrap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return bootstrap.py as loaded from an otherwise empty checkout."""
    checkout = tmp_path / "a checkout"
    checkout.mkdir()
    shutil.copy(ROOT / "bootstrap.py", checkout)
    (checkout / "pyproject.toml").write_text("[project]\nname = 'bozzetto'\n")
    spec = importlib.util.spec_from_file_location("bootstrap", checkout / "bootstrap.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert checkout == module.ROOT
    return module


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder that is the whole PATH, but for the plainest tools."""
    folder = tmp_path / "programs"
    folder.mkdir()
    for name in ("sh", "env", "mkdir", "cat", "touch"):
        found = shutil.which(name)
        if found:
            (folder / name).symlink_to(found)
    monkeypatch.setenv("PATH", str(folder))
    return folder


def script(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)
    return path


def calls_of(monkeypatch: pytest.MonkeyPatch, module: ModuleType, code: int = 0) -> list[list[str]]:
    """Record what the module would run, in place of running it."""
    calls: list[list[str]] = []

    def call(command: list[str], folder: Path | None = None) -> int:
        calls.append(list(command))
        return code

    monkeypatch.setattr(module, "call", call)
    return calls


class TestStamp:
    def test_is_current_only_for_the_same_digest(self, bootstrap: ModuleType) -> None:
        stamp = bootstrap.ROOT / "stamp"
        assert not bootstrap.is_current(stamp, "abc", "")
        stamp.write_text("abc test")
        assert bootstrap.is_current(stamp, "abc", "test")
        assert not bootstrap.is_current(stamp, "abd", "test")

    def test_an_install_for_tests_serves_to_run_but_not_the_reverse(
        self, bootstrap: ModuleType
    ) -> None:
        stamp = bootstrap.ROOT / "stamp"
        stamp.write_text("abc test")
        assert bootstrap.is_current(stamp, "abc", "")
        stamp.write_text("abc ")
        assert bootstrap.is_current(stamp, "abc", "")
        assert not bootstrap.is_current(stamp, "abc", "test")

    def test_digest_follows_project_file_interpreter_and_place(
        self, bootstrap: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        first = bootstrap.digest("3.11.7")
        assert bootstrap.digest("3.11.7") == first
        assert bootstrap.digest("3.11.8") != first
        with (bootstrap.ROOT / "pyproject.toml").open("a") as file:
            file.write("# changed\n")
        second = bootstrap.digest("3.11.7")
        assert second != first
        moved = tmp_path / "moved"
        shutil.copytree(bootstrap.ROOT, moved)
        monkeypatch.setattr(bootstrap, "ROOT", moved)
        assert bootstrap.digest("3.11.7") != second


@posix
class TestInstall:
    """With a Python in .venv that only pretends."""

    @pytest.fixture
    def log(self, bootstrap: ModuleType) -> Path:
        """Return the file in which the pretended pip writes its arguments."""
        log = bootstrap.ROOT / "pip.log"
        script(
            bootstrap.PYTHON,
            f'case "$*" in *version_info*) echo 3 12 1;; '
            f'*"pip install"*) echo "$*" >> "{log}"; exit ${{PIP_FAILS:-0}};; esac\n',
        )
        return log

    def test_installs_once(self, bootstrap: ModuleType, log: Path) -> None:
        bootstrap.install("test")
        bootstrap.install("test")
        bootstrap.install("")
        assert log.read_text().count("\n") == 1
        assert f"--editable {bootstrap.ROOT}[test]" in log.read_text()

    def test_installs_again_when_the_project_file_changed(
        self, bootstrap: ModuleType, log: Path
    ) -> None:
        bootstrap.install("")
        with (bootstrap.ROOT / "pyproject.toml").open("a") as file:
            file.write("# changed\n")
        bootstrap.install("")
        assert log.read_text().count("\n") == 2

    def test_an_install_that_failed_leaves_no_stamp(
        self, bootstrap: ModuleType, log: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        bootstrap.install("")
        monkeypatch.setenv("PIP_FAILS", "1")
        with pytest.raises(bootstrap.Stop, match="will try it again"):
            bootstrap.install("test")
        assert not bootstrap.STAMP.exists()
        monkeypatch.setenv("PIP_FAILS", "0")
        bootstrap.install("")
        assert log.read_text().count("\n") == 3

    def test_a_working_environment_without_stamp_is_kept(
        self, bootstrap: ModuleType, log: Path
    ) -> None:
        (bootstrap.VENV / "precious").touch()
        bootstrap.install("")
        assert (bootstrap.VENV / "precious").exists()

    @pytest.mark.parametrize(
        "broken", ["exit 1\n", "echo 3 9 2\n", "echo 3 15 0\n"], ids=["dead", "old", "new"]
    )
    def test_an_unusable_environment_is_made_anew(
        self, bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, log: Path, broken: str
    ) -> None:
        working = bootstrap.PYTHON.read_text().removeprefix("#!/bin/sh\n")
        script(bootstrap.PYTHON, broken)
        (bootstrap.VENV / "leftover").touch()

        def make_venv() -> None:
            shutil.rmtree(bootstrap.VENV)
            script(bootstrap.PYTHON, working)

        monkeypatch.setattr(bootstrap, "make_venv", make_venv)
        bootstrap.install("")
        assert not (bootstrap.VENV / "leftover").exists()
        assert bootstrap.STAMP.exists()

    def test_a_second_call_waits_for_the_first(
        self, bootstrap: ModuleType, log: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        started = threading.Event()
        original = bootstrap.call

        def slow(command: list[str]) -> int:
            started.set()
            time.sleep(0.3)
            return int(original(command))

        monkeypatch.setattr(bootstrap, "call", slow)
        first = threading.Thread(target=bootstrap.install, args=("",))
        first.start()
        assert started.wait(10)
        bootstrap.install("")
        first.join()
        assert log.read_text().count("\n") == 1


@posix
class TestMakeVenv:
    @pytest.fixture
    def python(self, bootstrap: ModuleType, programs: Path, monkeypatch: pytest.MonkeyPatch) -> str:
        """Return a Python as Debian ships it without python3-venv."""
        python = script(
            programs / "python-without-ensurepip",
            'mkdir -p "$3/bin"\necho "ensurepip is not available"\nexit 1\n',
        )
        monkeypatch.setattr(sys, "_base_executable", str(python))
        return str(python)

    @pytest.mark.usefixtures("python")
    def test_without_uv_says_the_line_and_leaves_nothing(
        self,
        bootstrap: ModuleType,
        monkeypatch: pytest.MonkeyPatch,
        capfd: pytest.CaptureFixture[str],
    ) -> None:
        monkeypatch.setattr(bootstrap, "is_root", lambda: False)
        assert bootstrap.main(["run"]) == 1
        said = capfd.readouterr().err
        version = "{}.{}".format(*sys.version_info)
        assert f"sudo apt-get install -y --no-install-recommends python{version}-venv" in said
        assert "ensurepip is not available" in said
        assert not bootstrap.VENV.exists()

    def test_uv_is_asked_second(self, bootstrap: ModuleType, programs: Path, python: str) -> None:
        log = programs / "uv.log"
        script(programs / "uv", f'test -e "$4" && exit 9\nmkdir "$4"\necho "$*" >> "{log}"\n')
        bootstrap.make_venv()
        assert log.read_text() == f"venv --python {python} {bootstrap.VENV}\n"

    @pytest.mark.usefixtures("python")
    def test_uv_that_fails_leaves_nothing(self, bootstrap: ModuleType, programs: Path) -> None:
        script(programs / "uv", 'mkdir -p "$4"\nexit 2\n')
        with pytest.raises(bootstrap.Stop, match="-venv"):
            bootstrap.make_venv()
        assert not bootstrap.VENV.exists()

    def test_uv_is_not_asked_where_venv_works(
        self, bootstrap: ModuleType, programs: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        python = script(programs / "python-whole", 'mkdir "$3"\n')
        monkeypatch.setattr(sys, "_base_executable", str(python))
        script(programs / "uv", "exit 2\n")
        bootstrap.make_venv()
        assert bootstrap.VENV.is_dir()

    def test_installer_is_pip_then_uv_then_nothing(
        self, bootstrap: ModuleType, programs: Path
    ) -> None:
        script(bootstrap.PYTHON, "exit 0\n")
        uv = script(programs / "uv", "exit 0\n")
        assert bootstrap.find_installer()[:4] == [str(bootstrap.PYTHON), "-m", "pip", "install"]
        script(bootstrap.PYTHON, "exit 1\n")
        expected = [str(uv), "pip", "install", "--python", str(bootstrap.PYTHON)]
        assert bootstrap.find_installer() == expected
        uv.unlink()
        assert bootstrap.find_installer() == []


class TestDisplay:
    @pytest.mark.parametrize(
        ("environment", "platform", "expected"),
        [
            ({}, "linux", False),
            ({"DISPLAY": ""}, "linux", False),
            ({"DISPLAY": ":0"}, "linux", True),
            ({"WAYLAND_DISPLAY": "wayland-0"}, "linux", True),
            ({}, "darwin", True),
            ({}, "win32", True),
            ({"DISPLAY": ":0", "QT_QPA_PLATFORM": "offscreen"}, "linux", False),
            ({"QT_QPA_PLATFORM": "offscreen:configfile=x"}, "win32", False),
            ({"QT_QPA_PLATFORM": "vnc:size=800x600"}, "linux", True),
        ],
    )
    def test_has_display(
        self, bootstrap: ModuleType, environment: dict[str, str], platform: str, expected: bool
    ) -> None:
        assert bootstrap.has_display(environment, platform) is expected

    def test_run_without_display_builds_the_samples(
        self,
        bootstrap: ModuleType,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        calls = calls_of(monkeypatch, bootstrap, code=5)
        monkeypatch.setattr(bootstrap, "has_display", lambda *_: False)
        assert bootstrap.run([]) == 5
        out = str(bootstrap.ROOT / "out")
        assert calls == [[str(bootstrap.PYTHON), "-m", "bozzetto_app", "samples", "-o", out]]
        said = capsys.readouterr().out
        assert "No display" in said
        assert out in said
        assert "To open it" in said

    @pytest.mark.parametrize("display", [False, True])
    def test_arguments_are_handed_on(
        self, bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, display: bool
    ) -> None:
        calls = calls_of(monkeypatch, bootstrap)
        monkeypatch.setattr(bootstrap, "has_display", lambda *_: display)
        monkeypatch.setattr(bootstrap, "require_qt", lambda *_: True)
        bootstrap.run(["info", "a.bozz"])
        assert calls == [[str(bootstrap.PYTHON), "-m", "bozzetto_app", "info", "a.bozz"]]

    def test_a_dead_display_is_none(
        self, bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        calls = calls_of(monkeypatch, bootstrap)
        dead = "qt.qpa.xcb: could not connect to display :99\nAborted"
        monkeypatch.setattr(bootstrap, "probe", lambda *_: (134, dead))
        monkeypatch.setattr(bootstrap, "has_display", lambda *_: True)
        monkeypatch.setattr(sys, "platform", "linux")
        bootstrap.run([])
        assert [command[3] for command in calls] == ["samples"]


class TestSystemLibraries:
    @pytest.mark.parametrize(
        ("release", "glib"),
        [
            (DEBIAN_12, "libglib2.0-0"),
            ('ID=debian\nVERSION_ID="13"\n', "libglib2.0-0t64"),
            ("ID=debian\nVERSION_CODENAME=forky\n", "libglib2.0-0t64"),
            ('ID=ubuntu\nVERSION_ID="22.04"\n', "libglib2.0-0"),
            ('ID=ubuntu\nVERSION_ID="24.04"\n', "libglib2.0-0t64"),
            ("", "libglib2.0-0"),
        ],
    )
    def test_glib_bears_two_names(self, bootstrap: ModuleType, release: str, glib: str) -> None:
        assert bootstrap.qt_packages(release, {}) == [
            *("libgl1", "libegl1", "libxkbcommon0", "libfontconfig1", "libdbus-1-3"),
            glib,
        ]

    def test_a_window_needs_more(self, bootstrap: ModuleType) -> None:
        bare = bootstrap.qt_packages(DEBIAN_12, {})
        x11 = bootstrap.qt_packages(DEBIAN_12, {"DISPLAY": ":0"})
        wayland = bootstrap.qt_packages(DEBIAN_12, {"WAYLAND_DISPLAY": "wayland-0"})
        hidden = bootstrap.qt_packages(DEBIAN_12, {"DISPLAY": ":0", "QT_QPA_PLATFORM": "offscreen"})
        assert "libxcb-cursor0" in set(x11) - set(bare)
        assert "libwayland-client0" in set(wayland) - set(bare) - set(x11)
        assert hidden == bare

    @pytest.mark.parametrize("root", [False, True])
    def test_without_apt_the_exact_line_is_said(
        self, bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, programs: Path, root: bool
    ) -> None:
        calls = calls_of(monkeypatch, bootstrap)
        lacking = "ImportError: libGL.so.1: cannot open shared object file"
        monkeypatch.setattr(bootstrap, "probe", lambda *_: (1, lacking))
        monkeypatch.setattr(bootstrap, "is_root", lambda: root)
        with pytest.raises(bootstrap.Stop) as stopped:
            bootstrap.require_qt({}, "linux")
        line = str(stopped.value).splitlines()[-1].strip()
        prefix = "" if root else "sudo "
        assert line.startswith(f"{prefix}apt-get install -y --no-install-recommends libgl1 libegl1")
        assert lacking in str(stopped.value)
        assert calls == []

    def test_root_on_apt_installs_and_looks_again(
        self,
        bootstrap: ModuleType,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        calls = calls_of(monkeypatch, bootstrap)
        monkeypatch.setattr(
            bootstrap, "probe", lambda *_: (0, "") if calls else (1, "libGL.so.1: cannot open")
        )
        monkeypatch.setattr(bootstrap, "is_root", lambda: True)
        monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}")
        assert bootstrap.require_qt({}, "linux") is True
        assert calls[0][:2] == ["apt-get", "update"]
        assert "libgl1" in calls[1]
        assert "libgl1" in capsys.readouterr().out

    def test_nothing_is_installed_where_qt_starts(
        self, bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        calls = calls_of(monkeypatch, bootstrap)
        monkeypatch.setattr(bootstrap, "PYTHON", Path(sys.executable))
        environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
        assert bootstrap.require_qt(environment, "linux") is True
        assert calls == []


class TestExitCodes:
    def test_the_childs_code_comes_through(self, bootstrap: ModuleType) -> None:
        assert bootstrap.call([sys.executable, "-c", "raise SystemExit(7)"]) == 7

    def test_files_are_named_from_where_the_person_stands(
        self, bootstrap: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "drawing").touch()
        look = "import pathlib, sys; sys.exit(pathlib.Path('drawing').exists())"
        assert bootstrap.call([sys.executable, "-c", look]) == 1
        assert bootstrap.call([sys.executable, "-c", look], bootstrap.ROOT) == 0

    @posix
    def test_a_killed_child_counts_as_in_a_shell(self, bootstrap: ModuleType) -> None:
        kill = "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"
        assert bootstrap.call([sys.executable, "-c", kill]) == 128 + signal.SIGKILL

    @pytest.mark.parametrize("failing", ["ruff", "mypy", "lint-imports", "pytest"])
    def test_one_failing_check_fails_the_test_command_after_all_ran(
        self,
        bootstrap: ModuleType,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
        failing: str,
    ) -> None:
        ran = []

        def call(command: list[str], folder: Path) -> int:
            assert folder == bootstrap.ROOT
            ran.append(" ".join([Path(command[0]).name, *command[1:]]))
            return 3 if failing in ran[-1] else 0

        monkeypatch.setattr(bootstrap, "call", call)
        monkeypatch.setattr(bootstrap, "require_qt", lambda *_: True)
        assert bootstrap.test([]) == 3
        assert ran[:-1] == ["ruff check", "ruff format --check", "mypy", "lint-imports"]
        assert ran[-1].endswith(" ".join(("-m pytest", *bootstrap.SIDE_BY_SIDE)))
        assert failing in capsys.readouterr().err

    def test_arguments_mean_pytest_alone(
        self, bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        calls = calls_of(monkeypatch, bootstrap, code=1)
        monkeypatch.setattr(bootstrap, "require_qt", lambda *_: True)
        assert bootstrap.test(["-m", "slow"]) == 1
        assert calls == [
            [str(bootstrap.PYTHON), "-m", "pytest", *bootstrap.SIDE_BY_SIDE, "-m", "slow"]
        ]

    def test_usage(self, bootstrap: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
        assert bootstrap.main([]) == 2
        assert bootstrap.main(["fly"]) == 2
        assert bootstrap.main(["--help"]) == 0
        assert capsys.readouterr().out.count("python3 bootstrap.py run") == 3


class TestPythonVersion:
    @pytest.mark.parametrize("version", [(3, 10), (3, 15), (2, 7)])
    def test_others_are_refused_with_a_way_out(
        self, bootstrap: ModuleType, version: tuple[int, int]
    ) -> None:
        with pytest.raises(bootstrap.Stop, match=r"needs Python 3\.11 to 3\.14.*python3\.14"):
            bootstrap.require_python(version)

    @pytest.mark.parametrize("version", [(3, 11), (3, 14)])
    def test_ours_are_not(self, bootstrap: ModuleType, version: tuple[int, int]) -> None:
        bootstrap.require_python(version)

    def test_the_bounds_are_those_of_the_project_file(self, bootstrap: ModuleType) -> None:
        project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
        (low, high), (low_minor, high_minor) = zip(bootstrap.OLDEST, bootstrap.NEWEST, strict=True)
        assert project["requires-python"] == f">={low}.{low_minor},<{high}.{high_minor + 1}"


def test_only_the_standard_library(bootstrap: ModuleType) -> None:
    """In a Python without site-packages, from another folder."""
    command = [sys.executable, "-I", "-S", str(bootstrap.ROOT / "bootstrap.py"), "--help"]
    done = subprocess.run(command, cwd="/", capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "bootstrap.py test" in done.stdout


def test_a_folder_that_may_not_be_written_is_named(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(extra: str) -> None:
        raise PermissionError(13, "Permission denied", str(bootstrap.VENV))

    monkeypatch.setattr(bootstrap, "install", refuse)
    assert bootstrap.main(["run"]) == 1
    assert str(bootstrap.VENV) in capsys.readouterr().err
