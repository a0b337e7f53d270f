"""glTF 2.0 in its binary form, written: one node per part; Y up and metres in the file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.color import WHITE, srgb_to_linear
from bozzetto.exchange.mesh.creases import divided
from bozzetto.exchange.mesh.face_groups import proper_groups
from bozzetto.exchange.mesh.gltf_motion import add_clip, animation, filmed_skins, rigid_motions
from bozzetto.exchange.mesh.gltf_reader import read_shapes as read_shapes
from bozzetto.exchange.mesh.gltf_scene import (
    AXES,
    BIN_CHUNK,
    FLOAT,
    JSON_CHUNK,
    LOOKS,
    MAGIC,
    MM_PER_METRE,
)
from bozzetto.exchange.mesh.gltf_skin import follows, inverse_binds, rig_nodes
from bozzetto.exchange.mesh.gltf_texture import SAMPLER, corners_of, picture_file
from bozzetto.exchange.mesh.polygons import without_degenerate
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.shapes import FaceGroup, Shapes, Solid, Surface

TO_FILE: Final = Placement(tuple(AXES.ravel().tolist()), 1.0 / MM_PER_METRE)
"""The change of axes and units as a placement."""

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
    drawn = [_drawn(frame) for frame in frames]
    return write_shapes(filmed_skins(drawn, seconds), motions=rigid_motions(drawn), seconds=seconds)


def _drawn(shapes: Shapes) -> Shapes:
    """Return the parts of which there is anything to write."""
    parts = [part for part in shapes.meshes() if len(without_degenerate(part.mesh.faces))]
    return Shapes(
        solids=tuple(part for part in parts if isinstance(part, Solid)),
        surfaces=tuple(part for part in parts if isinstance(part, Surface)),
    )


def write_shapes(
    shapes: Shapes,
    *,
    motions: Sequence[Sequence[Placement]] = (),
    seconds: Sequence[float] = (),
) -> bytes:
    """Write GLB with one node and mesh per part, and a material for it or each of its groups.

    A texture takes the place of vertex colours, which glTF would multiply with it. A solid with
    a skin is written at rest, its joints as they are turned, and its clips as animations. Motions
    say where each part is at each time, as seen from where it is written.
    """
    parts = [part for part in shapes.meshes() if len(without_degenerate(part.mesh.faces))]
    blob = bytearray()
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []

    def view(content: bytes, **more: int) -> None:
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(content), **more})
        blob.extend(content + b"\0" * (-len(content) % 4))  # what follows stays aligned

    def put(
        values: NDArray[Any], kind: str, component: int, target: int | None = None, **more: Any
    ) -> int:
        view(values.tobytes(), **({} if target is None else {"target": target}))
        accessor = {"bufferView": len(views) - 1, "componentType": component, "type": kind}
        accessors.append({**accessor, "count": len(values), **more})
        return len(accessors) - 1

    meshes, nodes = [], []
    materials: list[dict[str, Any]] = []
    images: list[dict[str, Any]] = []
    skins: list[dict[str, Any]] = []
    joint_nodes: list[dict[str, Any]] = []
    moving = animation(motions, seconds, TO_FILE, put, FLOAT)
    animations = {} if moving is None else {str(moving["name"]): moving}
    for number, part in enumerate(parts):
        mesh = part.mesh
        texture = part.texture if isinstance(part, Solid) else None
        skin = part.skin if isinstance(part, Solid) else None
        if skin is not None and skin.rest is not None:
            mesh = replace(mesh, vertices=skin.rest.vertices, normals=skin.rest.normals)
        vertex, faces, texels = corners_of(mesh, texture)
        normals = _unit_normals(mesh)[vertex]
        if mesh.normals is None and texture is None and skin is None:
            vertex, faces = divided(replace(mesh, faces=faces.astype(np.int32)))
            normals = _unit_normals(Mesh(mesh.vertices[vertex], faces.astype(np.int32)))
        places = (mesh.vertices[vertex] @ AXES.T / MM_PER_METRE).astype("<f4")
        reach = {"min": places.min(0).tolist(), "max": places.max(0).tolist()}
        attributes = {"POSITION": put(places, "VEC3", FLOAT, ARRAY_BUFFER, **reach)}
        attributes["NORMAL"] = put(normals, "VEC3", FLOAT, ARRAY_BUFFER)
        base = part.color or WHITE
        colors = mesh.colors_over(base)
        if texels is not None:
            attributes["TEXCOORD_0"] = put(texels.astype("<f4"), "VEC2", FLOAT, ARRAY_BUFFER)
        elif colors is not None:
            linear = _linear_colors(colors[vertex])
            attributes["COLOR_0"] = put(
                linear, "VEC4", UNSIGNED_SHORT, ARRAY_BUFFER, normalized=True
            )
        if skin is not None:
            joints, weights = follows(skin, vertex)
            component = UNSIGNED_BYTE if joints.itemsize == 1 else UNSIGNED_SHORT
            attributes["JOINTS_0"] = put(joints, "VEC4", component, ARRAY_BUFFER)
            attributes["WEIGHTS_0"] = put(weights, "VEC4", FLOAT, ARRAY_BUFFER)
        primitives = []
        begin = 0
        for group in proper_groups(part) or (FaceGroup(part.name, len(faces)),):
            own = faces[begin : begin + group.count].ravel().astype("<u4")
            indices = put(own, "SCALAR", UNSIGNED_INT, ELEMENT_ARRAY_BUFFER)
            primitives.append(
                {"attributes": attributes, "indices": indices, "material": len(materials)}
            )
            materials.append(_material(part, group))
            begin += group.count
        meshes.append({"name": part.name, "primitives": primitives})
        if texture is not None:
            view(picture_file(texture, base))
            for material in materials[-len(primitives) :]:
                material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": len(images)}
            images.append({"bufferView": len(views) - 1, "mimeType": "image/png"})
        nodes.append({"name": part.name, "mesh": number})
        if skin is not None:
            rig = skin.rig.placed(TO_FILE)
            root = len(parts) + len(joint_nodes)
            joint_nodes += rig_nodes(rig, root, part.name)
            nodes[-1]["skin"] = len(skins)
            binds = put(inverse_binds(rig), "MAT4", FLOAT)
            numbers = list(range(root + 1, root + 1 + len(rig.joints)))
            skins.append({"skeleton": root, "joints": numbers, "inverseBindMatrices": binds})
            for clip in skin.clips:
                add_clip(animations, clip.placed(TO_FILE), rig, root + 1, put, FLOAT)
    scene = {
        "asset": {"version": "2.0", "generator": "Bozzetto"},
        "scene": 0,
        "scenes": [{"nodes": [*range(len(nodes)), *(skin["skeleton"] for skin in skins)]}],
        "nodes": nodes + joint_nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    if skins:
        scene["skins"] = skins
    if animations:
        scene["animations"] = list(animations.values())
    if images:
        scene["images"] = images
        scene["textures"] = [{"source": k, "sampler": 0} for k in range(len(images))]
        scene["samplers"] = [SAMPLER]
    return _packed(msgspec.json.encode(scene), bytes(blob))


def _packed(text: bytes, blob: bytes) -> bytes:
    text += b" " * (-len(text) % 4)

    def chunk(kind: int, content: bytes) -> bytes:
        return np.array([len(content), kind], "<u4").tobytes() + content

    body = chunk(JSON_CHUNK, text) + chunk(BIN_CHUNK, blob)
    return MAGIC + np.array([2, 12 + len(body)], "<u4").tobytes() + body


def _unit_normals(mesh: Mesh) -> NDArray[np.float32]:
    normals = mesh.vertex_normals().astype(np.float64) @ AXES.T
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    up = np.array([0.0, 1.0, 0.0])  # a vertex that no face uses still needs some unit vector
    return np.where(length > 0, normals / np.where(length > 0, length, 1.0), up).astype("<f4")


def _linear_colors(colors: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Convert vertex colours to glTF's linear ones; 16 bits keep every sRGB byte apart."""
    linear = np.hstack((srgb_to_linear(colors[:, :3]), colors[:, 3:] / 255.0))
    return np.rint(65535.0 * linear).astype("<u2")


def _material(part: Solid | Surface, group: FaceGroup) -> dict[str, Any]:
    base = [1.0, 1.0, 1.0, 1.0]
    painted = isinstance(part, Solid) and part.texture is not None
    color = group.color or part.color
    if color is not None and part.mesh.colors is None and not painted:
        base[:3] = srgb_to_linear(color).tolist()
    metallic, roughness, opacity = LOOKS[group.finish]
    base[3] = opacity
    looks = {"baseColorFactor": base, "metallicFactor": metallic, "roughnessFactor": roughness}
    material: dict[str, Any] = {"name": group.name, "pbrMetallicRoughness": looks}
    if opacity < 1.0:
        material["alphaMode"] = "BLEND"
    if isinstance(part, Surface):
        material["doubleSided"] = True
    return material
