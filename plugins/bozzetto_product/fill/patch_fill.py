"""Fills of patches of degree five round a centre, exact on their sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Brep, BSplineSurface, Curve, Mesh
from bozzetto.plugin import cached_property, override, remembered
from bozzetto_product.fill.domain import Domain, domain_of
from bozzetto_product.fill.exact_patches import exact_patches
from bozzetto_product.fill.fair_solution import FairSolution, fairest
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.fill_brep import brep_of
from bozzetto_product.fill.fill_mesh import mesh_of, places_and_normals
from bozzetto_product.fill.half_sides import HalfSide, Side
from bozzetto_product.fill.loop_frame import LoopSides
from bozzetto_product.fill.patch_space import space_of
from bozzetto_product.fill.quintic import DEGREE
from bozzetto_product.network.net import Loop

FOLD_GRID: Final = 9
"""Places along each direction of a patch at which folds are looked for."""

FOLD_SHARES: Final = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Places within each span at which what looks like a fold is looked at again, as shares."""


@dataclass(frozen=True, eq=False)
class PatchFill(Fill):
    """A surface of patches, one for each corner of the domain, round a centre.

    Parameters
    ----------
    loop, sides, patches, spacing, key
        See `Fill`.
    solution : FairSolution
        The linear space in which the surface was found, ``solution.space``, and where it is
        there: to change a surface, seek changes of ``solution.free`` in ``solution.space.basis``
        and make the patches anew by `exact_patches`.
    """

    solution: FairSolution

    @property
    @override
    def size(self) -> float:
        """Diagonal of the box of the loop, mm."""
        return self.solution.loop.size

    @cached_property
    @override
    def mesh(self) -> Mesh:
        """Triangles with normals; vertices on an edge are those of all fills that have it."""
        return mesh_of(self.sides, self.solution.space.domain, self.patches, self.spacing)

    @cached_property
    def spokes(self) -> tuple[Curve, ...]:
        """From the middle of each side to the centre."""
        made = []
        for patch, side in zip(self.patches, self.sides, strict=True):
            points = patch.control_points[-1].copy()
            points[0] = side.halves[0].points[-1]
            made.append(Curve(DEGREE, patch.knots_v, points))
        return tuple(made)

    @cached_property
    @override
    def brep(self) -> Brep:
        """The patches as faces; its edges are the pieces of the loop's edges, and the spokes."""
        return brep_of(self.sides, self.patches, self.spokes, "surface")

    @property
    @override
    def bent(self) -> PatchFill:
        """The surface itself."""
        return self

    @override
    def places_beside(self, half: HalfSide, number: int, at: Array) -> tuple[Array, Array]:
        """Return places of the surface beside half a side, and unit normals there; see `Fill`."""
        zero = np.zeros(len(at))
        pair = (at, zero) if half.onward else (zero, at)
        return self.patches[number].value(*pair), self.patches[number].normals(*pair)

    @cached_property
    @override
    def folded(self) -> bool:
        """Whether normals of places beside one another point to opposite sides."""
        return any(
            _turns_over(patch, ()) and _turns_over(patch, FOLD_SHARES) for patch in self.patches
        )


def _turns_over(patch: BSplineSurface, shares: Sequence[float]) -> bool:
    """Whether normals beside one another on a grid point to opposite sides.

    The grid has even places, and those at shares of the spans: a surface may turn by a right angle
    within a span, as over an edge, and is not folded.
    """
    net = [np.linspace(0.03, 0.97, FOLD_GRID)] * 2
    if shares:
        for axis, knots in enumerate((patch.knots_u, patch.knots_v)):
            spans = np.unique(knots)
            finer = spans[:-1, None] + np.diff(spans)[:, None] * np.array(shares)
            net[axis] = np.union1d(net[axis], np.clip(finer, 0.03, 0.97))
    u, v = (x.ravel() for x in np.meshgrid(*net, indexing="ij"))
    _, normals = places_and_normals(patch, np.column_stack((u, v)))
    normals = normals.reshape(len(net[0]), len(net[1]), 3)
    along = (normals[1:] * normals[:-1]).sum(axis=-1).min()
    return bool(min(along, (normals[:, 1:] * normals[:, :-1]).sum(axis=-1).min()) < 0.0)


def patch_fill(frame: LoopSides, loop: Loop, spacing: float, key: bytes) -> PatchFill:
    """Fill a loop by patches.

    Parameters
    ----------
    frame : LoopSides
        Its sides.
    loop, spacing, key
        See `Fill`.

    Raises
    ------
    UserError
        If no surface goes through its sides.
    """
    try:
        return _filled(frame, loop, spacing, key)
    except np.linalg.LinAlgError as problem:
        raise UserError("A loop cannot be surfaced. Change one of its curves.") from problem


@remembered(limit=1024, key=lambda frame, loop, spacing, key: (key, loop))
def _filled(frame: LoopSides, loop: Loop, spacing: float, key: bytes) -> PatchFill:
    solution = fairest(space_of(domain_of_sides(frame.sides)), frame)
    patches = exact_patches(solution)
    fill = PatchFill(loop, frame.sides, patches, spacing, key, solution)
    if fill.folded:
        return fill
    try:
        _ = fill.mesh
    except ValueError as problem:  # the domain of sides of very different lengths crosses itself
        raise UserError("A loop cannot be surfaced. Make its curves more alike.") from problem
    return fill


def domain_of_sides(sides: Sequence[Side]) -> Domain:
    """Return the domain of a loop of sides."""
    lengths = np.array([side.lengths for side in sides])
    enter = np.array([-side.halves[1].end_slopes[0] for side in sides])
    leave = np.array([side.halves[0].end_slopes[0] for side in sides])
    enter = np.roll(enter, 1, axis=0)
    cosine = (enter * leave).sum(axis=1)
    cosine /= np.maximum(np.linalg.norm(enter, axis=1) * np.linalg.norm(leave, axis=1), 1e-300)
    angles = np.pi - np.arccos(np.clip(cosine, -1.0, 1.0))
    return domain_of(lengths, angles, np.array([side.bend for side in sides]))
