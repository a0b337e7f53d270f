"""Ink JSON (``bozzetto-ink/1``): every sample, column and camera, in plain text.

``x`` and ``y`` are canvas pixels, y down; ``pressure`` is 0 … 1, ``t`` seconds. All but
``x`` and ``y`` may be left out. ``curve`` is the stroke's group; a number is taken for its
digits. A stroke that was drawn through another camera than the sheet's carries its own
``camera`` and ``canvas``.
``steps`` say how the strokes were used; see `exchange.ink_steps`.

An object with none of these keys is a drawing without ink: facts for the modeler that knows
them, such as the marks on a sketch. It may have a ``format`` of its own.
"""

from __future__ import annotations

import codecs
import re
from typing import Annotated, Any, Final, Literal

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.camera_record import (
    CameraRecord,
    CanvasRecord,
    camera_from,
    camera_record,
    canvas_record,
)
from bozzetto.exchange.ink.ink_steps import decode_json, read_steps, step_record
from bozzetto.exchange.limits import MAX_COORDINATE, MAX_SAMPLES, MAX_STROKES, at_most
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.stroke import COLUMNS, Stroke, Strokes
from bozzetto.ink.stroke import MAX_SAMPLES as MAX_SAMPLES_OF_STROKE
from bozzetto.json_size import MAX_VALUES, json_values
from bozzetto.view.camera import Camera

FORMAT: Final = "bozzetto-ink/1"

NEEDED: Final = ("format", "canvas", "camera", "strokes")
KNOWN: Final = (*NEEDED, "steps")

MAX_NUMBERS: Final = 32_000_000
"""Values of a file: half of what a file of 64 MB has room for."""

MAX_KEYS: Final = 10_000
"""Keys at the top that are facts for a modeler."""

Number = Annotated[float, Meta(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
Numbers = list[Number]
Byte = Annotated[int, Meta(ge=0, le=255)]


class _StrokeRecord(msgspec.Struct):
    x: Numbers
    y: Numbers
    pressure: Numbers | None = None
    t: Numbers | None = None
    tilt_x: Numbers | None = None
    tilt_y: Numbers | None = None
    twist: Numbers | None = None
    tool: Literal["pen", "eraser", "mouse", "imported"] = "pen"
    color: tuple[Byte, Byte, Byte] | None = None
    curve: Annotated[str, Meta(max_length=1000)] | int = ""
    camera: CameraRecord | None = None
    canvas: CanvasRecord | None = None


def read_drawing(data: bytes, name: str) -> Drawing:
    """Read ink JSON.

    Parameters
    ----------
    data : bytes
        Content of the file.
    name : str
        Name of the drawing.

    Returns
    -------
    Drawing
        What the file says beyond canvas, camera and strokes is in `Drawing.facts`. One that
        says nothing of these has no strokes, and the camera of an empty sheet.

    Raises
    ------
    FormatError
        Names the place.
    """
    at_most(json_values(data), MAX_NUMBERS, "values")
    top = decode_json(data.removeprefix(codecs.BOM_UTF8), dict[str, msgspec.Raw], "the file")
    if top and not any(key in top for key in KNOWN):
        return Drawing(Strokes(), Camera(), name, _facts(top))
    if len(top) > 1 and not any(key in top for key in KNOWN[1:]) and _is_foreign(top["format"]):
        own = {"format": decode_json(top.pop("format"), str, "format")}
        return Drawing(Strokes(), Camera(), name, own | _facts(top))
    if NEEDED[0] not in top or decode_json(top["format"], str, "format") != FORMAT:
        raise FormatError(f"This is not ink JSON: “format” must be “{FORMAT}”.")
    for key in NEEDED[1:]:
        if key not in top:
            raise FormatError(f"“{key}” is missing.")
    canvas = decode_json(top["canvas"], CanvasRecord, "canvas")
    camera = camera_from(decode_json(top["camera"], CameraRecord, "camera"), canvas)
    raw = decode_json(top["strokes"], list[msgspec.Raw], "strokes")
    at_most(len(raw), MAX_STROKES, "strokes")
    strokes: list[Stroke] = []
    samples = 0
    for number, text in enumerate(raw, 1):
        strokes.append(_stroke(text, number, camera, canvas))
        samples += len(strokes[-1])
        at_most(samples, MAX_SAMPLES, "samples")
    steps = read_steps(top["steps"], canvas, len(strokes)) if "steps" in top else ()
    return Drawing(Strokes(strokes), camera, name, _facts(top), steps)


def _is_foreign(format_: msgspec.Raw) -> bool:
    """Whether a file says that it is of a format of somebody else's."""
    return not decode_json(format_, str, "format").startswith(FORMAT.partition("/")[0])


def _facts(top: dict[str, msgspec.Raw]) -> dict[str, Any]:
    rest = [key for key in top if key not in KNOWN]
    at_most(len(rest), MAX_KEYS, "keys")
    at_most(sum(json_values(bytes(top[key])) for key in rest), MAX_VALUES, "values")
    return {key: decode_json(top[key], Any, key[:40]) for key in rest}


def _stroke(text: msgspec.Raw, number: int, camera: Camera, canvas: CanvasRecord) -> Stroke:
    place = f"stroke {number}"
    at_most(json_values(bytes(text)), len(COLUMNS) * MAX_SAMPLES_OF_STROKE, "numbers in a stroke")
    record: _StrokeRecord = decode_json(text, _StrokeRecord, place)
    columns = {name: getattr(record, name) for name in COLUMNS}
    for name, values in columns.items():
        if values is not None and len(values) != len(record.x):
            raise FormatError(f"{place}: x and {name} differ in length.")
    try:
        if record.camera is not None:
            camera = camera_from(record.camera, record.canvas or canvas)
        x, y = columns.pop("x"), columns.pop("y")
        return Stroke(
            x, y, camera, **columns, tool=record.tool, color=record.color, group=str(record.curve)
        )
    except UserError as error:
        raise FormatError(f"{place}: {error.message}") from error


def write_drawing(drawing: Drawing) -> bytes:
    """Write ink JSON that reads back as an equal drawing."""
    top = {
        "format": FORMAT,
        "canvas": canvas_record(drawing.camera),
        "camera": camera_record(drawing.camera),
        **{key: value for key, value in drawing.facts.items() if key not in KNOWN},
        "strokes": [_record(stroke, drawing.camera) for stroke in drawing.strokes],
    }
    if drawing.steps:
        top["steps"] = [step_record(step) for step in drawing.steps]
    # One stroke a line: two versions of a drawing can then be compared as text.
    return re.sub(rb'\{"x":', b'\n{"x":', msgspec.json.encode(top)) + b"\n"


def _record(stroke: Stroke, camera: Camera) -> dict[str, Any]:
    record: dict[str, Any] = {"x": _shortest(stroke.x), "y": _shortest(stroke.y)}
    if stroke.has_pressure:
        record["pressure"] = _shortest(stroke.pressure)
    if stroke.has_time:
        record["t"] = _shortest(stroke.t)
    for name in ("tilt_x", "tilt_y", "twist"):
        column = getattr(stroke, name)
        if column.any():
            record[name] = _shortest(column)
    if stroke.tool != "pen":
        record["tool"] = stroke.tool
    if stroke.color is not None:
        record["color"] = stroke.color
    if stroke.group:
        record["curve"] = stroke.group
    if stroke.camera != camera:
        record["camera"] = camera_record(stroke.camera)
        record["canvas"] = canvas_record(stroke.camera)
    return record


def _shortest(column: NDArray[np.float32]) -> list[float]:
    """Return the shortest decimals that give the same float32."""
    return [float(str(value)) for value in column]
