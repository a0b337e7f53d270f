"""The tools of the pen, one in a module."""

from __future__ import annotations

from typing import Any

from bozzetto.plugin import Tool
from bozzetto_symmetry.tools.draw_curve import DrawCurve
from bozzetto_symmetry.tools.draw_line import DrawLine
from bozzetto_symmetry.tools.join import JoinCurves
from bozzetto_symmetry.tools.modify import Modify
from bozzetto_symmetry.tools.plane import SetPlane
from bozzetto_symmetry.tools.resize_box import ResizeBox
from bozzetto_symmetry.tools.split import Split


def all_tools() -> tuple[Tool[Any], ...]:
    """Return the tools in the order of the rail, most used first."""
    return (DrawCurve(), Modify(), Split(), JoinCurves(), DrawLine(), ResizeBox(), SetPlane())
