#!/usr/bin/env python3
"""Set Bozzetto up and start it, with nothing but Python itself.

    python3 bootstrap.py run  [arguments for bozzetto]
    python3 bootstrap.py test [arguments for pytest]

Both make ``.venv`` beside this file, install the project into it, editable, and do
so again only when ``pyproject.toml`` changed. ``run`` opens the window, or where
there is no display builds the sample drawings into ``out/``. ``test`` runs the style
and type checks, the import contracts and pytest; with arguments, only pytest.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
STAMP = VENV / "bozzetto-installed"
SIDE_BY_SIDE = ("-n", "auto", "--dist", "worksteal")  # pytest-xdist: a process for every core
OLDEST, NEWEST = (3, 11), (3, 14)  # as requires-python in pyproject.toml

APT = ("apt-get", "install", "-y", "--no-install-recommends")
QT_LIBRARIES = "libgl1 libegl1 libxkbcommon0 libfontconfig1 libdbus-1-3"
X11_LIBRARIES = (
    "libxkbcommon-x11-0 libxcb-cursor0 libxcb-icccm4 libxcb-keysyms1 libxcb-image0 "
    "libxcb-randr0 libxcb-render-util0 libxcb-shape0 libxcb-xkb1"
)
WAYLAND_LIBRARIES = "libwayland-client0 libwayland-cursor0 libwayland-egl1"
START_QT = "from PySide6 import QtOpenGLWidgets, QtSvg, QtWidgets; QtWidgets.QApplication([])"
DEAD_DISPLAY = ("could not connect to display", "Failed to create wl_display")


class Stop(Exception):
    """The set-up cannot go on; the message says what to do."""


def main(arguments: Sequence[str]) -> int:
    """Do what the command line asks; the exit code is the child's."""
    command = arguments[0] if arguments else ""
    if command not in ("run", "test"):
        print(__doc__)
        return 0 if command in ("-h", "--help") else 2
    try:
        require_python(sys.version_info[:2])
        install(extra="test" if command == "test" else "")
        return {"run": run, "test": test}[command](arguments[1:])
    except (Stop, OSError) as problem:
        print(problem, file=sys.stderr, flush=True)
        return 1
    except KeyboardInterrupt:
        return 130


def run(arguments: Sequence[str]) -> int:
    """Open the window, or without a display build the samples."""
    program = [str(PYTHON), "-m", "bozzetto_app"]
    display = has_display(os.environ, sys.platform) and require_qt(os.environ, sys.platform)
    if display or arguments:
        return call([*program, *arguments])
    out = str(ROOT / "out")
    print(f"No display here, so no window: building the sample drawings into {out} instead.")
    print("To open it, run the same command in a desktop session or over `ssh -X`.", flush=True)
    return call([*program, "samples", "-o", out])


def test(arguments: Sequence[str]) -> int:
    """Run every check, all of them even when one fails, pytest last."""
    keep_bytecode()
    require_qt({**os.environ, "QT_QPA_PLATFORM": "offscreen"}, sys.platform)
    checks = [] if arguments else ["ruff check", "ruff format --check", "mypy", "lint-imports"]
    steps = {check: [str(BIN / check.split()[0]), *check.split()[1:]] for check in checks}
    steps["pytest"] = [str(PYTHON), "-m", "pytest", *SIDE_BY_SIDE, *arguments]
    codes = {name: call(step, ROOT) for name, step in steps.items()}
    failed = [name for name, code in codes.items() if code]
    if failed:
        print("Failed: " + ", ".join(failed), file=sys.stderr, flush=True)
    return codes[failed[0]] if failed else 0


def keep_bytecode() -> None:
    """Let children keep what they compile, in ``.venv``, also where the machine says not to.

    pytest's rewriting of the assertions, and every program that a test starts, would begin with
    half a minute or half a second of compiling.
    """
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ.setdefault("PYTHONPYCACHEPREFIX", str(VENV / "bytecode"))


def require_python(version: tuple[int, int]) -> None:
    """Stop on a Python that the project does not support."""
    if not OLDEST <= version <= NEWEST:
        old, new, this = ("{}.{}".format(*each) for each in (OLDEST, NEWEST, version))
        why = f"Bozzetto needs Python {old} to {new}; this is Python {this}."
        raise Stop(f"{why} With another it goes, for example: python{new} bootstrap.py run")


def install(extra: str) -> None:
    """Bring ``.venv`` up to date; an install that was cut short is done again."""
    if is_current(STAMP, digest(venv_version()), extra):
        return
    with one_at_a_time():
        if is_current(STAMP, digest(venv_version()), extra):  # another call was faster
            return
        if not venv_version() or not find_installer():
            make_venv()
        version, installer = venv_version(), find_installer()
        if not version or not installer:
            raise Stop(f"Neither pip nor uv can install into {VENV}.")
        STAMP.unlink(missing_ok=True)
        print(f"Installing Bozzetto into {VENV}; the first time takes some minutes.", flush=True)
        if call([*installer, "--editable", f"{ROOT}[{extra}]" if extra else str(ROOT)]):
            raise Stop("The installation failed, see above. The same command will try it again.")
        fresh = STAMP.with_suffix(".new")
        fresh.write_text(f"{digest(version)} {extra}", encoding="utf-8")
        fresh.replace(STAMP)


