"""The program as a process of its own, which answers questions over a pipe."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

from tests.display.screens import Screen, folders_below, wait_until

__all__ = ["Program"]

ROOT: Final = Path(__file__).parents[2]
TICK: Final = os.sysconf("SC_CLK_TCK")
PATIENCE: Final = 90.0

STARTING: Final = 60.0
"""How long a start may go on behind the first paint on a loaded machine, seconds."""

QUIET: Final = 0.01
"""Share of a processor below which the start is over."""


class Program:
    """The real window on a screen; see `driver` for what can be asked.

    Parameters
    ----------
    screen : Screen
    words : str
        Arguments of the program.
    module : str
        What is run; only the driver answers questions.
    variables : str
        More of its environment.
    """

    def __init__(
        self,
        screen: Screen,
        *words: str,
        module: str = "tests.display.driver",
        **variables: str,
    ) -> None:
        self.screen = screen
        # A home of its own: a program that is killed leaves something to recover.
        home = Path(tempfile.mkdtemp(prefix="program-", dir=screen.home))
        variables |= folders_below(home)
        self._log = home / "stderr.txt"
        with open(self._log, "ab") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", module, *words],
                cwd=ROOT,
                env={**screen.environment, **variables},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                bufsize=1,
            )
        self._lines = selectors.DefaultSelector()
        assert self.process.stdout is not None
        self._lines.register(self.process.stdout, selectors.EVENT_READ)

    def __enter__(self) -> Program:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            assert pipe is not None
            pipe.close()
        self._lines.close()

    @property
    def said(self) -> str:
        """What the process wrote to stderr."""
        return self._log.read_text(errors="replace")

    def ask(self, what: str, **facts: Any) -> Any:
        """Put a question and wait for its answer.

        Raises
        ------
        RuntimeError
            If the process died, does not answer in time, or answers with a traceback.
        """
        pipe, lines = self.process.stdin, self.process.stdout
        assert pipe is not None
        assert lines is not None
        pipe.write(json.dumps({"do": what, **facts}) + "\n")
        pipe.flush()
        if not self._lines.select(PATIENCE):
            raise RuntimeError(f"no answer to {what!r} in {PATIENCE:.0f} s: {self.said}")
        line = lines.readline()
        if not line:
            raise RuntimeError(f"the program ended ({self.process.wait()}): {self.said}")
        answer = json.loads(line)
        if "problem" in answer:
            raise RuntimeError(answer["problem"])
        return answer["is"]

    def wait_painted(self) -> None:
        """Wait for the first paint, and until what it starts has ended."""
        wait_until(lambda: self.ask("painted"), "the first paint")
        self.wait_calm()

    def wait_calm(self) -> None:
        """Wait until the program has nothing to do."""
        wait_until(lambda: self.ask("calm"), "the program's work")

    def processor_seconds(self) -> float:
        """Processor time of all threads so far, seconds."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICK

    def wakeups(self) -> int:
        """How often the window's thread was woken so far."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.partition("\nvoluntary_ctxt_switches:")[2].split()[0])

    def idle_share(self, seconds: float) -> tuple[float, float]:
        """Share of one processor (0 … 1) and wakeups per second while nobody touches it.

        What the start leaves to be done (libraries, OpenGL) is waited for, but not for ever.
        """
        end = time.monotonic() + STARTING
        while self._used(1.0)[0] > QUIET and time.monotonic() < end:
            pass
        return self._used(seconds)

    def _used(self, seconds: float) -> tuple[float, float]:
        spent, woken, begun = self.processor_seconds(), self.wakeups(), time.monotonic()
        time.sleep(seconds)
        passed = time.monotonic() - begun
        return (self.processor_seconds() - spent) / passed, (self.wakeups() - woken) / passed
