"""All tools, most used first."""

from __future__ import annotations

from collections.abc import Sequence

from bozzetto.plugin import Tool
from bozzetto_product.model.state import ProductState
from bozzetto_product.tools.crease import SwitchCrease
from bozzetto_product.tools.detail import DrawDetail
from bozzetto_product.tools.draw_curve import DrawCurve
from bozzetto_product.tools.emblem import LayText
from bozzetto_product.tools.erase import Erase
from bozzetto_product.tools.fillet import Fillet
from bozzetto_product.tools.join import Join
from bozzetto_product.tools.loop import SwitchLoop
from bozzetto_product.tools.modify import Modify
from bozzetto_product.tools.move import Move
from bozzetto_product.tools.plane import SetPlane
from bozzetto_product.tools.pull import Pull
from bozzetto_product.tools.redraw import Redraw
from bozzetto_product.tools.split import Split


def all_tools() -> Sequence[Tool[ProductState]]:
    """Return the tools of the pen, most used first."""
    return (
        DrawCurve(),
        Modify(),
        SwitchLoop(),
        Move(),
        Erase(),
        DrawDetail(),
        LayText(),
        Pull(),
        Redraw(),
        Split(),
        Join(),
        SetPlane(),
        Fillet(),
        SwitchCrease(),
    )
