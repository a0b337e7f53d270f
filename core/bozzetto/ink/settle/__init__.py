"""Settle: several strokes, drawn over one another in any order and direction, become one curve."""

from __future__ import annotations

from bozzetto.ink.settle.fading import fading
from bozzetto.ink.settle.portfolio import Settled, settle

__all__ = ["Settled", "fading", "settle"]
