"""Answers of readers, taken apart into plain values and raw arrays, and put together again.

This is what crosses from the process that reads a file to the one that asked for it. Nothing
in it can run code: the values are msgpack of declared types, the arrays are bytes of a declared
type and shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.document.storage.stroke_columns import pack_strokes, unpack_strokes
from bozzetto.exchange.frame_guess import FrameGuess
from bozzetto.exchange.ink.ink_steps import VERBS
from bozzetto.exchange.reading import MeshFile
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.rig import Clip, Rig, Skin
from bozzetto.geometry.shapes import Curve, FaceGroup, Shapes, Solid, Surface
from bozzetto.geometry.texture import Texture
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.steps import Step
from bozzetto.ink.stroke import Strokes
from bozzetto.typed_data import decode_json, decode_msgpack
from bozzetto.view.camera import Camera

Answer = MeshFile | Drawing | Picture | NDArray[np.uint8]
Arrays = list[NDArray[Any]]
Color = tuple[int, int, int]


class _Mesh(msgspec.Struct, array_like=True):
    """Numbers of arrays."""

    vertices: int
    faces: int
    normals: int | None
    colors: int | None


class _Clip(msgspec.Struct, array_like=True):
    name: str
    seconds: int
    turns: int
    shifts: int | None


class _Rig(msgspec.Struct, array_like=True):
    names: tuple[str, ...]
    joints: int
    parents: int
    turns: int | None
    cuts: int | None
    axes: int | None
    shifts: int | None
    clips: list[_Clip]


class _Skin(msgspec.Struct, array_like=True):
    rig: int
    joints: int
    weights: int
    rest: _Mesh | None


class _Part(msgspec.Struct, array_like=True):
    name: str
    color: Color | None
    solid: bool
    mesh: _Mesh
    groups: tuple[FaceGroup, ...]
    texture: tuple[int, int] | None
    skin: _Skin | None
    path: list[int]


class _Curve(msgspec.Struct, array_like=True):
    degree: int
    knots: int
    points: int
    weights: int | None
    closed: bool
    name: str
    color: Color | None


class _Meshes(msgspec.Struct, tag=True):
    parts: list[_Part]
    curves: list[_Curve]
    rigs: list[_Rig]
    names: list[str]
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

PIECE: Final = 32_768
"""Bytes of JSON that are decoded in one call, which no other thread can interrupt."""

LEVELS: Final = 16
"""Levels of nesting that are taken apart for that; every one reads the text once more."""


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


@dataclass
class _Shelf:
    """Arrays and rigs of shapes, each once however often it is named."""

    arrays: Arrays = field(default_factory=list)
    rigs: list[_Rig] = field(default_factory=list)
    names: dict[str, int] = field(default_factory=dict)
    _numbers: dict[int, int] = field(default_factory=dict)
    _rig_numbers: dict[tuple[int, int], int] = field(default_factory=dict)

    def put(self, array: NDArray[Any]) -> int:
        number = self._numbers.setdefault(id(array), len(self.arrays))
        if number == len(self.arrays):
            self.arrays.append(array)
        return number

    def perhaps(self, array: NDArray[Any] | None) -> int | None:
        return None if array is None else self.put(array)

    def mesh(self, mesh: Mesh) -> _Mesh:
        normals, colors = self.perhaps(mesh.normals), self.perhaps(mesh.colors)
        return _Mesh(self.put(mesh.vertices), self.put(mesh.faces), normals, colors)

    def skin(self, skin: Skin) -> _Skin:
        key = id(skin.rig), id(skin.clips)
        number = self._rig_numbers.setdefault(key, len(self.rigs))
        if number == len(self.rigs):
            rig = skin.rig
            clips = [
                _Clip(c.name, self.put(c.seconds), self.put(c.turns), self.perhaps(c.shifts))
                for c in skin.clips
            ]
            self.rigs.append(
                _Rig(
                    rig.names,
                    self.put(rig.joints),
                    self.put(rig.parents),
                    self.perhaps(rig.turns),
                    self.perhaps(rig.cuts),
                    self.perhaps(rig.axes),
                    self.perhaps(rig.shifts),
                    clips,
                )
            )
        rest = None if skin.rest is None else self.mesh(skin.rest)
        return _Skin(number, self.put(skin.joints), self.put(skin.weights), rest)


def _meshes_record(file: MeshFile) -> tuple[_Record, Arrays]:
    shelf = _Shelf()
    parts = [
        _Part(
            part.name,
            part.color,
            isinstance(part, Solid),
            shelf.mesh(part.mesh),
            part.groups,
            None
            if part.texture is None
            else (shelf.put(part.texture.pixels), shelf.put(part.texture.corners)),
            None if part.skin is None else shelf.skin(part.skin),
            [shelf.names.setdefault(name, len(shelf.names)) for name in part.path],
        )
        for part in file.shapes.meshes()
    ]
    curves = [
        _Curve(
            curve.degree,
            shelf.put(curve.knots),
            shelf.put(curve.control_points),
            shelf.perhaps(curve.weights),
            curve.closed,
            curve.name,
            curve.color,
        )
        for curve in file.shapes.curves
    ]
    record = _Meshes(parts, curves, shelf.rigs, list(shelf.names), file.guess, file.left_out)
    return record, shelf.arrays


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
    told: _Record = decode_msgpack(record, _Record)
    match told:
        case _Meshes():
            return MeshFile(_shapes_of(told, arrays), told.guess, told.left_out)
        case _Drawing():
            return _drawing_of(told, arrays)
        case _Picture(name, width, height):
            return Picture(name, arrays[0], width, height)
        case _Pixels():
            return arrays[0]


def _shapes_of(told: _Meshes, arrays: Sequence[NDArray[Any]]) -> Shapes:
    def perhaps(number: int | None) -> NDArray[Any] | None:
        return None if number is None else arrays[number]

    def mesh_of(mesh: _Mesh) -> Mesh:
        normals, colors = perhaps(mesh.normals), perhaps(mesh.colors)
        return Mesh(arrays[mesh.vertices], arrays[mesh.faces], normals, colors)

    rigs = [
        (
            Rig(
                arrays[rig.joints],
                arrays[rig.parents],
                rig.names,
                perhaps(rig.turns),
                perhaps(rig.cuts),
                perhaps(rig.axes),
                perhaps(rig.shifts),
            ),
            tuple(
                Clip(clip.name, arrays[clip.seconds], arrays[clip.turns], perhaps(clip.shifts))
                for clip in rig.clips
            ),
        )
        for rig in told.rigs
    ]

    def skin_of(skin: _Skin) -> Skin:
        rig, clips = rigs[skin.rig]
        rest = None if skin.rest is None else mesh_of(skin.rest)
        return Skin(rig, arrays[skin.joints], arrays[skin.weights], rest, clips)

    solids: list[Solid] = []
    surfaces: list[Surface] = []
    for part in told.parts:
        kind = Solid if part.solid else Surface
        texture = None
        if part.texture is not None:
            pixels, corners = part.texture
            texture = Texture(arrays[pixels], arrays[corners])
        made = kind(
            mesh_of(part.mesh),
            part.name,
            part.color,
            texture=texture,
            skin=None if part.skin is None else skin_of(part.skin),
            groups=part.groups,
            path=tuple(told.names[number] for number in part.path),
        )
        if isinstance(made, Solid):
            solids.append(made)
        else:
            surfaces.append(made)
    curves = tuple(
        Curve(
            curve.degree,
            arrays[curve.knots],
            arrays[curve.points],
            perhaps(curve.weights),
            curve.closed,
            curve.name,
            curve.color,
        )
        for curve in told.curves
    )
    return Shapes(tuple(solids), tuple(surfaces), curves)


def _drawing_of(told: _Drawing, arrays: Sequence[NDArray[Any]]) -> Drawing:
    strokes = unpack_strokes(told.strokes, dict(zip(told.columns, arrays, strict=True)))
    steps: list[Step] = [decode_msgpack(text, VERBS[verb]) for verb, text in told.steps]
    facts: dict[str, Any] = _plain_values(msgspec.Raw(told.facts))
    return Drawing(
        Strokes(strokes), told.camera, told.name, facts, tuple(steps), left_out=told.left_out
    )


def _plain_values(text: msgspec.Raw, levels: int = LEVELS) -> Any:
    """Decode any JSON piece by piece: a large text in one call would hold up the window."""
    start = bytes(memoryview(text)[:1])
    if len(memoryview(text)) <= PIECE or not levels or start not in (b"[", b"{"):
        return msgspec.json.decode(text)
    if start == b"[":
        items = decode_json(text, list[msgspec.Raw])
        return [_plain_values(one, levels - 1) for one in items]
    members = decode_json(text, dict[str, msgspec.Raw])
    return {key: _plain_values(one, levels - 1) for key, one in members.items()}
