"""The matching of the two sides of a thing, place by place."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink import resample
from bozzetto_symmetry.stereo.correspondence import Pairing, pairing_of
from bozzetto_symmetry.stereo.dynamic_time_warping import warpings
from bozzetto_symmetry.stereo.epipolar_signal import Signal, differences, spread
from bozzetto_symmetry.stereo.mirror_camera import Stereo

SAMPLES: Final = 160
"""Places along each side that are matched."""

OPEN_END: Final = 0.01
"""Price of a sample without a partner at an end, per px of what the signals range over."""

UNEVEN: Final = 0.01
"""Price of a step along one side only, in the same unit."""

AT_ENDS: Final = 4.0
"""Distance, px, from the epipolar line of its partner at which an end may be that of a side that
was drawn whole: twice what a hand of 1 px errs by there."""

NEAR_TOP: Final = 0.1
"""How much lower than the highest turn of a loop, as a share of its range, another one may
be and still be the same place."""

MOST_CUTS: Final = 3
"""Places of the other loop at which it is tried to be cut."""


def pairings(
    stereo: Stereo,
    near: ArrayLike,
    far: ArrayLike,
    *,
    closed: bool = False,
    whole: bool = False,
) -> tuple[Pairing, ...]:
    """Match the two sides of a pair.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    near, far : (n, 2) array_like
        The sides as drawn, px, in any sense.
    closed : bool
        Both are loops; the first point is not repeated.
    whole : bool
        Open sides were drawn whole: their ends belong together, also where the epipolar lines run
        along them and the signal does not say so. Nothing where the ends contradict that.

    Returns
    -------
    tuple of Pairing
        The best first, both senses where both are possible; none where nothing matches.
    """
    one, other = (
        resample(np.asarray(side, float), count=SAMPLES, closed=closed) for side in (near, far)
    )
    if not (np.ptp(one, axis=0).any() and np.ptp(other, axis=0).any()):
        return ()
    made = _of_loops(stereo, one, other) if closed else _of_open(stereo, one, other, whole)
    kept = [pairing for pairing in made if len(pairing.near) > 1]
    return tuple(sorted(kept, key=lambda pairing: pairing.score))


def _of_open(stereo: Stereo, one: Array, other: Array, whole: bool) -> list[Pairing]:
    first = Signal.of(stereo, one)
    along = Signal.of(stereo, other).shifted(stereo, first)
    against = along.turned()
    unit = spread(first, along)
    table = differences(first, along)
    end, pinned = (np.inf, (True, True)) if whole else (OPEN_END * unit, (False, False))
    ways = warpings(np.stack([table, table[:, ::-1]]), step=UNEVEN * unit, begin=end, end=end)
    backwards = pairing_of(stereo, first, against, ways[1], pinned=pinned)
    made = [
        pairing_of(stereo, first, along, ways[0], pinned=pinned),
        replace(backwards, far_stations=1.0 - backwards.far_stations, reversed=True),
    ]
    if not whole:
        return made
    met = [abs(differences(first, each)[[0, -1], [0, -1]]).max() for each in (along, against)]
    return [each for each, off in zip(made, met, strict=True) if off < AT_ENDS]


def _of_loops(stereo: Stereo, one: Array, other: Array) -> list[Pairing]:
    """Match loops, cut where they reach furthest round: both images do so at one place."""
    count = len(one)
    cut = int(np.argmax(stereo.angles(one)))
    first = Signal.of(stereo, _cut(one, cut))
    made = []
    for sense in (1, -1):
        ring = other[::sense]
        cuts = _tops(stereo.angles(ring))
        seconds = [Signal.of(stereo, _cut(ring, k)).shifted(stereo, first) for k in cuts]
        unit = spread(first, *seconds)
        tables = np.stack([differences(first, second) for second in seconds])
        ways = warpings(tables, step=UNEVEN * unit)
        best = min(range(len(cuts)), key=lambda k: ways[k].total)
        found = pairing_of(stereo, first, seconds[best], ways[best], closed=True)
        stations = (found.stations + cut / count) % 1.0
        order = np.argsort(stations, kind="stable")
        theirs = (found.far_stations * count + cuts[best]) / count
        theirs = theirs if sense > 0 else (count - 1) / count - theirs
        made.append(
            replace(
                found,
                near=found.near[order],
                far=found.far[order],
                weak=found.weak[order],
                stations=stations[order],
                far_stations=theirs[order] % 1.0,
                reversed=sense < 0,
            )
        )
    return made


def _cut(ring: Array, place: int) -> Array:
    rolled = np.roll(ring, -place, axis=0)
    return np.vstack([rolled, rolled[:1]])


def _tops(angles: Array) -> list[int]:
    """Return local maxima that may be the highest one, the highest first."""
    higher = (angles >= np.roll(angles, 1)) & (angles > np.roll(angles, -1))
    high = angles > angles.max() - NEAR_TOP * np.ptp(angles)
    tops = np.flatnonzero(higher & high)
    if not len(tops):
        return [int(np.argmax(angles))]
    return [int(k) for k in tops[np.argsort(-angles[tops])][:MOST_CUTS]]
