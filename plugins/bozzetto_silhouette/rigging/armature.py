"""One rig for the whole tree: the joints of all parts, hung on each other where parts touch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Placement, Rig
from bozzetto.plugin import remembered
from bozzetto_silhouette.model.state import Cut, Group, Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.outline.medial_axis import Skeleton
from bozzetto_silhouette.outline.mirror_symmetry import mirrored_skeleton
from bozzetto_silhouette.outline.normalized import frame_of
from bozzetto_silhouette.rigging.bone_names import bone_names
from bozzetto_silhouette.rigging.joint_extraction import Joints, joints_of, most_central
from bozzetto_silhouette.solids.placements import placement_of

NEAR = 0.1
"""Parts touch when their balls are nearer than this share of the smaller ball's radius."""

HELD = 2
"""Parts that touch one that goes straight through, so that it has a joint: it holds them."""


@dataclass(frozen=True, eq=False)
class Limbs:
    """The joints of one connected piece of a part, parents before children.

    Attributes
    ----------
    part : str
        Id of the part.
    placement : Placement
        From the part's object frame to the model's.
    flatness : float
        Half thickness where a round part would have 1.
    nodes : (n, 3) float array
        x, y and radius of each joint, in the object frame.
    parents : (n,) int array
        Within the piece; -1 for its root.
    cuts : (k, 2) int array
        Links that closed loops.
    paths : tuple of (k, 3) float arrays
        x, y and radius of the axis along each link, in the object frame: from its parent to
        each joint but the root, then along the cuts.
    first : int
        Number of its root in the whole rig.
    """

    part: str
    placement: Placement
    flatness: float
    nodes: Array
    parents: Index
    cuts: Index
    paths: tuple[Array, ...]
    first: int

    @property
    def places(self) -> Array:
        """Joints in the model's frame, (n, 3), mm."""
        return _lifted(self.placement, self.nodes)

    @property
    def radii(self) -> Array:
        """Radii of the balls around them, (n,), mm."""
        return np.asarray(self.nodes[:, 2] * self.placement.scale)

    @property
    def numbers(self) -> slice:
        """Numbers of its joints in the whole rig."""
        return slice(self.first, self.first + len(self.nodes))


@dataclass(frozen=True, eq=False)
class Armature:
    """A rig at rest, and what its joints are in.

    Attributes
    ----------
    rig : Rig
        In the model's frame.
    radii : (n,) float array
        Of the ball around each joint, mm.
    limbs : tuple of Limbs
        In the order of their joints.
    rigid : frozenset of str
        Ids of parts that add to the shape and do not bend: they go straight through.
    """

    rig: Rig
    radii: Array
    limbs: tuple[Limbs, ...]
    rigid: frozenset[str]

    def limbs_of(self, joint: int) -> Limbs:
        """Return the limbs that a joint is in, by its number in the rig."""
        return next(one for one in reversed(self.limbs) if one.first <= joint)


@dataclass(frozen=True, eq=False)
class _Piece:
    """A piece of a part before it is attached to another."""

    part: Part
    placement: Placement
    joints: Joints
    skeleton: Skeleton

    @property
    def places(self) -> Array:
        return _lifted(self.placement, self.joints.nodes)

    @property
    def radii(self) -> Array:
        return np.asarray(self.joints.nodes[:, 2] * self.placement.scale)

    @property
    def size(self) -> float:
        """Radius of its thickest ball, mm."""
        return float(self.radii.max())

    @property
    def is_rigid(self) -> bool:
        """Whether it goes straight through, and does not bend."""
        return self.part.surface == "straight"

    def reaches(self, ways: Array) -> Array:
        """Return how far it reaches from the nodes of its skeleton, mm.

        There are balls around them, made thinner or thicker by the part's inflation.

        Parameters
        ----------
        ways : (n, m, 3) float array
            Unit directions from each of the n nodes, in the model's frame.

        Returns
        -------
        (n, m) float array
        """
        up = ways @ self.placement.directions(np.eye(3)[2:])[0]
        stretch = np.sqrt(1.0 - up**2 + (up / self.part.inflation) ** 2)
        return np.asarray(self.skeleton.nodes[:, 2:] * self.placement.scale / stretch)


