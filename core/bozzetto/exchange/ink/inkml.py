"""InkML (W3C Recommendation, 2011): ink of other programs, and ours for them.

What InkML has no place for (camera, tool, group) is written as annotations and as
attributes in a namespace of our own, so that our own files come back exactly.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, Final
from xml.sax.saxutils import escape, quoteattr

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.camera_record import (
    CameraRecord,
    CanvasRecord,
    camera_from,
    camera_record,
    canvas_record,
)
from bozzetto.exchange.ink.ink_steps import decode_json
from bozzetto.exchange.limits import MAX_COORDINATE, MAX_SAMPLES, MAX_STROKES, at_most
from bozzetto.exchange.page_layout import Sheet
from bozzetto.exchange.safe_xml import Element, parse_xml, writable
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.stroke import MAX_SAMPLES as MAX_STROKE
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.view.camera import Camera

SPACE: Final = "http://www.w3.org/2003/InkML"
OURS: Final = "urn:bozzetto:ink"

COLUMN_OF: Final = {
    "X": "x", "Y": "y", "F": "pressure", "T": "t", "OTX": "tilt_x", "OTY": "tilt_y", "OR": "twist",
}  # fmt: skip
"""Our columns by the channel's name (section 2.2.5), in capitals."""

CHANNEL_OF: Final = {
    "x": "X", "y": "Y", "pressure": "F", "t": "T", "tilt_x": "OTx", "tilt_y": "OTy", "twist": "OR",
}  # fmt: skip

MILLIMETRES: Final = {
    "mm": 1.0,
    "cm": 10.0,
    "m": 1000.0,
    "in": 25.4,
    "pt": 25.4 / 72,
    "pc": 25.4 / 6,
    "himetric": 0.01,
}
SECONDS: Final = {"s": 1.0, "ms": 1e-3}
DEGREES: Final = {"deg": 1.0, "rad": 180.0 / np.pi}
UNITS: Final = {**MILLIMETRES, **SECONDS, **DEGREES}

# Blanks are taken as they come, and no quantifier gives anything back: one pass, whatever it is.
VALUE: Final = re.compile(
    r"\s++|([!'\"]?+)\s*+([+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+"
    r"|[+-]?#[0-9A-Fa-f]{1,15}+|[*?TF])|(\S)"
)

MOST_CHANNELS: Final = 32
"""Columns of one trace; a pen has a dozen."""

Annotation = dict[str, str]


@dataclass(frozen=True)
class _Channel:
    """A column of the traces.

    Attributes
    ----------
    name : str
    unit : float, optional
        What 1 stands for, in mm, s or degrees; None where the file does not say.
    top : float, optional
        Largest value of the device.
    """

    name: str
    unit: float | None = None
    top: float | None = None


@dataclass(frozen=True)
class _Trace:
    columns: dict[str, NDArray[np.float64]]
    element: Element


@dataclass
class _Ink:
    """Definitions and traces found so far."""

    formats: dict[str, list[_Channel]] = field(default_factory=dict)
    traces: list[_Trace] = field(default_factory=list)
    notes: Annotation = field(default_factory=dict)
    samples: int = 0


PLAIN: Final = [_Channel("X"), _Channel("Y")]


# -- reading -------------------------------------------------------------------------------


