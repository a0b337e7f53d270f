"""Lumps: closed solids that are united, and only then looked at by manifold3d."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.inflation.closed_surface import vertex_normals
from bozzetto_silhouette.solids.body import Body, meet
from bozzetto_silhouette.solids.fillet import Fillet
from bozzetto_silhouette.solids.polygonize import Surface
from bozzetto_silhouette.solids.volume_check import is_union

if TYPE_CHECKING:
    from manifold3d import Manifold


@dataclass(frozen=True, eq=False)
class Remainder:
    """Remainder after carving or intersecting."""

    manifold: Manifold


Held = Body | Fillet | Remainder
"""What a solid of manifold3d can be asked of."""


class Lump(NamedTuple):
    """A closed solid, and the corners of its box (2, 3); its surface, where that is at hand."""

    held: Held
    box: Array
    surface: Surface | None = None

    @property
    def place(self) -> tuple[float, ...]:
        """Sort key of lumps, which depends on no other lump."""
        return tuple(self.box.ravel().tolist())

    @property
    def manifold(self) -> Manifold:
        """The solid as manifold3d sees it."""
        return self.held.manifold

    def shown(self) -> Surface:
        """Return its surface; of what was carved with normals of its own faces."""
        if self.surface is not None:
            return self.surface
        mesh = self.manifold.to_mesh64()
        corners = np.array(mesh.vert_properties, np.float64)[:, :3][np.array(mesh.tri_verts)]
        vertices = corners.reshape(-1, 3)
        faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
        return Surface(vertices, faces, vertex_normals(vertices, faces))


def united(lumps: tuple[Lump, ...], base: Manifold | None = None) -> Manifold | None:
    """Unite solids, and a base with them; None where the result is not sound.

    Rows of those that do not touch are put side by side, which costs a copy. Fillets are small and
    cut much: united with one solid before the others are, all take two thirds of the time. A base
    is united with all at once, so that where it is cut does not depend on what else there is.
    """
    from manifold3d import Manifold, OpType

    placed = sorted(lumps, key=lambda lump: lump.place)  # whichever came first
    if base is not None:
        parts = first = [*_side_by_side(placed), base]
    else:
        fillets = _side_by_side([lump for lump in placed if isinstance(lump.held, Fillet)])
        others = _side_by_side([lump for lump in placed if not isinstance(lump.held, Fillet)])
        parts = first = fillets + others
        if fillets and others:
            begun = Manifold.batch_boolean(parts[: len(fillets) + 1], OpType.Add)
            begun.num_tri()  # united now: put off, all would be united in another order
            first = [begun, *others[1:]]
    whole = Manifold.batch_boolean(first, OpType.Add) if len(first) > 1 else first[0]
    return whole if is_union(whole, parts) else None


def _side_by_side(lumps: list[Lump]) -> list[Manifold]:
    """Return solids with as many in one as do not meet one another."""
    from manifold3d import Manifold

    rows: list[list[Lump]] = []
    for lump in lumps:
        free = (row for row in rows if not any(meet(lump.box, other.box) for other in row))
        row = next(free, None)
        if row is None:
            rows.append([lump])
        else:
            row.append(lump)
    return [
        row[0].manifold if len(row) == 1 else Manifold.compose([lump.manifold for lump in row])
        for row in rows
    ]
