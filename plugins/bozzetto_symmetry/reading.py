"""What the sides in one view mean: both sides of a pair, a curve across the plane, or less.

All readings are tried, and each is priced in pixels: by how far the ink contradicts it,
how much of the ink it leaves without a partner, and how strange the curve in space would be.

One stroke that folds well at a place where it runs square to the plane is a curve across it.
One stroke that does not may lie in the plane or be the first of two sides: no picture can
tell, so it waits as a half, and a person says "in the plane". Two sides are a pair, or the
halves of a curve across the plane where their ends meet, or one side that was drawn twice.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto.ink.resample import arc_length
from bozzetto_symmetry.grouping import bonds_between
from bozzetto_symmetry.pairing import Folding, Pairing, foldings, pairings
from bozzetto_symmetry.sides import Side, drawn_twice, joined
from bozzetto_symmetry.solving import Solved, solved
from bozzetto_symmetry.stereo import MIRROR, Stereo
from bozzetto_symmetry.uncertainty import plane_covariances

__all__ = ["Read", "read"]

Array = NDArray[np.float64]
Kind = Literal["pair", "self", "plane", "half"]

MISSING: Final = 20.0
"""Price of a curve of which no place has a partner, px: a tenth without costs 2."""

OUTSIDE: Final = 10.0
"""Price of a curve that is all outside the box, px."""

ASTRIDE: Final = 20.0
"""Price of a side that lies as much on one side of the plane as on the other, px."""

BUCKLED: Final = 5.0
"""Price of a loop that is as deep as it is wide, px: loops match as well in either sense, and
most of them are about flat."""

CONTINUED: Final = 1.0
"""Price of a pair of which one side smoothly continues the other, px: these match as well as
halves of one curve across the plane."""

GAP: Final = 0.35
"""Price of a pixel between halves that are taken for one curve across the plane."""

MEETING: Final = 0.03
"""Widest gap of such sides, as a share of the shorter one."""

SQUARE: Final = 0.7
"""Cosine of the angle to the plane's normal at which a curve still crosses it smoothly."""

NEAR_PLANE: Final = 0.1
"""Share of a side over which its direction at the plane is taken: the crossing itself is the
place that a view knows least."""

OVERDRAWN: Final = (8.0, 4.5)
"""Mean distance, px, below which two sides may be one that was drawn twice, and the price of
taking strokes upon one another for a pair, px."""

HALF: Final = 3.5
"""Price of leaving one side waiting, px: a fold that is off by 1.5 px with a tenth of the
stroke missing is no better."""

HAND: Final = 0.5
"""Price of a pixel of noise in what waits: a fold of rough ink cannot be better than that."""

IN_PLANE: Final = 1.5
"""Price of taking one side to be in the plane, over that of leaving it waiting."""

TWO_SIDES: Final = 25.0
"""Price of leaving a side waiting though there are two, px."""

SAME: Final = 1e-6
"""Distance from the plane, in lengths of the curve, at which a place is the crossing itself."""

TELL: Final = 0.03
"""Share of a side without a partner that a person is told of."""

KEPT: Final = 4
"""Most readings of one kind that are handed on."""


@dataclass(frozen=True, eq=False)
class Read:
    """What the ink of one view may mean.

    Attributes
    ----------
    reading : {"pair", "self", "plane", "half"}
        "half" is one side that waits for the other.
    cost : float
        How far the ink contradicts this, px; comparable between readings.
    coverage : float
        Share of the ink that has a partner; of "plane" 1 and of "half" 0.
    points : (k, 3) float
        Places in space, mm, in the sense drawn. Of a pair they run along the first side. Of
        a curve across the plane they run along all of the stroke: k is odd, the middle one
        is on the plane, and ``points[-1 - j]`` is the mirror image of ``points[j]``. Of a
        ring they begin where it first leaves the plane: k is even, number ``k / 2`` is on
        the plane as well, and ``points[k - j]`` is the mirror image of ``points[j]``.
    covariances : (k, 3, 3) float
        For 1 px of noise, mm². Where the view says nothing the one along y is large.
    pairing : Pairing or None
        Of "pair" and "self".
    crossings : (c, 2) float
        Where the curve crosses the plane, px.
    near, far : tuple of (n, 2) float
        Ink that shows the half that was drawn first, and its mirror image; px. Of a curve
        across the plane both run from the plane outwards. What has no partner is left out.
    closed : bool
        The curve returns to its start: a ring, or a pair of loops.
    ring : bool
        Closed, and across the plane.
    warnings : tuple of str
    """

    reading: Kind
    cost: float
    coverage: float
    points: Array
    covariances: Array
    pairing: Pairing | None
    crossings: Array
    near: tuple[Array, ...]
    far: tuple[Array, ...]
    closed: bool = False
    ring: bool = False
    warnings: tuple[str, ...] = ()


