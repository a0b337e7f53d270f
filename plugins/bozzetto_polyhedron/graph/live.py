"""The graph while it is drawn: after each stroke the last one is continued, not searched anew."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto_polyhedron.graph.build import (
    empty_graph,
    graph_of_draft,
    light_segments,
    no_checkpoint,
    normalized,
    searched_graph,
    size_of,
)
from bozzetto_polyhedron.graph.certainty import certainty_of, line_traits
from bozzetto_polyhedron.graph.draft import Draft, Joined, draft_of
from bozzetto_polyhedron.graph.health import told
from bozzetto_polyhedron.graph.likelihood import FEW_LINES, FEW_VISIBLE, Fits
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.repair import repair
from bozzetto_polyhedron.graph.search import best_draft
from bozzetto_polyhedron.graph.second_reading import closest_other
from bozzetto_polyhedron.graph.segments import Drawn, Pieces, Segments, pieces_of, samples_of

LEAST_SURE: Final = 0.9
"""Certainty below which it is told where lines could meet in another way."""


@dataclass(frozen=True, eq=False)
class LiveGraph:
    """A graph with what is needed to continue it.

    Parameters
    ----------
    graph : LineGraph
        Lines and corners as far as they were drawn.
    strokes : tuple of Drawn
        What it was found from.
    pieces : tuple of Pieces
        Of each stroke.
    segments : Segments, optional
        All pieces, in shares of the diagonal.
    draft : Draft, optional
        The lines and corners in these units; not to be changed.
    """

    graph: LineGraph
    strokes: tuple[Drawn, ...] = ()
    pieces: tuple[Pieces, ...] = ()
    segments: Segments | None = None
    draft: Draft | None = None


def searched(
    strokes: Sequence[Drawn],
    *,
    checkpoint: Callable[[float, str], None] = no_checkpoint,
    only_visible: bool = False,
) -> LiveGraph:
    """Find the lines and corners that strokes draw.

    Parameters
    ----------
    strokes : sequence of Drawn
        In the order drawn.
    checkpoint : callable
        Called with the fraction done and the step's name; it may raise to end the work.
    only_visible : bool
        Whether hidden lines are left out, so that many corners have fewer than three.
    """
    size = size_of(strokes)
    if size == 0.0:
        return LiveGraph(empty_graph(len(strokes)), tuple(strokes))
    pieces = _pieces(strokes, size, {})
    segments, origin = normalized(pieces, size)
    if not len(segments):
        graph = graph_of_draft(None, pieces, segments, size, origin)
        return LiveGraph(graph, tuple(strokes), pieces)
    draft = best_draft(
        segments,
        light_segments(segments),
        lambda: checkpoint(0.5, "Finding corners"),
        FEW_VISIBLE if only_visible else FEW_LINES,
    )
    graph = searched_graph(draft, pieces, segments, size, origin)
    return LiveGraph(graph, tuple(strokes), pieces, segments, draft)


def with_draft(live: LiveGraph, draft: Draft) -> LiveGraph:
    """Return a graph of the same strokes whose lines meet as in another draft of theirs.

    Parameters
    ----------
    live : LiveGraph
        A graph with a draft.
    draft : Draft
        Of the same segments.
    """
    size = size_of(live.strokes)
    segments, origin = normalized(live.pieces, size)
    graph = searched_graph(draft, live.pieces, segments, size, origin)
    return replace(live, graph=graph, draft=draft)


def with_certainty(live: LiveGraph) -> LiveGraph:
    """Return a graph that knows how likely its lines are right.

    Where that is in doubt and nothing else looks wrong, it is a finding where the closest other
    way to join lines differs.

    Parameters
    ----------
    live : LiveGraph
        What all readings have settled on.
    """
    graph, draft = live.graph, live.draft
    if draft is None or not len(graph.lines):
        return live
    cost, place = closest_other(draft)
    size = size_of(live.strokes)
    certainty = certainty_of(line_traits(graph, draft, cost, size))
    health = graph.health
    if certainty < LEAST_SURE and not health and place is not None:
        _, origin = normalized(live.pieces, size)
        health = (told(place * size + origin, "second reading"),)
    return replace(live, graph=replace(graph, certainty=certainty, health=health))


def continued(
    before: LiveGraph,
    strokes: Sequence[Drawn],
    *,
    checkpoint: Callable[[float, str], None] = no_checkpoint,
) -> LiveGraph:
    """Find the graph of strokes, starting from that of most of them.

    Only what is beside new and erased strokes is looked at, unless there is nothing to start from.

    Parameters
    ----------
    before : LiveGraph
        The graph before strokes came or went; strokes are known by their identity.
    strokes : sequence of Drawn
        All strokes, in the order drawn.
    checkpoint : callable
        See `searched`.
    """
    size = size_of(strokes)
    if size == 0.0 or before.draft is None or before.segments is None:
        return searched(strokes, checkpoint=checkpoint)
    known = {id(s): p for s, p in zip(before.strokes, before.pieces, strict=True)}
    pieces = _pieces(strokes, size, known)
    segments, origin = normalized(pieces, size)
    if not len(segments):
        return searched(strokes, checkpoint=checkpoint)
    draft, beside = _carried(before, strokes, segments)
    repair(draft, lambda: checkpoint(0.5, "Finding corners"), beside)
    graph = graph_of_draft(draft, pieces, segments, size, origin)
    return LiveGraph(graph, tuple(strokes), pieces, segments, draft)


def _pieces(
    strokes: Sequence[Drawn], size: float, known: Mapping[int, Pieces]
) -> tuple[Pieces, ...]:
    """Return the pieces of each stroke, those that are known as they are."""
    both = [samples_of(each)[[0, -1]] if len(samples_of(each)) else None for each in strokes]
    made = []
    for number, stroke in enumerate(strokes):
        others = [one for k, one in enumerate(both) if one is not None and k != number]
        made.append(
            known.get(id(stroke))
            or pieces_of(stroke, size, np.concatenate([np.zeros((0, 2)), *others]))
        )
    return tuple(made)


def _carried(
    before: LiveGraph, strokes: Sequence[Drawn], segments: Segments
) -> tuple[Draft, set[int]]:
    """Return the draft of before with strokes that went left out and new ones added by themselves.

    The second value are the corners beside which it must be looked at again.
    """
    assert before.draft is not None
    assert before.segments is not None
    now = _numbers([id(each) for each in strokes], segments)
    then = _numbers([id(each) for each in before.strokes], before.segments)
    moved = {number: now[key] for key, number in then.items() if key in now}
    fits = Fits(segments, before.draft.fits.spread)
    lines: list[Joined] = []
    beside: set[int] = set()
    used: set[int] = set()
    for each in before.draft.lines.values():
        members = tuple(moved[k] for k in each.line.members if k in moved)
        if len(members) < len(each.line.members):
            beside |= {each.start, each.stop}
        if members:
            lines.append(_along(Joined(fits.line(members), each.start, each.stop), each))
            used |= set(members)
    used |= {moved[k] for k in before.draft.dropped if k in moved}
    corner = before.draft.next_corner
    for number in range(len(segments)):
        if number not in used:
            lines.append(Joined(fits.line((number,)), corner, corner + 1))
            beside |= {corner, corner + 1}
            corner += 2
    draft = draft_of(fits, lines)
    draft.dropped = tuple(sorted(moved[k] for k in before.draft.dropped if k in moved))
    return draft, beside & set(draft.sums)


def _numbers(strokes: list[int], segments: Segments) -> dict[tuple[int, int], int]:
    """Return the number of each segment by its stroke and its place in it."""
    made: dict[tuple[int, int], int] = {}
    pieces: dict[int, int] = {}
    for number, stroke in enumerate(segments.strokes.tolist()):
        piece = pieces[stroke] = pieces.get(stroke, -1) + 1
        made[strokes[stroke], piece] = number
    return made


def _along(new: Joined, old: Joined) -> Joined:
    """Put a line the same way round as the one that it replaces."""
    a, b = new.line, old.line
    forward = (a.stop[0] - a.start[0]) * (b.stop[0] - b.start[0]) + (a.stop[1] - a.start[1]) * (
        b.stop[1] - b.start[1]
    )
    return new if forward >= 0 else Joined(new.line, new.stop, new.start)
