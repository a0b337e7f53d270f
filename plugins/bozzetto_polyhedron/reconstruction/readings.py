"""Readings of a drawing: shapes in its own units, each with the measures that rank it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.planar_embedding import Ring, components, neighbors_of
from bozzetto_polyhedron.reconstruction.affine_depth import affine_depth
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.flaps import OpenBox, open_box
from bozzetto_polyhedron.reconstruction.hanging_parts import hanging_order
from bozzetto_polyhedron.reconstruction.lifting import Lifting, liftings
from bozzetto_polyhedron.reconstruction.lone_parallels import without_lone_parallels
from bozzetto_polyhedron.reconstruction.loose_loops import Attached, attached, likeliest
from bozzetto_polyhedron.reconstruction.metric_upgrade import metric_maps, squared
from bozzetto_polyhedron.reconstruction.orientation import open_lines
from bozzetto_polyhedron.reconstruction.parallel_classes import (
    LOOSE,
    STRICT,
    ParallelClasses,
    parallel_classes,
)
from bozzetto_polyhedron.reconstruction.ranking import FEATURES, lead_of_shares, scores
from bozzetto_polyhedron.reconstruction.regularity import (
    Relief,
    all_measures,
    relief_of,
)
from bozzetto_polyhedron.reconstruction.visibility import agreement, is_marked

MOST: Final = 8
"""Readings of one lifting."""

OPEN: Final = FEATURES.index("open lines")
"""Column of the share of lines that are not between two faces."""

MOST_LIFTED: Final = 10
"""Liftings of the body that are read, at most: of 120 drawings of solids none has more, scribbles
have up to sixteen."""

MOST_LIFTED_LOOSE: Final = 6
"""The same where a line has a loose end, as in scribbles and in drawings that are not finished."""

MOST_WAYS: Final = 4
"""Ways in which loose parts lie in a body that are solved together with it."""

THROUGH: Final = FEATURES.index("through-holes")
"""Column of the number of through-holes."""

ALIKE: Final = 8.0
"""Mean angle between the lines of two readings, degrees, up to which they are one shape: mostly
both are right then, or neither."""

COMPARED: Final = 3
"""Readings, the best ones, of which it is asked whether they are one shape."""

UPRIGHT: Final = 8.0
"""Standard deviation from upright, degrees, of lines that are upright in space."""

FLAT: Final = 0.03
"""Slope of upright lines in depth, up to which it is a matter of the hand's tremor."""


@dataclass(frozen=True, eq=False)
class Reading:
    """One shape that a drawing may show.

    Parameters
    ----------
    depths : (n,) float64
        Away from the eye, diagonals.
    faces : tuple of Rings
    features : (len(FEATURES),) float64
        Measures that rank it.
    score : float
    by_looks : bool, optional
        Whether it takes depths from a line that looks parallel to another one, which may be
        chance; not given where no depth hangs on that.
    """

    depths: Array
    faces: tuple[Rings, ...]
    features: Array
    score: float
    by_looks: bool | None = None


def readings(
    drawing: Drawing,
    checkpoint: Callable[[float, str], None] = lambda share, step: None,
    *,
    thorough: bool = True,
) -> list[Reading]:
    """Return readings of a drawing, best first, each found once.

    Where hidden lines are marked, a reading and its mirrored one are two; otherwise they are one.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    checkpoint : callable
        Called between the steps with the share done and a name.
    thorough : bool
        Whether lines are also joined strictly to parallel classes, and read once more without
        lone parallels: what comes to compare drawings with one another needs neither.
    """
    box = open_box(drawing)
    if box is not None:
        return _of_open_box(drawing, box, checkpoint)
    neighbors = neighbors_of(drawing.lines)
    parts = components(neighbors)
    parts.sort(key=lambda part: -float(np.linalg.norm(np.ptp(drawing.points[list(part)], axis=0))))
    found: list[Reading] = []
    seen: set[bytes] = set()
    is_loose = bool((np.bincount(drawing.lines.ravel()) == 1).any())
    left = MOST_LIFTED_LOOSE if is_loose else MOST_LIFTED
    for strict, joining in enumerate((LOOSE, STRICT) if thorough else (LOOSE,)):
        classes = parallel_classes(drawing, joining)
        if classes.labels.tobytes() in seen or not parts:
            continue
        seen.add(classes.labels.tobytes())
        lifted = [liftings(drawing, classes, neighbors, part) for part in parts if len(part) > 2]
        first = [each[0] for each in lifted if each] if len(lifted) > 1 else []
        inner = hanging_order(drawing, first)
        for body in _bodies(lifted, inner):
            if left <= 0:
                break
            checkpoint(0.3 + 0.3 * strict, "readings")
            left -= 1
            own = _of_body(drawing, classes, body, inner[1:], strict)
            other = (
                without_lone_parallels(drawing, classes, (body, *inner[1:])) if thorough else None
            )
            if other is not None:
                own = [replace(each, by_looks=True) for each in own]
                left -= 1
                freed = _of_body(drawing, other[0], other[1][0], other[1][1:], strict)
                own += [replace(each, by_looks=False) for each in freed]
            found += own
    return distinct(drawing, sorted(found, key=lambda each: -each.score))