def read(
    stereo: Stereo,
    sides: Sequence[Side],
    asked: str = "auto",
    *,
    box: ArrayLike | None = None,
) -> tuple[Read, ...]:
    """Read the sides of one view.

    Parameters
    ----------
    stereo : Stereo
    sides : sequence of Side
        One or two (`bozzetto_symmetry.sides.sides_of`).
    asked : {"auto", "pair", "self", "plane", "half"}
        Only readings of this kind are given.
    box : (2, 3) array_like, optional
        Least and greatest corner of the box, in the frame of the plane.

    Returns
    -------
    tuple of Read
        The best first. Never empty: a half is always possible.

    Raises
    ------
    UserError
        If the sides cannot be what is asked; it says why.
    """
    if not sides:
        raise UserError("There is no ink to read. Draw a curve.")
    corners = None if box is None else np.asarray(box, float)
    single = sides[0] if len(sides) == 1 else drawn_twice(sides[0], sides[1])
    halves = joined(sides[0], sides[1]) if len(sides) > 1 else None
    found: list[Read] = []
    if asked in ("auto", "pair") and len(sides) > 1:
        found += _best(_pairs(stereo, sides[0], sides[1], corners))
    if asked in ("auto", "self"):
        across = list(_across(stereo, single, corners)) if single else []
        if halves:
            gap = _gap(sides[0].pixels, sides[1].pixels)[0]
            across += [
                replace(one, cost=one.cost + GAP * gap) for one in _across(stereo, halves, corners)
            ]
        found += _best(across)
    whole = single or halves
    if asked in ("auto", "plane") and whole is not None:
        found += _in_plane(stereo, whole)
    if asked in ("auto", "half"):
        found.append(_half(sides, single))
    if not found:
        raise UserError(_impossible(asked, sides))
    return tuple(sorted(found, key=lambda one: one.cost))


def _best(readings: Iterable[Read]) -> list[Read]:
    return sorted(readings, key=lambda one: one.cost)[:KEPT]


def _impossible(asked: str, sides: Sequence[Side]) -> str:
    if asked == "pair":
        if len(sides) == 1:
            return "There is only one side. Draw the other one too, or choose another reading."
        return "The two sides do not match anywhere. Draw the second one again."
    if len(sides) > 1:
        return "The two sides do not meet. Draw the curve in one stroke, or choose another reading."
    if asked == "plane":
        return "From here the centre plane is seen edge-on. Turn the view and draw the curve again."
    return "The stroke nowhere crosses the plane. Draw it across, or draw the other side too."


# -- a pair ------------------------------------------------------------------------------------


