"""Mutated files of every format that is read: sound seeds, and injuries that know the format."""

from __future__ import annotations

import atexit
import gzip
import io
import json
import random
import re
import shutil
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from bozzetto.damaged_files import as_format_errors
from bozzetto.document.recovery.journal import JournalWriter, read_records
from bozzetto.document.storage.bozz_file import decode_document
from bozzetto.exchange.cad.dxf_document import mostly_faces
from bozzetto.exchange.formats import Kind, find, function, readers
from bozzetto.exchange.handover import FileFrame
from bozzetto.exchange.ink import ink_json, inkml
from bozzetto.exchange.mesh import glb, obj, ply, stl, threemf
from bozzetto.exchange.svg import reader as svg
from bozzetto.exchange.usd import usda, usdz
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin.host.manifest import read_manifest
from bozzetto.view import Camera
from bozzetto_car.template.loader import read_template
from tests.core.exchange.test_texture import painted_box
from tests.document_kit import FakeRegistry
from tests.hostile_files.dxf import (
    dxf,
    dxf_block,
    dxf_face,
    dxf_insert,
    dxf_line,
    dxf_vertex,
    tags,
)
from tests.reliability.mutated_documents import cases as document_cases
from tests.reliability.mutated_documents import mutated as bytes_changed
from tests.reliability.mutated_documents import other_value

Case = tuple[str, bytes]
"""An ending and a content."""

NUMBERS = (
    b"0", b"-1", b"1e308", b"-1e309", b"1e-320", b"nan", b"inf", b"4294967296", b"9" * 40, b"0.5",
    b"2147483648", b"1e9", b"-0", b"1e", b"#7f", b"1_0", b"0x10",
)  # fmt: skip

HOSTILE = (
    b"-1", b"4294967295", b"99999999999999999999", b"-inf", b"\x00", b"\xff\xff\xff\xff",
    b"\x7f\xff\xff\xff", b"\x00\x00\xc0\x7f", b"&a;", b"<!DOCTYPE a>", b"<![CDATA[", b"]]>",
    b"[[[[", b"}}", b'"', b"'", b",", b"#", b"\\\n", b"null", b"true", b"{}", b"[]", b"\xc3\x28",
    b"e", b".", b"-", b"z", b"A",
)  # fmt: skip
"""What readers may take for the beginning, the end or the number of something."""

WORDS = re.compile(rb"[+-]?\d+\.?\d*(?:e[+-]?\d+)?|[A-Za-z_]+|[<>{}\[\]()\",;:]")

OFF = (
    b"COFF\n3 2 0\n0 0 0 1 .5 0 1\n1 0 0 1 0 0 1\n0 1 0 .1 .2 .3 1\n3 0 1 2\n3 2 1 0 9 9 0 # red\n"
)

USDA = b"""#usda 1.0
(
    defaultPrim = "top"
    metersPerUnit = 0.1
    upAxis = "Y"
    timeCodesPerSecond = 24
)
def SkelRoot "top" ( displayName = "T p" prepend apiSchemas = ["SkelBindingAPI"] )
{
    def Skeleton "bones" {
        uniform token[] joints = ["a", "a/b"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1)),
            ((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,2,0,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0), (0,0,1,0), (0,-1,0,0), (0,0,0,1)),
            ((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,2,0,1))]
        rel skel:animationSource = </top/wag>
    }
    def SkelAnimation "wag" {
        uniform token[] joints = ["a", "a/b"]
        float3[] translations = [(0, 0, 0), (0, 2, 0)]
        quatf[] rotations.timeSamples = { 0: [(1, 0, 0, 0), (1, 0, 0, 0)],
            12: [(0.6, 0.8, 0, 0), (1, 0, 0, 0)], }
        half3[] scales = [(1, 1, 1), (1, 1, 1)]
    }
    def Mesh "m" {
        int[] faceVertexCounts = [3, 4]
        int[] faceVertexIndices = [0, 1, 2, 0, 2, 3, 4]
        point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 4, 0), (0, 4, 0), (-2, 2, 1)]
        normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)] (
            interpolation = "vertex"
        )
        texCoord2f[] primvars:st = [(0, 0), (1, 1)] ( interpolation = "faceVarying" )
        int[] primvars:st:indices = [0, 1, 0, 1, 0, 1, 0]
        color3f[] primvars:displayColor = [(1, 0, 0)]
        int[] primvars:skel:jointIndices = [0, 1, 0, 1, 0, 1, 0, 1, 0, 1] ( elementSize = 2 )
        float[] primvars:skel:jointWeights = [1, 0, 0, 1, 1, 0, .5, .5, 1, 0] ( elementSize = 2 )
        rel skel:skeleton = </top/bones>
        rel material:binding = </top/red>
        double3 xformOp:translate = (0, 1, 0)
        float3 xformOp:rotateXYZ = (0, 90, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "!invert!xformOp:rotateXYZ"]
        def GeomSubset "lid" {
            uniform token elementType = "face"
            int[] indices = [1]
            rel material:binding = </top/red>
        }
    }
    def Material "red" {
        token outputs:surface.connect = </top/red/s.outputs:surface>
        def Shader "s" {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (1, 0, 0)
            float inputs:roughness = 0.2
        }
    }
}
"""

