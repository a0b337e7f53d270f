"""Faces of a graph that can be drawn in the plane without crossings.

The algorithm of Demoucron, Malgrange and Pertuiset (1964): a cycle is drawn first, then one path of
what is missing after the other, each into a face that has all the corners at which its piece hangs.
Where a graph is 3-connected, its faces are unique (Whitney 1932).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from itertools import pairwise

Ring = tuple[int, ...]
"""Numbers of corners, once round."""

Neighbors = dict[int, set[int]]


def neighbors_of(lines: Iterable[Sequence[int]]) -> Neighbors:
    """Return the neighbours of each corner that has lines."""
    found: Neighbors = {}
    for first, second in lines:
        found.setdefault(int(first), set()).add(int(second))
        found.setdefault(int(second), set()).add(int(first))
    return found


def components(neighbors: Neighbors) -> list[tuple[int, ...]]:
    """Return the connected parts of a graph, each with its corners in order."""
    seen: set[int] = set()
    found = []
    for start in sorted(neighbors):
        if start not in seen:
            part = _reached(neighbors, start, seen)
            found.append(tuple(sorted(part)))
    return found


def embedded_faces(neighbors: Neighbors) -> tuple[Ring, ...] | None:
    """Return the faces of a planar embedding of a 2-connected graph.

    Returns
    -------
    tuple of Ring or None
        Rings that run through each line twice, once in either direction. None if the graph is not
        planar, or falls apart where one corner is taken away.
    """
    cycle = _cycle(neighbors)
    if cycle is None:
        return None
    faces: list[Ring] = [cycle, cycle[::-1]]
    drawn: Neighbors = {}
    _draw(drawn, (*cycle, cycle[0]))
    while True:
        pieces = _pieces(neighbors, drawn)
        if not pieces:
            return tuple(faces) if len(drawn) == len(neighbors) else None
        chosen: tuple[set[int], frozenset[int], list[int]] | None = None
        for inner, hanging in pieces:
            if len(hanging) < 2:
                return None
            fit = [k for k, face in enumerate(faces) if hanging <= set(face)]
            if not fit:
                return None
            if chosen is None or len(fit) < len(chosen[2]):
                chosen = inner, hanging, fit
        assert chosen is not None
        path = _path(neighbors, chosen[0], chosen[1])
        face = faces.pop(chosen[2][0])
        faces += _divided(face, path)
        _draw(drawn, path)


def is_whole(neighbors: Neighbors) -> bool:
    """Whether every part of a graph is planar and 3-connected, as nearly all solids are.

    Parameters
    ----------
    neighbors : dict of int to set of int
        Of each corner that has lines.
    """
    if any(len(around) < 3 for around in neighbors.values()):
        return False
    for part in components(neighbors):
        faces = embedded_faces({corner: neighbors[corner] for corner in part})
        if faces is None or shared_pairs(faces):
            return False
    return True


def shared_pairs(faces: Sequence[Ring]) -> list[tuple[int, int, int, int]]:
    """Return pairs of faces that meet in two corners which no line of both joins.

    Returns
    -------
    list of (face, face, corner, corner)
        The graph falls apart where both corners are taken away; without any pair it is
        3-connected.
    """
    found = []
    sets = [set(face) for face in faces]
    for first in range(len(faces)):
        for second in range(first + 1, len(faces)):
            common = sets[first] & sets[second]
            if len(common) < 2:
                continue
            ordered = [corner for corner in faces[first] if corner in common]
            pairs = zip(ordered, ordered[1:] + ordered[:1], strict=True)
            for one, other in list(pairs)[: len(ordered) - (len(ordered) == 2)]:
                if not (
                    _adjacent(faces[first], one, other) and _adjacent(faces[second], one, other)
                ):
                    found.append((first, second, one, other))
    return found


def flipped(faces: Sequence[Ring], pair: tuple[int, int, int, int]) -> tuple[Ring, ...]:
    """Return the embedding in which the piece between two corners is turned over.

    Both faces exchange the ways on which they pass the piece; directions are not kept.
    """
    first, second, one, other = pair
    ahead, behind = _ways(faces[first], one, other)
    along, against = _ways(faces[second], one, other)
    found = list(faces)
    found[first] = (*behind, *against[::-1][1:-1])
    found[second] = (*along, *ahead[::-1][1:-1])
    return tuple(found)


def _ways(face: Ring, one: int, other: int) -> tuple[Ring, Ring]:
    """Return the parts of a ring from one corner to the other and back, with both ends."""
    start = face.index(one)
    turned = face[start:] + face[:start]
    end = turned.index(other)
    return turned[: end + 1], (*turned[end:], one)


def _adjacent(face: Ring, one: int, other: int) -> bool:
    place = face.index(one)
    return other in (face[place - 1], face[(place + 1) % len(face)])


def _reached(neighbors: Neighbors, start: int, seen: set[int]) -> list[int]:
    """Corners that can be reached without those seen, which they join."""
    seen.add(start)
    part = [start]
    for corner in part:
        for following in sorted(neighbors[corner]):
            if following not in seen:
                seen.add(following)
                part.append(following)
    return part


def _cycle(neighbors: Neighbors) -> Ring | None:
    """Return a shortest cycle through the first corner, or None if there is none."""
    root = min(neighbors)
    branch = {root: root}
    parent = {root: root}
    waiting = deque([root])
    while waiting:
        corner = waiting.popleft()
        for following in sorted(neighbors[corner]):
            if following not in parent:
                parent[following] = corner
                branch[following] = following if corner == root else branch[corner]
                waiting.append(following)
            elif (
                following != parent[corner]
                and corner != parent[following]
                and branch[following] != branch[corner]
                and root not in (corner, following)
            ):
                return (*_back(parent, corner, root)[::-1], *_back(parent, following, root)[:-1])
    return None


def _back(parent: dict[int, int], corner: int, root: int) -> list[int]:
    """Return the way from a corner to the root of its tree."""
    way = [corner]
    while way[-1] != root:
        way.append(parent[way[-1]])
    return way


def _draw(drawn: Neighbors, path: Sequence[int]) -> None:
    """Enter the lines of a path."""
    for first, second in pairwise(path):
        drawn.setdefault(first, set()).add(second)
        drawn.setdefault(second, set()).add(first)


def _pieces(neighbors: Neighbors, drawn: Neighbors) -> list[tuple[set[int], frozenset[int]]]:
    """Return what is not drawn yet: connected corners, or none, and those where they hang."""
    found: list[tuple[set[int], frozenset[int]]] = []
    for corner in sorted(drawn):
        for following in sorted(neighbors[corner] - drawn[corner]):
            if following in drawn and corner < following:
                found.append((set(), frozenset((corner, following))))
    seen = set(drawn)
    for start in sorted(neighbors):
        if start not in seen:
            inner = set(_reached(neighbors, start, seen))
            hanging = frozenset(
                other for corner in inner for other in neighbors[corner] if other in drawn
            )
            found.append((inner, hanging))
    return found


def _path(neighbors: Neighbors, inner: set[int], hanging: frozenset[int]) -> Ring:
    """Return a shortest path through a piece between two corners at which it hangs."""
    start = min(hanging)
    if not inner:
        return (start, max(hanging))
    parent = {corner: start for corner in sorted(neighbors[start] & inner)}
    waiting = deque(parent)
    while waiting:
        corner = waiting.popleft()
        for following in sorted(neighbors[corner]):
            if following in hanging and following != start:
                return (*_back(parent, corner, start)[::-1], following)
            if following in inner and following not in parent:
                parent[following] = corner
                waiting.append(following)
    return (start, max(hanging))


def _divided(face: Ring, path: Ring) -> tuple[Ring, Ring]:
    """Both faces that a path makes of one, running round in the same sense."""
    ahead, behind = _ways(face, path[0], path[-1])
    between = path[1:-1]
    return (*ahead, *between[::-1]), (*behind, *between)
