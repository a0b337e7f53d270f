"""Hostile files: ink JSON."""

from __future__ import annotations

from tests.hostile_files.families import family, filled

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
