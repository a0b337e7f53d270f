"""How outlines close: ``python -m tests.plugins.silhouette.ink.figures_closing``.

Hand-drawn ellipses that stop up to a sixteenth early or late; a turn of more than 30° within an
eightieth of the size is a corner that nobody drew. Seeds that no test uses.
"""

from __future__ import annotations

import numpy as np

from bozzetto.errors import UserError
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from tests.plugins.silhouette.ink.hand_drawn import ellipse, turns, with_fold

COUNT = 400
FIRST_SEED = 710_000


def row(tremor: float, *, folded: bool) -> str:
    """Return a row of the table."""
    sharpest, refused = [], 0
    for seed in range(FIRST_SEED, FIRST_SEED + COUNT):
        random = np.random.default_rng(seed)
        line = ellipse(random, tremor)
        try:
            (ring,) = rings_from_strokes([with_fold(random, line) if folded else line])
        except UserError:
            refused += 1
            continue
        sharpest.append(turns(ring)[0].max())
    kinked = np.mean(np.array(sharpest) > 30.0)
    ink = f"{tremor:g} px" + (", one fold" if folded else "")
    return f"| {ink} | {np.median(sharpest):.1f}° | {100 * kinked:.1f} % | {refused} |"


def main() -> None:
    """Print the table."""
    print("| Tremor | Sharpest turn, median | Corners that nobody drew | Refused |")
    print("| --- | --- | --- | --- |")
    for tremor in (0.0, 0.3, 1.0, 2.0):
        print(row(tremor, folded=False))
    print(row(0.5, folded=True))


if __name__ == "__main__":
    main()
