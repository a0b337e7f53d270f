"""Exact shapes as triangles, for formats and modelers that know no others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING

from bozzetto.geometry.brep.tessellation import counted_mesh
from bozzetto.geometry.look import Look
from bozzetto.geometry.patches.tessellation import counted_patches
from bozzetto.geometry.shapes import FaceGroup, Shapes, Solid, Surface

if TYPE_CHECKING:
    from bozzetto.geometry.brep.brep import Brep
    from bozzetto.geometry.patches.patchwork import Patchwork


def meshed(shapes: Shapes) -> Shapes:
    """Return shapes with triangles in the place of all exact surfaces; curves stay.

    Breps that are closed become solids, all others surfaces. Rows of faces with names or looks
    of their own become groups, and so do patches with names.
    """
    skins = tuple(_surface(patchwork) for patchwork in shapes.patchworks)
    solids: list[Solid] = []
    surfaces: list[Surface] = []
    for brep in shapes.breps:
        mesh, counts = counted_mesh(brep)
        groups = _groups(brep, counts)
        if brep.is_closed:
            solids.append(Solid(mesh, brep.name, brep.color, groups=groups))
        else:
            surfaces.append(Surface(mesh, brep.name, brep.color, groups))
    return replace(
        shapes,
        solids=(*shapes.solids, *solids),
        surfaces=(*shapes.surfaces, *skins, *surfaces),
        patchworks=(),
        breps=(),
    )


def _surface(patchwork: Patchwork) -> Surface:
    """Return triangles of patches, with a group for each row of patches of one name and look."""
    mesh, counts = counted_patches(patchwork)
    names, looks = patchwork.patch_names, patchwork.patch_looks
    rows = []
    if names or looks:
        names, looks = names or ("",) * len(counts), looks or (Look(),) * len(counts)
        rows = list(zip(zip(names, looks, strict=True), counts, strict=True))
    groups = tuple(
        FaceGroup(name, sum(count for _, count in row), *look)
        for (name, look), row in groupby(rows, itemgetter(0))
    )
    return Surface(mesh, patchwork.name, patchwork.color, groups)


def _groups(brep: Brep, counts: Sequence[int]) -> tuple[FaceGroup, ...]:
    """Return a group for every row of faces of one name and look; none where all are plain."""
    looks = [(f.name or brep.name, Look(f.color, f.finish, f.material)) for f in brep.faces]
    if set(looks) == {(brep.name, Look())}:
        return ()
    return tuple(
        FaceGroup(name, sum(count for _, count in row), *look)
        for (name, look), row in groupby(zip(looks, counts, strict=True), itemgetter(0))
    )
