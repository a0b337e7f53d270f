"""Whether what a process holds stays as it is."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["has_grown", "spread"]


def spread(figures: Sequence[float]) -> float:
    """Largest distance from the mean, as a share of it."""
    mean = sum(figures) / len(figures)
    return max(abs(each - mean) for each in figures) / mean


def has_grown(figures: Sequence[float]) -> bool:
    """Whether the later half lies wholly above the earlier half; never for fewer than four."""
    half = len(figures) // 2
    return half > 1 and min(figures[half:]) > max(figures[:half])
