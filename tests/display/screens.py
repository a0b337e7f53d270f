"""Screens without a monitor: an X server with a window manager, and Wayland compositors.

Everything is started on its own free display, in an environment that knows nothing of the
person's, and is ended by its own process id.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

__all__ = [
    "Screen",
    "absent",
    "folders_below",
    "headless_weston",
    "nested_weston",
    "wait_until",
    "xvfb",
]

PATIENCE = 60.0
"""How long a program may take to come up on a loaded machine, seconds."""

KEPT = ("PATH", "LANG", "LC_ALL", "LD_LIBRARY_PATH", "PYTHONPATH", "OPENBLAS_NUM_THREADS")
"""The only variables that are taken from outside."""

FOLDERS = ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME")

SIZE = (1600, 1200)
LARGE = (2720, 1760)
"""Of a screen with room for the window at twice the usual scale, pixels."""


@dataclass(frozen=True)
class Screen:
    """Where a window can open.

    Parameters
    ----------
    environment : mapping
        All variables for a program that is to open its window there.
    home : Path
        Its scratch home.
    pointer : mapping, optional
        The environment of the X server whose pointer moves the one of this screen; None where
        nothing can be pressed from outside.
    """

    environment: Mapping[str, str]
    home: Path
    pointer: Mapping[str, str] | None

    def xdotool(self, *words: object) -> str:
        """Run xdotool, which speaks XTEST, and return what it says."""
        assert self.pointer is not None
        return subprocess.run(
            ["xdotool", *map(str, words)],
            env=dict(self.pointer),
            check=True,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        ).stdout

    def press(self, place: tuple[float, float]) -> None:
        """Put the left button down at a place of the screen.

        The way there begins in the corner: nested compositors take the pointer's steps and not
        its places, and every pointer stops at the corner.
        """
        x, y = map(round, place)
        self.xdotool("mousemove", 0, 0, "mousemove", x, y, "mousedown", 1)

    def move(self, places: Sequence[tuple[float, float]], pace: float = 0.01) -> None:
        """Move the pointer through places of the screen, `pace` seconds between them."""
        words: list[object] = []
        for x, y in places:
            words += ["mousemove", round(x), round(y), "sleep", pace]
        self.xdotool(*words)

    def lift(self) -> None:
        """Let the left button go."""
        self.xdotool("mouseup", 1)


def absent(*programs: str) -> str:
    """Return why a test cannot run here; "" if all programs are there."""
    missing = [program for program in programs if shutil.which(program) is None]
    return f"not installed here: {', '.join(missing)}" if missing else ""


def wait_until(holds: Callable[[], object], what: str, patience: float = PATIENCE) -> None:
    """Look again and again until something holds.

    Raises
    ------
    TimeoutError
        If it does not hold in time.
    """
    end = time.monotonic() + patience
    while not holds():
        if time.monotonic() > end:
            raise TimeoutError(f"waited {patience:.0f} s in vain for {what}")
        time.sleep(0.02)


def folders_below(home: Path) -> dict[str, str]:
    """The variables that keep a program's files below a folder; what they name exists then."""
    made = {name: home / name.lower() for name in FOLDERS}
    for place in made.values():
        place.mkdir(mode=0o700)
    return {name: str(place) for name, place in made.items()}


@contextmanager
def xvfb(folder: Path, size: tuple[int, int] = LARGE) -> Iterator[Screen]:
    """An X server with Openbox, a window manager."""
    environment = _clean(folder)
    with ExitStack() as stack:
        read, write = os.pipe()
        with open(read, encoding="ascii") as number:
            words = ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{size[0]}x{size[1]}x24"]
            words += ["+extension", "GLX", "-nolisten", "tcp", "-noreset"]
            stack.enter_context(_running(words, environment, folder / "xvfb.log", (write,)))
            os.close(write)
            display = number.readline().strip()
        if not display:
            raise RuntimeError(f"Xvfb did not start: {(folder / 'xvfb.log').read_text()}")
        environment |= {"DISPLAY": f":{display}", "QT_QPA_PLATFORM": "xcb"}
        environment["XDG_SESSION_TYPE"] = "x11"
        ready = folder / "openbox-is-ready"
        words = ["openbox", "--sm-disable", "--startup", f"touch {ready}"]
        stack.enter_context(_running(words, environment, folder / "openbox.log"))
        wait_until(ready.exists, "Openbox")
        yield Screen(environment, Path(environment["HOME"]), dict(environment))


@contextmanager
def headless_weston(folder: Path) -> Iterator[Screen]:
    """A Wayland compositor that has an output and no input devices."""
    environment = _clean(folder)
    words = ["--backend=headless-backend.so", f"--width={SIZE[0]}", f"--height={SIZE[1]}"]
    with _weston(words, environment, folder) as inside:
        yield Screen(inside, Path(inside["HOME"]), None)


@contextmanager
def nested_weston(folder: Path) -> Iterator[Screen]:
    """A Wayland compositor in a window of an X server, whose pointer and keys it has."""
    with xvfb(folder, SIZE) as outer:
        words = ["--backend=x11-backend.so", "--use-pixman"]
        words += [
            f"--width={SIZE[0]}",
            f"--height={SIZE[1]}",
            "--shell=kiosk-shell.so",
            "--fullscreen",
        ]
        with _weston(words, dict(outer.environment), folder) as inside:
            yield Screen(inside, outer.home, outer.pointer)


@contextmanager
def _weston(
    words: Sequence[str], environment: dict[str, str], folder: Path
) -> Iterator[dict[str, str]]:
    """Weston with a panel-free shell; yield the environment of its clients."""
    settings = folder / "weston.ini"
    settings.write_text("[shell]\npanel-position=none\nlocking=false\n[core]\nidle-time=0\n")
    socket = "bozzetto-tests"
    words = ["weston", f"--config={settings}", f"--socket={socket}", *words]
    with _running(words, environment, folder / "weston.log"):
        place = Path(environment["XDG_RUNTIME_DIR"]) / socket
        wait_until(place.exists, "Weston")
        inside = {k: v for k, v in environment.items() if k != "DISPLAY"}
        inside |= {"WAYLAND_DISPLAY": socket, "QT_QPA_PLATFORM": "wayland"}
        inside["XDG_SESSION_TYPE"] = "wayland"
        yield inside


def _clean(folder: Path) -> dict[str, str]:
    """A small environment whose folders are all below `folder`."""
    made = {name: os.environ[name] for name in KEPT if name in os.environ}
    made |= folders_below(folder)
    runtime = folder / "xdg_runtime_dir"
    runtime.mkdir(mode=0o700)
    made["XDG_RUNTIME_DIR"] = str(runtime)
    made["LIBGL_ALWAYS_SOFTWARE"] = "1"
    return made


@contextmanager
def _running(
    words: Sequence[str], environment: Mapping[str, str], log: Path, handed: Sequence[int] = ()
) -> Iterator[subprocess.Popen[bytes]]:
    """A program that runs until the block ends; its words go to a file."""
    with open(log, "wb") as file:
        process = subprocess.Popen(
            words,
            env=dict(environment),
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=file,
            pass_fds=tuple(handed),
        )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