def read_drawing(data: bytes, name: str) -> Drawing:
    """Read the traces of an InkML file.

    Channels X, Y, F, T, OTx, OTy and OR are understood, in any trace format; others are
    ignored. Without our camera the unit is a millimetre on the front view, where the
    file names no other.

    Parameters
    ----------
    data : bytes
        Content of the file.
    name : str
        Name of the drawing.

    Raises
    ------
    FormatError
    """
    root = parse_xml(data)
    if root.tag != "ink":
        raise FormatError("This is not an InkML file.")
    ink = _Ink()
    _find_formats(root, ink)
    _walk(root, "", ink)
    if not ink.traces:
        raise FormatError("There is no ink in this file.")
    shift = np.zeros(2)
    told: tuple[str, ...] = ()
    if "bozzetto-camera" in ink.notes:
        camera = _camera(ink.notes["bozzetto-camera"])
    else:
        points = [np.column_stack((t.columns["x"], t.columns["y"])) for t in ink.traces]
        sheet = Sheet.around(points)
        camera, shift = sheet.camera(), np.array([sheet.x, sheet.y])
        told = _unit_told(ink, sheet)
    most = max(float(t.columns.get("pressure", np.zeros(1)).max()) for t in ink.traces)
    strokes = [
        _stroke(trace, camera, shift, pressure_top=most if most > 1 else 1.0, number=number)
        for number, trace in enumerate(ink.traces, 1)
    ]
    facts = decode_json(ink.notes.get("bozzetto-extra", "{}"), dict[str, Any], "an annotation")
    return Drawing(Strokes(strokes), camera, name, facts, left_out=told)


def _unit_told(ink: _Ink, sheet: Sheet) -> tuple[str, ...]:
    """Return a sentence about the size of a drawing whose file says no unit; tablets differ."""
    channels = [channel for channels in ink.formats.values() for channel in channels]
    if any(one.name.upper() == "X" and one.unit is not None for one in channels):
        return ()
    size = " × ".join(
        f"{side:,.0f}" if side >= 100.0 else f"{side:.3g}" for side in (sheet.width, sheet.height)
    )
    return (f"Read as millimetres, {size}: the file does not say its unit.",)


class _View(msgspec.Struct):
    camera: CameraRecord
    canvas: CanvasRecord


def _camera(text: str) -> Camera:
    view: _View = decode_json(text, _View, "an annotation")
    return camera_from(view.camera, view.canvas)


def _find_formats(element: Element, ink: _Ink) -> None:
    """Collect trace formats by the ids of all elements that hold one; "" is the first one."""
    resolutions = _resolutions(element)
    for child in element.children:
        if child.tag == "traceFormat":
            channels = [
                _channel(c, resolutions)
                for holder in (child, *(c for c in child.children if c.tag != "channel"))
                for c in holder.children
                if c.tag == "channel"
            ]
            for key in ("", element.attributes.get("id", ""), child.attributes.get("id", "")):
                ink.formats.setdefault(key, channels)
        else:
            _find_formats(child, ink)
            # A context takes the format of the ink source inside it.
            inner = child.attributes.get("id", "")
            if inner in ink.formats and element.attributes.get("id"):
                ink.formats.setdefault(element.attributes["id"], ink.formats[inner])
    for name in ("traceFormatRef", "inkSourceRef"):
        target = element.attributes.get(name, "").lstrip("#")
        if target in ink.formats and element.attributes.get("id"):
            ink.formats.setdefault(element.attributes["id"], ink.formats[target])


def _resolutions(source: Element) -> dict[str, float]:
    """Return what one step of a device is in each channel, in mm, s or degrees."""
    found = {}
    for holder in source.children:
        for one in holder.children if holder.tag == "channelProperties" else ():
            unit = UNITS.get(one.attributes.get("units", "").removeprefix("1/"))
            steps = _number(one.attributes.get("value", ""))
            if unit is not None and steps and one.attributes.get("name") == "resolution":
                found[one.attributes.get("channel", "")] = unit / steps
    return found


def _channel(element: Element, resolutions: dict[str, float]) -> _Channel:
    """Return a channel of a trace format.

    Whole numbers are steps of the device, whatever unit stands there (Microsoft writes "cm" beside
    hundredths of millimetres); so are others without a unit.
    """
    name, unit = (element.attributes.get(key, "") for key in ("name", "units"))
    scale = UNITS.get(unit)
    if name in resolutions and (scale is None or element.attributes.get("type") == "integer"):
        scale = resolutions[name]
    return _Channel(name, scale, _number(element.attributes.get("max", "")))


