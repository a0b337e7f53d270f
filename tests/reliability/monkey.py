"""A monkey before the window: ``python -m tests.reliability.monkey --seed 3 --actions 5000``.

It uses the real window with everything a person has, in a random order that a seed names. What
goes wrong is told with the number of the action, on the standard error; the same command does
the same again, as far as the workers' threads allow. The last line of the standard output is
the result, in JSON. ``QT_QPA_PLATFORM`` chooses the platform, as ever.
"""

from __future__ import annotations

import argparse
import faulthandler
import json
import os
import random
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from tests.conftest import move_home

SCALES: Final = ("1", "1", "1.5", "2")
"""Device pixels for a pixel, by seed."""

EVERY: Final = 500
"""Actions between two measurements."""

PATIENCE: Final = 8.0
"""Seconds that a slow round waits for the window's work at most."""

STUCK: Final = 4.0
"""Seconds after which a menu or dialog that holds up an action is closed."""


class Player:
    """Chooses and does the actions; see `monkey_actions.Monkey` for what they ask of it."""

    def __init__(self, seed: int, folder: Path) -> None:
        from PySide6.QtCore import QTimer
        from PySide6.QtGui import QInputDevice, QPointingDevice
        from PySide6.QtTest import QTest
        from PySide6.QtWidgets import QColorDialog, QFileDialog

        from bozzetto.plugin.registry import Registry
        from bozzetto_app.start import application
        from bozzetto_app.tidying import Tidier
        from tests.reliability.monkey_files import write_files
        from tests.reliability.window_watch import Watch

        self.seed = seed
        self.chance = random.Random(seed)
        self.app = application()
        self.tidier = Tidier(self.app)
        self.folder = folder / "files"
        self.recovery = folder / "recovery"
        self.files = write_files(self.folder, Registry(), self.chance)
        self.watch = Watch()
        can = QInputDevice.Capability
        features = can.Position | can.Pressure | can.XTilt | can.YTilt | can.Rotation | can.Hover
        kinds = QPointingDevice.PointerType
        # Events hold a bare pointer to their device: these live as long as the process.
        self.pen, self.eraser = (
            QPointingDevice(name, 7, QInputDevice.DeviceType.Stylus, kind, features, 1, 3)
            for name, kind in (("pen", kinds.Pen), ("eraser", kinds.Eraser))
        )
        self.screen = QTest.createTouchDevice()
        self._stamp = 1000
        self._copies = 0
        self._began = time.monotonic()
        QFileDialog.getOpenFileName = self._file_to_open  # type: ignore[method-assign,assignment]
        QFileDialog.getSaveFileName = self._file_to_write  # type: ignore[method-assign,assignment]
        QColorDialog.getColor = self._color  # type: ignore[method-assign,assignment]
        self._turns = QTimer(interval=20)
        self._turns.timeout.connect(self._turned)
        self.window: Any = None

    # -- what the actions ask for --

    def stamp(self) -> int:
        """The time of the next event, ms."""
        self._stamp += 5
        return self._stamp

    def open_window(self) -> None:
        """Close the window for good, if there is one, and open another."""
        from bozzetto.plugin.registry import Registry
        from bozzetto_app.session import Session
        from bozzetto_app.window import Window

        old, self.window = self.window, Window(Session(Registry()), self.recovery)
        if old is not None:
            if old.isVisible():
                old._closing = True
                old.close()
            old.deleteLater()
            old.session.deleteLater()
        self.window.show()
        self.app.processEvents()

    def crash_a_copy(self) -> None:
        """Copy what is kept of the document on the sheet; a copy without a lock is a crash's."""
        folders = [one for one in sorted(self.recovery.glob("*/")) if (one / "lock").exists()]
        self._copies += 1
        if folders and self._copies <= 200:
            target = self.recovery / f"copy-{self._copies}"
            shutil.copytree(folders[-1], target, ignore=shutil.ignore_patterns("lock"))

    def _file_to_open(self, *arguments: Any, **options: Any) -> tuple[str, str]:
        named = str(self.chance.choice(self.files))
        return (named, "") if self.chance.random() < 0.8 else ("", "")

    def _file_to_write(self, *arguments: Any, **options: Any) -> tuple[str, str]:
        endings = (".bozz", ".stl", ".obj", ".3mf", ".glb", ".svg", ".step", ".txt", "")
        name = f"written {self.chance.randrange(6)}{self.chance.choice(endings)}"
        named = str(self.folder / name)
        return (named, "") if self.chance.random() < 0.8 else ("", "")

    def _color(self, *arguments: Any, **options: Any) -> Any:
        from PySide6.QtGui import QColor

        return QColor(self.chance.choice(("red", "#123456", "")))

    # -- playing --

    def play(self, actions: int) -> dict[str, Any]:
        """Do so many actions; return what was noticed."""
        from tests.reliability.monkey_actions import ACTIONS

        from .window_watch import figures_now

        self.watch.begin()
        self._turns.start()
        self.open_window()
        ways = [way for way, _ in ACTIONS]
        weights = [weight for _, weight in ACTIONS]
        figures = []
        for number in range(1, actions + 1):
            # A stream of its own for each action: one that finds nothing to do changes no other.
            self.chance = random.Random(self.seed * 1_000_003 + number)
            way = self.chance.choices(ways, weights)[0]
            self.watch.action = number
            self._began = time.monotonic()
            self._say(number, way.__name__)
            try:
                way(self)
            except Exception as problem:
                self.watch._uncaught(type(problem), problem, problem.__traceback__)
            if not self.window.isVisible():
                self.open_window()
            self._wait(patient=self.chance.random() < 0.25)
            if number % EVERY == 0:
                self._clear()
                figures.append(figures_now(number).as_dict())
                print(f"… {figures[-1]}", file=sys.stderr, flush=True)
        self._clear()
        self.watch.end()
        return {
            "seed": self.seed,
            "platform": self.app.platformName(),
            "actions": actions,
            "longest_pause": round(self.watch.longest, 2),
            "problems": [
                {"kind": one.kind, "action": one.action, "text": one.text}
                for one in self.watch.problems
            ],
            "figures": figures,
        }

    def _say(self, number: int, name: str) -> None:
        log.seek(0)
        log.write(f"{number} {name}".ljust(60))
        log.flush()

    def _turned(self) -> None:
        self.watch.beat()
        if time.monotonic() - self._began > STUCK:
            self._began = time.monotonic()
            front = self.app.activePopupWidget() or self.app.activeModalWidget()
            if front is not None:
                front.close()

    def _wait(self, *, patient: bool) -> None:
        """Let the event loop turn once, or until nothing is under way."""
        self.app.processEvents()
        end = time.monotonic() + PATIENCE
        while patient and time.monotonic() < end:
            if not self.window.session.busy and not self.window.keeper.busy:
                break
            time.sleep(0.002)
            self.app.processEvents()

    def _clear(self) -> None:
        """Close every dialog and menu, and put an empty sheet on the table."""
        for widget in self.app.topLevelWidgets():
            if widget is not self.window and widget.isVisible():
                widget.close()
        self.window.session.cancel_all()
        self.window.session.files.new()
        for _ in range(3):
            self._wait(patient=True)


log: Any = sys.stderr


def main(arguments: Sequence[str] | None = None) -> int:
    """Play, and print the result; 1 if something went wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.reliability.monkey")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--actions", type=int, default=5000)
    parser.add_argument("--log", type=Path, help="a file that names the action under way")
    options = parser.parse_args(arguments)
    faulthandler.enable()
    with tempfile.TemporaryDirectory(prefix="bozzetto-monkey-") as name:
        folder = Path(name)
        os.environ.update(move_home(folder))
        os.environ["QT_SCALE_FACTOR"] = SCALES[options.seed % len(SCALES)]
        global log
        with open(options.log or folder / "log", "w", encoding="utf-8") as log:
            result = Player(options.seed, folder).play(options.actions)
        print(json.dumps(result), flush=True)
        sys.stdout.flush()
        # Threads of workers may still run: what is measured is the window, not its end.
        wrong = any(problem["kind"] != "qt" for problem in result["problems"])
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(1 if wrong else 0)


if __name__ == "__main__":
    sys.exit(main())
