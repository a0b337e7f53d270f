"""Hidden lines that were not drawn, guessed from the visible ones.

Three guesses: a face that is wholly visible is one end of a prism, whose other end is the same
ring moved along its sides; the hidden half is the visible one turned by a half turn about a point;
or it is the visible one mirrored in a plane (`mirror_images`). All hold in the picture of a
parallel view as they do in space; drawings in perspective are made parallel first
(`perspective`). Lengths are shares of the diagonal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.view import Camera
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.hidden_corners import Whole, with_hidden_corners
from bozzetto_polyhedron.reconstruction.mirror_images import mirror_images
from bozzetto_polyhedron.reconstruction.outline import Outline, outline_of
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.perspective import ParallelView, parallel_view
from bozzetto_polyhedron.reconstruction.soundness import seen_otherwise
from bozzetto_polyhedron.reconstruction.visible_regions import (
    Junctions,
    holes_in,
    junctions_of,
    regions_of,
    with_passing_lines,
)

NEAR: Final = 0.03
"""Distance within which a guessed corner is one that was drawn, beyond thrice the noise."""

UNEXPLAINED: Final = 0.12
"""Share of what was drawn that a guess may leave unexplained."""

OTHERWISE: Final = 0.1
"""Share of all lines up to which guesses that show them otherwise come before others."""

MOST_OTHERWISE: Final = 0.15
"""Share of all lines that a guess shows otherwise at most: where the hand trembles, short ones."""

LEAST_SHARE: Final = 0.05
"""Share of the way to a vanishing point below which sides are parallel."""

LEAST_HIDDEN: Final = 0.01
"""Share of a line that is hidden at least where it goes behind others."""

FEWEST: Final = 3
"""Corners of the least ring."""

ALONG: Final = np.radians(5.0)
"""Angle up to which a line of a guess runs along an axis, or two lines are parallel."""

FLAT: Final = 0.15
"""Least part of an axis on the sheet by which it tells depths."""

SAME: Final = 1e-9
"""Distance, diagonals, below which a guessed corner is a drawn one."""

HELD: Final = 10.0
"""Weight of depths of drawn corners."""

SLACK: Final = 1e-3
"""Weight of depths and slopes that nothing tells, which are 0."""


@dataclass(frozen=True, eq=False)
class HiddenLines:
    """One guess.

    Parameters
    ----------
    ends : (k, 2, 2) float64
        Lines to draw lightly, canvas pixels.
    unexplained : float
        Share of what was drawn that is no part of the guessed solid.
    """

    ends: Array
    unexplained: float
    traits: Array | None = None


def hidden_lines(graph: LineGraph, camera: Camera, most: int = 3) -> tuple[HiddenLines, ...]:
    """Guess the lines that are hidden, the guess that explains most of the drawing first.

    Mirror images come after all others; the best one has the last place at least. Where the lines
    meet in the distance, they are straightened first, and so are guesses that come before those
    without perspective.

    Parameters
    ----------
    graph : LineGraph
        Of the visible lines; a line that goes behind a face ends on an edge of it.
    camera : Camera
        Through which it was drawn.
    most : int
        Largest number of guesses.

    Returns
    -------
    tuple of HiddenLines
        Different ones; empty where nothing fits, or nothing is missing.
    """
    drawing = drawing_of(graph)
    degrees = np.bincount(drawing.lines.ravel(), minlength=len(drawing.points))
    if len(drawing.lines) < FEWEST or (degrees >= 3).all():
        return ()
    drawing = with_passing_lines(drawing)
    junctions = junctions_of(drawing, (NEAR + 3.0 * drawing.noise) / 2.0)
    faces = [
        (ring, *holes_in(drawing, junctions, ring))
        for ring in regions_of(drawing, junctions)
        if len(ring) > FEWEST and not junctions.is_stem[list(ring)].any()
    ]
    view = parallel_view(drawing, camera, faces)
    found = _guessed(view, junctions, faces, most) if view.perspective > 0.0 else []
    plain = ParallelView(
        drawing, drawing.points, np.zeros(2), 0.0, np.zeros(len(drawing.points)), certain=False
    )
    return tuple(_different(found + _guessed(plain, junctions, faces, most), drawing)[:most])


def _different(found: Sequence[HiddenLines], drawing: Drawing) -> list[HiddenLines]:
    """Return guesses without those that repeat the lines of an earlier one."""
    near = NEAR * drawing.diagonal
    kept: list[HiddenLines] = []
    for each in found:
        middles = each.ends.mean(1)
        repeats = (
            len(other.ends) == len(each.ends)
            and np.linalg.norm(middles[:, None] - other.ends.mean(1), axis=2).min(1).max() < near
            for other in kept
        )
        if not any(repeats):
            kept.append(each)
    return kept


def _guessed(
    view: ParallelView, junctions: Junctions, faces: Sequence[Rings], most: int
) -> list[HiddenLines]:
    """Return what may be hidden of a drawing without perspective, as it was drawn."""
    drawing = view.drawing
    reach = NEAR + 3.0 * drawing.noise
    outline = outline_of(drawing, reach)
    # Much of a prism is a mirror image of something: mirrors are asked where the others end.
    wholes = [
        *((0, 0, whole) for whole in _extruded(drawing, junctions, reach)),
        *((0, 1, whole) for whole in _turned(drawing, junctions, reach)),
        *(
            (1, 2, whole)
            for whole in with_hidden_corners(drawing, junctions, faces, outline, reach)
        ),
        *((2, 3, whole) for whole in _mirrored(drawing, junctions, reach)),
    ]
    found: list[tuple[bool, float, bool, int, int, HiddenLines]] = []
    seen: list[Whole] = []
    for way, kind, whole in wholes:
        hidden, unexplained = _compared(drawing, junctions, whole, reach)
        missing = hidden > 0.0
        if unexplained > UNEXPLAINED or not missing.any() or _is_known(whole, seen, reach):
            continue
        if not _is_within(whole.points[whole.lines[missing]], outline):
            continue
        seen.append(whole)
        misfit = seen_otherwise(drawing, whole.points, whole.lines, hidden)
        if misfit is not None and misfit > MOST_OTHERWISE:
            continue
        unsure = misfit is None or misfit > OTHERWISE
        places = view.as_drawn(whole.points, _depths(view, whole))
        places = (places * (1.0, -1.0)) * drawing.diagonal + drawing.center
        guess = HiddenLines(places[whole.lines[missing]], unexplained)
        rank = (way == 2, round(unexplained, 3), unsure, way, int(missing.sum()))
        guess = HiddenLines(
            guess.ends,
            unexplained,
            _traits(drawing, junctions, whole, hidden, unexplained, misfit, kind),
        )
        found.append((*rank, guess))
    found.sort(key=lambda each: each[:-1])
    others = sum(not each[0] for each in found)
    if others < len(found):
        del found[max(1, most - 1) : others]
    return [each[-1] for each in found[:most]]


def _traits(drawing, junctions, whole, hidden, unexplained, misfit, kind):
    away = np.linalg.norm(whole.points[:, None] - drawing.points, axis=2)
    new = away.min(1) > SAME
    lengths = np.linalg.norm(
        whole.points[whole.lines[:, 0]] - whole.points[whole.lines[:, 1]], axis=1
    )
    classes = parallel_classes(drawing)
    spans = whole.points[whole.lines[:, 1]] - whole.points[whole.lines[:, 0]]
    unit = spans / np.maximum(np.linalg.norm(spans, axis=1), 1e-9)[:, None]
    sines = np.abs(
        unit[:, :1] * classes.directions[:, 1] - unit[:, 1:] * classes.directions[:, 0]
    ).min(1)
    missing = hidden > 0.0
    wholly = hidden == 1.0
    odd = float((lengths * (sines > 0.1))[missing].sum() / max(lengths[missing].sum(), 1e-9))
    degrees = np.bincount(whole.lines.ravel(), minlength=len(whole.points))
    stems = int(junctions.is_stem.sum())
    met = _compared_stems(drawing, junctions, whole)
    return np.array(
        [
            kind,
            unexplained,
            -1.0 if misfit is None else misfit,
            new.sum(),
            missing.sum(),
            wholly.sum(),
            len(drawing.lines),
            stems,
            drawing.noise,
            odd,
            (degrees > 3).sum(),
            len(whole.points),
            float(lengths[missing].min()),
            float(hidden @ lengths / lengths.sum()),
            met,
        ]
    )


def _compared_stems(drawing, junctions, whole):
    """Root mean square distance of lines that go behind from the lines of the whole."""
    stems = np.flatnonzero(junctions.is_stem)
    if not len(stems):
        return 0.0
    starts, stops = whole.points[whole.lines[:, 0]], whole.points[whole.lines[:, 1]]
    steps = stops - starts
    places = drawing.points[stems]
    at = np.clip(
        ((places[:, None] - starts) * steps).sum(2) / np.maximum((steps**2).sum(1), 1e-12), 0, 1
    )
    away = np.linalg.norm(places[:, None] - starts - at[..., None] * steps, axis=2).min(1)
    return float(np.sqrt((away**2).mean()))


def _is_within(ends: Array, outline: Outline) -> bool:
    """Whether hidden lines, (k, 2, 2), are behind what was drawn."""
    share = np.linspace(0.0, 1.0, 9)[:, None]
    places = ends[:, None, 0] + share * (ends[:, None, 1] - ends[:, None, 0])
    return bool(outline.cover(places.reshape(-1, 2)).all())


def _depths(view: ParallelView, whole: Whole) -> Array:
    """Return depths of the corners of a whole, (n,): those drawn keep theirs.

    A line rises with its length by the slope of its class; lines along an axis by that of the axis.
    """
    count = len(whole.points)
    if view.perspective == 0.0 or view.axes is None:
        return np.zeros(count)
    ends = whole.points[whole.lines]
    spans = ends[:, 1] - ends[:, 0]
    lengths = np.maximum(np.linalg.norm(spans, axis=1), 1e-9)
    axes = view.axes[np.linalg.norm(view.axes[:, :2], axis=1) > FLAT]
    seen = axes[:, :2] / np.linalg.norm(axes[:, :2], axis=1)[:, None]
    along = spans @ seen.T
    turned = np.arccos(np.clip(np.abs(along) / lengths[:, None], 0.0, 1.0))
    axis = turned.argmin(1)
    labels = np.where(turned.min(1) < ALONG, axis, -1)
    free = np.flatnonzero(labels < 0)
    classes = _classes_of(spans[free])
    names = int(classes.max(initial=-1)) + 1
    rows = np.zeros((len(spans), count + names))
    number = np.arange(len(spans))
    rows[number, whole.lines[:, 1]] += 1.0
    rows[number, whole.lines[:, 0]] -= 1.0
    slopes = axes[:, 2] / np.linalg.norm(axes[:, :2], axis=1)
    values = np.where(labels >= 0, along[number, axis] * slopes[axis], 0.0)
    signed = np.where(spans[:, 0] + 1e-6 * spans[:, 1] < 0.0, -lengths, lengths)
    rows[free, count + classes] = -signed[free]
    away = np.linalg.norm(whole.points[:, None] - view.drawing.points, axis=2)
    nearest = away.argmin(1)
    drawn = np.flatnonzero(away.min(1) < SAME)
    held = np.zeros((len(drawn), count + names))
    held[np.arange(len(drawn)), drawn] = HELD
    weak = SLACK * np.eye(count + names)
    matrix = np.vstack((rows, held, weak))
    right = np.concatenate((values, HELD * view.depths[nearest[drawn]], np.zeros(count + names)))
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0][:count])


def _classes_of(spans: Array) -> Index:
    """Return numbers of directions that lines of a parallel drawing share, (m,)."""
    angles = np.arctan2(spans[:, 1], spans[:, 0]) % np.pi
    labels = np.full(len(spans), -1, np.intp)
    for number in range(len(spans)):
        off = np.abs((angles - angles[number] + np.pi / 2.0) % np.pi - np.pi / 2.0)
        if labels[number] < 0:
            labels[(labels < 0) & (off < ALONG)] = labels.max(initial=-1) + 1
    return labels


def _extruded(drawing: Drawing, junctions: Junctions, reach: float) -> list[Whole]:
    """Return prisms over every visible ring, along every direction of lines that leave it."""
    labels = parallel_classes(drawing).labels
    everything = np.arange(len(labels))
    found = []
    for ring in regions_of(drawing, junctions):
        if len(ring) < FEWEST:
            continue
        shrunk = _shrunk(drawing, ring, *_steps(drawing, junctions, ring, everything), reach)
        found += [_prism(drawing, ring, far, reach) for far in shrunk]
        for name in np.unique(labels).tolist():
            _, steps = _steps(drawing, junctions, ring, np.flatnonzero(labels == name))
            for step in _distinct(steps, reach):
                found.append(_prism(drawing, ring, drawing.points[list(ring)] + step, reach))
                holes = holes_in(drawing, junctions, ring)
                if holes:
                    found.append(_with_holes(drawing, found[-1], holes, step, reach))
    return found


def _with_holes(
    drawing: Drawing, whole: Whole, holes: Sequence[Ring], step: Array, reach: float
) -> Whole:
    """Return a prism with holes that go through it as far as its sides."""
    points, lines = [whole.points], [whole.lines]
    for ring in holes:
        hole = _prism(drawing, ring, drawing.points[list(ring)] + step, reach)
        lines.append(hole.lines + sum(len(each) for each in points))
        points.append(hole.points)
    return Whole(np.concatenate(points), np.concatenate(lines))


def _steps(
    drawing: Drawing, junctions: Junctions, ring: Sequence[int], sides: Index
) -> tuple[Array, Array]:
    """Return where sides leave a ring, and the ways to corners of their own, both (k, 2)."""
    inside = set(ring)
    nears, made = [], []
    for first, second in drawing.lines[sides].tolist():
        if (first in inside) == (second in inside):
            continue
        near, far = (first, second) if first in inside else (second, first)
        if not junctions.is_stem[far]:
            nears.append(drawing.points[near])
            made.append(drawing.points[far] - drawing.points[near])
    return np.array(nears).reshape(-1, 2), np.array(made).reshape(-1, 2)


def _shrunk(
    drawing: Drawing, ring: Sequence[int], nears: Array, steps: Array, reach: float
) -> list[Array]:
    """Return the far end of a prism in perspective: the ring drawn towards a vanishing point.

    Two sides or more tell the point and the share of the way, way = share (point - near).
    """
    if len(nears) < 2:
        return []
    middle = nears - nears.mean(0)
    square = float((middle**2).sum())
    if square < reach**2:
        return []
    share = -float((middle * steps).sum()) / square
    ways = steps.mean(0) - share * (drawing.points[list(ring)] - nears.mean(0))
    misfit = steps - steps.mean(0) + share * middle
    if not LEAST_SHARE < abs(share) < 1.0 or np.linalg.norm(misfit, axis=1).max() > reach:
        return []
    return [drawing.points[list(ring)] + ways]


def _distinct(steps: Array, reach: float) -> list[Array]:
    """Return the mean of all ways, and each one that is far from it."""
    if not len(steps):
        return []
    mean = np.median(steps, axis=0)
    far = steps[np.linalg.norm(steps - mean, axis=1) > reach]
    return [mean, *far]


def _prism(drawing: Drawing, ring: Sequence[int], far: Array, reach: float) -> Whole:
    """Return the prism between a ring and its far end, (n, 2)."""
    count = len(ring)
    near = drawing.points[list(ring)]
    points = np.concatenate((near, _snapped(far, drawing.points, reach)))
    here = np.arange(count)
    following = np.roll(here, -1)
    lines = np.concatenate(
        (
            np.column_stack((here, following)),
            np.column_stack((here, following)) + count,
            np.column_stack((here, here + count)),
        )
    )
    return Whole(points, lines)


def _turned(drawing: Drawing, junctions: Junctions, reach: float) -> list[Whole]:
    """Return what was drawn with its image by a half turn, about middles of pairs of corners."""
    points, lines, _ = _without_stems(drawing, junctions)
    first, second = np.triu_indices(len(points), 1)
    middles = (points[first] + points[second]) / 2.0
    turned = (
        _with_images(points, lines, 2.0 * middle - points, reach)
        for middle in middles[_most_common(middles, reach)]
    )
    return [whole for whole in turned if whole is not None]


def _mirrored(drawing: Drawing, junctions: Junctions, reach: float) -> list[Whole]:
    """Return what was drawn with its mirror image, across the lines of each class."""
    points, lines, kept = _without_stems(drawing, junctions)
    labels = parallel_classes(drawing).labels[kept]
    mirrored = (
        _with_images(points, lines, images, reach, across=True)
        for images in mirror_images(points, lines, labels, reach)
    )
    return [whole for whole in mirrored if whole is not None]


def _without_stems(drawing: Drawing, junctions: Junctions) -> tuple[Array, Index, Flags]:
    """Return corners and lines between them without those that go behind, and which lines stay."""
    kept = np.asarray(~junctions.is_stem[drawing.lines].any(1))
    corners, numbers = np.unique(drawing.lines[kept], return_inverse=True)
    return drawing.points[corners], numbers.reshape(-1, 2).astype(np.intp), kept


def _with_images(
    points: Array, lines: Index, images: Array, reach: float, *, across: bool = False
) -> Whole | None:
    """Return corners and lines with their images; None where a corner has too few lines.

    Lines `across` join corners to their images where both have one line too few.
    """
    if not len(points):
        return None
    away = np.linalg.norm(images[:, None] - points, axis=2)
    nearest = away.argmin(1)
    own = away[np.arange(len(points)), nearest] < reach
    fresh = np.cumsum(~own) - 1 + len(points)
    numbers = np.where(own, nearest, fresh)
    pairs = np.sort(np.concatenate((lines, numbers[lines])), axis=1)
    pairs = np.unique(pairs, axis=0)
    corners = np.concatenate((points, images[~own]))
    degrees = np.bincount(pairs.ravel(), minlength=len(corners))
    if across:
        joins = np.sort(np.column_stack((np.arange(len(points)), numbers)), axis=1)
        joins = joins[(joins[:, 0] != joins[:, 1]) & (degrees[joins] == 2).all(axis=1)]
        pairs = np.unique(np.concatenate((pairs, joins)), axis=0)
        degrees = np.bincount(pairs.ravel(), minlength=len(corners))
    return Whole(corners, pairs) if (degrees >= 3).all() else None


def _most_common(places: Array, reach: float, most: int = 6) -> Index:
    """Return places with the most others close by, each far from those before."""
    close = np.linalg.norm(places[:, None] - places, axis=2) < reach
    order = np.argsort(-close.sum(1), kind="stable")
    taken: list[int] = []
    for number in order.tolist():
        if not any(close[number, other] for other in taken):
            taken.append(number)
        if len(taken) == most:
            break
    return np.array(taken, np.intp)


def _snapped(guessed: Array, drawn: Array, reach: float) -> Array:
    """Put guessed corners on drawn ones that are close."""
    away = np.linalg.norm(guessed[:, None] - drawn, axis=2)
    nearest = away.argmin(1)
    close = away[np.arange(len(guessed)), nearest] < reach
    return np.where(close[:, None], drawn[nearest], guessed)


def _compared(
    drawing: Drawing, junctions: Junctions, whole: Whole, reach: float
) -> tuple[Array, float]:
    """Return the share of each line of a whole that was not drawn, (k,), and of ink beside it.

    A line that was drawn from end to end has the share 0 however it was drawn, and others more.
    """
    starts, stops = whole.points[whole.lines[:, 0]], whole.points[whole.lines[:, 1]]
    ends = drawing.points[drawing.lines]
    stems = junctions.is_stem[drawing.lines]
    first = _at_ends(ends[:, 0], stems[:, 0], starts, stops, reach)
    second = _at_ends(ends[:, 1], stems[:, 1], starts, stops, reach)
    fit: Flags = first & second
    long = np.linalg.norm(stops - starts, axis=1) > reach
    explained = (fit & long).any(1)
    lengths = drawing.lengths
    whole_lines = ~(stems[:, 0] | stems[:, 1])
    complete = fit & whole_lines[:, None]
    drawn = ((fit & long) * lengths[:, None]).sum(0) / np.maximum(
        np.linalg.norm(stops - starts, axis=1), 1e-12
    )
    hidden = np.where(long & ~complete.any(0), np.clip(1.0 - drawn, LEAST_HIDDEN, 1.0), 0.0)
    return hidden, float(lengths[~explained].sum() / max(lengths.sum(), 1e-12))


def _at_ends(places: Array, loose: Flags, starts: Array, stops: Array, reach: float) -> Flags:
    """Whether places (m, 2) are at an end of stretches (k, 2), or on them where loose, (m, k)."""
    to_start = np.linalg.norm(places[:, None] - starts, axis=2)
    to_stop = np.linalg.norm(places[:, None] - stops, axis=2)
    steps = stops - starts
    square = np.maximum((steps**2).sum(1), 1e-12)
    at = np.clip(((places[:, None] - starts) * steps).sum(2) / square, 0.0, 1.0)
    away = np.linalg.norm(places[:, None] - starts - at[..., None] * steps, axis=2)
    made: Flags = (np.minimum(to_start, to_stop) < reach) | (loose[:, None] & (away < reach))
    return made


def _is_known(whole: Whole, seen: Sequence[Whole], reach: float) -> bool:
    """Whether a guess has the corners of one before."""
    for other in seen:
        if len(other.points) == len(whole.points):
            away = np.linalg.norm(whole.points[:, None] - other.points, axis=2)
            if away.min(1).max() < reach and away.min(0).max() < reach:
                return True
    return False
