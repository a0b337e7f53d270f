"""Cameras as plain JSON values, shared by the ink formats."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.limits import MAX_COORDINATE
from bozzetto.view.camera import Camera

Number = Annotated[float, Meta(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
Triple = tuple[Number, Number, Number]


class CanvasRecord(msgspec.Struct):
    """Size of the canvas, pixels."""

    width: Number
    height: Number


class CameraRecord(msgspec.Struct, omit_defaults=True):
    """A camera without its canvas."""

    kind: Literal["perspective", "orthographic"]
    eye: Triple
    target: Triple
    up: Triple = (0.0, 0.0, 1.0)
    fov_y: Number | None = None
    height: Number | None = None


def camera_record(camera: Camera) -> dict[str, Any]:
    """Return a camera as a JSON object."""
    return {
        "kind": camera.kind,
        "eye": camera.eye,
        "target": camera.target,
        "up": camera.up,
        "fov_y": camera.fov_y,
        "height": camera.height,
    }


def canvas_record(camera: Camera) -> dict[str, float]:
    """Return a camera's canvas as a JSON object."""
    return {"width": camera.viewport[0], "height": camera.viewport[1]}


def camera_from(record: CameraRecord, canvas: CanvasRecord) -> Camera:
    """Return the camera that a record describes.

    Raises
    ------
    FormatError
        If a number is missing, or makes no camera.
    """
    needed = "fov_y" if record.kind == "perspective" else "height"
    if getattr(record, needed) is None:
        raise FormatError(f"camera: a {record.kind} camera needs “{needed}”.")
    given = {
        name: getattr(record, name)
        for name in ("fov_y", "height")
        if getattr(record, name) is not None
    }
    try:
        return Camera(
            kind=record.kind,
            eye=record.eye,
            target=record.target,
            up=record.up,
            viewport=(canvas.width, canvas.height),
            **given,
        )
    except UserError as error:
        raise FormatError(f"camera: {error.message}") from error
