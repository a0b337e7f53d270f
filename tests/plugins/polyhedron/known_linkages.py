"""Known linkages in closed form: corners by name, and the bars between them; x right, y up."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from bozzetto_polyhedron.mechanism.assembly import (
    GROUND,
    Assembly,
    Ground,
    Motion,
    motor,
    no_joints,
    spherical,
)
from bozzetto_polyhedron.mechanism.drives import Drive, Steady

SWING: dict[str, object] = {"drive": "swing", "angle": 30.0}
RISE: dict[str, object] = {"drive": "swing", "angle": 12.0}

Corners = dict[str, np.ndarray]


@dataclass(frozen=True)
class Linkage:
    """Corners and bars, what is held and what is driven.

    Parameters
    ----------
    corners : dict of str to (2,) float64
    bars : tuple of str
        Names of both ends, one letter each.
    held : str
    motor : str
        The bar that is turned, its axis first.
    traced : str
    pins : tuple of (str, str)
        Bars that are pinned where they cross.
    guided : str
        The corner that slides along the x-axis.
    drive : dict
        Of the motor; see `bozzetto_polyhedron.model.fittings.Driven`.
    more : tuple of (str, dict)
        Further bars that are turned, and how.
    links : tuple of str
        Bars without mass between the drawings that no other bar joins.
    """

    corners: Corners
    bars: tuple[str, ...]
    held: str
    motor: str
    traced: str
    pins: tuple[tuple[str, str], ...] = ()
    guided: str = ""
    drive: dict[str, object] = field(default_factory=lambda: {"speed": 180.0})
    more: tuple[tuple[str, dict[str, object]], ...] = ()
    links: tuple[str, ...] = ()

    def drawings(self) -> list[tuple[str, ...]]:
        """Return the bars that hang together at corners or pins, group by group, in their order."""
        found: list[set[str]] = []
        joints = [{bar for bar in self.bars if name in bar} for name in self.corners]
        for joint in (*joints, *map(set, self.pins)):
            near = [each for each in found if each & joint]
            found = [each for each in found if each not in near] + [joint.union(*near)]
        return sorted(
            (tuple(bar for bar in self.bars if bar in each) for each in found),
            key=lambda bars: self.bars.index(bars[0]),
        )


def meeting(one: np.ndarray, first: float, other: np.ndarray, second: float) -> np.ndarray:
    """Return the place at two distances from two places, on the left of the way between them."""
    across = other - one
    apart = float(np.linalg.norm(across))
    along = (first**2 - second**2 + apart**2) / (2.0 * apart)
    aside = np.sqrt(first**2 - along**2)
    unit = across / apart
    return one + along * unit + aside * np.array([-unit[1], unit[0]])


def four_bar() -> Linkage:
    """A crank that turns fully, and a rocker."""
    crank = 40.0 * np.array([np.cos(1.1), np.sin(1.1)])
    base = np.array([160.0, 0.0])
    elbow = meeting(crank, 140.0, base, 100.0)
    along = (elbow - crank) / 140.0
    tip = crank + 90.0 * along + 70.0 * np.array([-along[1], along[0]])
    corners = {"a": np.zeros(2), "b": crank, "c": elbow, "d": base, "e": tip}
    return Linkage(corners, ("ab", "bc", "cd", "be", "ce"), "ad", "ab", "e")


def peaucellier() -> Linkage:
    """Peaucellier and Lipkin's straight line: q is the inverse of p in a circle about o."""
    middle, turn = np.array([85.0, 0.0]), np.radians(20.0)
    driven = middle + 85.0 * np.array([np.cos(turn), np.sin(turn)])
    arm, side = np.sqrt(66500.0), 110.0
    upper = meeting(driven, side, np.zeros(2), arm)
    lower = meeting(np.zeros(2), arm, driven, side)
    far = upper + lower - driven
    corners = {"o": np.zeros(2), "c": middle, "p": driven, "a": upper, "b": lower, "q": far}
    return Linkage(
        corners, ("oa", "ob", "ap", "bp", "aq", "bq", "cp"), "oc", "cp", "q", drive=SWING
    )


def jansen() -> Linkage:
    """One leg of Jansen's walking animal, with his eleven numbers."""
    crank = 15.0 * np.array([np.cos(0.2), np.sin(0.2)])
    pivot = np.array([-38.0, -7.8])
    top = meeting(pivot, 41.5, crank, 50.0)
    low = meeting(crank, 61.9, pivot, 39.3)
    heel = meeting(pivot, 40.1, top, 55.8)
    knee = meeting(low, 36.7, heel, 39.4)
    foot = meeting(low, 49.0, knee, 65.7)
    corners = {
        "z": np.zeros(2), "x": crank, "y": pivot, "t": top,
        "l": low, "h": heel, "k": knee, "f": foot,
    }  # fmt: skip
    bars = ("zx", "xt", "xl", "yt", "yl", "th", "yh", "hk", "lk", "kf", "lf")
    return Linkage(corners, bars, "zy", "zx", "f")


