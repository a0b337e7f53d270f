"""Which joints lie where on each curve, those of mirror images included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.reflection import OWN_IMAGE, Reflection, size_of

SAME_PLACE: Final = 1e-9
"""Share of a curve's parameter range below which two places on it are one."""

SAME_JOINT: Final = 1e5
"""Places on a curve that are told apart when a joint is compared with the mirror image of another;
images are found as foot points, not to the last digit."""

NodeKey = tuple[str, bool, str]
"""Id of a joint, whether it is the mirror image of that joint, and for a free end, which has no
joint, the id of its curve and which end it is."""


@dataclass(frozen=True)
class Cut:
    """A place on a curve, by its share of the parameter range, and the node that lies there."""

    at: float
    node: NodeKey


@dataclass(frozen=True, eq=False)
class CutCurve:
    """A curve with its cuts.

    Parameters
    ----------
    curve : Curve
    spline : Spline
        Clamped where it is open.
    cuts : tuple of Cut
        In order; first and last are the ends of an open curve. Cuts at one place are all there.
    across : bool
        It is its own mirror image, with the ends exchanged.
    in_plane : bool
        It lies in the plane.
    """

    curve: Curve
    spline: Spline
    cuts: tuple[Cut, ...]
    across: bool = False
    in_plane: bool = False

    @property
    def mirrored(self) -> bool:
        """Whether it stands for its mirror image as well."""
        return self.curve.mirrored and not self.across and not self.in_plane


def cut_curves(
    curves: Sequence[Curve], joints: Sequence[Joint], reflection: Reflection
) -> tuple[tuple[CutCurve, ...], dict[NodeKey, NodeKey]]:
    """Find the cuts of every curve.

    Parameters
    ----------
    curves : sequence of Curve
        Those without a length are left out.
    joints : sequence of Joint
        Meetings with curves that are not there are left out.
    reflection : Reflection
        In the symmetry plane.

    Returns
    -------
    cut : tuple of CutCurve
        Curves that have a length, in their order.
    images : dict
        The mirror image of each node that has one.
    """
    bare = {each.id: _without_cuts(each, reflection) for each in curves if _has_length(each)}
    cuts: dict[str, list[Cut]] = {name: [] for name in bare}
    images: dict[NodeKey, NodeKey] = {}
    known = {joint.id: _known(joint.meetings, bare) for joint in joints}
    listed = {place: name for name, own in known.items() for place in _places(own)}
    for joint in joints:
        own, key = known[joint.id], (joint.id, False, "")
        mirrored = _images(own, bare, reflection)
        same = sorted(listed[place] for place in _places(mirrored) if place in listed)
        image = (same[0], False, "") if same else (joint.id, True, "")
        image = key if joint.in_plane else image
        if joint.in_plane or same or any(bare[each.curve].mirrored for each in own):
            images[key], images[image] = image, key
            # What the image has already is not cut a second time beside it.
            mirrored = [one for one in mirrored if _place(one) not in listed]
        else:
            mirrored = []
        for meetings, node in ((own, key), (mirrored, image)):
            for each in meetings:
                if not each.mirrored:
                    cuts[each.curve].append(Cut(each.at, node))
    done = tuple(replace(each, cuts=_in_order(each, cuts[name])) for name, each in bare.items())
    for curve in done:
        images.update(_images_of_free_ends(curve))
    return done, images


def _has_length(curve: Curve) -> bool:
    if curve.spline is None or curve.spline.control_points.shape[1] != 3:
        return False
    points = curve.spline.control_points
    return bool(np.isfinite(points).all() and np.ptp(points, axis=0).max() > 0)


def _without_cuts(curve: Curve, reflection: Reflection) -> CutCurve:
    assert curve.spline is not None
    spline, across, in_plane = _as_it_lies(curve.spline, reflection.plane)
    return CutCurve(curve, spline, (), across, in_plane)


