"""What crosses between the process that reads a file and the one that asked comes whole."""

from __future__ import annotations

import pytest

from bozzetto.exchange.read_process.answers import LEVELS, PIECE, pack_answer, unpack_answer
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.stroke import Strokes
from bozzetto.view.camera import Camera


def nested(levels, leaf):
    for number in range(levels):
        leaf = {"": leaf, "beside": number} if number % 2 else [number, leaf]
    return leaf


@pytest.mark.parametrize(
    "value",
    [
        [[] for _ in range(PIECE)],
        [{} for _ in range(PIECE)],
        {f"key {number}": [number, -1.5e-7, None, True, "ü]\\"] for number in range(PIECE // 8)},
        "[" * 2 * PIECE,
        nested(3, [0.1] * PIECE),
        nested(3 * LEVELS, ["deep"] * PIECE),
        [[[1, 2.5, -3e300]] * (PIECE // 8), {"a": {"b": ["}"] * PIECE}}, "x" * PIECE, 2**53, False],
    ],
    ids=["lists", "objects", "members", "text", "numbers", "levels", "mixed"],
)
def test_large_facts_come_as_they_were(value):
    facts = {"small": 1, "large": value}
    drawing = Drawing(Strokes(), Camera(), "one", facts)
    assert unpack_answer(*pack_answer(drawing)).facts == facts
