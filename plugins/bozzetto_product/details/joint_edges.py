"""Edges that lie on surfaces exactly enough to be shared, with their curves in the parameters.

A curve in the parameters of a surface is no spline in space: its image is fitted in spans of degree
five, which are halved until it is within a hundredth of what a `Brep` allows. Several curves over
one parameter get the same knots, so that the surface of straight lines between two is exact.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry import BSplineSurface, Curve, ParameterCurve

DEGREE: Final = 5

EXACT: Final = 2e-9
"""Largest distance of an edge from its surface, as share of the size: a fifth of the gap that a
`Brep` allows."""

FOLLOWED: Final = 1e-6
"""Largest distance of an edge from the outline meant, as share of the size."""

HALVINGS: Final = 14
"""How often a span may be halved."""

MOST_SPANS: Final = 3000

KINKS: Final = (0.05, 1e-4)
"""Difference of derivatives on both sides of a knot, as share of their length, that is a kink; the
second one where nothing can be followed with the first. Wherever a curve is cut its fits differ a
little, and CAD splits a surface with a kink, or complains."""

NODES: Final = 0.5 - 0.5 * np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
"""Chebyshev-Lobatto places in a span, at which it is interpolated."""

PROBES: Final = (np.arange(9) + 0.5) / 9
"""Places in a span at which it is checked."""


def _bernstein(at: Array) -> Array:
    from math import comb

    return np.stack(
        [comb(DEGREE, k) * at**k * (1.0 - at) ** (DEGREE - k) for k in range(DEGREE + 1)], axis=1
    )


TO_BEZIER: Final = np.linalg.inv(_bernstein(NODES))
AT_PROBES: Final = _bernstein(PROBES)
AT_NODES: Final = _bernstein(NODES)


@dataclass(frozen=True, eq=False)
class Track:
    """A curve on a surface.

    Parameters
    ----------
    surface : BSplineSurface
    parameters : callable
        (n,) parameters t to u and v, (n, 2).
    """

    surface: BSplineSurface
    parameters: Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class FittedEdge:
    """An edge and its image in the parameters of a surface."""

    curve: Curve
    path: ParameterCurve


def fitted_edges(
    tracks: Sequence[Track], start: float, end: float, size: float, pieces: int = 4
) -> tuple[FittedEdge, ...]:
    """Return edges over one parameter range with the same knots.

    Parameters
    ----------
    tracks : sequence of Track
        The curves, over one parameter.
    start, end : float
        Its range.
    size : float
        Of the whole, mm: what is exact is measured by it.
    pieces : int
        Spans to begin with.

    Raises
    ------
    UserError
        If a curve is not on its surface, or too rough to be followed.
    """
    samples: list[dict[tuple[float, float], Array]] = [{} for _ in tracks]
    for kink in KINKS:
        breaks = np.linspace(start, end, pieces + 1)
        for _ in range(HALVINGS):
            for track, known in zip(tracks, samples, strict=True):
                _look(track, breaks, known)
            paths, edges, bad, kinks = _fits(tracks, samples, breaks, size, kink)
            if not bad.any() or len(breaks) > MOST_SPANS:
                break
            middles = 0.5 * (breaks[:-1] + breaks[1:])[bad]
            breaks = np.sort(np.concatenate((breaks, middles)))
        if not bad.any():
            break
    else:
        raise UserError(
            "The outline is too rough for this surface. Draw it more smoothly, or elsewhere."
        )
    knots, kept = _spline_layout(breaks, kinks)
    made = []
    for path, edge in zip(paths, edges, strict=True):
        curve = Curve(DEGREE, knots, edge.reshape(-1, 3)[kept])
        made.append(FittedEdge(curve, ParameterCurve(DEGREE, knots, path.reshape(-1, 2)[kept])))
    return tuple(made)


def _look(track: Track, breaks: Array, known: dict[tuple[float, float], Array]) -> None:
    """Find the parameters of a curve at nodes and probes of spans that are new, (15, 2) each."""
    spans = [span for span in itertools.pairwise(breaks.tolist()) if span not in known]
    if not spans:
        return
    low, high = np.transpose(spans)
    at = low[:, None] + (high - low)[:, None] * np.concatenate((NODES, PROBES))
    at[:, DEGREE] = high
    found = track.parameters(at.ravel()).reshape(*at.shape, 2)
    known.update(zip(spans, found, strict=True))


def _fits(
    tracks: Sequence[Track],
    samples: Sequence[dict[tuple[float, float], Array]],
    breaks: Array,
    size: float,
    kink: float,
) -> tuple[list[Array], list[Array], Flags, Flags]:
    """Return Bézier points of paths and edges, spans that are off, and joints with a kink."""
    widths = np.diff(breaks)
    spans = list(itertools.pairwise(breaks.tolist()))
    found = [np.stack([known[span] for span in spans]) for known in samples]
    bad = np.zeros(len(widths), bool)
    kinks = np.zeros(max(len(widths) - 1, 0), bool)
    raw = []
    for row in found:
        values = row[:, : DEGREE + 1]
        path = np.einsum("ij,sjd->sid", TO_BEZIER, values)
        path[:, 0], path[:, -1] = values[:, 0], values[:, -1]
        kinks |= _kinked(path, widths, kink)
        raw.append(path)
    paths = [_smooth(path, widths, kinks) for path in raw]
    images = []
    for track, path in zip(tracks, paths, strict=True):
        inner = np.einsum("ij,sjd->sid", AT_NODES, path).reshape(-1, 2)
        space = track.surface.value(*inner.T).reshape(len(widths), DEGREE + 1, 3)
        edge = np.einsum("ij,sjd->sid", TO_BEZIER, space)
        edge[:, 0], edge[:, -1] = space[:, 0], space[:, -1]
        kinks |= _kinked(edge, widths, kink)
        images.append(edge)
    edges = [_smooth(edge, widths, kinks) for edge in images]
    for track, row, path, edge in zip(tracks, found, paths, edges, strict=True):
        wanted = track.surface.value(*row[:, DEGREE + 1 :].reshape(-1, 2).T)
        run = np.einsum("ij,sjd->sid", AT_PROBES, path).reshape(-1, 2)
        on = track.surface.value(*run.T)
        here = np.einsum("ij,sjd->sid", AT_PROBES, edge).reshape(-1, 3)
        off = np.linalg.norm(here - on, axis=1).reshape(len(widths), -1).max(axis=1)
        beside = np.linalg.norm(on - wanted, axis=1).reshape(len(widths), -1).max(axis=1)
        bad |= ~((off <= EXACT * size) & (beside <= FOLLOWED * size))
    return paths, edges, bad, kinks


def _slopes(points: Array, widths: Array) -> tuple[Array, Array]:
    """Return the derivatives before and behind inner joints, (s − 1, d) each."""
    before = DEGREE * (points[:-1, -1] - points[:-1, -2]) / widths[:-1, None]
    behind = DEGREE * (points[1:, 1] - points[1:, 0]) / widths[1:, None]
    return before, behind


def _kinked(points: Array, widths: Array, kink: float) -> Flags:
    before, behind = _slopes(points, widths)
    length = np.linalg.norm(before, axis=1) + np.linalg.norm(behind, axis=1)
    return np.asarray(np.linalg.norm(before - behind, axis=1) > kink * length)


def _smooth(points: Array, widths: Array, kinks: Flags) -> Array:
    """Return Bézier points with one derivative at each joint that has no kink."""
    made = points.copy()
    before, behind = _slopes(points, widths)
    # The shorter span tells its derivative less well: what it is off counts against its width.
    share = (widths[:-1] / (widths[:-1] + widths[1:]))[:, None]
    mean = share * before + (1.0 - share) * behind
    smooth = ~kinks
    made[:-1, -2][smooth] = (points[:-1, -1] - mean * widths[:-1, None] / DEGREE)[smooth]
    made[1:, 1][smooth] = (points[1:, 0] + mean * widths[1:, None] / DEGREE)[smooth]
    return made


def _spline_layout(breaks: Array, kinks: Flags) -> tuple[Array, Flags]:
    """Return the knots of spans put together, and which of their Bézier points are its points."""
    knots = [np.repeat(breaks[0], DEGREE + 1)]
    kept = np.ones((len(breaks) - 1, DEGREE + 1), bool)
    for number, kink in enumerate(kinks.tolist()):
        knots.append(np.repeat(breaks[number + 1], DEGREE if kink else DEGREE - 1))
        kept[number, -1] = kink
        kept[number + 1, 0] = False
    knots.append(np.repeat(breaks[-1], DEGREE + 1))
    return np.concatenate(knots), kept.ravel()
