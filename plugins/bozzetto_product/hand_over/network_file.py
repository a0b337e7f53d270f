"""Networks of curves in files: plain values, read carefully, become a recipe."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias, get_args

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import (
    SPACE,
    a_list,
    a_number,
    an_object,
    point_rows,
)
from bozzetto.plugin import Job
from bozzetto_product.hand_over.colors import a_color
from bozzetto_product.hand_over.equal_curves import equal_curves
from bozzetto_product.hand_over.names import piece_names
from bozzetto_product.hand_over.near_rings import ring_of_row
from bozzetto_product.hand_over.network_joints import joined_state
from bozzetto_product.hand_over.overlaps import without_overlaps
from bozzetto_product.hand_over.point_fit import (
    closed_spline_through,
    smoothed_spline,
    spline_through,
)
from bozzetto_product.hand_over.point_joints import ON_CURVE
from bozzetto_product.hand_over.point_noise import SAME, noise_of, rounding_of
from bozzetto_product.model.appearance import Finish
from bozzetto_product.model.curve_stretch import with_stretch
from bozzetto_product.model.curves import Curve, EdgeKind, Stretch
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.solver import net_of_state

KEYS: Final = ("curves", "loops", "creases", "pressure", "paint", "details")
"""The keys of a network."""

UNITS: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Millimetres in a unit of length."""

MOST_CURVES: Final = 2000
"""Curves of a network; the largest of the chapter has 107."""

FIT: Final = 1e-4
"""Tolerance of the fit of a curve to its points, as share of the diagonal of the network."""

FINE: Final = 1e-5
"""Tolerance where the points of a curve are smooth enough for it: its tangents are right to a few
hundredths of a degree then, so that surfaces can be smooth over them."""

NOISE: Final = 3.5
"""Greatest distance of a point that trembles from its curve, in standard deviations."""

SEAM: Final = np.radians(25.0)
"""A curve that ends where it began, and turns there by more than this, has a corner there."""


OfSurfaces: TypeAlias = Mapping[frozenset[str], Mapping[str, Any]]
"""Values of surfaces by their parameters, by the names of the curves round each."""


@dataclass(frozen=True)
class Network:
    """A network as a file gives it.

    Parameters
    ----------
    state : ProductState
        Curves and joints; no surfaces yet.
    loops : tuple of tuple of str
        Names of the curves or pieces round each surface; None where they are to be found.
    pressure, paint : mapping of frozenset of str to mapping of str to object
        Values of surfaces, by the names of the curves round each.
    tolerance : float
        Greatest distance of a point of the file from its curve, mm.
    details : object
        As the file gives them; see `with_details`.
    scale : float
        Millimetres in a unit of the file.
    rounding : float
        Step to which its coordinates are rounded, mm.
    """

    state: ProductState
    loops: tuple[tuple[str, ...], ...] | None
    pressure: OfSurfaces
    paint: OfSurfaces
    tolerance: float
    details: object = ()
    scale: float = 1.0
    rounding: float = 0.0


def network_of(facts: Mapping[str, Any], job: Job | None = None) -> Network:
    """Return the network that a file describes.

    A curve that is another one again is left out, and its name stands for the first one.

    Parameters
    ----------
    facts : mapping of str to object
        What the file says.
    job : Job, optional
        Can be cancelled between curves.

    Raises
    ------
    UserError
        If something is missing, or of the wrong kind or size; the message names the key.
    """
    given = an_object(facts.get("network"), "network")
    unknown = sorted(set(map(str, given)) - set(KEYS))
    if unknown:
        raise UserError(f"“network” has a key “{unknown[0][:40]}”. Known are {', '.join(KEYS)}.")
    unit = facts.get("unit", "mm")
    if not isinstance(unit, str) or unit not in UNITS:
        raise UserError(f"“unit” is one of {', '.join(UNITS)}.")
    rows = _rows(given.get("curves"), UNITS[unit])
    size = float(np.linalg.norm(np.ptp(np.vstack(list(rows.values())), axis=0)))
    told = _numbers(given.get("creases", {}), "creases", rows)
    creases = {name: number for name, number in told.items() if name in rows}
    rounding = UNITS[unit] * rounding_of(
        np.vstack(list(rows.values())) / UNITS[unit], size / UNITS[unit]
    )
    noise = NOISE * noise_of(rows.values(), size)
    exact, fine = (max(share * size, rounding) for share in (FIT, FINE))
    tolerance = max(exact, noise)
    alone = _ending_alone(list(rows.values()), max(ON_CURVE * size, tolerance))
    job = Job() if job is None else job
    splines: list[Spline] = []
    for (name, points), lone in zip(rows.items(), alone, strict=True):
        job.checkpoint(len(splines) / len(rows), name)
        fitted = _spline(points, name, size, tolerance, 0.0 if noise > exact else fine, lone)
        splines.append(fitted)
    names = list(rows)
    again = {names[k]: names[first] for k, first in equal_curves(splines, tolerance).items()}
    pieces = {
        _first_name(name, "network.creases", again): number
        for name, number in told.items()
        if name not in rows
    }
    for name, first in again.items():
        if name in creases:
            creases.setdefault(first, creases[name])
    whole = splines
    splines = without_overlaps(whole, max(ON_CURVE * size, tolerance), size)
    kept = [row for row in zip(names, splines, whole, strict=True) if row[0] not in again]
    curves = tuple(
        _creased(Curve(f"n{number}", name, spline=spline), creases.get(name))
        for number, (name, spline, _) in enumerate(kept, 1)
    )
    cut = {
        (curve.id, float(-end))
        for curve, (_, spline, before) in zip(curves, kept, strict=True)
        for end in (0, -1)
        if (spline.control_points[end] != before.control_points[end]).any()
    }
    state = joined_state(curves, size, tolerance / FIT, cut)
    state = _with_creased_pieces(state, pieces)
    loops = None if given.get("loops") is None else _loops(given["loops"], rows, again)
    return Network(
        state,
        loops,
        _of_surfaces(given.get("pressure", {}), "pressure", rows, again, _pressure),
        _of_surfaces(given.get("paint", {}), "paint", rows, again, _paint),
        tolerance,
        given.get("details", ()),
        UNITS[unit],
        rounding,
    )


