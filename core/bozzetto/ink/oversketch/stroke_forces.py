"""Forces of strokes on a curve: the stretch along which they run, and their closest points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.ink.curves.resample import arc_length, distinct, points_along, resample
from bozzetto.ink.oversketch.bending_energy import lengths_of
from bozzetto.ink.oversketch.ordered_feet import FEET_LAPS, ordered_feet

SPACING: Final = 3.0
"""Longest way between the samples of a stroke, px: others are put between its own."""

MOST_SAMPLES: Final = 1000
"""Most samples of a stroke; where there are more, fewer are taken at equal steps."""

MATCHED: Final = 80
"""Most places of a stroke whose feet are sought in order; those of the others lie between."""

MATCHED_NODES: Final = 500
"""Most nodes among which feet are sought in order."""

WINDOW: Final = 30.0
"""How far along the curve, px, the closest point may be from the foot that order gives:
more than the unsteadiness of a hand, less than the way to another leg of the curve."""

DIAGONAL: Final = 2.0**0.5
"""Distance of two ends over their distance across the curve, up to which they are a pair:
they are then no farther apart along the curve than across."""

STRETCH: Final = 40.0
"""Least length of curve, px, over which the nodes spread out where its end moves on; it is
at least twice the way that the end goes."""


@dataclass(frozen=True, eq=False)
class Trace:
    """A stroke and the place along the curve that belongs to each of its samples.

    Attributes
    ----------
    places : (m, 2) float
        Samples in the sense of the curve, px.
    pressure : (m,) float
    stations : (m,) float
        Arc length along the curve, px, not decreasing. Below 0, or above the length of the
        curve, where an open curve is to become longer; above it also on later laps of a
        closed one.
    """

    places: Array
    pressure: Array
    stations: Array


def trace_of(
    places: Array, pressure: Array, nodes: Array, along: Array, ring: float | None
) -> Trace:
    """Find where along a curve a stroke runs.

    Parameters
    ----------
    places : (m, 2) float
        px.
    pressure : (m,) float
        Pressure of the pen at each sample, 0 … 1.
    nodes : (n, 2) float
        Nodes of the curve, px.
    along : (n,) float
        Their arc length.
    ring : float or None
        Length of a closed curve; None for an open one.
    """
    fine, press = _sampled(places, pressure)
    few = np.unique(np.linspace(0, len(fine) - 1, MATCHED).astype(np.intp))
    some = np.unique(np.linspace(0, len(nodes) - 1, MATCHED_NODES).astype(np.intp))
    coarse = resample(fine, count=len(few))
    step = float(arc_length(fine)[-1]) / len(few)
    lengths = lengths_of(along[some], ring)
    feet = ordered_feet(coarse, step, nodes[some], lengths, closed=ring is not None)
    if _against(feet, coarse, nodes[some]):
        fine, press, feet = fine[::-1], press[::-1], feet[::-1]
    lap, foot = np.divmod(feet, len(some))
    stations = along[some[foot]] + (0.0 if ring is None else ring) * lap
    way = arc_length(fine)
    stations = np.interp(way, np.linspace(0.0, way[-1], len(feet)), stations)
    if ring is None and along[-1] > 0:
        length = along[-1]
        turned = nodes[::-1], length - along[::-1]
        stations = _at_the_end(fine, stations, nodes, along)
        stations = length - _at_the_end(fine[::-1], length - stations[::-1], *turned)[::-1]
    return Trace(fine, press, stations)


def _sampled(places: Array, pressure: Array) -> tuple[Array, Array]:
    """Return a stroke's samples with others between them; fewer, where there are too many."""
    kept = distinct(places)
    along = arc_length(places[kept])
    spans = np.diff(along)
    spacing = max(SPACING, float(along[-1]) / MOST_SAMPLES)
    if len(kept) > MOST_SAMPLES:
        way = np.linspace(0.0, along[-1], MOST_SAMPLES)
    else:
        parts = np.maximum(np.ceil(spans / spacing), 1.0).astype(np.intp)
        number = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
        way = np.repeat(along[:-1], parts) + number * np.repeat(spans / parts, parts)
        way = np.append(way, along[-1])
    columns = (*places[kept].T, pressure[kept])
    x, y, press = (np.interp(way, along, column) for column in columns)
    return np.column_stack((x, y)), press


