"""Write a car as a template of its own.

The new template has the nodes and tangents of the car, and everything else from the template that
the car came from: names, prompts, patches, chains, creases. Edges over which the car's surface
breaks otherwise, because it was not kept smooth, become creases, too. A solve leads a car up to its
rules, and a template keeps its own with room to spare, so rules that the car has used up are eased.
A node that has turned away from where it was seen best gets the nearest direction from which it is
seen.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.patches import SMOOTH, crease_angles
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import read_template
from bozzetto_car.template.model import AXES, Rule, Template, ViewHint
from bozzetto_car.template.network import Network
from bozzetto_car.template.validation import faces

ROOM: Final = 20.0
"""Least slack of a rule in a new template, mm: some pixels of a sketch."""

TURNS: Final = (0, 15, -15, 30, -30, 45, -45, 60, -60, 75, -75, 90, -90)
"""Turns by which another direction to see a node from is looked for, degrees."""

DECIMALS: Final = 6
"""Decimals of the numbers of a rule."""

MOST_TOLD: Final = 2
"""Number of faults that a refusal names."""


def template_file(
    source: str,
    network: Network,
    name: str,
    without: Collection[str] = (),
    remedy: str = "Move its nodes apart.",
) -> bytes:
    """Return the file of a template that is a given car.

    Parameters
    ----------
    source : str
        File of the template that the car came from.
    network : Network
        The car, symmetric.
    name : str
        Title of the new template. Its id is made of it.
    without : collection of str
        Names of the soundness rules that were switched off for this car: it has them no more.
    remedy : str
        What to do, in a sentence, where no template can be like this car.

    Returns
    -------
    bytes
        JSON (``bozzetto-car-template/1``), which `read_template` accepts.

    Raises
    ------
    UserError
        If no template can be like this car, such as one with a patch that folds.
    """
    told: dict[str, Any] = json.loads(source)
    title = " ".join(name.split())[:200] or "Own car"
    template = network.template
    was, told["title"], told["id"] = told["title"], title, _label(title)
    told["about"] = f"A car that was shaped from the template {was}."[:200]
    right = {full[:-2] if full.endswith(".R") else full: number
             for number, full in enumerate(template.names) if not full.endswith(".L")}  # fmt: skip
    placed = replace(template, positions=network.positions, tangents=network.tangents)
    for section in ("centre", "pairs", "wheels"):
        for node, record in told[section].items():
            number = right[node]
            record["at"] = network.positions[number].tolist()
            record["picture"] |= _seen(placed, number)
    told["edges"] = {key: _tangents(network, key, right) for key in told["edges"]}
    if template.chains != read_template(source.encode()).chains:
        told["chains"] = _chains(template)
    if "creases" in told:
        told["creases"] += _broken(network, told["edges"], right)
    kept = (rule for rule in template.rules if rule.name not in without)
    told["soundness"] = {rule.name: _eased(rule, network.positions, right) for rule in kept}
    written = (json.dumps(told, indent=1, ensure_ascii=False) + "\n").encode()
    _refuse_unsound(written, remedy)
    return written


def _refuse_unsound(written: bytes, remedy: str) -> None:
    try:
        read_template(written)
    except UserError as problem:
        words = problem.message.partition("cannot be used. ")[2] or problem.message
        told = " ".join(re.split(r"(?<=\.) (?=[A-Z])", words)[:MOST_TOLD])
        raise UserError(f"This car cannot become a template: {told} {remedy}") from problem


def _label(title: str) -> str:
    """Return an id: a word in lower case."""
    words = re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")
    return (words if words[:1].isalpha() else f"car_{words}".rstrip("_"))[:40]


def _tangents(network: Network, key: str, right: dict[str, int]) -> list[list[float]]:
    """Return the tangents of an edge that a file calls by its ends."""
    start, end = (right[node] for node in key.split("-"))
    edge = network.template.edge_between[start, end]
    own = network.tangents[edge] if edge >= 0 else -network.tangents[~edge][::-1]
    rows: list[list[float]] = own.tolist()
    return rows


def _chains(template: Template) -> dict[str, Any]:
    """Return the chains as a file has them: the right half, and only where one is smooth."""
    found = {}
    left = set(template.pairs[:, 1].tolist())
    names = [name.removesuffix(".R") for name in template.names]
    for chain in template.chains:
        if left.issuperset(chain.nodes) or chain.name.endswith(".L") or not chain.smooth:
            continue
        nodes = chain.nodes
        if nodes[0] == template.mirrored[nodes[-1]] and nodes[0] != nodes[-1]:
            half = nodes[len(nodes) // 2 :]
            nodes = half if half[-1] not in left else nodes[len(nodes) // 2 :: -1]
        found[chain.name.removesuffix(".R")] = {
            "nodes": [names[node] for node in nodes],
            "smooth": [names[node] for node in nodes if node in chain.smooth],
        }
    return found


def _broken(network: Network, keys: Collection[str], right: dict[str, int]) -> list[str]:
    """Return the edges over which the surface of a car breaks although they were no creases."""
    template = network.template
    angles = crease_angles(fair_nets(network), template.sides, len(template.edges))
    broken = template.smooth_edges & (angles > SMOOTH)

    def edge(key: str) -> int:
        start, end = (right[node] for node in key.split("-"))
        signed = template.edge_between[start, end]
        return max(signed, ~signed)

    return [key for key in keys if broken[edge(key)]]


def _seen(template: Template, number: int) -> dict[str, float]:
    """Return azimuth and elevation from which a node is seen, the nearest to those it has."""
    hint = template.pictures[template.names[number]]
    for turn in TURNS:
        azimuth = (hint.azimuth + turn + 180.0) % 360.0 - 180.0
        if faces(template, number, ViewHint(azimuth, hint.elevation).toward_eye):
            return {"azimuth": azimuth, "elevation": hint.elevation}
    return {"azimuth": hint.azimuth, "elevation": hint.elevation}


def _eased(rule: Rule, positions: Array, right: dict[str, int]) -> str:
    """Return a rule as it stands, or one that leaves the car `ROOM`."""
    slack = rule.constant + sum(
        factor * float(positions[node, axis]) for node, axis, factor in rule.terms
    )
    if slack >= ROOM:
        return rule.text
    names = {number: node for node, number in right.items()}
    # Up to the next millimetre, so that a file that is read and written again is the same.
    constant = rule.constant + np.ceil(ROOM - slack)
    left: list[str] = []
    other: list[str] = []
    for node, axis, factor in rule.terms:
        sum_ = left if factor > 0.0 else other
        sum_.append(f"{_number(abs(factor))} {names[node]}.{AXES[axis]}".removeprefix("1 "))
    (left if constant > 0.0 else other).append(_number(abs(constant)))
    return f"{' + '.join(left) or '0'} >= {' + '.join(other) or '0'}"


def _number(value: float) -> str:
    return f"{value:.{DECIMALS}f}".rstrip("0").rstrip(".")
