"""The contract suite on the product modeler."""

from __future__ import annotations

from bozzetto.testing import ModelerContract, Pen, Shell
from tests.plugins.product.pen_strokes import draw_rectangle


class TestProduct(ModelerContract):
    modeler = "bozzetto.product"

    def sketch(self, shell: Shell, pen: Pen) -> None:
        """A rectangle on the top of a box."""
        draw_rectangle(shell, pen)
