"""glTF 2.0 in its binary form, written: a node for each part; Y up and metres in the file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.color import WHITE, srgb_to_linear
from bozzetto.exchange.mesh.creases import divided, divided_by
from bozzetto.exchange.mesh.face_groups import proper_groups
from bozzetto.exchange.mesh.gltf_buffers import GltfBuffers
from bozzetto.exchange.mesh.gltf_groups import in_groups
from bozzetto.exchange.mesh.gltf_looks import Looks
from bozzetto.exchange.mesh.gltf_motion import add_clip, animation, drawn_parts, filmed
from bozzetto.exchange.mesh.gltf_reader import read_shapes as read_shapes
from bozzetto.exchange.mesh.gltf_scene import (
    AXES,
    BIN_CHUNK,
    FLOAT,
    JSON_CHUNK,
    MAGIC,
    MM_PER_METRE,
    UNIT,
)
from bozzetto.exchange.mesh.gltf_skin import follows, rig_in_file, rig_nodes
from bozzetto.exchange.mesh.gltf_texture import SAMPLER, Corners, corners_of, laid_out
from bozzetto.exchange.mesh.picture_places import Checkpoint, Places, no_checkpoint, picture_places
from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Rig, same_rig
from bozzetto.geometry.shapes import FaceGroup, Shapes, Solid, Surface

TO_FILE: Final = Placement(tuple(AXES.ravel().tolist()), 1.0 / MM_PER_METRE)
"""The change of axes and units as a placement."""

COVERAGE: Final = (0.25, 0.05, 0.0)
"""Shares of the screen's height down to which each level is meant."""

ARRAY_BUFFER: Final = 34962
ELEMENT_ARRAY_BUFFER: Final = 34963
UNSIGNED_BYTE: Final = 5121
UNSIGNED_SHORT: Final = 5123
UNSIGNED_INT: Final = 5125


def write_motion(frames: Sequence[Shapes], seconds: Sequence[float]) -> bytes:
    """Write GLB of parts that move rigidly or by their joints, with an animation of these.

    Parameters
    ----------
    frames : sequence of Shapes
        The same parts at each time.
    seconds : sequence of float
        These times, growing.

    Raises
    ------
    UserError
        If parts come, go, or change their shape.
    """
    shapes, motions = filmed(frames, seconds)
    return write_shapes(shapes, motions=motions, seconds=seconds)


def write_shapes(
    shapes: Shapes,
    *,
    motions: Sequence[Sequence[Placement]] = (),
    seconds: Sequence[float] = (),
    coarser: Sequence[Shapes] = (),
    uvs: bool = False,
    checkpoint: Checkpoint = no_checkpoint,
) -> bytes:
    """Write GLB with one node and mesh per part, and a material for it or each of its groups.

    A texture takes the place of vertex colours, which glTF would multiply with it. A part with
    a skin is written at rest, its joints as they are posed, and its clips as animations; parts on
    equal rigs share one. What is in something (`Solid.path`) is in nodes of these names. Motions
    say where each part is at each time, as seen from where it is written.

    Parameters
    ----------
    shapes : Shapes
        In the world, mm.
    motions, seconds
        Where each part is at each of these times.
    coarser : sequence of Shapes
        The same parts with fewer and fewer triangles, for whoever sees them from afar (MSFT_lod).
    uvs : bool
        Whether parts without a texture get places in one that somebody may paint: one for all.
    checkpoint : callable
        Called with the fraction done and the step's name meanwhile; may raise to stop it.
    """
    levels = [list(drawn_parts(level).meshes()) for level in (shapes, *coarser)]
    parts = levels[0]
    file = GltfBuffers()
    looks = Looks(file)
    moving = animation(motions, seconds, TO_FILE, file.put, FLOAT)
    animations = {} if moving is None else {str(moving["name"]): moving}
    meshes: list[dict[str, Any]] = []
    nodes: list[dict[str, Any]] = [{"name": part.name} for part in parts]
    skins: list[dict[str, Any]] = []
    joint_nodes: list[dict[str, Any]] = []
    rigs: list[Rig] = []
    laid = [picture_places(level, checkpoint) if uvs else [None] * len(level) for level in levels]
    for number, part in enumerate(parts):
        skin = part.skin
        nodes[number]["mesh"] = len(meshes)
        meshes.append(_mesh(file, looks, part, laid[0][number]))
        if skin is None:
            continue
        known = next((k for k, rig in enumerate(rigs) if same_rig(rig, skin.rig)), len(rigs))
        nodes[number]["skin"] = known
        if known == len(rigs):
            rigs.append(skin.rig)
            rig, binds = rig_in_file(skin.rig.placed(TO_FILE))
            root = len(parts) + len(joint_nodes)
            joint_nodes += rig_nodes(rig, root, part.name)
            numbers = list(range(root + 1, root + 1 + len(rig.joints)))
            rows = file.put(binds, "MAT4", FLOAT)
            skins.append({"skeleton": root, "joints": numbers, "inverseBindMatrices": rows})
            for clip in skin.clips:
                add_clip(animations, clip.placed(TO_FILE), rig, root + 1, file.put, FLOAT)
    nodes += joint_nodes
    held = in_groups(nodes, parts, is_still=not motions)
    roots = [*held, *(skin["skeleton"] for skin in skins)]
    scene: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "Bozzetto"},
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": looks.materials,
        "accessors": file.accessors,
        "bufferViews": file.views,
    }
    for level, row in enumerate(levels[1:], 1):
        for number, part in enumerate(row):
            ids = nodes[number].setdefault("extensions", {"MSFT_lod": {"ids": []}})["MSFT_lod"]
            ids["ids"].append(len(nodes))
            coarse = {"name": f"{part.name} LOD{level}", "mesh": len(meshes)}
            if "skin" in nodes[number]:
                coarse["skin"] = nodes[number]["skin"]
            nodes.append(coarse)
            meshes.append(_mesh(file, looks, part, laid[level][number]))
            nodes[number]["extras"] = {"MSFT_screencoverage": COVERAGE[: len(levels)]}
        scene["extensionsUsed"] = ["MSFT_lod"]
    scene["buffers"] = [{"byteLength": len(file.blob)}]
    if skins:
        scene["skins"] = skins
    if animations:
        scene["animations"] = list(animations.values())
    if looks.images:
        scene["images"] = looks.images
        scene["textures"] = [{"source": k, "sampler": 0} for k in range(len(looks.images))]
        scene["samplers"] = [SAMPLER]
    return _packed(msgspec.json.encode(scene), bytes(file.blob))


