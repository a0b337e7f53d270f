"""Numbers of the certainty; written by ``python -m tests.plugins.polyhedron.fit_certainty``."""

from __future__ import annotations

from typing import Final

LOG_ODDS: Final = 20.0
"""Log odds that lines are right, without their traits."""

TRAITS: Final = {
    "cost of other lines": (0.0, 0.0, 0.0),
    "crowded corners": (0.0, 0.0, 0.0),
    "closest corners": (0.0, 0.0, 0.0),
    "closest corner and line": (0.0, 0.0, 0.0),
    "logarithm of the number of lines": (0.0, 0.0, 0.0),
    "noise, diagonals": (0.0, 0.0, 0.0),
    "most strained corner": (0.0, 0.0, 0.0),
    "not those of solids": (0.0, 0.0, 0.0),
    "second reading": (0.0, 0.0, 0.0),
    "other findings": (0.0, 0.0, 0.0),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
