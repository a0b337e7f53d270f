"""Drafts: what is seen of a tree while something of it changes at every move of the hand.

Parts and fillets are shown one in another: what is seen of them is their union, and nothing is
united. What is carved is carved from each of them by itself, where it reaches them. So a change
costs what it touches, however large the tree is.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Placement
from bozzetto.plugin import cached_property, remembered
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Placed
from bozzetto_silhouette.inflation.sewing import vertex_normals
from bozzetto_silhouette.inflation.solidify import Checkpoint, SilhouetteSolid, ignore
from bozzetto_silhouette.model.state import Group, Operation, Part, SilhouetteState
from bozzetto_silhouette.solids.body import Body, meet
from bozzetto_silhouette.solids.extrude import acts_on, straight_body
from bozzetto_silhouette.solids.fillet import Fillet, common_box, fillets_between
from bozzetto_silhouette.solids.lump import Held, Lump, Remainder
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.solids.placements import groups_around
from bozzetto_silhouette.solids.polygonize import Surface
from bozzetto_silhouette.solids.traversal import put_together
from bozzetto_silhouette.solids.union_mesh import found, mesh_of

if TYPE_CHECKING:
    from manifold3d import Manifold

FILLETED = 2
"""Fillets that may change with the chosen part and still be shown while it does: each takes 20 to
30 ms."""

FELT = 5.0
"""Distance from a crease, in reaches, up to which a part may tell on its fillet: the promise of
`Implicit` on values outside is no better."""


@dataclass(frozen=True, eq=False)
class Draft:
    """Some solids one in another.

    Attributes
    ----------
    lumps : tuple of Lump
    owners : tuple of str
        The id of the part that each belongs to; of a fillet that of the later of its two.
    bodies : tuple of Body
        Those of the parts, by whose vertices creases are found.
    implicit : Implicit
        Its zero set is the surface that is meant.
    radius : float
        The largest inscribed radius.
    step : float
        The finest spacing of the meshes.
    """

    lumps: tuple[Lump, ...]
    owners: tuple[str, ...]
    bodies: tuple[Body, ...]
    implicit: Implicit
    radius: float
    step: float

    @classmethod
    def of(cls, body: Body) -> Draft:
        """Return one part by itself."""
        lump = Lump(body, body.bounds, _surface(body))
        return cls((lump,), body.sources, (body,), body.implicit, body.radius, body.step)

    @cached_property
    def box(self) -> Array:
        """Corners of the box around all lumps, (2, 3)."""
        boxes = np.stack([lump.box for lump in self.lumps])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    def placed(self, pose: Placement) -> Draft:
        """Return all of it where a group was moved to."""
        if pose.is_identity:
            return self
        return Draft(
            tuple(_placed(lump, pose) for lump in self.lumps),
            self.owners,
            tuple(_placed_body(body, pose) for body in self.bodies),
            Placed(self.implicit, pose),
            self.radius * pose.scale,
            self.step * pose.scale,
        )

    def body(self) -> Body:
        """Return what is seen as one body: every surface is closed, and they overlap."""
        if len(self.lumps) == 1 and self.lumps[0].held is self.bodies[0]:
            return self.bodies[0]
        seen = [lump.shown() for lump in self.lumps]
        starts = np.cumsum([0, *(len(surface.vertices) for surface in seen)])
        sources = tuple(dict.fromkeys(self.owners))
        number = {source: k for k, source in enumerate(sources)}
        return Body(
            np.concatenate([surface.vertices for surface in seen]),
            np.concatenate([
                surface.faces + np.int32(start)
                for surface, start in zip(seen, starts, strict=False)
            ]),
            np.concatenate([surface.normals for surface in seen]),
            np.repeat(
                np.array([number[owner] for owner in self.owners], np.int32), np.diff(starts)
            ),
            sources,
            self.implicit,
            self.radius,
            self.step,
        )  # fmt: skip


def draft_of(
    state: SilhouetteState, resolution: int, checkpoint: Checkpoint = ignore
) -> tuple[Body | None, dict[str, SilhouetteSolid]]:
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
    return None if whole is None else whole.body(), making.solids


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
        body = body_of(part, self.resolution, self.checkpoint)
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
            lumps, owners = _acted_on(first, second.lumps, added, operation)
        else:
            lumps = first.lumps + second.lumps + added
            owners = first.owners + second.owners + (second.owners[0],) * len(added)
        if not lumps:
            return None
        radius = max(first.radius, second.radius)
        return Draft(lumps, owners, first.bodies + second.bodies, solid, radius, step)

    def _fillets(
        self, first: Draft, second: Draft, solid: Composite, step: float
    ) -> tuple[Lump, ...]:
        bodies = first.bodies + second.bodies
        around = common_box(first.box, second.box, (2.0 + FELT) * solid.reach)
        if any(meet(body.bounds, around) for body in bodies if self._is_chosen(body)):
            self.changing += 1
            if self.leaves_out:
                return ()
        box = common_box(first.box, second.box, 2.0 * solid.reach)
        fillets = fillets_between(solid, box, bodies, step, self.checkpoint)
        return tuple(Lump(fillet, fillet.box, fillet.surface) for fillet in fillets)

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
    first: Draft, tools: tuple[Lump, ...], fillets: tuple[Lump, ...], operation: Operation
) -> tuple[tuple[Lump, ...], tuple[str, ...]]:
    """Return what carving or intersecting leaves of each lump, and whose it is."""
    left: list[tuple[Lump, str]] = []
    for lump, owner in zip(first.lumps, first.owners, strict=True):
        met = tuple(tool for tool in tools if meet(tool.box, lump.box))
        taken = tuple(fillet for fillet in fillets if meet(fillet.box, lump.box))
        if operation == "carve":
            rest = [_left(lump, None, met + taken)] if met or taken else [lump]
        else:
            rest = [_left(lump, tool, taken) for tool in met]
        left += [(some, owner) for some in rest if some is not None]
    return tuple(lump for lump, _ in left), tuple(owner for _, owner in left)


@remembered(
    limit=256,
    key=lambda lump, within, taken: (
        lump.held, None if within is None else within.held, tuple(tool.held for tool in taken),
    ),
)  # fmt: skip
def _left(lump: Lump, within: Lump | None, taken: tuple[Lump, ...]) -> Lump | None:
    """Return a lump as far as it lies within another, without what is taken; None for nothing.

    Where manifold3d finds no sound solid the lump stays as it is.
    """
    from manifold3d import Manifold, OpType

    solid = lump.manifold if within is None else lump.manifold ^ within.manifold
    if taken:
        solid = Manifold.batch_boolean([solid, *(tool.manifold for tool in taken)], OpType.Subtract)
    if solid.status().name != "NoError":
        return lump
    if solid.is_empty():
        return None
    box = np.array(solid.bounding_box()).reshape(2, 3)
    others = taken if within is None else (within, *taken)
    return Lump(Remainder(solid), box, _with_normals_of(solid, (lump, *others), within))


def _with_normals_of(solid: Manifold, lumps: tuple[Lump, ...], within: Lump | None) -> Surface:
    """Return the surface of a remainder, whose corners keep the normals of what they come from.

    Those of new corners, along creases, are the normals of their faces.
    """
    mesh = mesh_of(solid)
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
        return Draft.of(_placed_body(held, pose)).lumps[0]
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