def _number(text: str) -> float | None:
    """Return a positive number that can be reckoned with, or None."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if 1 / MAX_COORDINATE <= number <= MAX_COORDINATE else None


def _walk(element: Element, context: str, ink: _Ink) -> None:
    """Collect the traces in the order of the file."""
    for child in element.children:
        own = child.attributes.get("contextRef", f"#{context}").lstrip("#")
        if child.tag == "trace" and child.attributes.get("type") == "penUp":
            continue  # how the pen moved through the air
        if child.tag == "trace":
            at_most(len(ink.traces) + 1, MAX_STROKES, "strokes")
            channels = ink.formats.get(own) or ink.formats.get("") or PLAIN
            columns = _columns(child.text, channels, len(ink.traces) + 1)
            ink.samples += len(columns["x"])
            at_most(ink.samples, MAX_SAMPLES, "samples")
            ink.traces.append(_Trace(columns, child))
        elif child.tag == "annotation":
            ink.notes.setdefault(child.attributes.get("type", ""), child.text.strip())
        elif child.tag != "definitions":
            _walk(child, own, ink)


def _columns(text: str, channels: list[_Channel], number: int) -> dict[str, NDArray[np.float64]]:
    """Read the samples of one trace, in our units but for pressure without a top."""
    at_most(text.count(",") + 1, 2 * MAX_STROKE, "samples in one trace")
    rows = [row for row in text.split(",") if row.strip()]
    if not rows:
        raise FormatError(f"trace {number}: it holds no sample.")
    at_most(len(rows), MAX_STROKE, "samples in one trace")
    width = len(channels)
    at_most(width, MOST_CHANNELS, "channels")
    table = np.zeros((len(rows), width))
    state = [_Running() for _ in channels]
    for place, row in enumerate(rows):
        values = [value for value in VALUE.findall(row) if any(value)]
        if any(stray for *_, stray in values) or len(values) > width:
            raise FormatError(
                f"trace {number}: sample {place + 1} cannot be understood: “{row.strip()[:40]}”."
            )
        for k in range(width):
            sign, word = values[k][:2] if k < len(values) else ("", "?")
            table[place, k] = state[k].take(sign, word)
    if not (np.abs(table) <= MAX_COORDINATE).all():
        raise FormatError(f"trace {number}: a value is larger than ink can be.")
    columns: dict[str, NDArray[np.float64]] = {}
    for k, channel in enumerate(channels):
        column = COLUMN_OF.get(channel.name.upper())
        if column is not None:
            columns[column] = _scaled(table[:, k], column, channel)
    if not {"x", "y"} <= columns.keys():
        raise FormatError(f"trace {number}: its format has no X and Y.")
    return columns


class _Running:
    """One channel's value, its first and its second difference (section 3.2.1)."""

    def __init__(self) -> None:
        self.order = 0
        self.value = self.step = 0.0

    def take(self, sign: str, word: str) -> float:
        """Return the next value, from the file's word and the sign before it."""
        if word in ("*", "?"):
            return self.value
        if word in ("T", "F"):
            return float(word == "T")
        if sign:
            self.order = "!'\"".index(sign)
        given = float(int(word.replace("#", ""), 16)) if "#" in word else float(word)
        if self.order == 0:
            self.step, self.value = given - self.value, given
        else:
            self.step = given if self.order == 1 else self.step + given
            self.value += self.step
        return self.value


def _scaled(values: NDArray[np.float64], column: str, channel: _Channel) -> NDArray[np.float64]:
    if column == "pressure":
        return values / channel.top if channel.top is not None else values
    usual = SECONDS["ms"] if column == "t" else 1.0
    return values * (usual if channel.unit is None else channel.unit)


