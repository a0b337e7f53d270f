"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

LEADS: Final = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
"""Log odds of the share of the first answer at which `LOG_ODDS` stand."""

LOG_ODDS: Final = {
    "plain": (-13.408, -10.101, -8.384, -6.632, -5.786, -4.973, -3.412, -3.07, -2.035),
    "loose": (-13.449, -10.184, -8.486, -8.265, -6.638, -3.75, -2.089, -0.497, 1.055),
    "marked": (-13.24, -9.765, -7.96, -6.568, -5.502, -4.494, -3.612, -2.501, -1.269),
}
"""Log odds that the first answer is right, by `Evidence`, without its traits."""

TRAITS: Final = {
    "square corners": (0.1242, 1.0, 1.188),
    "square dihedral angles": (0.06284, 1.0, 0.2221),
    "equal lengths in a face": (0.02424, 0.7771, -0.6636),
    "square classes": (0.13, 1.0, -1.646),
    "depth against width, squared logarithm": (1.053e-06, 0.1518, -4.398),
    "steepness": (0.1695, 0.329, 1.374),
    "axis square to all else": (0.05805, 1.0, 0.6908),
    "faces opposite one another": (0.0, 1.0, 0.7759),
    "frame coverage": (0.3274, 1.0, 0.00461),
    "equal angles in a face": (0.2088, 1.0, 2.068),
    "mirror plane": (0.2263, 1.0, -0.6398),
    "further mirror planes": (0.133, 1.0, -0.9356),
    "frame coverage, sixth power": (0.001231, 1.0, -0.4588),
    "planarity beyond the noise": (0.0, 0.2829, -2.116),
    "depth residual": (5.85e-15, 1.096, 0.07046),
    "strict classes": (0.0, 1.0, 0.2014),
    "open lines": (0.0, 0.0, 0.0),
    "through-holes": (0.0, 1.0, -0.6937),
    "parts that stand out": (0.0, 1.0, 0.5529),
    "misfit of loose parts": (0.0, 0.8968, -1.95),
    "parts that hang nowhere": (0.0, 0.0, 0.0),
    "marks of hidden lines": (-18.49, 0.0, 0.04154),
    "logarithm of the number of lines": (2.197, 3.584, 2.144),
    "noise, diagonals": (0.002, 0.03093, 13.78),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
