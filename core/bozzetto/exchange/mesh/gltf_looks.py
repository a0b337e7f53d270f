"""Materials and pictures of a glTF file that is being written."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import msgspec

from bozzetto.exchange.color import WHITE, srgb_to_linear
from bozzetto.exchange.mesh.gltf_buffers import GltfBuffers
from bozzetto.exchange.mesh.gltf_scene import LOOKS
from bozzetto.exchange.mesh.gltf_texture import picture_file
from bozzetto.geometry.shapes import FaceGroup, Solid, Surface


@dataclass
class Looks:
    """The materials of a file, and the pictures that they name.

    Parameters
    ----------
    file : GltfBuffers
        Where pictures go.
    """

    file: GltfBuffers
    materials: list[dict[str, Any]] = field(default_factory=list)
    images: list[dict[str, Any]] = field(default_factory=list)
    _numbers: dict[bytes, int] = field(default_factory=dict)
    _pictures: dict[tuple[int, tuple[int, int, int]], int] = field(default_factory=dict)

    def number(self, part: Solid | Surface, group: FaceGroup) -> int:
        """Return the number of the material of a group; equal ones are one."""
        material = _material(part, group)
        texture = part.texture
        if texture is not None:
            base = part.color or WHITE
            key = (id(texture.pixels), base)
            if key not in self._pictures:
                view = self.file.view(picture_file(texture, base))
                self._pictures[key] = len(self.images)
                self.images.append({"bufferView": view, "mimeType": "image/png"})
            link = {"index": self._pictures[key]}
            material["pbrMetallicRoughness"]["baseColorTexture"] = link
        number = self._numbers.setdefault(msgspec.json.encode(material), len(self.materials))
        if number == len(self.materials):
            self.materials.append(material)
        return number


def _material(part: Solid | Surface, group: FaceGroup) -> dict[str, Any]:
    base = [1.0, 1.0, 1.0, 1.0]
    painted = part.texture is not None
    color = group.color or part.color
    if part.mesh.colors is not None or painted:
        color = None
    if color is not None:
        base[:3] = srgb_to_linear(color).tolist()
    metallic, roughness, opacity = LOOKS[group.finish]
    base[3] = opacity
    looks: dict[str, Any] = {"metallicFactor": metallic, "roughnessFactor": roughness}
    if color is not None or opacity < 1.0:
        looks["baseColorFactor"] = base
    name = group.material or group.name
    material: dict[str, Any] = {"name": name, "pbrMetallicRoughness": looks}
    if opacity < 1.0:
        material["alphaMode"] = "BLEND"
    if isinstance(part, Surface):
        material["doubleSided"] = True
    return material
