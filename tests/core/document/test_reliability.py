"""Short runs of the long tests: mutated files, and processes killed at any moment."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.reliability import suite_kills

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")


def command(module: str, *arguments: str) -> str:
    """Run one of the long tests' commands in a process of its own."""
    paths = [str(ROOT), *filter(None, sys.path)]
    run = subprocess.run(
        [sys.executable, "-m", module, *arguments],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@needs_fork
def test_twenty_thousand_mutated_files_are_one_error_or_open():
    assert "20000 mutated" in command(
        "tests.reliability.mutated_documents", "--count", "20000", "--seed", "7"
    )


@needs_fork
@pytest.mark.parametrize("what", ["saves", "drawing", "recovering"])
def test_sixty_kills_lose_nothing(what):
    tally = getattr(suite_kills, what)(60)
    assert [tally.get(name, 0) for name in ("lost", "stale", "wrong")] == [0, 0, 0], tally


@needs_fork
@pytest.mark.kill
def test_three_hundred_kills_of_each_kind_lose_nothing():
    assert [row for row in suite_kills.rows(0.3) if not row.kept] == []
