"""Thousands of damaged files: nothing but `UserError` may come out of a reader."""

from __future__ import annotations

import gzip
import json
import random
import struct
import subprocess
import sys
import textwrap
import zipfile

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import UserError
from bozzetto.exchange.export import export, write_drawing
from bozzetto.exchange.formats import FORMATS, find, function, readers
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.view import Camera
from tests.core.exchange.test_texture import painted_box
from tests.sizes import sized

DEFAULT_CASES = 3000
LONG_CASES = sized(10_000, 200_000)

MEMORY = 3 << 30
"""Address space of the process that reads the hungry files, bytes."""

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

TEXT_STL = b"""solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid a
"""

OBJ = b"o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .4 .4 0\nf 1 2/1 3//2 4 5\nf -1 -2 -3\nl 1 2\n"

OFF = b"COFF\n4 3 0\n0 0 0 1 .5 0 1\n1 0 0 1 0 0 1\n0 1 0 .1 .2 .3 1\n0 0 1 1 1 1 1\n3 0 1 2\n" + (
    b"3 0 1 3 255 0 9 # red\n4 0 3 2 1 .1 .2 .3\n"
)

GLTF = (
    b'{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"a","scale":[1,2,3]}]'
    b',"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[{"bufferView'
    b'":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":3'
    b',"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,'
    b'"byteLength":3}],"buffers":[{"byteLength":39,"uri":"data:application/octet-stream;base64,AAAAAAAAA'
    b'AAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC"}]}'
)

SVG = b"""<?xml version="1.0" encoding="utf-8"?>
<svg xmlns="http://www.w3.org/2000/svg" viewBox="-5 -5 110 90" width="110mm" height="90mm">
<g transform="translate(1,2) rotate(30 5 5)" stroke="#a0b0c0" style="display:inline">
<path d="M1 2L3 4h5v-6zm1 1c1 1 2 2 3 3s4 4 5 5q1 2 3 4t1 1a3 4 20 1 0 5 6"/>
<rect x="1" y="2" width="30" height="20" rx="3"/><circle cx="5" cy="6" r="7"/>
<svg x="5" viewBox="0 0 9 9" width="20" height="20"><polygon points="1,2 3,4 5,1"/></svg>
</g></svg>"""

INKML = b"""<ink xmlns="http://www.w3.org/2003/InkML"><definitions><context xml:id="c">
<traceFormat><channel name="X" units="mm"/><channel name="Y"/><channel name="F" max="99"/>
<channel name="T" units="ms"/></traceFormat></context></definitions>
<traceGroup contextRef="#c"><trace>1 2 50 0, 3 4 60 8, '1'1 * 16, "1"1 70 24</trace></traceGroup>
</ink>"""

HOSTILE = [
    b"-1", b"0", b"4294967295", b"99999999999999999999", b"1e308", b"1e-320", b"nan", b"inf",
    b"-inf", b"\x00", b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", b"\x00\x00\xc0\x7f", b"&a;",
    b"<!DOCTYPE a>", b"<![CDATA[", b"]]>", b"[[[[", b"}}", b'"', b"'", b",", b"#", b"\\\n", b"null",
    b"true", b"{}", b"[]", b"\xc3\x28", b"e", b".", b"-", b"z", b"A",
]  # fmt: skip


@pytest.fixture(scope="session")
def seeds(tmp_path_factory):
    """Good files of every format that is read, as (ending, bytes)."""
    folder = tmp_path_factory.mktemp("seeds")
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    places = [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]]
    solid = Solid(Mesh(places, faces, colors=np.arange(16).reshape(4, 4)), "a", (1, 2, 3))
    for ending in ("stl", "glb", "obj", "ply"):
        export(Shapes(solids=(solid, solid)), folder / f"a.{ending}")
    export(Shapes(solids=(painted_box(), solid)), folder / "a.3mf")
    with (
        zipfile.ZipFile(folder / "a.3mf") as packed,
        zipfile.ZipFile(folder / "b.3mf", "w") as plain,  # where damage reaches the text
    ):
        for name in packed.namelist():
            plain.writestr(name, packed.read(name))
    stroke = Stroke(
        [1, 2, 3], [4, 5, 6], Camera(), pressure=[0, 0.5, 1], t=[0, 1, 2], twist=[1, 2, 3]
    )
    drawing = Drawing(Strokes([stroke] * 2), Camera(), facts={"box": [1, {"a": None}]})
    for ending in ("json", "inkml", "svg"):
        write_drawing(drawing, folder / f"a.{ending}")
    picture = Image.fromarray(np.random.default_rng(0).integers(0, 255, (9, 7, 3), np.uint8))
    for ending in ("png", "jpg", "tif", "webp", "bmp"):
        picture.save(folder / f"a.{ending}")
    files = [(p.suffix, p.read_bytes()) for p in sorted(folder.iterdir()) if p.suffix != ".mtl"]
    files += [(".gltf", GLTF), (".off", OFF), (".svgz", gzip.compress(SVG, mtime=0))]
    files += [(".ply", ASCII_PLY), (".ply", ASCII_PLY.replace(b"4 0 1 2 3", b"3 0 1 2"))]
    files += [(".stl", TEXT_STL), (".obj", OBJ), (".svg", SVG), (".inkml", INKML)]
    return files