def _rows(value: object, scale: float) -> dict[str, Array]:
    entries = a_list(value, "network.curves", MOST_CURVES)
    if not entries:
        raise UserError("“network.curves” is empty. Give at least one curve with its points.")
    rows: dict[str, Array] = {}
    for number, entry in enumerate(entries):
        where = f"network.curves[{number}]"
        curve = an_object(entry, where)
        unknown = sorted(set(map(str, curve)) - {"name", "points"})
        if unknown:
            raise UserError(f"{where} has a key “{unknown[0][:40]}”. Known are name, points.")
        name = curve.get("name", f"c{number + 1}")
        if not isinstance(name, str) or not 1 <= len(name) <= 200:
            raise UserError(f"{where}.name is a text of 1 to 200 letters. Give it one, or none.")
        plain = " ".join(name.replace("/", " ").split())
        if plain != name:
            raise UserError(
                f"The name “{name[:80]}” has a “/”, which tells pieces apart, or blanks in a row "
                f"or at an end. Call the curve “{plain[:80] or 'c'}”, here and in loops."
            )
        if name in rows:
            raise UserError(f"Two curves are called “{name}”. Give each its own name.")
        rows[name] = _points(curve.get("points"), f"{where}.points", scale)
    return rows


def _points(value: object, where: str, scale: float) -> Array:
    points = point_rows(value, where, SPACE) * scale
    _, farthest = SPACE
    if not (np.abs(points) <= farthest).all():
        raise UserError(f"“{where}” reaches further than {farthest:g} mm.")
    return points


