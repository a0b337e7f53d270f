"""Products for other programs: exact faces sewn together, triangles that fit, and the curves."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

from bozzetto.geometry import Brep, FaceGroup, Mesh, Shapes, Solid, Surface, counted_mesh, sewn
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.plugin import remembered
from bozzetto_product.details.shell import Shell, group_of
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.shaping.wall import NOBODY, Wall
from bozzetto_product.solve.bodies import JoinedPatches, is_closed_mesh, joined_patches
from bozzetto_product.solve.result import ProductResult, SolvedPatch


def shapes_of(state: ProductState, result: ProductResult) -> Shapes:
    """Return the surfaces and the visible curves.

    Surfaces that share edges are one part: a solid where they close, else an open surface. In it
    each patch is a group of faces with its name, and the exact form is one shell.
    """
    bodies = _bodies(result)
    solids = tuple(body for body in bodies if isinstance(body, Solid))
    surfaces = tuple(body for body in bodies if isinstance(body, Surface))
    return Shapes(solids=solids, surfaces=surfaces, curves=curves_of(state, result))


def curves_of(state: ProductState, result: ProductResult) -> tuple[ShapeCurve, ...]:
    """Return the visible curves, exact; a mirror image after its curve."""
    shown = {curve.id for curve in state.shown(Curve)}
    mirror = Reflection(state.symmetry)
    made = []
    for curve in result.curves:
        if curve.spline is None or curve.id not in shown:
            continue
        made.append(curve.spline.to_curve(curve.name, curve.color))
        if curve.mirrored:
            image = mirror.spline(curve.spline)
            made.append(image.to_curve(f"{curve.name} mirrored", curve.color))
    return tuple(made)


@remembered(limit=4, key=lambda result: result)
def _bodies(result: ProductResult) -> tuple[Solid | Surface, ...]:
    walls = {body.patches: body.wall for body in result.walls}
    made: list[Solid | Surface] = []
    for part in joined_patches(result.filled):
        wall = walls.get(part.patches)
        if wall is not None:
            made.append(Solid(wall.mesh, groups=_groups_of(part, wall)))
            continue
        closed, detailed = part.closed, _detailed(result, part.patches)
        if detailed is None:
            mesh, groups = part.mesh, part.groups
            exact = _sewn(part.patches) if result.is_exact else None
        else:
            mesh, groups, exact = detailed
            closed = closed and exact.is_closed and is_closed_mesh(mesh)
            if part.turned_over:
                mesh = replace(mesh, faces=mesh.faces[:, ::-1])
        if part.turned_over and exact is not None:
            exact = exact.turned_over()
        kind = Solid if closed else Surface
        made.append(kind(mesh, exact=exact, groups=groups))
    return tuple(made)


def _detailed(
    result: ProductResult, part: Sequence[SolvedPatch]
) -> tuple[Mesh, tuple[FaceGroup, ...], Brep] | None:
    """Return triangles, groups and exact faces of surfaces with details; None without any.

    The triangles are those of the exact faces: they share vertices along outlines.
    """
    numbers = [k for k, one in enumerate(result.filled) if any(one is other for other in part)]
    found = next((s for s in result.detailed.changed if s.owners[0].patch in numbers), None)
    if found is None:
        return None
    order = sorted(range(len(found.faces)), key=lambda k: group_of(found.owners[k]))
    shell = Shell(
        found.edges,
        tuple(found.faces[k] for k in order),
        tuple(found.owners[k] for k in order),
    )
    names, colors, finishes = [], [], []
    for owner in shell.owners:
        one = result.filled[owner.patch]
        if owner.detail < 0:
            names.append(one.name)
            colors.append(one.patch.color)
            finishes.append(one.patch.finish)
        else:
            solved = result.detailed.details[owner.detail]
            names.append(solved.name)
            colors.append(solved.detail.color or one.patch.color)
            finishes.append(solved.detail.finish)
    exact = shell.brep(names, colors)
    mesh, counts = counted_mesh(exact)
    groups: list[FaceGroup] = []
    rows = zip(shell.owners, names, colors, finishes, counts, strict=True)
    for _, row in itertools.groupby(rows, key=lambda entry: group_of(entry[0])):
        faces = list(row)
        _, name, color, finish, _ = faces[0]
        groups.append(FaceGroup(name, sum(count for *_, count in faces), color, finish))
    return mesh, tuple(groups), exact


def _groups_of(part: JoinedPatches, wall: Wall) -> tuple[FaceGroup, ...]:
    """Return the triangles of walls by the patches that they belong to."""
    made = []
    for number, own, count in wall.groups:
        if number == NOBODY:
            made.append(FaceGroup("Walls", count))
        else:
            one = part.patches[number]
            name = one.name if own else f"{one.name} wall"
            made.append(FaceGroup(name, count, one.patch.color, one.patch.finish))
    return tuple(made)


def _sewn(part: Sequence[SolvedPatch]) -> Brep:
    """Return the exact faces of patches as one shell, each face with the name of its patch."""
    breps = []
    for one in part:
        if one.fill is not None:
            color = one.patch.color
            faces = one.fill.brep.faces
            faces = tuple(replace(face, name=one.name, color=color) for face in faces)
            breps.append(replace(one.fill.brep, faces=faces))
    return sewn(breps)
