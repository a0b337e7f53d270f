"""The box and the centre plane as ink files give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, get_args

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, is_one_view, on_canvas
from bozzetto.scene import Lines, Scene, Shaded
from bozzetto.view import triple
from bozzetto_symmetry.model.axes import AXES
from bozzetto_symmetry.model.state import AskedReading, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane

SIZE_LIMITS: Final = (0.1, 1e6)
"""Least and greatest edge of a box, mm; as in the form."""

FARTHEST: Final = 1e7
"""Greatest coordinate, mm."""

SYMMETRIES: Final = {"x": "length", "y": "width", "z": "height"}
"""The box's own planes of symmetry by the axis that they are square to."""

COINCIDENT: Final = 1e-9
"""Difference of unit normals, and share of the box's diagonal between planes, below which a
plane is the box's own."""

LEAST_SEEN: Final = 0.4
"""Share of its length that an axis is taken to be seen at, however short it is seen."""

FIGURES: Final = 2
"""Digits of the edges of a box around ink or around other objects."""

UNLIKE: Final = 4.0
"""How many times as large as the usual box what is visible may be, or the box as that."""

ROOM: Final = 1.1
"""Edges of a box about other objects, in lengths of theirs."""

LEAST_SHARE: Final = 0.25
"""Its shortest edge, as share of the longest of theirs."""


