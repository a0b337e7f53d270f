"""Check that the edges, patches and chains of a template make the shell of a car.

The shell is a disc of quadrangles: closed all round, open at the bottom, one rim. Its Euler
characteristic V - E + F is 1 then, and as every patch has four sides, 4 F = 2 E - 12 where the
rim has twelve. Kara & Shimada's templates (2008) have these counts: 35 nodes of the body, 62
edges, 28 patches; 37, 66 and 30.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_car.template.model import MIRROR, Chain, Template

RIM_EDGES: Final = 12
"""Edges around the open bottom: on either side one along the front bumper, one below the front
wing, two along the sill, one below the rear wing and one along the rear bumper."""

SMOOTH_ANGLE: Final = 1e-6
"""Largest angle between the tangents of a smooth chain at a node, radians. A file gives them
with a few decimals, and parallel tangents can be written exactly."""

NARROWEST_CORNER: Final = 5.0
"""Least angle, degrees, of the two edges at a corner of a patch, and of each to the other's
continuation. Where they run in one line the surface has no normal."""


def edge_faults(template: Template) -> Iterator[str]:
    """Yield what is wrong with single edges."""
    wheels = set(template.wheels.ravel().tolist())
    known = {frozenset(ends) for ends in template.edges.tolist()}
    if len(known) < len(template.edges):
        yield "Two edges join the same nodes."
    for number, (start, end) in enumerate(template.edges.tolist()):
        name = template.edge_names[number]
        if start == end:
            yield f"The edge {name} begins and ends in one node."
        elif wheels & {start, end}:
            yield f"The edge {name} ends in the centre of a wheel; wheels stand by themselves."
        image = int(template.mirrored[start]), int(template.mirrored[end])
        if image not in template.edge_between:
            yield f"The edge {name} has no mirror image."
        elif not _same(_tangents(template, *image), template.tangents[number] * MIRROR):
            yield f"The tangents of the edge {name} and of its mirror image differ."


def _tangents(template: Template, start: int, end: int) -> Array:
    """Return the derivatives at both ends of the edge from one node to another, (2, 3) mm."""
    edge = template.edge_between[start, end]
    return np.asarray(template.tangents[edge] if edge >= 0 else -template.tangents[~edge][::-1])


def _same(one: Array, other: Array) -> bool:
    return bool((one == other).all())


def patch_faults(template: Template) -> Iterator[str]:
    """Yield what is wrong with the patches and with the shell that they make."""
    broken = False
    for patch in template.patches:
        if len(set(patch.nodes)) < 4:
            yield f"The patch {patch.name} meets a node twice."
        ring = zip(patch.nodes, (*patch.nodes[1:], patch.nodes[0]), strict=True)
        if any(
            template.edge_between.get(ends) != edge
            for ends, edge in zip(ring, patch.edges, strict=True)
        ):
            yield f"The edges of the patch {patch.name} do not join its nodes in their order."
            broken = True
    if broken:
        return
    yield from _shell_faults(template)
    yield from _corner_faults(template)
    corners = {frozenset(patch.nodes) for patch in template.patches}
    for patch in template.patches:
        if frozenset(template.mirrored[list(patch.nodes)].tolist()) not in corners:
            yield f"The patch {patch.name} has no mirror image."


def _corner_faults(template: Template) -> Iterator[str]:
    for patch in template.patches:
        for number, node in enumerate(patch.nodes):
            ahead = _tangents(template, node, patch.nodes[(number + 1) % 4])[0]
            back = _tangents(template, node, patch.nodes[number - 1])[0]
            opening = np.degrees(_angle(ahead, back))
            if not NARROWEST_CORNER <= opening <= 180.0 - NARROWEST_CORNER:
                yield (
                    f"The edges of the patch {patch.name} at {template.names[node]} run in one "
                    f"line (they make {opening:.1f}°): the surface has no normal there."
                )


def _angle(one: Array, other: Array) -> float:
    """Return the angle of two vectors, radians; 0 where one of them is zero."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))


