"""Fit the tables that turn the share of the first reading into how likely it is the right one.

``python -m tests.plugins.polyhedron.fit_confidence [drawings]`` draws random solids with seeds from
30,000 on, to which nothing else is fitted, reads them as the program does, and writes
``confidence_tables.py``.

The drawings: a sixth each of upright solids, of slanted ones twice, and of blocks with a pocket, a
boss or a tunnel, all with lines alike; of such blocks, and of upright and slanted solids together,
with hidden lines drawn lightly, 10 % of them wrongly. A corner is off by 0, 0.5, 1 or 2 % of the
diagonal (standard deviation), a quarter each; the program is told that noise wrong by a factor of
1.28. A reading is right if its shape is (``objects.is_right``) and it has the faces of the solid.

Between the knots the tables are straight; among all that never fall, the one with the least squared
error (Brier 1950) is taken. A hat of `PRIOR` drawings at each knot pulls it to the share itself.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import lsq_linear

import bozzetto_polyhedron.reconstruction.confidence_tables as written
from bozzetto_polyhedron.reconstruction.answers import evidence_of, ranked_readings
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from tests.plugins.polyhedron.fit_ranking import NOISES, softmax
from tests.plugins.polyhedron.objects import CAMERA, graph_of, is_right, made, view

FIRST_SEED = 30_000
UPRIGHT = ("rectilinear prism", "stairs", "letter prism", "boxes", "notched box")
SLANTED = ("slanted prism", "slanted step", "tapered", "chamfered")
LOOPED = ("looped",)
KINDS = (
    (UPRIGHT, None),
    (SLANTED, None),
    (LOOPED, 0.1),
    (UPRIGHT + SLANTED, 0.1),
    (SLANTED, None),
    (LOOPED, None),
)
"""Solids, and the share of wrong marks of hidden lines; none where all lines are alike."""

SHARES = (0.0, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.96, 0.99, 1.0)
EVIDENCE = ("plain", "loose", "marked")
PRIOR = 4.0
LEAST, MOST = 0.02, 0.995
"""Nothing is said to be surer or less sure than so."""

HEADER = '''\
"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

'''


@dataclass(frozen=True)
class Outcome:
    """The first reading of one drawing: its share among all, and whether it is right."""

    evidence: str
    share: float
    right: bool


def outcome(seed: int) -> Outcome | None:
    """Draw a solid and judge the first reading; None where there is no view or no reading."""
    kinds, marks = KINDS[seed % len(KINDS)]
    noise = NOISES[seed // len(KINDS) % len(NOISES)]
    solid = made(seed, kinds)
    seen = view(solid, seed)
    if seen is None:
        return None
    graph, _ = graph_of(seen, noise, seed, marks)
    drawing = drawing_of(graph)
    sight, found = ranked_readings(drawing, CAMERA)
    if not found:
        return None
    first = found[0]
    shape = is_right(seen, np.column_stack((sight.drawing.points, first.depths)), noise)
    faces = {frozenset(frozenset(ring) for ring in face) for face in first.faces}
    shares = softmax(np.array([each.score for each in found]))
    right = shape and faces == solid.face_sets()
    return Outcome(evidence_of(drawing), float(shares[0]), right)


def table(shares: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return how often the first reading is right at each of `SHARES`, never falling."""
    knots = np.array(SHARES)
    hats = np.array([np.interp(shares, knots, row) for row in np.eye(len(knots))]).T
    rows = np.vstack((hats, np.sqrt(PRIOR) * np.eye(len(knots))))
    wanted = np.concatenate((right, np.sqrt(PRIOR) * knots))
    rising = np.tril(np.ones((len(knots), len(knots))))
    steps = lsq_linear(rows @ rising, wanted, bounds=(0.0, 1.0)).x
    return np.clip(rising @ steps, LEAST, MOST)


def main(count: int) -> None:
    seeds = range(FIRST_SEED, FIRST_SEED + count)
    every = [each for seed in seeds if (each := outcome(seed)) is not None]
    lines = [
        f"SHARES: Final = {SHARES}",
        '"""Shares of the first answer at which its probability was measured."""\n',
        "CONFIDENCES: Final = {",
    ]
    for name in EVIDENCE:
        some = [each for each in every if each.evidence == name]
        rates = table(
            np.array([each.share for each in some]),
            np.array([each.right for each in some], float),
        )
        lines.append(f'    "{name}": {tuple(round(float(rate), 3) for rate in rates)},')
        print(f"{name}: {len(some)} drawings")
    lines += ["}", '"""How often the first answer was right at these shares, by `Evidence`."""\n']
    Path(written.__file__).write_text(HEADER + "\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 12_000)
