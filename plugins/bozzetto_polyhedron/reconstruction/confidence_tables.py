"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

SHARES: Final = (0.0, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.96, 0.99, 1.0)
"""Shares of the first answer at which its probability was measured."""

CONFIDENCES: Final = {
    "plain": (0.02, 0.242, 0.672, 0.718, 0.86, 0.918, 0.967, 0.995, 0.995, 0.995),
    "loose": (0.047, 0.344, 0.415, 0.486, 0.756, 0.995, 0.995, 0.995, 0.995, 0.995),
    "marked": (0.025, 0.274, 0.613, 0.682, 0.808, 0.94, 0.961, 0.983, 0.99, 0.995),
}
"""How often the first answer was right at these shares, by `Evidence`."""
