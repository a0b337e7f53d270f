"""Which place of one side belongs to which of the other: at pen-up, and at every pen event."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bozzetto.ink.resample import resample
from bozzetto_symmetry.live import Growing
from bozzetto_symmetry.pairing import foldings, pairings
from bozzetto_symmetry.stereo import MIRROR, Stereo
from bozzetto_symmetry.warping import first_row, next_row, warpings
from tests.benchmarks.timing import Row, median_ms, processor_ms
from tests.plugins.symmetry.scenes import ACROSS, LOOPS, PAIRS, RINGS, camera, drawn


def rows() -> Iterator[Row]:
    """Pairs, loops, folds and rings whole; one row, and one pen event of a growing side."""
    view = camera(30, 20)
    stereo = Stereo(view)
    curve, loop = PAIRS["S-wave"], LOOPS["wheel"]
    near, far = drawn(curve, view, noise=1.0), drawn(curve * MIRROR, view, noise=1.0, sense=-1)
    one, other = drawn(loop, view), drawn(loop * MIRROR, view)
    across, ring = drawn(ACROSS["wavy bumper"], view, noise=1.0), drawn(RINGS["grille"], view)
    works = {
        "pair at 160 samples, both senses": (lambda: pairings(stereo, near, far), "< 60 ms"),
        "pair of loops": (lambda: pairings(stereo, one, other, closed=True), ""),
        "fold of one stroke": (lambda: foldings(stereo, across), ""),
        "fold of a ring": (lambda: foldings(stereo, ring, closed=True), ""),
    }
    for what, (work, budget) in works.items():
        yield Row("pairing", what, median_ms(work, repeats=15), "ms", budget)
    costs = np.random.default_rng(0).random((2, 160, 160))
    both = median_ms(lambda: warpings(costs, step=0.1, begin=0.1, end=0.1), repeats=15)
    yield Row("pairing", "two warpings 160 × 160", both, "ms")
    row = first_row(costs[:, 0], 0.0)
    each = median_ms(lambda: next_row(row, costs[:, 1], 0.1), repeats=50)
    yield Row("pairing", "live row, both senses", each, "ms", "< 1 ms")
    for gap in (2.0, 20.0):
        ink = resample(far, spacing=gap)

        def grown(ink: np.ndarray = ink) -> None:
            growing = Growing(stereo, near)
            for count in range(1, len(ink) + 1):
                growing.points(ink[:count])

        spent = processor_ms(grown, repeats=5) / len(ink)
        yield Row("pairing", f"live pen event, {gap:g} px apart", spent, "ms", "< 1 ms")
