"""Files made to hurt their readers, as small generators: what once hurt stays here for ever.

Each family makes a file of about so many bytes. Most are read or refused in time that grows
with their size; a few are small and ask for much, and have one size only.
"""

from __future__ import annotations

import base64
import io
import json
import math
import random
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["FAMILIES", "Family", "families"]


@dataclass(frozen=True)
class Family:
    """Files of one kind.

    Attributes
    ----------
    name : str
        Begins with the ending.
    make : callable
        The content of a file of about so many bytes.
    """

    name: str
    make: Callable[[int], bytes]

    @property
    def ending(self) -> str:
        return "." + self.name.split()[0]


FAMILIES: list[Family] = []


def family(name: str):
    """Keep a generator under a name."""

    def keep(make: Callable[[int], bytes]) -> Callable[[int], bytes]:
        FAMILIES.append(Family(name, make))
        return make

    return keep


def families(ending: str = "") -> list[Family]:
    """All, or those of one ending."""
    return [one for one in FAMILIES if not ending or one.ending == ending]


def filled(unit: bytes, size: int) -> bytes:
    return unit * max(1, size // len(unit))


# -- InkML -----------------------------------------------------------------------------------------


def ink(body: bytes, definitions: bytes = b"") -> bytes:
    return b"<ink>" + definitions + body + b"</ink>"


def trace(body: bytes) -> bytes:
    return ink(b"<trace>" + body + b"</trace>")


def channels(count: int) -> bytes:
    more = b"".join(b'<channel name="c%d"/>' % k for k in range(count))
    return b'<traceFormat><channel name="X"/><channel name="Y"/>' + more + b"</traceFormat>"


@family("inkml blanks after a value")
def _(size):
    return trace(b"1 2" + b" " * size + b"$")


@family("inkml signs without values")
def _(size):
    return trace(b"1 2," + filled(b"' ", size))


@family("inkml one long number")
def _(size):
    return trace(b"1" * size + b" 2")


@family("inkml numbers without an end")
def _(size):
    return trace(filled(b"1e", size))


@family("inkml channels times rows")
def _(size):
    return ink(b"<trace>" + filled(b"1,", size // 2) + b"1</trace>", channels(size // 50))


@family("inkml empty rows")
def _(size):
    return trace(b"," * size)


@family("inkml traces of one sample")
def _(size):
    return ink(filled(b"<trace>1 2</trace>", size))


@family("inkml contexts that name each other")
def _(size):
    one = b'<context id="a%d" inkSourceRef="#a%d"/>'
    row = b"".join(one % (k, k + 1) for k in range(max(1, size // 40)))
    return ink(b"<trace>1 2</trace>", row)


@family("inkml formats without end")
def _(size):
    many = filled(b"<traceFormat><channel name='X'/></traceFormat>", size)
    return ink(b"<trace>1 2</trace>", b"<definitions>" + many + b"</definitions>")


@family("inkml nested deeply")
def _(size):
    count = max(1, size // 25)
    return ink(b"<traceGroup>" * count + b"</traceGroup>" * count)


@family("inkml in UTF-16")
def _(size):
    return trace(filled(b"1 2,", size // 2)).decode().encode("utf-16")


# -- SVG -------------------------------------------------------------------------------------------


def svg(body: bytes, head: bytes = b"") -> bytes:
    return b'<svg xmlns="http://www.w3.org/2000/svg"' + head + b">" + body + b"</svg>"


def path(data: bytes) -> bytes:
    return svg(b'<path d="' + data + b'"/>')


def polygon(places, extra: bytes = b"") -> bytes:
    row = " ".join(f"{x:.4f},{y:.4f}" for x, y in places).encode()
    return b'<polygon points="' + row + b'"' + extra + b"/>"


def random_places(count: int, seed: int, width: float = 1000.0):
    rng = random.Random(seed)
    return [(rng.uniform(0, width), rng.uniform(0, width)) for _ in range(count)]


@family("svg length of digits")
def _(size):
    return svg(b'<rect width="' + b"1" * size + b'q" height="1"/><path d="M0 0L1 1"/>')


@family("svg length of blanks")
def _(size):
    return svg(b'<rect width="1' + b" " * size + b'q" height="1"/><path d="M0 0L1 1"/>')


@family("svg style without braces")
def _(size):
    return svg(b"<style>" + b"a" * size + b"</style><path d='M0 0L1 1'/>")


@family("svg style of open comments")
def _(size):
    return svg(b"<style>" + filled(b"/* ", size) + b"</style><path d='M0 0L1 1'/>")


@family("svg selectors times declarations")
def _(size):
    row = b",".join(b".a%d" % k for k in range(size // 20))
    said = b";".join(b"p%d:1" % k for k in range(size // 20))
    return svg(b"<style>" + row + b"{" + said + b"}</style><path d='M0 0L1 1'/>")


@family("svg use times path")
def _(size):
    curve = b"M0 0" + filled(b"L1 2", size // 2)
    uses = filled(b'<use href="#p"/>', size // 2)
    return svg(b'<defs><path id="p" d="' + curve + b'"/></defs>' + uses)


@family("svg use times transform")
def _(size):
    turns = filled(b"scale(1)", size // 2)
    uses = filled(b'<use href="#p"/>', size // 2)
    return svg(b'<path id="p" transform="' + turns + b'" d="M0 0L1 1"/>' + uses)


@family("svg use times classes")
def _(size):
    classes = filled(b"a b ", size // 2)
    uses = filled(b'<use href="#p"/>', size // 2)
    look = b"<style>a{fill:red}</style>"
    return svg(look + b'<path id="p" class="' + classes + b'" d="M0 0L1 1"/>' + uses)


@family("svg symbol times attributes")
def _(size):
    many = b" ".join(b'a%d="1"' % k for k in range(size // 24))
    uses = filled(b'<use href="#p"/>', size // 2)
    return svg(b'<symbol id="p" ' + many + b'><path d="M0 0L1 1"/></symbol>' + uses)


@family("svg use of use, doubling")
def _(size):
    levels = min(60, max(2, size // 60))
    row = b"".join(
        b'<g id="g%d"><use href="#g%d"/><use href="#g%d"/></g>' % (k, k - 1, k - 1)
        for k in range(1, levels)
    )
    return svg(b'<g id="g0"><path d="M0 0L1 1"/></g>' + row)


@family("svg use of itself")
def _(size):
    return svg(b'<g id="a">' + filled(b'<use href="#a"/>', size) + b'</g><path d="M0 0L1 1"/>')


@family("svg groups of nothing, used")
def _(size):
    empty = filled(b"<g/>", size // 2)
    return svg(b'<g id="a">' + empty + b"</g>" + filled(b'<use href="#a"/>', size // 2))


@family("svg one random polygon")
def _(size):
    return svg(polygon(random_places(size // 20, 1)))


@family("svg two random polygons")
def _(size):
    both = (polygon(random_places(size // 40, seed)) for seed in (1, 2))
    return svg(b"".join(both))


@family("svg a comb of diagonals")
def _(size):
    teeth = size // 40
    places = [p for k in range(teeth) for p in ((k * 1e-3, 0.0), (1000 + k * 1e-3, 1000.0))]
    return svg(polygon(places))


@family("svg a star of spokes")
def _(size):
    spokes = max(3, size // 40)
    turn = 2 * math.pi / spokes
    places = [
        p
        for k in range(spokes)
        for p in ((0.0, 0.0), (900 * math.cos(k * turn), 900 * math.sin(k * turn)))
    ]
    return svg(polygon(places))


@family("svg squares on each other")
def _(size):
    return svg(filled(b'<rect width="9" height="9"/>', size).replace(b'"9"', b'"8.5"', 1))


@family("svg squares that all overlap")
def _(size):
    count = max(2, size // 45)
    return svg(b"".join(b'<rect x="%d" width="99999" height="%d"/>' % (k, k + 1)
                        for k in range(count)))  # fmt: skip


@family("svg path of small steps")
def _(size):
    return path(b"M0 0" + b"h1" * (size // 2))


@family("svg path of arcs")
def _(size):
    return path(b"M0 0" + filled(b"a9 9 0 1 1 1 1", size))


@family("svg path of moves")
def _(size):
    return path(filled(b"M1 1", size) + b"L2 2")


@family("svg path of blanks")
def _(size):
    return path(b"M0 0" + b" ," * (size // 2) + b"#")


@family("svg transforms without an end")
def _(size):
    return svg(b'<path d="M0 0L1 1" transform="' + b"a" * size + b'"/>')


@family("svg transforms that overflow")
def _(size):
    return svg(b'<path d="M0 0L1 1" transform="' + filled(b"scale(1e9)", size) + b'"/>')


@family("svg elements without end")
def _(size):
    return svg(filled(b"<g/>", size) + b"<path d='M0 0L1 1'/>")


@family("svg attributes without end")
def _(size):
    return svg(b"<path " + b" ".join(b'a%d=""' % k for k in range(size // 11)) + b" d='M0 0L1 1'/>")


@family("svg nested deeply")
def _(size):
    count = max(1, size // 7)
    return svg(b"<g>" * count + b"</g>" * count)


@family("svg of entities")
def _(size):
    rows = "".join(f'<!ENTITY a{k} "&a{k - 1};&a{k - 1};">' for k in range(1, 40))
    return f'<!DOCTYPE svg [<!ENTITY a0 "x">{rows}]><svg>&a39;</svg>'.encode()


@family("svg of comments")
def _(size):
    return svg(filled(b"<!-- -->", size) + b"<path d='M0 0L1 1'/>")


@family("svg a huge curve")
def _(size):
    return path(b"M0 0C" + filled(b"1e9 -1e9 -1e9 1e9 1 1 ", size))


# -- ink JSON --------------------------------------------------------------------------------------

HEAD = (
    b'{"format":"bozzetto-ink/1","canvas":{"width":9,"height":9},'
    b'"camera":{"kind":"orthographic","eye":[0,-1,0],"target":[0,0,0],"height":9},'
)


@family("json junk of empty lists")
def _(size):
    return HEAD + b'"strokes":[],"junk":[' + filled(b"[],", size) + b"0]}"


@family("json junk of empty objects")
def _(size):
    return b'{"views":[' + filled(b"{},", size) + b"{}]}"


@family("json keys without end")
def _(size):
    return b"{" + b",".join(b'"k%d":0' % k for k in range(size // 12)) + b"}"


@family("json one key, repeated")
def _(size):
    return b"{" + filled(b'"k":0,', size) + b'"k":1}'


@family("json nested deeply")
def _(size):
    return b'{"views":' + b"[" * (size // 2) + b"]" * (size // 2) + b"}"


@family("json one stroke without end")
def _(size):
    row = b",".join([b"1"] * (size // 4))
    return HEAD + b'"strokes":[{"x":[' + row + b'],"y":[' + row + b"]}]}"


@family("json strokes of one sample")
def _(size):
    return HEAD + b'"strokes":[' + filled(b'{"x":[1],"y":[1]},', size) + b'{"x":[1],"y":[1]}]}'


@family("json steps without end")
def _(size):
    return HEAD + b'"strokes":[],"steps":[' + filled(b'{"show":true},', size) + b'{"show":true}]}'


@family("json numbers beyond all bounds")
def _(size):
    return b'{"views":[' + filled(b"1e308,", size) + b"1e999]}"


@family("json a number of many digits")
def _(size):
    return b'{"views":' + b"9" * size + b"}"


@family("json a text of escapes")
def _(size):
    return b'{"views":"' + filled(b"\\u0041", size) + b'"}'


@family("json after a byte order mark")
def _(size):
    return b"\xef\xbb\xbf" + b" " * size + b"{}"


@family("json of NUL bytes")
def _(size):
    return bytes(size)


# -- OBJ -------------------------------------------------------------------------------------------


def zigzag(count: int) -> list[tuple[float, float]]:
    """A polygon that is not convex and does not cross itself: a saw on top of a line."""
    top = [(float(k), 1.0 + (k % 2)) for k in range(count - 2)]
    return [*top, (float(count), -1.0), (-1.0, -1.0)]


@family("obj a face of many corners")
def _(size):
    count = max(4, size // 22)
    rows = b"".join(b"v %g %g 0\n" % place for place in zigzag(count))
    return rows + b"f " + b" ".join(b"%d" % k for k in range(1, count + 1)) + b"\n"


@family("obj faces of five, not convex")
def _(size):
    rows = b"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\n"
    return rows + filled(b"f 1 2 3 4 5\n", size)


@family("obj faces of four, not convex")
def _(size):
    return b"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\n" + filled(b"f 1 2 3 4\n", size)


@family("obj faces of every size")
def _(size):
    rows = b"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\n"
    most = int(math.sqrt(size))
    return rows + b"".join(b"f " + b"1 2 3 4 " * (k // 4) + b"\n" for k in range(4, most))


@family("obj vertices of three letters")
def _(size):
    return filled(b"v 1 1 1\n", size) + b"f 1 2 3\n"


@family("obj empty lines")
def _(size):
    return b"\n" * size + b"v 0 0 0\nf 1 1 1\n"


@family("obj one long line")
def _(size):
    return b"v 0 0 0\nf " + filled(b"1 ", size)


@family("obj lines joined")
def _(size):
    return b"v 0 0 0 " + filled(b"\\\n", size) + b"\nf 1 1 1\n"


@family("obj a number of many digits")
def _(size):
    return b"v 0 0 0\nf " + b"9" * size + b" 1 1\n"


@family("obj places that are no numbers")
def _(size):
    return filled(b"v nan inf -inf\n", size) + b"f 1 2 3\n"


@family("obj a spiral of one face")
def _(size):
    count = max(6, size // 40)
    arm = [(k * math.cos(k / 5), k * math.sin(k / 5)) for k in range(count // 2)]
    back = [(0.99 * x, 0.99 * y) for x, y in reversed(arm)]
    rows = b"".join(b"v %g %g 0\n" % place for place in (*arm, *back))
    return rows + b"f " + b" ".join(b"%d" % (k + 1) for k in range(len(arm) + len(back))) + b"\n"


@family("obj a face that crosses itself")
def _(size):
    count = max(4, size // 25)
    rows = b"".join(b"v %g %g 0\n" % place for place in random_places(count, 3))
    return rows + b"f " + b" ".join(b"%d" % k for k in range(1, count + 1)) + b"\n"


# -- STL -------------------------------------------------------------------------------------------


def stl_records(count: int, record: bytes) -> bytes:
    return b"x" * 80 + struct.pack("<I", count) + record * count


@family("stl triangles without end")
def _(size):
    rng = random.Random(0)
    some = b"".join(struct.pack("<12fH", *(rng.random() for _ in range(12)), 0)
                    for _ in range(min(1000, max(1, size // 50))))  # fmt: skip
    count = max(1, size // len(some)) * (len(some) // 50)
    return b"x" * 80 + struct.pack("<I", count) + some * (count * 50 // len(some))


@family("stl of NaN and infinity")
def _(size):
    row = struct.pack("<12fH", *[math.nan] * 6, *[math.inf] * 6, 0)
    return stl_records(max(1, size // 50), row)


@family("stl that promises much")
def _(size):
    return b"x" * 80 + b"\xff\xff\xff\xff" + bytes(size)


@family("stl of words")
def _(size):
    return b"solid " + filled(b"a ", size)


@family("stl of vertices")
def _(size):
    return b"solid " + filled(b"vertex 1 1 1 ", size)


@family("stl of numbers that are none")
def _(size):
    return b"solid " + filled(b"vertex nan inf 1e999 ", size)


@family("stl of one point")
def _(size):
    return stl_records(max(1, size // 50), bytes(50))


# -- PLY -------------------------------------------------------------------------------------------


def ply(elements: bytes, body: bytes, form: bytes = b"binary_little_endian") -> bytes:
    return b"ply\nformat " + form + b" 1.0\n" + elements + b"end_header\n" + body


PLACES = b"property float x\nproperty float y\nproperty float z\n"
LISTS = b"property list uchar int vertex_indices\n"


@family("ply of 2^63 vertices")
def _(size):
    return ply(b"element vertex 9223372036854775808\n" + PLACES, bytes(size))


@family("ply lists of every length")
def _(size):
    rows = b"".join(bytes([k % 7]) + bytes(4 * (k % 7)) for k in range(size // 13))
    head = b"element vertex 1\n" + PLACES + b"element face %d\n" % (size // 13) + LISTS
    return ply(head, bytes(12) + rows)


@family("ply one list of all")
def _(size):
    head = b"element vertex 1\n" + PLACES
    head += b"element face 1\nproperty list uint int vertex_indices\n"
    return ply(head, bytes(12) + struct.pack("<I", size // 4) + bytes(size // 4 * 4))


@family("ply empty lists")
def _(size):
    head = b"element vertex 1\n" + PLACES + b"element face %d\n" % size + LISTS
    return ply(head, bytes(12) + bytes(size))


@family("ply rows of nothing")
def _(size):
    return ply(b"element nothing 19999999\n" * 9 + b"element vertex 1\n" + PLACES, bytes(size))


@family("ply elements without end")
def _(size):
    return ply(filled(b"element a 0\n", min(size, 60_000)), bytes(size))


@family("ply of short words")
def _(size):
    head = b"element vertex %d\n" % (size // 6) + PLACES + b"element face 1\n" + LISTS
    return ply(head, filled(b"1 ", size) + b"3 0 1 2", b"ascii")


@family("ply of words that are no numbers")
def _(size):
    head = b"element vertex %d\n" % (size // 12) + PLACES
    return ply(head, filled(b"nan inf ", size), b"ascii")


@family("ply lists of double length")
def _(size):
    head = b"element vertex 1\n" + PLACES
    head += b"element face 2\nproperty list double double vertex_indices\n"
    return ply(head, bytes(12) + struct.pack("<d", 1e300) + bytes(size))


@family("ply a face of many corners")
def _(size):
    count = max(4, size // 16)
    head = b"element vertex %d\n" % count + PLACES
    head += b"element face 1\nproperty list uint int vertex_indices\n"
    body = b"".join(struct.pack("<3f", x, y, 0) for x, y in zigzag(count))
    return ply(head, body + struct.pack("<I", count) + struct.pack(f"<{count}i", *range(count)))


# -- GLB -------------------------------------------------------------------------------------------


def glb(document: object, blob: bytes = b"") -> bytes:
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(blob), 0x4E4942) + blob
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def gltf(count: int, blob: bytes, **more: object) -> dict[str, object]:
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(blob)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(blob)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
        **more,
    }


@family("glb primitives times corners")
def _(size):
    count = max(3, size // 24)
    blob = bytes(12 * count)
    primitives = [{"attributes": {"POSITION": 0}}] * max(1, size // 80)
    return glb(gltf(count, blob, meshes=[{"primitives": primitives}]), blob)


@family("glb nodes times primitives")
def _(size):
    blob = bytes(36)
    primitives = [{"attributes": {"POSITION": 0}}] * max(1, size // 80)
    nodes = [{"mesh": 0}] * max(1, size // 30)
    return glb(gltf(3, blob, meshes=[{"primitives": primitives}], nodes=nodes), blob)


@family("glb nodes without end")
def _(size):
    return glb(gltf(3, bytes(36), nodes=[{}] * max(1, size // 4)), bytes(36))


@family("glb a chain of nodes")
def _(size):
    count = max(2, size // 22)
    nodes = [{"children": [k + 1]} for k in range(count - 1)] + [{}]
    return glb(gltf(3, bytes(36), nodes=nodes, scenes=[{"nodes": [0]}]), bytes(36))


@family("glb nodes in a ring")
def _(size):
    nodes = [{"children": [1]}, {"children": [0]}]
    return glb(gltf(3, bytes(36), nodes=nodes, scenes=[{"nodes": [0]}]), bytes(36) + bytes(size))


@family("glb junk in the description")
def _(size):
    return glb(b'{"asset":{"version":"2.0"},"extras":[' + filled(b"[],", size) + b"0]}")


@family("glb nested deeply")
def _(size):
    return glb(b'{"extras":' + b"[" * (size // 2) + b"]" * (size // 2) + b"}")


@family("glb strides of nothing")
def _(size):
    blob = bytes(size)
    document = gltf(size, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    document["bufferViews"] = [{"buffer": 0, "byteLength": size, "byteStride": 1}]
    return glb(document, blob)


@family("glb offsets below zero")
def _(size):
    blob = bytes(size)
    document = gltf(3, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    document["bufferViews"] = [{"buffer": 0, "byteLength": size, "byteOffset": -(2**62)}]
    return glb(document, blob)


@family("glb counts beyond all bounds")
def _(size):
    blob = bytes(size)
    document = gltf(2**62, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    return glb(document, blob)


@family("glb sparse accessors")
def _(size):
    blob = bytes(size)
    document = gltf(3, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    document["accessors"][0]["sparse"] = {"count": 2**40}  # type: ignore[index]
    return glb(document, blob)


@family("glb one accessor for everything")
def _(size):
    blob = bytes(max(36, size // 12 * 12))
    named = {"POSITION": 0, "NORMAL": 0, "COLOR_0": 0}
    document = gltf(len(blob) // 12, blob, meshes=[{"primitives": [{"attributes": named}]}])
    return glb(document, blob)


@family("glb matrices that overflow")
def _(size):
    nodes = [{"matrix": [1e300] * 16, "mesh": 0}]
    document = gltf(3, bytes(36), nodes=nodes)
    document["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}}]}]
    return glb(document, bytes(36) + bytes(size))


# -- glTF ------------------------------------------------------------------------------------------


def beside(document: object) -> bytes:
    return json.dumps(document).encode()


@family("gltf a buffer in the text")
def _(size):
    blob = bytes(max(36, size // 48 * 36))
    document = gltf(
        len(blob) // 12, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}]
    )
    uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    return beside(document | {"buffers": [{"byteLength": len(blob), "uri": uri}]})


@family("gltf buffers without end")
def _(size):
    one = {"byteLength": 36, "uri": "data:application/octet-stream;base64," + "AAAA" * 12}
    return beside(gltf(3, bytes(36)) | {"buffers": [one] * max(1, size // 110)})


@family("gltf buffers that lie beside")
def _(size):
    names = [{"byteLength": 36, "uri": f"{k}.bin"} for k in range(max(1, size // 40))]
    return beside(gltf(3, bytes(36)) | {"buffers": names})


@family("gltf a buffer that leads out of the folder")
def _(size):
    one = {"byteLength": 36, "uri": "../" * (size // 3) + "etc/passwd"}
    primitives = [{"attributes": {"POSITION": 0}}]
    return beside(gltf(3, bytes(36), meshes=[{"primitives": primitives}]) | {"buffers": [one]})


@family("gltf one node with all meshes' names")
def _(size):
    nodes = [{"mesh": 0, "name": "a" * size, "scale": [1e200] * 3}]
    primitives = [{"attributes": {"POSITION": 0}}]
    return beside(gltf(3, bytes(36), meshes=[{"primitives": primitives}], nodes=nodes))


@family("gltf a deep pile of lists")
def _(size):
    return b'{"asset":{"version":"2.0"},"extras":' + b"[" * (size // 2) + b"]" * (size // 2) + b"}"


# -- DXF -------------------------------------------------------------------------------------------


def dxf(*entities: bytes, blocks: bytes = b"") -> bytes:
    body = b"".join(entities)
    head = tags((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015"), (0, "ENDSEC"))
    sections = b"  0\nSECTION\n  2\nBLOCKS\n" + blocks + b"  0\nENDSEC\n" if blocks else b""
    return head + sections + b"  0\nSECTION\n  2\nENTITIES\n" + body + b"  0\nENDSEC\n  0\nEOF\n"


def tags(*pairs: tuple[int, object]) -> bytes:
    return b"".join(f"{code:3d}\n{value}\n".encode() for code, value in pairs)


def dxf_line(*ends: float) -> bytes:
    return tags((0, "LINE"), (8, "0"), *zip((10, 20, 11, 21), ends, strict=True))


def dxf_block(name: str, content: bytes) -> bytes:
    begin = tags((0, "BLOCK"), (8, "0"), (2, name), (70, 0), (10, 0), (20, 0), (30, 0))
    return begin + content + tags((0, "ENDBLK"), (8, "0"))


def dxf_insert(name: str, *more: tuple[int, object]) -> bytes:
    return tags((0, "INSERT"), (8, "0"), (2, name), (10, 1), (20, 1), (30, 0), *more)


@family("dxf lines without end")
def _(size):
    return dxf(filled(dxf_line(0, 0, 1, 1), size))


@family("dxf an open chain of lines")
def _(size):
    rows = (dxf_line(k, k % 2, k + 1, (k + 1) % 2) for k in range(max(1, size // 46)))
    return dxf(b"".join(rows))


@family("dxf blocks in blocks")
def _(size):
    count = 12
    rows = [dxf_block("b0", filled(dxf_line(0, 0, 1, 1), size // 2))]
    rows += [dxf_block(f"b{k}", dxf_insert(f"b{k - 1}") * 9) for k in range(1, count)]
    return dxf(dxf_insert(f"b{count - 1}"), blocks=b"".join(rows))


@family("dxf a block in itself")
def _(size):
    row = dxf_block("a", dxf_insert("a") + filled(dxf_line(0, 0, 1, 1), size))
    return dxf(dxf_insert("a"), blocks=row)


@family("dxf a block in rows beyond all bounds")
def _(size):
    many = dxf_insert("a", (70, 32767), (71, 32767), (44, 1.0), (45, 1.0))
    return dxf(filled(many, size), blocks=dxf_block("a", dxf_line(0, 0, 1, 1)))


@family("dxf a line of many corners")
def _(size):
    count = max(2, size // 22)
    places = [pair for x, y in zigzag(count) for pair in ((10, x), (20, y))]
    return dxf(
        tags(
            (0, "LWPOLYLINE"),
            (100, "AcDbEntity"),
            (8, "0"),
            (100, "AcDbPolyline"),
            (90, count),
            (70, 0),
            *places,
        )
    )


@family("dxf arcs of a line that turn and turn")
def _(size):
    count = max(2, size // 36)
    places = [pair for x, y in zigzag(count) for pair in ((10, x), (20, y), (42, 1e6))]
    return dxf(
        tags(
            (0, "LWPOLYLINE"),
            (100, "AcDbEntity"),
            (8, "0"),
            (100, "AcDbPolyline"),
            (90, count),
            (70, 1),
            *places,
        )
    )


@family("dxf a spline of high degree")
def _(size):
    count = max(8, size // 40)
    knots = [(40, float(k)) for k in range(2 * count)]
    places = [pair for x, y in zigzag(count) for pair in ((10, x), (20, y), (30, 0.0))]
    head = (
        (0, "SPLINE"),
        (100, "AcDbEntity"),
        (8, "0"),
        (100, "AcDbSpline"),
        (70, 8),
        (71, count - 1),
        (72, 2 * count),
        (73, count),
    )
    return dxf(tags(*head, *knots, *places))


@family("dxf splines with knots in one place")
def _(size):
    places = [pair for x, y in zigzag(4) for pair in ((10, x), (20, y), (30, 0.0))]
    head = (
        (0, "SPLINE"),
        (100, "AcDbEntity"),
        (8, "0"),
        (100, "AcDbSpline"),
        (70, 8),
        (71, 3),
        (72, 8),
        (73, 4),
    )
    return dxf(filled(tags(*head, *[(40, 0.0)] * 8, *places), size))


@family("dxf places beyond all bounds")
def _(size):
    return dxf(filled(dxf_line(1e308, -1e308, math.inf, math.nan), size))


@family("dxf a helix of many turns")
def _(size):
    axis = ((10, 0), (20, 0), (30, 0), (11, 1), (21, 0), (31, 0), (12, 0), (22, 0), (32, 1))
    one = tags(
        (0, "HELIX"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbSpline"), (70, 0), (71, 3), (72, 0),
        (73, 0), (100, "AcDbHelix"), *axis, (40, 1.0), (41, 1e9), (42, 1e-9),
    )  # fmt: skip
    return dxf(filled(one, size))


@family("dxf tags that are none")
def _(size):
    return dxf(filled(b"zz\nno number\n", size))


@family("dxf one long value")
def _(size):
    return dxf(tags((0, "TEXT"), (1, "a" * size)))


@family("dxf entities that nobody knows")
def _(size):
    return dxf(b"".join(tags((0, f"E{k}"), (8, k)) for k in range(max(1, size // 20))))


@family("dxf layers without end")
def _(size):
    rows = b"".join(
        tags((0, "LAYER"), (2, f"l{k}"), (70, 0), (62, -k)) for k in range(max(1, size // 40))
    )
    table = tags((0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (70, 1)) + rows
    return table + tags((0, "ENDTAB"), (0, "ENDSEC")) + dxf(dxf_line(0, 0, 1, 1))


# -- STEP and IGES ---------------------------------------------------------------------------------


def step(rows: bytes) -> bytes:
    head = b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
    head += b"FILE_NAME('','',(''),(''),'','','');\n"
    head += b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
    return head + rows + b"ENDSEC;\nEND-ISO-10303-21;\n"


@family("step points without end")
def _(size):
    row = b"#%d=CARTESIAN_POINT('',(0.,1.,2.));\n"
    return step(b"".join(row % k for k in range(1, max(2, size // 44))))


@family("step a chain of names")
def _(size):
    count = max(2, size // 40)
    row = b"#%d=ADVANCED_FACE('',(#%d),#%d,.T.);\n"
    return step(b"".join(row % (k, k + 1, k + 1) for k in range(1, count)))


@family("step a ring of names")
def _(size):
    rows = b"#1=CLOSED_SHELL('',(#2));\n#2=CLOSED_SHELL('',(#1));\n#3=MANIFOLD_SOLID_BREP('',#1);\n"
    return step(filled(rows, size))


@family("step nested deeply")
def _(size):
    return step(b"#1=CARTESIAN_POINT(''," + b"(" * (size // 2) + b")" * (size // 2) + b");\n")


@family("step one long name")
def _(size):
    return step(b"#1=CARTESIAN_POINT('" + b"a" * size + b"',(0.,1.,2.));\n")


@family("step an end that is missing")
def _(size):
    return step(b"/*" + b" " * size)


def iges(rows: list[bytes]) -> bytes:
    lines = [
        b"S".rjust(73) + b"      1",
        b"1H,,1H;,1Ha,1Ha,1Ha,1Ha,32,38,6,308,15,1Ha,1.,2,2HMM,1,1.;".ljust(72) + b"G      1",
    ]
    lines += rows
    return b"".join(line.ljust(80)[:80] + b"\n" for line in lines)


@family("iges entries without end")
def _(size):
    rows = []
    for k in range(max(1, size // 162)):
        rows.append(
            b"     116%8d       0       0       0       0       0       000000000D%7d"
            % (k, 2 * k + 1)
        )
        rows.append(
            b"     116       0       0       1       0                               0D%7d"
            % (2 * k + 2)
        )
    return iges(rows)


@family("iges blank lines")
def _(size):
    return iges([b""] * max(1, size // 81))


@family("iges one long number")
def _(size):
    return iges([b"1" * 64 + b"P%15d" % (k + 1) for k in range(max(1, size // 81))])


# -- pictures --------------------------------------------------------------------------------------


def png_chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width: int, height: int, rows: bytes, *more: bytes, depth: int = 8, kind: int = 2) -> bytes:
    header = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    chunks = png_chunk(b"IHDR", header) + b"".join(more)
    return b"\x89PNG\r\n\x1a\n" + chunks + png_chunk(b"IDAT", rows) + png_chunk(b"IEND", b"")


def encoded(width: int, height: int, form: str, mode: str = "RGB", **how: object) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.new(mode, (width, height)).save(file, form, **how)
    return file.getvalue()


def side_of(size: int) -> int:
    """A side so that a file of 64 MB stands for the largest picture that could be asked for."""
    return max(8, min(8400, int(math.sqrt(size))))


@family("png of black, large")
def _(size):
    side = side_of(size)
    return png(side, side, zlib.compress(bytes((3 * side + 1) * side), 1))


@family("png with little data")
def _(size):
    return png(60_000, 60_000, zlib.compress(b"\0"))


@family("png without an end of data")
def _(size):
    return png(8000, 8000, zlib.compress(bytes(size)))


@family("png a text that unpacks to much")
def _(size):
    packed = zlib.compress(bytes(16 * size), 9)
    return png(1, 1, zlib.compress(b"\0abc"), png_chunk(b"zTXt", b"a\0\0" + packed))


@family("png a profile that unpacks to much")
def _(size):
    packed = zlib.compress(bytes(16 * size), 9)
    return png(1, 1, zlib.compress(b"\0abc"), png_chunk(b"iCCP", b"a\0\0" + packed))


@family("png of empty chunks")
def _(size):
    return png(1, 1, zlib.compress(b"\0abc"), filled(png_chunk(b"tEXt", b"a\0b"), size))


@family("png of sixteen bits, large")
def _(size):
    side = side_of(size)
    rows = zlib.compress(bytes((2 * side + 1) * side), 1)
    return png(side, side, rows, depth=16, kind=0)


@family("tif of black, large")
def _(size):
    return encoded(side_of(size), side_of(size), "TIFF", compression="tiff_deflate")


@family("tif of floats, large")
def _(size):
    return encoded(side_of(size), side_of(size), "TIFF", "F", compression="tiff_deflate")


@family("tif directories in a ring")
def _(size):
    entries = struct.pack("<H", 1) + struct.pack("<HHII", 256, 4, 1, 9) + struct.pack("<I", 8)
    return b"II*\0" + struct.pack("<I", 8) + entries + bytes(size)


@family("tif with a table of 2^32 entries")
def _(size):
    rows = [(256, 4, 1, 9), (257, 4, 1, 9), (273, 4, 2**32 - 1, 8), (279, 4, 2**32 - 1, 8)]
    entries = struct.pack("<H", len(rows)) + b"".join(struct.pack("<HHII", *row) for row in rows)
    return b"II*\0" + struct.pack("<I", 8) + entries + bytes(4) + bytes(size)


@family("webp of black, large")
def _(size):
    return encoded(side_of(size), side_of(size), "WEBP", lossless=True, method=0, quality=0)


@family("webp of many frames")
def _(size):
    from PIL import Image

    file = io.BytesIO()
    frames = [Image.new("RGB", (900, 900), (k % 256, 0, 0)) for k in range(min(60, size // 800))]
    frames[0].save(file, "WEBP", save_all=True, append_images=frames[1:], method=0)
    return file.getvalue()


@family("jpg of black, large")
def _(size):
    return encoded(side_of(size), side_of(size), "JPEG")


@family("jpg of black, large, progressive")
def _(size):
    return encoded(side_of(size), side_of(size), "JPEG", progressive=True)


@family("jpg with damaged facts")
def _(size):
    exif = b"Exif\0\0II*\0" + struct.pack("<I", 8) + b"\xff\xff" + b"\x12\x01\x03\0" * 9999
    plain = encoded(8, 8, "JPEG")
    return plain[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + plain[2:]


@family("jpg of empty segments")
def _(size):
    plain = encoded(8, 8, "JPEG")
    return plain[:2] + filled(b"\xff\xfe\0\2", size) + plain[2:]


@family("bmp of 2^60 pixels")
def _(size):
    header = struct.pack("<IiiHHIIiiII", 40, 2**30, 2**30, 1, 24, *[0] * 6)
    return b"BM" + bytes(12) + header + bytes(size)


@family("bmp of runs, large")
def _(size):
    header = struct.pack("<IiiHHIIiiII", 40, 8000, 8000, 1, 8, 1, 0, 0, 0, 256, 0)
    return b"BM" + struct.pack("<IHHI", 0, 0, 0, 54 + 1024) + header + bytes(1024) + bytes(size)
