"""Parse the rules of a template: ``C3.x >= C2.x + 50`` becomes a row of numbers.

A rule compares two sums. A term is a number of mm, or a node and a letter of a coordinate with
or without a factor before it. A node off the plane of symmetry stands for the one on the right
side, so ``2 S3.y`` is the width there.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from bozzetto.errors import FormatError
from bozzetto_car.template.model import AXES, Rule

LARGEST_NUMBER: Final = 1e6
"""Largest factor or number of mm in a rule: a car is shorter than a kilometre."""

MOST_TERMS: Final = 20
"""Most terms on one side of a rule; a longer rule cannot be explained in a sentence."""

TERM: Final = re.compile(
    r"\s*(?P<sign>[+-]?)\s*"
    r"(?:(?P<factor>\d{1,7}(?:\.\d{1,6})?)?\s*(?P<node>[A-Z][A-Z0-9]{0,7})\.(?P<axis>[xyz])"
    r"|(?P<number>\d{1,7}(?:\.\d{1,6})?))\s*"
)


def parse_rule(name: str, text: str, nodes: Mapping[str, int]) -> Rule:
    """Parse one rule.

    Parameters
    ----------
    name : str
        Name in a designer's words.
    text : str
        Two sums with ``>=`` or ``<=`` between them.
    nodes : mapping of str to int
        Nodes of the right half and the centre, by their names without a side.

    Raises
    ------
    FormatError
        If the rule cannot be read, or names a node that does not exist.
    """
    place = f"soundness, “{name}”"
    sign = ">=" if ">=" in text else "<="
    left, found, right = text.partition(sign)
    if not found:
        raise FormatError(f"{place}: a rule needs >= or <= between two sums, not “{text}”.")
    direction = 1.0 if sign == ">=" else -1.0
    sums: dict[tuple[int, int], float] = {}
    constant = 0.0
    for side, weight in ((left, direction), (right, -direction)):
        for node, axis, number in _terms(side, place):
            if not node:
                constant += weight * number
            elif node not in nodes:
                raise FormatError(f"{place}: there is no node {node}.")
            else:
                key = nodes[node], AXES.index(axis)
                sums[key] = sums.get(key, 0.0) + weight * number
    terms = tuple((node, axis, factor) for (node, axis), factor in sums.items() if factor)
    if not terms:
        raise FormatError(f"{place}: “{text}” says nothing about any node.")
    return Rule(name, text, terms, constant)


def _terms(text: str, place: str) -> list[tuple[str, str, float]]:
    """Return the terms of one sum: node, axis and factor; the node of a plain number is ""."""
    terms: list[tuple[str, str, float]] = []
    at = 0
    while at < len(text) or not terms:
        match = TERM.match(text, at)
        if match is None or (terms and not match["sign"]):
            raise FormatError(
                f"{place}: “{text.strip()}” is not a sum of numbers and coordinates such as "
                "C2.x + 50."
            )
        value = float(match["number"] or match["factor"] or 1.0)
        if value > LARGEST_NUMBER:
            raise FormatError(f"{place}: {value:g} is too large a number.")
        value = -value if match["sign"] == "-" else value
        terms.append((match["node"] or "", match["axis"] or "", value))
        if len(terms) > MOST_TERMS:
            raise FormatError(f"{place}: a rule has at most {MOST_TERMS} terms on a side.")
        at = match.end()
    return terms
