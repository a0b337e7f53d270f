"""From a draft of lines and corners to the graph that is handed over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.draft import Draft
from bozzetto_polyhedron.graph.grouping import (
    ACROSS_DASHES,
    FEWEST_DASHES,
    dashed,
)
from bozzetto_polyhedron.graph.health import findings, told
from bozzetto_polyhedron.graph.line_graph import Finding, LineGraph
from bozzetto_polyhedron.graph.noise import corner_noise
from bozzetto_polyhedron.graph.second_reading import second_readings
from bozzetto_polyhedron.graph.segments import (
    Drawn,
    Pieces,
    Segments,
    samples_of,
    segments_of,
)


def no_checkpoint(fraction: float, step: str) -> None:
    """Let the work go on."""


def size_of(strokes: Sequence[Drawn]) -> float:
    """Return the diagonal of the box around strokes, px.

    Parameters
    ----------
    strokes : sequence of Drawn
        Any number of them.
    """
    points = np.concatenate([np.zeros((0, 2)), *(samples_of(each) for each in strokes)])
    return float(np.hypot(*np.ptp(points, axis=0))) if len(points) else 0.0


def normalized(pieces: Sequence[Pieces], size: float) -> tuple[Segments, Array]:
    """Return all pieces in shares of the diagonal, and the place that is their zero, px.

    Parameters
    ----------
    pieces : sequence of Pieces
        One for each stroke.
    size : float
        Diagonal of the drawing, px.
    """
    in_pixels = segments_of(pieces)
    origin: Array = np.zeros(2)
    if len(in_pixels):
        origin = in_pixels.ends.reshape(-1, 2).min(0)
    return in_pixels.scaled(size, origin), origin


def light_segments(segments: Segments) -> Flags:
    """Return which segments were drawn lightly, or, where no pressure tells, in dashes, (k,).

    Parameters
    ----------
    segments : Segments
        Lengths in shares of the drawing's diagonal.
    """
    light = segments.light.copy()
    if not light.any():
        for chain in dashed(segments, light, ACROSS_DASHES):
            light[list(chain)] = len(chain) >= FEWEST_DASHES
    return light


def searched_graph(
    draft: Draft, pieces: Sequence[Pieces], segments: Segments, size: float, origin: Array
) -> LineGraph:
    """Hand over the likeliest draft; where another one is nearly as likely, that is a finding.

    The parameters are those of `graph_of_draft`.
    """
    graph = graph_of_draft(draft, pieces, segments, size, origin)
    if graph.health:
        return graph
    doubts = (told(place * size + origin, "second reading") for place in second_readings(draft))
    return replace(graph, health=tuple(doubts))


def graph_of_draft(
    draft: Draft | None, pieces: Sequence[Pieces], segments: Segments, size: float, origin: Array
) -> LineGraph:
    """Give the corners of a draft their numbers, and hand everything over in pixels.

    Parameters
    ----------
    draft : Draft, optional
        None if no stroke is a line.
    pieces : sequence of Pieces
        One for each stroke.
    segments : Segments
        Lengths in shares of the drawing's diagonal.
    size : float
        That diagonal, px.
    origin : (2,) float64
        The zero of the segments, px.
    """
    curved = tuple(told(each.middle, "curved stroke") for each in pieces if each.curved)
    if draft is None:
        return empty_graph(len(pieces), curved)
    corners = sorted(draft.sums)
    number = {corner: k for k, corner in enumerate(corners)}
    found = draft.places()
    places = np.array([found[k] for k in corners]).reshape(-1, 2)
    rows = sorted(
        (tuple(sorted((number[each.start], number[each.stop]))), each.line.members)
        for each in draft.lines.values()
    )
    lines: Index = np.array([pair for pair, _ in rows], np.intp).reshape(-1, 2)
    health = tuple(told(place * size + origin, what) for place, what in findings(places, lines))
    strokes = tuple(
        tuple(sorted({int(k) for k in segments.strokes[list(members)]})) for _, members in rows
    )
    kept = {stroke for each in strokes for stroke in each}
    light = light_segments(segments)
    return LineGraph(
        places * size + origin,
        lines,
        np.array([_lightness(segments, light, members) for _, members in rows], float),
        strokes,
        tuple(k for k in range(len(pieces)) if k not in kept),
        corner_noise(draft) * size,
        (*health, *curved),
    )


def _lightness(segments: Segments, light: Flags, members: tuple[int, ...]) -> float:
    """Share of a line's ink that was drawn lightly."""
    lengths = segments.lengths[list(members)]
    return float(lengths[light[list(members)]].sum() / max(float(lengths.sum()), 1e-12))


def empty_graph(count: int, health: tuple[Finding, ...] = ()) -> LineGraph:
    """Return the graph of strokes none of which is a line.

    Parameters
    ----------
    count : int
        Number of strokes.
    health : tuple of Finding
        What is said about them.
    """
    nothing = np.zeros(0)
    return LineGraph(
        np.zeros((0, 2)), np.zeros((0, 2), np.intp), nothing, (), tuple(range(count)), 0.0, health
    )