def _pairs(stereo: Stereo, one: Side, other: Side, box: Array | None) -> Iterator[Read]:
    closed = one.closed and other.closed
    first, second = (side.pixels if closed else _unrolled(side) for side in (one, other))
    overdrawn = _overdrawn(one, other)
    told: tuple[str, ...]
    for pairing in pairings(stereo, first, second, closed=closed):
        made = solved(stereo, pairing, box)
        if len(made.points) < 2:
            continue
        missing = 1.0 - made.kept * float(np.mean(pairing.coverage))
        if closed:
            near, far, told = first, second, ()
        else:
            near, far = _matched(first, pairing.stations), _matched(second, pairing.far_stations)
            told = (
                *_untold(pairing.stations, "first"),
                *_untold(pairing.far_stations, "second"),
            )
        yield Read(
            "pair",
            pairing.cost
            + MISSING * missing
            + _strangeness(made, closed)
            + overdrawn
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


def _unrolled(side: Side) -> Array:
    """A side as an open line."""
    return np.vstack((side.pixels, side.pixels[:1])) if side.closed else side.pixels


def _strangeness(made: Solved, closed: bool) -> float:
    return (
        OUTSIDE * made.outside
        + ASTRIDE * made.astride
        + (BUCKLED * made.buckled if closed else 0.0)
    )


def _overdrawn(one: Side, other: Side) -> float:
    """Price of taking two lines for a pair that run alongside one another."""
    bond = bonds_between([one.pixels, other.pixels])[0][1]
    widest, price = OVERDRAWN
    return price * max(0.0, 1.0 - bond.distance / widest) if bond.over else 0.0


def _continued(stereo: Stereo, one: Array, other: Array, made: Solved) -> float:
    """Price of taking two lines for a pair that meet on the plane, square to it."""
    gap, place, at_end = _gap(one, other)
    if gap > MEETING * min(float(arc_length(line)[-1]) for line in (one, other)):
        return 0.0
    foot = stereo.on_plane(place)[0]
    line = np.vstack((foot, made.points[::-1] if at_end else made.points))
    along = arc_length(line)
    inner = int(np.searchsorted(along, NEAR_PLANE * along[-1]))
    way = line[min(inner, len(line) - 1)] - foot
    return CONTINUED if abs(way[1]) > SQUARE * float(np.linalg.norm(way)) else 0.0


def _gap(one: Array, other: Array) -> tuple[float, Array, bool]:
    """How near two lines' ends come, where, and whether it is the last end of the first."""
    first, second = one[[0, -1]], other[[0, -1]]
    gaps = np.linalg.norm(first[:, None] - second, axis=2)
    which, that = np.unravel_index(int(gaps.argmin()), gaps.shape)
    return float(gaps.min()), 0.5 * (first[which] + second[that]), bool(which)


def _matched(pixels: Array, stations: Array) -> Array:
    """The part of a line that found partners."""
    begin, end = float(np.min(stations)), float(np.max(stations))
    along = arc_length(pixels)
    share = along / max(float(along[-1]), 1e-300)
    inner = (share > begin) & (share < end)
    ends = np.column_stack([np.interp((begin, end), share, column) for column in pixels.T])
    return np.vstack((ends[:1], pixels[inner], ends[1:]))


def _untold(stations: Array, which: str) -> Iterator[str]:
    """What to say of the ends of a side that found no partner."""
    for place, missing in (("first", np.min(stations)), ("last", 1.0 - np.max(stations))):
        if missing > TELL:
            yield f"The {place} {100.0 * missing:.0f} % of the {which} side have no partner."


# -- a curve across the plane --------------------------------------------------------------------


def _across(stereo: Stereo, whole: Side, box: Array | None) -> Iterator[Read]:
    ways = [(whole.pixels, True), (_unrolled(whole), False)] if whole.closed else []
    for pixels, ring in ways or [(whole.pixels, False)]:
        for folding in foldings(stereo, pixels, closed=ring):
            found = _folded(stereo, folding, pixels, ring, box)
            if found is not None:
                yield found


def _folded(
    stereo: Stereo, folding: Folding, pixels: Array, ring: bool, box: Array | None
) -> Read | None:
    pairing = folding.pairing
    made = solved(stereo, pairing, box)
    middle = stereo.on_plane(folding.crossings)
    if len(made.points) < 2 or not np.isfinite(middle).all():
        return None
    near, far, missing = _halved(pixels, folding, ring)
    missing = 1.0 - made.kept * (1.0 - missing)
    points, covariances = _whole(
        made, middle, plane_covariances(stereo, folding.crossings), folding.first, ring
    )
    told: tuple[str, ...] = ()
    if missing > TELL:
        told = (f"{100.0 * missing:.0f} % of the curve across the plane have no partner.",)
    return Read(
        "self",
        pairing.cost + MISSING * missing + _strangeness(made, False),
        1.0 - missing,
        points,
        covariances,
        pairing,
        folding.crossings,
        (near,),
        (far,),
        closed=ring,
        ring=ring,
        warnings=told,
    )


def _halved(pixels: Array, folding: Folding, ring: bool) -> tuple[Array, Array, float]:
    """The ink of the near and of the far half, and the share of all of it without a partner."""
    places = [
        int(np.argmin(np.linalg.norm(pixels - crossing, axis=1))) for crossing in folding.crossings
    ]
    if ring:
        begin, end = places[0], places[-1]
        turned = np.roll(pixels, -begin, axis=0)
        count = (end - begin) % len(pixels)
        one = np.vstack((folding.crossings[0], turned[1:count], folding.crossings[-1]))
        other = np.vstack((folding.crossings[-1], turned[count + 1 :], folding.crossings[0]))[::-1]
        middle = folding.pairing.near[len(folding.pairing.near) // 2]
        nearer = [float(np.linalg.norm(half - middle, axis=1).min()) for half in (one, other)]
        near, far = (one, other) if nearer[0] <= nearer[1] else (other, one)
        return near, far, 1.0 - float(np.mean(folding.pairing.coverage))
    cut = places[0]
    before = np.vstack((folding.crossings[0], pixels[:cut][::-1]))
    behind = np.vstack((folding.crossings[0], pixels[cut + 1 :]))
    near, far = (before, behind) if folding.first else (behind, before)
    lengths = [float(arc_length(half)[-1]) for half in (near, far)]
    covered = float(np.dot(lengths, folding.pairing.coverage)) / max(sum(lengths), 1e-300)
    stations = np.append(folding.pairing.stations, 0.0)
    far_stations = np.append(folding.pairing.far_stations, 0.0)
    return _matched(near, stations), _matched(far, far_stations), 1.0 - min(covered, 1.0)


def _whole(
    made: Solved, middle: Array, flat: Array, first: bool, ring: bool
) -> tuple[Array, Array]:
    """The curve and its mirror image in one line, in the sense drawn."""
    own = np.linalg.norm(made.points[:, None] - middle, axis=2).min(axis=1)
    apart = own > SAME * float(np.linalg.norm(np.ptp(made.points, axis=0)))
    points, spread = made.points[apart], made.covariances[apart]
    flip = np.diag(MIRROR)
    mirrored, turned = points * MIRROR, flip @ spread @ flip
    if ring:
        return (
            np.vstack((middle[:1], points, middle[-1:], mirrored[::-1])),
            np.concatenate((flat[:1], spread, flat[-1:], turned[::-1])),
        )
    if first:
        points, spread, mirrored, turned = mirrored, turned, points, spread
    return (
        np.vstack((mirrored[::-1], middle, points)),
        np.concatenate((turned[::-1], flat, spread)),
    )


# -- one side ------------------------------------------------------------------------------------


def _in_plane(stereo: Stereo, whole: Side) -> list[Read]:
    points = stereo.on_plane(whole.pixels)
    seen = np.isfinite(points).all(axis=1)
    if seen.sum() < 2 or not seen.mean() > 0.5:
        return []
    told = () if seen.all() else ("Part of the stroke does not meet the centre plane.",)
    return [
        Read(
            "plane",
            IN_PLANE * _waiting(whole),
            1.0,
            points[seen],
            plane_covariances(stereo, whole.pixels[seen]),
            None,
            np.zeros((0, 2)),
            (whole.pixels[seen],),
            (),
            closed=whole.closed and bool(seen.all()),
            warnings=told,
        )
    ]


def _half(sides: Sequence[Side], single: Side | None) -> Read:
    nothing = np.zeros((0, 3)), np.zeros((0, 3, 3)), None, np.zeros((0, 2))
    if single is None:
        near, far = ((side.pixels,) for side in sides)
        told = ("The two sides do not match: each waits for its partner.",)
        return Read("half", TWO_SIDES, 0.0, *nothing, near, far, warnings=told)
    return Read("half", _waiting(single), 0.0, *nothing, (single.pixels,), (), single.closed)


def _waiting(side: Side) -> float:
    """Price of leaving a side waiting: what the hand wavers makes worse folds likely."""
    return HALF + HAND * side.noise
