"""Fair lines through nodes that have moved: the character of the template, without wiggles.

Tangents of the template, in mm, on nodes that have moved bend most edges twice. Here an edge turns
relative to its chord as it does in the template: its tangents are turned and stretched with the
chord. Chains are then annealed (`chain_smoothing.anneal`): a part of the bending that they have so
is kept, for it is the character of the template, and the rest, where there is more than the least,
goes. An edge that still bends to both sides
lies where a row of nodes zigzags, which is the tremor of marks; what it turns to both sides is
taken from it, and its neighbours turn with it. That is continuous in the places of the nodes: an
edge that has just come to bend twice hardly changes, so that no line leaps while a mark is dragged.
Where the template's line is level at its highest node, such as that of the roof, it stays so, and
rises no higher beside it. Last, corners of patches in which two edges have come to run in one line
are opened, for the surface would have no normal there.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto_car.body.chain_smoothing import anneal
from bozzetto_car.template.crease_sides import one_sided
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import EdgeJunction, Network, junctions, with_tangents

STRAIGHT: Final = 1e-9
"""Product of the turns (sines) at both ends below which an edge does not count as bent twice."""

CHARACTER: Final = 0.4
"""Share of the template's bending that annealing does not count as bending. Of 0, 0.25, 0.4, 0.5,
0.6 and 0.75 the one with the fewest saddles in 40 solved cars (14.1 % of the area; 15.9 with 0 and
14.6 with 0.75); curvature varies least with it, too."""

WIDEST: Final = 170.0
"""Largest angle of two edges at a corner of a patch, degrees: with a margin to what a template may
have (`network_validation.NARROWEST_CORNER`)."""

KNOWN: Final = 16
"""Number of templates whose crests are remembered."""

LEVEL: Final = 0.01
"""Sine of the slope up to which a line of a template counts as level."""

STEEPEST: Final = 2.5
"""Greatest rise of the tangent at the foot of an edge to a crest, relative to the rise of the edge.
From 3 on the edge would pass above the crest (Fritsch & Carlson, *Monotone piecewise cubic
interpolation*, 1980); the rest is room for tangents that the lock of ratios makes longer."""

ROUNDS: Final = 40
"""Most rounds of straightening: an edge that is straightened may bend its neighbour twice. Three to
eight are usual."""

PASSES: Final = 4
"""Most times that creases are put on one side: an edge that is straightened may lie beside another
crease. Two are usual."""

SUNK: Final = 80.0
"""How far below a neighbour the highest node of a line counts as its crest in part, mm."""

BEYOND: Final = 1.5
"""What is taken from an edge that bends twice, relative to what would just do. Where two such edges
share a joint, neither gets all that it wants, and with 1 they would come to it in ever shorter
steps."""


def fair_network(template: Template, positions: ArrayLike) -> Network:
    """Return fair edges through nodes that have moved.

    Parameters
    ----------
    template : Template
        The template of the car.
    positions : (n, 3) array_like
        Places of the nodes, mm.
    """
    turned = turned_with_chords(template, positions)
    lines = crested(straightened(anneal(turned, character=CHARACTER)))
    return opened(with_creases_of_one_side(lines))


def with_creases_of_one_side(network: Network) -> Network:
    """Return a network whose creases are on one side all along, without more edges that bend twice.

    Crests stay level; where an edge would bend twice or rise over a crest, a crease may turn.

    Parameters
    ----------
    network : Network
        A network whose chains have one direction at each junction.
    """
    made = network
    for _ in range(PASSES):
        sided = one_sided(made)
        turned = np.argwhere((sided.tangents != made.tangents).any(axis=2)).tolist()
        if not turned:
            break
        made = straightened(sided, {(edge, end) for edge, end in turned})
    return made if made is network else crested(straightened(made))


def opened(network: Network, widest: float = WIDEST, most: float = 360.0) -> Network:
    """Return a network without corners of patches that are wider than an angle; nodes stay.

    The tangents of both edges turn to the inside of the patch, by half of what is too much, or one
    of them by all of it where the other is smooth over the corner and so belongs to a chain. An
    edge between two such corners takes the sum of both turns, so that lines stay continuous.

    Parameters
    ----------
    network : Network
        The network to change. A corner of which both edges run on smoothly stays.
    widest : float
        Largest angle, degrees.
    most : float
        Angle from which a corner stays: the patch is bent in there, and has a normal.
    """
    corners = _patch_corners(network.template)
    places = network.positions[corners.nodes]
    normals = cross_product(places[:, 2] - places[:, 0], places[:, 3] - places[:, 1])
    ways = corners.leaving * network.tangents[corners.ends[..., 0], corners.ends[..., 1]]
    openings = inside_angle(ways[:, 0], ways[:, 1], np.repeat(normals, 4, axis=0))
    moves: dict[tuple[int, int], Array] = {}
    for at in np.flatnonzero((widest < openings) & (openings < most)).tolist():
        patch, number = divmod(at, 4)
        free = np.flatnonzero(corners.free[at]).tolist()
        if not free:
            continue
        inside = places[patch, (number + 2) % 4] - places[patch, number]
        turn = np.radians(openings[at] - widest) / len(free)
        for k in free:
            edge, end = corners.ends[at, k].tolist()
            move = _turned(ways[at, k], inside, turn) - ways[at, k]
            moves[edge, end] = moves.get((edge, end), 0.0) + (move if end == 0 else -move)
    sizes = {end: np.linalg.norm(network.tangents[end]) for end in moves}
    turned = {end: sizes[end] * _units(network.tangents[end] + by) for end, by in moves.items()}
    return with_tangents(network, turned)


@dataclass(frozen=True, eq=False)
class _PatchCorners:
    """The corners of the patches of the right half and the middle, four a patch.

    Attributes
    ----------
    nodes : (p, 4) int
        Of each patch.
    ends : (4 p, 2, 2) int
        Of each corner: edge, and which end of it, of the edge after it and of the one before.
    leaving : (4 p, 2, 1) float
        1 where such a tangent leaves the node, -1 where it leads to it.
    free : (4 p, 2) bool
        Ends that belong to no chain.
    """

    nodes: Index
    ends: Index
    leaving: Array
    free: Flags


@lru_cache(maxsize=KNOWN)
def _patch_corners(template: Template) -> _PatchCorners:
    held = {end for joint in junctions(template) for end in (joint.before, joint.after)}
    patches = [patch for patch in template.patches if not patch.name.endswith(".L")]
    # The edge after a corner leaves it, the one before leads to it.
    ends = [
        (_end_at(patch.edges[number]), _end_at(~patch.edges[number - 1]))
        for patch in patches
        for number in range(4)
    ]
    places = np.array(ends, np.intp)
    return _PatchCorners(
        np.array([patch.nodes for patch in patches], np.intp),
        places,
        np.where(places[..., 1:] == 0, 1.0, -1.0),
        np.array([[end not in held for end in pair] for pair in ends]),
    )


def _end_at(edge: int) -> tuple[int, int]:
    """Return the edge and which of its ends it leaves when it is run through in its sense."""
    return (edge, 0) if edge >= 0 else (~edge, 1)


def inside_angle(ahead: Array, back: Array, normal: Array) -> Array:
    """Return the angles inside corners of patches seen along their normals, 0 to 360 degrees.

    Above 180 degrees a patch is bent in there.

    Parameters
    ----------
    ahead, back : (..., 3) float
        Tangents of the next and of the previous edge as they leave the corner; the patch runs
        anticlockwise seen from outside.
    normal : (..., 3) float
        Normals of the patches, outward.

    Returns
    -------
    (...) float
    """
    squares = (normal**2).sum(axis=-1, keepdims=True)
    ahead, back = (
        way * squares - (way * normal).sum(axis=-1, keepdims=True) * normal for way in (ahead, back)
    )
    size = np.maximum(np.sqrt(squares[..., 0]), np.finfo(float).tiny)
    sine = (cross_product(ahead, back) * normal).sum(axis=-1) / size
    return np.asarray(np.degrees(np.arctan2(sine, (ahead * back).sum(axis=-1))) % 360.0)


def _turned(way: Array, toward: Array, angle: float) -> Array:
    """Return a vector turned toward another one by an angle, radians."""
    length = float(np.linalg.norm(way))
    ahead = way / length
    aside = toward - (toward @ ahead) * ahead
    size = float(np.linalg.norm(aside))
    return way if size == 0.0 else length * (np.cos(angle) * ahead + np.sin(angle) * aside / size)


def turned_with_chords(template: Template, positions: ArrayLike) -> Network:
    """Return edges whose tangents keep their angle to the chord, and their length relative to it.

    Parameters
    ----------
    template : Template
        The template, whose edges they are.
    positions : (n, 3) array_like
        Places of the nodes, mm. An edge without a length keeps its tangents.
    """
    places = np.asarray(positions, float)
    old, new = (
        nodes[template.edges[:, 1]] - nodes[template.edges[:, 0]]
        for nodes in (template.positions, places)
    )
    sizes = np.linalg.norm(old, axis=1), np.linalg.norm(new, axis=1)
    there = (sizes[0] > 0.0) & (sizes[1] > 0.0)
    a, b = old[there] / sizes[0][there, None], new[there] / sizes[1][there, None]
    tangents = np.array(template.tangents)
    stretched = tangents[there] * (sizes[1] / np.where(there, sizes[0], 1.0))[there, None, None]
    # The least turn from a to b is a reflection in the plane across a, then across a + b.
    middle = a + b
    length = np.linalg.norm(middle, axis=1, keepdims=True)
    middle /= np.where(length > 0.0, length, 1.0)
    for mirror in (a, middle):
        along = (stretched * mirror[:, None]).sum(axis=2, keepdims=True)
        stretched = stretched - 2.0 * along * mirror[:, None]
    tangents[there] = stretched
    ends = {(edge, end): tangents[edge, end] for edge in range(len(tangents)) for end in (0, 1)}
    return with_tangents(Network(template, places, template.tangents), ends)


def double_bends(network: Network) -> Array:
    """Return the product of the turns at both ends of each edge; above 0 it bends twice, (m,).

    Turns are sines of the angles of tangent and chord, with the sense that they turn in.
    """
    ends, tangents = network.ends, network.tangents
    chord = ends[:, 1] - ends[:, 0]
    turns = cross_product(chord[:, None], tangents)
    sizes = np.linalg.norm(chord, axis=1) ** 2 * np.linalg.norm(tangents, axis=2).prod(axis=1)
    return np.asarray((turns[:, 0] * turns[:, 1]).sum(axis=1) / np.where(sizes > 0.0, sizes, 1.0))


def straightened(network: Network, held: Collection[tuple[int, int]] = ()) -> Network:
    """Return a network without edges that bend twice; lengths of tangents stay.

    The turns u and v at the ends of an edge, vectors across its chord, have a common part
    a = (u + v) / 2 and a rest b = (u - v) / 2, and u · v = a² - b². Where that is positive a is
    made shorter than b, so that u · v is not; an edge that turns equally at both ends is straight.
    At u · v = 0 nothing changes, so that the lines are continuous in the nodes. Where one end is
    held, what the other one has of its turn goes; that is not continuous where the held turn is 0.

    Joints of chains keep one direction, so a neighbour in a chain turns with it. Where a chain
    crosses the middle it does so at a right angle, as before.

    Parameters
    ----------
    network : Network
        A network whose chains have one direction at each junction.
    held : collection of (edge, end)
        Tangents that stay.
    """
    joints = joined(network.template)
    at_joint, senses = joints.at, joints.senses
    stays = joints.crosses.copy()
    for end in held:
        stays[at_joint == at_joint[end]] = True
    chords = network.ends[:, 1] - network.ends[:, 0]
    lengths = np.linalg.norm(network.tangents, axis=2, keepdims=True)
    ways, begun = _units(chords), _units(network.tangents)
    now = begun
    for _ in range(ROUNDS):
        turns = cross_product(ways[:, None], now)
        bad = np.flatnonzero((turns[:, 0] * turns[:, 1]).sum(axis=1) > STRAIGHT)
        if not len(bad):
            break
        still, way = stays[bad, :, None], ways[bad, None]
        turned = _bent_once(turns[bad], still)
        ahead = np.sqrt(np.maximum(1.0 - (turned**2).sum(axis=2, keepdims=True), 0.0))
        wanted = ahead * way + cross_product(turned, way)
        change = np.where(still, 0.0, senses[bad] * (wanted - now[bad]))
        sums = np.zeros((at_joint.size, 3))
        np.add.at(sums, at_joint[bad].ravel(), change.reshape(-1, 3))
        moved = sums[at_joint]
        now = np.where((moved != 0.0).any(axis=2, keepdims=True), _units(now + senses * moved), now)
    changed = np.argwhere((now != begun).any(axis=2)).tolist()
    ends = {(edge, end): lengths[edge, end] * now[edge, end] for edge, end in changed}
    return with_tangents(network, ends) if ends else network


def _bent_once(turns: Array, still: Flags) -> Array:
    """Return the turns (k, 2, 3) of edges that bend twice without what they turn to both sides.

    The ends that stay, (k, 2, 1), have their turns from then on, too.
    """
    first, last = turns[:, 0], turns[:, 1]
    common, rest = 0.5 * (first + last), 0.5 * (first - last)
    sizes = [np.linalg.norm(part, axis=1, keepdims=True) for part in (common, rest)]
    common = common * np.maximum(1.0 - BEYOND * (1.0 - sizes[1] / sizes[0]), 0.0)
    free = np.stack((common + rest, common - rest), axis=1)
    others = turns[:, ::-1]
    product = (first * last).sum(axis=1)[:, None, None]
    squares = np.maximum((others**2).sum(axis=2, keepdims=True), np.finfo(float).tiny)
    beside_held = turns - BEYOND * product / squares * others
    return np.where(still.any(axis=1, keepdims=True), np.where(still, turns, beside_held), free)


def _units(ways: Array) -> Array:
    """Return vectors (…, 3) with length 1; 0 where they have none."""
    sizes = np.linalg.norm(ways, axis=-1, keepdims=True)
    return np.asarray(ways / np.where(sizes > 0.0, sizes, 1.0))


@dataclass(frozen=True)
class Joined:
    """Which ends of edges keep one direction.

    Attributes
    ----------
    at : (m, 2) int
        A number that both ends at a smooth joint have, and no others.
    senses : (m, 2, 1) float
        1 where an edge runs along with its chain, -1 where it runs against it.
    crosses : (m, 2) bool
        Ends at which a chain crosses the middle.
    """

    at: Index
    senses: Array
    crosses: Flags


@lru_cache(maxsize=KNOWN)
def joined(template: Template) -> Joined:
    """Return which ends of edges keep one direction at the smooth joints of a template."""
    count = len(template.edges)
    at, senses = np.arange(2 * count).reshape(count, 2), np.ones((count, 2, 1))
    crosses = np.zeros((count, 2), bool)
    for joint in junctions(template):
        if joint.crosses:
            crosses[joint.before] = crosses[joint.after] = True
            continue
        at[joint.after] = at[joint.before]
        senses[joint.before], senses[joint.after] = joint.senses
    return Joined(at, senses, crosses)


@lru_cache(maxsize=KNOWN)
def crests(template: Template) -> tuple[EdgeJunction, ...]:
    """Return the joints at which a line of a template is level, and above both neighbours."""
    heights = template.positions[:, 2]
    slopes = np.abs(template.tangents[..., 2])
    lengths = np.linalg.norm(template.tangents, axis=2)
    return tuple(
        joint
        for joint in junctions(template)
        if not joint.crosses
        and heights[joint.node] > heights[list(joint.neighbours)].max()
        and all(slopes[end] <= LEVEL * lengths[end] for end in (joint.before, joint.after))
    )


def crested(network: Network) -> Network:
    """Return a network whose lines are level and highest where those of the template are.

    Tangents turn up or down and keep their lengths: at the crest until they are level, at the far
    ends of both edges until these rise to the crest, neither over it nor with a bend to both sides.
    An edge beyond that bends twice then is straightened at its other end. A node that has moved
    below one of its neighbours is a crest in part, and by `SUNK` none any more: its line stays
    then. So no line leaps while the node is dragged down.

    Parameters
    ----------
    network : Network
        A network whose chains have one direction at each junction.
    """
    at = {
        end: joint for joint in junctions(network.template) for end in (joint.before, joint.after)
    }
    held: set[tuple[int, int]] = set()
    turned = False
    for joint in crests(network.template):
        heights = network.positions[[joint.node, *joint.neighbours], 2]
        share = min(1.0 + float(heights[0] - heights[1:].max()) / SUNK, 1.0)
        if share <= 0.0:
            continue
        for end, foot in zip((joint.before, joint.after), joint.neighbours, strict=True):
            changed = {end: _sloped(network.tangents[end], 0.0)}
            far = (end[0], 1 - end[1])
            together = {far: 1}
            if far in at:
                twin = at[far]
                together = dict(zip((twin.before, twin.after), twin.senses, strict=True))
            # Up the edge, whichever way it and its chain run.
            up = 1 if far[1] == 0 else -1
            own, way = up * network.tangents[far], network.positions[joint.node]
            wanted = _up_to_crest(own, way - network.positions[foot], up * changed[end])
            for other, sense in together.items():
                length = float(np.linalg.norm(network.tangents[other]))
                changed[other] = up * together[far] * sense * length * wanted
            if share < 1.0:
                changed = {
                    own: _turned_in_part(network.tangents[own], to, share)
                    for own, to in changed.items()
                }
            network = with_tangents(network, changed)
            turned = True
            if share == 1.0:
                held |= {end, *together}
    return straightened(network, held) if turned else network


def _turned_in_part(own: Array, to: Array, share: float) -> Array:
    """Return a vector as long as another of the same length, turned to it by a share of the way."""
    way = (1.0 - share) * own + share * to
    length = float(np.linalg.norm(way))
    return np.asarray(way * (float(np.linalg.norm(own)) / length)) if length > 0.0 else own


def _up_to_crest(own: Array, way: Array, level: Array) -> Array:
    """Return the unit vector at the foot of an edge with which it rises to its crest, no higher.

    Parameters
    ----------
    own : (3,) float
        The tangent that it has there, up the edge.
    way : (3,) float
        The chord, up the edge.
    level : (3,) float
        The tangent at the crest.
    """
    length, chord = float(np.linalg.norm(own)), way / np.linalg.norm(way)
    highest = STEEPEST * float(way[2])
    rise = min(max(float(own[2]), length * float(chord[2])), highest)
    made = own if rise == own[2] else _sloped(own, rise)
    bent_twice = cross_product(chord, made) @ cross_product(chord, level) > 0.0
    return np.asarray(chord if bent_twice else made / length)


def _sloped(way: Array, rise: float) -> Array:
    """Return a vector of the same length and bearing that rises by another height."""
    flat = float(np.hypot(way[0], way[1]))
    length = float(np.linalg.norm(way))
    if flat == 0.0 or abs(rise) >= length:
        return way
    scale = np.sqrt(length**2 - rise**2) / flat
    return np.array([scale * way[0], scale * way[1], rise])