def _bodies(lifted: Sequence[Sequence[Lifting]], inner: Sequence[Lifting]) -> Sequence[Lifting]:
    """Return the ways to lift the part that all others hang at."""
    if not inner:
        return lifted[0] if lifted else ()
    return next(each for each in lifted if each and each[0] is inner[0])


def distinct(drawing: Drawing, ordered: Sequence[Reading]) -> list[Reading]:
    """Return readings without those that repeat a better one.

    Of two that have one shape, the one whose faces leave fewer lines open stays, in the place of
    the better one. A hole and a pocket with a thin floor are two.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size; where its hidden lines are not marked, mirrored ones are alike.
    ordered : sequence of Reading
        The best one first.
    """
    same = 0.02 + 0.25 * drawing.noise
    sides = (1.0,) if is_marked(drawing) else (1.0, -1.0)
    kept: list[Reading] = []
    others = np.zeros((len(ordered), len(drawing.points)))
    for each in ordered:
        depths = each.depths - each.depths.mean()
        near = np.zeros(len(kept), bool)
        for side in sides:
            near |= ((depths - side * others[: len(kept)]) ** 2).mean(1) <= same**2
        holes = np.array([other.features[THROUGH] for other in kept])
        near &= np.abs(holes - each.features[THROUGH]) < 0.5
        alike = np.flatnonzero(near).tolist()
        if not alike:
            others[len(kept)] = depths
            kept.append(each)
        elif each.features[OPEN] < kept[alike[0]].features[OPEN]:
            others[alike[0]] = depths
            kept[alike[0]] = replace(each, score=kept[alike[0]].score)
    return kept


def lead_over_others(drawing: Drawing, found: Sequence[Reading]) -> float:
    """Return the log odds of the first reading and those of its shape against all others.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size; where its hidden lines are not marked, mirrored ones are alike.
    found : sequence of Reading
        At least one, the best first.
    """
    first = found[0]
    sides = (1.0,) if is_marked(drawing) else (1.0, -1.0)
    alike = np.zeros(len(found), bool)
    alike[0] = True
    for number, each in enumerate(found[1:COMPARED], 1):
        if _face_sets(each) == _face_sets(first):
            angles = [_mean_angle(drawing, first.depths, side * each.depths) for side in sides]
            alike[number] = min(angles) < ALIKE
    shares = np.exp([each.score - first.score for each in found])
    return lead_of_shares(float(shares[alike].sum()), float(shares[~alike].sum()))


def _face_sets(reading: Reading) -> frozenset[frozenset[frozenset[int]]]:
    return frozenset(frozenset(frozenset(ring) for ring in face) for face in reading.faces)


def _mean_angle(drawing: Drawing, one: Array, other: Array) -> float:
    """Return the mean angle between lines that are so deep, degrees."""
    first, second = (
        np.column_stack((drawing.spans, depths[drawing.lines[:, 1]] - depths[drawing.lines[:, 0]]))
        for depths in (one, other)
    )
    lengths = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    cosines = (first * second).sum(axis=1) / np.maximum(lengths, 1e-12)
    return float(np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))).mean())


def seen_from_above(drawing: Drawing, reading: Reading) -> Reading:
    """Return a reading, or its mirrored one, so that upright lines lean towards the eye.

    Where these have no depth, as in a box with a flat front, lines recede upwards instead.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    reading : Reading
        On either side.
    """
    spans = drawing.spans * np.sign(drawing.spans[:, 1:] + 1e-12)
    tilts = np.degrees(np.arctan2(spans[:, 0], spans[:, 1]))
    share = np.exp(-0.5 * (tilts / UPRIGHT) ** 2)
    upright = drawing.lengths * share
    rise = reading.depths[drawing.lines[:, 1]] - reading.depths[drawing.lines[:, 0]]
    rise = rise * np.sign(drawing.spans[:, 1] + 1e-12)
    away = float(upright @ rise)
    if abs(away) <= FLAT * float(upright @ drawing.lengths):
        away = -float(((1.0 - share) * spans[:, 1]) @ rise)
    return replace(reading, depths=-reading.depths) if away > 0.0 else reading


def _of_open_box(
    drawing: Drawing, box: OpenBox, checkpoint: Callable[[float, str], None]
) -> list[Reading]:
    """Return readings of a solid with flaps: those of the solid, with the flaps at it."""
    found: list[Reading] = []
    for each in readings(box.solid(drawing), checkpoint):
        depths = box.depths(drawing.points, each.depths)
        faces = box.faces(np.column_stack((drawing.points, depths)), each.faces)
        found += _sides(drawing, depths, faces, each.features[:-1])
    return distinct(drawing, sorted(found, key=lambda each: -each.score))


