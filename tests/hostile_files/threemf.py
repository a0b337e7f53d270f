"""Hostile files: 3MF."""

from __future__ import annotations

import io
import zipfile

from tests.hostile_files.families import family, filled

CORE = b"http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
TRIANGLE = (
    b'<object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
    b'<vertex x="0" y="1" z="0"/></vertices><triangles>'
    b'<triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>'
)


def package(resources: bytes, build: bytes, packing: int = zipfile.ZIP_STORED) -> bytes:
    data = io.BytesIO()
    text = (
        b'<model xmlns="' + CORE + b'"><resources>' + resources + b"</resources><build>"
        + build + b"</build></model>"
    )  # fmt: skip
    with zipfile.ZipFile(data, "w", packing) as file:
        file.writestr("3D/3dmodel.model", text)
    return data.getvalue()


@family("3mf one object with many vertices")
def _(size):
    vertices = filled(b'<vertex x="1" y="2" z="3"/>', size)
    return package(
        TRIANGLE.replace(b"<vertices>", b"<vertices>" + vertices), b'<item objectid="1"/>'
    )


@family("3mf one part placed without end")
def _(size):
    return package(
        TRIANGLE, filled(b'<item objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>', size)
    )


@family("3mf groups of groups of groups")
def _(size):
    count = max(2, size // 300)
    groups = b"".join(
        b'<object id="%d"><components>' % k + b'<component objectid="%d"/>' % (k - 1) * 8
        + b"</components></object>"
        for k in range(2, count)
    )  # fmt: skip
    return package(TRIANGLE + groups, b'<item objectid="%d"/>' % (count - 1))


@family("3mf spaces packed away")
def _(size):
    return package(b" " * (200 * size), b"", zipfile.ZIP_DEFLATED)


@family("3mf colours without end")
def _(size):
    colors = filled(b'<m:color color="#112233"/>', size)
    group = b'<m:colorgroup xmlns:m="m" id="5">' + colors + b"</m:colorgroup>"
    return package(group + TRIANGLE, b'<item objectid="1"/>')