def box_facts(facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the facts of a drawing change in a state.

    Parameters
    ----------
    facts : mapping
        Plain JSON values that nobody has checked. ``"box"`` is ``[l, w, h]``, or
        ``{"center": [x, y, z], "size": [l, w, h]}``, or ``{"min": […], "max": […]}``, or
        ``{"length": l, "width": w, "height": h}`` with or without ``"center"``. ``"plane"``
        is ``"x"``, ``"y"`` or ``"z"`` for the plane through the middle of the box that is
        square to that axis, ``"y = 0"`` and the like for one at a coordinate, or
        ``{"point": […], "normal": […]}``, or
        ``{"normal": n, "offset": d}`` for n · p = d, or ``[a, b, c, d]`` for
        a x + b y + c z + d = 0. Other keys are left alone.

    Returns
    -------
    dict
        Fields of `SymmetryState` with their new values; only those that the facts give.

    Raises
    ------
    UserError
        If a box or plane cannot be read; the message names the place.
    """
    changes: dict[str, Any] = {}
    if facts.get("box") is not None:
        centre, size = _box(facts["box"])
        changes["centre"] = tuple(centre.tolist())
        changes["length"], changes["width"], changes["height"] = size.tolist()
    if facts.get("plane") is not None:
        changes |= _plane(facts["plane"], SymmetryState(**changes))
    return changes


def readings_of(facts: Mapping[str, Any]) -> dict[str, AskedReading]:
    """Return what the facts of a drawing say that its curves are.

    Parameters
    ----------
    facts : mapping
        ``"readings"`` names a reading for some curves, by the names of their strokes:
        ``"auto"``, ``"pair"``, ``"self"``, ``"plane"`` or ``"half"``.

    Raises
    ------
    UserError
        If it is something else.
    """
    value = facts.get("readings", {})
    if not isinstance(value, Mapping):
        raise UserError("“readings” is no list of names. Give one reading for each curve.")
    for name, reading in value.items():
        if reading not in get_args(AskedReading):
            known = ", ".join(f"“{r}”" for r in get_args(AskedReading))
            raise UserError(f"“readings” of “{str(name)[:40]}”: there are {known}.")
    return dict(value)


def box_around(strokes: Sequence[Stroke], plane: CentrePlane) -> dict[str, Any]:
    """Return a box for a drawing that gives none: its picture has room for all the ink.

    It stands in the middle of the first view, on both sides of the centre plane. Along every
    axis it is as long as the ink is wide on the sheet, and longer the more that axis is
    foreshortened.

    Parameters
    ----------
    strokes : sequence of Stroke
        At least one.
    plane : CentrePlane
        That of the drawing.

    Returns
    -------
    dict
        Fields of `SymmetryState` with their values.
    """
    camera = strokes[0].camera
    normal, target = np.asarray(plane.normal), np.asarray(camera.target)
    centre = target - normal * float((target - plane.point) @ normal)
    middle, _ = camera.project(centre)
    here = [stroke for stroke in strokes if is_one_view(stroke.camera, camera)]
    ink = np.concatenate([on_canvas(stroke, camera).points for stroke in here])
    if not np.isfinite(middle).all():
        middle = 0.5 * np.asarray([camera.viewport])
    reach = 2.0 * float(np.abs(ink - middle).max()) / camera.pixels_per_mm
    seen = np.sqrt(np.clip(1.0 - camera.axes[2] ** 2, LEAST_SEEN**2, 1.0))
    edges = np.clip([float(f"{v:.{FIGURES}g}") for v in reach / seen], *SIZE_LIMITS)
    length, width, height = edges.tolist()
    x, y, z = (float(v) + 0.0 for v in np.clip(centre, -FARTHEST, FARTHEST))
    return {"centre": (x, y, z), "length": length, "width": width, "height": height}


def box_about(scene: Scene) -> dict[str, Any]:
    """Return a box about what is visible, where the usual one would be far too small or too large.

    It stands where that stands. Objects on both sides of the plane y = 0, as cars are, have it in
    the middle: it is the centre plane.

    Parameters
    ----------
    scene : Scene
        What other objects show.

    Returns
    -------
    dict
        Fields of `SymmetryState` with their values; empty where the usual box is as good.
    """
    bounds = scene.of_kinds(Shaded, Lines).bounds()
    if not np.isfinite(bounds).all():
        return {}
    middle, span = bounds.mean(axis=0), np.ptp(bounds, axis=0)
    largest, usual = float(span.max()), SymmetryState().length
    if usual / UNLIKE <= largest <= usual * UNLIKE or largest == 0.0:
        return {}
    if bounds[0, 1] < 0.0 < bounds[1, 1]:
        middle[1], span[1] = 0.0, 2.0 * float(np.abs(bounds[:, 1]).max())
    wanted = np.maximum(ROOM * span, LEAST_SHARE * largest)
    edges = np.clip([float(f"{v:.{FIGURES}g}") for v in wanted], *SIZE_LIMITS)
    length, width, height = edges.tolist()
    middle[2] = bounds[0, 2] + 0.5 * height
    x, y, z = (float(f"{v:.{FIGURES + 1}g}") + 0.0 for v in np.clip(middle, -FARTHEST, FARTHEST))
    return {"centre": (x, y, z), "length": length, "width": width, "height": height}


# -- the box ---------------------------------------------------------------------------------


def _box(value: object) -> tuple[Array, Array]:
    """Return centre and size."""
    if not isinstance(value, Mapping):
        return np.zeros(3), _size(value, "box")
    value = {"center" if key == "centre" else key: part for key, part in value.items()}
    keys = set(value)
    if keys == {"min", "max"}:
        low, high = _place(value["min"], "box.min"), _place(value["max"], "box.max")
        if not (low < high).all():
            raise UserError(
                "“box”: “min” is not below “max”. Give the lower corner as “min” and the upper "
                "one as “max”."
            )
        return 0.5 * (low + high), _size((high - low).tolist(), "box")
    if keys - {"center"} == {"size"}:
        size = _size(value["size"], "box.size")
    elif keys - {"center"} == {"length", "width", "height"}:
        size = _size([value[name] for name in ("length", "width", "height")], "box")
    else:
        raise UserError(
            "“box” holds other keys than it can. Give “center” and “size”, or “min” and “max”, "
            "or “length”, “width” and “height”."
        )
    return (_place(value["center"], "box.center") if "center" in value else np.zeros(3)), size


def _size(value: object, key: str) -> Array:
    size = _numbers(value, key, 3, "length, width and height in millimetres")
    least, most = SIZE_LIMITS
    if not ((size >= least) & (size <= most)).all():
        raise UserError(f"“{key}”: a box's edges are from {least:g} to {most:,.0f} mm. Change it.")
    return size


# -- the plane -------------------------------------------------------------------------------


def _plane(value: object, state: SymmetryState) -> dict[str, Any]:
    if isinstance(value, str) and value in SYMMETRIES:
        return {"symmetry": SYMMETRIES[value]}
    point, normal = _point_and_normal(value)
    plane = CentrePlane(triple(point), triple(normal))
    aside = abs(float((np.asarray(state.centre) - plane.point) @ plane.normal))
    for axis, symmetry in zip(AXES, SYMMETRIES.values(), strict=True):
        turned = float(np.abs(np.abs(plane.normal) - axis).max())
        if turned <= COINCIDENT and aside <= COINCIDENT * state.diagonal:
            return {"symmetry": symmetry}
    return {"symmetry": "free", "free_plane": plane}


def _point_and_normal(value: object) -> tuple[Array, Array]:
    if isinstance(value, str):
        return _at_coordinate(value)
    if isinstance(value, Mapping):
        if set(value) == {"point", "normal"}:
            return _place(value["point"], "plane.point"), _normal(value["normal"], "plane.normal")
        if set(value) == {"normal", "offset"}:
            normal = _normal(value["normal"], "plane.normal")
            (offset,) = _numbers([value["offset"]], "plane.offset", 1, "the distance")
            return _foot(normal, float(offset), "plane.offset"), normal
        raise UserError(
            "“plane” holds other keys than it can. Give “point” and “normal”, or “normal” and "
            "“offset”."
        )
    numbers = _numbers(value, "plane", 4, "a, b, c and d of a x + b y + c z + d = 0")
    normal = _normal(numbers[:3].tolist(), "plane")
    return _foot(normal, -float(numbers[3]), "plane"), normal


def _at_coordinate(value: str) -> tuple[Array, Array]:
    """Return the plane that "y = 0" and the like describe."""
    name, _, number = value.partition("=")
    try:
        axis = AXES[list(SYMMETRIES).index(name.strip())]
        offset = float(number)
    except ValueError:
        raise UserError(
            f"“plane” is “{value[:20]}”. Give “x”, “y” or “z”, or “y = 0”, or a normal."
        ) from None
    return _foot(axis, offset, "plane"), axis


def _foot(normal: Array, offset: float, key: str) -> Array:
    """Return the place of the plane n · p = d that is nearest to the origin."""
    point = normal * (offset / float(normal @ normal))
    return _place(point.tolist(), key)


def _normal(value: object, key: str) -> Array:
    normal = _numbers(value, key, 3, "a direction")
    if not 1.0 / FARTHEST < float(np.abs(normal).max()) < FARTHEST:
        raise UserError(f"“{key}” has no direction. Give one of about unit length.")
    return normal


# -- numbers ---------------------------------------------------------------------------------


def _place(value: object, key: str) -> Array:
    place = _numbers(value, key, 3, "a place in millimetres")
    if not (np.abs(place) <= FARTHEST).all():
        raise UserError(f"“{key}” is too far away. Stay within {FARTHEST:,.0f} mm of the origin.")
    return place


def _numbers(value: object, key: str, count: int, meaning: str) -> Array:
    """Return finite numbers out of a list of anything."""
    if (
        not isinstance(value, list | tuple)
        or len(value) != count
        or not all(_is_number(entry) for entry in value)
    ):
        raise UserError(f"“{key}” needs {count} plain number{'s' * (count > 1)}: {meaning}.")
    return np.array(value, float)


def _is_number(value: object) -> bool:
    """Return whether a JSON value is a number that is finite as a float."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return bool(np.isfinite(float(value)))
    except OverflowError:
        return False
