"""Rules in words."""

from __future__ import annotations

import pytest

from bozzetto.errors import FormatError
from bozzetto_car.template.rules import parse_rule

NODES = {"C2": 0, "C3": 1, "S1": 2}
X, Y, Z = range(3)


@pytest.mark.parametrize(
    ("text", "terms", "constant"),
    [
        ("C3.x >= C2.x + 50", {(1, X): 1.0, (0, X): -1.0}, -50.0),
        ("C3.x<=C2.x-50", {(1, X): -1.0, (0, X): 1.0}, -50.0),
        ("2 S1.y >= 1500", {(2, Y): 2.0}, -1500.0),
        ("C3.x - C2.x <= 0.8 S1.z", {(1, X): -1.0, (0, X): 1.0, (2, Z): 0.8}, 0.0),
        ("-S1.z + 3 >= -7.25", {(2, Z): -1.0}, 10.25),
        ("S1.y + S1.y >= S1.y", {(2, Y): 1.0}, 0.0),
        ("2S1.y >= 0", {(2, Y): 2.0}, 0.0),
    ],
)
def test_rules_become_rows(text: str, terms: dict[tuple[int, int], float], constant: float) -> None:
    rule = parse_rule("So it is", text, NODES)
    assert {(node, axis): factor for node, axis, factor in rule.terms} == terms
    assert rule.constant == constant
    assert (rule.name, rule.text) == ("So it is", text)


@pytest.mark.parametrize(
    "text",
    [
        "C3.x > C2.x",
        "C3.x = C2.x",
        "C3.x >=",
        ">= C2.x",
        "C3.x >= C2.x >= 0",
        "C3.x >= C2.w",
        "C3.x >= C2",
        "C3.x >= C2.x 50",
        "C3.x >= C2.x + + 50",
        "C3.x >= C2.x * S1.x",
        "C3.x >= 1e9",
        "C3.x >= 9999999",
        "C3.x >= nan",
        "C3.x >= __import__('os')",
        "C9.x >= 0",
        "5 >= 4",
        "C3.x >= C3.x",
        " + ".join(["C3.x"] * 30) + " >= 0",
        "0 C3.x >= 5",
        "",
    ],
)
def test_what_is_no_rule_is_refused_by_its_name(text: str) -> None:
    with pytest.raises(FormatError, match="soundness, “So it is”"):
        parse_rule("So it is", text, NODES)