def mutated(data, rng):
    """One to four injuries of the usual kinds."""
    out = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(out) + 1)
        length = min(rng.choice((1, 1, 2, 4, 8, 40)), len(out) - at)
        match rng.randrange(7):
            case 0 if at < len(out):
                out[at] ^= 1 << rng.randrange(8)
            case 1:
                out[at:at] = rng.choice(HOSTILE)
            case 2:
                out[at : at + length] = rng.choice(HOSTILE)
            case 3:
                del out[at : at + length]
            case 4:
                out[at:at] = out[at : at + length] * rng.randint(1, 3)
            case 5:
                out[at : at + length] = rng.randbytes(length)
            case 6:
                other = rng.randrange(len(out) + 1)
                out[at : at + length] = out[other : other + length]
        if rng.random() < 0.05:
            del out[rng.randrange(len(out) + 1) :]
    return bytes(out)


def read(ending, data):
    chosen = find(f"a{ending}", readers())
    if "mesh" in chosen.holds:
        return function(chosen, "read_shapes")(data)
    if "ink" in chosen.holds:
        return function(chosen, "read_drawing")(data, "a")
    return function(chosen, "read_pixels")(data)


def attack(seeds, endings, cases, seed):
    rng = random.Random(seed)
    chosen = [entry for entry in seeds if entry[0] in endings]
    read_well = told = 0
    for case in range(cases):
        ending, data = rng.choice(chosen)
        broken = mutated(data, rng)
        try:
            read(ending, broken)
            read_well += 1
        except UserError as error:
            told += bool(error.message)
        except Exception as error:
            raise AssertionError(f"case {case} of {ending}: {broken!r}") from error
    assert 0 < read_well < cases
    assert told == cases - read_well


READ = [one for one in FORMATS if one.reads and one.id not in ("cad", "dxf-drawing", "dxf-mesh")]
"""Readers of ours; those of other libraries are tried where these are."""


@pytest.mark.filterwarnings("ignore::UserWarning:PIL", "ignore::PIL.Image.DecompressionBombWarning")
@pytest.mark.filterwarnings("ignore:::tifffile")
@pytest.mark.parametrize("one", READ, ids=[one.id for one in READ])
def test_only_user_errors_escape(seeds, one):
    attack(seeds, one.endings, DEFAULT_CASES, seed=one.id)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning:PIL", "ignore::PIL.Image.DecompressionBombWarning")
@pytest.mark.parametrize("one", READ, ids=[one.id for one in READ])
def test_only_user_errors_escape_for_long(seeds, one):
    attack(seeds, one.endings, LONG_CASES, seed=f"{one.id} long")


def test_the_seeds_are_good(seeds):
    for ending, data in seeds:
        read(ending, data)
    assert {ending for one in READ for ending in one.endings} - {e for e, _ in seeds} == {
        ".jpeg", ".tiff",
    }  # fmt: skip


def glb_of(document, blob):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x4E4942)
    )
    return b"glTF" + struct.pack("<II", 2, 20 + len(body) + len(blob)) + body + blob


def hungry_files():
    """Small files that ask for much."""
    accessor = {"bufferView": 0, "componentType": 5126, "count": 2**40, "type": "VEC3"}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 2**50}],
        "bufferViews": [{"buffer": 0, "byteLength": 2**50, "byteStride": 12}],
        "accessors": [accessor],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * 1000}],
    }
    yield ".glb", glb_of(document, bytes(4096))
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 19999999\n"
    yield ".ply", head + b"property double x\n" * 200 + b"end_header\n"
    yield ".ply", head + b"end_header\n"
    lists = b"element face 9999999\nproperty list uint double vertex_indices\nend_header\n"
    yield ".ply", b"ply\nformat binary_little_endian 1.0\n" + lists + b"\xff\xff\xff\x7f" * 99
    yield ".stl", b"x" * 80 + b"\xff\xff\xff\x7f" + bytes(5000)
    curve = b"C" + b"1e9 -1e9 -1e9 1e9 1 1 " * 40_000
    yield ".svg", b'<svg><path d="M0 0' + curve + b'"/></svg>'
    yield (
        ".svg",
        b"<svg>" + b"<g>" * 90 + b"<path d='M0 0L1 1'/>" * 5_000 + b"</g>" * 90 + b"</svg>",
    )
    yield ".inkml", b"<ink><trace>" + b"1 1," * 1_500_000 + b"</trace></ink>"
    yield ".json", b'{"format":"bozzetto-ink/1","canvas":{},"camera":{},"strokes":[' + b"0," * 10**6
    yield ".bmp", b"BM" + bytes(12) + struct.pack("<IiiHHIIiiII", 40, 2**30, 2**30, 1, 24, *[0] * 6)


@pytest.mark.skipif(sys.platform != "linux", reason="limits memory the Linux way")
def test_small_files_cannot_eat_the_memory(tmp_path):
    endings = []
    for number, (ending, data) in enumerate(hungry_files()):
        endings.append(ending)
        (tmp_path / f"{number}{ending}").write_bytes(data)
    code = """
        import resource, sys
        from pathlib import Path
        resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[2]),) * 2)
        from bozzetto.errors import UserError
        from bozzetto.exchange import import_file as importing
        for path in sorted(Path(sys.argv[1]).iterdir()):
            name = {".svg": "drawing", ".inkml": "drawing", ".json": "drawing", ".bmp": "image"}
            try:
                getattr(importing, "read_" + name.get(path.suffix, "mesh"))(path)
                print(path.name, "read")
            except UserError as error:
                print(path.name, error.message[:60])
    """
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", textwrap.dedent(code), str(tmp_path), str(MEMORY)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
    assert len(done.stdout.splitlines()) == len(endings)
