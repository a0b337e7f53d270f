"""How outlines close: ``python -m tests.plugins.silhouette.ink.figures_closing``.

Hand-drawn ellipses that stop up to a sixteenth early or late; a turn of more than 30° within an
eightieth of the size is a corner that nobody drew; turning is that of the whole ring, over the
one turn of a convex one. Seeds that no test uses.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from tests.plugins.silhouette.ink.hand_drawn import (
    by_a_fast_pen,
    ellipse,
    turning,
    turns,
    with_fold,
    with_folded_end,
)

COUNT = 400
FIRST_SEED = 710_000


Hand = Callable[[np.random.Generator], Array]


def row(ink: str, hand: Hand) -> str:
    """Return a row of the table."""
    sharpest, unrest, refused = [], [], 0
    for seed in range(FIRST_SEED, FIRST_SEED + COUNT):
        try:
            (ring,) = rings_from_strokes([hand(np.random.default_rng(seed))])
        except UserError:
            refused += 1
            continue
        sharpest.append(turns(ring)[0].max())
        unrest.append(turning(ring))
    kinked = np.mean(np.array(sharpest) > 30.0)
    return (
        f"| {ink} | {np.median(sharpest):.1f}° | {100 * kinked:.1f} % "
        f"| {np.median(unrest):.2f} | {refused} |"
    )


def main() -> None:
    """Print the table."""
    print("| Ink | Sharpest turn, median | Corners that nobody drew | Turning | Refused |")
    print("| --- | --- | --- | --- | --- |")
    for tremor in (0.0, 0.3, 1.0, 2.0):
        print(row(f"tremor {tremor:g} px", partial(ellipse, tremor=tremor)))
    print(row("tremor 0.5 px, one fold", lambda r: with_fold(r, ellipse(r, 0.5))))
    for start, place in ((False, "end"), (True, "start")):
        print(row(
            f"tremor 0.3 px, back over itself at its {place}",
            lambda r, start=start: with_folded_end(r, ellipse(r, 0.3), start=start),
        ))  # fmt: skip
    for spacing, jitter in ((3.0, 0.5), (7.0, 1.4), (15.0, 3.0), (24.0, 1.0)):
        print(row(
            f"a sample every {spacing:g} px, off by {jitter:g} px",
            lambda r, s=spacing, j=jitter: by_a_fast_pen(r, ellipse(r, 0.0), s, j),
        ))  # fmt: skip


if __name__ == "__main__":
    main()
