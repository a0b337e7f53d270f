"""Numbers of the ranking; written by ``python -m tests.plugins.polyhedron.fit_ranking``."""

from __future__ import annotations

from typing import Final

WEIGHTS: Final = {
    "square corners": 1.11,
    "square dihedral angles": 0.62,
    "equal lengths in a face": 2.87,
    "square classes": 0.78,
    "depth against width, squared logarithm": -3.15,
    "steepness": -5.29,
    "axis square to all else": 1.25,
    "faces opposite one another": 2.24,
    "frame coverage": 0.72,
    "equal angles in a face": 9.93,
    "mirror plane": 1.74,
    "further mirror planes": 3.81,
    "frame coverage, sixth power": 3.89,
    "planarity beyond the noise": -0.64,
    "depth residual": 0.12,
    "strict classes": -0.09,
    "open lines": -1.06,
    "through-holes": 0.58,
    "parts that stand out": -0.56,
    "misfit of loose parts": -1.06,
    "parts that hang nowhere": -1.50,
    "marks of hidden lines": 0.86,
}
"""Weight of each measure."""
