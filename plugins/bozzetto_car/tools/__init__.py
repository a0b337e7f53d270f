"""The tools of the pen for a car."""

from __future__ import annotations

from collections.abc import Sequence

from bozzetto.plugin import Tool
from bozzetto_car.state import CarState
from bozzetto_car.tools.draw_style import Style
from bozzetto_car.tools.join_lines import JoinLines
from bozzetto_car.tools.mark_points import MarkPoints
from bozzetto_car.tools.shape_nodes import ShapeNodes
from bozzetto_car.tools.trace_edges import TraceEdges


def all_tools() -> Sequence[Tool[CarState]]:
    """Return all tools, most used first."""
    return (MarkPoints(), TraceEdges(), ShapeNodes(), Style(), JoinLines())
