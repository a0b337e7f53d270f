"""Where curves meet, and boundaries that run from joint to joint.

A joint names its places by the parameter on each curve, so that a curve that is bent takes its
neighbours along.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Meeting:
    """A place on a curve at which it meets others.

    Parameters
    ----------
    curve : str
        Id of the curve.
    at : float
        Share of its parameter range; 0 and 1 are its ends, anything between is a T-joint.
    mirrored : bool
        It is the mirror image that meets.
    """

    curve: str
    at: float
    mirrored: bool = False


@dataclass(frozen=True)
class Joint:
    """A place where curves meet.

    Parameters
    ----------
    id : str
        Unique among the joints.
    meetings : tuple of Meeting
        Those that were meant; the mirror image of a joint is not listed.
    in_plane : bool
        It lies in the symmetry plane, exactly.
    """

    id: str
    meetings: tuple[Meeting, ...]
    in_plane: bool = False


@dataclass(frozen=True)
class Run:
    """A part of a boundary: a curve from one joint to another.

    Parameters
    ----------
    curve : str
    start, end : str
        Ids of joints; both "" for a closed curve without a joint, and the same one for a closed
        curve all the way round.
    forward : bool
        Whether it goes along with the curve.
    mirrored : bool
        It is the mirror image of all that the other fields say.
    start_opposite, end_opposite : bool
        The end is the mirror image of the joint named: of a curve across the symmetry plane.
    """

    curve: str
    start: str = ""
    end: str = ""
    forward: bool = True
    mirrored: bool = False
    start_opposite: bool = False
    end_opposite: bool = False


Boundary = tuple[Run, ...]
