"""Wheel arches: what is cut out of the panels beside a wheel, and the well behind them.

An arch is a circle about the axle, seen from the side. It is laid on the panels, which it enters
and leaves across their sides; panels are divided as polygons are (Weiler & Atherton 1977, "Hidden
surface removal using polygon area sorting").
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, BSplineSurface, Curve, ParameterCurve
from bozzetto.geometry.patches import Places, grid, points_at
from bozzetto.plugin import remembered
from bozzetto_car.parts.trimmed_face import KNOTS, bezier, edge_along, face_within, local, polyline
from bozzetto_car.template.network import Network

RADII: Final = (1.14, 1.11, 1.08, 1.05)
"""Radii of an arch per radius of its wheel; the first that fits the panels is taken."""

DEPTH: Final = 0.36
"""Depth of a wheel well, as share of the half width of the body beside it."""

INWARD: Final = (1.0, 1.0 - DEPTH, 1.0)
"""Factors of the coordinates that bring a place of a panel to the back of the well."""

CLEAR: Final = 1e-3
"""Least distance of a crossing from a corner of its panel, as share of the side."""

SAMPLES: Final = 25
"""Places on an arc through which its curve in the parameters is laid."""

GUESSES: Final = 9
"""Places along each side of a panel from which the search for a place starts."""

STEPS: Final = 12
"""Steps of Newton's method in this search."""

OVER_EDGE: Final = 1e-9
"""How far rounding may put a place of an arc outside its panel, in u and v."""

MET: Final = 1e-6
"""Distance, mm, at which the search has found the place."""

REMEMBERED: Final = 8
"""Number of cars whose cuts are remembered."""

TURN: Final = 2.0 * np.pi

Path = list[ParameterCurve]
Span = tuple[float, float]


@dataclass(frozen=True, eq=False)
class CutPanel:
    """A panel that a wheel arch divides.

    Attributes
    ----------
    outside, inside : tuple of list of ParameterCurve
        Loops round what is left of it, and round what is cut out, in u and v.
    arcs : tuple of ParameterCurve
        Pieces of the arch, in the sense in which the loops outside run them.
    cut : mapping of int to (float, float)
        The part of each side that is cut out, 0 … 1 in the sense of the loop.
    wheel : int
        0 for the front, 1 for the rear one.
    radius : float
        Of the arch, mm.
    """

    outside: tuple[Path, ...]
    inside: tuple[Path, ...]
    arcs: tuple[ParameterCurve, ...]
    cut: dict[int, Span]
    wheel: int
    radius: float


@dataclass(frozen=True)
class _Crossing:
    """Where the loop of a panel crosses the circle: side, way along it, turn about the axle."""

    side: int
    along: float
    turn: float
    enters: bool


class _MisfitError(ValueError):
    """A circle that cannot be laid on a panel."""


@remembered(limit=REMEMBERED, key=lambda network, nets: network)
def cut_panels(network: Network, nets: Array) -> dict[int, CutPanel]:
    """Return the panels of the right side that arches divide, by the numbers of their patches.

    A wheel whose arch fits no panels, or would cut one that is cut already, has none.

    Parameters
    ----------
    network : Network
        The car; its wheels stand on the ground, so that their height is their radius.
    nets : (k, 4, 4, 3) array_like
        Its patches, mm.
    """
    found: dict[int, CutPanel] = {}
    for wheel, centre in enumerate(network.positions[network.template.wheels[:, 0]]):
        for share in RADII:
            made = _arch(network, nets, wheel, share * float(centre[2]))
            if made and not made.keys() & found.keys():
                found |= made
                break
    return found


