"""Names of bones that tell animators what they are, and on which side.

Parts that a person named keep that name. Else the row of joints between junctions is the body;
where left and right hang on it alike, as far as a hand draws them alike, it is the spine, and
what rises from it is the head. Of two pairs the upper one are the arms; of more, the lowest are
the legs if they point down, and the next ones the arms: those above are ears, horns or wings.
What hangs on a limb, such as fingers, a hand or a foot of its own outline, is named as the limb.
The left is that of the character, which looks at who draws it: the side of +x.
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
    holders = _holders(chains)
    sides = _sides(chains, holders, places)
    words = _words(chains, holders, sides, places)
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


def _holders(chains: Sequence[_Chain]) -> list[int]:
    """Return the chain that each one hangs on; -1 for the roots' own."""
    chain_of = {joint: number for number, chain in enumerate(chains) for joint in chain.joints}
    found = [chain_of[chain.base] for chain in chains]
    return [-1 if holder == number else holder for number, holder in enumerate(found)]


def _sides(
    chains: Sequence[_Chain], holders: Sequence[int], places: Array
) -> dict[int, tuple[str, int]]:
    """Return the side and the partner of each chain that has one.

    What hangs on a limb is on the limb's side, with or without a partner (-1) of its own.
    """
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
    gaps[gaps > ALIKE * size] = np.inf
    # A shoe begins where its leg ends: of what ends alike, that is a pair which begins alike.
    bases = places[[chain.base for chain in chains]]
    starts = bases * [-1.0, 1.0, 1.0] + [2.0 * middle, 0.0, 0.0]
    gaps += np.linalg.norm(bases[:, None] - starts, axis=2)
    for flat in np.argsort(gaps, axis=None, kind="stable").tolist():
        one, other = divmod(flat, len(chains))
        if not np.isfinite(gaps[one, other]):
            break
        if one not in found and other not in found and tips[one, 0] > tips[other, 0]:
            found[one], found[other] = (".L", other), (".R", one)
    paired = [number in found or not beside[number] for number in np.flatnonzero(ends)]
    if not found or np.mean(paired) < SYMMETRIC:
        return {}
    for number, holder in enumerate(holders):
        if holder in found:
            found[number] = (found[holder][0], found.get(number, ("", -1))[1])
    return found


def _words(
    chains: Sequence[_Chain],
    holders: Sequence[int],
    sides: dict[int, tuple[str, int]],
    places: Array,
) -> dict[int, str]:
    """Return what each chain is."""
    words = {}
    pairs = [k for k, (side, _) in sides.items() if side == ".L" and holders[k] not in sides]
    pairs.sort(key=lambda k: tuple(-places[[chains[k].base, chains[k].joints[0]], 2]))
    limbs = 0
    for number, word in zip(pairs, _pair_words([chains[k] for k in pairs], places), strict=True):
        if not word:
            limbs += 1
            word = f"Limb {limbs}"
        words[number] = words[sides[number][1]] = word
    # What bears more than pairs of limbs, such as ears, is below the head.
    bearing = {holders[k] for k, word in words.items() if word in ("Arm", "Leg")}
    bearing |= {holders[k] for k in range(len(chains)) if k not in sides}
    for number, chain in enumerate(chains):
        if number in words:
            continue
        if holders[number] in sides:
            words[number] = words[holders[number]]
            continue
        if number == 0 or number in bearing or not (chain.ends or sides):
            words[number] = "Spine" if sides else "Body"
            continue
        rise = places[chain.joints[-1], 2] - places[chain.base, 2]
        word = ("Head" if rise > 0.0 else "Tail") if sides else ""
        if not word or word in words.values():
            limbs += 1
            word = f"Limb {limbs}"
        words[number] = word
    return words


def _pair_words(pairs: Sequence[_Chain], places: Array) -> Sequence[str]:
    """Return what pairs of limbs are, the highest first; "" for those without a word."""
    if not pairs:
        return ()
    ways = [places[pair.joints[-1]] - places[pair.base] for pair in pairs]
    stands = bool(-ways[-1][2] > abs(ways[-1][0]))
    if len(pairs) == 1:
        return ("Leg",) if stands else ("Arm",)
    if len(pairs) == 2:
        return ("Arm", "Leg")
    return ("",) * (len(pairs) - 2) + (("Arm", "Leg") if stands else ("", ""))
