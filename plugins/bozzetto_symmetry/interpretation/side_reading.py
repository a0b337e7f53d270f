"""The meaning of the sides in one view: a pair, a curve across the plane, or less.

All readings are tried, and each is priced in pixels: by how far the ink contradicts it,
how much of the ink it leaves without a partner, and how strange the curve in space would be.

One stroke that folds well at a place where it runs square to the plane is a curve across it.
One stroke that does not may lie in the plane or be the first of two sides: no picture can
say which, so it waits as a half, and a person says "in the plane". Two sides are a pair, or the
halves of a curve across the plane where their ends meet, or one side that was drawn twice.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.ink import distances_to_polyline
from bozzetto.plugin import cached_property
from bozzetto_symmetry.ink.sides import Side, gap_between, join_ends, merge_alongside
from bozzetto_symmetry.interpretation.candidate import Candidate, Read
from bozzetto_symmetry.interpretation.pair import as_pair, overdrawn
from bozzetto_symmetry.interpretation.round_loop import is_wheel
from bozzetto_symmetry.interpretation.self_symmetric import as_crossing
from bozzetto_symmetry.interpretation.stereo_triangulation import strays
from bozzetto_symmetry.stereo.degeneracies import Case, reasons_of, special_case
from bozzetto_symmetry.stereo.mirror_camera import Stereo
from bozzetto_symmetry.stereo.uncertainty import plane_covariances

HALF: Final = 3.5
"""Price of leaving one side waiting, px: a fold that is off by 1.5 px with a tenth of the
stroke missing is no better."""

HAND: Final = 0.5
"""Price of a pixel of noise in ink that waits: a fold of rough ink cannot be better."""

IN_PLANE: Final = (0.9, 1.5)
"""Price of taking one side to be in the plane, over that of leaving it waiting: where all of
it would be in the box, and where not. Seen at an angle, a side that stands away from the plane
is mostly shifted out of the box; three of four sides of recorded ink are."""

IN_BOX: Final = 0.02
"""Share of the box's size by which a curve in the plane may leave it."""

TWO_SIDES: Final = 25.0
"""Price of leaving sides waiting although there are two, px."""

WHEEL: Final = 0.8
"""Price of a loop that is round along the plane, in that of the best ring across."""

GAP: Final = 0.35
"""Price of a pixel of gap between halves that are read as one curve across the plane."""

MET: Final = 3.0
"""Gap, px, above which ends that are seen near one another need not have been drawn to meet."""

ALIKE: Final = 0.02
"""Median distance, in lengths of the curve, below which two readings are one and the same."""

KEPT: Final = 4
"""Most readings of one kind that are returned."""

UNMATCHED: Final = "The two sides do not match: each waits for its partner."
PARTLY: Final = "Part of the stroke does not meet the centre plane."


def read(
    stereo: Stereo,
    sides: Sequence[Side],
    asked: str = "auto",
    *,
    box: ArrayLike | None = None,
) -> tuple[Read, ...]:
    """Read the sides of one view, the best reading first.

    The parameters are those of `Reader` and of `Reader.read`.
    """
    return Reader(stereo, sides).read(asked, None if box is None else np.asarray(box, float))


