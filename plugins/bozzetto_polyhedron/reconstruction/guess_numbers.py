"""Numbers of guesses; written by ``python -m tests.plugins.polyhedron.fit_guesses``."""

from __future__ import annotations

from typing import Final

LOG_ODDS: Final = 2.991
"""Log odds that a guess is right, without its traits."""

TRAITS: Final = {
    "unexplained ink": (0.0, 0.05911, -42.47),
    "lines seen otherwise": (0.0, 0.1482, -13.04),
    "not told what is seen": (0.0, 1.0, 1.236),
    "logarithm of the number of guessed lines": (0.0, 2.9, -0.1425),
    "logarithm of the number of visible lines": (1.792, 3.332, 0.2705),
    "noise, diagonals": (0.003833, 0.01257, -22.91),
    "lines of no drawn direction": (0.0, 1.0, -1.754),
    "crowded corners": (0.0, 6.17, -0.2096),
    "closest corners": (1.176, 4.154, -0.3538),
    "shortest guessed line": (-3.058, -0.384, 0.4715),
    "among other guesses": (0.0, 1.0, -0.8604),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
