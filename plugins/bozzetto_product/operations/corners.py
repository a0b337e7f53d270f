"""Corners of a network: two curves that end in one joint, at an angle."""

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
from bozzetto_product.model.planes import Point
from bozzetto_product.operations.meetings import is_end, place_at
from bozzetto_product.operations.tangents import end_direction
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
    """Two curves that end in one joint.

    Attributes
    ----------
    joint, first, second : str
        Ids.
    place, handle : (x, y, z)
        The joint, and a place between the curves, mm.
    angle : float
        Between the curves, radians.
    """

    joint: str
    first: str
    second: str
    place: Point
    handle: Point
    angle: float

    @property
    def name(self) -> str:
        """What it is called in gestures."""
        return f"{CORNER}{self.joint} {self.first} {self.second}"

    def radius_through(self, goal: Array) -> float:
        """Return the radius of the arc whose middle is as far from the joint as a place, mm.

        Of straight curves: r (1/sin(angle/2) − 1) from the joint, along the bisector.
        """
        way = np.subtract(self.handle, self.place)
        along = float((goal - self.place) @ way / np.linalg.norm(way))
        return float(along / (1.0 / np.sin(0.5 * self.angle) - 1.0))


def corners_of(joints: Sequence[Joint], splines: Mapping[str, Spline]) -> Iterator[Corner]:
    """Yield the corners that can be rounded.

    Parameters
    ----------
    joints : sequence of Joint
        Those in the symmetry plane have none.
    splines : mapping of str to Spline
        The curves, by id, mm.
    """
    for joint in joints:
        ends = [meet for meet in joint.meetings if meet.curve in splines]
        names = {meet.curve for meet in ends}
        if joint.in_plane or not 2 <= len(ends) <= MOST_ENDS or len(names) < len(ends):
            continue
        if all(is_end(splines, meet) for meet in ends):
            own = [meet for meet in ends if not meet.mirrored]
            for one, other in itertools.combinations(own, 2):
                yield from _corner(joint, one, other, splines)


def _corner(
    joint: Joint, one: Meeting, other: Meeting, splines: Mapping[str, Spline]
) -> Iterator[Corner]:
    try:
        ways = [end_direction(splines[meet.curve], meet.at) for meet in (one, other)]
    except UserError:
        return
    angle = float(np.arccos(np.clip(ways[0] @ ways[1], -1.0, 1.0)))
    if not SHARPEST <= angle <= FLATTEST:
        return
    place = place_at(splines[one.curve], one.at)
    between = (ways[0] + ways[1]) / np.linalg.norm(ways[0] + ways[1])
    length = min(chord_length(splines[meet.curve]) for meet in (one, other))
    handle = triple(place + INTO * length * between)
    yield Corner(joint.id, one.curve, other.curve, triple(place), handle, angle)
