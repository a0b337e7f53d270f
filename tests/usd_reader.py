"""USD's own library as an independent reader: asked as a program, in a Python that has ``pxr``.

BOZZETTO_USD names that Python; the licence of the library (TOST 1.0) keeps it outside.
"""

from __future__ import annotations

import json
import os
import subprocess
from typing import Any

import pytest

BEGIN = """
import json, sys
from pxr import Gf, Usd, UsdGeom, UsdShade, UsdSkel, UsdUtils, UsdValidation, Vt
stage = Usd.Stage.Open(sys.argv[1])

def rows(values):
    return [list(map(float, value)) for value in values]
"""

END = """
print("answer:" + json.dumps(answer), flush=True)
"""


def python_of_usd() -> str:
    """Return the Python that has USD; skip the test where there is none."""
    python = os.environ.get("BOZZETTO_USD")
    if not python:
        pytest.skip("BOZZETTO_USD names no Python with pxr")
    return python


def asked_usd(script: str, *arguments: object) -> Any:
    """Run a script about the ``stage`` of a file that leaves an ``answer``; skip without USD."""
    done = subprocess.run(
        [python_of_usd(), "-c", BEGIN + script + END, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    line = next(line for line in done.stdout.splitlines() if line.startswith("answer:"))
    return json.loads(line.removeprefix("answer:"))
