"""Ends that settle where they nearly meet: all ends of all curves at once.

Ends that come near one another are one place, of which every one of them says what its ink knows
(Aitken, 1935). What is fixed, as a corner of the box, holds them; then single ends settle on curves, on
the centre plane and on the faces of the box. Everything is worked out from the curves as their ink
says them, so neither the order of the curves nor how often it is done tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto.view import Camera, triple
from bozzetto_symmetry.editing.end_snaps import drawn_end, with_end_snaps
from bozzetto_symmetry.editing.snap import end_direction
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.axes import AXES
from bozzetto_symmetry.model.perspective import pixel_size
from bozzetto_symmetry.model.state import Curve, EndSnap, Snap, SymmetryState
from bozzetto_symmetry.operations.snap_candidates import SMOOTH, Reach, snap_within
from bozzetto_symmetry.operations.snap_targets import Targets, curve_targets, targets
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import HAND, image_slopes

TWICE: Final = 2.0
"""How much worse a hand ends along its way than it keeps on it, as for flat curves."""

HELD: Final = 1e3
"""Weight of the centre plane for a curve that lies in it, per mm."""

LEAST: Final = 1e-3
"""Weight of the place of an end where its ink knows nothing of it, per mm."""

FARTHEST: Final = 2.0
"""How far an end goes to what does not come to meet it, in errors of a hand."""

SWEEPS: Final = 6
"""Times that ends settle on curves whose own ends settle on others."""


@dataclass(frozen=True, eq=False)
class Free:
    """A curve as its ink says it, whose ends may settle.

    Attributes
    ----------
    node : Curve
        Without snaps of its ends.
    trace : Trace
    curve : SpaceCurve
    camera : Camera
        Of its last stroke, in the model's frame.
    """

    node: Curve
    trace: Trace
    curve: SpaceCurve
    camera: Camera

    @property
    def ends(self) -> tuple[int, ...]:
        """Its free ends."""
        return (1,) if self.curve.reading == "self" else (0, 1)


@dataclass(frozen=True, eq=False)
class _End:
    """A free end, on that side of the centre plane where y is not negative.

    Attributes
    ----------
    owner : str
        Id of the curve.
    number : {0, 1}
    side : (3,) float
        Factors that lead from the side of the curve to this one.
    place : (3,) float
        In the frame of the plane, mm.
    reach : Reach
        How far it may go, there.
    sigma : float
        mm.
    leaving : (3,) float
        Unit direction in which the curve leaves it.
    known : (3, 3) float
        Information of the ink about the place, per mm².
    """

    owner: str
    number: int
    side: Array
    place: Array
    reach: Reach
    sigma: float
    leaving: Array
    known: Array


Places = Mapping[str, tuple[Snap, ...]]
"""Where the ends of curves settle, by their id, in the model's frame."""


def settled(
    state: SymmetryState, context: Context, without: str = "", *, box: bool = True
) -> Places:
    """Return where the ends of all curves settle that may.

    Parameters
    ----------
    state : SymmetryState
        Its curves, lines, box and plane.
    context : Context
        The curves of other models.
    without : str
        Id of a curve that does not count.
    box : bool
        Whether the edges and faces of the box count.
    """
    free, others = _free_curves(state, without)
    fixed = targets(state, others, context, box=box)
    ends = [end for each in free.values() for end in _ends_of(each, state)]
    taken = _met(ends, fixed, free, state)
    settling = {name: tuple(snaps) for name, snaps in taken.items()}
    for _ in range(SWEEPS):
        moved = {name: _moved(each, settling.get(name, ()), state) for name, each in free.items()}
        known = {
            name: curve_targets(curve, state.plane).without_points("end")
            for name, curve in moved.items()
        }
        after = {}
        for name, each in free.items():
            met = taken.get(name, [])
            held = {snap.end for snap in met}
            bodies = Targets.joined(
                (fixed.without_points("end", "corner"),
                 *(body for other, body in known.items() if other != name))
            )  # fmt: skip
            alone = [end for end in ends if end.owner == name and end.number not in held]
            rest = [_on_body(end, each, bodies, state, box) for end in alone]
            after[name] = (*met, *(snap for snap in rest if snap is not None))
        if after == settling:
            break
        settling = after
    return {name: settling.get(name, ()) for name in free}


