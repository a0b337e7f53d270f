"""Details in files: plain values, read carefully, laid on the surfaces of a product."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, Final, get_args

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import (
    PLANE,
    SPACE,
    Drawing,
    a_list,
    a_number,
    a_point,
    an_object,
    point_rows,
)
from bozzetto.plugin import Job
from bozzetto_product.details.drawing_outlines import drawing_outlines
from bozzetto_product.details.emblem_places import anchored
from bozzetto_product.details.ground import Ground
from bozzetto_product.details.outline_places import (
    NO_SURFACE,
    corners_on,
    laid_flat,
    places_of_points,
)
from bozzetto_product.hand_over.colors import a_color
from bozzetto_product.hand_over.point_noise import SAME
from bozzetto_product.model.details import Detail, DetailKind
from bozzetto_product.model.emblems import LONGEST_TEXT, Emblem
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.solver import grounds_of, solve_product

KEYS: Final = (
    "name", "kind", "depth", "draft", "gap", "mirrored", "color", "open",
    "outlines", "flat", "text", "drawing", "at", "up", "width", "height", "turn",
)  # fmt: skip
"""The keys of a detail."""

MOST_DETAILS: Final = 200

MOST_OUTLINES: Final = 200
"""Outlines of one detail."""

BOUNDS: Final = {"depth": (1e-3, 1e4), "draft": (0.0, 60.0), "gap": (1e-3, 1e4)}
"""Least and greatest numbers, mm and degrees."""


def with_details(
    state: ProductState, given: object, scale: float, drawings: Mapping[str, Drawing]
) -> ProductState:
    """Return the state with the details that a file describes.

    Parameters
    ----------
    state : ProductState
        With its surfaces.
    given : object
        The value of “network.details”.
    scale : float
        Millimetres in a unit of the file.
    drawings : mapping of str to Drawing
        Those that details name, by the names of their files.

    Raises
    ------
    UserError
        If something is missing, of the wrong kind, or not on a surface; the message names the key.
    """
    rows = a_list(given, "network.details", MOST_DETAILS)
    if not rows:
        return state
    grounds = grounds_of(solve_product(state, Job()).patches)
    for number, row in enumerate(rows):
        where = f"network.details[{number}]"
        values = an_object(row, where)
        unknown = sorted(set(map(str, values)) - set(KEYS))
        if unknown:
            raise UserError(f"{where} has a key “{unknown[0][:40]}”. Known are {', '.join(KEYS)}.")
        detail = _form(values, where, scale)
        if "text" in values or "drawing" in values:
            unlaid = _unlaid(values, where, drawings)
            state = state.with_node(_emblem(unlaid, values, where, scale, detail, state, grounds))
            continue
        name = detail.name or state.unused_name("Detail")
        outlines = _outlines(values, where, scale, grounds)
        corners = [corners_on(grounds, row) for row in outlines]
        places = places_of_points(outlines, corners, grounds, name)
        made = replace(detail, id=state.unused_id(), name=name, places=places)
        state = state.with_node(made)
    return state


def _form(values: Mapping[str, Any], where: str, scale: float) -> Detail:
    """Return kind and sizes of a detail."""
    kind = values.get("kind", "in")
    if kind not in get_args(DetailKind):
        raise UserError(f"“{where}.kind” is one of {', '.join(get_args(DetailKind))}.")
    name = values.get("name", "")
    if not isinstance(name, str) or len(name) > 200:
        raise UserError(f"“{where}.name” is a text.")
    flags = {key: values.get(key, False) for key in ("mirrored", "open")}
    for key, flag in flags.items():
        if not isinstance(flag, bool):
            raise UserError(f"“{where}.{key}” is true or false.")
    usual = Detail(kind=kind, name=name, mirrored=flags["mirrored"], closed=not flags["open"])
    sizes = {}
    for key, (least, greatest) in BOUNDS.items():
        if key in values:
            unit = 1.0 if key == "draft" else scale
            sizes[key] = unit * a_number(
                values[key], f"{where}.{key}", least / unit, greatest / unit
            )
    color = None
    if values.get("color") is not None:
        color = a_color(values["color"], f"{where}.color")
    return replace(
        usual,
        color=color,
        depth=sizes.get("depth", usual.depth),
        draft=sizes.get("draft", usual.draft),
        gap=sizes.get("gap", usual.gap),
    )


def _unlaid(values: Mapping[str, Any], where: str, drawings: Mapping[str, Drawing]) -> Emblem:
    """Return a text, or the outlines of a drawing, that lie nowhere yet."""
    if "drawing" not in values:
        text = values["text"]
        if not isinstance(text, str) or not 1 <= len(text.strip()) <= LONGEST_TEXT:
            raise UserError(f"“{where}.text” is a text of 1 to {LONGEST_TEXT} characters.")
        return Emblem(text=text, name="Text")
    if "text" in values:
        raise UserError(f"{where} has either “text” or “drawing”.")
    file = an_object(values["drawing"], f"{where}.drawing").get("file")
    drawing = drawings.get(file) if isinstance(file, str) else None
    if drawing is None:
        raise UserError(f"“{where}.drawing” is {{“file”: the name of a drawing beside this file}}.")
    flat, _ = drawing_outlines(drawing.strokes, drawing.name)
    return Emblem(flat=flat, name=drawing.name)


def _emblem(
    unlaid: Emblem,
    values: Mapping[str, Any],
    where: str,
    scale: float,
    form: Detail,
    state: ProductState,
    grounds: Sequence[Ground],
) -> Emblem:
    """Return a text, or the outlines of a drawing, on a surface."""
    if not grounds:
        raise UserError(NO_SURFACE)
    at, up = _place(values, where, scale)
    height = a_number(values.get("height"), f"{where}.height", 1e-2 / scale, 1e4 / scale) * scale
    turn = a_number(values.get("turn", 0.0), f"{where}.turn", -180.0, 180.0)
    shared = {field.name: getattr(form, field.name) for field in fields(Detail)}
    shared |= {"id": state.unused_id(), "name": form.name or state.unused_name(unlaid.name)}
    shared["places"] = anchored(grounds, at, up)
    return replace(unlaid, **shared, height=height, turn=turn)


def _place(values: Mapping[str, Any], where: str, scale: float) -> tuple[Array, Array]:
    """Return where something flat is laid, mm, and which way is up."""
    at = a_point(values.get("at"), f"{where}.at") * scale
    up = a_point(values.get("up", [0, 0, 1]), f"{where}.up")
    if not np.linalg.norm(up) > 0.0:
        raise UserError(f"“{where}.up” has no length.")
    return at, up


def _outlines(
    values: Mapping[str, Any], where: str, scale: float, grounds: Sequence[Any]
) -> list[Array]:
    """Return outlines in space, mm: given there, or flat ones laid on a surface."""
    if ("outlines" in values) == ("flat" in values):
        raise UserError(f"{where} needs either “outlines” in space, or “flat” ones.")
    if "outlines" in values:
        rows = a_list(values["outlines"], f"{where}.outlines", MOST_OUTLINES)
        return [
            _open_ended(point_rows(row, f"{where}.outlines[{k}]", SPACE) * scale)
            for k, row in enumerate(rows or [None])
        ]
    rows = a_list(values["flat"], f"{where}.flat", MOST_OUTLINES)
    flat = [
        _open_ended(point_rows(row, f"{where}.flat[{k}]", PLANE))
        for k, row in enumerate(rows or [None])
    ]
    at, up = _place(values, where, scale)
    width = a_number(values.get("width"), f"{where}.width", 1e-6, 1e6) * scale
    if not np.ptp(np.concatenate(flat)[:, 0]) > 0.0:
        raise UserError(f"“{where}” has outlines of no width.")
    return laid_flat(flat, at, up, width, grounds)


def _open_ended(points: Array) -> Array:
    """Return points without repetitions: a closed outline does not repeat its first."""
    least = SAME * float(np.linalg.norm(np.ptp(points, axis=0)))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    kept = points[np.concatenate(([True], steps > least))]
    if len(kept) > 1 and np.linalg.norm(kept[0] - kept[-1]) <= least:
        kept = kept[:-1]
    if len(kept) < 3:
        raise UserError("An outline of a detail needs at least three points that differ.")
    return np.asarray(kept)
