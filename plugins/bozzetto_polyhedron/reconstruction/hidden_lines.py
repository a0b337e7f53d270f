"""Hidden lines that were not drawn, guessed from the visible ones.

Three guesses: a face that is wholly visible is one end of a prism, whose other end is the same
ring moved along its sides; the hidden half is the visible one turned by a half turn about a point;
or it is the visible one mirrored in a plane (`mirror_images`). All hold in the picture of a
parallel view as they do in space; drawings in perspective are made parallel first
(`perspective`). Lengths are shares of the diagonal.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.view import Camera
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.explained_ink import compared
from bozzetto_polyhedron.reconstruction.guess_certainty import certainty_of_guess, guess_traits
from bozzetto_polyhedron.reconstruction.hidden_corners import with_hidden_corners
from bozzetto_polyhedron.reconstruction.missing_lines import Whole
from bozzetto_polyhedron.reconstruction.outline import Outline, outline_of
from bozzetto_polyhedron.reconstruction.perspective import ParallelView, parallel_view
from bozzetto_polyhedron.reconstruction.soundness import seen_otherwise
from bozzetto_polyhedron.reconstruction.visible_halves import mirrored_wholes, turned_wholes
from bozzetto_polyhedron.reconstruction.visible_parts import completed_parts, parts_of
from bozzetto_polyhedron.reconstruction.visible_prisms import extruded
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

WAYS: Final = (0, 0, 1, 2)
"""Order of guesses that explain as much: prisms, images by a half turn, hidden corners, mirrors."""

PRISMS, TURNED, HIDDEN_CORNERS, MIRRORED = range(4)
"""Numbers of these kinds."""

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
    traits : (len(TRAITS),) float64
        What tells how likely it is; see `guess_certainty`.
    """

    ends: Array
    unexplained: float
    traits: Array

    @property
    def certainty(self) -> float:
        """Probability that the lines are those that were meant."""
        return certainty_of_guess(self.traits)


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
    faces = [(ring, *holes_in(drawing, junctions, ring)) for ring in _faces_of(drawing, junctions)]
    view = parallel_view(drawing, camera, faces)
    plain = ParallelView(
        drawing, drawing.points, np.zeros(2), 0.0, np.zeros(len(drawing.points)), certain=False
    )
    views = (view, plain) if view.perspective > 0.0 else (plain,)
    kept: list[HiddenLines] = []
    for waiting in (False, True):
        found = [_guessed(each, junctions, faces, most, waiting=waiting) for each in views]
        kept = _different(list(chain.from_iterable(found)), drawing)[:most]
        if kept:
            break
    among_others = float(len(kept) > 1)
    return tuple(replace(each, traits=np.append(each.traits, among_others)) for each in kept)


def _faces_of(drawing: Drawing, junctions: Junctions) -> list[Ring]:
    """Return rings around faces that are wholly visible, of which planarity tells something."""
    return [
        ring
        for ring in regions_of(drawing, junctions)
        if len(ring) > FEWEST and not junctions.is_stem[list(ring)].any()
    ]


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
    view: ParallelView,
    junctions: Junctions,
    faces: Sequence[Rings],
    most: int,
    *,
    waiting: bool,
) -> list[HiddenLines]:
    """Return what may be hidden of a drawing without perspective, as it was drawn.

    `waiting` lines are those of hidden corners that others find; it takes long to try these.
    """
    drawing = view.drawing
    reach = NEAR + 3.0 * drawing.noise
    outline = outline_of(drawing, reach)
    found: list[tuple[bool, float, bool, int, int, HiddenLines]] = []
    seen: list[Whole] = []
    for kind, body, whole in _wholes(drawing, junctions, faces, outline, reach, waiting):
        hidden, unexplained = compared(drawing, junctions, whole, reach)
        missing = hidden > 0.0
        if unexplained > UNEXPLAINED or not missing.any() or _is_known(whole, seen, reach):
            continue
        if not _is_within(whole.points[whole.lines[missing]], outline):
            continue
        count = len(body.lines)
        misfit = seen_otherwise(drawing, body.points, body.lines, hidden[:count])
        if misfit is not None and misfit > MOST_OTHERWISE:
            continue
        seen.append(whole)
        unsure = misfit is None or misfit > OTHERWISE
        places = view.as_drawn(whole.points, _depths(view, whole))
        places = (places * (1.0, -1.0)) * drawing.diagonal + drawing.center
        way = WAYS[kind]
        rank = (kind == MIRRORED, round(unexplained, 3), unsure, way, int(missing.sum()))
        traits = guess_traits(drawing, whole, hidden, unexplained, misfit)
        guess = HiddenLines(places[whole.lines[missing]], unexplained, traits)
        found.append((*rank, guess))
    found.sort(key=lambda each: each[:-1])
    others = sum(not each[0] for each in found)
    if others < len(found):
        del found[max(1, most - 1) : others]
    return [each[-1] for each in found[:most]]


def _wholes(
    drawing: Drawing,
    junctions: Junctions,
    faces: Sequence[Rings],
    outline: Outline,
    reach: float,
    waiting: bool,
) -> Iterator[tuple[int, Whole, Whole]]:
    """Yield the kind of a guess, its body, and the body with all other parts.

    Much of a prism is a mirror image of something: mirrors are asked where the others end. Where
    lines may wait, only hidden corners are sought.
    """
    parts = parts_of(drawing, junctions, reach / 2.0)
    drawn, ends = parts[0].drawing, parts[0].junctions
    own = [(ring,) for ring in _faces_of(drawn, ends)] if len(parts) > 1 else faces
    misfit = partial(_misfit, drawing, junctions, reach)
    misfit_of_part = partial(_misfit, drawn, ends, reach)
    ways = {
        PRISMS: lambda: extruded(drawn, ends, reach),
        TURNED: lambda: turned_wholes(drawn, ends, reach),
        HIDDEN_CORNERS: lambda: with_hidden_corners(
            drawn, own, outline, reach, misfit_of_part, waiting=waiting
        ),
        MIRRORED: lambda: mirrored_wholes(drawn, ends, reach),
    }
    for kind in (HIDDEN_CORNERS,) if waiting else tuple(ways):
        for whole in ways[kind]():
            if len(parts) == 1:
                yield kind, whole, whole
            elif compared(drawn, ends, whole, reach)[1] <= UNEXPLAINED:
                for every in completed_parts(whole, parts, reach, UNEXPLAINED):
                    yield kind, whole, every
    if len(parts) > 1:
        for whole in with_hidden_corners(drawing, faces, outline, reach, misfit, waiting=waiting):
            yield HIDDEN_CORNERS, whole, whole


def _misfit(drawing: Drawing, junctions: Junctions, reach: float, whole: Whole) -> float:
    """Return the share of its lines that a whole shows otherwise than drawn; 1 if that is no guess.

    0 where it is not told.
    """
    hidden, unexplained = compared(drawing, junctions, whole, reach)
    if unexplained > UNEXPLAINED or not (hidden > 0.0).any():
        return 1.0
    misfit = seen_otherwise(drawing, whole.points, whole.lines, hidden)
    if misfit is None:
        return 0.0
    return misfit if misfit <= MOST_OTHERWISE else 1.0


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


def _is_known(whole: Whole, seen: Sequence[Whole], reach: float) -> bool:
    """Whether a guess has the corners of one before."""
    for other in seen:
        if len(other.points) == len(whole.points):
            away = np.linalg.norm(whole.points[:, None] - other.points, axis=2)
            if away.min(1).max() < reach and away.min(0).max() < reach:
                return True
    return False