class Reader:
    """The sides of one view and all that they may mean.

    What the box does not change is worked out once, when it is first asked for.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    sides : sequence of Side
        One or two (`bozzetto_symmetry.ink.sides.sides_of`).

    Raises
    ------
    UserError
        If there are no sides.
    """

    def __init__(self, stereo: Stereo, sides: Sequence[Side]) -> None:
        if not sides:
            raise UserError("There is no ink to read. Draw a curve.")
        self._stereo = stereo
        self._sides = tuple(sides)
        self._differences: dict[tuple[object, object], bool] = {}

    def read(self, asked: str, box: Array | None) -> tuple[Read, ...]:
        """Read the sides beside a box.

        Parameters
        ----------
        asked : {"auto", "pair", "self", "plane", "half"}
            Only readings of this kind are given.
        box : (2, 3) float or None
            Least and greatest corner of the box, in the frame of the plane, mm.

        Returns
        -------
        tuple of Read
            The best first. Never empty: a half is always possible.

        Raises
        ------
        UserError
            If the sides cannot be what is asked; it says why.
        """
        found: list[Read] = []
        if asked in ("auto", "pair"):
            found += self._best(self._pairs, box)
        crossings = self._best(self._crossings, box) if asked in ("auto", "self") else []
        found += crossings
        lone: list[Read] = []
        if asked in ("auto", "plane") and self._in_plane is not None:
            lone += self._in_plane.in_box(box)
        if asked in ("auto", "half"):
            lone.append(self._half)
        if crossings and len(lone) > 1 and is_wheel(lone[0], crossings):
            # It fits across the plane as well, as every ellipse does.
            meant = min(lone, key=lambda one: one.cost)
            cost = WHEEL * min(each.cost for each in crossings)
            lone = [replace(each, cost=cost) if each is meant else each for each in lone]
        found += lone
        if not found:
            raise UserError(_impossible(asked, self._sides))
        return tuple(sorted(found, key=lambda one: one.cost))

    @cached_property
    def _single(self) -> Side | None:
        """All ink as one side, where it may be one."""
        return self._sides[0] if len(self._sides) == 1 else merge_alongside(*self._sides)

    @cached_property
    def _joined(self) -> Side | None:
        """Two sides as halves of one line, where their ends meet."""
        return join_ends(*self._sides) if len(self._sides) > 1 else None

    @cached_property
    def _pairs(self) -> tuple[Candidate, ...]:
        return tuple(as_pair(self._stereo, *self._sides)) if len(self._sides) > 1 else ()

    @cached_property
    def _crossings(self) -> tuple[Candidate, ...]:
        found = [] if self._single is None else [*as_crossing(self._stereo, self._single)]
        if self._joined is not None:
            one, other = self._sides
            gap = gap_between(one.pixels, other.pixels)[0]
            # Ends that meet say themselves that these are halves, and no line drawn twice.
            more = GAP * gap + overdrawn(one, other) * min(1.0, gap / MET)
            found += as_crossing(self._stereo, self._joined, more)
        return tuple(found)

    @cached_property
    def _in_plane(self) -> _InPlane | None:
        whole = self._single or self._joined
        return None if whole is None else _InPlane.of(self._stereo, whole)

    @cached_property
    def _half(self) -> Read:
        nothing = np.zeros((0, 3)), np.zeros((0, 3, 3)), None, np.zeros((0, 2))
        single = self._single
        if single is None:
            near, far = ((side.pixels,) for side in self._sides)
            warnings = _blind(self._stereo) or (UNMATCHED,)
            return Read("half", TWO_SIDES, 0.0, *nothing, near, far, warnings=warnings)
        return Read("half", _waiting(single), 0.0, *nothing, (single.pixels,), (), single.closed)

    def _best(self, candidates: Iterable[Candidate], box: Array | None) -> list[Read]:
        """Return the cheapest readings of a kind that put the curve in different places."""
        kept: list[Read] = []
        for one in sorted((each.in_box(box) for each in candidates), key=lambda one: one.cost):
            if len(kept) < KEPT and all(self._differ(one, better) for better in kept):
                kept.append(one)
        return kept

    def _differ(self, one: Read, other: Read) -> bool:
        """Return whether two readings put the curve in different places."""
        if one.source[1] or other.source[1]:  # the box has left out strays
            return _are_apart(one, other)
        pair = one.source[0], other.source[0]
        if pair not in self._differences:
            self._differences[pair] = _are_apart(one, other)
        return self._differences[pair]


def _are_apart(one: Read, other: Read) -> bool:
    extent = float(np.linalg.norm(np.ptp(other.points, axis=0)))
    apart = distances_to_polyline(one.points, other.points)
    return one.ring != other.ring or float(np.median(apart)) > ALIKE * extent


@dataclass(frozen=True, eq=False)
class _InPlane:
    """A line in the centre plane, whatever the box.

    Attributes
    ----------
    whole : Side
    met : (n,) bool
        Places whose rays meet the plane in front of the eye.
    points : (m, 3) float
        Where these rays meet it, mm.
    covariances : (m, 3, 3) float
        For 1 px of noise, mm².
    """

    whole: Side
    met: Flags
    points: Array
    covariances: Array

    @classmethod
    def of(cls, stereo: Stereo, whole: Side) -> _InPlane:
        points = stereo.on_plane(whole.pixels)
        met = np.asarray(np.isfinite(points).all(axis=1))
        return cls(whole, met, points[met], plane_covariances(stereo, whole.pixels[met]))

    def in_box(self, box: Array | None) -> list[Read]:
        """Return the reading, or nothing where too little of the line meets the plane."""
        keep = ~strays(self.points, box)
        seen = self.met.copy()
        seen[seen] = keep
        if seen.sum() < 2 or not seen.mean() > 0.5:
            return []
        whole, everywhere = self.whole, bool(seen.all())
        inside, beyond = IN_PLANE
        share = inside if everywhere and _inside(self.points, box) else beyond
        return [
            Read(
                "plane", share * _waiting(whole), 1.0, self.points[keep], self.covariances[keep],
                None, np.zeros((0, 2)), (whole.pixels[seen],), (),
                closed=whole.closed and everywhere,
                warnings=() if everywhere else (PARTLY,),
                source=(self, keep.tobytes()),
            )
        ]  # fmt: skip


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


def _inside(points: Array, box: Array | None) -> bool:
    if box is None:
        return False
    room = IN_BOX * (box[1] - box[0])
    return bool(((points >= box[0] - room) & (points <= box[1] + room)).all())


def _blind(stereo: Stereo) -> tuple[str, ...]:
    """Return why a view as a whole shows no depth, and what to do; nothing if it does."""
    middle = np.multiply(stereo.camera.viewport, 0.5)[None]
    codes = special_case(stereo, middle, middle)
    whole = codes[0] == Case.EYE_ON_PLANE or stereo.parallel
    return reasons_of(codes) if whole else ()


def _waiting(side: Side) -> float:
    """Return the price of leaving a side waiting: a wavering hand makes worse folds likely."""
    return HALF + HAND * side.noise