def _against(feet: Index, coarse: Array, nodes: Array) -> bool:
    """Whether a stroke runs against the curve; one beyond an end is taken to lead away."""
    if feet[0] != feet[-1]:
        return bool(feet[-1] < feet[0])
    first, last = np.linalg.norm(coarse[[0, -1]] - nodes[feet[0] % len(nodes)], axis=1)
    leads_to = first > last
    return bool(leads_to if feet[0] > 0 else first < last)


def _at_the_end(fine: Array, stations: Array, nodes: Array, along: Array) -> Array:
    """Return stations of a stroke that are put right at the curve's last node.

    A stroke that lies aside of the curve and ends beside its end, goes right to the end,
    wherever its nearest foot is. A stroke that runs on farther goes beyond.
    """
    length, end = along[-1], nodes[-1]
    station = _foot_near(fine[-1], stations[-1], nodes, along)
    foot = points_along(nodes, along, station)
    made = np.minimum(stations, station)
    if station >= length:
        at_end = np.flatnonzero(stations >= stations[-1])
        away = np.linalg.norm(fine[at_end] - end, axis=1)
        leaves = at_end[np.argmin(away)]
        beyond = arc_length(fine[leaves:])
        if beyond[-1] > away.min():
            made[leaves:] = length + beyond
    else:
        reach = DIAGONAL * float(np.linalg.norm(fine[-1] - foot))
        if np.linalg.norm(fine[-1] - end) <= reach and length - station <= reach:
            made[-1] = length
    return made


def _foot_near(place: Array, station: float, nodes: Array, along: Array) -> float:
    """Return the station of the nearest point on the two spans beside a node."""
    node = int(np.searchsorted(along, station))
    best, least = station, np.inf
    for k in (node - 1, node):
        if 0 <= k < len(nodes) - 1:
            step = nodes[k + 1] - nodes[k]
            share = float(np.clip((place - nodes[k]) @ step / (step @ step), 0.0, 1.0))
            gap = float(np.linalg.norm(nodes[k] + share * step - place))
            if gap < least:
                best, least = float(along[k] + share * (along[k + 1] - along[k])), gap
    return best


def lengthened(nodes: Array, along: Array, traces: list[Trace]) -> tuple[Array, Array]:
    """Return an open curve with its ends moved along the strokes that continue beyond them.

    Parameters
    ----------
    nodes : (n, 2) float
        px.
    along : (n,) float
        Their arc length.
    traces : list of Trace
        The strokes, with the stretch of the curve along which each runs.

    Returns
    -------
    nodes : (n, 2) float
        Near an end that moved on they are spread along the old curve and the stroke's tail.
    stations : (n,) float
        Where they are now along the curve, as in `Trace`.
    """
    made, stations = _lengthened_at_end(nodes, along, traces)
    turned = [
        replace(trace, places=trace.places[::-1], stations=along[-1] - trace.stations[::-1])
        for trace in traces
    ]
    back, from_end = _lengthened_at_end(nodes[::-1], along[-1] - along[::-1], turned)
    at_begin = along < 0.5 * along[-1]
    return (
        np.where(at_begin[:, None], back[::-1], made),
        np.where(at_begin, along[-1] - from_end[::-1], stations),
    )