def well(panel: CutPanel, net: Array) -> list[Brep]:
    """Return the faces of a wheel well behind a panel: around the wheel, and beside it.

    What is beside the wheel is the panel brought toward the middle of the car by `DEPTH`, and
    what is around it consists of the lines between both, across the car. The floor consists of
    such lines, too, and meets them exactly.
    """
    outer = bezier(net)

    def brought_in(path: ParameterCurve) -> Curve:
        """Return the edge at the back that lies behind one of the panel, of as many spans."""
        edge = edge_along(outer, path)
        return replace(edge, control_points=edge.control_points * INWARD)

    faces = []
    for arc in panel.arcs:
        edge = edge_along(outer, arc)
        rows = np.stack((edge.control_points, edge.control_points * INWARD), axis=1)
        around = BSplineSurface((3, 1), edge.knots, KNOTS[1], rows)
        faces.append(Brep.of_surface(around).turned_over())
    inner = bezier(net * INWARD)
    return [*faces, *(face_within(inner, [loop], brought_in) for loop in panel.inside)]


def _arch(network: Network, nets: Array, wheel: int, radius: float) -> dict[int, CutPanel]:
    """Return the panels that an arch divides; none where it does not fit."""
    made: dict[int, CutPanel] = {}
    centre = network.positions[network.template.wheels[wheel, 0]]
    away = (nets - centre)[..., [0, 2]].reshape(len(nets), -1, 2)
    # A panel lies within the box of its control points.
    near = ((away.min(axis=1) < radius) & (away.max(axis=1) > -radius)).all(axis=1)
    for number, patch in enumerate(network.template.patches):
        if not near[number] or not patch.name.endswith(".R"):
            continue
        try:
            panel = _divided(nets[number], centre, wheel, radius)
        except _MisfitError:
            return {}
        if panel is not None and patch.glass:
            return {}
        if panel is not None:
            made[number] = panel
    rim = network.template.rim
    ends = [
        end
        for number, panel in made.items()
        for side, span in panel.cut.items()
        for end in span
        if network.template.edge_of(number, side) in rim and 0.0 < end < 1.0
    ]
    return made if len(ends) == 2 else {}


# -- dividing a panel ------------------------------------------------------------------------------


def _divided(net: Array, centre: Array, wheel: int, radius: float) -> CutPanel | None:
    """Return a panel divided by a circle; None where they do not cross.

    Raises
    ------
    _MisfitError
        If the circle cannot be laid on the panel.
    """
    crossings = _crossings(net, centre, radius)
    if not crossings:
        return None
    follower = dict(zip(crossings, crossings[1:] + crossings[:1], strict=True))
    arcs: dict[_Crossing, tuple[_Crossing, ParameterCurve]] = {}
    leaving = [c for c in crossings if not c.enters]
    for enter in (c for c in crossings if c.enters):
        end = min(leaving, key=lambda c: (c.turn - enter.turn) % TURN)
        arcs[enter] = end, _arc(net, centre, radius, enter, end)
    into = {end: (enter, _backwards(arc)) for enter, (end, arc) in arcs.items()}
    if len(into) < len(arcs):
        raise _MisfitError
    cut: dict[int, Span] = {}
    for enter in arcs:
        cut |= _cut_sides(enter, follower[enter])
    return CutPanel(
        _loops(leaving, follower, arcs),
        _loops(list(arcs), follower, into),
        tuple(arc for _, arc in arcs.values()),
        cut,
        wheel,
        radius,
    )


def _loops(
    starts: list[_Crossing],
    follower: dict[_Crossing, _Crossing],
    arcs: dict[_Crossing, tuple[_Crossing, ParameterCurve]],
) -> tuple[Path, ...]:
    """Return the loops that go along the sides from each start and back along arcs."""
    left, loops = list(starts), []
    while left:
        loop: Path = []
        here = left[0]
        while here in left:
            left.remove(here)
            there = follower[here]
            after, arc = arcs[there]
            loop += [*_border(here, there), arc]
            here = after
        loops.append(loop)
    return tuple(loops)


def _border(start: _Crossing, end: _Crossing) -> Path:
    """Return the way along the sides from one crossing to the next."""
    places = [local(start.side, start.along, 0.0)]
    side = start.side
    if side != end.side or end.along < start.along:
        while True:
            side = (side + 1) % 4
            places.append(local(side, 0.0, 0.0))
            if side == end.side:
                break
    return polyline([*places, local(end.side, end.along, 0.0)])


