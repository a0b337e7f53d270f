"""Validation of shapes: only what other programs can use passes."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Final, get_args

from bozzetto.geometry.brep.brep import Brep, Face
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.look import Look
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.geometry.shapes import Curve, FaceGroup, Finish, Shapes, Skeleton, Solid, Surface
from bozzetto.plugin.guard.checked_values import (
    Unsound,
    check_finite,
    check_mesh,
    check_words,
    expect,
    expect_tuple,
)

MOST_PARTS: Final = 20_000
"""Parts that one model hands over."""


def sound_shapes(shapes: Any) -> Shapes:
    """Return the shapes if other programs can use them.

    Raises
    ------
    Unsound
        If a part is of a wrong type, not finite, or there are too many.
    """
    if type(shapes) is not Shapes:
        raise Unsound(f"{type(shapes).__name__} where Shapes belong")
    count = 0
    kinds = (Solid, Surface, Curve, Skeleton, Patchwork, Brep)
    for entry, kind in zip(fields(Shapes), kinds, strict=True):
        parts = getattr(shapes, entry.name)
        expect_tuple(parts, f"Shapes.{entry.name}")
        count += len(parts)
        for part in parts:
            if type(part) is not kind:
                raise Unsound(f"{type(part).__name__} among Shapes.{entry.name}")
            _check_part(part)
    if count > MOST_PARTS:
        raise Unsound(f"{count} parts; at most {MOST_PARTS} can be handed over")
    return shapes


def _check_part(part: Any) -> None:
    check_words(part.name, "the name of a part")
    if not isinstance(part, Skeleton):
        _check_color(part.color, "a part")
    if isinstance(part, Solid | Surface):
        check_mesh(part.mesh)
        expect_tuple(part.groups, "the groups of a part")
        for group in part.groups:
            expect(type(group) is FaceGroup, "a group of triangles")
            check_words(group.name, "the name of a group of triangles")
            check_words(group.material, "the material of a group of triangles")
            expect(group.finish in get_args(Finish), "the finish of a group of triangles")
            _check_color(group.color, "a group of triangles")
        if part.exact is not None:
            expect(type(part.exact) is Brep, "the exact form of a part")
            _brep(part.exact)
    elif isinstance(part, Curve):
        _curve(part, "a curve")
    elif isinstance(part, Patchwork):
        check_finite(part.nets, "the control points of a patchwork")
        check_finite(part.edges, "the edges of a patchwork")
        expect(all(isinstance(n, str) for n in part.patch_names), "the names of patches")
        for look in part.patch_looks:
            expect(type(look) is Look, "the look of a patch")
            check_words(look.material, "the material of a patch")
            expect(look.finish in get_args(Finish), "the finish of a patch")
            _check_color(look.color, "a patch")
    elif isinstance(part, Brep):
        _brep(part)
    else:
        check_finite(part.joints, "the joints of a skeleton")
        check_finite(part.radii, "the radii of a skeleton")
        count = len(part.joints)
        fits = part.bones.size == 0 or (part.bones.min() >= 0 and part.bones.max() < count)
        expect(len(part.radii) == count and bool(fits), "a skeleton")


def _check_color(color: Any, what: str) -> None:
    channels = color is None or (isinstance(color, tuple) and len(color) == 3)
    expect(channels, f"the colour of {what}")
    expect(all(isinstance(c, int) and 0 <= c <= 255 for c in color or ()), f"the colour of {what}")


def _curve(part: Any, what: str) -> None:
    check_finite(part.knots, f"the knots of {what}")
    check_finite(part.control_points, f"the control points of {what}")
    if part.weights is not None:
        check_finite(part.weights, f"the weights of {what}")


def _brep(part: Brep) -> None:
    """Check what a frozen brep could be given all the same; it has checked itself when made."""
    expect_tuple(part.edges, "Brep.edges")
    expect_tuple(part.faces, "Brep.faces")
    for edge in part.edges:
        expect(type(edge) is Curve, "an edge of a brep")
        _curve(edge, "an edge")
    for face in part.faces:
        expect(type(face) is Face, "a face of a brep")
        check_words(face.name, "the name of a face")
        check_words(face.material, "the material of a face")
        expect(face.finish in get_args(Finish), "the finish of a face")
        _check_color(face.color, "a face")
        surface = face.surface
        expect(type(surface) is BSplineSurface, "the surface of a face")
        check_finite(surface.control_points, "the control points of a surface")
        if surface.weights is not None:
            check_finite(surface.weights, "the weights of a surface")
