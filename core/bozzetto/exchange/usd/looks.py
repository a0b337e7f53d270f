"""Materials of a USD scene: a UsdPreviewSurface for each look, and the pictures that it names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from bozzetto.exchange.color import WHITE, srgb_to_linear
from bozzetto.exchange.mesh.gltf_scene import LOOKS
from bozzetto.exchange.mesh.gltf_texture import picture_file
from bozzetto.exchange.usd.prims import Names, Prim, quoted
from bozzetto.geometry.shapes import FaceGroup, Finish, Solid, Surface

RGB = tuple[int, int, int]

WRAP: Final = quoted("clamp")


@dataclass
class Looks:
    """The materials of a scene.

    Parameters
    ----------
    path : str
        Of the prim that holds them.
    picture_name : callable
        Gives the file of a picture by its number, as seen from the scene's file.
    """

    path: str
    picture_name: Callable[[int], str]
    prims: list[Prim] = field(default_factory=list)
    pictures: dict[str, bytes] = field(default_factory=dict)
    _names: Names = field(default_factory=Names)
    _known: dict[tuple[str, Finish, RGB | None, str], str] = field(default_factory=dict)
    _files: dict[tuple[int, RGB], str] = field(default_factory=dict)

    def bound_to(self, part: Solid | Surface, group: FaceGroup) -> str:
        """Return the path of the material of a group; equal ones are one."""
        picture = ""
        color: RGB | None = group.color or part.color or WHITE
        if part.texture is not None:
            base = part.color or WHITE
            key = (id(part.texture.pixels), base)
            if key not in self._files:
                self._files[key] = self.picture_name(len(self._files) + 1)
                self.pictures[self._files[key]] = picture_file(part.texture, base)
            color, picture = WHITE, self._files[key]
        elif part.mesh.colors is not None:
            color = None
        look = (group.material or group.name or part.name, group.finish, color, picture)
        if look not in self._known:
            name = self._names.new(look[0], "material")
            self._known[look] = path = f"{self.path}/{name}"
            self.prims.append(_material(Prim("Material", name, look[0]), path, *look[1:]))
        return self._known[look]


def _material(made: Prim, path: str, finish: Finish, color: RGB | None, picture: str) -> Prim:
    """Fill a material; where there is no colour, vertices have theirs."""
    metallic, roughness, opacity = LOOKS[finish]
    made.lines.append(f"token outputs:surface.connect = <{path}/Surface.outputs:surface>")
    surface = Prim("Shader", "Surface")
    surface.put("uniform token info:id", quoted("UsdPreviewSurface"))
    made.children.append(surface)
    source = "Picture.outputs:rgb" if picture else "VertexColor.outputs:result"
    if picture or color is None:
        surface.lines.append(f"color3f inputs:diffuseColor.connect = <{path}/{source}>")
    else:
        surface.put("color3f inputs:diffuseColor", linear(color))
    surface.put("float inputs:metallic", f"{metallic:g}")
    surface.put("float inputs:roughness", f"{roughness:g}")
    surface.put("float inputs:opacity", f"{opacity:g}")
    surface.lines.append("token outputs:surface")
    if picture:
        places = Prim("Shader", "Places")
        places.put("uniform token info:id", quoted("UsdPrimvarReader_float2"))
        places.put("string inputs:varname", quoted("st"))
        places.lines.append("float2 outputs:result")
        file = Prim("Shader", "Picture")
        file.put("uniform token info:id", quoted("UsdUVTexture"))
        file.put("asset inputs:file", f"@./{picture}@")
        file.put("token inputs:sourceColorSpace", quoted("sRGB"))
        file.lines.append(f"float2 inputs:st.connect = <{path}/Places.outputs:result>")
        file.put("token inputs:wrapS", WRAP)
        file.put("token inputs:wrapT", WRAP)
        file.lines.append("float3 outputs:rgb")
        made.children += [places, file]
    elif color is None:
        reader = Prim("Shader", "VertexColor")
        reader.put("uniform token info:id", quoted("UsdPrimvarReader_float3"))
        reader.put("string inputs:varname", quoted("displayColor"))
        reader.lines.append("float3 outputs:result")
        made.children.append(reader)
    return made


def linear(color: RGB) -> str:
    """Return an sRGB colour as a tuple of linear light."""
    return "(" + ", ".join(f"{value:.6g}" for value in srgb_to_linear(color).tolist()) + ")"
