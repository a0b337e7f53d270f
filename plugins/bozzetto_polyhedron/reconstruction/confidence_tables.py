"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

LEADS: Final = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
"""Log odds of the share of the first answer at which `LOG_ODDS` stand."""

LOG_ODDS: Final = {
    "plain": (-12.504, -9.411, -7.477, -5.567, -4.784, -3.915, -2.119, -1.31, -0.265),
    "loose": (-12.673, -9.75, -8.244, -7.271, -6.36, -5.365, -3.244, -1.545, -0.001),
    "marked": (-12.078, -8.559, -6.554, -5.288, -4.625, -3.633, -2.337, -1.114, -0.017),
}
"""Log odds that the first answer is right, by `Evidence`, without its traits."""

TRAITS: Final = {
    "square corners": (0.06823, 1.0, 0.72),
    "square dihedral angles": (0.03536, 1.0, -0.2197),
    "equal lengths in a face": (0.02371, 0.5957, -1.288),
    "square classes": (0.0962, 1.0, -1.813),
    "depth against width, squared logarithm": (2.538e-06, 0.1573, -4.434),
    "steepness": (0.1702, 0.3236, -0.2138),
    "axis square to all else": (0.0, 1.0, -0.0922),
    "faces opposite one another": (0.0, 1.0, 0.9942),
    "frame coverage": (0.2874, 1.0, 0.2936),
    "equal angles in a face": (0.2491, 1.0, 1.675),
    "mirror plane": (0.2286, 1.0, -0.5233),
    "further mirror planes": (0.1282, 0.9995, 0.2353),
    "frame coverage, sixth power": (0.0005633, 1.0, -1.124),
    "stands upright": (0.0373, 1.0, 0.2605),
    "planarity beyond the noise": (0.0, 0.2712, -3.446),
    "depth residual": (6.525e-15, 1.074, 0.7797),
    "strict classes": (0.0, 1.0, -0.04907),
    "open lines": (0.0, 0.0, 0.0),
    "through-holes": (0.0, 1.0, -0.9464),
    "parts that stand out": (0.0, 1.0, 0.1838),
    "misfit of loose parts": (0.0, 0.75, -0.8609),
    "parts that hang nowhere": (0.0, 0.0, 0.0),
    "gaps of loose parts": (0.0, 0.0, 0.0),
    "marks of hidden lines": (-18.54, 0.0, 0.06422),
    "logarithm of the number of lines": (2.197, 3.584, 2.153),
    "noise, diagonals": (0.002, 0.03093, 27.38),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
