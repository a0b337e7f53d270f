"""Numbers of the ranking; written by ``python -m tests.plugins.polyhedron.fit_ranking``."""

from __future__ import annotations

from typing import Final

WEIGHTS: Final = {
    "square corners": 0.98,
    "square dihedral angles": 0.69,
    "equal lengths in a face": 2.64,
    "square classes": 0.80,
    "depth against width, squared logarithm": -2.77,
    "steepness": -5.05,
    "axis square to all else": 1.17,
    "faces opposite one another": 2.17,
    "frame coverage": 0.90,
    "equal angles in a face": 9.85,
    "mirror plane": 2.58,
    "further mirror planes": 5.44,
    "frame coverage, sixth power": 3.49,
    "stands upright": 1.03,
    "planarity beyond the noise": -0.60,
    "depth residual": 0.18,
    "strict classes": -0.50,
    "open lines": -1.06,
    "through-holes": 0.50,
    "parts that stand out": -0.29,
    "misfit of loose parts": -0.43,
    "parts that hang nowhere": -6.00,
    "gaps of loose parts": -1.00,
    "marks of hidden lines": 0.90,
}
"""Weight of each measure."""