@remembered(limit=64, key=lambda state: state.unpainted)
def armature_of(state: SilhouetteState) -> Armature | None:
    """Return the joints of all parts that add to the shape; None where there are none.

    The largest piece has its root at its thickest joint. Every other one is attached to the
    largest of those it touches: its joint nearest to one of that piece becomes its root, where it
    leaves that piece if it begins inside. What touches nothing has a root of its own. What goes
    straight through has a joint only where it holds others together, as a seat holds legs.

    Parameters
    ----------
    state : SilhouetteState
        The tree of nodes.

    Raises
    ------
    UserError
        If a part's ink is no outline.
    """
    adding = list(_adding(state))
    waiting = [
        _Piece(part, placement_of(state, part), joints, skeleton)
        for part in adding
        for skeleton, pieces in (_drawn_joints(part),)
        for joints in pieces
    ]
    waiting.sort(key=lambda piece: -piece.size)  # stable: equals stay in the order of the tree
    hung, parents, beside = _hung(waiting)
    while ends := [
        piece for piece, around in zip(waiting, beside, strict=True)
        if piece.is_rigid and around < HELD
    ]:  # fmt: skip
        waiting = [piece for piece in waiting if piece not in ends]
        hung, parents, beside = _hung(waiting)
    if not hung:
        return None
    all_limbs = tuple(limbs for _, limbs in hung)
    cuts = np.concatenate([limbs.first + limbs.cuts for limbs in all_limbs])
    places = np.concatenate([limbs.places for limbs in all_limbs])
    parts = [piece.part.name for piece, limbs in hung for _ in limbs.nodes]
    rig = Rig(
        places,
        np.array(parents, np.int32),
        bone_names(places, parents, parts),
        cuts=cuts.astype(np.int32) if len(cuts) else None,
    )
    rigid = frozenset(part.id for part in adding if part.surface == "straight")
    return Armature(rig, np.concatenate([limbs.radii for limbs in all_limbs]), all_limbs, rigid)


def _hung(pieces: list[_Piece]) -> tuple[list[tuple[_Piece, Limbs]], list[int], list[int]]:
    """Hang pieces on each other, the largest first.

    Parameters
    ----------
    pieces : list of _Piece
        By size, falling.

    Returns
    -------
    list of (_Piece, Limbs)
        Without what lies inside the piece that they hang on, in the order of their joints.
    list of int
        The parent of each joint of all; -1 for roots.
    list of int
        How many pieces each of those given hangs on, or holds.
    """
    waiting = list(pieces)
    hung: list[tuple[_Piece, Limbs]] = []
    touched: dict[_Piece, tuple[_Piece, _Piece, Limbs]] = {}
    parents: list[int] = []
    while waiting:
        whole = next((piece for piece in waiting if piece in touched), waiting[0])
        waiting.remove(whole)
        piece = whole
        away = np.linalg.norm(piece.places - piece.places.mean(axis=0), axis=1)
        root, parent = most_central(piece.radii, away), -1
        if whole in touched:
            _, holder, onto = touched[whole]
            piece, roots = _leaving(piece, holder)
            gaps = np.linalg.norm(piece.places[roots, None] - onto.places, axis=2)
            reach = piece.radii[roots, None] + onto.radii
            root, there = divmod(int((gaps / reach).argmin()), len(onto.nodes))
            root, parent = int(roots[root]), onto.first + there
        limbs = _rooted(piece, root, len(parents))
        hung.append((piece, limbs))
        parents += [parent, *(limbs.first + limbs.parents[1:]).tolist()]
        for other in waiting:
            larger = other not in touched or touched[other][1].size < piece.size
            if larger and _touch(other, piece):
                touched[other] = (whole, piece, limbs)
    holders = [touched[piece][0] for piece in pieces if piece in touched]
    return hung, parents, [(piece in touched) + holders.count(piece) for piece in pieces]


# Whatever else of a part changes, at every move of a slider.
@remembered(limit=256, key=lambda part: (outline_of(part), part.skeleton))
def _drawn_joints(part: Part) -> tuple[Skeleton, list[Joints]]:
    """Return the skeleton of a part's solid and its joints, in the object frame.

    What goes straight through has one joint, in its middle, for each of its pieces.
    """
    frame = frame_of(outline_of(part), part.skeleton)
    skeleton = frame.skeleton
    if frame.mirrored is not None:
        skeleton = mirrored_skeleton(skeleton, frame.mirrored)
    skeleton = skeleton.transformed(frame.scale, frame.origin)
    pieces = joints_of(skeleton)
    return skeleton, list(map(_in_the_middle, pieces)) if part.surface == "straight" else pieces


def _in_the_middle(joints: Joints) -> Joints:
    """Return the thickest joint of a piece alone."""
    away = np.linalg.norm(joints.nodes[:, :2] - joints.nodes[:, :2].mean(axis=0), axis=1)
    node = most_central(joints.nodes[:, 2], away)
    return Joints(joints.nodes[[node]], np.zeros((0, 2), np.intp), np.zeros(0), ())


def _adding(state: SilhouetteState, within: str = "") -> Iterator[Part]:
    """Return the visible parts that add to the shape: what comes first in a group always does."""
    first = True
    for node in state.nodes:
        if node.within != within or not node.visible:
            continue
        adds, first = first or node.operation in ("add", "merge"), False
        if not adds:
            continue
        if isinstance(node, Group):
            yield from _adding(state, node.id)
        elif not isinstance(node, Cut):
            yield node


