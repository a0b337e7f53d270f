"""3MF, for printing: named objects in millimetres, with colours where there are any.

Core specification 1.3 and the materials extension's ``m:colorgroup``. Three libraries were
tried as writers; one drops colours and breaks the schema, one is refused by a common
reader. This is the plain file that all readers tried accept.

Open shells are objects of the type "model", too: slicers pass over the type "surface" and then
refuse the file as empty, while they mend or slice an open shell of the type "model".
"""

from __future__ import annotations

import io
import zipfile
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from bozzetto.exchange.color import vertex_colors
from bozzetto.exchange.handover import MILLIMETRES, FileFrame, Unit
from bozzetto.exchange.mesh.face_groups import triangle_colors
from bozzetto.exchange.mesh.polygons import without_degenerate
from bozzetto.exchange.safe_xml import writable
from bozzetto.geometry.shapes import Shapes, Solid, Surface

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


def write_shapes(shapes: Shapes, frame: FileFrame = MILLIMETRES) -> bytes:
    """Write a 3MF package with one object per part, in the unit of the frame."""
    parts = [part for part in shapes.meshes() if len(part.mesh.faces)]
    colored = any(
        vertex_colors(part) is not None or triangle_colors(part) is not None for part in parts
    )
    resources: list[str] = []
    items: list[str] = []
    for number, part in enumerate(parts):
        resources.append(_object(part, color_id=2 * number + 1, object_id=2 * number + 2))
        items.append(f'<item objectid="{2 * number + 2}"/>')
    model = (
        f'{XML}<model unit="{UNIT_WORDS[frame.unit]}" xml:lang="en-US" xmlns="{CORE}"'
        + (f' xmlns:m="{MATERIAL}"' if colored else "")
        + '>\n<metadata name="Application">Bozzetto</metadata>\n<resources>\n'
        + "".join(resources)
        + f"</resources>\n<build>{''.join(items)}</build>\n</model>"
    )
    package = io.BytesIO()
    with zipfile.ZipFile(package, "w", zipfile.ZIP_DEFLATED, compresslevel=COMPRESSION) as file:
        for name, text in (
            ("[Content_Types].xml", TYPES),
            ("_rels/.rels", RELATIONS),
            ("3D/3dmodel.model", model),
        ):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(entry, text)
    return package.getvalue()


def _object(part: Solid | Surface, color_id: int, object_id: int) -> str:
    """Return the XML of one object, its colours before it."""
    faces = without_degenerate(part.mesh.faces)  # the schema forbids them
    by_triangle = triangle_colors(part)
    colors = vertex_colors(part) if by_triangle is None else by_triangle
    group, default, line = "", "", '<triangle v1="%d" v2="%d" v3="%d"/>'
    rows = faces.astype(np.int64)
    if colors is not None:
        palette, index = np.unique(colors, axis=0, return_inverse=True)
        of_corners = index.ravel()[faces] if by_triangle is None else np.tile(index[:, None], 3)
        swatches = ('<m:color color="#%02X%02X%02X%02X"/>' * len(palette)) % tuple(
            palette.ravel().tolist()
        )
        group = f'<m:colorgroup id="{color_id}">{swatches}</m:colorgroup>\n'
        default = f' pid="{color_id}" pindex="0"'
        if len(palette) > 1:
            line = f'<triangle v1="%d" v2="%d" v3="%d" pid="{color_id}" p1="%d" p2="%d" p3="%d"/>'
            rows = np.hstack((rows, of_corners))
    vertices = ('<vertex x="%.9g" y="%.9g" z="%.9g"/>' * len(part.mesh.vertices)) % tuple(
        part.mesh.vertices.ravel().tolist()
    )
    triangles = (line * len(rows)) % tuple(rows.ravel().tolist())
    name = quoteattr(writable(part.name))
    return (
        f'{group}<object id="{object_id}" type="model" name={name}{default}><mesh>'
        f"<vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>\n"
    )
