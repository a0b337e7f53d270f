"""Two sides as the images of a curve and of its mirror image."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.ink.curves.resample import arc_length
from bozzetto_symmetry.ink.sides import Side, gap_between
from bozzetto_symmetry.ink.stroke_grouping import bonds_between
from bozzetto_symmetry.interpretation.candidate import TELL, Read, matched, price
from bozzetto_symmetry.interpretation.side_pairing import Pairing, pairings
from bozzetto_symmetry.interpretation.triangulation import Solved, solved
from bozzetto_symmetry.stereo.mirror_camera import Stereo

__all__ = ["as_pair", "overdrawn"]

Array = NDArray[np.float64]

SENSE: Final = 2.0
"""Weight of a matching's own score, which tells the right sense from the wrong one better than
the distances that are left do."""

ASKEW: Final = 2.0
"""Price of a loop that faces no way of the box, px, over 1 − the cosine. Loops match nearly as
well in either sense: a wheel is an upright ellipse as well. What people draw mostly faces the
side, the front or the top, and is evenly round, which the matching's own score counts."""

CONTINUED: Final = 1.0
"""Price of a pair of which one side smoothly continues the other, px: these match as well as
halves of one curve across the plane."""

MEETING: Final = 0.03
"""Widest gap of such sides, as a share of the shorter one."""

SQUARE: Final = 0.7
"""Cosine of the angle to the plane's normal at which a curve still crosses it smoothly."""

NEAR_PLANE: Final = 0.1
"""Share of a side over which its direction at the plane is taken: the crossing itself is the
place that a view knows least."""

OVERDRAWN: Final = (8.0, 4.5)
"""Mean distance, px, below which two sides may be one that was drawn twice, and the price of
taking strokes upon one another for two, px."""


def as_pair(stereo: Stereo, one: Side, other: Side, box: Array | None) -> Iterator[Read]:
    """Every way in which two sides can be a pair, at its price.

    Parameters
    ----------
    stereo : Stereo
    one, other : Side
        If only one of them is closed both are taken as open lines.
    box : (2, 3) float or None
        Least and greatest corner, in the frame of the plane, mm.
    """
    closed = one.closed and other.closed
    first, second = (side.pixels if closed else side.unrolled for side in (one, other))
    twice = overdrawn(one, other)
    told: tuple[str, ...]
    for pairing in pairings(stereo, first, second, closed=closed):
        made = solved(stereo, pairing, box)
        if len(made.points) < 2:
            continue
        missing = 1.0 - made.kept * float(np.mean(pairing.coverage))
        told = made.reasons if 1.0 - made.kept > TELL else ()
        if closed:
            near, far = first, second
        else:
            near, far = matched(first, pairing.stations), matched(second, pairing.far_stations)
            told = (
                *told,
                *_untold(pairing.stations, "first"),
                *_untold(pairing.far_stations, "second"),
            )
        yield Read(
            "pair",
            price(_misfit(pairing, made), made, missing)
            + twice
            + (0.0 if closed else _continued(stereo, first, second, made)),
            1.0 - missing,
            made.points,
            made.covariances,
            pairing,
            np.zeros((0, 2)),
            (near,),
            (far,),
            closed=closed,
            warnings=told,
        )


def _misfit(pairing: Pairing, made: Solved) -> float:
    return SENSE * pairing.score + (ASKEW * made.askew if pairing.closed else 0.0)


def overdrawn(one: Side, other: Side) -> float:
    """Price of taking two lines for two sides that run alongside one another, px."""
    bond = bonds_between([one.pixels, other.pixels])[0][1]
    widest, price = OVERDRAWN
    return price * max(0.0, 1.0 - bond.distance / widest) if bond.over else 0.0


def _continued(stereo: Stereo, one: Array, other: Array, made: Solved) -> float:
    """Price of taking two lines for a pair that meet on the plane, square to it."""
    gap, place, at_end = gap_between(one, other)
    if gap > MEETING * min(float(arc_length(line)[-1]) for line in (one, other)):
        return 0.0
    foot = stereo.on_plane(place)[0]
    line = np.vstack((foot, made.points[::-1] if at_end else made.points))
    along = arc_length(line)
    inner = int(np.searchsorted(along, NEAR_PLANE * along[-1]))
    way = line[min(inner, len(line) - 1)] - foot
    return CONTINUED if abs(way[1]) > SQUARE * float(np.linalg.norm(way)) else 0.0


def _untold(stations: Array, which: str) -> Iterator[str]:
    """What to say of the ends of a side that found no partner."""
    for place, missing in (("first", np.min(stations)), ("last", 1.0 - np.max(stations))):
        if missing > TELL:
            yield f"The {place} {100.0 * missing:.0f} % of the {which} side have no partner."