def _lifted(placement: Placement, nodes: Array) -> Array:
    return placement.points(np.column_stack([nodes[:, :2], np.zeros(len(nodes))]))


def _leaving(piece: _Piece, holder: _Piece) -> tuple[_Piece, Index]:
    """Return a piece without what lies inside the piece that it hangs on, and where it leaves that.

    Of each row that begins inside the last joint there stays, as a hip or a shoulder; of the
    branches into the corners of a limb's broad beginning, nothing.

    Returns
    -------
    _Piece
        As it was if all of it lies inside.
    (k,) int array
        Its joints that may hang on the other piece: those inside, else all.
    """
    home = holder.placement.inverse().points(piece.places)
    depth = np.abs(home[:, 2]) / max(holder.part.inflation, 1e-300)
    inside = holder.skeleton.heights(home[:, :2]) > depth
    if inside.all() or not inside.any():
        return piece, np.arange(len(inside))
    links = piece.joints.links
    kept = np.ones(len(inside), bool)
    while True:
        left = links[kept[links].all(axis=1)]
        degrees = np.bincount(left.ravel(), minlength=len(kept))
        ends = np.flatnonzero(kept & inside & (degrees == 1))
        ways = left[np.isin(left, ends).any(axis=1)]
        ways = np.concatenate([ways, ways[:, ::-1]])
        ways = ways[np.isin(ways[:, 0], ends)]
        gone = ways[inside[ways[:, 1]] | (degrees[ways[:, 1]] > 2), 0]
        if not len(gone):
            break
        kept[gone[0]] = False
    left = np.flatnonzero(kept[links].all(axis=1))
    number = np.cumsum(kept) - 1
    joints = Joints(
        piece.joints.nodes[kept],
        number[links[left]],
        piece.joints.thickness[left],
        tuple(piece.joints.paths[k] for k in left.tolist()),
    )
    places = np.flatnonzero(inside[kept])
    return replace(piece, joints=joints), places if len(places) else np.arange(len(joints.nodes))


def _touch(one: _Piece, other: _Piece) -> bool:
    """Whether balls of two pieces meet."""
    if one.part.id == other.part.id:
        return False
    here, there = one.skeleton.nodes, other.skeleton.nodes
    radii, others = here[:, 2] * one.placement.scale, there[:, 2] * other.placement.scale
    ways = _lifted(other.placement, there) - _lifted(one.placement, here)[:, None]
    gaps = np.linalg.norm(ways, axis=2)
    ways /= np.maximum(gaps, 1e-300)[:, :, None]
    reach = one.reaches(ways) + other.reaches(ways.swapaxes(0, 1)).T
    return bool((gaps <= reach + NEAR * np.minimum(radii[:, None], others)).any())


def _rooted(piece: _Piece, root: int, first: int) -> Limbs:
    """Order the joints of a piece as a tree; loops are cut where they are thinnest."""
    nodes, links = piece.joints.nodes, piece.joints.links
    axis = {(a, b): path for (a, b), path in zip(links.tolist(), piece.joints.paths, strict=True)}
    axis |= {(b, a): path[::-1] for (a, b), path in axis.items()}
    cluster = list(range(len(nodes)))

    def head(node: int) -> int:
        while cluster[node] != node:
            node = cluster[node]
        return node

    around: list[list[int]] = [[] for _ in nodes]
    cut = []
    for link in np.argsort(-piece.joints.thickness, kind="stable").tolist():
        a, b = links[link].tolist()
        if head(a) == head(b):
            cut.append((a, b))
            continue
        cluster[head(a)] = head(b)
        around[a].append(b)
        around[b].append(a)

    order: list[int] = []
    parents: list[int] = []
    place = {}
    stack = [(root, -1)]
    while stack:
        node, above = stack.pop()
        place[node] = len(order)
        order.append(node)
        parents.append(above)
        # Around the clock, so that limbs are numbered the same however they were found.
        children = [k for k in around[node] if k not in place]
        children.sort(key=lambda k: -float(np.arctan2(*(nodes[k] - nodes[node])[1::-1])))
        stack += [(k, place[node]) for k in reversed(children)]
    cuts = sorted(sorted((place[a], place[b])) for a, b in cut)
    pairs = [(parents[k], k) for k in range(1, len(order))] + cuts
    return Limbs(
        piece.part.id,
        piece.placement,
        piece.part.inflation,
        nodes[order],
        np.array(parents, np.intp),
        np.array(cuts, np.intp).reshape(-1, 2),
        tuple(axis[order[a], order[b]] for a, b in pairs),
        first,
    )
