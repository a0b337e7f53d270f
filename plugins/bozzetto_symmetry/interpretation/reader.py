"""What the sides in one view mean: both sides of a pair, a curve across the plane, or less.

All readings are tried, and each is priced in pixels: by how far the ink contradicts it,
how much of the ink it leaves without a partner, and how strange the curve in space would be.

One stroke that folds well at a place where it runs square to the plane is a curve across it.
One stroke that does not may lie in the plane or be the first of two sides: no picture can
tell, so it waits as a half, and a person says "in the plane". Two sides are a pair, or the
halves of a curve across the plane where their ends meet, or one side that was drawn twice.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto_symmetry.ink.sides import Side, drawn_twice, gap_between, joined
from bozzetto_symmetry.interpretation.candidate import Read
from bozzetto_symmetry.interpretation.pair import as_pair, overdrawn
from bozzetto_symmetry.interpretation.self_symmetric import as_crossing
from bozzetto_symmetry.interpretation.triangulation import strays
from bozzetto_symmetry.stereo.degeneracies import Case, reasons, special_case
from bozzetto_symmetry.stereo.mirror_camera import Stereo
from bozzetto_symmetry.stereo.uncertainty import plane_covariances

__all__ = ["Read", "read"]

Array = NDArray[np.float64]

HALF: Final = 3.5
"""Price of leaving one side waiting, px: a fold that is off by 1.5 px with a tenth of the
stroke missing is no better."""

HAND: Final = 0.5
"""Price of a pixel of noise in what waits: a fold of rough ink cannot be better than that."""

IN_PLANE: Final = (0.9, 1.5)
"""Price of taking one side to be in the plane, over that of leaving it waiting: where all of
it would be in the box, and where not. Seen aslant, a side that stands away from the plane is
mostly shifted out of the box; three of four sides of recorded ink are."""

IN_BOX: Final = 0.02
"""Share of the box's size by which a curve in the plane may leave it."""

TWO_SIDES: Final = 25.0
"""Price of leaving a side waiting though there are two, px."""

GAP: Final = 0.35
"""Price of a pixel between halves that are taken for one curve across the plane."""

MET: Final = 3.0
"""Gap, px, above which ends that are seen near one another need not have been drawn to meet."""

ALIKE: Final = 0.02
"""Median distance, in lengths of the curve, below which two readings are one and the same."""

KEPT: Final = 4
"""Most readings of one kind that are handed on."""


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
        One or two (`bozzetto_symmetry.ink.sides.sides_of`).
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
        found += _best(as_pair(stereo, sides[0], sides[1], corners))
    if asked in ("auto", "self"):
        across = list(as_crossing(stereo, single, corners)) if single else []
        if halves:
            gap = gap_between(sides[0].pixels, sides[1].pixels)[0]
            # Ends that meet say themselves that these are halves, and no line drawn twice.
            more = GAP * gap + overdrawn(sides[0], sides[1]) * min(1.0, gap / MET)
            folded = as_crossing(stereo, halves, corners)
            across += [replace(one, cost=one.cost + more) for one in folded]
        found += _best(across)
    whole = single or halves
    if asked in ("auto", "plane") and whole is not None:
        found += _in_plane(stereo, whole, corners)
    if asked in ("auto", "half"):
        found.append(_half(stereo, sides, single))
    if not found:
        raise UserError(_impossible(asked, sides))
    return tuple(sorted(found, key=lambda one: one.cost))


def _best(readings: Iterable[Read]) -> list[Read]:
    """The cheapest readings of a kind that put the curve in different places."""
    kept: list[Read] = []
    for one in sorted(readings, key=lambda one: one.cost):
        if len(kept) < KEPT and all(_differ(one, better) for better in kept):
            kept.append(one)
    return kept


def _differ(one: Read, other: Read) -> bool:
    extent = float(np.linalg.norm(np.ptp(other.points, axis=0)))
    apart = distances_to_polyline(one.points, other.points)
    return one.ring != other.ring or float(np.median(apart)) > ALIKE * extent


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


def _in_plane(stereo: Stereo, whole: Side, box: Array | None) -> list[Read]:
    points = stereo.on_plane(whole.pixels)
    seen = np.asarray(np.isfinite(points).all(axis=1))
    seen[seen] = ~strays(points[seen], box)
    if seen.sum() < 2 or not seen.mean() > 0.5:
        return []
    told = () if seen.all() else ("Part of the stroke does not meet the centre plane.",)
    inside, beyond = IN_PLANE
    return [
        Read(
            "plane",
            (inside if seen.all() and _inside(points, box) else beyond) * _waiting(whole),
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


def _inside(points: Array, box: Array | None) -> bool:
    if box is None:
        return False
    room = IN_BOX * (box[1] - box[0])
    return bool(((points >= box[0] - room) & (points <= box[1] + room)).all())


def _half(stereo: Stereo, sides: Sequence[Side], single: Side | None) -> Read:
    nothing = np.zeros((0, 3)), np.zeros((0, 3, 3)), None, np.zeros((0, 2))
    if single is None:
        near, far = ((side.pixels,) for side in sides)
        told = _blind(stereo) or ("The two sides do not match: each waits for its partner.",)
        return Read("half", TWO_SIDES, 0.0, *nothing, near, far, warnings=told)
    return Read("half", _waiting(single), 0.0, *nothing, (single.pixels,), (), single.closed)


def _blind(stereo: Stereo) -> tuple[str, ...]:
    """Why a view as a whole shows no depth, and what to do; nothing if it does."""
    middle = np.multiply(stereo.camera.viewport, 0.5)[None]
    codes = special_case(stereo, middle, middle)
    whole = codes[0] == Case.EYE_ON_PLANE or stereo.parallel
    return reasons(codes) if whole else ()


def _waiting(side: Side) -> float:
    """Price of leaving a side waiting: what the hand wavers makes worse folds likely."""
    return HALF + HAND * side.noise
