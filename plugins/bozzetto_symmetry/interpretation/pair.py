"""Two sides read as the images of a curve and of its mirror image."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import arc_length
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.ink.sides import Side, gap_between
from bozzetto_symmetry.ink.stroke_grouping import bonds_between
from bozzetto_symmetry.interpretation.candidate import TELL, Candidate, Read, matched_part, price
from bozzetto_symmetry.interpretation.line_weight import weight_prices
from bozzetto_symmetry.interpretation.partial_pairing import partial_pairings
from bozzetto_symmetry.interpretation.side_pairing import pairings
from bozzetto_symmetry.interpretation.stereo_triangulation import HalfInSpace, triangulate
from bozzetto_symmetry.stereo.correspondence import Pairing
from bozzetto_symmetry.stereo.mirror_camera import Stereo

SENSE: Final = 2.0
"""Weight of a matching's own score, which finds the right sense more reliably than the distances
that are left."""

ASKEW: Final = 0.4
"""Price of a loop that faces no axis of the box, px, over 1 − the cosine. Loops match nearly as
well in either sense: a wheel is an upright ellipse as well. What people draw mostly faces the
side, the front or the top, and is neither much longer than wide nor deep.

This and the prices that follow are logarithms of odds, five for a pixel: a logistic regression over
924 drawings of loops, of which a quarter face anywhere."""

SQUARELY: Final = (0.92, 0.01)
"""Price of a loop that does not squarely face an axis, px, and over which 1 − the cosine: by chance
hardly any loop does, so one that does is meant to."""

SLENDER: Final = 0.89
"""Price of a loop that is longer than wide, px over the logarithm of that: in the wrong sense what
is wide changes places with what is deep."""

LARGE: Final = 0.88
"""Price of the sense in which a loop is larger, px over the logarithm of that: it reaches farther
into the depth than anything on the sheet asks for."""

BENT: Final = 0.48
"""Price of a loop that does not lie in a plane, px. In the wrong sense only an ellipse is flat;
what else people draw mostly is."""

FLAT: Final = (1.0, 1.7)
"""How far (rms, in errors of a hand of 1 px) places are off their plane up to which a loop is
flat, and from which it is not: in the right sense they are by 0.9, in the wrong one by 1.6 to 5."""

BEGUN: Final = (0.47, 0.06)
"""Price of two loops begun at places that do not belong together, px, and how far apart, in turns,
places may be that do. People mostly begin the second side where they began the first; a loop begun
elsewhere pays in both senses."""

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

IN_PART: Final = 3.0
"""Price of a side of which nearly nothing was drawn, px, if what was drawn matches a stretch of
the other one."""

SURE_PART: Final = 2.4
"""Price, px, up to which all of one side matches a stretch of the other: sides of different curves
mostly cost more, whatever the stretch, and a true part costs 2.3 at most (1 px of tremor)."""

OVERDRAWN: Final = (8.0, 4.5)
"""Mean distance, px, below which two sides may be one that was drawn twice, and the price of
taking strokes upon one another for two, px."""


def as_pair(stereo: Stereo, one: Side, other: Side) -> Iterator[Candidate]:
    """Yield every way in which two sides can be a pair.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    one, other : Side
        The sides; if only one of them is closed both are taken as open lines.
    """
    closed = one.closed and other.closed
    once = len(one.strokes) == len(other.strokes) == 1
    lines = one.pixels if closed else one.unrolled, other.pixels if closed else other.unrolled
    twice = overdrawn(one, other)
    # Sides that meet may be halves of one curve as well, which are whole for certain.
    apart = not closed and gap_between(*lines)[0] > MEETING * min(map(length_of, lines))
    whole = pairings(stereo, *lines, whole=True) if apart else ()
    found = (*whole, *pairings(stereo, *lines, closed=closed))
    halves = [triangulate(stereo, pairing) for pairing in found]
    light = weight_prices(stereo, found, one, other) if closed else (0.0,) * len(found)
    least = min((half.extent for half in halves if half.extent > 0.0), default=1.0)
    for pairing, half, lightly in zip(found, halves, light, strict=True):
        if len(half.points) > 1:
            extra = twice + lightly + (_begun(pairing) if closed and once else 0.0)
            if closed:
                extra += LARGE * float(np.log(max(half.extent / least, 1.0)))
            yield Candidate(half, partial(_read, stereo, pairing, lines, extra))
    for pairing in () if closed else partial_pairings(stereo, *lines):
        half = triangulate(stereo, pairing)
        if len(half.points) > 1 and _price(pairing, half) < SURE_PART:
            yield Candidate(half, partial(_read, stereo, pairing, lines, twice))


def _price(pairing: Pairing, half: HalfInSpace) -> float:
    """Return what a matching costs over the parts of the sides that were matched, px."""
    covered = np.divide(pairing.coverage, pairing.part)
    misfit = SENSE * pairing.score
    if pairing.closed:
        bent = float(np.interp(half.off_plane, FLAT, (0.0, 1.0)))
        most, near = SQUARELY
        aslant = 1.0 - float(np.exp(-half.askew / near))
        misfit += ASKEW * half.askew + most * aslant + BENT * bent + SLENDER * half.slender
    return price(misfit, half, 1.0 - half.kept * float(np.mean(covered)))


def _begun(pairing: Pairing) -> float:
    """Return the price of loops that were begun at places that the matching takes apart, px."""
    most, near = BEGUN
    first = int(np.argmin(np.minimum(pairing.stations, 1.0 - pairing.stations)))
    gap = abs((float(pairing.far_stations[first]) + 0.5) % 1.0 - 0.5)
    return most * (1.0 - float(np.exp(-0.5 * (gap / near) ** 2)))


def _read(
    stereo: Stereo,
    pairing: Pairing,
    lines: tuple[Array, Array],
    extra: float,
    half: HalfInSpace,
) -> Read:
    missing = 1.0 - half.kept * float(np.mean(pairing.coverage))
    rest = 1.0 - min(pairing.part)
    cost = _price(pairing, half) + IN_PART * rest + extra
    warnings = half.reasons if 1.0 - half.kept > TELL else ()
    near, far = lines
    if not pairing.closed:
        cost += _continued(stereo, *lines, half)
        near = matched_part(near, pairing.stations)
        far = matched_part(far, pairing.far_stations)
        warnings = (
            *warnings,
            *_unmatched(pairing.stations, "first", pairing.part[0]),
            *_unmatched(pairing.far_stations, "second", pairing.part[1]),
        )
    return Read(
        "pair", cost, 1.0 - missing, half.points, half.covariances, pairing, np.zeros((0, 2)),
        (near,), (far,), closed=pairing.closed, rest=rest, warnings=warnings,
    )  # fmt: skip


def overdrawn(one: Side, other: Side) -> float:
    """Return the price of taking two lines that run alongside one another for two sides, px."""
    bond = bonds_between([one.pixels, other.pixels])[0][1]
    widest, price = OVERDRAWN
    return price * max(0.0, 1.0 - bond.distance / widest) if bond.over else 0.0


def _continued(stereo: Stereo, one: Array, other: Array, half: HalfInSpace) -> float:
    """Return the price of taking two lines for a pair that meet on the plane, square to it."""
    gap, place, at_end = gap_between(one, other)
    if gap > MEETING * min(map(length_of, (one, other))):
        return 0.0
    foot = stereo.on_plane(place)[0]
    line = np.vstack((foot, half.points[::-1] if at_end else half.points))
    along = arc_length(line)
    inner = int(np.searchsorted(along, NEAR_PLANE * along[-1]))
    way = line[min(inner, len(line) - 1)] - foot
    return CONTINUED if abs(way[1]) > SQUARE * float(np.linalg.norm(way)) else 0.0


def _unmatched(stations: Array, which: str, part: float) -> Iterator[str]:
    """Yield sentences about the ends of a side that found no partner."""
    waits = "" if part == 1.0 else ": they wait for it"
    for place, missing in (("first", np.min(stations)), ("last", 1.0 - np.max(stations))):
        if missing > TELL:
            share = f"The {place} {100.0 * missing:.0f} % of the {which} side"
            yield f"{share} has no counterpart{waits}."
