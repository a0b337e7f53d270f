"""Hostile files: InkML."""

from __future__ import annotations

from tests.hostile_files.families import family, filled


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
