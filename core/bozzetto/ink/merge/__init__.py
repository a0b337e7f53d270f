"""Merging: several strokes, drawn over one another in any order, become one curve."""

from __future__ import annotations

from bozzetto.ink.merge.merge import Settled, settle
from bozzetto.ink.merge.weights import fading

__all__ = ["Settled", "fading", "settle"]
