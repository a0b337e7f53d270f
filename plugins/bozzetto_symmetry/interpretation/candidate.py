"""The ways to read the ink of a view, and what each costs in pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import arc_length
from bozzetto.plugin import cached_property
from bozzetto_symmetry.ink.polyline import interpolate
from bozzetto_symmetry.interpretation.simple_form import SimpleForm
from bozzetto_symmetry.interpretation.stereo_triangulation import HalfInSpace, strays
from bozzetto_symmetry.stereo.correspondence import Pairing

Kind = Literal["pair", "self", "plane", "half"]

MISSING: Final = 20.0
"""Price of a curve of which no place has a partner, px: a tenth without costs 2."""

OUTSIDE: Final = 10.0
"""Price of the first of a curve that is outside the box, px for all of it."""

AT_MOST: Final = 0.6
"""Price, px, that leaving the box never exceeds: the box is a ruler, and curves may leave it. It
decides where the ink fits two readings alike, and not against the ink."""

ASTRIDE: Final = 20.0
"""Price of a side that lies as much on one side of the plane as on the other, px."""

TELL: Final = 0.03
"""Share of a side without a partner from which a warning is given."""


@dataclass(frozen=True, eq=False)
class Read:
    """One meaning of the ink of a view.

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
        Covariances of these places for 1 px of noise, mm². Where the view says nothing the
        one along y is large.
    pairing : Pairing or None
        The matching behind "pair" and "self".
    crossings : (c, 2) float
        Where the curve crosses the plane, px.
    near, far : tuple of (n, 2) float
        Ink that shows the half that was drawn first, and its mirror image; px. Of a curve
        across the plane both run from the plane outwards. Ink without a partner is left out.
    closed : bool
        The curve returns to its start: a ring, or a pair of loops.
    ring : bool
        The curve is closed and crosses the plane.
    rest : float
        Share of a side that waits, because only a part of the other side was drawn.
    form : SimpleForm or None
        What the curve is where the rays say nothing; None for as smooth as can be.
    warnings : tuple of str
        Sentences for the person.
    source : tuple
        The candidate that was read and the places that the box left out of it. Two readings
        of equal source have equal places and ink; only their costs can differ.
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
    rest: float = 0.0
    form: SimpleForm | None = None
    warnings: tuple[str, ...] = ()
    source: tuple[object, ...] = ()


@dataclass(frozen=True, eq=False)
class Candidate:
    """A matching that gives a curve, whatever the box.

    All slow work is done once; a box of another size changes only the cost and which places
    are strays.

    Parameters
    ----------
    half : HalfInSpace
        What the matching gives in space.
    build : callable
        Makes the reading of a half; its cost lacks what the box adds.
    """

    half: HalfInSpace
    build: Callable[[HalfInSpace], Read]

    @cached_property
    def whole(self) -> Read:
        """The reading with all places."""
        return self.build(self.half)

    def in_box(self, box: Array | None) -> Read:
        """Return the reading beside a box (2, 3) mm, without the places that stray from it."""
        left_out = strays(self.half.points, box) & self.half.doubtful(box)
        read, source = self.whole, (self, b"")
        if left_out.any():
            read, source = self.build(self.half.without(left_out)), (self, left_out.tobytes())
        cost = read.cost + beyond(self.half, box)
        return replace(read, cost=cost, source=source)


def beyond(half: HalfInSpace, box: Array | None) -> float:
    """Return what it costs that a curve leaves a box (2, 3) mm, px."""
    share = OUTSIDE * half.share_outside(box)
    return share / (1.0 + share / AT_MOST)


def price(misfit: float, half: HalfInSpace, missing: float) -> float:
    """Return what a matching costs, px, whatever the box.

    Parameters
    ----------
    misfit : float
        How far off the matching is, px.
    half : HalfInSpace
        What the matching gives.
    missing : float
        Share of the ink without a partner.
    """
    return misfit + MISSING * missing + ASTRIDE * half.astride


def matched_part(pixels: Array, stations: Array) -> Array:
    """Return the part of a line (n, 2) between the least and the greatest of its stations."""
    begin, end = float(np.min(stations)), float(np.max(stations))
    along = arc_length(pixels)
    share = along / max(float(along[-1]), 1e-300)
    inner = (share > begin) & (share < end)
    ends = interpolate((begin, end), share, pixels)
    return np.vstack((ends[:1], pixels[inner], ends[1:]))