def with_settled(
    state: SymmetryState, context: Context, *, chosen: bool = False, box: bool = True
) -> SymmetryState:
    """Return the state in which ends that nearly meet something do.

    Parameters
    ----------
    state : SymmetryState
        Its curves.
    context : Context
        The curves of other models.
    chosen : bool
        Only the chosen curve, and those whose ends settle elsewhere because of it.
    box : bool
        Whether the edges and faces of the box count.
    """
    found = settled(state, context, box=box)
    if chosen:
        node = state.chosen
        before = settled(state, context, state.selected, box=box)
        found = {
            name: snaps for name, snaps in found.items()
            if node is not None and (name == node.id or snaps != before.get(name))
        }  # fmt: skip
    for node in state.curves:
        if node.id not in found:
            continue
        base = trace_of(replace(node, end_snaps=(), axis=-1), state)
        assert base.curve is not None
        made = [end_snap_of(snap, base.curve, node, state) for snap in found[node.id]]
        snaps = tuple(snap for snap in made if snap is not None)
        if snaps != node.end_snaps:
            node = replace(node, end_snaps=snaps)
            state = replace(state.with_node(node), selected=state.selected)
    return state


def end_snap_of(snap: Snap, curve: SpaceCurve, node: Curve, state: SymmetryState) -> EndSnap | None:
    """Return a snap of the curve as one of the stroke that ends there; the last such stroke."""
    for number in range(len(node.strokes) - 1, -1, -1):
        stroke = node.strokes[number]
        for end in (0, 1):
            shown = drawn_end(curve, stroke, end, state)
            if shown is None or shown.end != snap.end:
                continue
            if not shown.mirrored:
                return EndSnap(number, end, snap.point, snap.tangent)
            way = snap.tangent
            if way is not None:
                way = triple(_turned(_turned(way, state) * MIRROR, state, back=True))
            place = state.plane.inverse.points(snap.point)[0] * MIRROR
            return EndSnap(number, end, triple(state.plane.placement.points(place)[0]), way)
    return None


def _turned(way: Sequence[float] | Array, state: SymmetryState, *, back: bool = False) -> Array:
    frame = state.plane.placement if back else state.plane.inverse
    return np.asarray(frame.directions(way)[0])


def _free_curves(state: SymmetryState, without: str) -> tuple[dict[str, Free], list[SpaceCurve]]:
    """Return the curves whose ends may settle, by id, and those that stay as they are."""
    free: dict[str, Free] = {}
    others: list[SpaceCurve] = []
    for node in state.shown_curves:
        if node.id == without:
            continue
        bare = replace(node, end_snaps=(), axis=-1)
        may = node.settles and node.canvas is None and not node.edits
        try:
            trace = trace_of(bare if may else node, state)
        except UserError:
            continue
        if trace.curve is None:
            continue
        if may and not trace.curve.closed:
            free[node.id] = Free(
                replace(node, end_snaps=()), trace, trace.curve, node.strokes[-1].camera
            )
        else:
            others.append(trace.curve)
    return free, others


def _ends_of(each: Free, state: SymmetryState) -> Iterator[_End]:
    curve, camera = each.curve, Stereo.of(each.camera, state.plane).camera
    for number in each.ends:
        place = curve.spline.value(curve.spline.range[number : number + 1])[0]
        leaving = end_direction(curve.spline if number else curve.spline.reversed())
        reach = Reach.of(place, camera)
        if reach is None:
            continue
        side = MIRROR if place[1] < 0.0 else np.ones(3)
        sigma = float(each.trace.sigma[-number])
        known = side[:, None] * _information(each, number, place, leaving, state) * side
        yield _End(each.node.id, number, side, place * side, reach.reflected(side), sigma,
                   leaving * side, known)  # fmt: skip


def _information(
    each: Free, number: int, place: Array, leaving: Array, state: SymmetryState
) -> Array:
    """Return what the ink says about an end, (3, 3) per mm²: 1 px across its way, 2 px along it."""
    made = np.eye(3) * LEAST**2
    if each.curve.reading == "plane":
        made[1, 1] += HELD**2
    for stroke in each.node.strokes:
        for end in (0, 1):
            shown = drawn_end(each.curve, stroke, end, state)
            if shown is None or shown.end != number:
                continue
            side = MIRROR if shown.mirrored else np.ones(3)
            stereo = Stereo.of(stroke.camera, state.plane)
            slopes = image_slopes(stereo, place * side)[0] * side
            way = slopes @ leaving
            way = way / max(float(np.linalg.norm(way)), 1e-300)
            rows = np.stack((way @ slopes / TWICE, np.array((-way[1], way[0])) @ slopes))
            made += rows.T @ rows
    return made


