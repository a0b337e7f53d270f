"""Numbers of guesses; written by ``python -m tests.plugins.polyhedron.fit_guesses``."""

from __future__ import annotations

from typing import Final

LOG_ODDS: Final = 2.319
"""Log odds that a guess is right, without its traits."""

TRAITS: Final = {
    "unexplained ink": (0.0, 0.1002, -26.58),
    "lines seen otherwise": (0.0, 0.1486, -13.6),
    "not told what is seen": (0.0, 1.0, 1.568),
    "logarithm of the number of guessed lines": (0.0, 2.944, -0.2259),
    "logarithm of the number of visible lines": (1.792, 3.332, 0.7241),
    "noise, diagonals": (0.003841, 0.01316, -37.55),
    "lines of no drawn direction": (0.0, 1.0, -1.265),
    "crowded corners": (0.0, 6.0, -0.2764),
    "closest corners": (1.115, 4.231, -0.3555),
    "shortest guessed line": (-3.025, -0.3818, 0.691),
    "among other guesses": (0.0, 1.0, -0.9644),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
