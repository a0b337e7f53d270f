"""Names of bones that tell animators what they are, and on which side.

Parts that a person named keep that name. Else the row of joints between junctions is the body;
where left and right hang on it alike, as far as a hand draws them alike, it is the spine, what
rises from it is the head, and of two pairs the upper one are the arms. The left is that of the
character, which looks at who draws it: the side of +x.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array

DEFAULT = re.compile(r"(Part \d+)?")
"""Names that nobody chose."""

LONGEST = 40
"""Letters of a name that are kept: other programs cut names of more than 63 bytes."""

ALIKE = 0.1
"""How far the ends of limbs may be from mirroring each other, as a share of the rig's size."""

ASIDE = 0.03
"""How far beside the plane of symmetry the end of a limb is that has a side, likewise."""

SYMMETRIC = 0.6
"""Share of the limbs that must have a partner, or lie in the plane, for a rig with two sides."""


@dataclass(frozen=True)
class _Chain:
    """Joints in a row, from where they leave others to a junction or an end.

    Attributes
    ----------
    joints : tuple of int
    base : int
        Joint that they hang on; the first of them at a root.
    ends : bool
        Whether nothing hangs on the last of them.
    """

    joints: tuple[int, ...]
    base: int
    ends: bool


def bone_names(places: Array, parents: Sequence[int], parts: Sequence[str]) -> tuple[str, ...]:
    """Return a name for each joint, all different; sides end in .L and .R.

    Parameters
    ----------
    places : (n, 3) float array
        Joints at rest; x to the viewer's right, z up.
    parents : sequence of int
        Index of each joint's parent, which stands before it; -1 for roots.
    parts : sequence of str
        Name of the part that each joint is in.
    """
    chains = _chains(parents, parts)
    sides = _sides(chains, places)
    words = _words(chains, sides, places)
    names = [""] * len(parents)
    taken: set[str] = set()
    counts: dict[str, int] = {}
    for number, chain in enumerate(chains):
        own = parts[chain.joints[0]]
        stem = words[number] if DEFAULT.fullmatch(own) else _clean(own)
        side = sides.get(number, ("", -1))[0]
        for joint in chain.joints:
            while True:
                count = counts[stem + side] = counts.get(stem + side, 0) + 1
                name = stem + (f"-{count}" if count > 1 else "") + side
                if name not in taken:
                    break
            taken.add(name)
            names[joint] = name
    return tuple(names)


def _clean(name: str) -> str:
    """Return a name without dots, which other programs read as sides and numbers."""
    return name.replace(".", " ").strip()[:LONGEST] or "Bone"


def _chains(parents: Sequence[int], parts: Sequence[str]) -> list[_Chain]:
    """Part the joints into rows, in the order of their first joints."""
    children: list[list[int]] = [[] for _ in parents]
    for joint, parent in enumerate(parents):
        if parent >= 0:
            children[parent].append(joint)
    chains: list[_Chain] = []
    for joint, parent in enumerate(parents):
        goes_on = parent >= 0 and len(children[parent]) == 1 and parts[parent] == parts[joint]
        if goes_on and parents[parent] >= 0:
            continue
        row = [joint]
        while parent >= 0 or not chains:
            following = children[row[-1]]
            if len(following) != 1 or parts[following[0]] != parts[joint] or parent < 0:
                break
            row.append(following[0])
        chains.append(_Chain(tuple(row), max(parent, 0), not children[row[-1]]))
    return chains


def _sides(chains: Sequence[_Chain], places: Array) -> dict[int, tuple[str, int]]:
    """Return the side and the partner of each chain that has one."""
    size = float(np.ptp(places, axis=0).max())
    middle = places[chains[0].joints[0], 0]
    tips = np.array([places[chain.joints[-1]] for chain in chains])
    mirrored = tips * [-1.0, 1.0, 1.0] + [2.0 * middle, 0.0, 0.0]
    gaps = np.linalg.norm(tips[:, None] - mirrored, axis=2)
    beside = np.abs(tips[:, 0] - middle) > ASIDE * size
    ends = np.array([chain.ends for chain in chains])
    gaps[~beside] = gaps[:, ~beside] = np.inf
    gaps[ends[:, None] != ends] = np.inf
    found: dict[int, tuple[str, int]] = {}
    for flat in np.argsort(gaps, axis=None, kind="stable").tolist():
        one, other = divmod(flat, len(chains))
        if not gaps[one, other] <= ALIKE * size:
            break
        if one not in found and other not in found and tips[one, 0] > tips[other, 0]:
            found[one], found[other] = (".L", other), (".R", one)
    paired = [number in found or not beside[number] for number in np.flatnonzero(ends)]
    return found if found and np.mean(paired) >= SYMMETRIC else {}


def _words(
    chains: Sequence[_Chain], sides: dict[int, tuple[str, int]], places: Array
) -> dict[int, str]:
    """Return what each chain is."""
    words = {}
    pairs = [k for k, (side, _) in sides.items() if side == ".L" and chains[k].ends]
    pairs.sort(key=lambda k: -float(places[chains[k].base, 2]))
    limbs = 0
    known = {2: ("Arm", "Leg")}.get(len(pairs), ())
    for rank, number in enumerate(pairs):
        word = known[rank] if known else "Limb"
        if len(pairs) == 1:
            along = places[chains[number].joints[-1]] - places[chains[number].base]
            word = "Leg" if -along[2] > abs(along[0]) else "Arm"
        elif not known:
            limbs += 1
            word = f"Limb {limbs}"
        words[number] = words[sides[number][1]] = word
    for number, chain in enumerate(chains):
        if number in words:
            continue
        if not chain.ends or number == 0:
            words[number] = "Spine" if sides else "Body"
            continue
        rise = places[chain.joints[-1], 2] - places[chain.base, 2]
        word = ("Head" if rise > 0.0 else "Tail") if sides else ""
        if not word or word in words.values():
            limbs += 1
            word = f"Limb {limbs}"
        words[number] = word
    return words
