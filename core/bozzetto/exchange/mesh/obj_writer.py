"""Wavefront OBJ, written: text with names, normals and groups, and its materials beside it.

Colours of vertices stand as ``v x y z r g b``, which most read. The materials lie in a file of
their own (MTL), with the roughness and metal of its extension for physically based rendering,
and pictures beside that.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Floats, Index
from bozzetto.exchange.color import WHITE, vertex_colors
from bozzetto.exchange.handover import MILLIMETRES, FileFrame
from bozzetto.exchange.mesh.gltf_scene import LOOKS
from bozzetto.exchange.mesh.gltf_texture import picture_file
from bozzetto.exchange.mesh.picture_places import Checkpoint, no_checkpoint, picture_places
from bozzetto.exchange.mesh.polygon_corners import corner_runs
from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.geometry.shapes import Color, FaceGroup, Finish, Shapes, Solid, Surface
from bozzetto.geometry.texture import Texture
from bozzetto.scene.renderer.normals import corner_normals

HEADER: Final = "# Bozzetto: "

SHARPEST: Final = 1000.0
"""Specular exponent (Ns) of a mirror; nothing of what is rough."""


@dataclass(frozen=True, eq=False)
class _Material:
    """A material, and the part and the group that have it."""

    name: str
    part: Solid | Surface
    group: FaceGroup
    picture: str = ""


def write_shapes(
    shapes: Shapes,
    frame: FileFrame = MILLIMETRES,
    *,
    beside: str = "",
    uvs: bool = False,
    checkpoint: Checkpoint = no_checkpoint,
) -> bytes:
    """Write OBJ with one object per part, and its groups; faces share the part's vertices.

    Parameters
    ----------
    shapes : Shapes
        In the frame of the file.
    frame : FileFrame
        Said at its top.
    beside : str
        Name of the files beside it, without an ending; none if it is empty.
    uvs : bool
        Whether parts without a picture get places in one that somebody may paint: one for all.
    checkpoint : callable
        Called with the fraction done and the step's name meanwhile; may raise to stop it.
    """
    pieces = [f"{HEADER}{frame}\n"]
    materials = iter(_materials(shapes, _word(beside)) if beside else ())
    if beside:
        pieces.append(f"mtllib {_word(beside)}.mtl\n")
    first = np.zeros(3, np.int64) + 1  # of vertices, places in pictures, and normals
    parts = list(shapes.meshes())
    all_laid = _places(parts, checkpoint, pictures=bool(beside), uvs=uvs)
    for part, laid in zip(parts, all_laid, strict=True):
        texture = part.texture if beside else None
        pieces.append(f"o {_word(part.name)}\n{_vertices(part, texture)}")
        normals = part.normals or corner_normals(part.mesh)
        pieces.append(_rows("vn %.7g %.7g %.7g\n", normals.vectors))
        corners = [part.mesh.faces + first[0], normals.corners + first[2]]
        line = " %d//%d"
        if laid is not None:
            places, which = np.unique(laid.reshape(-1, 2), axis=0, return_inverse=True)
            pieces.append(_rows("vt %.7g %.7g\n", places * (1.0, -1.0) + (0.0, 1.0)))
            corners.insert(1, which.reshape(-1, 3) + first[1])
            line = " %d/%d/%d"
            first[1] += len(places)
        rows = np.stack(corners, axis=2).reshape(3 * len(part.mesh.faces), -1)
        pieces += _faces(part, rows, line, laid, materials if beside else None)
        first += (len(part.mesh.vertices), 0, len(normals.vectors))
    return "".join(pieces).encode()


def files_beside(shapes: Shapes, beside: str) -> tuple[tuple[str, bytes], ...]:
    """Return the files that an OBJ file names: its materials, and pictures, each with its name."""
    found: list[tuple[str, bytes]] = []
    pieces = [f"{HEADER.rstrip(': ')}\n"]
    for material in dict.fromkeys(_materials(shapes, _word(beside))):
        pieces.append(_look(material))
        if material.picture and all(name != material.picture for name, _ in found):
            base = material.part.color or WHITE
            texture = material.part.texture
            if texture is not None:
                found.append((material.picture, picture_file(texture, base)))
    return ((f"{_word(beside)}.mtl", "".join(pieces).encode()), *found)


def _places(
    parts: Sequence[Solid | Surface], checkpoint: Checkpoint, *, pictures: bool, uvs: bool
) -> list[Floats | None]:
    """Return the places of all triangles in their part's picture, or in one to come; (f, 3, 2)."""
    found: list[Floats | None] = [
        part.texture.corners if pictures and part.texture is not None else None for part in parts
    ]
    if not uvs:
        return found
    for number, (part, laid) in enumerate(
        zip(parts, picture_places(parts, checkpoint), strict=True)
    ):
        if laid is not None:
            places = np.zeros((len(part.mesh.faces), 3, 2), np.float32)
            places[~is_degenerate(part.mesh.faces)] = laid
            found[number] = places
    return found


