"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

LEADS: Final = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
"""Log odds of the share of the first answer at which `LOG_ODDS` stand."""

LOG_ODDS: Final = {
    "plain": (-11.299, -8.129, -6.302, -4.631, -3.664, -2.835, -1.083, 0.767, 2.356),
    "loose": (-11.49, -8.511, -7.025, -6.343, -5.222, -4.034, -2.014, -0.23, 1.406),
    "marked": (-11.033, -7.596, -5.648, -4.546, -3.703, -2.879, -1.676, -0.114, 1.053),
}
"""Log odds that the first answer is right, by `Evidence`, without its traits."""

TRAITS: Final = {
    "square corners": (0.06787, 1.0, -0.04128),
    "square dihedral angles": (0.0308, 1.0, 0.1339),
    "equal lengths in a face": (0.02422, 0.5622, -1.687),
    "square classes": (0.09693, 1.0, -1.033),
    "depth against width, squared logarithm": (1.973e-06, 0.1636, -4.137),
    "steepness": (0.1694, 0.3214, 0.8568),
    "axis square to all else": (0.0, 1.0, 0.6356),
    "faces opposite one another": (0.0, 1.0, 1.119),
    "frame coverage": (0.303, 1.0, -0.6409),
    "equal angles in a face": (0.2568, 1.0, 0.629),
    "mirror plane": (0.2365, 1.0, -0.1008),
    "further mirror planes": (0.1304, 0.9999, 0.05072),
    "frame coverage, sixth power": (0.0007747, 1.0, -0.8782),
    "stands upright": (0.02968, 1.0, 0.1655),
    "planarity beyond the noise": (0.0, 0.2609, -4.106),
    "depth residual": (6.334e-15, 1.098, 1.021),
    "strict classes": (0.0, 1.0, -0.1614),
    "open lines": (0.0, 0.0, 0.0),
    "through-holes": (0.0, 1.0, -0.918),
    "parts that stand out": (0.0, 1.0, 0.3256),
    "misfit of loose parts": (0.0, 0.7195, -0.5935),
    "parts that hang nowhere": (0.0, 0.0, 0.0),
    "marks of hidden lines": (-18.63, 0.0, 0.0519),
    "logarithm of the number of lines": (2.197, 3.584, 1.742),
    "noise, diagonals": (0.002, 0.03078, 25.83),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
