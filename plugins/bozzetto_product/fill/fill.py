"""The surface of a loop, exact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b
from operator import itemgetter
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Brep, BSplineSurface, Curve, Mesh
from bozzetto.plugin import remembered
from bozzetto_product.fill.domain import Domain, domain_of
from bozzetto_product.fill.exact_patches import exact_patches
from bozzetto_product.fill.fair_solution import FairSolution, LoopSides, fairest
from bozzetto_product.fill.fill_brep import KNOTS, brep_of
from bozzetto_product.fill.fill_mesh import mesh_of, places_and_normals, radius_ratios
from bozzetto_product.fill.half_sides import HalfSide, Side
from bozzetto_product.fill.patch_space import space_of
from bozzetto_product.fill.quintic import DEGREE
from bozzetto_product.network.net import Loop

CHECKS: Final = 33
"""Places along half a side at which joints and deviations are measured."""

SHORTEST: Final = 1e-9
"""Least length of half a side, as a share of the longest."""

FOLD_GRID: Final = 9
"""Places along each direction of a patch at which folds are looked for."""

SEGMENTS: Final = 24
"""Segments of a mesh along the diagonal of a loop, where no spacing is given."""


@dataclass(frozen=True, eq=False)
class Fill:
    """The surface of a loop.

    Parameters
    ----------
    loop : Loop
    sides : tuple of Side
        Those of the domain.
    solution : FairSolution
        The linear space in which the surface was found, ``solution.space``, and where it is
        there: to change a surface, seek changes of ``solution.free`` in ``solution.space.basis``
        and make the patches anew by `exact_patches`.
    patches : tuple of BSplineSurface
        One for each corner of the domain, round a centre; their normals point to where the loop
        runs counter-clockwise.
    spacing : float
        Length of the segments of edges in the mesh, mm.
    key : bytes
        Of all that the surface depends on.
    """

    loop: Loop
    sides: tuple[Side, ...]
    solution: FairSolution
    patches: tuple[BSplineSurface, ...]
    spacing: float
    key: bytes

    @cached_property
    def mesh(self) -> Mesh:
        """Triangles with normals; vertices on an edge are those of all fills that have it."""
        return mesh_of(self.sides, self.solution.space.domain, self.patches, self.spacing)

    @cached_property
    def spokes(self) -> tuple[Curve, ...]:
        """From the middle of each side to the centre."""
        loop = self.solution.loop
        nets = self.solution.nets[:, -1] * loop.size + loop.origin
        made = []
        for k, side in enumerate(self.sides):
            points = nets[k].copy()
            points[0] = side.halves[0].points[-1]
            made.append(Curve(DEGREE, KNOTS, points))
        return tuple(made)

    @cached_property
    def brep(self) -> Brep:
        """The patches as faces; its edges are the pieces of the loop's edges, and the spokes."""
        return brep_of(self.sides, self.patches, self.spokes, "surface")

    @cached_property
    def g1_degrees(self) -> tuple[float, ...]:
        """Largest angle between the surface and the normals of each half edge; NaN at creases."""
        worst = np.full(len(self.loop), np.nan)
        for half, number, at in self._halves():
            normals = half.normals(at)
            if normals is None:
                continue
            patch = self.patches[number]
            pair = (at, np.zeros(len(at))) if half.onward else (np.zeros(len(at)), at)
            found = patch.normals(*pair)
            sine = np.linalg.norm(np.cross(found, normals), axis=1)
            angle = np.degrees(np.arctan2(sine, np.abs((found * normals).sum(axis=1))))
            which = np.clip(np.searchsorted(half.breaks, at, "right") - 1, 0, len(half.pieces) - 1)
            for index, piece in enumerate(half.pieces):
                most = float(angle[which == index].max(initial=0.0))
                worst[piece.half_edge] = np.fmax(worst[piece.half_edge], most)
        return tuple(worst.tolist())

    def normals_along(self, half_edge: int, count: int) -> Array:
        """Return unit normals of the surface along an edge, in the edge's own sense.

        Parameters
        ----------
        half_edge : int
            Which of the loop's.
        count : int
            Places on each piece of the edge, with both of its ends.

        Returns
        -------
        (k, 3) float
            At the same places of the edge for every fill that has it.
        """
        shares = np.linspace(0.0, 1.0, count)
        found: list[tuple[float, Array]] = []
        for half, number, _ in self._halves():
            for index, piece in enumerate(half.pieces):
                if piece.half_edge != half_edge:
                    continue
                low, high = half.breaks[index : index + 2]
                own = shares if piece.forward == half.onward else 1.0 - shares
                at, zero = low + (high - low) * own, np.zeros(count)
                pair = (at, zero) if half.onward else (zero, at)
                found.append((piece.piece.curve.range[0], self.patches[number].normals(*pair)))
        return np.concatenate([normals for _, normals in sorted(found, key=itemgetter(0))])

    @cached_property
    def deviation(self) -> float:
        """Largest distance of the patches from the edges where they meet, mm."""
        worst = 0.0
        for half, number, at in self._halves():
            pair = (at, np.zeros(len(at))) if half.onward else (np.zeros(len(at)), at)
            off = self.patches[number].value(*pair) - half.value(at)
            worst = max(worst, float(np.linalg.norm(off, axis=1).max()))
        return worst

    def _halves(self) -> list[tuple[HalfSide, int, Array]]:
        at = np.linspace(0.0, 1.0, CHECKS)
        count = len(self.sides)
        return [
            (half, (number + index) % count, at)
            for number, side in enumerate(self.sides)
            for index, half in enumerate(side.halves)
        ]

    @cached_property
    def area(self) -> float:
        """Area of the mesh, mm²."""
        corners = self.mesh.vertices.astype(np.float64)[self.mesh.faces]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return float(0.5 * np.linalg.norm(across, axis=1).sum())

    @cached_property
    def _qualities(self) -> Array:
        return radius_ratios(self.mesh)

    @property
    def quality_min(self) -> float:
        """Least radius ratio 2 r / R of the mesh's triangles."""
        return float(self._qualities.min())

    @property
    def quality_p5(self) -> float:
        """Radius ratio that 95 % of the mesh's triangles exceed."""
        return float(np.percentile(self._qualities, 5))

    @cached_property
    def folded(self) -> bool:
        """Whether normals of places beside one another point to opposite sides."""
        at = np.linspace(0.03, 0.97, FOLD_GRID)
        u, v = (x.ravel() for x in np.meshgrid(at, at, indexing="ij"))
        for patch in self.patches:
            _, normals = places_and_normals(patch, np.column_stack((u, v)))
            normals = normals.reshape(FOLD_GRID, FOLD_GRID, 3)
            along = (normals[1:] * normals[:-1]).sum(axis=-1).min()
            if min(along, (normals[:, 1:] * normals[:, :-1]).sum(axis=-1).min()) < 0.0:
                return True
        return False


