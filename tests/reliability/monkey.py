"""A monkey before the window: ``python -m tests.reliability.monkey --seed 3 --actions 5000``.

It uses the real window with everything a person has, in a random order that a seed names. What
goes wrong is told with the number of the action, on the standard error; the same command does
the same again, as far as the workers' threads allow. The last line of the standard output is
the result, in JSON. ``QT_QPA_PLATFORM`` chooses the platform, as ever.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from tests.reliability.stage import Script, Stage, perform

SCALES: Final = ("1", "1", "1.5", "2")
"""Device pixels for a pixel, by seed."""

EVERY: Final = 500
"""Actions between two measurements."""

PATIENCE: Final = 4.0
"""Seconds that a slow action waits for the window's work at most."""

SLOW: Final = 0.15
"""Share of the actions that wait; the others are followed by the next one at once."""

MOST_CRASHES: Final = 200
"""Copies of recovery data that are left in a run."""


class Player:
    """Chooses and does the actions; see `monkey_actions.Monkey` for what they ask of it."""

    def __init__(self, seed: int, stage: Stage) -> None:
        from PySide6.QtGui import QInputDevice, QPointingDevice
        from PySide6.QtTest import QTest
        from PySide6.QtWidgets import QColorDialog, QFileDialog

        from bozzetto.plugin.host.registry import Registry
        from tests.reliability.monkey_files import write_files

        self.seed = seed
        self.stage = stage
        self.chance = random.Random(seed)
        self.folder = stage.folder / "files"
        self.files = write_files(self.folder, Registry(), self.chance)
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
        self._crashes = 0
        # What would be a dialog of the system's is answered here.
        QFileDialog.getOpenFileName = self._file_to_open  # type: ignore[method-assign,assignment]
        QFileDialog.getOpenFileNames = self._files_to_open  # type: ignore[method-assign,assignment]
        QFileDialog.getSaveFileName = self._file_to_write  # type: ignore[method-assign,assignment]
        QColorDialog.getColor = self._color  # type: ignore[method-assign,assignment]

    # -- what the actions ask for --

    @property
    def window(self) -> Any:
        """The window that is open now."""
        return self.stage.window

    def open_window(self) -> None:
        """Close the window for good and open another."""
        self.stage.open_window()

    def stamp(self) -> int:
        """The time of the next event, ms."""
        self._stamp += 5
        return self._stamp

    def crash_a_copy(self) -> None:
        """Copy what is kept of the document on the sheet; a copy without a lock is a crash's."""
        kept = self.stage.recovery
        folders = [one for one in sorted(kept.glob("*/")) if (one / "lock").exists()]
        self._crashes += 1
        if folders and self._crashes <= MOST_CRASHES:
            copy = kept / f"copy-{self._crashes}"
            shutil.copytree(folders[-1], copy, ignore=shutil.ignore_patterns("lock"))

    def _file_to_open(self, *arguments: Any, **options: Any) -> tuple[str, str]:
        named = str(self.chance.choice(self.files))
        return (named, "") if self.chance.random() < 0.8 else ("", "")

    def _files_to_open(self, *arguments: Any, **options: Any) -> tuple[list[str], str]:
        count = self.chance.choice((0, 1, 1, 3))
        return [str(self.chance.choice(self.files)) for _ in range(count)], ""

    def _file_to_write(self, *arguments: Any, **options: Any) -> tuple[str, str]:
        endings = (".bozz", ".stl", ".obj", ".3mf", ".glb", ".svg", ".step", ".txt", "")
        name = f"written {self.chance.randrange(6)}{self.chance.choice(endings)}"
        named = str(self.folder / name)
        return (named, "") if self.chance.random() < 0.8 else ("", "")

    def _color(self, *arguments: Any, **options: Any) -> Any:
        from PySide6.QtGui import QColor

        return QColor(self.chance.choice(("red", "#123456", "")))

    # -- playing --

    def script(self, actions: int) -> Script:
        """One action after the other, with a look at what the process holds now and then."""
        from tests.reliability.monkey_actions import ACTIONS

        ways = [way for way, _ in ACTIONS]
        weights = [weight for _, weight in ACTIONS]
        for number in range(1, actions + 1):
            # A stream of its own for each action: one that finds nothing to do changes no other.
            self.chance = random.Random(self.seed * 1_000_003 + number)
            way = self.chance.choices(ways, weights)[0]
            patience = PATIENCE if self.chance.random() < SLOW else 0.0
            self.stage.do(number, way.__name__, partial(way, self))
            yield patience
            if number % EVERY == 0 or number == actions:
                yield from self.stage.measure(number)


def main(arguments: Sequence[str] | None = None) -> int:
    """Play, and print the result; 1 if something went wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.reliability.monkey")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--actions", type=int, default=5000)
    parser.add_argument("--log", type=Path, help="a file that names the action under way")
    options = parser.parse_args(arguments)
    os.environ["QT_SCALE_FACTOR"] = SCALES[options.seed % len(SCALES)]

    def play(stage: Stage) -> dict[str, Any]:
        result = stage.run(Player(options.seed, stage).script(options.actions))
        return {"seed": options.seed, "actions": options.actions, **result}

    perform(play, options.log)
    return 0


if __name__ == "__main__":
    sys.exit(main())
