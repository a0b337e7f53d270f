"""What is shown of details: surfaces with what is cut out of them, walls and floors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from bozzetto.geometry import Mesh, shaded_faces
from bozzetto.plugin import remembered
from bozzetto.scene import Lines, Shaded
from bozzetto_product.details.shell import Owner, Shell, group_of
from bozzetto_product.model.appearance import Color
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.view.colors import SHOWN_FINISHES

COARSE: Final = 2e-4
"""Distance of triangles from the surface, as share of the size of the whole."""

APART: Final = 0.82
"""Lightness of a piece that a split tells apart, where no colour is given, against its patch's."""

WIDTH: Final = 1.6
"""Width of an outline that is shown by itself, px."""


@remembered(limit=8, key=lambda shell: shell)
def detail_meshes(shell: Shell) -> tuple[tuple[Owner, Mesh], ...]:
    """Return the triangles of every patch that has details, and of every detail, by its owner."""
    count = len(shell.faces)
    brep = shell.brep([""] * count, [None] * count)
    groups: dict[tuple[int, int], list[int]] = {}
    for number, owner in enumerate(shell.owners):
        groups.setdefault(group_of(owner), []).append(number)
    meshes = shaded_faces(brep, COARSE * shell.size)
    return tuple(
        (shell.owners[rows[0]], _joined([meshes[k] for k in rows])) for rows in groups.values()
    )


def _joined(meshes: Sequence[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(
            [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
        ).astype(np.int32),
        np.concatenate([mesh.vertex_normals() for mesh in meshes]),
    )


def surface_items(result: ProductResult, colors: Sequence[Color]) -> Iterator[Shaded]:
    """Yield the surfaces in the order of their patches, then details in theirs."""
    changed = {}
    details = []
    for shell in result.detailed.changed:
        for owner, mesh in detail_meshes(shell):
            if owner.detail < 0:
                changed[owner.patch] = mesh
            else:
                details.append((owner, mesh))
    gone = {
        owner.patch for shell in result.detailed.changed for owner in _plain(result, shell).owners
    }
    for number, (one, color) in enumerate(zip(result.filled, colors, strict=True)):
        assert one.mesh is not None
        mesh = changed.get(number, EMPTY if number in gone else one.mesh)
        finish, opacity = SHOWN_FINISHES[one.patch.finish]
        yield Shaded(mesh, color=color, opacity=opacity, finish=finish)
    for owner, mesh in sorted(details, key=lambda row: row[0].detail):
        detail = result.detailed.details[owner.detail].detail
        color = detail.color or _apart(colors[owner.patch])
        finish, opacity = SHOWN_FINISHES[detail.finish]
        yield Shaded(mesh, color=color, opacity=opacity, finish=finish)


EMPTY: Final = Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
"""Of a surface that is wholly cut out."""


def _plain(result: ProductResult, shell: Shell) -> Shell:
    number = result.detailed.shells.index(shell)
    return result.detailed.plain[number]


def _apart(color: Color) -> Color:
    red, green, blue = (round(APART * part) for part in color)
    return red, green, blue


def outline_lines(result: ProductResult, selected: str) -> Iterator[Lines]:
    """Yield the outlines of the chosen detail, and of those that could not be carved."""
    for one in result.detailed.details:
        chosen = one.detail.id == selected
        if not one.outlines or not (chosen or one.problem):
            continue
        points = np.concatenate(one.outlines).astype(np.float32)
        starts = np.cumsum([0, *(len(row) for row in one.outlines[:-1])]).astype(np.int32)
        color = "warning" if one.problem else "accent"
        yield Lines(points, starts, color=color, width=WIDTH + chosen)