def fill_loop(
    sides: Sequence[Side],
    *,
    loop: Loop = (),
    spacing: float | None = None,
) -> Fill:
    """Fill a loop.

    Parameters
    ----------
    sides : sequence of Side
        At least three, head to tail.
    loop : Loop
        What the fill is of.
    spacing : float, optional
        Length of the segments of edges in the mesh, mm.

    Raises
    ------
    UserError
        If a side of the loop has no length, or no surface goes through its sides.
    """
    lengths = [half.length for side in sides for half in side.halves]
    if not min(lengths) > SHORTEST * max(lengths):
        raise UserError("A curve of a loop has no length. Draw it longer, or delete it.")
    frame = LoopSides.of(sides)
    step = frame.size / SEGMENTS if spacing is None else spacing
    loop = loop or tuple((number, True) for number in range(len(sides)))
    try:
        return _filled(frame, loop, step, _key(frame, step))
    except np.linalg.LinAlgError as problem:
        raise UserError("A loop cannot be surfaced. Change one of its curves.") from problem


@remembered(limit=1024, key=lambda frame, loop, spacing, key: (key, loop))
def _filled(frame: LoopSides, loop: Loop, spacing: float, key: bytes) -> Fill:
    solution = fairest(space_of(domain_of_sides(frame.sides)), frame)
    fill = Fill(loop, frame.sides, solution, exact_patches(solution), spacing, key)
    try:
        _ = fill.mesh
    except ValueError as problem:  # the domain of sides of very different lengths crosses itself
        raise UserError("A loop cannot be surfaced. Make its curves more alike.") from problem
    return fill


def _key(frame: LoopSides, spacing: float) -> bytes:
    """Return what tells whether the sides of a loop are the same to the last bit."""
    made = blake2b(digest_size=16)
    made.update(repr(spacing).encode())
    made.update(frame.normals.tobytes())
    for side in frame.sides:
        for half in side.halves:
            for values in (half.points, half.knots, half.breaks):
                made.update(np.ascontiguousarray(values).tobytes())
    return made.digest()


def domain_of_sides(sides: Sequence[Side]) -> Domain:
    """Return the domain of a loop of sides."""
    lengths = np.array([side.lengths for side in sides])
    enter = np.array([-side.halves[1].end_slopes()[0] for side in sides])
    leave = np.array([side.halves[0].end_slopes()[0] for side in sides])
    enter = np.roll(enter, 1, axis=0)
    cosine = (enter * leave).sum(axis=1)
    cosine /= np.maximum(np.linalg.norm(enter, axis=1) * np.linalg.norm(leave, axis=1), 1e-300)
    angles = np.pi - np.arccos(np.clip(cosine, -1.0, 1.0))
    return domain_of(lengths, angles, np.array([side.bend for side in sides]))
