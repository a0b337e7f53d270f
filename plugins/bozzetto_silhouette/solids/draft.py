"""Drafts: what is seen of a tree while something of it changes at every move of the hand.

Parts and fillets are shown one in another: what is seen of them is their union, and nothing is
united. What is carved is carved from each of them by itself, where it reaches them. So a change
costs what it touches, however large the tree is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Placement
from bozzetto.plugin import cached_property, remembered
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Placed
from bozzetto_silhouette.inflation.closed_surface import vertex_normals
from bozzetto_silhouette.inflation.manifold_check import original_numbers
from bozzetto_silhouette.inflation.solidify import Checkpoint, SilhouetteSolid, ignore
from bozzetto_silhouette.model.state import Group, Operation, Part, SilhouetteState
from bozzetto_silhouette.solids.body import Body, meet
from bozzetto_silhouette.solids.extrude import acts_on, straight_body
from bozzetto_silhouette.solids.fillet import Blend, Fillet, common_box, fillets_of
from bozzetto_silhouette.solids.fillet_rim import with_even_rim
from bozzetto_silhouette.solids.lump import Held, Lump, Remainder
from bozzetto_silhouette.solids.part_cells import FEWEST_IN_DRAFTS, cells_of
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.solids.placements import groups_around
from bozzetto_silhouette.solids.polygonize import Surface
from bozzetto_silhouette.solids.traversal import put_together
from bozzetto_silhouette.solids.union_mesh import UnionMesh, found, mesh_of

FILLETED = 2
"""Fillets that may change with the chosen part and still be shown while it does: each takes 20 to
30 ms."""

FELT = 6.0
"""Distance from a crease, in reaches, up to which a part may tell on its fillet: the promise of
`Implicit` on values outside is no better."""


class Shell(NamedTuple):
    """A closed surface of a draft, and which parts it belongs to.

    Attributes
    ----------
    lump : Lump
    owner : str
        Id of the part; of a fillet that of the later of its two.
    numbers : (v,) int array, optional
        Of what was carved: under which manifold3d keeps apart what its vertices come from.
    walls : mapping of int to str
        Ids of the parts by these numbers.
    fills : bool
        Whether it is a fillet, or what was left of one.
    """

    lump: Lump
    owner: str
    numbers: Index | None = None
    walls: Mapping[int, str] = MappingProxyType({})
    fills: bool = False

    def known(self) -> dict[int, str]:
        """Return the ids of the parts by the numbers of manifold3d."""
        if self.numbers is not None:
            return dict(self.walls)
        return dict.fromkeys(original_numbers(self.lump.manifold), self.owner)

    def owners(self) -> list[str]:
        """Return the ids of the parts that its vertices belong to."""
        if self.numbers is None:
            return [self.owner] * len(self.lump.shown().vertices)
        known, at = np.unique(self.numbers, return_inverse=True)
        names = [self.walls.get(int(number), self.owner) for number in known]
        return [names[k] for k in at.tolist()]


class Drafted(NamedTuple):
    """Visible parts of a tree.

    Attributes
    ----------
    body : Body
        Every surface in it is closed, and they overlap. A wall that was carved has its origin
        in the part that carved it.
    under : (v,) int array
        For every vertex the index in `body.sources` of the part that it would belong to if
        nothing had been carved.
    shells : tuple of Shell
        Its surfaces in turn.
    """

    body: Body
    under: Index
    shells: tuple[Shell, ...]


@dataclass(frozen=True, eq=False)
class Draft:
    """Some solids one in another.

    Attributes
    ----------
    shells : tuple of Shell
    bodies : tuple of Body
        Those of the parts, by whose vertices creases are found.
    implicit : Implicit
        Its zero set is the surface that is meant.
    radius : float
        The largest inscribed radius.
    step : float
        The finest spacing of the meshes.
    """

    shells: tuple[Shell, ...]
    bodies: tuple[Body, ...]
    implicit: Implicit
    radius: float
    step: float

    @classmethod
    def of(cls, body: Body) -> Draft:
        """Return one part by itself."""
        shell = Shell(Lump(body, body.bounds, _surface(body)), body.sources[0])
        return cls((shell,), (body,), body.implicit, body.radius, body.step)

    @cached_property
    def box(self) -> Array:
        """Corners of the box around all of it, (2, 3)."""
        boxes = np.stack([shell.lump.box for shell in self.shells])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    def placed(self, pose: Placement) -> Draft:
        """Return all of it where a group was moved to."""
        if pose.is_identity:
            return self
        return Draft(
            tuple(shell._replace(lump=_placed(shell.lump, pose)) for shell in self.shells),
            tuple(_placed_body(body, pose) for body in self.bodies),
            Placed(self.implicit, pose),
            self.radius * pose.scale,
            self.step * pose.scale,
        )

    def seen(self) -> Drafted:
        """Return what is seen as one body."""
        if len(self.shells) == 1 and self.shells[0].lump.held is self.bodies[0]:
            body = self.bodies[0]
            return Drafted(body, body.origins.astype(np.intp), self.shells)
        surfaces = [shell.lump.shown() for shell in self.shells]
        starts = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
        owners = [shell.owners() for shell in self.shells]
        sources = tuple(dict.fromkeys(
            source for shell, found in zip(self.shells, owners, strict=True)
            for source in (shell.owner, *dict.fromkeys(found))
        ))  # fmt: skip
        number = {source: k for k, source in enumerate(sources)}
        body = Body(
            np.concatenate([surface.vertices for surface in surfaces]),
            np.concatenate([
                surface.faces + np.int32(start)
                for surface, start in zip(surfaces, starts, strict=False)
            ]),
            np.concatenate([surface.normals for surface in surfaces]),
            np.array([number[name] for found in owners for name in found], np.int32),
            sources,
            self.implicit,
            self.radius,
            self.step,
        )  # fmt: skip
        whole = np.array([number[shell.owner] for shell in self.shells], np.intp)
        return Drafted(body, np.repeat(whole, np.diff(starts)), self.shells)


def draft_of(
    state: SilhouetteState, resolution: int, checkpoint: Checkpoint = ignore
) -> tuple[Drafted | None, dict[str, SilhouetteSolid]]:
    """Return what is seen of all nodes that are switched on, and the solids of the parts by id.

    It is told by the state alone. Where the chosen node meets so many others that the fillets
    between would take longer than a hand may wait, these are left out: there creases are sharp.

    Raises
    ------
    UserError
        If a part's ink is no outline; the message begins with the name of the part.
    """
    making = _Making(state, resolution, checkpoint)
    whole = making.whole()
    if 0 < making.changing <= FILLETED:
        making = _Making(state, resolution, checkpoint, leaves_out=False)
        whole = making.whole()
    return None if whole is None else whole.seen(), making.solids


@dataclass
class _Making:
    """One pass over the tree; `changing` counts the creases that the chosen node tells on."""

    state: SilhouetteState
    resolution: int
    checkpoint: Checkpoint
    leaves_out: bool = True
    changing: int = 0
    solids: dict[str, SilhouetteSolid] = field(default_factory=dict)

    def whole(self) -> Draft | None:
        return put_together(self.state, self.part, self.moved, self.joined)

    def part(self, part: Part, before: Draft | None) -> Draft:
        if before is not None and acts_on(part):
            return Draft.of(straight_body(part, before.box, self.resolution))
        body = body_of(part, self._cells.get(part.id, self.resolution), self.checkpoint)
        if body.solid is not None:
            self.solids[part.id] = body.solid
        return Draft.of(body)

    def moved(self, whole: Draft, group: Group) -> Draft:
        return whole.placed(group.pose)

    def joined(self, first: Draft, second: Draft, node: Part | Group) -> Draft | None:
        operation = node.operation
        reach = node.blend * min(first.radius, second.radius)
        gap = reach if operation == "merge" else 0.0
        apart = not meet(first.box, second.box + gap * np.array([[-1.0], [1.0]]))
        if apart and operation in ("carve", "intersect"):
            return first if operation == "carve" else None
        self.checkpoint(0.8, "combine")
        reach = 0.0 if apart else reach
        blend = node.blend if reach else 0.0
        solid = Composite(first.implicit, second.implicit, operation, blend, reach)
        step = min(first.step, second.step)
        added = self._fillets(first, second, solid, step) if reach > 0.0 else ()
        if operation in ("carve", "intersect"):
            shells = _acted_on(first.shells, second.shells, added, operation)
        else:
            shells = first.shells + second.shells + added
        if not shells:
            return None
        radius = max(first.radius, second.radius)
        return Draft(shells, first.bodies + second.bodies, solid, radius, step)

    def _fillets(
        self, first: Draft, second: Draft, solid: Composite, step: float
    ) -> tuple[Shell, ...]:
        bodies = first.bodies + second.bodies
        around = common_box(first.box, second.box, (2.0 + FELT) * solid.reach)
        if any(meet(body.bounds, around) for body in bodies if self._is_chosen(body)):
            self.changing += 1
            if self.leaves_out:
                return ()
        box = common_box(first.box, second.box, 2.0 * solid.reach)
        (fillets,) = fillets_of([Blend(solid, box, bodies, step)], self.checkpoint)
        owner = second.shells[0].owner
        return tuple(
            Shell(Lump(f, f.box, with_even_rim(f, solid, step)), owner, fills=True) for f in fillets
        )

    @cached_property
    def _cells(self) -> dict[str, int]:
        return cells_of(self.state, self.resolution, FEWEST_IN_DRAFTS)

    def _is_chosen(self, body: Body) -> bool:
        return body.sources[0] in self._chosen

    @cached_property
    def _chosen(self) -> frozenset[str]:
        """The ids of the chosen part, or of all parts in the chosen group."""
        selected = self.state.selected
        return frozenset(
            part.id
            for part in self.state.parts
            if part.id == selected
            or any(group.id == selected for group in groups_around(self.state, part))
        )


def _acted_on(
    first: tuple[Shell, ...],
    tools: tuple[Shell, ...],
    fillets: tuple[Shell, ...],
    operation: Operation,
) -> tuple[Shell, ...]:
    """Return what carving or intersecting leaves of each shell."""
    left: list[Shell | None] = []
    for shell in first:
        box = shell.lump.box
        met = tuple(tool for tool in tools if meet(tool.lump.box, box))
        taken = tuple(fillet for fillet in fillets if meet(fillet.lump.box, box))
        if operation == "intersect":
            left += [_cut(shell, tool, taken) for tool in met]
        else:
            left.append(_cut(shell, None, met + taken) if met or taken else shell)
    return tuple(shell for shell in left if shell is not None)


def _cut(shell: Shell, within: Shell | None, taken: tuple[Shell, ...]) -> Shell | None:
    """Return a shell as far as it lies within another, without what is taken; None for nothing."""
    found = _left(
        shell.lump, None if within is None else within.lump, tuple(tool.lump for tool in taken)
    )
    if found is None:
        return None
    lump, numbers = found
    if lump is shell.lump:
        return shell
    walls: dict[int, str] = {}
    for one in (*taken, *(() if within is None else (within,)), shell):
        walls |= one.known()
    return Shell(lump, shell.owner, numbers, walls, shell.fills)


@remembered(
    limit=256,
    key=lambda lump, within, taken: (
        lump.held, None if within is None else within.held, tuple(tool.held for tool in taken),
    ),
)  # fmt: skip
def _left(
    lump: Lump, within: Lump | None, taken: tuple[Lump, ...]
) -> tuple[Lump, Index | None] | None:
    """Return what is left of a lump, and where its vertices come from; None for nothing.

    Where manifold3d finds no sound solid the lump stays as it is.
    """
    from manifold3d import Manifold, OpType

    solid = lump.manifold if within is None else lump.manifold ^ within.manifold
    if taken:
        solid = Manifold.batch_boolean([solid, *(tool.manifold for tool in taken)], OpType.Subtract)
    if solid.status().name != "NoError":
        return lump, None
    if solid.is_empty():
        return None
    mesh = mesh_of(solid)
    others = taken if within is None else (within, *taken)
    surface = _with_normals_of(mesh, (lump, *others), within)
    box = np.stack([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
    return Lump(Remainder(solid), box, surface), np.repeat(mesh.numbers, 3)


def _with_normals_of(mesh: UnionMesh, lumps: tuple[Lump, ...], within: Lump | None) -> Surface:
    """Return the surface of a remainder, whose corners keep the normals of what they come from.

    Those of new corners, along creases, are the normals of their faces.
    """
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    faces = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    normals = vertex_normals(corners, faces)
    for k, lump in enumerate(lumps):
        surface = lump.shown()
        parent = found(corners, surface.vertices)
        known = parent >= 0
        side = 1.0 if k == 0 or lump is within else -1.0
        normals[known] = side * surface.normals[parent[known]]
    return Surface(corners, faces, normals)


@remembered(limit=256, key=lambda lump, pose: (lump.held, pose))
def _placed(lump: Lump, pose: Placement) -> Lump:
    """Return a lump of a group that was moved."""
    held = lump.held
    if isinstance(held, Body):
        return Draft.of(_placed_body(held, pose)).shells[0].lump
    vertices, faces, normals = lump.shown()
    surface = Surface(
        pose.points(vertices),
        faces[:, ::-1] if pose.mirrors else faces,
        pose.directions(normals),
    )
    box = np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])
    moved: Held
    if isinstance(held, Fillet):
        moved = Fillet(surface, held.cell * pose.scale)
    else:
        rotation = np.array(pose.rotation).reshape(3, 3)
        moved = Remainder(
            held.manifold.transform(np.column_stack([pose.scale * rotation, pose.offset]))
        )
    return Lump(moved, box, surface)


@remembered(limit=64)
def _surface(body: Body) -> Surface:
    if not len(body.creases):
        return Surface(body.vertices, body.faces, body.normals)
    return Surface(*body.split_at_creases())


@remembered(limit=256)
def _placed_body(body: Body, pose: Placement) -> Body:
    return body.placed(pose)