def as_rods(known: Linkage) -> tuple[Assembly, Motion, dict[str, tuple[int, np.ndarray]]]:
    """Return rigid rods in the plane y = 0, m, one for each bar; and who carries each corner."""
    places = {name: np.array([x, 0.0, z]) / 1e3 for name, (x, z) in known.corners.items()}
    bars = (*known.bars, *known.links)
    ends = [(places[one], places[other]) for one, other in bars]
    motion = Motion.at_rest(np.array([0.5 * (a + b) for a, b in ends]))
    lengths = np.array([np.linalg.norm(b - a) for a, b in ends])
    inertias = np.eye(3) * (lengths**2 / 12)[:, None, None]
    joints, carriers = no_joints(), {}
    for number, bar in enumerate(bars):
        for name in bar:
            if name in carriers:
                joints += spherical(motion, number, carriers[name][0], places[name])
            else:
                carriers[name] = number, places[name] - motion.places[number]
                if name in known.held:
                    joints += spherical(motion, number, GROUND, places[name])
    planar = np.array([0.0, 1.0, 0.0])
    count = len(bars)
    made = Assembly(np.ones(count), inertias, joints, gravity=np.zeros(3), planar=planar)
    return made, motion, carriers


APART: float = 230.0
"""Distance of the two pairs of legs of a walker, mm."""

PAIRS = (("zxyY", "tlhkfTLHKF", 2.3), ("owuU", "abcdeABCDE", 2.3 + np.pi))
"""Of each pair the axis, its crank and its two pivots; the corners of both legs; the turn."""


def walker() -> Linkage:
    """Two pairs of Jansen's legs under one beam, on cranks that are half a turn apart."""
    corners: Corners = {}
    bars: list[str] = []
    for number, ((axis, pin, *pivots), legs, turn) in enumerate(PAIRS):
        middle = np.array([APART * number, 0.0])
        crank = 15.0 * np.array([np.cos(turn), np.sin(turn)])
        corners |= {axis: middle, pin: middle + crank}
        bars += [axis + pivots[0], axis + pivots[1], pivots[0] + pivots[1], axis + pin]
        for pivot, leg, side in zip(pivots, (legs[:5], legs[5:]), (1.0, -1.0), strict=True):
            mirrored = np.array([side, 1.0])
            base, end = np.array([-38.0, -7.8]), crank * mirrored
            top, low = meeting(base, 41.5, end, 50.0), meeting(end, 61.9, base, 39.3)
            heel = meeting(base, 40.1, top, 55.8)
            knee = meeting(low, 36.7, heel, 39.4)
            found = (top, low, heel, knee, meeting(low, 49.0, knee, 65.7))
            corners[pivot] = middle + base * mirrored
            corners |= {n: middle + at * mirrored for n, at in zip(leg, found, strict=True)}
            t, e, h, k, f = leg
            bars += [pin + t, pin + e, pivot + t, pivot + e, t + h, pivot + h, h + k, e + k]
            bars += [k + f, e + f]
    more = (("ow", {"speed": 180.0}),)
    links = ("zo", "Yu", "zu")
    return Linkage(corners, tuple(bars), "", "zx", "z", more=more, links=links)


def walking(friction: float, rate: float) -> tuple[Assembly, Motion]:
    """Return the walker as rods with its feet on the ground, its cranks driven in its frame."""
    known = walker()
    assembly, motion, carriers = as_rods(known)
    joints, axis = assembly.joints, np.array([0.0, 1.0, 0.0])
    for bar, frame in (("zx", "zy"), ("ow", "ou")):
        turned, against = known.bars.index(bar), known.bars.index(frame)
        joints += motor(motion, turned, against, axis, Drive(Steady(rate)))
    feet = [carriers[name] for name in "fFeE"]
    ground = Ground(
        np.array([rod for rod, _ in feet]),
        np.array([arm for _, arm in feet]),
        min(float(known.corners[name][1]) for name in "fFeE") / 1e3,
    )
    gravity = np.array([0.0, 0.0, -9.81])
    return replace(
        assembly, joints=joints, ground=ground, gravity=gravity, friction=friction
    ), motion


def scissor() -> Linkage:
    """A lift of two crossings; its foot is drawn in by a crank."""
    reach = np.array([150.0, 0.0])
    rise = np.array([0.0, 70.0])
    corners = {
        "a": np.zeros(2), "b": reach, "c": rise, "d": reach + rise, "e": 2 * rise,
        "f": reach + 2 * rise,
    }  # fmt: skip
    bars = ("ad", "bc", "cf", "de")
    pins = (("ad", "bc"), ("cf", "de"))
    return Linkage(corners, bars, "a", "ad", "f", pins, guided="b", drive=RISE)


def robot_arm() -> Linkage:
    """An arm of two braced booms and a gripper on a stand, with a motor in every joint."""
    at = {
        "a": (-40.0, 0.0), "b": (40.0, 0.0), "s": (0.0, 84.0),
        "c": (4.0, 150.0), "e": (60.0, 186.0),
        "d": (106.0, 204.0), "w": (176.0, 140.0),
        "g": (222.0, 124.0), "h": (188.0, 90.0),
    }  # fmt: skip
    corners = {name: np.array(place) for name, place in at.items()}
    stand = ("ab", "as", "bs")
    booms = ("se", "sc", "ce", "ew", "ed", "dw")
    gripper = ("wg", "wh")

    def to_and_fro(angle: float, period: float) -> dict[str, object]:
        return {"drive": "swing", "angle": angle, "period": period}

    more = (
        ("ew", to_and_fro(-28.0, 2.0)),
        ("wg", to_and_fro(14.0, 1.0)),
        ("wh", to_and_fro(-14.0, 1.0)),
    )
    return Linkage(
        corners,
        (*stand, *booms, *gripper),
        "ab",
        "se",
        "w",
        drive=to_and_fro(22.0, 4.0),
        more=more,
    )
