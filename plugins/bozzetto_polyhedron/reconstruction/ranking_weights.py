"""Numbers of the ranking; written by ``python -m tests.plugins.polyhedron.fit_ranking``."""

from __future__ import annotations

from typing import Final

WEIGHTS: Final = {
    "square corners": 1.14,
    "square dihedral angles": 0.29,
    "equal lengths in a face": 2.46,
    "square classes": 0.77,
    "depth against width, squared logarithm": -2.86,
    "steepness": -4.74,
    "axis square to all else": 1.48,
    "faces opposite one another": 2.12,
    "frame coverage": 0.86,
    "equal angles in a face": 10.07,
    "mirror plane": 1.83,
    "further mirror planes": 5.61,
    "frame coverage, sixth power": 4.21,
    "planarity beyond the noise": -0.65,
    "depth residual": 0.21,
    "strict classes": -0.46,
    "open lines": -1.07,
    "through-holes": 0.48,
    "parts that stand out": -0.28,
    "misfit of loose parts": -0.44,
    "parts that hang nowhere": -1.50,
    "marks of hidden lines": 0.87,
}
"""Weight of each measure."""
