"""Fitting and settling of ink, with SciPy's spline as the alternative."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bozzetto.ink import fit_spline, merge_strokes
from tests.benchmarks.timing import Row, in_turn, median_ms


def wave(count: int, seed: int = 0) -> np.ndarray:
    """A wave of one and a half periods with a pixel of noise."""
    s = np.linspace(0.0, 1.0, count)
    truth = np.column_stack((700.0 * s, 120.0 * np.sin(3.0 * np.pi * s)))
    return truth + np.random.default_rng(seed).normal(0.0, 1.0, truth.shape)


def spiral(stroke: np.ndarray, seed: int) -> np.ndarray:
    """A stroke rolled up, and set aside a little."""
    radius, angle = stroke[:, 0], stroke[:, 0] / 110.0
    aside = np.random.default_rng(seed).normal(0.0, 4.0, 2)
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle))) + aside


def rows() -> Iterator[Row]:
    """Fits at two sampling rates; eight strokes at once."""
    from scipy.interpolate import splprep

    for count in (200, 1000):
        ink = wave(count)
        ours, other = in_turn(
            lambda ink=ink: fit_spline(ink), lambda ink=ink: splprep(ink.T, s=2 * len(ink)),
            repeats=30,
        )  # fmt: skip
        yield Row("ink", f"fit, {count} samples", ours, "ms", "< 5 ms", "splprep, raw ink", other)
    strokes = [wave(200, seed) + np.array([0.0, seed]) for seed in range(8)]
    yield Row(
        "ink", "settle 8 strokes", median_ms(lambda: merge_strokes(strokes)), "ms", "< 100 ms"
    )
    turned = [spiral(stroke, number) for number, stroke in enumerate(strokes)]
    yield Row("ink", "settle 8 spirals", median_ms(lambda: merge_strokes(turned)), "ms", "< 100 ms")
