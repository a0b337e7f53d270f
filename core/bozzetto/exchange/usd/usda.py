"""USD as text (``.usda``), written: one file, and its pictures beside it."""

from __future__ import annotations

from collections.abc import Callable

from bozzetto.exchange.handover import FileFrame
from bozzetto.exchange.mesh.picture_places import Checkpoint, no_checkpoint
from bozzetto.exchange.usd.looks import Looks
from bozzetto.exchange.usd.stage import stage_text
from bozzetto.geometry.shapes import FaceGroup, Shapes


def write_shapes(
    shapes: Shapes,
    frame: FileFrame,
    *,
    beside: str = "",
    uvs: bool = False,
    checkpoint: Checkpoint = no_checkpoint,
) -> bytes:
    """Write a USD scene as text.

    Parameters
    ----------
    shapes : Shapes
        In the unit and the axes of the frame.
    frame : FileFrame
        Said at its top.
    beside : str
        Name of the pictures beside it, without number and ending.
    uvs : bool
        Whether parts without a picture get places in one that somebody may paint.
    checkpoint : callable
        Called with the fraction done and the step's name meanwhile; may raise to stop it.
    """
    return stage_text(shapes, frame, _picture_name(beside), uvs=uvs, checkpoint=checkpoint)[
        0
    ].encode()


def files_beside(shapes: Shapes, beside: str) -> tuple[tuple[str, bytes], ...]:
    """Return the pictures that a scene names, each with its name."""
    looks = Looks("", _picture_name(beside))
    for part in shapes.meshes():
        if part.texture is not None:
            looks.bound_to(part, FaceGroup(part.name, len(part.mesh.faces)))
    return tuple(looks.pictures.items())


def _picture_name(beside: str) -> Callable[[int], str]:
    stem = beside.replace("@", "_")  # which ends a path in USD
    return lambda number: f"{stem}-{number}.png"
