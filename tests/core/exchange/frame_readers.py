"""Where things lie in files of every format, read without any of our own code."""

from __future__ import annotations

import io
import json
import re
import struct
import zipfile
from typing import NamedTuple

import numpy as np
import pytest

MILLIMETRES = {"millimeter": 1.0, "centimeter": 10.0, "meter": 1000.0, "inch": 25.4}
"""Of the units of 3MF and Rhino."""

INSUNITS = {4: 1.0, 5: 10.0, 6: 1000.0, 1: 25.4}
"""Millimetres in the units of DXF."""


class Measured(NamedTuple):
    """Corners of the box around what a file holds, in the numbers and the axes of the file.

    `unit` is what the file says of its unit, mm, and `up` of the axis that points up; None where
    the format has no place for that.
    """

    low: np.ndarray
    high: np.ndarray
    unit: float | None = None
    up: str | None = None


def _around(points, unit=None, up=None):
    points = np.asarray(points, float).reshape(-1, 3)
    return Measured(points.min(axis=0), points.max(axis=0), unit, up)


def stl(data):
    count = struct.unpack_from("<I", data, 80)[0]
    assert len(data) == 84 + 50 * count
    rows = np.frombuffer(data, np.uint8, 50 * count, 84).reshape(count, 50)
    return _around(rows[:, 12:48].copy().view("<f4"))


def obj(data):
    return _around([row.split()[1:4] for row in data.decode().splitlines() if row[:2] == "v "])


def ply(data):
    head, _, body = data.partition(b"end_header\n")
    lines = head.decode().splitlines()
    assert lines[1].split()[1] == "binary_little_endian"
    count = int(next(line for line in lines if line.startswith("element vertex")).split()[2])
    own = lines[lines.index(f"element vertex {count}") + 1 :]
    kinds = {"float": "<f4", "uchar": "u1"}
    row = []
    for line in own:
        if not line.startswith("property "):
            break
        row.append((line.split()[2], kinds[line.split()[1]]))
    table = np.frombuffer(body, np.dtype(row), count)
    return _around(np.stack([table[axis] for axis in "xyz"], axis=-1))


def glb(data):
    length = struct.unpack_from("<I", data, 12)[0]
    told, body = json.loads(data[20 : 20 + length]), data[28 + length :]
    found = []

    def visit(number, above):
        node = told["nodes"][number]
        assert "rotation" not in node
        assert "matrix" not in node
        own = np.diag([*node.get("scale", (1, 1, 1)), 1.0])
        own[:3, 3] = node.get("translation", (0, 0, 0))
        here = above @ own
        for one in told["meshes"][node["mesh"]]["primitives"] if "mesh" in node else ():
            accessor = told["accessors"][one["attributes"]["POSITION"]]
            view = told["bufferViews"][accessor["bufferView"]]
            begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            assert view.get("byteStride", 12) == 12
            rows = np.frombuffer(body, "<f4", 3 * accessor["count"], begin).reshape(-1, 3)
            found.append(rows @ here[:3, :3].T + here[:3, 3])
        for child in node.get("children", ()):
            visit(child, here)

    for root in told["scenes"][told.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    return _around(np.concatenate(found), 1000.0, "y")  # glTF 2.0, 3.4


def threemf(data):
    text = zipfile.ZipFile(io.BytesIO(data)).read("3D/3dmodel.model").decode()
    assert "transform=" not in text
    rows = re.findall(r'<vertex x="(.*?)" y="(.*?)" z="(.*?)"', text)
    return _around(rows, MILLIMETRES[re.search(r'<model unit="(\w+)"', text)[1]], "z")


def usda(data):
    text = data.decode()
    assert "xformOp" not in text
    rows = re.findall(r"point3f\[\] points = \[(.*?)\]", text)
    points = np.concatenate([re.findall(r"[-+.\de]+", row) for row in rows])
    metres = float(re.search(r"metersPerUnit = (\S+)", text)[1])
    return _around(points, 1000.0 * metres, re.search(r'upAxis = "(\w)"', text)[1].lower())


def usdz(data):
    package = zipfile.ZipFile(io.BytesIO(data))
    return usda(package.read(package.namelist()[0]))


def svg(data):
    text = data.decode()
    box = [float(v) for v in re.search(r'viewBox="(.*?)"', text)[1].split()]
    wide, unit = re.search(r'<svg [^>]*width="([\d.e+-]+)(\w+)"', text).groups()
    at = re.findall(r"([-+.\de]+),([-+.\de]+)", " ".join(re.findall(r' d="(.*?)"', text)))
    x, y = np.array(at, float).T
    scale = float(wide) / box[2]  # the file is a front view: x to the right, z up
    size = {"mm": 1.0, "cm": 10.0, "in": 25.4}[unit]
    return _around(np.stack([x, np.full(len(x), np.nan), -y], axis=-1) * scale, size, "z")


def dxf(data):
    lines = data.decode().splitlines()
    pairs = list(zip([int(code) for code in lines[::2]], lines[1::2], strict=True))
    names = [value for code, value in pairs if code == 9]
    assert "$INSUNITS" in names
    unit = int(pairs[pairs.index((9, "$INSUNITS")) + 1][1])
    kind, own, found = "", {}, []
    begin = pairs.index((2, "ENTITIES"))
    for code, value in pairs[begin:]:
        if code == 0:
            kind, own = value, {}
        elif kind in ("SPLINE", "LWPOLYLINE") and code in (10, 20, 30):
            own[code] = float(value)
            if code == (30 if kind == "SPLINE" else 20):
                x, y = own[10], own[20]
                found.append((x, y, own[30]) if kind == "SPLINE" else (x, np.nan, y))
    return _around(found, INSUNITS[unit], "z")


def step(data):
    text = data.decode().replace("\n", "")
    places = dict(re.findall(r"(#\d+)=CARTESIAN_POINT\('',\(([^)]*)\)\)", text))
    used = re.findall(r"#\d+", " ".join(re.findall(r"B_SPLINE_CURVE_WITH_KNOTS\((.*?)\)", text)))
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    return _around([places[name].split(",") for name in used], 1.0, "z")


def iges(data):
    lines = data.decode().splitlines()
    told = "".join(line[:72] for line in lines if line[72] == "G").split(",")
    flag, name = told[told.index("2HMM") - 1], "2HMM"
    assert (flag, name) == ("2", "2HMM")
    points = []
    text = "".join(line[:64].strip() for line in lines if line[72] == "P")
    for row in text.split(";"):
        values = row.split(",")
        if values[0] == "126":
            upper, degree = int(values[1]), int(values[2])
            begin = 7 + (upper + degree + 2) + (upper + 1)
            points += values[begin : begin + 3 * (upper + 1)]
    return _around(points, 1.0, "z")


def rhino(data):
    library = pytest.importorskip("rhino3dm")
    model = library.File3dm.FromByteArray(data)
    unit = str(model.Settings.ModelUnitSystem).rpartition(".")[2].lower().removesuffix("s")
    boxes = [one.Geometry.GetBoundingBox() for one in model.Objects]
    corners = [(b.X, b.Y, b.Z) for box in boxes for b in (box.Min, box.Max)]
    return _around(corners, MILLIMETRES[unit.replace("inche", "inch")], "z")


READERS = {
    "stl": stl, "obj": obj, "ply": ply, "glb": glb, "3mf": threemf, "usda": usda, "usdz": usdz,
    "svg": svg, "dxf": dxf, "step": step, "iges": iges, "3dm": rhino,
}  # fmt: skip