@contextlib.contextmanager
def one_at_a_time() -> Iterator[None]:
    """Hold a lock on this very file; the system drops it however we end."""
    with open(__file__, "ab") as file:
        if sys.platform == "win32":
            import msvcrt

            file.seek(1 << 30)  # beyond the text, which stays readable
            for _ in range(120):
                with contextlib.suppress(OSError):  # raised after ten seconds of waiting
                    msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)
                    break
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def digest(version: str) -> str:
    """Return what an install depends on: the project file, the interpreter and the place."""
    parts = ((ROOT / "pyproject.toml").read_bytes(), version.encode(), os.fsencode(ROOT))
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def is_current(stamp: Path, expected: str, extra: str) -> bool:
    """Whether the stamp tells of a finished install of this digest, with at least this extra."""
    found, _, installed = (stamp.read_text("utf-8") if stamp.is_file() else "").partition(" ")
    return found == expected and extra in ("", installed)


def venv_version() -> str:
    """Return the version of the environment's Python, empty if it cannot be used."""
    code, output = probe([str(PYTHON), "-c", "import sys; print(*sys.version_info[:3])"])
    numbers = tuple(int(word) for word in output.split()) if code == 0 else ()
    return ".".join(map(str, numbers)) if OLDEST <= numbers[:2] <= NEWEST else ""


def find_installer() -> list[str]:
    """Return the start of an install command for ``.venv``: pip, else uv, else nothing."""
    if probe([str(PYTHON), "-m", "pip", "--version"])[0] == 0:
        return [str(PYTHON), "-m", "pip", "install", "--disable-pip-version-check"]
    uv = shutil.which("uv")
    return [uv, "pip", "install", "--python", str(PYTHON)] if uv else []


def make_venv() -> None:
    """Make ``.venv`` anew with the venv module, else with uv; leave no broken one behind."""
    python = getattr(sys, "_base_executable", sys.executable)  # never the one inside .venv
    uv = shutil.which("uv")
    ways = [[python, "-m", "venv", str(VENV)]]
    ways += [[uv, "venv", "--python", python, str(VENV)]] if uv else []
    shutil.rmtree(VENV, ignore_errors=True)
    for way in ways:
        code, output = probe(way)
        if code == 0:
            return
        print(output, file=sys.stderr)
        shutil.rmtree(VENV, ignore_errors=True)
    line = apt_line(["python{}.{}-venv".format(*sys.version_info)])
    raise Stop(f"No virtual environment. On Debian and Ubuntu this helps:\n    {line}")


def has_display(environment: Mapping[str, str], platform: str) -> bool:
    """Whether a window can be expected to open: always, save on a bare Linux."""
    chosen = environment.get("QT_QPA_PLATFORM", "").partition(":")[0]
    if chosen:
        return chosen not in ("offscreen", "minimal", "minimalegl")
    displays = environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")
    return not platform.startswith("linux") or bool(displays)


def require_qt(environment: Mapping[str, str], platform: str) -> bool:
    """Make sure that Qt starts, in a child since it may abort; False if the display is dead."""
    if not platform.startswith("linux"):
        return True
    start = [str(PYTHON), "-c", START_QT]
    release = Path("/etc/os-release")
    packages = qt_packages(release.read_text("utf-8") if release.is_file() else "", environment)
    for repaired in (False, True):
        code, output = probe(start, environment)
        if code == 0 or any(sign in output for sign in DEAD_DISPLAY):
            return code == 0
        if not repaired and is_root() and shutil.which("apt-get"):
            print(f"Qt lacks system libraries. Running: {apt_line(packages)}", flush=True)
            call(["apt-get", "update", "-qq"])
            call(["env", "DEBIAN_FRONTEND=noninteractive", *APT, *packages])
    raise Stop(
        f"{output}\n\nQt does not start, most likely for want of system libraries. "
        f"On Debian and Ubuntu this installs them:\n    {apt_line(packages)}"
    )


def qt_packages(os_release: str, environment: Mapping[str, str]) -> list[str]:
    """Return the Debian packages that Qt needs for this platform."""
    lines = [line for line in os_release.replace('"', "").split("\n") if "=" in line]
    facts = dict(line.split("=", 1) for line in lines)
    first = {"debian": 13, "ubuntu": 24}.get(facts.get("ID", ""), sys.maxsize)
    version = facts.get("VERSION_ID", "").partition(".")[0] or "99"  # none: a testing release
    packages = [*QT_LIBRARIES.split(), "libglib2.0-0" + ("t64" if int(version) >= first else "")]
    if has_display(environment, "linux"):
        packages += X11_LIBRARIES.split() if environment.get("DISPLAY") else []
        packages += WAYLAND_LIBRARIES.split() if environment.get("WAYLAND_DISPLAY") else []
    return packages


def apt_line(packages: Sequence[str]) -> str:
    """Return the command that installs these packages, for whoever runs this."""
    return " ".join([*([] if is_root() else ["sudo"]), *APT, *packages])


def is_root() -> bool:
    """Whether we may change the system."""
    return hasattr(os, "geteuid") and os.geteuid() == 0


def call(command: Sequence[str], folder: Path | None = None) -> int:
    """Run a child, here or in a folder; its exit code as a shell would give it."""
    code = subprocess.run(list(command), cwd=folder).returncode
    return code if code >= 0 else 128 - code


def probe(command: Sequence[str], environment: Mapping[str, str] | None = None) -> tuple[int, str]:
    """Run a child quietly; its exit code and all that it said."""
    pipe, both = subprocess.PIPE, subprocess.STDOUT
    try:
        done = subprocess.run(list(command), stdout=pipe, stderr=both, text=True, env=environment)
    except OSError as error:
        return 127, str(error)
    return done.returncode, done.stdout.strip()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