def _mesh(
    file: GltfBuffers, looks: Looks, part: Solid | Surface, laid: Places | None
) -> dict[str, Any]:
    """Add the mesh of a part, with its places in a picture to come, if any; return its record."""
    mesh, skin = part.mesh, part.skin
    if skin is not None and skin.rest is not None:
        mesh = replace(mesh, vertices=skin.rest.vertices, normals=skin.rest.normals)
    vertex, faces, texels, _ = corners_of(mesh, part.texture)
    normals = _unit_normals(mesh.vertex_normals())[vertex]
    if part.normals is not None and part.texture is None and skin is None:
        exact = part.normals.of_faces(~is_degenerate(mesh.faces))
        vertex, faces, which = divided_by(faces, exact.corners)
        normals = _unit_normals(exact.vectors)[which]
    elif mesh.normals is None and part.texture is None and skin is None:
        vertex, faces = divided(replace(mesh, faces=faces.astype(np.int32)))
        split = Mesh(mesh.vertices[vertex], faces.astype(np.int32))
        normals = _unit_normals(split.vertex_normals())
    if laid is not None:
        vertex, faces, texels, before = laid_out(Corners(vertex, faces, None), laid)
        normals = normals[before]
    places = (mesh.vertices[vertex] @ AXES.T / MM_PER_METRE).astype("<f4")
    reach = {"min": places.min(0).tolist(), "max": places.max(0).tolist()}
    attributes = {"POSITION": file.put(places, "VEC3", FLOAT, ARRAY_BUFFER, **reach)}
    attributes["NORMAL"] = file.put(normals, "VEC3", FLOAT, ARRAY_BUFFER)
    colors = mesh.colors_over(part.color or WHITE)
    if texels is not None:
        attributes["TEXCOORD_0"] = file.put(texels.astype("<f4"), "VEC2", FLOAT, ARRAY_BUFFER)
    if part.texture is None and colors is not None:
        linear = _linear_colors(colors[vertex])
        attributes["COLOR_0"] = file.put(
            linear, "VEC4", UNSIGNED_SHORT, ARRAY_BUFFER, normalized=True
        )
    if skin is not None:
        joints, weights = follows(skin, vertex)
        component = UNSIGNED_BYTE if joints.itemsize == 1 else UNSIGNED_SHORT
        attributes["JOINTS_0"] = file.put(joints, "VEC4", component, ARRAY_BUFFER)
        attributes["WEIGHTS_0"] = file.put(weights, "VEC4", FLOAT, ARRAY_BUFFER)
    primitives = []
    begin = 0
    for group in proper_groups(part) or (FaceGroup(part.name, len(faces)),):
        own = faces[begin : begin + group.count].ravel().astype("<u4")
        indices = file.put(own, "SCALAR", UNSIGNED_INT, ELEMENT_ARRAY_BUFFER)
        material = looks.number(part, group)
        primitives.append({"attributes": attributes, "indices": indices, "material": material})
        begin += group.count
    return {"name": part.name, "primitives": primitives}


def _packed(text: bytes, blob: bytes) -> bytes:
    text += b" " * (-len(text) % 4)

    def chunk(kind: int, content: bytes) -> bytes:
        return np.array([len(content), kind], "<u4").tobytes() + content

    body = chunk(JSON_CHUNK, text) + chunk(BIN_CHUNK, blob)
    return MAGIC + np.array([2, 12 + len(body)], "<u4").tobytes() + body


def _unit_normals(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    normals = vectors.astype(np.float64) @ AXES.T
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    length[np.abs(length - 1.0) <= UNIT] = 1.0  # the rounding of what was read
    up = np.array([0.0, 1.0, 0.0])  # a vertex that no face uses still needs some unit vector
    return np.where(length > 0, normals / np.where(length > 0, length, 1.0), up).astype("<f4")


def _linear_colors(colors: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Convert vertex colours to glTF's linear ones; 16 bits keep every sRGB byte apart."""
    linear = np.hstack((srgb_to_linear(colors[:, :3]), colors[:, 3:] / 255.0))
    return np.rint(65535.0 * linear).astype("<u2")