def _shell_faults(template: Template) -> Iterator[str]:
    uses = Counter(edge for patch in template.patches for edge in patch.edges)
    names = template.edge_names
    turned = [edge for edge, count in uses.items() if count > 1]
    for edge in turned:
        name = names[edge if edge >= 0 else ~edge]
        yield f"Two patches run through the edge {name} the same way: one is inside out."
    if turned:
        return
    sides = [(number in uses) + (~number in uses) for number in range(len(names))]
    for name in (name for name, count in zip(names, sides, strict=True) if not count):
        yield f"No patch lies at the edge {name}."
    body = {node for patch in template.patches for node in patch.nodes}
    characteristic = len(body) - len(names) + len(template.patches)
    if characteristic != 1:
        yield (
            f"The body is no open shell: nodes minus edges plus patches are {characteristic}, "
            "and should be 1."
        )
    rim = [number for number, count in enumerate(sides) if count == 1]
    rings = _rings(template, rim)
    if len(rim) != RIM_EDGES or rings != 1:
        yield (
            f"The body should be open along one rim of {RIM_EDGES} edges at the bottom; "
            f"{len(rim)} edges in {rings} rings are open."
        )
    elif _volume(template, rim) <= 0:
        yield "All patches are inside out: seen from outside their nodes run anticlockwise."


def _rings(template: Template, rim: list[int]) -> int:
    """Return the number of connected parts of the rim."""
    part = {int(node): int(node) for node in template.edges[rim].ravel()}

    def root(node: int) -> int:
        while part[node] != node:
            node = part[node]
        return node

    for start, end in template.edges[rim].tolist():
        part[root(start)] = root(end)
    return len({root(node) for node in part})


def _volume(template: Template, rim: list[int]) -> float:
    """Return six times the volume between the patches and the middle of the rim, mm³."""
    places = template.positions - template.positions[template.edges[rim]].mean(axis=(0, 1))
    a, b, c, d = (places[[patch.nodes[i] for patch in template.patches]] for i in range(4))
    triple = np.cross(a, b) * c + np.cross(a, c) * d
    return float(triple.sum())


def chain_faults(template: Template) -> Iterator[str]:
    """Yield what is wrong with the chains: gaps, kinks, and ends of edges in two chains."""
    claimed: dict[tuple[int, int], str] = {}
    sides = [{max(edge, ~edge) for edge in patch.edges} for patch in template.patches]
    for chain in template.chains:
        steps = pairwise(chain.nodes)
        if [template.edge_between.get(step) for step in steps] != list(chain.edges):
            yield f"The chain {chain.name} is not connected by edges."
            continue
        if len(set(chain.nodes)) < len(chain.nodes):
            yield f"The chain {chain.name} meets a node twice."
            continue
        for node in chain.smooth:
            if node not in chain.nodes[1:-1]:
                name = template.names[node]
                yield f"The chain {chain.name} cannot be smooth at {name}, which is not inside it."
                continue
            yield from _kinks(template, chain, node)
            around = _around(chain, node)
            for patch, its in zip(template.patches, sides, strict=True):
                if its >= set(around):
                    yield (
                        f"The chain {chain.name} cannot be smooth at {template.names[node]}, a "
                        f"corner of the patch {patch.name}: the surface would have no normal there."
                    )
            for edge in around:
                end = (edge, node)
                if end in claimed:
                    yield (
                        f"The chains {claimed[end]} and {chain.name} are both smooth along the "
                        f"edge {template.edge_names[end[0]]} at {template.names[node]}."
                    )
                claimed[end] = chain.name


def _around(chain: Chain, node: int) -> tuple[int, int]:
    """Return the edges of a chain before and after a node, without their direction."""
    at = chain.nodes.index(node)
    before, after = chain.edges[at - 1 : at + 1]
    return max(before, ~before), max(after, ~after)


def _kinks(template: Template, chain: Chain, node: int) -> Iterator[str]:
    at = chain.nodes.index(node)
    into = _tangents(template, chain.nodes[at - 1], node)[1]
    out = _tangents(template, node, chain.nodes[at + 1])[0]
    name = template.names[node]
    if not (into.any() and out.any()):
        yield f"The chain {chain.name} has no direction at {name}: a tangent is zero."
        return
    angle = _angle(into, out)
    if angle > SMOOTH_ANGLE:
        yield f"The chain {chain.name} has a kink of {np.degrees(angle):.3g}° at {name}."
    if node == template.mirrored[node] and chain.nodes[0] == template.mirrored[chain.nodes[-1]]:
        if out[0] or out[2]:
            yield f"The chain {chain.name} does not cross the middle at a right angle at {name}."
