"""Records of a type from any thread, and that nobody goes past the one place that makes them."""

from __future__ import annotations

import ast
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Annotated

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bozzetto
from bozzetto import typed_data
from bozzetto.typed_data import convert, decode_in_turns, decode_json, decode_msgpack

ROOT = Path(__file__).parents[2]

RACE = textwrap.dedent("""
    import sys, threading
    import msgspec
    from msgspec import defstruct
    from bozzetto.typed_data import convert, decode_json, decode_msgpack

    sys.setswitchinterval(1e-6)
    WAYS = (
        lambda plain, kind: convert(plain, kind),
        lambda plain, kind: decode_json(msgspec.json.encode(plain), kind),
        lambda plain, kind: decode_msgpack(msgspec.msgpack.encode(plain), kind),
    )
    right = []
    for number in range(60):
        inner = defstruct("Inner", [(f"a{i}", "dict[str, tuple[float, float]]") for i in range(12)])
        outer = defstruct("Outer", [(f"b{i}", list[inner] | None) for i in range(4)])
        value = {f"a{i}": {"x": (1.0, i)} for i in range(12)}
        plain = {f"b{i}": [value] for i in range(4)}
        start = threading.Barrier(6)

        def work(way):
            start.wait()
            right.append(way(plain, outer).b3[0].a11["x"] == (1.0, 11.0))

        threads = [threading.Thread(target=work, args=(WAYS[i % 3],)) for i in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert right == [True] * 360
""")


def test_a_type_may_be_met_first_by_several_threads():
    # In a process of its own: the fault ends the process.
    ended = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-c", RACE], capture_output=True, timeout=120
    )
    assert ended.returncode == 0, ended.stderr.decode()[-2000:]


class Point(msgspec.Struct, forbid_unknown_fields=True):
    x: float
    tags: tuple[str, ...] = ()


def test_the_three_ways_agree_and_refuse_alike():
    plain = {"x": 2, "tags": ["a"]}
    made = [
        convert(plain, Point),
        decode_json(msgspec.json.encode(plain), Point),
        decode_json(msgspec.Raw(msgspec.json.encode(plain)), Point),
        decode_msgpack(msgspec.msgpack.encode(plain), Point),
    ]
    assert made == [Point(2.0, ("a",))] * 4
    wrong = {"x": "2"}
    for refused in (
        lambda: convert(wrong, Point),
        lambda: decode_json(msgspec.json.encode(wrong), Point),
        lambda: decode_msgpack(msgspec.msgpack.encode(wrong), Point),
    ):
        with pytest.raises(msgspec.ValidationError, match="Expected `float`"):
            refused()


def decodes(tree: ast.Module) -> list[int]:
    """Lines in which msgspec itself is asked for a type."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("msgspec."):
            name = ast.unparse(node.func).rpartition(".")[2]
            typed = name == "decode" and (len(node.args) > 1 or node.keywords)
            if typed or name in ("convert", "Decoder"):
                found.append(node.lineno)
    return found


def test_types_are_decoded_in_one_place():
    folders = [Path(bozzetto.__file__).parent, ROOT / "app", ROOT / "plugins"]
    found = [
        f"{path.name}:{line}"
        for folder in folders
        for path in sorted(folder.rglob("*.py"))
        if path != Path(typed_data.__file__)
        for line in decodes(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert found == []
    assert decodes(ast.parse(Path(typed_data.__file__).read_text(encoding="utf-8")))


class Leaf(msgspec.Struct, frozen=True):
    name: str
    place: tuple[int, int] = (0, 0)


class Row(msgspec.Struct, array_like=True):
    number: Annotated[int, msgspec.Meta(ge=1)]
    leaves: list[Leaf]


class Tree(msgspec.Struct, rename={"kind": "type"}):
    kind: str
    leaves: list[Leaf]
    rows: list[Row]
    words: list[str] = []
    top: Leaf | None = None


WHOLE = Tree(
    "oak", [Leaf("a"), Leaf("b", (1, 2))], [Row(1, [Leaf("c")]), Row(2, [])], ["x"], Leaf("d")
)


def test_row_by_row_gives_what_one_call_gives(monkeypatch):
    monkeypatch.setattr(typed_data, "LONG", 0)
    text = msgspec.json.encode(WHOLE)
    for data in (text, memoryview(text), msgspec.Raw(text)):
        assert decode_in_turns(data, Tree) == WHOLE
    further = text[:-1] + b',"later":[{}]}'
    assert decode_in_turns(further, Tree) == decode_json(further, Tree) == WHOLE
    least = b'{"type":"fir","leaves":[],"rows":[]}'
    assert decode_in_turns(least, Tree) == decode_json(least, Tree)
    rows = msgspec.json.encode(WHOLE.leaves)
    assert decode_in_turns(rows, list[Leaf]) == WHOLE.leaves


@given(st.data())
def test_row_by_row_refuses_what_one_call_refuses(data):
    text = bytearray(msgspec.json.encode(WHOLE))
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(st.sampled_from(b'{}[]",:0a- '))
    content = bytes(text)
    answers = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typed_data, "LONG", 0)
        for decode in (decode_json, decode_in_turns):
            try:
                answers.append(decode(content, Tree))
            except (msgspec.MsgspecError, ValueError):
                answers.append(None)
    assert answers[0] == answers[1]