ASCII_PLY = b"""ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
end_header
0 0 0 1 2 3
1 0 0 1 2 3
1 1 0 1 2 3
0 1 0 1 2 3
3 0 1 2
4 0 1 2 3
"""

TEXT_STL = (
    b"solid a\n"
    + b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
    + (b"vertex 0 1 0\nendloop\nendfacet\nendsolid a\n")
)

OBJ = b"o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .4 .4 0\nf 1 2/1 3//2 4 5\nf -1 -2 -3\nl 1 2\n"

SVG = b"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="-5 -5 110 90" width="110mm">
<style>.a{fill:red;stroke:#123} /* c */ #b,path{visibility:visible}</style>
<defs><symbol id="s" viewBox="0 0 9 9"><path id="b" d="M0 0L9 9V3z"/></symbol></defs>
<g transform="translate(1,2) rotate(30 5 5) skewX(3)" stroke="#a0b0c0" style="display:inline">
<path class="a" d="M1 2L3 4h5v-6zm1 1c1 1 2 2 3 3s4 4 5 5q1 2 3 4t1 1a3 4 20 1 0 5 6"/>
<rect x="1" y="2" width="30" height="20" rx="3"/><circle cx="5" cy="6" r="7"/>
<use href="#s" x="3" width="20"/><ellipse rx="3" ry="4"/><line x1="3" y2="1"/>
<svg x="5" viewBox="0 0 9 9" width="20" height="20"><polygon points="1,2 3,4 5,1"/></svg>
</g></svg>"""

INKML = b"""<ink xmlns="http://www.w3.org/2003/InkML"><definitions><context xml:id="c">
<traceFormat><channel name="X" units="mm"/><channel name="Y"/><channel name="F" max="99"/>
<channel name="T" units="ms"/></traceFormat></context></definitions>
<traceGroup contextRef="#c"><trace>1 2 50 0, 3 4 60 8, '1'1 * 16, "1"1 70 24</trace></traceGroup>
</ink>"""

MARKS = json.dumps(
    {
        "views": [{"marks": {"C1": [1, 2], "A2": [3.5, 4]}, "kind": "auto", "name": "a"}],
        "image": {"width": 800, "height": 600},
        "dimensions": {"LN": 4000},
    }
).encode()

GLTF = b"""{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,
"name":"a","translation":[1,2,3],"children":[1]},{"mesh":0,"scale":[1,2,1]}],"meshes":[{"primitives":
[{"attributes":{"POSITION":0},"material":0}]}],"materials":[{"pbrMetallicRoughness":{"baseColorFactor":
[1,0.5,0,1]}}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"""

DXF_MESH = dxf(
    dxf_face(0, 0, 0, 9, 0, 0, 0, 9, 1),
    tags((0, "POLYLINE"), (8, "a"), (66, 1), (70, 64)),
    *(dxf_vertex((10, x), (20, y), (30, x * y), (70, 192)) for x in (0, 5) for y in (0, 7)),
    dxf_vertex((10, 0), (20, 0), (30, 0), (70, 128), (71, 1), (72, 2), (73, 4), (74, 3)),
    tags((0, "SEQEND"), (8, "a")),
)

DXF = dxf(
    dxf_line(0, 0, 9, 0), dxf_line(9, 0, 9, 5), dxf_line(9, 5, 0, 0),
    tags((0, "CIRCLE"), (100, "AcDbEntity"), (8, "a"), (62, 3), (100, "AcDbCircle"),
         (10, 1), (20, 2), (30, 0), (40, 4)),
    tags((0, "LWPOLYLINE"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbPolyline"), (90, 3), (70, 1),
         (10, 0), (20, 0), (42, 0.5), (10, 4), (20, 0), (10, 4), (20, 3)),
    dxf_insert("b", (41, 2), (42, 3), (50, 30), (70, 2), (71, 2), (44, 5), (45, 5)),
    blocks=dxf_block("b", dxf_line(0, 0, 1, 1)),
)  # fmt: skip

PLUGINS = Path(__file__).parents[2] / "plugins"


def _journal() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        journal = JournalWriter(Path(folder) / "a")
        for content in (b"one", bytes(300), b"three"):
            journal.append(content)
        journal.close()
        return (Path(folder) / "a").read_bytes()


def _pictures() -> Iterator[Case]:
    from PIL import Image

    pixels = np.random.default_rng(0).integers(0, 255, (9, 7, 3), np.uint8)
    picture = Image.fromarray(pixels)
    exif = picture.getexif()
    exif[0x0112] = 6
    how: dict[str, dict[str, Any]] = {
        "png": {}, "jpg": {"exif": exif}, "tif": {"compression": "tiff_lzw"}, "webp": {}, "bmp": {},
    }  # fmt: skip
    for ending, options in how.items():
        file = io.BytesIO()
        form = {"jpg": "JPEG", "tif": "TIFF"}.get(ending, ending.upper())
        picture.save(file, form, **options)
        yield f".{ending}", file.getvalue()
    file = io.BytesIO()
    picture.convert("I;16" if hasattr(Image, "I16") else "L").save(file, "TIFF")
    yield ".tif", file.getvalue()


def _packages(shapes: Shapes) -> Iterator[Case]:
    """A 3MF, and one that is not compressed: where damage reaches the text."""
    packed = threemf.write_shapes(shapes)
    yield ".3mf", packed
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(packed)) as inside, zipfile.ZipFile(file, "w") as plain:
        for name in inside.namelist():
            plain.writestr(name, inside.read(name))
    yield ".3mf", file.getvalue()


@cache
def seeds() -> list[Case]:
    """Sound files of every format."""
    places = [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    solid = Solid(Mesh(places, faces, colors=np.arange(16).reshape(4, 4)), "a", (1, 2, 3))
    shapes = Shapes(solids=(solid, solid))
    row: dict[str, Any] = {"pressure": [0, 0.5, 1], "t": [0, 1, 2], "twist": [1, 2, 3]}
    stroke = Stroke([1, 2, 3], [4, 5, 6], Camera(), **row)
    drawing = Drawing(Strokes([stroke] * 2), Camera(), facts={"box": [1, {"a": None}]})
    found: list[Case] = [
        (".stl", stl.write_shapes(shapes)), (".stl", TEXT_STL), (".obj", OBJ),
        (".obj", obj.write_shapes(shapes)), (".ply", ply.write_shapes(shapes)),
        (".ply", ASCII_PLY), (".glb", glb.write_shapes(shapes)), (".svg", SVG),
        (".svg", svg.write_drawing(drawing)), (".inkml", INKML),
        (".inkml", inkml.write_drawing(drawing)), (".json", ink_json.write_drawing(drawing)),
        (".json", MARKS), (".toml", (PLUGINS / "bozzetto_mesh" / "plugin.toml").read_bytes()),
        (".template", (PLUGINS / "bozzetto_car" / "templates" / "sedan.json").read_bytes()),
        (".journal", _journal()),
    ]  # fmt: skip
    painted = Shapes(solids=(painted_box(), solid))
    found += [(".off", OFF), (".svgz", gzip.compress(SVG, mtime=0)), *_packages(painted)]
    metres = FileFrame("m", "y")
    found += [(".usda", USDA), (".usd", usda.write_shapes(painted, metres, beside="a"))]
    found += [(".usdz", usdz.write_shapes(painted, metres)), (".usdc", USDA)]
    found += [(".usdc", (Path(__file__).parents[1] / "data" / "scenes" / "worm.usdc").read_bytes())]
    found.append((".ply", ASCII_PLY.replace(b"4 0 1 2 3", b"3 0 1 2")))
    if find_spec("ezdxf"):
        found += [(".dxf", DXF), (".dxf", DXF_MESH)]
    return [*found, (".gltf", GLTF), *_pictures()]


# -- injuries --------------------------------------------------------------------------------------


def words_swapped(content: bytes, rng: random.Random) -> bytes:
    """Two words of a text exchanged, or one put in the place of another."""
    found = list(WORDS.finditer(content))
    if len(found) < 2:
        return content
    one, other = sorted(rng.sample(range(len(found)), 2))
    a, b = found[one], found[other]
    back = a[0] if rng.random() < 0.5 else b[0]
    middle = content[a.end() : b.start()]
    return content[: a.start()] + b[0] + middle + back + content[b.end() :]


def number_changed(content: bytes, rng: random.Random) -> bytes:
    """One number of a text made an extreme one."""
    found = [m for m in WORDS.finditer(content) if m[0][-1:].isdigit()]
    if not found:
        return content
    chosen = rng.choice(found)
    return content[: chosen.start()] + rng.choice(NUMBERS) + content[chosen.end() :]


def word_put_in(content: bytes, rng: random.Random) -> bytes:
    """A word that means something to a reader, put in or in the place of something."""
    at = rng.randrange(len(content) + 1)
    length = rng.choice((0, 0, 1, 2, 4, 8, 40))
    return content[:at] + rng.choice(HOSTILE) + content[at + length :]


def piece_repeated(content: bytes, rng: random.Random) -> bytes:
    """A piece of the content, up to a hundred times."""
    first = rng.randrange(len(content))
    last = min(len(content), first + rng.randrange(1, 80))
    return content[:first] + content[first:last] * rng.choice((2, 3, 100)) + content[last:]


def nested(content: bytes, rng: random.Random) -> bytes:
    """An element or a bracket put around and around something."""
    begin, end = rng.choice(((b"<g>", b"</g>"), (b"[", b"]"), (b'{"a":', b"}"), (b"<use>", b"")))
    at = rng.randrange(len(content))
    deep = rng.choice((1, 3, 120, 5000))
    return content[:at] + begin * deep + content[at : at + 9] + end * deep + content[at + 9 :]


def tree_changed(content: bytes, rng: random.Random) -> bytes:
    """A value of JSON changed; in a GLB that of its description, with its lengths put right."""
    is_glb = content[:4] == b"glTF" and len(content) > 20
    length = struct.unpack_from("<I", content, 12)[0] if is_glb else 0
    try:
        tree = json.loads(content[20 : 20 + length] if is_glb else content)
        text = json.dumps(other_value(tree, rng)).encode()
    except (ValueError, RecursionError):
        return words_swapped(content, rng)
    if not is_glb:
        return text
    text += b" " * (-len(text) % 4)
    rest = content[20 + length :]
    sizes = (2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    return b"glTF" + struct.pack("<4I", *sizes) + text + rest


def attribute_changed(content: bytes, rng: random.Random) -> bytes:
    """An attribute of XML given the value of another, or an element taken out or doubled."""
    quoted = list(re.finditer(rb'"[^"]*"', content))
    if len(quoted) < 2:
        return words_swapped(content, rng)
    one, other = rng.sample(quoted, 2)
    return content[: one.start()] + other[0] + content[one.end() :]


def chunk_changed(content: bytes, rng: random.Random) -> bytes:
    """A byte of a PNG's chunk changed, its checksum put right."""
    if content[:4] != b"\x89PNG":
        return bytes_changed(content, rng)
    at, chunks = 8, []
    while at + 8 <= len(content):
        (length,) = struct.unpack_from(">I", content, at)
        chunks.append((content[at + 4 : at + 8], content[at + 8 : at + 8 + length]))
        at += 12 + length
    if not chunks:
        return bytes_changed(content, rng)
    which = rng.randrange(len(chunks))
    kind, body = chunks[which]
    chunks[which] = (kind, bytes_changed(body, rng) if body else rng.randbytes(4))
    return content[:8] + b"".join(
        struct.pack(">I", len(b)) + k + b + struct.pack(">I", zlib.crc32(k + b)) for k, b in chunks
    )


def cut_short(content: bytes, rng: random.Random) -> bytes:
    """Only the beginning."""
    return content[: rng.randrange(len(content))]


INJURIES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    bytes_changed, bytes_changed, words_swapped, number_changed, number_changed, word_put_in,
    word_put_in, piece_repeated, nested, tree_changed, attribute_changed, chunk_changed, cut_short,
)  # fmt: skip


