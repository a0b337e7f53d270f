"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

LEADS: Final = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
"""Log odds of the share of the first answer at which `LOG_ODDS` stand."""

LOG_ODDS: Final = {
    "plain": (-12.877, -9.53, -7.326, -6.458, -5.73, -4.935, -2.717, -1.102, 0.105),
    "loose": (-13.245, -10.265, -8.718, -7.715, -6.956, -5.747, -3.916, -2.495, -1.061),
    "marked": (-12.751, -9.277, -7.272, -6.052, -5.203, -4.18, -2.946, -1.569, -0.433),
}
"""Log odds that the first answer is right, by `Evidence`, without its traits."""

TRAITS: Final = {
    "square corners": (0.1211, 1.0, 0.4216),
    "square dihedral angles": (0.05612, 1.0, 0.4644),
    "equal lengths in a face": (0.0239, 0.6122, -1.619),
    "square classes": (0.1208, 1.0, -1.648),
    "depth against width, squared logarithm": (3.264e-06, 0.1544, -5.119),
    "steepness": (0.1702, 0.3277, 0.2879),
    "axis square to all else": (0.01364, 1.0, 0.4142),
    "faces opposite one another": (0.0, 1.0, 0.7334),
    "frame coverage": (0.3194, 1.0, 0.392),
    "equal angles in a face": (0.2192, 1.0, 1.019),
    "mirror plane": (0.2246, 1.0, -0.007033),
    "further mirror planes": (0.1253, 0.9982, 0.2218),
    "frame coverage, sixth power": (0.001062, 1.0, -0.9913),
    "planarity beyond the noise": (0.0, 0.3404, -3.004),
    "depth residual": (6.351e-15, 1.127, 0.6744),
    "strict classes": (0.0, 1.0, 0.05709),
    "open lines": (0.0, 0.0, 0.0),
    "through-holes": (0.0, 1.0, -0.9286),
    "parts that stand out": (0.0, 1.0, 0.1352),
    "misfit of loose parts": (0.0, 0.7334, -0.5406),
    "parts that hang nowhere": (0.0, 0.0, 0.0),
    "marks of hidden lines": (-18.63, 0.0, 0.07377),
    "logarithm of the number of lines": (2.197, 3.584, 2.229),
    "noise, diagonals": (0.002, 0.03087, 13.56),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
