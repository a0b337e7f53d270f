"""The steps of an ink file: read strictly, written so that they read back equal."""

from __future__ import annotations

import math
from dataclasses import MISSING, fields
from typing import Any, Final

import msgspec

from bozzetto import typed_data
from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.camera_record import (
    CameraRecord,
    CanvasRecord,
    camera_from,
    camera_record,
    canvas_record,
)
from bozzetto.exchange.limits import MAX_COORDINATE, MAX_STEPS, at_most
from bozzetto.ink.steps import (
    AddStep,
    CommandStep,
    DeleteStep,
    DragStep,
    DrawStep,
    DuplicateStep,
    GroupStep,
    MoveStep,
    RenameStep,
    SelectStep,
    SetStep,
    ShowStep,
    Step,
    TapStep,
    UngroupStep,
)

VERBS: Final[dict[str, type[Step]]] = {
    "strokes": DrawStep,
    "drag": DragStep,
    "tap": TapStep,
    "set": SetStep,
    "select": SelectStep,
    "rename": RenameStep,
    "show": ShowStep,
    "delete": DeleteStep,
    "duplicate": DuplicateStep,
    "move": MoveStep,
    "group": GroupStep,
    "ungroup": UngroupStep,
    "command": CommandStep,
    "add": AddStep,
}
"""The key that says what a step does."""


def read_steps(text: msgspec.Raw, canvas: CanvasRecord, stroke_count: int) -> tuple[Step, ...]:
    """Read the value of “steps”.

    Parameters
    ----------
    text : Raw
        JSON.
    canvas : CanvasRecord
        Canvas of the file; a step's own camera looks through it unless it brings another.
    stroke_count : int
        Strokes that the file holds.

    Raises
    ------
    FormatError
        Names the step, counted from 1.
    """
    records = decode_json(text, list[dict[str, msgspec.Raw]], "steps")
    at_most(len(records), MAX_STEPS, "steps")
    return tuple(
        _step(record, f"step {number}", canvas, stroke_count)
        for number, record in enumerate(records, 1)
    )


def step_record(step: Step) -> dict[str, Any]:
    """Return a step as a JSON object, without its default values."""
    record: dict[str, Any] = {}
    for field in fields(step):
        value = getattr(step, field.name)
        if field.name == "camera" and value is not None:
            record |= {"camera": camera_record(value), "canvas": canvas_record(value)}
        elif field.default is MISSING or value != field.default:
            record[field.name] = value
    return record


def decode_json(text: bytes | str | msgspec.Raw, kind: Any, place: str) -> Any:
    """Decode typed JSON of an ink file; a refusal begins with the `place`."""
    try:
        return typed_data.decode_json(text, kind)
    except (msgspec.MsgspecError, UnicodeError) as error:
        raise FormatError(f"{place}: {words_of(error)}.") from error
    except RecursionError:
        raise FormatError(f"{place}: nested too deeply.") from None


def _step(
    record: dict[str, msgspec.Raw], place: str, canvas: CanvasRecord, stroke_count: int
) -> Step:
    verbs = [verb for verb in VERBS if verb in record]
    if len(verbs) != 1:
        known = ", ".join(f"“{verb}”" for verb in VERBS)
        raise FormatError(f"{place}: it needs one of {known}, and only one.")
    kind = VERBS[verbs[0]]
    hints = {field.name: field for field in fields(kind)}
    allowed = {*hints, "canvas"} if "camera" in hints else set(hints)
    for key in record:
        if key not in allowed:
            raise FormatError(f"{place}: there is no “{key[:40]}” in a step with “{verbs[0]}”.")
    camera = None
    if "camera" in record and "camera" in hints:
        seen = decode_json(record["camera"], CameraRecord, f"{place}, camera")
        if "canvas" in record:
            canvas = decode_json(record["canvas"], CanvasRecord, f"{place}, canvas")
        try:
            camera = camera_from(seen, canvas)
        except FormatError as error:
            raise FormatError(f"{place}: {error.message}") from error
    plain = {key: raw for key, raw in record.items() if key not in ("camera", "canvas")}
    step: Step = decode_json(msgspec.json.encode(plain), kind, place)
    if isinstance(step, TapStep):
        if not all(math.isfinite(v) and abs(v) <= MAX_COORDINATE for v in step.tap):
            raise FormatError(f"{place}: the place of the tap is beyond all bounds.")
        step = TapStep(step.tool, step.tap, step.shift, step.ctrl, camera)
    used: tuple[int, ...] = ()
    if isinstance(step, DrawStep):
        used = step.strokes
        if not used:
            raise FormatError(f"{place}: it names no stroke.")
    elif isinstance(step, DragStep):
        used = (step.stroke,)
    for index in used:
        if not 0 <= index < stroke_count:
            raise FormatError(
                f"{place}: there is no stroke {index}; the file has {stroke_count}, counted from 0."
            )
    return step
