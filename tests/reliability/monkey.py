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
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from tests.conftest import move_home

SCALES: Final = ("1", "1", "1.5", "2")
"""Device pixels for a pixel, by seed."""

EVERY: Final = 500
"""Actions between two measurements."""

PATIENCE: Final = 4.0
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
        self.app.setQuitOnLastWindowClosed(False)
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
        self.figures: list[dict[str, float]] = []

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
        """Do so many actions in the event loop; return what was noticed."""
        self.watch.begin()
        self._turns.start()
        self.open_window()
        self._script = self._actions(actions)
        self._calm_by = 0.0
        self._go_on()
        self.app.exec()
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
            "figures": self.figures,
        }

    def _go_on(self) -> None:
        """Do the next action, if the window is ready or was waited for long enough."""
        from PySide6.QtCore import QTimer

        busy = self.window.session.busy or self.window.keeper.busy
        if busy and time.monotonic() < self._calm_by:
            QTimer.singleShot(3, self._go_on)
            return
        try:
            patience = next(self._script)
        except StopIteration:
            self.app.quit()
            return
        self._calm_by = time.monotonic() + patience
        QTimer.singleShot(0, self._go_on)

    def _actions(self, actions: int) -> Iterator[float]:
        """Do one action after the other; yield how long to wait for the work at most."""
        from tests.reliability.monkey_actions import ACTIONS
        from tests.reliability.window_watch import figures_now

        ways = [way for way, _ in ACTIONS]
        weights = [weight for _, weight in ACTIONS]
        for number in range(1, actions + 1):
            # A stream of its own for each action: one that finds nothing to do changes no other.
            self.chance = random.Random(self.seed * 1_000_003 + number)
            way = self.chance.choices(ways, weights)[0]
            patience = PATIENCE if self.chance.random() < 0.15 else 0.0
            self.watch.action = number
            self._began = time.monotonic()
            self._say(number, way.__name__)
            try:
                way(self)
            except Exception:
                self.watch.note("exception", traceback.format_exc())
            if not self.window.isVisible():
                self.open_window()
            yield patience
            if number % EVERY == 0:
                for _ in range(3):
                    self._clear()
                    yield PATIENCE
                self.figures.append(figures_now(number).as_dict())
                print(f"… {self.figures[-1]}", file=sys.stderr, flush=True)

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

    def _clear(self) -> None:
        """Close every dialog and menu, and put an empty sheet on the table."""
        for widget in self.app.topLevelWidgets():
            if widget is not self.window and widget.isVisible():
                widget.close()
        self.window.session.cancel_all()
        self.window.session.files.new()


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
        wrong = any(problem["kind"] not in ("qt", "warning") for problem in result["problems"])
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(1 if wrong else 0)


if __name__ == "__main__":
    sys.exit(main())
