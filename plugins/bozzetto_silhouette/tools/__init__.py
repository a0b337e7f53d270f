"""The tools. Imports everything below."""

from __future__ import annotations

from typing import Any

from bozzetto.plugin import Tool
from bozzetto_silhouette.tools.animate import Animate
from bozzetto_silhouette.tools.arrange import Arrange
from bozzetto_silhouette.tools.brush import Brush
from bozzetto_silhouette.tools.cut import DrawCut
from bozzetto_silhouette.tools.draw_outline import DrawOutline
from bozzetto_silhouette.tools.draw_profile import DrawProfile
from bozzetto_silhouette.tools.extrude import Extrude
from bozzetto_silhouette.tools.mirror import MirrorCopy
from bozzetto_silhouette.tools.outline_edits import SketchOver, Smooth
from bozzetto_silhouette.tools.paint import Paint
from bozzetto_silhouette.tools.project_picture import ProjectPicture
from bozzetto_silhouette.tools.tunnel import DrawTunnel

__all__ = ["DrawOutline", "all_tools"]


def all_tools() -> tuple[Tool[Any], ...]:
    """Return the tools in the order of the rail, most used first."""
    return (
        DrawOutline(),
        SketchOver(),
        Smooth(),
        DrawProfile(),
        DrawTunnel(),
        DrawCut(),
        Extrude(),
        Arrange(),
        Animate(),
        MirrorCopy(),
        Paint(),
        Brush(),
        ProjectPicture(),
    )
