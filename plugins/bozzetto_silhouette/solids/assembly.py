"""Bodies and fillets that are one solid, united only when its mesh is asked for.

So a tree costs one union, however many parts it has, and parts that do not touch cost a copy.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import cached_property
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.model.state import Operation
from bozzetto_silhouette.solids.body import Body, meet, places_in
from bozzetto_silhouette.solids.field_body import field_body
from bozzetto_silhouette.solids.fillet import Blend, Fillet, common_box, fillets_of
from bozzetto_silhouette.solids.lump import Lump, Remainder, united
from bozzetto_silhouette.solids.polygonize import Surface
from bozzetto_silhouette.solids.volume_check import is_allowed, is_lost

if TYPE_CHECKING:
    from manifold3d import Manifold


CRUMBS = 1e-9
"""Share of a solid's volume below which nothing is left of it but what rounding leaves."""


class Piece(NamedTuple):
    """A body whose surface may be part of the whole's.

    Attributes
    ----------
    body : Body
    side : {1, -1}
        -1 where its inside is outside of the whole.
    """

    body: Body
    side: int


@dataclass(frozen=True, eq=False)
class Assembly:
    """Some solids that are united, and what is known of the surface that they make.

    Attributes
    ----------
    solids : tuple of Lump
        Their union with the fillets of `loose` is the solid.
    pieces : tuple of Piece
        In the order of their sources.
    blends : tuple of Blend
    loose : tuple of Blend
        Those of them whose fillets are not in the solids: what is carved has them in it.
    implicit : Implicit
        Its zero set is the surface.
    radius : float
        The largest inscribed radius.
    step : float
        The finest spacing of the meshes.
    """

    solids: tuple[Lump, ...]
    pieces: tuple[Piece, ...]
    blends: tuple[Blend, ...]
    loose: tuple[Blend, ...]
    implicit: Implicit
    radius: float
    step: float

    @classmethod
    def of(cls, body: Body) -> Assembly:
        """Return one body by itself."""
        surface = Surface(body.vertices, body.faces, body.normals)
        lump = Lump(body, body.bounds, surface)
        return cls((lump,), (Piece(body, 1),), (), (), body.implicit, body.radius, body.step)

    @property
    def alone(self) -> Body | None:
        """The body that it consists of; None where several were put together."""
        return self.pieces[0].body if len(self.pieces) == 1 and not self.blends else None

    @property
    def sources(self) -> tuple[str, ...]:
        """Ids of the parts."""
        return tuple(source for piece in self.pieces for source in piece.body.sources)

    @cached_property
    def fillets(self) -> tuple[Fillet, ...]:
        """The fillets of all blends."""
        return _fillets(self.blends)

    @cached_property
    def lumps(self) -> tuple[Lump, ...]:
        """Solids that are to be united."""
        return self.solids + _lumps(self.loose)

    @cached_property
    def box(self) -> Array:
        """Corners of a box around all lumps, (2, 3)."""
        known = [lump.box for lump in self.solids], [blend.bounds for blend in self.loose]
        boxes = np.stack([box for boxes in known for box in boxes])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    @cached_property
    def whole(self) -> Manifold | None:
        """The lumps united; None where manifold3d finds no sound solid."""
        return united(self.lumps)

    @property
    def resampled(self) -> bool:
        """Whether a body in it was made anew from its function."""
        return any(piece.body.resampled for piece in self.pieces)

    def places(self, box: Array) -> Array:
        """Return the vertices of the bodies in a box (2, 3)."""
        return places_in((body for body, _ in self.pieces), box)


