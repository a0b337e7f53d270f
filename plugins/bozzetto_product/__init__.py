"""Products: curves drawn on a rough shape, and exact surfaces between them.

After Kara & Shimada, "Supporting Early Styling Design of Automobiles Using Sketch-Based 3D Shape
Construction" and their book chapter, section 13.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_product.modeler import ProductModeler

    return [ProductModeler()]
