"""What of a line drawing is round: rims first, then rounded corners, then loose dashes of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.segments import is_curved
from bozzetto_polyhedron.rounds.bends import Bends
from bozzetto_polyhedron.rounds.ellipses import TURN
from bozzetto_polyhedron.rounds.ink_left import FEWEST, Evidence, InkLeft, is_bowed
from bozzetto_polyhedron.rounds.rims import Rims, tangent_lines
from bozzetto_polyhedron.rounds.round_things import Reading
from bozzetto_polyhedron.rounds.straight_rows import DASH

WIDE: Final = 0.045
"""Distance, in diagonals, within which single dashes belong to what is round."""


def read(strokes: Sequence[Stroke], evidence: Evidence) -> Reading | None:
    """Return what of a drawing is round; None where nothing is."""
    if evidence == "none" or not strokes:
        return None
    paths = [np.asarray(stroke.points, float) for stroke in strokes]
    both = np.concatenate(paths)
    size = float(np.linalg.norm(np.ptp(both, axis=0)))
    if not size > 0.0:
        return None
    curved = {
        number
        for number, stroke in enumerate(strokes)
        if len(paths[number]) >= FEWEST and (is_curved(stroke, size) or _closes(paths[number]))
    }
    if not curved and not any(is_bowed(path, size) for path in paths):
        return None
    ink_left = InkLeft(strokes, paths, size, curved, evidence)
    rims = Rims(ink_left)
    bends = Bends(ink_left)
    swept = _swept(ink_left, rims, bends)
    if not rims.rims and not bends.bends:
        return None
    return Reading(
        tuple(rims.rims),
        tuple(rims.barrels),
        tuple(bends.bends),
        frozenset(swept),
        len(ink_left.straight()) // 2,
        ink_left.light,
        size,
    )


def _closes(path: Array) -> bool:
    """Whether a stroke goes about a place, back to where it began or beyond."""
    spokes = path - path.mean(axis=0)
    angles = np.unwrap(np.arctan2(spokes[:, 1], spokes[:, 0]))
    return bool(abs(angles[-1] - angles[0]) > 0.75 * TURN)


def _swept(ink_left: InkLeft, rims: Rims, bends: Bends) -> set[int]:
    """Take what is left of dashes that lie about what is round, in no straight row."""
    curves = [rim.ellipse.at(np.linspace(0.0, TURN, 73)) for rim in rims.rims]
    for barrel in rims.barrels:
        near, far = (rims.rims[k].ellipse for k in (barrel.near, barrel.far))
        for line in tangent_lines(near, far.center - near.center):
            curves.append(line[0] + np.linspace(-0.1, 1.1, 60)[:, None] * (line[1] - line[0]))
    curves += [bend.arc + shift for bend in bends.bends for shift in (0.0, bend.shift)]
    size, samples = ink_left.size, ink_left.samples
    swept: set[int] = set()
    for curve in curves:
        loose = [
            k
            for k in sorted(ink_left.left)
            if samples.lengths[k] < DASH * size and k not in ink_left.row_of
        ]
        swept |= set(ink_left.take(samples.lying_along(curve, loose, WIDE * size)))
    return swept