@remembered(limit=2000)
def _as_it_lies(spline: Spline, plane: Plane) -> tuple[Spline, bool, bool]:
    """Return a clamped spline, and whether it lies across a plane or in it, then exactly so."""
    reflection = Reflection(plane)
    begin, end = spline.range
    if not spline.closed and not (spline.knots[0] == begin and spline.knots[-1] == end):
        (spline,) = spline.split()
    if reflection.holds(spline):
        flat = Spline(spline.knots, reflection.onto(spline.control_points), spline.closed)
        return flat, False, True
    across = reflection.keeps(spline)
    return reflection.symmetric(spline) if across and not spline.closed else spline, across, False


def _known(meetings: Sequence[Meeting], curves: dict[str, CutCurve]) -> list[Meeting]:
    """Return the meetings with curves that are there, with places in their range."""
    known = []
    for each in meetings:
        curve = curves.get(each.curve)
        if curve is not None and np.isfinite(each.at):
            at = min(1.0, max(0.0, float(each.at)))
            known.append(Meeting(each.curve, at, each.mirrored and curve.mirrored))
    return known


def _images(
    meetings: Sequence[Meeting], curves: dict[str, CutCurve], reflection: Reflection
) -> list[Meeting]:
    """Return the mirror images of meetings, as far as their curves have one."""
    images = []
    for each in meetings:
        curve = curves[each.curve]
        if curve.mirrored:
            images.append(replace(each, mirrored=not each.mirrored))
        elif curve.in_plane:
            images.append(each)
        elif curve.across:
            images.append(replace(each, at=image_place(curve.spline, each.at, reflection)))
    return images


def image_place(spline: Spline, at: float, reflection: Reflection) -> float:
    """Return where a curve that is its own mirror image has the image of one of its places."""
    begin, end = spline.range
    image = reflection.points(spline.value([begin + at * (end - begin)]))
    for exact in (at, 1.0 - at):
        miss = np.linalg.norm(spline.value([begin + exact * (end - begin)]) - image)
        if miss <= OWN_IMAGE * size_of(spline):
            return exact
    (foot,) = spline.foot_points(image)
    return float((foot - begin) / (end - begin))


def _places(meetings: Sequence[Meeting]) -> set[tuple[str, int, bool]]:
    """Return meetings so that those at one place of a curve are equal."""
    return set(map(_place, meetings))


def _place(meeting: Meeting) -> tuple[str, int, bool]:
    return meeting.curve, round(meeting.at * SAME_JOINT), meeting.mirrored


def _in_order(curve: CutCurve, cuts: Sequence[Cut]) -> tuple[Cut, ...]:
    """Return cuts in order along a curve; an open one gets its free ends."""
    if curve.spline.closed:
        around = (replace(each, at=_around(each.at)) for each in cuts)
        return tuple(sorted(around, key=lambda each: (each.at, each.node)))
    found = list(cuts)
    for at, name in ((0.0, "start"), (1.0, "end")):
        if not any(abs(each.at - at) <= SAME_PLACE for each in found):
            found.append(Cut(at, ("", False, f"{name} of {curve.curve.id}")))
    return tuple(sorted(found, key=lambda each: (each.at, each.node)))


def _around(at: float) -> float:
    """Return a place on a closed curve, 0 rather than 1 at the seam."""
    return 0.0 if at >= 1.0 - SAME_PLACE else at


def _images_of_free_ends(curve: CutCurve) -> dict[NodeKey, NodeKey]:
    images = {}
    start, end = (("", False, f"{name} of {curve.curve.id}") for name in ("start", "end"))
    for node in {each.node for each in curve.cuts if not each.node[0]}:
        image = (node[0], True, node[2])
        if curve.in_plane:
            image = node
        elif curve.across:
            image = end if node == start else start
        if curve.mirrored or curve.in_plane or curve.across:
            images[node], images[image] = image, node
    return images
