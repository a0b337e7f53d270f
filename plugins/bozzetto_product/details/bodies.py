"""Bodies with details: all that are visible, one after another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import sewn
from bozzetto.plugin import remembered
from bozzetto.scene import Hits, Layer, Scene, Shaded, cast_rays
from bozzetto.view import Rays
from bozzetto_product.details.carve import carved, parted
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.course import CROSSES
from bozzetto_product.details.emblem_places import LOST, hanging_outlines
from bozzetto_product.details.floor_places import LaidFloor, on_floors
from bozzetto_product.details.form import Form, Near
from bozzetto_product.details.ground import (
    Ground,
)
from bozzetto_product.details.inset_rings import Thickness
from bozzetto_product.details.outline_regions import (
    enclosing_first,
    followed_places,
    laid_outlines,
    outline_of,
)
from bozzetto_product.details.region import faces_over
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.shell import Owner, Shell
from bozzetto_product.model.details import Detail
from bozzetto_product.model.emblems import Emblem
from bozzetto_product.model.planes import Plane
from bozzetto_product.projection.planes import mirror_image

BEHIND: Final = 1e-4
"""Share of the size behind a surface from which on its far side is sought."""

THIN: Final = 1e-7
"""Share of the size by which rays go on behind a triangle."""

LAYERS: Final = 4
"""Triangles in front of the far side that a ray may meet: those of the surface's own side, for
triangles lie a little beside a surface."""


OFF: Final = "The outline is on no surface. Draw it on a surface."
UNDRAWN: Final = "it has no outline. Draw it with the tool “Detail”."
ASIDE: Final = "a surface under it is gone; it lies on those beside it."
OPEN: Final = (
    "its outline is open, so it only splits the surface. Draw a closed round to press it in, "
    "raise it or cut it out."
)


@dataclass(frozen=True, eq=False)
class SolvedDetail:
    """A detail of the recipe, or its mirror image.

    Parameters
    ----------
    detail : Detail
    mirrored : bool
        It is the mirror image.
    outlines : tuple of (n, 3) float
        Polylines on the surface, mm.
    problem : str
        Why it is not carved, for a person; "" where it is.
    told : str
        What a person must know of it besides.
    deviation : float
        Largest distance of its floor from the true offset, mm.
    """

    detail: Detail
    mirrored: bool
    outlines: tuple[Array, ...] = ()
    problem: str = ""
    told: str = ""
    deviation: float = 0.0

    @property
    def name(self) -> str:
        """Name for people and files."""
        return f"{self.detail.name} mirrored" if self.mirrored else self.detail.name


@dataclass(frozen=True, eq=False)
class DetailedBodies:
    """Surfaces with details.

    Parameters
    ----------
    shells : tuple of Shell
        Of surfaces that hang together; their owners count grounds and `details`.
    details : tuple of SolvedDetail
    plain : tuple of Shell
        The same surfaces without details.
    grounds : tuple of Ground
        What they lie on.
    floors : tuple of LaidFloor
        Those of the details, as they were made.
    """

    shells: tuple[Shell, ...] = ()
    details: tuple[SolvedDetail, ...] = ()
    plain: tuple[Shell, ...] = ()
    grounds: tuple[Ground, ...] = ()
    floors: tuple[LaidFloor, ...] = ()

    def number_of(self, detail: Detail, mirrored: bool) -> int:
        """Return the number of a detail, or of its mirror image."""
        rows = ((one.detail, one.mirrored) for one in self.details)
        return next(k for k, row in enumerate(rows) if row == (detail, mirrored))

    @property
    def changed(self) -> tuple[Shell, ...]:
        """The shells that have details."""
        pairs = zip(self.shells, self.plain, strict=True)
        return tuple(shell for shell, plain in pairs if shell is not plain)


def detailed_bodies(
    grounds: Sequence[Ground],
    details: Sequence[Detail],
    symmetry: Plane,
    checkpoint: Callable[[], None] = lambda: None,
) -> DetailedBodies:
    """Return bodies with details carved in their order; a mirror image after its detail.

    What has a floor comes before what it encloses, which then lies on that floor. What cannot be
    carved is left as it is and told by its `SolvedDetail.problem`.
    """
    made = _plain_bodies(tuple(grounds))
    for detail in enclosing_first(tuple(grounds), details):
        for mirrored in (False, True) if detail.mirrored else (False,):
            checkpoint()
            made = _with_detail(made, tuple(grounds), detail, mirrored, symmetry)
    return made


@remembered(limit=4, key=lambda grounds: tuple((g.patch, g.mirrored, g.fill.key) for g in grounds))
def _plain_bodies(grounds: tuple[Ground, ...]) -> DetailedBodies:
    """Return the bodies without details: what those with details are remembered by."""
    plain = _shells(grounds)
    return DetailedBodies(plain, plain=plain, grounds=grounds)


@remembered(limit=4, key=lambda grounds: tuple(g.fill.key for g in grounds))
def _shells(grounds: tuple[Ground, ...]) -> tuple[Shell, ...]:
    if not grounds:
        return ()
    whole = sewn([one.fill.brep for one in grounds])
    owners = [Owner(k) for k, one in enumerate(grounds) for _ in one.fill.patches]
    return tuple(
        Shell(
            whole.edges,
            tuple(whole.faces[k] for k in piece.tolist()),
            tuple(owners[k] for k in piece.tolist()),
        )
        for piece in whole.pieces
    )


@remembered(
    limit=64,
    key=lambda made, grounds, detail, mirrored, symmetry: (
        made,
        detail,
        mirrored,
        symmetry,
        tuple((g.patch, g.mirrored, g.fill.key) for g in grounds),
    ),
)
def _with_detail(
    made: DetailedBodies,
    grounds: tuple[Ground, ...],
    detail: Detail,
    mirrored: bool,
    symmetry: Plane,
) -> DetailedBodies:
    number = len(made.details)
    if detail.places is None:
        row = SolvedDetail(detail, mirrored, problem=UNDRAWN)
        return replace(made, details=(*made.details, row))
    plane = symmetry if mirrored else None
    try:
        places = outline_of(detail, grounds)
    except UserError as error:
        rows = hanging_outlines(detail, grounds) if isinstance(detail, Emblem) else []
        seen = tuple(mirror_image(row, symmetry) if mirrored else row for row in rows)
        return replace(
            made, details=(*made.details, SolvedDetail(detail, mirrored, seen, str(error)))
        )
    followed = followed_places(grounds, places, plane)
    if followed is None:
        row = SolvedDetail(detail, mirrored, problem=LOST)
        return replace(made, details=(*made.details, row))
    *_, lower = on_floors(made.floors, followed.points, followed.normals, places.starts.tolist())
    laid = laid_outlines(followed, lower, places, detail.closed)
    told = ASIDE if laid.lost else ""
    if isinstance(detail, Emblem) and detail.flat is not None and detail.flat.missing:
        told = f"there are no letters for “{detail.flat.missing}”; it is written without."
    if not detail.closed and detail.kind != "split":
        told = OPEN
    solved = SolvedDetail(detail, mirrored, laid.outlines, laid.problem, told)
    shells, floors = list(made.shells), list[LaidFloor]()
    try:
        form = Form(detail.kind, detail.depth, float(np.radians(detail.draft)), detail.gap)
        for region in laid.regions:
            chart, near = laid.chart, laid.near
            assert chart is not None
            assert near is not None
            which = _shell_under(shells, chart, region[0], near)
            if which < 0:
                under = _shell_under(made.plain, chart, region[0], near)
                raise UserError(OFF if under < 0 else CROSSES)
            if detail.closed:
                done = carved(shells[which], chart, region, near, form, _thickness(grounds), number)
            else:
                done = parted(shells[which], chart, region[0], near, number)
            shells[which] = done.shell
            floors += done.floors
    except UserError as error:
        return replace(made, details=(*made.details, replace(solved, problem=str(error))))
    row = replace(solved, deviation=max((f.floor.deviation for f in floors), default=0.0))
    return replace(
        made,
        shells=tuple(shells),
        details=(*made.details, row),
        floors=(*made.floors, *floors),
    )


def _shell_under(shells: Sequence[Shell], chart: Chart, ring: Ring, near: Near) -> int:
    """Return the number of the shell that an outline lies on; −1 where there is none."""
    place = ring.value(np.array([0.0 if ring.closed else 0.5 * ring.end]))[0]
    point = near(place)
    best, found = np.inf, -1
    for number, shell in enumerate(shells):
        for _, where in faces_over(shell, chart, place, 1.0):
            gap = float(np.linalg.norm(where - point))
            if gap < best:
                best, found = gap, number
    return found


def _outward(grounds: Sequence[Ground], hits: Hits) -> Array:
    """Return outward normals of triangles that rays hit, (n, 3); 0 where they hit none."""
    made = np.zeros((len(hits.hit), 3))
    for number, surface in enumerate(hits.surfaces):
        rows = hits.hit & (hits.on == number)
        mesh = grounds[surface.number].fill.mesh
        a, b, c = mesh.vertices.astype(float)[mesh.faces[hits.faces[rows]]].transpose(1, 0, 2)
        made[rows] = cross_product(b - a, c - a)
    return made


@remembered(limit=4, key=lambda grounds: tuple(g.fill.key for g in grounds))
def _thickness(grounds: tuple[Ground, ...]) -> Thickness:
    """Return what measures bodies behind points of their surface."""
    scene = Scene((Layer("surfaces", tuple(Shaded(g.fill.mesh) for g in grounds)),))
    size = max(float(np.linalg.norm(np.ptp(g.fill.mesh.bounds, axis=0))) for g in grounds)

    def thickness(points: Array, normals: Array) -> Array:
        if not len(points):
            return np.empty(0)
        depth = np.full(len(points), BEHIND * size)
        going = np.arange(len(points))
        for _ in range(LAYERS):
            starts = points[going] - depth[going, None] * normals[going]
            hits = cast_rays(scene, Rays(starts, -normals[going]))
            depth[going] += np.where(hits.hit, hits.distance, np.inf)
            entered = hits.hit & ((_outward(grounds, hits) * normals[going]).sum(axis=1) > 0.0)
            going = going[entered]
            depth[going] += THIN * size
            if not len(going):
                break
        return depth

    return thickness