def _ending_alone(rows: Sequence[Array], reach: float) -> list[bool]:
    """Return of each row of points whether no other one ends where it begins or ends."""
    from scipy.spatial import cKDTree

    ends = np.concatenate([row[[0, -1]] for row in rows])
    near = cKDTree(ends).query_ball_point(ends, reach)
    return [
        all(end // 2 == number for end in (*near[2 * number], *near[2 * number + 1]))
        for number in range(len(rows))
    ]


def _spline(
    points: Array, name: str, size: float, tolerance: float, fine: float, alone: bool
) -> Spline:
    """Return the spline through the points of a curve; closed where it returns smoothly.

    A fine tolerance of 0 says that they tremble. What ends alone may stop short of its start.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    kept = points[np.concatenate(([True], steps > SAME * size))]
    if len(kept) < 2 or not size > 0.0:
        raise UserError(f"All points of the curve “{name}” lie in one place. Spread them out.")
    # The end stays the very number of the file: ends that coincide there do so here.
    kept = np.vstack((kept[:-1], points[-1:]))
    is_ring = len(kept) > 5 and np.linalg.norm(kept[-1] - kept[0]) <= SAME * size
    if is_ring and not _has_corner(kept):
        return closed_spline_through(kept[:-1], tolerance, fine or tolerance)
    ring = None
    if alone and not is_ring:
        ring = ring_of_row(kept, size, tolerance, 0.0 if fine else tolerance / NOISE)
    if ring is not None:
        return closed_spline_through(ring, tolerance, fine or tolerance)
    return spline_through(kept, tolerance, fine) if fine else smoothed_spline(kept, FIT * size)


def _has_corner(ring: Array) -> bool:
    """Whether a ring of points turns sharply at its seam, more than near by."""
    into, out = ring[-1] - ring[-2], ring[1] - ring[0]
    lengths = np.linalg.norm(into) * np.linalg.norm(out)
    turn = float(np.arccos(np.clip(into @ out / lengths, -1.0, 1.0)))
    inner = np.diff(ring, axis=0)
    inner /= np.linalg.norm(inner, axis=1, keepdims=True)
    turns = np.arccos(np.clip((inner[1:] * inner[:-1]).sum(axis=1), -1.0, 1.0))
    return bool(turn > max(SEAM, 1.5 * float(np.max(turns[[0, -1]]))))


KINDS: Final[Mapping[float, EdgeKind]] = {0.0: "smooth", 1.0: "crease"}
"""Kinds of edges by their crease."""


def _creased(curve: Curve, crease: float | None) -> Curve:
    if crease is None:
        return curve
    return replace(curve, edge=KINDS.get(crease, "between"), crease=crease)


def _with_creased_pieces(state: ProductState, creases: Mapping[str, float]) -> ProductState:
    """Return a network whose pieces meet as a file says, by their names."""
    if not creases:
        return state
    net = net_of_state(state)
    names = piece_names(net, state.of_kind(Curve))
    for name, crease in creases.items():
        found = next((net.edges[k] for k, own in enumerate(names) if own == name), None)
        if found is None:
            whole = name.partition("/")[0]
            count = sum(own.partition("/")[0] == whole for own in names)
            raise UserError(
                f"“network.creases” names a piece “{name[:40]}”; “{whole[:40]}” has {count}, where "
                "curves meet it."
            )
        chosen = Stretch(*found.span, KINDS.get(crease, "between"), crease)
        curve = next(one for one in state.of_kind(Curve) if one.id == found.curve)
        state = state.with_node(with_stretch(curve, *found.span, chosen))
    return state


def _loops(
    value: object, rows: Mapping[str, Array], again: Mapping[str, str]
) -> tuple[tuple[str, ...], ...]:
    loops = []
    for number, entry in enumerate(a_list(value, "network.loops", 4 * MOST_CURVES)):
        where = f"network.loops[{number}]"
        names = a_list(entry, where, MOST_CURVES)
        if not names:
            raise UserError(f"“{where}” is empty. Name the curves round the surface.")
        for name in names:
            _known(name, where, rows)
        loops.append(tuple(_first_name(name, where, again) for name in names))
    return tuple(loops)


def _known(name: object, where: str, rows: Mapping[str, Array]) -> None:
    if not isinstance(name, str) or name.partition("/")[0] not in rows:
        raise UserError(f"“{where}” names a curve “{str(name)[:40]}” that is not there.")


def _first_name(name: str, where: str, again: Mapping[str, str]) -> str:
    """Return the name of the first of curves that are the same."""
    whole, cut, _ = name.partition("/")
    if cut and whole in again:
        raise UserError(
            f"“{where}” names a piece of “{whole[:40]}”, which is the same curve as "
            f"“{again[whole][:40]}”. Name the piece of that one."
        )
    return again.get(name, name)


def _numbers(value: object, where: str, rows: Mapping[str, Array]) -> dict[str, float]:
    """Return numbers from 0 to 1 by the names of curves and pieces."""
    made = {}
    for name, number in an_object(value, f"network.{where}").items():
        _known(name, f"network.{where}", rows)
        made[str(name)] = a_number(number, f"network.{where}.{name}", 0.0, 1.0)
    return made


def _of_surfaces(
    value: object,
    title: str,
    rows: Mapping[str, Array],
    again: Mapping[str, str],
    read: Callable[[object, str], Mapping[str, Any]],
) -> OfSurfaces:
    made = {}
    for names, given in an_object(value, f"network.{title}").items():
        listed = _names_in(str(names), rows)
        for name in listed:
            _known(name, f"network.{title}", rows)
        where = f"network.{title}.{str(names)[:40]}"
        key = frozenset(_first_name(name, where, again) for name in listed)
        made[key] = read(given, where)
    return made


def _pressure(value: object, where: str) -> Mapping[str, Any]:
    return {"pressure": a_number(value, where, -2.0, 2.0)}


def _paint(value: object, where: str) -> Mapping[str, Any]:
    """Return colour, finish and name of a surface, as far as they are told."""
    given = an_object(value, where)
    unknown = sorted(set(map(str, given)) - {"color", "finish", "name"})
    if unknown:
        raise UserError(f"“{where}” has a key “{unknown[0][:40]}”. Known are color, finish, name.")
    made: dict[str, Any] = {}
    if given.get("color") is not None:
        made["color"] = a_color(given["color"], f"{where}.color")
    if "finish" in given:
        if given["finish"] not in get_args(Finish):
            raise UserError(f"“{where}.finish” is one of {', '.join(get_args(Finish))}.")
        made["finish"] = given["finish"]
    if "name" in given:
        name = given["name"]
        if not isinstance(name, str) or not 1 <= len(name.strip()) <= 200:
            raise UserError(f"“{where}.name” is a text of 1 to 200 letters.")
        made["name"] = name.strip()
    return made


def _names_in(text: str, rows: Mapping[str, Array]) -> list[str]:
    """Return names that blanks part and may have some themselves: the longest there is, each time.

    What is no name is one word.
    """
    words = text.split()
    names = []
    while words:
        starts = {" ".join(words[:end]): end for end in range(len(words), 0, -1)}
        told = (name for name in starts if re.sub(r"/\d+$", "", name) in rows)
        name = next(told, words[0])
        names.append(name)
        words = words[starts[name] :]
    return names
