"""What tells how likely guessed hidden lines are those that were meant."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.certainty import closest_corners, closest_to_lines
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.hidden_corners import Whole
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.visible_regions import Junctions

TURNED = np.sin(np.radians(6.0))


def guess_traits(drawing, junctions, whole, hidden, unexplained, misfit, kind, loose):
    away = np.linalg.norm(whole.points[:, None] - drawing.points, axis=2).min(1)
    spans = whole.points[whole.lines[:, 1]] - whole.points[whole.lines[:, 0]]
    lengths = np.linalg.norm(spans, axis=1)
    unit = spans / np.maximum(lengths, 1e-9)[:, None]
    directions = parallel_classes(drawing).directions
    sines = np.abs(unit[:, :1] * directions[:, 1] - unit[:, 1:] * directions[:, 0]).min(1)
    missing = hidden > 0.0
    odd = float(lengths[missing & (sines > TURNED)].sum() / lengths[missing].sum())
    degrees = np.bincount(whole.lines.ravel(), minlength=len(whole.points))
    return np.array(
        (
            kind == 0, kind == 1, kind == 2, kind == 3,
            float(loose),
            unexplained,
            0.0 if misfit is None else misfit,
            np.log1p((away > 1e-9).sum()),
            np.log(missing.sum()),
            np.log(len(drawing.lines)),
            np.log1p(junctions.is_stem.sum()),
            drawing.noise,
            odd,
            float((degrees > 3).sum()),
            float(hidden @ lengths / lengths.sum()),
            np.log(closest_corners(drawing.points) / drawing.noise),
            np.log(closest_to_lines(drawing.points, drawing.lines) / drawing.noise),
            np.log(max(1e-3, float(lengths[missing].min()))),
            float(misfit is None),
        ), float
    )
