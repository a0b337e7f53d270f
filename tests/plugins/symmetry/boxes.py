"""A box that stands beside the origin, and planes that cut it."""

from __future__ import annotations

from dataclasses import replace

from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane

__all__ = ["PLANES", "STATE", "tilted"]

STATE = SymmetryState(centre=(10.0, -5.0, 30.0), length=200.0, width=120.0, height=80.0)
PLANES = [
    CentrePlane((10, 0, 30), (1, 1, 0.4)),
    CentrePlane((20, -5, 25), (1, 1, 1)),
    CentrePlane((-40, 0, 30), (2, 0.1, -0.3)),
    CentrePlane((10, -65, 30), (0, -1, 0)),  # a face of the box
]


def tilted(plane: CentrePlane) -> SymmetryState:
    """The box with a plane of its own."""
    return replace(STATE, symmetry="free", free_plane=plane)
