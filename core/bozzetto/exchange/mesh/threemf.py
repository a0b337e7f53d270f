"""3MF, for printing: named objects in millimetres, with colours and pictures where there are any.

Core specification 1.3 and the materials extension's ``m:colorgroup`` and ``m:texture2dgroup``.
Three libraries were tried as writers; one drops colours and breaks the schema, one is refused by
a common reader. This is the plain file that all readers tried accept.

Open shells are objects of the type "model", too: slicers pass over the type "surface" and then
refuse the file as empty, while they mend or slice an open shell of the type "model".
"""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass, field
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from bozzetto.arrays import Flags, Index
from bozzetto.exchange.color import WHITE, vertex_colors
from bozzetto.exchange.handover import MILLIMETRES, FileFrame, Unit
from bozzetto.exchange.mesh.face_groups import triangle_colors
from bozzetto.exchange.mesh.gltf_texture import picture_file
from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.exchange.safe_xml import writable
from bozzetto.geometry.shapes import Color, Shapes, Solid, Surface
from bozzetto.geometry.texture import Texture

CORE: Final = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIAL: Final = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
XML: Final = '<?xml version="1.0" encoding="UTF-8"?>\n'

TYPES: Final = (
    XML + '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONS: Final = (
    XML + '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)

PICTURE_TYPE: Final = (
    '<Default Extension="png" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodeltexture"/></Types>'
)
PICTURE_LINK: Final = (
    '<Relationship Target="/{0}" Id="{1}" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"/>'
)
LINKS: Final = "http://schemas.openxmlformats.org/package/2006/relationships"

UNIT_WORDS: Final[dict[Unit, str]] = {
    "mm": "millimeter",
    "cm": "centimeter",
    "m": "meter",
    "in": "inch",
}

EPOCH: Final = (1980, 1, 1, 0, 0, 0)
"""Date of every entry, so that equal shapes give equal files."""

COMPRESSION: Final = 4
"""Deflate level: beyond it the time grows faster than the file shrinks."""


@dataclass
class _Resources:
    """Resources of a model besides its objects, each with a number of its own."""

    texts: list[str] = field(default_factory=list)
    pictures: dict[str, bytes] = field(default_factory=dict)
    last: int = 0
    _known: dict[tuple[int, Color], int] = field(default_factory=dict)

    def number(self) -> int:
        """Return a number that nothing has."""
        self.last += 1
        return self.last

    def picture(self, texture: Texture, base: Color) -> int:
        """Return the number of a picture; equal ones are one."""
        key = (id(texture.pixels), base)
        if key not in self._known:
            self._known[key] = number = self.number()
            name = f"3D/Textures/{len(self.pictures) + 1}.png"
            self.pictures[name] = picture_file(texture, base)
            self.texts.append(
                f'<m:texture2d id="{number}" path="/{name}" contenttype="image/png" '
                'tilestyleu="clamp" tilestylev="clamp"/>\n'
            )
        return self._known[key]


def write_shapes(shapes: Shapes, frame: FileFrame = MILLIMETRES) -> bytes:
    """Write a 3MF package with one object per part, in the unit of the frame.

    A picture takes the place of colours, as in the other formats that hold one.
    """
    parts = [part for part in shapes.meshes() if len(part.mesh.faces)]
    held = _Resources()
    items = []
    for part in parts:
        items.append(f'<item objectid="{_object(part, held)}"/>')
    colored = any("<m:" in text for text in held.texts)
    model = (
        f'{XML}<model unit="{UNIT_WORDS[frame.unit]}" xml:lang="en-US" xmlns="{CORE}"'
        + (f' xmlns:m="{MATERIAL}"' if colored else "")
        + '>\n<metadata name="Application">Bozzetto</metadata>\n<resources>\n'
        + "".join(held.texts)
        + f"</resources>\n<build>{''.join(items)}</build>\n</model>"
    )
    entries: list[tuple[str, str | bytes]] = [
        ("[Content_Types].xml", TYPES),
        ("_rels/.rels", RELATIONS),
        ("3D/3dmodel.model", model),
    ]
    if held.pictures:
        entries[0] = entries[0][0], TYPES.replace("</Types>", PICTURE_TYPE)
        links = "".join(
            PICTURE_LINK.format(name, f"pic{number}") for number, name in enumerate(held.pictures)
        )
        text = f'{XML}<Relationships xmlns="{LINKS}">{links}</Relationships>'
        entries += [("3D/_rels/3dmodel.model.rels", text), *held.pictures.items()]
    package = io.BytesIO()
    with zipfile.ZipFile(package, "w", zipfile.ZIP_DEFLATED, compresslevel=COMPRESSION) as file:
        for name, content in entries:
            entry = zipfile.ZipInfo(name, EPOCH)
            packed = name in held.pictures
            entry.compress_type = zipfile.ZIP_STORED if packed else zipfile.ZIP_DEFLATED
            file.writestr(entry, content)
    return package.getvalue()


def _object(part: Solid | Surface, held: _Resources) -> int:
    """Add an object, and before it its colours or its picture; return its number."""
    proper = ~is_degenerate(part.mesh.faces)  # the schema forbids others
    rows = part.mesh.faces[proper].astype(np.int64)
    default, line = "", '<triangle v1="%d" v2="%d" v3="%d"/>'
    looks = _places(part, proper, held) if part.texture is not None else _colors(part, rows, held)
    if looks is not None:
        group, of_corners = looks
        default = f' pid="{group}" pindex="0"'
        if of_corners is not None:
            line = f'<triangle v1="%d" v2="%d" v3="%d" pid="{group}" p1="%d" p2="%d" p3="%d"/>'
            rows = np.hstack((rows, of_corners))
    vertices = ('<vertex x="%.9g" y="%.9g" z="%.9g"/>' * len(part.mesh.vertices)) % tuple(
        part.mesh.vertices.ravel().tolist()
    )
    triangles = (line * len(rows)) % tuple(rows.ravel().tolist())
    name = quoteattr(writable(part.name))
    number = held.number()
    held.texts.append(
        f'<object id="{number}" type="model" name={name}{default}><mesh>'
        f"<vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>\n"
    )
    return number


def _colors(
    part: Solid | Surface, faces: Index, held: _Resources
) -> tuple[int, Index | None] | None:
    """Add the colours of a part: their number, and those of corners (f, 3) if they differ."""
    by_triangle = triangle_colors(part)
    colors = vertex_colors(part) if by_triangle is None else by_triangle
    if colors is None:
        return None
    palette, index = np.unique(colors, axis=0, return_inverse=True)
    of_corners = index.ravel()[faces] if by_triangle is None else np.tile(index.reshape(-1, 1), 3)
    swatches = ('<m:color color="#%02X%02X%02X%02X"/>' * len(palette)) % tuple(
        palette.ravel().tolist()
    )
    number = held.number()
    held.texts.append(f'<m:colorgroup id="{number}">{swatches}</m:colorgroup>\n')
    return number, of_corners if len(palette) > 1 else None


def _places(part: Solid | Surface, proper: Flags, held: _Resources) -> tuple[int, Index] | None:
    """Add the places of a part in its picture; their number, and that of each corner, (f, 3)."""
    texture = part.texture
    if texture is None:
        return None
    picture = held.picture(texture, part.color or WHITE)
    corners = texture.corners[proper].astype(np.float64)
    corners[..., 1] = 1.0 - corners[..., 1]
    places, index = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    number = held.number()
    listed = ('<m:tex2coord u="%.10g" v="%.10g"/>' * len(places)) % tuple(places.ravel().tolist())
    held.texts.append(
        f'<m:texture2dgroup id="{number}" texid="{picture}">{listed}</m:texture2dgroup>\n'
    )
    return number, index.reshape(-1, 3)
