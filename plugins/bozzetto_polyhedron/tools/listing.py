"""The tools in the order of the rail."""

from __future__ import annotations

from typing import Any

from bozzetto.plugin import Tool
from bozzetto_polyhedron.tools.chamfer import ChamferTool, RoundEdge
from bozzetto_polyhedron.tools.copies import CopiesTool
from bozzetto_polyhedron.tools.dimension import DimensionTool
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.erase import Erase
from bozzetto_polyhedron.tools.fittings import (
    DrawCrank,
    DrawHinge,
    DrawLink,
    DrawPin,
    DrawSlider,
    DrawSpring,
    TraceCorner,
)
from bozzetto_polyhedron.tools.mend import Mend
from bozzetto_polyhedron.tools.mirror import MirrorTool
from bozzetto_polyhedron.tools.move import Move
from bozzetto_polyhedron.tools.open_face import OpenFace
from bozzetto_polyhedron.tools.pieces import FreePiece
from bozzetto_polyhedron.tools.push import DrawOnFace, PushLoop
from bozzetto_polyhedron.tools.replay import Replay
from bozzetto_polyhedron.tools.slant import SlantTool
from bozzetto_polyhedron.tools.turn_solid import TurnSolid


def all_tools() -> tuple[Tool[Any], ...]:
    """Return the tools, most used first."""
    return (
        DrawLines(),
        TurnSolid(),
        DrawOnFace(),
        PushLoop(),
        OpenFace(),
        ChamferTool(),
        RoundEdge(),
        MirrorTool(),
        CopiesTool(),
        Move(),
        DrawLink(),
        DrawSpring(),
        DrawHinge(),
        DrawSlider(),
        DrawCrank(),
        DrawPin(),
        TraceCorner(),
        FreePiece(),
        Replay(),
        DimensionTool(),
        SlantTool(),
        Erase(),
        Mend(),
    )
