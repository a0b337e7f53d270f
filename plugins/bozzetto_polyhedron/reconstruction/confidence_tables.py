"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

SHARES: Final = (0.0, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.96, 0.99, 1.0)
"""Shares of the first answer at which its probability was measured."""

CONFIDENCES: Final = {
    "plain": (0.075, 0.227, 0.674, 0.72, 0.847, 0.909, 0.976, 0.995, 0.995, 0.995),
    "loose": (0.063, 0.332, 0.384, 0.499, 0.766, 0.992, 0.992, 0.993, 0.993, 0.995),
    "marked": (0.036, 0.262, 0.659, 0.676, 0.892, 0.958, 0.958, 0.976, 0.995, 0.995),
}
"""How often the first answer was right at these shares, by `Evidence`."""
