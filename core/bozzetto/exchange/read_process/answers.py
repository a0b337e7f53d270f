"""Answers of readers, taken apart into plain values and raw arrays, and put together again.

This is what crosses from the process that reads a file to the one that asked for it. Nothing
in it can run code: the values are msgpack of declared types, the arrays are bytes of a declared
type and shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.document.storage.stroke_columns import pack_strokes, unpack_strokes
from bozzetto.exchange.frame_guess import FrameGuess
from bozzetto.exchange.ink.ink_steps import VERBS
from bozzetto.exchange.reading import MeshFile
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import FaceGroup, Shapes, Solid, Surface
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.steps import Step
from bozzetto.ink.stroke import Strokes
from bozzetto.view.camera import Camera

Answer = MeshFile | Drawing | Picture | NDArray[np.uint8]
Arrays = list[NDArray[Any]]
Color = tuple[int, int, int]


class _Part(msgspec.Struct, array_like=True):
    name: str
    color: Color | None
    solid: bool
    normals: bool
    colors: bool
    groups: tuple[FaceGroup, ...] = ()


class _Meshes(msgspec.Struct, tag=True):
    parts: list[_Part]
    guess: FrameGuess | None
    left_out: tuple[str, ...]


class _Drawing(msgspec.Struct, tag=True):
    name: str
    camera: Camera
    strokes: bytes
    columns: list[str]
    facts: bytes
    steps: list[tuple[str, bytes]]
    left_out: tuple[str, ...]


class _Picture(msgspec.Struct, tag=True):
    name: str
    width: int
    height: int


class _Pixels(msgspec.Struct, tag=True):
    pass


_Record = _Meshes | _Drawing | _Picture | _Pixels

_VERB_OF: Final = {kind: verb for verb, kind in VERBS.items()}


def pack_answer(answer: Answer) -> tuple[bytes, Arrays]:
    """Take an answer apart.

    Returns
    -------
    record : bytes
    arrays : list of array
        What the record leaves out, in its order.
    """
    record, arrays = _taken_apart(answer)
    return msgspec.msgpack.encode(record), [np.ascontiguousarray(array) for array in arrays]


def _taken_apart(answer: Answer) -> tuple[_Record, Arrays]:
    if isinstance(answer, MeshFile):
        return _meshes_record(answer)
    if isinstance(answer, Drawing):
        return _drawing_record(answer)
    if isinstance(answer, Picture):
        return _Picture(answer.name, answer.width, answer.height), [answer.encoded]
    return _Pixels(), [answer]


def _meshes_record(file: MeshFile) -> tuple[_Record, Arrays]:
    parts: list[_Part] = []
    arrays: Arrays = []
    row: list[Solid | Surface] = [*file.shapes.solids, *file.shapes.surfaces]
    for part in row:
        mesh = part.mesh
        given = [array for array in (mesh.normals, mesh.colors) if array is not None]
        arrays += [mesh.vertices, mesh.faces, *given]
        parts.append(
            _Part(
                part.name,
                part.color,
                isinstance(part, Solid),
                mesh.normals is not None,
                mesh.colors is not None,
                part.groups,
            )
        )
    return _Meshes(parts, file.guess, file.left_out), arrays


def _drawing_record(drawing: Drawing) -> tuple[_Record, Arrays]:
    meta, columns = pack_strokes(drawing.strokes)
    steps = [(_VERB_OF[type(step)], msgspec.msgpack.encode(step)) for step in drawing.steps]
    record = _Drawing(
        drawing.name,
        drawing.camera,
        msgspec.json.encode(meta),
        list(columns),
        msgspec.json.encode(drawing.facts),
        steps,
        drawing.left_out,
    )
    return record, list(columns.values())


def unpack_answer(record: bytes, arrays: Sequence[NDArray[Any]]) -> Answer:
    """Put an answer together again.

    Parameters
    ----------
    record, arrays
        As `pack_answer` gave them; the arrays are read-only and backed by ``bytes``.
    """
    told: _Record = msgspec.msgpack.decode(record, type=_Record)
    match told:
        case _Meshes(parts, guess, left_out):
            return MeshFile(_shapes_of(parts, list(arrays)), guess, left_out)
        case _Drawing():
            return _drawing_of(told, arrays)
        case _Picture(name, width, height):
            return Picture(name, arrays[0], width, height)
        case _Pixels():
            return arrays[0]


def _shapes_of(parts: Sequence[_Part], arrays: Arrays) -> Shapes:
    solids: list[Solid] = []
    surfaces: list[Surface] = []
    rest = iter(arrays)
    for part in parts:
        vertices, faces = next(rest), next(rest)
        normals = next(rest) if part.normals else None
        mesh = Mesh(vertices, faces, normals, next(rest) if part.colors else None)
        if part.solid:
            solids.append(Solid(mesh, part.name, part.color, groups=part.groups))
        else:
            surfaces.append(Surface(mesh, part.name, part.color, part.groups))
    return Shapes(tuple(solids), tuple(surfaces))


def _drawing_of(told: _Drawing, arrays: Sequence[NDArray[Any]]) -> Drawing:
    strokes = unpack_strokes(told.strokes, dict(zip(told.columns, arrays, strict=True)))
    steps: list[Step] = [
        msgspec.msgpack.decode(text, type=VERBS[verb]) for verb, text in told.steps
    ]
    facts: dict[str, Any] = msgspec.json.decode(told.facts)
    return Drawing(
        Strokes(strokes), told.camera, told.name, facts, tuple(steps), left_out=told.left_out
    )
