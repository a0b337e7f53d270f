"""Blender as an independent reader: asked as a program, in a Python that has the package ``bpy``.

BOZZETTO_BLENDER names that Python; Blender is under the GPL and stays outside.
"""

from __future__ import annotations

import json
import os
import subprocess
from typing import Any

import pytest

BEGIN = """
import bpy, json, os, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
"""

END = """
print("answer:" + json.dumps(answer), flush=True)
os._exit(0)  # as a module it may crash while it is taken down
"""


def asked(script: str, *arguments: object) -> Any:
    """Run a script that leaves an ``answer``; the test is skipped where there is no Blender."""
    python = os.environ.get("BOZZETTO_BLENDER")
    if not python:
        pytest.skip("BOZZETTO_BLENDER names no Python with bpy")
    done = subprocess.run(
        [python, "-c", BEGIN + script + END, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    line = next(line for line in done.stdout.splitlines() if line.startswith("answer:"))
    return json.loads(line.removeprefix("answer:"))
