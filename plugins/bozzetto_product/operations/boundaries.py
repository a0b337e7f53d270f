"""Boundaries of surfaces when curves are cut, joined, turned round or taken away."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from bozzetto_product.model.joints import Boundary, Joint, Run
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState


def with_boundaries(
    state: ProductState, change: Callable[[Boundary], Boundary | None]
) -> ProductState:
    """Return the state with every boundary changed; surfaces whose boundary is None go.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    change : callable
        From a boundary to the new one.
    """
    nodes: list[Any] = []
    for node in state.nodes:
        if isinstance(node, Patch):
            boundary = change(node.boundary)
            if boundary is None:
                continue
            nodes.append(node if boundary == node.boundary else replace(node, boundary=boundary))
        else:
            nodes.append(node)
    rejected = [new for old in state.rejected if (new := change(old)) is not None]
    return replace(state, nodes=tuple(nodes), rejected=tuple(rejected))


def span_of(run: Run, joints: Sequence[Joint], closed: bool) -> tuple[float, float]:
    """Return the shares of its curve over which a run goes, growing: (0.8, 1.3) is over a seam.

    Parameters
    ----------
    run : Run
        One whose joints are known, or a whole curve.
    joints : sequence of Joint
        Of the network.
    closed : bool
        Whether the curve is closed.
    """
    first, last = (run.start, run.end) if run.forward else (run.end, run.start)
    low, high = _shares(first, run.curve, joints), _shares(last, run.curve, joints)
    begin = min(low, default=0.0)
    if not closed:
        return begin, max(high, default=1.0)
    end = min(high, default=begin)
    return begin, end if end > begin else end + 1.0


def split_run(
    run: Run, span: tuple[float, float], cuts: Sequence[tuple[float, str]], pieces: Sequence[str]
) -> list[Run]:
    """Return the runs over the pieces of a curve that was cut.

    Parameters
    ----------
    run : Run
        Over the whole curve or a part of it.
    span : (float, float)
        The shares of the curve over which it goes, as `span_of` gives them.
    cuts : sequence of (float, str)
        Shares at which the curve was cut, growing, and the joints that are there now.
    pieces : sequence of str
        Ids of the curves between: one more than cuts of an open curve; as many as cuts of a
        closed one, and the last is over the seam.
    """
    begin, end = span
    first, last = (run.start, run.end) if run.forward else (run.end, run.start)
    around = [(share + lap, name) for lap in (0.0, 1.0) for share, name in cuts]
    inside = [(share, name) for share, name in around if begin < share < end]
    stops = [(begin, first), *inside, (end, last)]
    closed = len(pieces) == len(cuts)
    found = []
    for (low, start), (high, stop) in itertools.pairwise(stops):
        middle = (0.5 * (low + high)) % 1.0
        number = sum(share < middle for share, _ in cuts)
        piece = pieces[number - 1] if closed else pieces[number]
        # A whole closed curve has no joint: it begins and ends in the cut.
        ends = [name or cuts[0][1] for name in (start, stop)] if closed else [start, stop]
        found.append(replace(run, curve=piece, start=ends[0], end=ends[1], forward=True))
    if closed and not run.start and len(found) > 1:
        found = [*found[1:-1], replace(found[-1], end=found[0].end)]
    return found if run.forward else [turned_run(one) for one in reversed(found)]


def turned_run(run: Run) -> Run:
    """Return a run walked the other way."""
    return replace(run, start=run.end, end=run.start, forward=not run.forward)


def outlines_of_boundary(boundary: Boundary) -> list[Boundary]:
    """Return the outlines of a boundary: that of the surface, and those of its holes.

    One ends where it is closed and the next run begins in another joint.
    """
    made: list[list[Run]] = []
    for run in boundary:
        last = made[-1] if made else []
        closed = bool(last) and last[0].start == last[-1].end
        if not made or (closed and (not run.start or run.start != last[-1].end)):
            made.append([])
        made[-1].append(run)
    return [tuple(outline) for outline in made]


def joined_runs(boundary: Boundary, curve: str, joint: str) -> Boundary:
    """Return a boundary in which two runs over one curve, met at a joint, are one."""
    outlines = outlines_of_boundary(boundary)
    return tuple(run for one in outlines for run in _joined_runs(one, curve, joint))


def _joined_runs(outline: Boundary, curve: str, joint: str) -> list[Run]:
    runs = list(outline)
    number = 0
    while len(runs) > 1 and number < len(runs):
        run, after = runs[number], runs[(number + 1) % len(runs)]
        if (
            run.curve == after.curve == curve
            and run.end == after.start == joint
            and run.forward == after.forward
            and run.mirrored == after.mirrored
        ):
            runs[number] = replace(run, end=after.end)
            del runs[(number + 1) % len(runs)]
            number = 0
        else:
            number += 1
    return runs


def joints_in_use(state: ProductState) -> set[str]:
    """Return the ids of joints at which a boundary turns from one run to the next."""
    boundaries = [*(patch.boundary for patch in state.of_kind(Patch)), *state.rejected]
    return {
        name for boundary in boundaries for run in boundary for name in (run.start, run.end) if name
    }


def _shares(joint: str, curve: str, joints: Sequence[Joint]) -> list[float]:
    return [
        meet.at for one in joints if one.id == joint for meet in one.meetings if meet.curve == curve
    ]
