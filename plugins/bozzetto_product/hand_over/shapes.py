"""Products for other programs: exact faces sewn together, triangles that fit, and the curves."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

from bozzetto.geometry import (
    Brep,
    CornerNormals,
    FaceGroup,
    GapError,
    Mesh,
    Shapes,
    Solid,
    Surface,
    counted_mesh,
    sewn,
    shaded_faces,
)
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.plugin import remembered
from bozzetto_product.details.shell import Owner, Shell, group_of
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.shaping.wall import NOBODY, Wall
from bozzetto_product.solve.bodies import is_closed_mesh, joined_patches
from bozzetto_product.solve.result import ProductResult, SolvedPatch, WalledBody


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
    walls = {body.patches: body for body in result.walls}
    made: list[Solid | Surface] = []
    for part in joined_patches(result.filled):
        body = walls.get(part.patches)
        if body is not None and body.wall is not None:
            made.append(Solid(body.wall.mesh, groups=_groups_of(result, body, body.wall)))
            continue
        closed, detailed = part.closed, _detailed(result, part.patches)
        if detailed is None:
            mesh, groups, normals = part.mesh, part.groups, part.normals
            exact = _sewn(part.patches) if result.is_exact else None
        else:
            mesh, groups, normals, exact = detailed
            closed = closed and exact.is_closed and is_closed_mesh(mesh)
            if part.turned_over:
                mesh, normals = replace(mesh, faces=mesh.faces[:, ::-1]), normals.turned_over()
        if part.turned_over and exact is not None:
            exact = exact.turned_over()
        kind = Solid if closed else Surface
        made.append(kind(mesh, exact=exact, groups=groups, normals=normals))
    return tuple(made)


def _detailed(
    result: ProductResult, part: Sequence[SolvedPatch]
) -> tuple[Mesh, tuple[FaceGroup, ...], CornerNormals, Brep] | None:
    """Return triangles, groups, normals and exact faces of surfaces with details; else None.

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
    looks = [_look_of(result, owner) for owner in shell.owners]
    names, colors = [look.name for look in looks], [look.color for look in looks]
    exact = shell.brep(names, colors)
    mesh, counts = counted_mesh(exact)
    groups: list[FaceGroup] = []
    rows = zip(shell.owners, looks, counts, strict=True)
    for _, row in itertools.groupby(rows, key=lambda entry: group_of(entry[0])):
        faces = list(row)
        groups.append(replace(faces[0][1], count=sum(count for *_, count in faces)))
    return mesh, tuple(groups), CornerNormals.of_meshes(shaded_faces(exact)), exact


def _look_of(result: ProductResult, owner: Owner) -> FaceGroup:
    """Return name, colour and finish of a face, as a group without triangles."""
    one = result.filled[owner.patch]
    if owner.detail < 0:
        return FaceGroup(one.name, 0, one.patch.color, one.patch.finish)
    solved = result.detailed.details[owner.detail]
    color = solved.detail.color or one.patch.color
    return FaceGroup(solved.name, 0, color, solved.detail.finish)


def _groups_of(result: ProductResult, body: WalledBody, wall: Wall) -> tuple[FaceGroup, ...]:
    """Return the triangles of walls by the patches and details that they belong to."""
    rows = []
    for number, own, count in wall.groups:
        if number == NOBODY:
            rows.append(FaceGroup("Walls", count))
        else:
            look = _look_of(result, body.owners[number])
            name = look.name if own else f"{look.name} wall"
            rows.append(replace(look, name=name, count=count))
    made = []
    for look, row in itertools.groupby(rows, key=lambda group: replace(group, count=0)):
        made.append(replace(look, count=sum(group.count for group in row)))
    return tuple(made)


def _sewn(part: Sequence[SolvedPatch]) -> Brep | None:
    """Return the exact faces of patches as one shell, each face with the name of its patch.

    None where a surface misses its own edges by more than exact shapes allow: a sliver a thousand
    times as long as wide.
    """
    try:
        return _exact(part)
    except GapError:
        return None


def _exact(part: Sequence[SolvedPatch]) -> Brep:
    breps = []
    for one in part:
        if one.fill is not None:
            color = one.patch.color
            faces = one.fill.brep.faces
            faces = tuple(replace(face, name=one.name, color=color) for face in faces)
            breps.append(replace(one.fill.brep, faces=faces))
    return sewn(breps)
