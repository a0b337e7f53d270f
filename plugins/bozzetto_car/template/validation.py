"""Report what is wrong with a template, in sentences for its author.

A template that passes is symmetric to the last bit, one open shell, smooth where it says so,
keeps its own rules, and can ask for every mark. `loader.read_template` takes no other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry.patches import SMOOTH, crease_angles
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import Network
from bozzetto_car.template.network_validation import chain_faults, edge_faults, patch_faults
from bozzetto_car.template.shape_constraints import Soundness

NEAREST_NODES: Final = 1.0
"""Least distance of two nodes, mm; nearer nodes could not be told apart in a sketch."""


def check(template: Template) -> list[str]:
    """Return what is wrong with a template, in sentences.

    Parameters
    ----------
    template : Template
        The template.

    Returns
    -------
    list of str
        A sentence for each fault; empty for a template that can be used. Where the nodes are
        wrong, nothing else is checked, because all else depends on them.
    """
    faults = list(_node_faults(template))
    if faults:
        return faults
    faults += edge_faults(template)
    faults += patch_faults(template)
    faults += chain_faults(template)
    faults += _rule_faults(template)
    faults += _marking_faults(template)
    return faults


def undeclared_creases(template: Template) -> list[str]:
    """Return a sentence for each edge over which the surface breaks although it is no crease.

    Parameters
    ----------
    template : Template
        A template in which `check` has found nothing.
    """
    nets = fair_nets(Network.of(template))
    angles = crease_angles(nets, template.sides, len(template.edges))
    return [
        f"The surface breaks by {angles[edge]:.2g}° over the edge {template.edge_names[edge]}, "
        "which is not declared in creases. Declare it, or let smooth chains cross it at both ends."
        for edge in np.flatnonzero(template.smooth_edges & (angles > SMOOTH)).tolist()
        if ".L" not in template.edge_names[edge]
    ]


def _node_faults(template: Template) -> Iterator[str]:
    count = Counter(template.names)
    for name in (name for name, times in count.items() if times > 1):
        yield f"Two nodes are called {name}."
    sorts = Counter([*template.centre.tolist(), *template.pairs.ravel().tolist()])
    for number, name in enumerate(template.names):
        if sorts[number] != 1:
            yield f"The node {name} should be either in the middle or in one pair."
    for number in template.centre.tolist():
        if template.positions[number, 1] != 0.0:
            yield f"The node {template.names[number]} should lie in the middle, at y = 0."
    for right, left in template.pairs.tolist():
        name = template.names[right]
        if template.positions[right, 1] <= 0.0:
            yield f"The node {name} should lie on the right side, where y is above 0."
        if (template.positions[right] * MIRROR != template.positions[left]).any():
            yield f"The node {name} and its mirror image {template.names[left]} do not match."
    pairs = set(map(tuple, template.pairs.tolist()))
    if len(template.wheels) != 2 or not set(map(tuple, template.wheels.tolist())) <= pairs:
        yield "A template needs two pairs of wheels, front and rear."
    places = template.positions
    apart = np.linalg.norm(places[:, None] - places, axis=2) + np.diag(np.full(len(places), np.inf))
    for one, other in np.argwhere(np.triu(apart < NEAREST_NODES)).tolist():
        yield f"The nodes {template.names[one]} and {template.names[other]} lie in one place."


def _rule_faults(template: Template) -> Iterator[str]:
    soundness = Soundness.of(template)
    for name, slack in soundness.least(template.variables).items():
        if slack <= 0.0:
            yield f"The template does not keep its own constraint “{name}”: {slack:.1f} mm short."


def _marking_faults(template: Template) -> Iterator[str]:
    nodes = Counter(template.asked())
    for number, name in enumerate(template.names):
        if nodes[number] != 1:
            yield f"The order of marks asks for {name} {nodes[number]} times instead of once."
        if not template.titles.get(name) or not template.prompts.get(name):
            yield f"The node {name} has no title or no prompt."
    patches = {patch.name for patch in template.patches}
    for number, name in enumerate(template.names):
        if name not in template.pictures:
            yield f"The node {name} has no picture."
            continue
        picture = template.pictures[name]
        for patch in picture.patches:
            if patch not in patches:
                yield f"The picture of {name} speaks of the patch {patch}, which there is not."
        if not faces(template, number, picture.toward_eye):
            yield f"The picture of {name} looks at the car from where it cannot be seen."


def faces(template: Template, number: int, eye: Array) -> bool:
    """Whether a patch at a node faces the eye; of a wheel, whether its side of the car does.

    Parameters
    ----------
    template : Template
        The template.
    number : int
        Index of the node.
    eye : (3,) float
        Direction from the car to the eye.
    """
    around = [patch for patch in template.patches if number in patch.nodes]
    if not around:
        return bool(eye[1] * template.positions[number, 1] > 0.0)
    for patch in around:
        a, b, c, d = template.positions[list(patch.nodes)]
        if np.cross(c - a, d - b) @ eye > 0.0:
            return True
    return False
