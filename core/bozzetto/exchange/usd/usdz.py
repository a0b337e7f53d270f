"""USDZ, written: a USD scene and its pictures in one file, as phones and headsets show it.

A ZIP archive without compression in which the content of every file begins at a multiple of 64
bytes, so that it is read where it lies (OpenUSD, "Usdz File Format Specification"). The scene is
the first of its files.
"""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Sequence
from typing import Final

from bozzetto.exchange.handover import FileFrame
from bozzetto.exchange.mesh.gltf_motion import filmed
from bozzetto.exchange.mesh.picture_places import Checkpoint, no_checkpoint
from bozzetto.exchange.usd.stage import stage_text
from bozzetto.geometry.shapes import Shapes

ALIGNED: Final = 64
"""Bytes of which the place of every content is a multiple."""

HEADER: Final = 30
"""Bytes of an entry before its name."""

PADDING: Final = 0x1986
"""Kind of the extra field that holds nothing, as other writers have it."""

EPOCH: Final = (1980, 1, 1, 0, 0, 0)
"""Date of all entries: equal scenes are equal files."""

SCENE: Final = "model.usda"


def write_shapes(
    shapes: Shapes,
    frame: FileFrame,
    *,
    uvs: bool = False,
    checkpoint: Checkpoint = no_checkpoint,
) -> bytes:
    """Write a USD scene with its pictures as one file.

    Parameters
    ----------
    shapes : Shapes
        In the unit and the axes of the frame.
    frame : FileFrame
        Said in the scene.
    uvs : bool
        Whether parts without a picture get places in one that somebody may paint.
    checkpoint : callable
        Called with the fraction done and the step's name meanwhile; may raise to stop it.
    """
    return packed(*stage_text(shapes, frame, picture_name, uvs=uvs, checkpoint=checkpoint))


def write_motion(frames: Sequence[Shapes], seconds: Sequence[float]) -> bytes:
    """Write a package of parts that move rigidly or by their joints, in metres with Y up.

    Parameters
    ----------
    frames : sequence of Shapes
        The same parts at each time, in the world, mm.
    seconds : sequence of float
        These times, growing.

    Raises
    ------
    UserError
        If parts come, go, or change their shape.
    """
    frame = FileFrame("m", "y")
    shapes, motions = filmed([one.placed(frame.placement) for one in frames], seconds)
    return packed(*stage_text(shapes, frame, picture_name, motions=motions, seconds=seconds))


def picture_name(number: int) -> str:
    """Return the name of a picture in the package."""
    return f"textures/{number}.png"


def packed(text: str, pictures: dict[str, bytes]) -> bytes:
    """Return the package of a scene and its pictures."""
    package = io.BytesIO()
    with zipfile.ZipFile(package, "w", zipfile.ZIP_STORED) as file:
        for name, data in ((SCENE, text.encode()), *pictures.items()):
            entry = zipfile.ZipInfo(name, EPOCH)
            begin = package.tell() + HEADER + len(name) + 4  # the extra field has a head of its own
            padding = -begin % ALIGNED
            entry.extra = struct.pack("<HH", PADDING, padding) + bytes(padding)
            file.writestr(entry, data)
    return package.getvalue()
