"""Windows in processes of their own, on a platform of Qt: started, waited for, looked after."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

__all__ = ["PLATFORMS", "Outcome", "is_possible", "play"]

PLATFORMS: Final = ("offscreen", "xcb")
PROJECT: Final = Path(__file__).parents[2]
SCREEN: Final = "-screen 0 1600x1200x24 +extension GLX"

LAST_WORDS: Final = 4000
"""Characters of the standard error that are kept of a process that died."""


@dataclass(frozen=True)
class Outcome:
    """What became of a process.

    Parameters
    ----------
    name : str
        By which it can be played again.
    result : dict or None
        What it printed at its end; None where it did not come to it.
    last : str
        Number and name of the action that was under way last.
    words : str
        The end of what it said.
    """

    name: str
    result: dict[str, Any] | None
    last: str
    words: str

    @property
    def problems(self) -> list[dict[str, Any]]:
        """What was noticed, in order."""
        return [] if self.result is None else list(self.result["problems"])

    def of_kind(self, *kinds: str) -> list[str]:
        """Where problems of some kinds came up, as names to be played again."""
        return [f"{self.name} at {p['action']}" for p in self.problems if p["kind"] in kinds]

    def figures(self, after: int) -> list[dict[str, float]]:
        """What the process held, from an action on."""
        kept = [] if self.result is None else self.result["figures"]
        return [each for each in kept if each["action"] >= after]


def is_possible(platform: str) -> bool:
    """Whether windows can be opened on a platform here."""
    return platform == "offscreen" or shutil.which("xvfb-run") is not None


def play(
    module: str, arguments: Sequence[str], platform: str, patience: float, name: str
) -> Outcome:
    """Run a module that ends with a line of JSON; one that takes too long is ended.

    Parameters
    ----------
    module : str
        Of this folder.
    arguments : sequence of str
    platform : str
        One of `PLATFORMS`.
    patience : float
        Seconds.
    name : str
        Of the outcome.
    """
    with tempfile.TemporaryDirectory(prefix="bozzetto-played-") as folder:
        log = Path(folder) / "log"
        words = [sys.executable, "-m", f"tests.reliability.{module}", *arguments, "--log", str(log)]
        if platform == "xcb":
            manager = "openbox > /dev/null 2>&1 & " if shutil.which("openbox") else ""
            words = [
                "xvfb-run",
                "-a",
                "-s",
                SCREEN,
                "sh",
                "-c",
                f'{manager}exec "$@"',
                "sh",
                *words,
            ]
        environment = {**os.environ, "QT_QPA_PLATFORM": platform}
        output, errors = Path(folder) / "output", Path(folder) / "errors"
        with open(output, "wb") as out, open(errors, "wb") as wrong:
            process = subprocess.Popen(
                words, cwd=PROJECT, env=environment, stdout=out, stderr=wrong,
                start_new_session=True,
            )  # fmt: skip
            try:
                process.wait(patience)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, 9)
                process.wait()
        said = errors.read_text(encoding="utf-8", errors="replace")[-LAST_WORDS:]
        lines = output.read_text(encoding="utf-8", errors="replace").splitlines()
        result = json.loads(lines[-1]) if lines and lines[-1].startswith("{") else None
        last = log.read_text(encoding="utf-8").strip() if log.exists() else "the start"
    if result is None:
        print(f"{name} died at {last}:\n{said}", file=sys.stderr, flush=True)
    for problem in result["problems"] if result else ():
        print(f"{name} at {problem['action']}: {problem['text']}", file=sys.stderr, flush=True)
    return Outcome(name, result, last, said)
