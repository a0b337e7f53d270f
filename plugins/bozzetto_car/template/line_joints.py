"""Lines that are made sharp or smooth where they pass a node, other than the template has it.

A template says by its chains where lines are smooth. A person may want an edge where a line runs
on, or a line where two meet at an angle. The template with such wishes is a template like any
other: all that follows its chains follows the wishes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Final

from bozzetto.errors import UserError
from bozzetto_car.template.model import Chain, Template

KNOWN: Final = 32
"""Number of templates with wishes that are remembered."""

Line = tuple[int, int, int]
"""A node and the nodes before and after it on a line."""


@dataclass(frozen=True)
class LineJoint:
    """A line that is sharp or smooth where it passes a node, other than the template has it.

    Parameters
    ----------
    node : str
        Name of a node of the right half or the middle; the other side follows.
    before, after : str
        Names of the nodes before and after it on the line.
    smooth : bool
    """

    node: str = ""
    before: str = ""
    after: str = ""
    smooth: bool = False


def lines_at(template: Template, node: int) -> tuple[Line, ...]:
    """Return the lines that pass a node of the right half or the middle, or could: one or two.

    That along the middle is the first.
    Two edges that are sides of one patch make no line: where it is smooth, the patch has no normal.
    """
    found: dict[frozenset[int], Line] = {}
    middle = template.centre.tolist()
    if node in middle[1:-1]:
        at = middle.index(node)
        line = middle[at - 1], node, middle[at + 1]
        if all(pair in template.edge_between for pair in pairwise(line)):
            found[frozenset((line[0], line[2]))] = line
    for chain in template.chains:
        for before, at, after in zip(chain.nodes, chain.nodes[1:], chain.nodes[2:], strict=False):
            if at == node:
                found.setdefault(frozenset((before, after)), (before, at, after))
    return tuple(line for line in found.values() if not _turns_in_a_patch(template, line))


def is_smooth(template: Template, line: Line) -> bool:
    """Whether a line is smooth where it passes its node."""
    chain = _through(template.chains, line)
    return chain is not None and line[1] in chain.smooth


def next_joints(
    template: Template, joints: tuple[LineJoint, ...], node: int
) -> tuple[LineJoint, ...]:
    """Return the wishes after a touch on a node: the next of all ways in which lines pass it.

    With one line it becomes sharp or smooth; with two, one after the other changes, so that four
    touches lead back.

    Parameters
    ----------
    template : Template
        The template without wishes.
    joints : tuple of LineJoint
        The wishes so far.
    node : int
        The node that is touched, of either half.

    Raises
    ------
    UserError
        If no line passes the node.
    """
    own = _on_the_right(template, node)
    lines = lines_at(template, own)
    if not lines:
        raise UserError(
            f"{template.titles[template.names[own]]}: no line runs through it, for the edges that "
            "meet there are corners of patches. Touch another node."
        )
    wished = with_joints(template, joints)
    ways = [is_smooth(wished, line) for line in lines]
    # Gray's code: one line changes at each touch, and all ways come up.
    changed = sum(way != is_smooth(template, line) for way, line in zip(ways, lines, strict=True))
    turned = 0 if len(lines) == 1 or changed % 2 == 0 else 1
    line = lines[turned]
    names = [template.names[at] for at in line]
    others = tuple(
        one for one in joints
        if (one.node, {one.before, one.after}) != (names[1], {names[0], names[2]})
    )  # fmt: skip
    if is_smooth(template, line) != ways[turned]:
        return others  # as the template has it
    return (*others, LineJoint(names[1], names[0], names[2], not ways[turned]))


def _on_the_right(template: Template, node: int) -> int:
    return max(node, int(template.mirrored[node]), key=lambda at: template.positions[at, 1])


@lru_cache(maxsize=KNOWN)
def with_joints(template: Template, joints: tuple[LineJoint, ...]) -> Template:
    """Return a template with lines that are sharp or smooth as wished.

    Wishes for nodes that the template has not, or that make no line there, are left out.
    """
    chains = list(template.chains)
    for joint in joints:
        names = (joint.before, joint.node, joint.after)
        if not all(name in template.node for name in names):
            continue
        before, node, after = (template.node[name] for name in names)
        line = before, node, after
        if not all(pair in template.edge_between for pair in pairwise(line)):
            continue
        if joint.smooth and _turns_in_a_patch(template, line):
            continue
        image = tuple(template.mirrored[list(line)].tolist())
        for own in {line} if {*image} == {*line} else {line, image}:
            _set(template, chains, own, joint.smooth)
    return replace(template, chains=tuple(chains)) if joints else template


def _set(template: Template, chains: list[Chain], line: Line, smooth: bool) -> None:
    """Change the chain that goes along a line, or make one."""
    chain = _through(chains, line)
    if chain is None and not smooth:
        return
    if chain is None:
        chain = _joined(template, chains, line)
    kept = {*chain.smooth, line[1]} if smooth else {*chain.smooth} - {line[1]}
    new = replace(chain, smooth=tuple(node for node in chain.nodes if node in kept))
    if chain in chains:
        chains[chains.index(chain)] = new
    else:
        chains.append(new)


def _through(chains: list[Chain] | tuple[Chain, ...], line: Line) -> Chain | None:
    """Return the chain that goes along a line, in either sense; None if there is none."""
    wanted = frozenset((line[0], line[2]))
    for chain in chains:
        for before, at, after in zip(chain.nodes, chain.nodes[1:], chain.nodes[2:], strict=False):
            if at == line[1] and frozenset((before, after)) == wanted:
                return chain
    return None


def _joined(template: Template, chains: list[Chain], line: Line) -> Chain:
    """Take the chains that end where a line turns out of the list, and return them as one."""
    before, node, after = line
    first = _ending(chains, (before, node))
    last = _ending(chains, (after, node))
    head = (before, node) if first is None else _toward(first, node)
    tail = (after, node) if last is None else _toward(last, node)
    nodes = (*head, *tail[::-1][1:])
    for chain in (first, last):
        if chain is not None:
            chains.remove(chain)
    parts = [chain for chain in (first, last) if chain is not None]
    name = parts[0].name if parts else _name(template, line)
    smooth = tuple(at for chain in parts for at in chain.smooth)
    edges = tuple(template.edge_between[pair] for pair in pairwise(nodes))
    return Chain(name, nodes, edges, smooth)


def _name(template: Template, line: Line) -> str:
    """Return the name of a chain, as a file has it: one side of the car is told by a suffix."""
    names = [template.names[at] for at in line]
    side = next((name[-2:] for name in names if name.endswith((".R", ".L"))), "")
    return "_".join(["line", *(name.partition(".")[0].lower() for name in names)]) + side


def _ending(chains: list[Chain], step: tuple[int, int]) -> Chain | None:
    """Return the chain that ends with a step from one node to another."""
    for chain in chains:
        if step in (chain.nodes[-2:], chain.nodes[1::-1]):
            return chain
    return None


def _toward(chain: Chain, node: int) -> tuple[int, ...]:
    return chain.nodes if chain.nodes[-1] == node else chain.nodes[::-1]


def _turns_in_a_patch(template: Template, line: Line) -> bool:
    """Whether both edges of a line are sides of one patch."""
    own = {max(edge, ~edge) for edge in _edges(template, line)}
    return any(own <= {max(edge, ~edge) for edge in patch.edges} for patch in template.patches)


def _edges(template: Template, line: Line) -> Iterator[int]:
    yield from (template.edge_between[pair] for pair in pairwise(line))
