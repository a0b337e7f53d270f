"""Short runs of the long tests: mutated files, and processes killed at any moment."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
def test_sixty_kills_during_saves_lose_nothing():
    assert "60 kills, 0 lost, 0 stale" in command("tests.kill_documents", "saves", "--count", "60")


@needs_fork
def test_sixty_kills_while_drawing_lose_at_most_the_stroke_under_way():
    assert "60 kills, 0 lost, 0 wrong" in command(
        "tests.kill_documents", "drawing", "--count", "60"
    )


@needs_fork
@pytest.mark.kill
@pytest.mark.parametrize("what", ["saves", "drawing"])
def test_a_thousand_kills(what):
    assert "1000 kills, 0 lost, 0 " in command("tests.kill_documents", what, "--count", "1000")
