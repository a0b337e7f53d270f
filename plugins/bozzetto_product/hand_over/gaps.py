"""Gaps that the ends of curves in files have: they are closed, the smallest first."""

from __future__ import annotations

from typing import Final

from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.trim import crossings_joined, ends_joined

WIDTHS: Final = (1e-3, 3e-3, 1e-2, 2e-2)
"""Gaps that are closed, one after the other, as shares of the diagonal: what nearly meets is joined
before what is farther apart, so that narrow strips stay strips."""

CROSSING: Final = 1e-2
"""Largest distance, as share of the diagonal, of curves that cross."""


def with_gaps_closed(state: ProductState, size: float) -> ProductState:
    """Join free ends to what they nearly meet, and curves where they nearly cross.

    Parameters
    ----------
    state : ProductState
        Curves, joined where they meet exactly.
    size : float
        Diagonal of the network, mm.

    Returns
    -------
    ProductState
        The same object where nothing was left to join.
    """
    for width in WIDTHS:
        state, _ = ends_joined(state, width * size)
        if width == CROSSING:
            state, _ = crossings_joined(state, width * size)
    return state
