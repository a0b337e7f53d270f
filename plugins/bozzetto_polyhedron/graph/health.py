"""Where a graph looks wrong, and the one touch that mends it.

A closed polyhedron has three lines or more at every corner. Lengths are shares of the drawing's
diagonal.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.graph.line_graph import Finding, FindingKind

CLOSE: Final = 0.025
"""Distance under which two corners without a line between them may be meant for one."""

ON_LINE: Final = 0.012
"""Distance under which a corner lies on a line."""

TICK: Final = 0.05
"""Length under which a line that touches nothing is a stray mark."""

GAP: Final = 0.12
"""Distance up to which two loose ends are taken for the two sides of a gap."""

SENTENCES: Final[dict[FindingKind, str]] = {
    "loose end": "A line ends here alone. Draw on to the next corner, or erase the line.",
    "corner of two lines": "Only two lines meet here. Draw the line that is missing, or let "
    "Object › Polyhedron › Draw hidden edges guess it. If this is a folded sheet, touch a corner.",
    "crossing": "A line ends on the middle of another one here. Draw the missing line from here, "
    "or draw on to the next corner.",
    "tick": "This short mark belongs to no line. Erase it, or draw it longer.",
    "close corners": "Two corners are close together here. Draw the line between them, or erase "
    "and draw them as one.",
    "gap": "There is a gap between two ends. Draw the line across it.",
    "second reading": "The lines here could also meet in another way. Touch a corner to see the "
    "solid; if it is wrong, erase lines that run close together and draw them farther apart.",
    "open faces": "The faces do not close here: a line is missing, or it ends at the wrong corner. "
    "Erase lines that run close together and draw them farther apart.",
    "curved stroke": "This stroke is curved, and no clear ellipse or rounded corner. Erase it and "
    "draw it again.",
}
"""For each kind of finding, what to do about it."""


def findings(places: Array, lines: Index) -> list[tuple[Array, FindingKind]]:
    """Find what looks wrong about corners and lines.

    Parameters
    ----------
    places : (n, 2) float64
        Shares of the diagonal.
    lines : (m, 2) intp
        Numbers of corners.
    """
    degrees = np.bincount(lines.ravel(), minlength=len(places))
    found, told_already = _ticks(places, lines, degrees)
    for corner in _on_lines(places, lines, degrees):
        if corner not in told_already:
            found.append((places[corner], "crossing"))
            told_already.add(corner)
    loose = [k for k in np.flatnonzero(degrees == 1).tolist() if k not in told_already]
    for corner in list(loose):
        if corner not in loose:
            continue
        partner = _across_gap(corner, loose, places, lines)
        if partner is None:
            found.append((places[corner], "loose end"))
        else:
            loose = [k for k in loose if k not in (corner, partner)]
            found.append(((places[corner] + places[partner]) / 2, "gap"))
    two = [k for k in np.flatnonzero(degrees == 2).tolist() if k not in told_already]
    found += [(places[k], "corner of two lines") for k in two]
    found += [(middle, "close corners") for middle in _close_corners(places, lines, degrees)]
    return found


def _ticks(
    places: Array, lines: Index, degrees: Index
) -> tuple[list[tuple[Array, FindingKind]], set[int]]:
    """Find short lines that touch nothing, and their corners."""
    found: list[tuple[Array, FindingKind]] = []
    corners: set[int] = set()
    for a, b in lines.tolist():
        if degrees[a] == degrees[b] == 1 and np.hypot(*(places[a] - places[b])) < TICK:
            found.append(((places[a] + places[b]) / 2, "tick"))
            corners |= {a, b}
    return found, corners


def _on_lines(places: Array, lines: Index, degrees: Index) -> list[int]:
    """Corners of too few lines that lie on the middle part of another line."""
    few = np.flatnonzero((degrees == 1) | (degrees == 2))
    start, stop = places[lines[:, 0]], places[lines[:, 1]]
    axis = stop - start
    square = np.maximum((axis**2).sum(1), 1e-12)
    at = ((places[few][:, None] - start) * axis).sum(2) / square
    away = np.linalg.norm(places[few][:, None] - start - at[..., None] * axis, axis=2)
    margin = CLOSE / np.sqrt(square)
    hit = (away < ON_LINE) & (at > margin) & (at < 1.0 - margin)
    hit &= ~(few[:, None, None] == lines).any(2)
    return [int(k) for k in few[hit.any(1)]]


def _across_gap(corner: int, loose: list[int], places: Array, lines: Index) -> int | None:
    """Return the loose end that goes on where the line of another loose end stops."""
    line = lines[(lines == corner).any(1)][0]
    start = int(line[line != corner][0])
    along = places[corner] - places[start]
    for other in loose:
        step = places[other] - places[corner]
        away = float(np.hypot(*step))
        if other in (corner, start) or not 0.0 < away < GAP:
            continue
        if along @ step > np.cos(np.radians(25.0)) * np.hypot(*along) * away:
            return other
    return None


def _close_corners(places: Array, lines: Index, degrees: Index) -> list[Array]:
    """Middles of pairs of corners, one of too few lines, that are close and not joined."""
    joined = {tuple(sorted(pair)) for pair in lines.tolist()}
    away = np.linalg.norm(places[:, None] - places, axis=2)
    few = degrees < 3
    rows, columns = np.nonzero(np.triu(away < CLOSE, 1) & (few[:, None] | few))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(places[a] + places[b]) / 2 for a, b in pairs if (a, b) not in joined]


def told(place: Array, what: FindingKind) -> Finding:
    """Return a finding with its sentence.

    Parameters
    ----------
    place : (2,) float64
        Canvas pixels.
    what : str
        The kind of finding.
    """
    return Finding((float(place[0]), float(place[1])), what, SENTENCES[what])