def _of_body(
    drawing: Drawing,
    classes: ParallelClasses,
    body: Lifting,
    parts: Sequence[Lifting],
    strict: int,
) -> list[Reading]:
    """Return readings of the largest part with all others in it.

    Faces that hold rings of a part tie it to the body: then lines and faces of all tell the depths
    together, and right angles of a pocket those of the body.
    """
    if not parts:
        return _shapes(
            drawing, Attached.alone(body.depth.depths, body.faces, classes), body, strict
        )
    found: list[Reading] = []
    joined: dict[frozenset[frozenset[frozenset[int]]], Attached] = {}
    around: dict[tuple[Ring, Ring], bool] = {}
    relief, maps = _maps(drawing, classes, body)
    for chosen, regular in zip(maps[:MOST], all_measures(relief, maps[:MOST]), strict=True):
        depths = relief.heights(squared(relief, chosen))
        for way in attached(drawing, classes, depths, body.faces, body.corners, parts, around):
            if way.hangs:
                key = frozenset(frozenset(frozenset(ring) for ring in face) for face in way.faces)
                if key not in joined or way.rough < joined[key].rough:
                    joined[key] = way
            else:
                measures = _measures(drawing, body, relief, regular, depths, strict)
                every = np.concatenate((measures, way.measures))
                found += _sides(drawing, way.depths, way.faces, every)
    corners = tuple(sorted({*body.corners, *(c for part in parts for c in part.corners)}))
    for way in likeliest(drawing, list(joined.values()), corners, MOST_WAYS):
        depth = affine_depth(drawing, way.classes, corners, way.faces)
        whole = Lifting(corners, way.faces, depth, unique=False)
        found += _shapes(drawing, way, whole, strict)
    return found


def _shapes(
    drawing: Drawing,
    way: Attached,
    whole: Lifting,
    strict: int,
) -> list[Reading]:
    """Return readings of a lifting that holds all parts."""
    relief, maps = _maps(drawing, way.classes, whole)
    found = []
    for chosen, regular in zip(maps, all_measures(relief, maps), strict=True):
        depths = relief.heights(squared(relief, chosen))
        measures = _measures(drawing, whole, relief, regular, depths, strict)
        every = np.concatenate((measures, way.measured(drawing, depths)))
        found += _sides(drawing, depths, whole.faces, every)
    return found


def _maps(drawing: Drawing, classes: ParallelClasses, body: Lifting) -> tuple[Relief, Array]:
    """Return a lifting as it is compared, and its most regular maps."""
    members = np.isin(drawing.lines[:, 0], body.corners)
    present, labels = np.unique(classes.labels[members], return_inverse=True)
    relief = relief_of(
        drawing.points,
        body.depth.basis,
        drawing.lines[members],
        labels,
        classes.directions[present],
        body.faces,
        drawing.noise,
    )
    return relief, metric_maps(relief, MOST)


def _measures(
    drawing: Drawing, body: Lifting, relief: Relief, regular: Array, depths: Array, strict: int
) -> Array:
    """Return the measures of a map but those of parts and marks; `regular` are its regularities."""
    beyond = max(0.0, _planarity(drawing.points, depths, body.faces) - drawing.noise)
    return np.array(
        (
            *regular,
            beyond / (drawing.noise + 0.01),
            min(5.0, body.depth.residual / (0.05 + 10.0 * drawing.noise)),
            float(strict),
            open_lines(body.faces, relief.lines) / max(1, len(relief.lines)),
        )
    )


def _sides(
    drawing: Drawing, depths: Array, faces: tuple[Rings, ...], measures: Array
) -> list[Reading]:
    """Return a reading, and its mirrored one where marks tell them apart."""
    if not is_marked(drawing):
        return [_reading(depths, faces, np.append(measures, 0.0))]
    marks = agreement(drawing, depths, faces)
    return [
        _reading(side * depths, faces, np.append(measures, each))
        for side, each in zip((1.0, -1.0), marks, strict=True)
    ]


def _reading(depths: Array, faces: tuple[Rings, ...], features: Array) -> Reading:
    return Reading(depths, faces, features, float(scores(features)))


def _planarity(points: Array, depths: Array, faces: Sequence[Rings]) -> float:
    """Largest root mean square distance of the corners of a face from a plane, diagonals."""
    space = np.column_stack((points, depths))
    worst = 0.0
    for face in faces:
        corners = space[[corner for ring in face for corner in ring]]
        if len(corners) > 3:
            values = np.linalg.svd(corners - corners.mean(0), compute_uv=False)
            worst = max(worst, float(values[-1]) / len(corners) ** 0.5)
    return worst