def assembled(
    first: Assembly,
    second: Assembly,
    operation: Operation,
    blend: float,
    checkpoint: Checkpoint = ignore,
    reach: float | None = None,
) -> Assembly | None:
    """Put two assemblies together; None where nothing is left.

    Parameters
    ----------
    first, second : Assembly
        In the same frame.
    operation : {"add", "merge", "carve", "intersect"}
        What the second does to the first.
    blend : float
        Radius of the blend as a share of the smaller `radius` of the two; 0 is a sharp crease.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.
    reach : float, optional
        The largest radius of the blend, as a length; by default it follows from `blend`.
    """
    if reach is None:
        reach = blend * min(first.radius, second.radius)
    gap = reach if operation == "merge" else 0.0
    apart = not meet(first.box, second.box + gap * np.array([[-1.0], [1.0]]))
    if apart and operation in ("carve", "intersect"):
        return first if operation == "carve" else None
    checkpoint(0.0, "combine")
    step = min(first.step, second.step)
    reach = 0.0 if apart else reach
    solid = Composite(first.implicit, second.implicit, operation, blend if reach else 0.0, reach)
    added: tuple[Blend, ...] = ()
    if reach > 0.0:
        bodies = [piece.body for piece in first.pieces + second.pieces]
        box = common_box(first.box, second.box, 2.0 * reach)
        added = (Blend(solid, box, bodies, step),)
    side = -1 if operation == "carve" else 1
    whole = Assembly(
        first.solids + second.solids,
        first.pieces + tuple(Piece(body, side * sign) for body, sign in second.pieces),
        first.blends + second.blends + added,
        first.loose + second.loose + added,
        solid,
        max(first.radius, second.radius),
        step,
    )
    if operation in ("add", "merge"):
        return whole
    checkpoint(0.8, "combine")
    fillets_of(whole.loose, checkpoint)  # all at once, and remembered
    left = _remainder(first, second, operation, _lumps(added))
    if left is not None and left.is_empty() and is_lost(solid, solid.bounds, step):
        left = None
    if left is None:
        return remade(whole, checkpoint)
    if first.whole is None or not left.volume() > CRUMBS * first.whole.volume():
        return None
    low_high = np.array(left.bounding_box()).reshape(2, 3)
    return replace(whole, solids=(Lump(Remainder(left), low_high),), loose=())


def restricted(solid: Implicit, bodies: Mapping[Implicit, Body]) -> Assembly | None:
    """Return what some bodies are by themselves in a tree of unions; None for none of them.

    Parameters
    ----------
    solid : Implicit
        A composite of more bodies, all of them added or merged.
    bodies : mapping of Implicit to Body
        Those that are wanted, by their functions.
    """
    if solid in bodies:
        return Assembly.of(bodies[solid])
    if not isinstance(solid, Composite):
        return None
    first, second = (restricted(side, bodies) for side in (solid.first, solid.second))
    if first is None or second is None:
        return second if first is None else first
    return assembled(first, second, solid.operation, solid.blend, reach=solid.reach)


def _fillets(blends: tuple[Blend, ...]) -> tuple[Fillet, ...]:
    return tuple(fillet for fillets in fillets_of(blends) for fillet in fillets)


def _lumps(blends: tuple[Blend, ...]) -> tuple[Lump, ...]:
    return tuple(Lump(fillet, fillet.box, fillet.surface) for fillet in _fillets(blends))


def remade(whole: Assembly, checkpoint: Checkpoint = ignore) -> Assembly | None:
    """Return an assembly of one body, polygonized anew; None where nothing is inside.

    Raises
    ------
    UserError
        If not even that is sound.
    """
    bodies = [piece.body for piece in whole.pieces]
    body = field_body(whole.implicit, bodies, whole.radius, whole.step, checkpoint)
    return None if body is None else Assembly.of(body)


def _remainder(
    first: Assembly, second: Assembly, operation: Operation, added: tuple[Lump, ...]
) -> Manifold | None:
    """Return what carving or intersecting leaves; None where that is no sound solid."""
    one = first.whole
    other = united(second.lumps + added) if operation == "carve" else second.whole
    if one is None or other is None:
        return None
    if operation == "intersect" and tuple(second.box.ravel()) < tuple(first.box.ravel()):
        one, other = other, one  # the same to the last bit, whichever came first
    left = one - other if operation == "carve" else one ^ other
    if not is_allowed(left, operation, one, other):
        return None
    if operation == "carve" or not added:
        return left
    fillets = united(added)
    less = None if fillets is None else left - fillets
    if fillets is None or less is None or not is_allowed(less, "carve", left, fillets):
        return None
    return less
