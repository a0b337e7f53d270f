"""Hostile files: USD, as text and as a package."""

from __future__ import annotations

import io
import zipfile

from tests.hostile_files.families import family, filled

HEAD = b"#usda 1.0\n"
SQUARE = (
    b"int[] faceVertexCounts=[3]int[] faceVertexIndices=[0,1,2]"
    b"point3f[] points=[(0,0,0),(1,0,0),(0,1,0)]"
)


def usdz(*entries: tuple[str, bytes], packing: int = zipfile.ZIP_STORED) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", packing) as package:
        for name, data in entries:
            package.writestr(name, data)
    return file.getvalue()


@family("usda prims without end")
def _(size):
    return HEAD + b'def "a"{' * (size // 8)


@family("usda prims beside each other")
def _(size):
    return HEAD + b'def Mesh "a"{}' * (size // 14)


@family("usda meshes that all name one material")
def _(size):
    one = b'def Mesh "a"{' + SQUARE + b"rel material:binding=</m>}"
    return HEAD + b'def Material "m"{}' + one * (size // len(one))


@family("usda a chain of connections in a ring")
def _(size):
    one = b'def Material "m"{token outputs:surface.connect=</m.outputs:surface>}'
    mesh = b'def Mesh "a"{' + SQUARE + b"rel material:binding=</m>}"
    return HEAD + one + mesh * (size // len(mesh))


@family("usda a long name above many prims")
def _(size):
    return HEAD + b'def "%s"{' % (b"a" * (size // 2)) + b'def "b"{}' * (size // 18) + b"}"


@family("usda lists in lists")
def _(size):
    return HEAD + b'def "a"{ token[] b = ' + b"[" * size


@family("usda braces in braces")
def _(size):
    return HEAD + b'def "a"( customData = ' + b"{" * size


@family("usda a list without end")
def _(size):
    return HEAD + b'def Mesh "a"{ int[] b = [' + filled(b"1,", size)


@family("usda many words")
def _(size):
    return HEAD + b'def Mesh "a"{' + SQUARE + b"token[] b = [" + filled(b'"",', size) + b"]}"


@family("usda values at many times")
def _(size):
    rows = b",".join(b"%d:1" % k for k in range(size // 8))
    return HEAD + b'def Mesh "a"{' + SQUARE + b"float b.timeSamples = {" + rows + b"}}"


@family("usda skeletons that share many motions")
def _(size):
    count = size // 420
    bind = b"matrix4d[] bindTransforms=[((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))]"
    bones = b"".join(
        b'def Skeleton "s%d"{token[] joints=["a"]%s}' % (k, bind) for k in range(count)
    )
    motion = (
        b'def SkelAnimation "m"{token[] joints=["a"]float3[] translations=[(0,0,0)]'
        b"quatf[] rotations.timeSamples={0:[(1,0,0,0)],1:[(1,0,0,0)]}}"
    )
    meshes = b"".join(
        b'def Mesh "a"{%srel skel:skeleton=</r/s%d>}' % (SQUARE, k) for k in range(count)
    )
    return HEAD + b'def "r"{' + bones + motion * count + b"}" + meshes


@family("usda transforms that grow beyond all bounds")
def _(size):
    one = (
        b'def Xform "a"{double3 xformOp:scale=(1e300,1e300,1)token[] xformOpOrder=["xformOp:scale"]'
    )
    return HEAD + one * min(size // len(one), 90) + b'def Mesh "m"{' + SQUARE + b"}" + b"}" * 90


@family("usda a transform of many steps")
def _(size):
    body = b"float xformOp:rotateX=1 token[] xformOpOrder=["
    return HEAD + b'def Mesh "a"{' + SQUARE + body + filled(b'"xformOp:rotateX",', size) + b"]}"


@family("usda a text that does not end")
def _(size):
    return HEAD + b'def "' + b"a" * size


@family("usda backslashes")
def _(size):
    return HEAD + b'("""' + b"\\" * size


@family("usda comments")
def _(size):
    return HEAD + filled(b"#\n", size)


@family("usda corners beyond all bounds")
def _(size):
    body = SQUARE.replace(b"[0,1,2]", b"[0,1,%s]" % (b"9" * min(size, 4000)))
    return HEAD + b'def Mesh "a"{' + body + b"}"


@family("usda groups of one mesh")
def _(size):
    one = b'def GeomSubset "g"{int[] indices=[0]rel material:binding=</m>}'
    rest = b'def Mesh "a"{' + SQUARE + one * (size // len(one)) + b"}"
    return HEAD + b'def Material "m"{}' + rest


@family("usdz a scene of zeros, packed")
def _(size):
    return usdz(("a.usda", HEAD + bytes(40 * size)), packing=zipfile.ZIP_DEFLATED)


@family("usdz many files")
def _(size):
    return usdz(*((f"{k}.txt", b"") for k in range(size // 100)))