def _stroke(
    trace: _Trace, camera: Camera, shift: NDArray[np.float64], pressure_top: float, number: int
) -> Stroke:
    columns = dict(trace.columns)
    own = {
        key.removeprefix(f"{OURS} "): value
        for key, value in trace.element.attributes.items()
        if key.startswith(OURS)
    }
    if "pressure" in columns:
        columns["pressure"] = np.clip(columns["pressure"] / pressure_top, 0.0, 1.0)
    if "t" in columns and "absolute-time" not in own:
        columns["t"] = columns["t"] - columns["t"][0]
    x, y = columns.pop("x") - shift[0], columns.pop("y") - shift[1]
    tool = own.get("tool", "imported")
    if tool not in ("pen", "eraser", "mouse", "imported"):
        raise FormatError(f"trace {number}: there is no tool “{tool[:40]}”.")
    try:
        return Stroke(
            x,
            y,
            _camera(own["camera"]) if "camera" in own else camera,
            **columns,
            tool=tool,  # type: ignore[arg-type]
            color=decode_json(own["color"], tuple[int, int, int], "an annotation")
            if "color" in own
            else None,
            group=own.get("curve", ""),
        )
    except UserError as error:
        raise FormatError(f"trace {number}: {error.message}") from error


# -- writing -------------------------------------------------------------------------------


def write_drawing(drawing: Drawing) -> bytes:
    """Write InkML that reads back as an equal drawing."""
    layouts: dict[tuple[str, ...], str] = {}
    traces = [_trace(stroke, drawing.camera, layouts) for stroke in drawing.strokes]
    contexts = [
        f'<context xml:id="{key}"><traceFormat>{"".join(map(_channel_text, columns))}'
        "</traceFormat></context>"
        for columns, key in layouts.items()
    ]
    notes = [_note("bozzetto-camera", _view_text(drawing.camera))]
    if drawing.facts:
        notes.append(_note("bozzetto-extra", msgspec.json.encode(drawing.facts).decode()))
    return "\n".join(
        (
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<ink xmlns="{SPACE}" xmlns:bozzetto="{OURS}">',
            *notes,
            "<definitions>",
            *contexts,
            "</definitions>",
            *traces,
            "</ink>\n",
        )
    ).encode()


def _note(kind: str, text: str) -> str:
    return f'<annotation type="{kind}">{escape(writable(text))}</annotation>'


def _view_text(camera: Camera) -> str:
    view = {"camera": camera_record(camera), "canvas": canvas_record(camera)}
    return msgspec.json.encode(view).decode()


def _channel_text(column: str) -> str:
    units = {"x": "dev", "y": "dev", "pressure": "dev", "t": "s"}.get(column, "deg")
    top = ' min="0" max="1"' if column == "pressure" else ""
    return f'<channel name="{CHANNEL_OF[column]}" type="decimal" units="{units}"{top}/>'


def _trace(stroke: Stroke, camera: Camera, layouts: dict[tuple[str, ...], str]) -> str:
    columns = ["x", "y"]
    columns += ["pressure"] * stroke.has_pressure + ["t"] * stroke.has_time
    columns += [name for name in ("tilt_x", "tilt_y", "twist") if getattr(stroke, name).any()]
    key = layouts.setdefault(tuple(columns), f"layout{len(layouts) + 1}")
    own: dict[str, str] = {"tool": stroke.tool}
    if stroke.has_time:
        own["absolute-time"] = "yes"
    if stroke.color is not None:
        own["color"] = msgspec.json.encode(stroke.color).decode()
    if stroke.group:
        own["curve"] = stroke.group
    if stroke.camera != camera:
        own["camera"] = _view_text(stroke.camera)
    marks = "".join(f" bozzetto:{name}={quoteattr(writable(text))}" for name, text in own.items())
    table = zip(*(map(str, getattr(stroke, name)) for name in columns), strict=True)
    samples = ", ".join(map(" ".join, table))
    return f'<trace contextRef="#{key}"{marks}>{samples}</trace>'
