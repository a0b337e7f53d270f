"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

LEADS: Final = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
"""Log odds of the share of the first answer at which `LOG_ODDS` stand."""

LOG_ODDS: Final = {
    "plain": (-8.43, -5.114, -3.214, -1.901, -1.068, -0.062, 1.637, 3.263, 4.793),
    "loose": (-8.549, -5.353, -3.657, -2.696, -2.177, -1.155, 0.481, 2.082, 3.621),
    "marked": (-8.477, -5.208, -3.439, -2.253, -1.33, -0.46, 0.786, 1.992, 3.208),
}
"""Log odds that the first answer is right, by `Evidence`, without its traits."""

TRAITS: Final = {
    "square corners": (0.1101, 1.0, 0.00154),
    "square dihedral angles": (0.07334, 1.0, -0.009081),
    "equal lengths in a face": (0.02498, 0.5858, -0.314),
    "square classes": (0.1126, 1.0, -0.6687),
    "depth against width, squared logarithm": (2.487e-06, 0.1558, -4.921),
    "steepness": (0.1733, 0.3539, -1.623),
    "axis square to all else": (0.0, 1.0, 0.3927),
    "faces opposite one another": (0.0, 1.0, 0.5648),
    "frame coverage": (0.3121, 1.0, 0.2092),
    "equal angles in a face": (0.2197, 1.0, 1.146),
    "mirror plane": (0.2038, 1.0, 0.3139),
    "further mirror planes": (0.1251, 0.9958, 0.2668),
    "frame coverage, sixth power": (0.0009245, 1.0, -0.5325),
    "planarity beyond the noise": (0.0, 0.1952, -8.049),
    "depth residual": (6.246e-15, 1.04, 0.7791),
    "strict classes": (0.0, 1.0, 0.3236),
    "open lines": (0.0, 0.0, 0.0),
    "through-holes": (0.0, 1.0, -0.356),
    "parts that stand out": (0.0, 1.0, 0.5958),
    "misfit of loose parts": (0.0, 0.8305, 0.06024),
    "parts that hang nowhere": (0.0, 0.0, 0.0),
    "marks of hidden lines": (-16.88, 0.0, 0.0203),
    "logarithm of the number of lines": (2.197, 3.584, 0.5535),
    "noise, diagonals": (0.002, 0.03071, 9.025),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
