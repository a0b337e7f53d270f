"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

SHARES: Final = (0.0, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.96, 0.99, 1.0)

CONFIDENCES: Final = {
    "plain": (0.089, 0.489, 0.612, 0.724, 0.847, 0.929, 0.976, 0.987, 0.999, 0.999),
    "loose": (0.089, 0.489, 0.612, 0.724, 0.847, 0.929, 0.976, 0.987, 0.999, 0.999),
    "marked": (0.086, 0.335, 0.656, 0.667, 0.667, 0.929, 0.973, 0.992, 0.992, 0.992),
}