def _vertices(part: Solid | Surface, texture: Texture | None) -> str:
    rows = part.mesh.vertices.astype(np.float64)
    colors = None if texture is not None else vertex_colors(part)
    line = "v %.9g %.9g %.9g"
    if colors is not None:
        rows = np.hstack((rows, colors[:, :3] / 255.0))
        line += " %.4f %.4f %.4f"
    return _rows(f"{line}\n", rows)


def _rows(line: str, rows: Array | Floats | Index) -> str:
    return (line * len(rows)) % tuple(rows.ravel().tolist())


def _faces(
    part: Solid | Surface,
    corners: Index,
    line: str,
    laid: Floats | None,
    materials: Iterator[_Material] | None,
) -> Iterator[str]:
    """Yield the faces of each group; `line` writes one of the corners (3 f, k)."""
    begin = 0
    for group in part.groups or (FaceGroup("", len(part.mesh.faces)),):
        if group.name:
            yield f"g {_word(group.name)}\n"
        if materials is not None:
            yield f"usemtl {next(materials).name}\n"
        for run in corner_runs(part, begin, begin + group.count, laid):
            yield _rows(f"f{line * run.shape[1]}\n", corners[run].reshape(len(run), -1))
        begin += group.count


def _materials(shapes: Shapes, beside: str) -> list[_Material]:
    """Return a material for every group of every part, in their order.

    No two have one name; of those with a picture or a name of their own, equal ones are one.
    """
    found: list[_Material] = []
    taken: set[str] = set()
    pictures: dict[tuple[int, Color], str] = {}
    known: dict[tuple[str, str, Finish, Color | None], _Material] = {}
    for part in shapes.meshes():
        picture = ""
        if part.texture is not None:
            key = (id(part.texture.pixels), part.color or WHITE)
            picture = pictures.setdefault(key, f"{beside}-{len(pictures) + 1}.png")
        for group in part.groups or (FaceGroup("", len(part.mesh.faces)),):
            name = wanted = _word(group.material or group.name or part.name)
            color = None if picture else group.color or part.color
            look = (wanted, picture, group.finish, color)
            if (picture or group.material) and look in known:
                found.append(known[look])
                continue
            number = 1
            while name in taken:
                number += 1
                name = f"{wanted}.{number}"
            taken.add(name)
            found.append(_Material(name, part, group, picture))
            known[look] = found[-1]
    return found


def _look(material: _Material) -> str:
    """Write a material: colour, shine, opacity, and the same for physically based rendering."""
    part, group = material.part, material.group
    metallic, roughness, opacity = LOOKS[group.finish]
    color = WHITE if part.mesh.colors is not None or material.picture else None
    shade = " ".join(f"{value / 255:.4f}" for value in color or group.color or part.color or WHITE)
    gleam = 1.0 - roughness
    lines = [
        f"newmtl {material.name}",
        f"Kd {shade}",
        f"Ks {gleam:.4f} {gleam:.4f} {gleam:.4f}",
        f"Ns {SHARPEST * gleam * gleam:.4f}",
        f"d {opacity:.4f}",
        "illum 2",
        f"Pr {roughness:.4f}",
        f"Pm {metallic:.4f}",
    ]
    if material.picture:
        lines.append(f"map_Kd {material.picture}")
    return "\n".join(lines) + "\n\n"


def _word(name: str) -> str:
    """Return a name without blanks, which end names in OBJ."""
    return re.sub(r"\s+", "_", name.strip()) or "part"
