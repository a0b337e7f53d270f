"""One line as a curve across the centre plane, folded where it crosses."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.ink.sides import Side
from bozzetto_symmetry.ink.stroke_line import calmest_noise
from bozzetto_symmetry.interpretation.candidate import TELL, Candidate, Read, matched_part, price
from bozzetto_symmetry.interpretation.flat_crossing import flattened
from bozzetto_symmetry.interpretation.folding import Folding, foldings
from bozzetto_symmetry.interpretation.simple_form import SimpleForm
from bozzetto_symmetry.interpretation.stereo_triangulation import HalfInSpace, triangulate
from bozzetto_symmetry.interpretation.straight_crossing import as_bar, is_bowed
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import plane_covariances

NEEDLESS: Final = 0.7
"""Price of a curve that is bent more than the ink asks for, px, beside a simpler one: what the two
halves of a careful hand stray by."""

LIKELY: Final = 1.7
"""Price of a simpler curve, px, up to which a hand may well have meant it."""

TREMBLING: Final = (0.2, 0.005)
"""Tremor that can be told, px, from which on a hand errs by so much: of all of a line, and of its
calmest places. Ink that is steadier by both means what it shows."""

SAME: Final = 1e-6
"""Distance from the plane, in lengths of the curve, at which a place is the crossing itself."""


def as_crossing(stereo: Stereo, side: Side, more: float = 0.0) -> Iterator[Candidate]:
    """Yield every way in which a side can be a curve across the plane.

    A closed side is a ring; where it can be none, it may be a line whose ends happen to be
    seen near one another.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    side : Side
        The line that is folded.
    more : float
        Price that every reading of it bears, px.
    """
    bars = () if side.closed else tuple(as_bar(stereo, side.pixels, more))
    yield from bars
    found = _folded(stereo, side.pixels, True) if side.closed else []
    ring = bool(found)
    pixels = side.pixels if ring else side.unrolled
    found = found or _folded(stereo, pixels, False)
    straight = bool(bars) and not is_bowed(pixels)
    # A curve that is free to bend follows the tremor: coming nearer to the ink than a simpler one
    # that a hand may well have meant is no merit.
    dear = more + (NEEDLESS if straight else 0.0)
    least = bars[0].whole.cost + NEEDLESS if straight else 0.0
    level = [
        Candidate(apart, partial(_read, stereo, flat, pixels, ring, (dear, least), form))
        for folding, half in found
        for flat, apart, form in flattened(stereo, folding, half, pixels, ring, straight)
    ]
    yield from level
    simpler = [*bars, *level]
    dear = more + (NEEDLESS if simpler else 0.0)
    meant = more + LIKELY * _trembling(side.noise, pixels, ring)
    likely = [one.whole.cost for one in simpler if one.whole.cost <= meant]
    least = min(likely, default=0.0) + dear
    for folding, half in found:
        yield Candidate(half, partial(_read, stereo, folding, pixels, ring, (dear, least), None))


def _trembling(noise: float, pixels: Array, ring: bool) -> float:
    """Return how surely a line was drawn by a hand: 1, or less for ink that is steadier."""
    told = noise, calmest_noise(pixels, closed=ring)
    return max(min(1.0, each / enough) for each, enough in zip(told, TREMBLING, strict=True))


def _folded(stereo: Stereo, pixels: Array, ring: bool) -> list[tuple[Folding, HalfInSpace]]:
    """Return every way to fold a line that gives a curve, with its half in space."""
    made = [
        (folding, triangulate(stereo, folding.pairing))
        for folding in foldings(stereo, pixels, closed=ring)
    ]
    return [
        (folding, half)
        for folding, half in made
        if len(half.points) > 1 and np.isfinite(stereo.on_plane(folding.crossings)).all()
    ]


def _read(
    stereo: Stereo,
    folding: Folding,
    pixels: Array,
    ring: bool,
    costs: tuple[float, float],
    form: SimpleForm | None,
    half: HalfInSpace,
) -> Read:
    pairing = folding.pairing
    if ring:
        near, far, turned = _ring_halves(pixels, folding)
        covered = float(np.mean(pairing.coverage))
    else:
        near, far, covered = _halves(pixels, folding)
        turned = not folding.first
    missing = 1.0 - half.kept * min(covered, 1.0)
    middle = stereo.on_plane(folding.crossings)
    flat = plane_covariances(stereo, folding.crossings)
    points, covariances = _whole(half, middle, flat, turned, ring)
    warnings: tuple[str, ...] = ()
    if missing > TELL:
        warnings = (f"{100.0 * missing:.0f} % of the curve across the plane has no counterpart.",)
    more, least = costs
    cost = max(price(pairing.cost, half, missing) + more, least)
    return Read(
        "self", cost, 1.0 - missing, points, covariances, pairing, folding.crossings,
        (near,), (far,), closed=ring, ring=ring, form=form, warnings=warnings,
    )  # fmt: skip


def _place(pixels: Array, crossing: Array) -> int:
    return int(np.argmin(np.linalg.norm(pixels - crossing, axis=1)))


def _halves(pixels: Array, folding: Folding) -> tuple[Array, Array, float]:
    """Return the ink on both sides of the crossing, outwards, and the share with a partner."""
    pairing, foot = folding.pairing, folding.crossings[:1]
    cut = _place(pixels, foot[0])
    halves = np.vstack((foot, pixels[:cut][::-1])), np.vstack((foot, pixels[cut + 1 :]))
    stations, coverage = [pairing.stations, pairing.far_stations], list(pairing.coverage)
    if not folding.first:
        stations.reverse()
        coverage.reverse()
    lengths = [length_of(half) for half in halves]
    covered = float(np.dot(lengths, coverage)) / max(sum(lengths), 1e-300)
    before, behind = (
        matched_part(half, np.append(share, 0.0))
        for half, share in zip(halves, stations, strict=True)
    )
    return before, behind, covered


def _ring_halves(pixels: Array, folding: Folding) -> tuple[Array, Array, bool]:
    """Return both halves of a ring, and whether the half drawn first is the far one."""
    begin, end = (_place(pixels, crossing) for crossing in folding.crossings)
    turned = np.roll(pixels, -begin, axis=0)
    count = (end - begin) % len(pixels)
    first, last = folding.crossings
    one = np.vstack((first, turned[1:count], last))
    other = np.vstack((last, turned[count + 1 :], first))[::-1]
    middle = folding.pairing.near[len(folding.pairing.near) // 2]
    to_one, to_other = (float(np.linalg.norm(half - middle, axis=1).min()) for half in (one, other))
    return one, other, to_other < to_one


def _whole(
    half: HalfInSpace, middle: Array, flat: Array, turned: bool, ring: bool
) -> tuple[Array, Array]:
    """Return the curve and its mirror image in one line, in the sense drawn.

    Parameters
    ----------
    half : HalfInSpace
        One half of the curve in space.
    middle, flat : (c, 3) and (c, 3, 3) float
        Where the curve crosses the plane, and the covariances there.
    turned : bool
        The half that was drawn first is the mirror image of what was solved.
    ring : bool
        The curve is closed.
    """
    own = np.linalg.norm(half.points[:, None] - middle, axis=2).min(axis=1)
    apart = own > SAME * float(np.linalg.norm(np.ptp(half.points, axis=0)))
    points, spread = half.points[apart], half.covariances[apart]
    flip = np.diag(MIRROR)
    mirrored, reflected = points * MIRROR, flip @ spread @ flip
    if turned:
        points, spread, mirrored, reflected = mirrored, reflected, points, spread
    if ring:
        return (
            np.vstack((middle[:1], points, middle[-1:], mirrored[::-1])),
            np.concatenate((flat[:1], spread, flat[-1:], reflected[::-1])),
        )
    return (
        np.vstack((points[::-1], middle, mirrored)),
        np.concatenate((spread[::-1], flat, reflected)),
    )
