"""Short runs of the long tests: mutated files, and processes killed at any moment."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.reliability import suite_kills
from tests.sizes import sized

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
def test_mutated_files_are_one_error_or_open():
    count = str(sized(4_000, 20_000))
    told = command("tests.reliability.mutated_documents", "--count", count, "--seed", "7")
    assert f"{count} mutated" in told


@needs_fork
@pytest.mark.kill
def test_kills_lose_nothing():
    command("tests.reliability", "kills", "--share", str(sized(20, 300) / suite_kills.COUNT))