def _met(
    ends: list[_End], fixed: Targets, free: Mapping[str, Free], state: SymmetryState
) -> dict[str, list[Snap]]:
    """Return the ends that meet others, or fixed points, with their common places."""
    points = state.plane.inverse.points(fixed.points) if len(fixed.points) else fixed.points
    ways = state.plane.inverse.directions(fixed.tangents) if len(points) else points
    sides = np.where(points[:, 1:2] < 0.0, MIRROR, 1.0)
    points, ways = points * sides, ways * sides
    clusters = _clusters(ends, points)
    places = _common_places(ends, clusters, points, free, state)
    found: dict[str, list[Snap]] = {}
    for (members, held), place in zip(clusters, places, strict=True):
        if len(members) < 2 and held < 0:
            continue
        for k, way in zip(
            members, _continued(members, ends, ways[held] if held >= 0 else None), strict=True
        ):
            end = ends[k]
            point = state.plane.placement.points(place * end.side)[0]
            tangent = None if way is None else triple(_turned(way * end.side, state, back=True))
            found.setdefault(end.owner, []).append(Snap(end.number, triple(point), tangent))
    return found


_Cluster = tuple[list[int], int]
"""Numbers of ends that meet, and of the fixed point that they meet in; -1 for none."""


def _clusters(ends: list[_End], points: Array) -> list[_Cluster]:
    """Return which ends meet one another; each within reach of every other one or the fixed point."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(ends)
    if not count:
        return []
    own = [_nearest(end, points) for end in ends]
    links = [
        (i, j) for i in range(count) for j in range(i)
        if ends[i].owner != ends[j].owner and _apart(ends[i], ends[j]) <= 1.0
    ]  # fmt: skip
    rows = np.array(links, int).reshape(-1, 2)
    graph = coo_array((np.ones(len(rows)), (rows[:, 0], rows[:, 1])), shape=(count, count))
    _, group = connected_components(graph, directed=False)
    made: list[_Cluster] = []
    for number in range(int(group.max()) + 1):
        made += _parted(np.flatnonzero(group == number).tolist(), ends, own, points)
    return made


def _nearest(end: _End, points: Array) -> int:
    """Return the number of the fixed point that an end is meant to be at; -1 for none."""
    if not len(points):
        return -1
    ratios = end.reach.ratios(points - end.place, end.sigma)
    return int(np.argmin(ratios)) if float(ratios.min()) <= 1.0 else -1


def _parted(
    members: list[int], ends: list[_End], own: Sequence[int], points: Array
) -> Iterator[_Cluster]:
    """Yield clusters of ends that hang together, after those are left out that are too far off."""
    left = members
    while left:
        held = sorted({own[k] for k in left if own[k] >= 0})
        known = sum(ends[k].known for k in left)
        middle = np.linalg.solve(known, sum(ends[k].known @ ends[k].place for k in left))
        number = -1
        if held:
            worst = [max(_off(ends[k], points[p]) for k in left) for p in held]
            number = held[int(np.argmin(worst))]
            middle = points[number]
        off = {k: _off(ends[k], middle) for k in left}
        for k in left:  # both ends of a curve do not meet
            twins = [j for j in left if ends[j].owner == ends[k].owner]
            if len(twins) > 1 and k == max(twins, key=off.__getitem__):
                off[k] += 1.0
        worst_end = max(left, key=off.__getitem__)
        if off[worst_end] <= 1.0:
            yield left, number
            left = []
        elif len(left) == 1:
            yield left, -1
            left = []
        else:
            yield [worst_end], own[worst_end]
            left = [k for k in left if k != worst_end]


def _off(end: _End, place: Array) -> float:
    """Return how far an end is from a place, in its reaches."""
    return float(end.reach.ratios((place - end.place)[None], end.sigma)[0])


def _apart(one: _End, other: _End) -> float:
    """Return how far two ends are apart, in what both may be off."""
    way, sigma = (one.place - other.place)[None], float(np.hypot(one.sigma, other.sigma))
    return float(max(one.reach.ratios(way, sigma)[0], other.reach.ratios(way, sigma)[0]))


def _common_places(
    ends: list[_End],
    clusters: list[_Cluster],
    points: Array,
    free: Mapping[str, Free],
    state: SymmetryState,
) -> Array:
    """Return the places of clusters, (n, 3), by what all their ink says.

    Curves that were drawn along an axis of the box join places along that axis: these are
    equations that hold, and the rest is least squares.
    """
    count = len(clusters)
    places = np.zeros((count, 3))
    of_end = {}
    matrix, right = np.zeros((3 * count, 3 * count)), np.zeros(3 * count)
    for c, (members, held) in enumerate(clusters):
        rows = slice(3 * c, 3 * c + 3)
        for k in members:
            of_end[ends[k].owner, ends[k].number] = c, ends[k].side
            if held < 0:
                matrix[rows, rows] += ends[k].known
                right[rows] += ends[k].known @ ends[k].place
        if held >= 0:
            matrix[rows, rows], right[rows] = np.eye(3), points[held]
            places[c] = points[held]
    if not count:
        return places
    laws, values = [], []
    for name, each in free.items():
        if each.node.axis < 0 or each.curve.reading != "pair":
            continue
        (one, first), (two, second) = (
            of_end.get((name, 0), (-1, MIRROR)),
            of_end.get((name, 1), (-1, MIRROR)),
        )
        if min(one, two) < 0 or one == two or min(clusters[one][1], clusters[two][1]) >= 0:
            continue
        axis = _turned(AXES[each.node.axis], state)
        for way in np.linalg.svd(axis[None])[2][1:]:
            law, value = np.zeros(3 * count), 0.0
            for c, side, sign in ((one, first, 1.0), (two, second, -1.0)):
                if clusters[c][1] >= 0:
                    value -= sign * float(way @ (places[c] * side))
                else:
                    law[3 * c : 3 * c + 3] = sign * way * side
            laws.append(law)
            values.append(value)
    if not laws:
        return np.asarray(np.linalg.solve(matrix, right).reshape(-1, 3))
    law = np.stack(laws)
    zero = np.zeros((len(law), len(law)))
    whole = np.block([[matrix, law.T], [law, zero]])
    made = np.linalg.lstsq(whole, np.concatenate((right, values)), rcond=1e-12)[0]
    return np.asarray(made[: 3 * count].reshape(-1, 3))


def _continued(members: list[int], ends: list[_End], known: Array | None) -> list[Array | None]:
    """Return the direction that each end takes, if it nearly goes on another one or a known one."""
    if known is not None and known.any():
        cosines = [float(ends[k].leaving @ known) for k in members]
        return [np.copysign(1.0, c) * known if abs(c) > SMOOTH else None for c in cosines]
    ways: list[Array | None] = [None] * len(members)
    pairs = sorted(
        (float(ends[members[i]].leaving @ ends[members[j]].leaving), i, j)
        for i in range(len(members)) for j in range(i)
    )  # fmt: skip
    for cosine, i, j in pairs:
        if cosine < -SMOOTH and ways[i] is None and ways[j] is None:
            way = ends[members[i]].leaving - ends[members[j]].leaving
            way = way / np.linalg.norm(way)
            ways[i], ways[j] = way, -way
    return ways


def _moved(each: Free, snaps: tuple[Snap, ...], state: SymmetryState) -> SpaceCurve:
    """Return a curve with its ends where they settle."""
    made = [end_snap_of(snap, each.curve, each.node, state) for snap in snaps]
    node = replace(each.node, end_snaps=tuple(snap for snap in made if snap is not None))
    return with_end_snaps(each.curve, node, each.trace.sigma, state)


def _on_body(end: _End, each: Free, known: Targets, state: SymmetryState, box: bool) -> Snap | None:
    """Return where a single end settles on a curve, on the centre plane or on a face.

    These do not move with it, so it goes no farther than its own ink allows: `FARTHEST` errors of
    a hand, and no farther than a person sees it caught.
    """
    frame = state.plane.placement
    turn = frame.directions(np.eye(3)).T * end.side
    place = frame.points(end.place * end.side)[0]
    stretch, axes = np.linalg.eigh(turn @ end.known @ turn.T)
    stretch = np.sqrt(np.maximum(stretch, 0.0)) / (FARTHEST * HAND)
    shrink, grow = (axes * stretch) @ axes.T, (axes / np.maximum(stretch, LEAST**2)) @ axes.T
    leaving = _turned(end.leaving * end.side, state, back=True)
    snap = snap_within(
        end.number, place, (shrink, grow), known, state, leaving,
        within_plane=each.curve.reading == "plane", faces=box,
    )  # fmt: skip
    if snap is None:
        return None
    way = (state.plane.inverse.points(snap.point)[0] * end.side - end.place)[None]
    return snap if float(end.reach.ratios(way, end.sigma)[0]) <= 1.0 else None
