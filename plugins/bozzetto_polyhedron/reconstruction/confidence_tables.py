"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

LEADS: Final = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
"""Log odds of the share of the first answer at which `LOG_ODDS` stand."""

LOG_ODDS: Final = {
    "plain": (-10.271, -7.045, -5.221, -3.77, -2.775, -2.005, -0.302, 1.515, 3.097),
    "loose": (-10.474, -7.451, -5.923, -5.227, -4.238, -2.878, -0.906, 0.818, 2.429),
    "marked": (-10.04, -6.583, -4.639, -3.699, -2.801, -1.994, -0.729, 0.774, 1.846),
}
"""Log odds that the first answer is right, by `Evidence`, without its traits."""

TRAITS: Final = {
    "square corners": (0.07469, 1.0, -0.08206),
    "square dihedral angles": (0.03881, 1.0, 0.2922),
    "equal lengths in a face": (0.02264, 0.554, -1.559),
    "square classes": (0.1026, 1.0, -0.9507),
    "depth against width, squared logarithm": (1.973e-06, 0.1573, -5.192),
    "steepness": (0.1702, 0.3214, 0.5634),
    "axis square to all else": (0.0, 1.0, 0.6046),
    "faces opposite one another": (0.0, 1.0, 0.9904),
    "frame coverage": (0.3037, 1.0, -0.557),
    "equal angles in a face": (0.2575, 1.0, 0.6241),
    "mirror plane": (0.2392, 1.0, 0.04299),
    "further mirror planes": (0.1315, 0.9999, 0.09227),
    "frame coverage, sixth power": (0.0007845, 1.0, -0.8938),
    "stands upright": (0.02805, 1.0, 0.3291),
    "planarity beyond the noise": (0.0, 0.2609, -3.407),
    "depth residual": (6.501e-15, 1.154, 0.9614),
    "strict classes": (0.0, 1.0, -0.02101),
    "open lines": (0.0, 0.0, 0.0),
    "through-holes": (0.0, 1.0, -0.8836),
    "parts that stand out": (0.0, 1.0, 0.536),
    "misfit of loose parts": (0.0, 0.7996, -0.8353),
    "parts that hang nowhere": (0.0, 0.0, 0.0),
    "marks of hidden lines": (-18.54, 0.0, 0.05027),
    "logarithm of the number of lines": (2.197, 3.584, 1.335),
    "noise, diagonals": (0.002, 0.03053, 23.1),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
