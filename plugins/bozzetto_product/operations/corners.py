"""Corners of a network: two curves that meet in one joint, at an angle."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.view import triple
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane, Point
from bozzetto_product.operations.meetings import is_end, place_at
from bozzetto_product.operations.pieces import exact_pieces
from bozzetto_product.operations.tangents import end_direction
from bozzetto_product.projection.planes import in_plane
from bozzetto_product.projection.spline_basis import chord_length

CORNER: Final = "corner "
"""How the name of a corner begins; its joint and its curves follow."""

SHARPEST, FLATTEST = np.radians(5.0), np.radians(170.0)
"""Angles between which two curves make a corner that is offered."""

MOST_ENDS: Final = 6
"""Ends in a joint of which all pairs are offered."""

INTO: Final = 0.1
"""How far into a corner its handle is, in lengths of the shorter curve."""


@dataclass(frozen=True)
class Corner:
    """Two curves that meet in one joint, of which one ends there.

    Attributes
    ----------
    joint, first, second : str
        Ids.
    place, handle : (x, y, z)
        The joint, and a place between the curves, mm.
    angle : float
        Between the curves, radians.
    ways : (int, int)
        As of `fillet`: 0 of a curve that ends in the joint.
    """

    joint: str
    first: str
    second: str
    place: Point
    handle: Point
    angle: float
    ways: tuple[int, int] = (0, 0)

    @property
    def name(self) -> str:
        """What it is called in gestures."""
        sides = " ".join(f"{way:+d}" for way in self.ways) if any(self.ways) else ""
        return f"{CORNER}{self.joint} {self.first} {self.second} {sides}".rstrip()

    def radius_through(self, goal: Array) -> float:
        """Return the radius of the arc whose middle is as far from the joint as a place, mm.

        Of straight curves: r (1/sin(angle/2) − 1) from the joint, along the bisector.
        """
        way = np.subtract(self.handle, self.place)
        along = float((goal - self.place) @ way / np.linalg.norm(way))
        return float(along / (1.0 / np.sin(0.5 * self.angle) - 1.0))


def corners_of(
    joints: Sequence[Joint], splines: Mapping[str, Spline], symmetry: Plane
) -> Iterator[Corner]:
    """Yield the corners that can be rounded.

    Parameters
    ----------
    joints : sequence of Joint
        Of the network.
    splines : mapping of str to Spline
        The curves, by id, mm.
    symmetry : Plane
        In which mirror images are.
    """
    for joint in joints:
        ends = [meet for meet in joint.meetings if meet.curve in splines]
        names = {meet.curve for meet in ends}
        if not 2 <= len(ends) <= MOST_ENDS or len(names) < len(ends):
            continue
        own = [
            (meet, way)
            for meet in ends
            if not meet.mirrored and not splines[meet.curve].closed
            for way in ((0,) if is_end(splines, meet) else (1, -1))
        ]
        for one, other in itertools.combinations(own, 2):
            pair = (one[0], other[0])
            flat = [lies_in(splines[meet.curve], symmetry) for meet in pair]
            through = [bool(way) for _, way in (one, other)]
            if pair[0] is not pair[1] and is_corner(joint, through, flat):
                yield from _corner(joint, one, other, splines)


def is_corner(joint: Joint, through: Sequence[bool], flat: Sequence[bool]) -> bool:
    """Whether two curves that meet in a joint make a corner that can be rounded.

    Parameters
    ----------
    joint : Joint
        Where they meet.
    through : sequence of bool
        Which of them run through it.
    flat : sequence of bool
        Which of them lie in the symmetry plane.
    """
    if all(through):
        return False
    across = any(passes and not own for passes, own in zip(through, flat, strict=True))
    return not joint.in_plane or (any(flat) and not across)


def lies_in(spline: Spline, plane: Plane) -> bool:
    """Whether a curve lies in a plane, to the last bit."""
    points = np.asarray(spline.control_points, float)
    return bool((in_plane(points, plane) == points).all())


def from_corner(spline: Spline, at: float, way: int) -> Spline:
    """Return a curve from a place on, along it or against it.

    Parameters
    ----------
    spline : Spline
        Open.
    at : float
        Share of its range.
    way : int
        1 is along it, −1 against it; 0 is away from the end that the place is.
    """
    if way == 0:
        return spline if at == 0.0 else spline.reversed()
    before, behind = exact_pieces(spline, [at])
    return behind if way > 0 else before.reversed()


def _corner(
    joint: Joint,
    one: tuple[Meeting, int],
    other: tuple[Meeting, int],
    splines: Mapping[str, Spline],
) -> Iterator[Corner]:
    sides = [from_corner(splines[meet.curve], meet.at, way) for meet, way in (one, other)]
    try:
        ways = [end_direction(side, 0.0) for side in sides]
    except UserError:
        return
    angle = float(np.arccos(np.clip(ways[0] @ ways[1], -1.0, 1.0)))
    if not SHARPEST <= angle <= FLATTEST:
        return
    place = place_at(sides[0], 0.0)
    between = (ways[0] + ways[1]) / np.linalg.norm(ways[0] + ways[1])
    handle = triple(place + INTO * min(map(chord_length, sides)) * between)
    yield Corner(
        joint.id,
        one[0].curve,
        other[0].curve,
        triple(place),
        handle,
        angle,
        (one[1], other[1]),
    )
