"""Outlines drawn by hand: ``python -m tests.plugins.silhouette.ink.figures_outlines``.

All outlines of `tests.fidelity`, each by some hands, 620 px along the longest side. Seeds that no
test uses.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.testing import Pen
from bozzetto_silhouette.model.state import Part
from bozzetto_silhouette.outline.from_ink import outline_of
from tests.fidelity import FOLDERS
from tests.plugins.silhouette.ink.hand_drawn import Hand, corners_missed, drawn_after, unrest
from tests.plugins.silhouette.outlines import svg_rings

HANDS = {
    "a pen": Hand(tremor=0.3),
    "a mouse": Hand(grain=1.0),
    "a mouse, trembling": Hand(tremor=1.2, drift=4.0, grain=1.0, miss=14.0),
    "a pen, up to four strokes": Hand(grain=0.5, miss=10.0, strokes=4),
    "a slow pen, 6 to 12 waves a second": Hand(tremor=0.0, waves=0.6, rate=200.0, pace=0.4),
}
TIMES = 3
FIRST_SEED = 9_610_000
SIZE, CORNER = 620.0, (290.0, 140.0)


def outlines() -> dict[str, Array]:
    """Return the largest ring of every outline, px."""
    found = {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.svg"))}
    rings = {}
    for name, path in sorted(found.items()):
        ring = max(svg_rings(path), key=lambda ring: float(np.prod(np.ptp(ring, axis=0))))
        rings[name] = (ring - ring.min(axis=0)) * SIZE / np.ptp(ring, axis=0).max() + CORNER
    return rings


def read(strokes: list[Array]) -> Array:
    """Return the outline that the modeler reads from strokes, px."""
    pen = Pen()
    part = Part(strokes=Strokes(tuple(Stroke(*line.T, pen.camera) for line in strokes)))
    ring = max(outline_of(part).rings, key=len)
    return pen.camera.project(part.sheet.to_world(ring))[0]


def row(words: str, hand: Hand) -> str:
    """Return a row of the table."""
    counts, calm, refused, far = np.zeros(3, int), [], 0, []
    for k, ring in enumerate(outlines().values()):
        for turn in range(TIMES):
            random = np.random.default_rng(FIRST_SEED + TIMES * k + turn)
            meant, strokes = drawn_after(random, ring, hand)
            try:
                found = read(strokes)
            except UserError:
                refused += 1
                continue
            counts += corners_missed(meant, found)
            calm.append(unrest(meant, found))
            away = np.hypot(*(meant[:, None, :][::4] - found[None]).transpose(2, 0, 1))
            far.append(float(away.min(axis=1).max()))
    corners, lost, added = counts
    return (
        f"| {words} | {np.median(calm):.2f} | {np.quantile(calm, 0.95):.2f} | "
        f"{100 * lost / corners:.1f} % | {added} | {np.quantile(far, 0.95):.1f} px | {refused} |"
    )


def main() -> None:
    """Print the table."""
    print(
        "| Drawn by | Turning, median | 95 % | Corners lost | Corners that nobody drew "
        "| Farthest off, 95 % | Refused |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for words, hand in HANDS.items():
        print(row(words, hand), flush=True)


if __name__ == "__main__":
    main()
