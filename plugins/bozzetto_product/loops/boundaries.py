"""Loops by curves and joints, as the recipe keeps them, and back."""

from __future__ import annotations

from dataclasses import replace

from bozzetto_product.model.joints import Boundary, Run
from bozzetto_product.network.half_edges import half_edge_images, half_edges, loop_of_half_edges
from bozzetto_product.network.net import HalfEdge, Loop, Net
from bozzetto_product.network.outlines import ends_of, outlines_of

NodeName = tuple[str, bool]
"""Id of a joint, and whether it is the joint's mirror image."""


def boundary_of(net: Net, loop: Loop) -> Boundary:
    """Name a loop by curves and joints.

    Parameters
    ----------
    net : Net
        Where the loop is.
    loop : Loop
        Its outlines go through nodes that are joints, or are one closed edge.

    Returns
    -------
    tuple of Run
        Pieces of one curve that follow one another are one run, so that joints which are added
        later change nothing.
    """
    return tuple(run for outline in outlines_of(net, loop) for run in _runs_of(net, outline))


def _runs_of(net: Net, outline: Loop) -> list[Run]:
    """Return the runs of one outline."""
    runs: list[Run] = []
    for half_edge in outline:
        run = _run(net, half_edge)
        if runs and _goes_on(runs[-1], run):
            runs[-1] = _joined(runs[-1], run)
        else:
            runs.append(run)
    if len(runs) > 1 and _goes_on(runs[-1], runs[0]):
        runs[0] = _joined(runs.pop(), runs[0])
    return runs


def mirrored_boundary(boundary: Boundary) -> Boundary:
    """Return the mirror image of a boundary, in the same sense along its curves."""
    return tuple(replace(run, mirrored=not run.mirrored) for run in boundary)


def loop_of(net: Net, boundary: Boundary) -> Loop | None:
    """Find the loop that a boundary names.

    Parameters
    ----------
    net : Net
        Where the loop is looked for.
    boundary : tuple of Run
        Head to tail, outline after outline.

    Returns
    -------
    Loop or None
        None if a curve or a joint is gone, or if the runs of an outline do not close. Joints that
        were added within a run since then only make more edges of it.
    """
    images = half_edge_images(net)
    loop: list[HalfEdge] = []
    for run in boundary:
        part = _walk(net, run)
        if part is not None and run.mirrored:
            halves = [int(images[half]) for half in half_edges(tuple(part))]
            part = list(loop_of_half_edges(halves)) if min(halves) >= 0 else None
        if part is None:
            return None
        loop += part
    closed = all(
        ends_of(net, outline[0])[0] == ends_of(net, outline[-1])[1]
        for outline in outlines_of(net, tuple(loop))
    )
    return tuple(loop) if loop and closed else None


# -- from edges to runs ----------------------------------------------------------------------


def _run(net: Net, half_edge: HalfEdge) -> Run:
    """Return the run that is one edge; an edge of a mirror image is named by what it mirrors."""
    number, forward = half_edge
    edge = net.edges[number]
    named = edge.twin if edge.mirrored and edge.twin >= 0 else number
    first, last = ends_of(net, (named, forward))
    if first < 0:
        return Run(edge.curve, "", "", forward, edge.mirrored)
    (start, opposite), (end, end_opposite) = net.joints[first], net.joints[last]
    return Run(edge.curve, start, end, forward, edge.mirrored, opposite, end_opposite)


def _goes_on(first: Run, second: Run) -> bool:
    """Tell whether a second run carries on along the curve of a first, at the same joint."""
    return (
        (first.curve, first.forward, first.mirrored)
        == (second.curve, second.forward, second.mirrored)
    ) and (first.end, first.end_opposite) == (second.start, second.start_opposite)


def _joined(first: Run, second: Run) -> Run:
    return replace(first, end=second.end, end_opposite=second.end_opposite)


# -- from runs to edges ----------------------------------------------------------------------


def _walk(net: Net, run: Run) -> list[HalfEdge] | None:
    """Return the edges of a run, as if it were not mirrored; None if they are gone."""
    pieces = [
        i for i, edge in enumerate(net.edges) if edge.curve == run.curve and not edge.mirrored
    ]
    pieces.sort(key=lambda number: net.edges[number].piece, reverse=not run.forward)
    if not pieces:
        return None
    ends = [ends_of(net, (number, run.forward)) for number in pieces]
    around = ends[-1][1] == ends[0][0]
    if not run.start and not run.end:
        return [(number, run.forward) for number in pieces] if around else None
    start, end = (
        _node(net, run.start, run.start_opposite),
        _node(net, run.end, run.end_opposite),
    )
    for first, (tail, _) in enumerate(ends):
        if tail != start:
            continue
        last = len(pieces) + (first if around else 0)
        for step in range(first, last):
            if ends[step % len(pieces)][1] == end:
                walked = (pieces[each % len(pieces)] for each in range(first, step + 1))
                return [(number, run.forward) for number in walked]
    return None


def _node(net: Net, name: str, opposite: bool) -> int | None:
    """Return the node of a joint, or of its mirror image; one in the plane is both."""
    for joint in ((name, opposite), (name, not opposite)):
        if joint in net.joints:
            return net.joints.index(joint)
    return None