def cases(count: int, seed: int) -> Iterator[Case]:
    """Mutated files over all loaders; a fifth are documents."""
    rng = random.Random(seed)
    documents = document_cases(count, seed)
    for _ in range(count):
        if rng.random() < 0.2:
            yield ".bozz", next(documents)
            continue
        ending, content = rng.choice(seeds())
        yield ending, mutated(content, rng)


def mutated(content: bytes, rng: random.Random) -> bytes:
    """One to three injuries."""
    for _ in range(rng.choice((1, 1, 2, 3))):
        content = rng.choice(INJURIES)(content, rng) if content else content
    return content


@cache
def folder() -> Path:
    """A place for the files of this process, in memory where the system has such a place."""
    memory = Path("/dev/shm")
    made = tempfile.mkdtemp(prefix="bozzetto-mutated-", dir=memory if memory.is_dir() else None)
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    return Path(made)


def read(ending: str, content: bytes) -> object:
    """Read a content as the program reads a file of that ending."""
    if ending == ".bozz":
        return decode_document(content, FakeRegistry())
    if ending == ".toml":
        (folder() / "plugin.toml").write_bytes(content)
        return read_manifest(folder())
    if ending == ".journal":
        (folder() / "journal").write_bytes(content)
        return list(read_records(folder() / "journal"))
    if ending == ".template":
        return read_template(content)
    meshes = ending == ".dxf" and mostly_faces(content)
    kinds: tuple[Kind, ...] = ("ink",) if ending == ".dxf" and not meshes else ()
    chosen = find(f"a{ending}", readers(*kinds))
    with as_format_errors():
        if "mesh" in chosen.holds:
            return function(chosen, "read_shapes")(content)
        if "ink" in chosen.holds:
            return function(chosen, "read_drawing")(content, "a")
        return function(chosen, "read_pixels")(content)