def _cut_sides(enter: _Crossing, leave: _Crossing) -> dict[int, Span]:
    """Return the part of each side between where the loop enters and leaves the circle."""
    if enter.side == leave.side and enter.along < leave.along:
        return {enter.side: (enter.along, leave.along)}
    between = range(enter.side + 1, enter.side + 1 + (leave.side - enter.side - 1) % 4)
    whole = {side % 4: (0.0, 1.0) for side in between}
    return {enter.side: (enter.along, 1.0), **whole, leave.side: (0.0, leave.along)}


def _crossings(net: Array, centre: Array, radius: float) -> list[_Crossing]:
    """Return where the loop of a panel crosses the circle, in its order."""
    found = []
    at = np.linspace(0.0, 1.0, 4)
    for side in range(4):
        places = Places(np.zeros(4, np.intp), np.array([local(side, p, 0.0) for p in at]))
        points = points_at(net[None], places) - centre
        x, z = (np.polyfit(at, points[:, axis], 3) for axis in (0, 2))
        away = np.polyadd(np.polymul(x, x), np.polymul(z, z))
        away[-1] -= radius**2
        roots = np.roots(away)
        real = np.sort(roots.real[np.abs(roots.imag) < 1e-9])
        for root in real[np.abs(real - 0.5) < 0.5 + CLEAR].tolist():
            if abs(root - 0.5) > 0.5 - CLEAR:
                raise _MisfitError
            turn = float(np.arctan2(np.polyval(z, root), np.polyval(x, root)))
            enters = bool(np.polyval(np.polyder(away), root) < 0.0)
            found.append(_Crossing(side, root, turn, enters))
    if any(a.enters == b.enters for a, b in zip(found, found[1:] + found[:1], strict=True)):
        raise _MisfitError
    return found


# -- arcs ------------------------------------------------------------------------------------------


def _arc(
    net: Array, centre: Array, radius: float, start: _Crossing, end: _Crossing
) -> ParameterCurve:
    """Return the arc from one crossing to another in u and v; seen from outside, clockwise."""
    from scipy.interpolate import make_interp_spline

    turn = start.turn + np.linspace(0.0, (end.turn - start.turn) % TURN, SAMPLES)[1:-1]
    goal = np.stack((centre[0] + radius * np.cos(turn), centre[2] + radius * np.sin(turn)), axis=1)
    whole = np.vstack(
        (local(start.side, start.along, 0.0), _parameters(net, goal),
         local(end.side, end.along, 0.0))
    )  # fmt: skip
    fit = make_interp_spline(np.linspace(0.0, 1.0, SAMPLES), whole, k=3)
    return ParameterCurve(3, fit.t, fit.c)


def _backwards(arc: ParameterCurve) -> ParameterCurve:
    return ParameterCurve(3, 1.0 - arc.knots[::-1], arc.control_points[::-1])


def _parameters(net: Array, goal: Array) -> Array:
    """Return u and v where a panel is seen at places (n, 2), x and z, from the side."""
    at = np.linspace(0.0, 1.0, GUESSES)
    laid = grid(net[None], at, at)[0][..., [0, 2]].reshape(-1, 2)
    first = ((laid - goal[:, None]) ** 2).sum(axis=2).argmin(axis=1)
    found = np.stack((at[first // GUESSES], at[first % GUESSES]), axis=1)
    nets, of = net[None], np.zeros(len(goal), np.intp)
    for _ in range(STEPS):
        places = Places(of, found)
        way = goal - points_at(nets, places)[:, [0, 2]]
        across = np.stack(
            [points_at(nets, places, du=1 - k, dv=k)[:, [0, 2]] for k in (0, 1)], axis=2
        )
        if (np.linalg.det(across) == 0.0).any():
            raise _MisfitError
        found = found + np.linalg.solve(across, way[..., None])[..., 0]
        found = np.clip(found, -OVER_EDGE, 1.0 + OVER_EDGE)
    met = points_at(nets, Places(of, found))[:, [0, 2]]
    if np.linalg.norm(met - goal, axis=1).max() > MET:
        raise _MisfitError
    return np.asarray(np.clip(found, 0.0, 1.0))