def _lengthened_at_end(nodes: Array, along: Array, traces: list[Trace]) -> tuple[Array, Array]:
    longest = max(traces, key=lambda trace: trace.stations[-1])
    length, gain = along[-1], longest.stations[-1] - along[-1]
    if gain <= 0 or length <= 0:
        return nodes, along
    beyond = longest.stations > length
    tail = longest.places[beyond]
    leaves = longest.places[~beyond][-1] if not beyond.all() else tail[0]
    path = np.vstack((nodes, tail - leaves + nodes[-1]))
    way = np.append(along, longest.stations[beyond])
    zone = min(max(STRETCH, 2.0 * gain), 0.5 * length)
    share = np.clip((along - (length - zone)) / zone, 0.0, 1.0)
    stations = along + gain * share**2
    return points_along(path, way, stations), stations


@dataclass(frozen=True, eq=False)
class Pull:
    """One stroke, on one lap, at the nodes beside it.

    Attributes
    ----------
    nodes : (n,) int
        Which nodes lie beside the stroke.
    trace : Trace
    window : (n, w) int
        Samples among which the closest to each of these nodes is sought.
    around : (n, w, 2) float
        Their places.
    """

    nodes: Index
    trace: Trace
    window: Index
    around: Array

    def closest(self, places: Array) -> tuple[Array, Array]:
        """Closest points of the stroke, and its pressure there.

        Parameters
        ----------
        places : (n, 2) float
            Nodes of this pull, px.

        Returns
        -------
        points : (n, 2) float
        pressure : (n,) float
        """
        offset = self.around - places[:, None]
        near = np.argmin(np.einsum("nwk,nwk->nw", offset, offset), axis=1)
        sample = self.window[np.arange(len(near)), near]
        path, press = self.trace.places, self.trace.pressure
        best, pressure = path[sample], press[sample]
        least = np.einsum("nk,nk->n", best - places, best - places)
        for other in (np.maximum(sample - 1, 0), np.minimum(sample + 1, len(path) - 1)):
            step = path[other] - path[sample]
            square = np.einsum("nk,nk->n", step, step)
            share = np.einsum("nk,nk->n", places - path[sample], step)
            share = np.clip(share / np.where(square > 0, square, 1.0), 0.0, 1.0)
            foot = path[sample] + share[:, None] * step
            gap = np.einsum("nk,nk->n", foot - places, foot - places)
            nearer = gap < least
            least = np.where(nearer, gap, least)
            best = np.where(nearer[:, None], foot, best)
            at_foot = press[sample] + share * (press[other] - press[sample])
            pressure = np.where(nearer, at_foot, pressure)
        return best, pressure


def pulls_of(trace: Trace, stations: Array, ring: float | None) -> Iterator[Pull]:
    """Yield the pulls of a stroke at the nodes that lie at some stations of the curve.

    Parameters
    ----------
    trace : Trace
        The stroke, with the stretch of the curve along which it runs.
    stations : (n,) float
        Stations of the nodes, px.
    ring : float or None
        Length of a closed curve; None for an open one.
    """
    begin, end = trace.stations[0], trace.stations[-1]
    for lap in range(1 if ring is None else FEET_LAPS):
        at = stations + lap * (ring or 0.0)
        nodes = np.flatnonzero((at >= begin) & (at <= end))
        if len(nodes):
            # One more on either side: where the stroke leaves out a part of the curve, there
            # may be no sample within the window.
            low = np.searchsorted(trace.stations, at[nodes] - WINDOW, "left") - 1
            high = np.searchsorted(trace.stations, at[nodes] + WINDOW, "right")
            low, high = np.maximum(low, 0), np.minimum(high, len(trace.stations) - 1)
            steps = np.arange(int((high - low).max()) + 1)
            window = np.minimum(low[:, None] + steps, high[:, None])
            if ring is None:  # an end goes where the stroke ends that reaches it
                window[(nodes == 0) & (at[nodes] == begin)] = 0
                window[(nodes == len(at) - 1) & (at[nodes] == end)] = len(trace.places) - 1
            yield Pull(nodes, trace, window, trace.places[window])
