"""Numbers of the certainty; written by ``python -m tests.plugins.polyhedron.fit_certainty``."""

from __future__ import annotations

from typing import Final

LOG_ODDS: Final = -0.9246
"""Log odds that lines are right, without their traits."""

TRAITS: Final = {
    "cost of other lines": (-1.065, 12.9, 0.03543),
    "crowded corners": (0.0, 5.0, -1.006),
    "closest corners": (0.8226, 4.477, 1.777),
    "closest corner and line": (-2.328, 3.793, 0.2235),
    "logarithm of the number of lines": (1.792, 3.871, 0.8358),
    "noise, diagonals": (0.00188, 0.01222, -309.5),
    "most strained corner": (0.3544, 1.66, -0.5847),
    "not those of solids": (0.0, 1.0, -0.7791),
    "second reading": (0.0, 1.0, -0.6205),
    "other findings": (0.0, 1.0, -5.991),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
