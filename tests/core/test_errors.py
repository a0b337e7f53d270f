"""What exceptions of others become in a person's message."""

from __future__ import annotations

import ast
import io
import re
from pathlib import Path

import pytest

import bozzetto
from bozzetto.errors import UserError, message_of, words_of
from bozzetto.exchange.formats import readers
from bozzetto.exchange.import_file import read_drawing, read_image, read_mesh

CORE = Path(bozzetto.__file__).parent
PLUGINS = Path(__file__).parents[2] / "plugins"
ADDRESS = re.compile(r"0x[0-9a-fA-F]{6,}|\bobject at\b")


class Silent(Exception):
    def __str__(self) -> str:
        raise ValueError("no words")


@pytest.mark.parametrize(
    ("problem", "said"),
    [
        (ValueError(f"cannot identify image file {io.BytesIO()!r}"), "image file the data"),
        (ValueError("<a.b object at 0x7f1234567890> and <lambda>"), "the data and <lambda>"),
        (ValueError("<function f.<locals>.g at 0x7f1234567890> failed."), "the data failed"),
        (TypeError(f"{object()} is wrong"), "the data is wrong"),
        (KeyError("size"), "size"),
        (OSError(28, "No space left on device"), "No space left on device"),
        (ValueError("two\nlines.\n"), "two lines"),
        (MemoryError(), "not enough memory"),
        (RecursionError("maximum recursion depth exceeded"), "nested too deeply"),
        (ValueError(), "an error of the kind ValueError"),
        (Silent(), "an error of the kind Silent"),
        (ValueError("x" * 9000), "…"),
    ],
)
def test_words_are_plain_and_short(problem, said):
    words = words_of(problem)
    assert said in words
    assert not ADDRESS.search(words)
    assert "\n" not in words
    assert not words.endswith(".")
    assert len(words) <= 300
    assert not ADDRESS.search(message_of(problem))


HOSTILE = {
    "text": b"this is no such file at all, only words\n" * 4,
    "zeros": bytes(400),
    "ones": b"\xff" * 400,
    "png": b"\x89PNG\r\n\x1a\n" + bytes(64),
    "jpeg": b"\xff\xd8\xff\xe0" + bytes(64),
    "tiff": b"II*\x00\x08\x00\x00\x00" + b"\xff" * 64,
    "webp": b"RIFF\x40\x00\x00\x00WEBPVP8 " + bytes(64),
    "bmp": b"BM" + b"\xff" * 64,
    "glb": b"glTF\x02\x00\x00\x00\x30\x00\x00\x00\x10\x00\x00\x00JSON" + b'{"a": <x>}      ' * 2,
    "ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\nq\n",
    "json": b'{"strokes": [[1, 2], {"x": "0x"}], "camera": 7}',
    "xml": b'<?xml version="1.0" encoding="x-none"?><svg><path d="M0"/></svg>',
    "inkml": b'<ink xmlns="http://www.w3.org/2003/InkML"><trace>a, b</trace></ink>',
    "obj": b"v 1 2\nf 1 2 9\n",
}


def refusal(read, path) -> str:
    """Why a file is refused; "" if it is read."""
    try:
        read(path)
    except UserError as problem:
        return problem.message
    return ""


@pytest.mark.filterwarnings("ignore:Corrupt EXIF data")
@pytest.mark.parametrize("ending", [e for one in readers() for e in one.endings])
def test_no_reader_shows_an_objects_address(tmp_path, ending):
    read = {"mesh": read_mesh, "ink": read_drawing, "image": read_image}
    holds = next(one.holds for one in readers() if ending in one.endings)
    reads = [read[kind] for kind in holds if kind in read]
    refused = 0
    for name, content in HOSTILE.items():
        path = tmp_path / f"{name}{ending}"
        path.write_bytes(content)
        for one in reads:
            said = refusal(one, path)
            refused += bool(said)
            assert not ADDRESS.search(said), said
            assert "\n" not in said
    assert refused >= len(HOSTILE) // 2


OUR_OWN = {
    *("UserError", "FormatError", "DocumentError", "ManifestError", "PluginFault", "Unfinished"),
    *("Refusal", "Unsound", "Locked", "Cancelled", "Undelivered", "Broken", "AssertionError"),
}
"""Exceptions whose messages are written for people."""


def handled(handler: ast.ExceptHandler) -> set[str]:
    """The names of the exceptions that are caught."""
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    return {ast.unparse(kind).rpartition(".")[2] for kind in kinds if kind is not None}


def told_raw(handler: ast.ExceptHandler) -> list[int]:
    """Lines in which the exception itself stands in an f-string, or is made a text."""
    found = []
    for node in ast.walk(handler):
        value = None
        if isinstance(node, ast.FormattedValue):
            value = node.value
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("str", "repr"):
            value = node.args[0]
        if isinstance(value, ast.Name) and value.id == handler.name:
            found.append(node.lineno)
    return found


@pytest.mark.parametrize("folder", [CORE, PLUGINS], ids=["core", "plugins"])
def test_messages_of_others_pass_through_one_place(folder):
    raw = []
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ExceptHandler) and handled(node) - OUR_OWN:
                raw += [f"{path.relative_to(folder)}:{line}" for line in told_raw(node)]
    assert raw == []
