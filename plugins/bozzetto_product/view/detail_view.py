"""Scenes of details: surfaces with what is cut out of them, walls and floors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh
from bozzetto.plugin import remembered
from bozzetto.scene import SHOWN_FINISHES, Handle, Label, Lines, Paint, Shaded
from bozzetto.view import triple
from bozzetto_product.details.bodies import SolvedDetail
from bozzetto_product.details.ground import Ground, followed_outline
from bozzetto_product.details.outline_places import tangent_axes
from bozzetto_product.details.shell import Owner, Shell, face_meshes, group_of
from bozzetto_product.model.appearance import Color
from bozzetto_product.model.emblems import Emblem
from bozzetto_product.model.state import ProductState
from bozzetto_product.shaping.wall import NOBODY
from bozzetto_product.solve.result import ProductResult, WalledBody

APART: Final = 0.82
"""Lightness of a piece that a split tells apart, where no colour is given, against its patch's."""

EMBLEM_TOOL: Final = "text"
"""Id of the tool that shows the handles of a text."""

MIDDLE: Final = "text middle"
SIZED: Final = "text corner"
"""Handles of the chosen text."""

WIDTH: Final = 1.6
"""Width of an outline that is shown by itself, px."""


@remembered(limit=8, key=lambda shell: shell)
def detail_meshes(shell: Shell) -> tuple[tuple[Owner, Mesh], ...]:
    """Return the triangles of every patch that has details, and of every detail, by its owner."""
    groups: dict[tuple[int, int], list[int]] = {}
    for number, owner in enumerate(shell.owners):
        groups.setdefault(group_of(owner), []).append(number)
    meshes = face_meshes(shell)
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
    opened = frozenset().union(*(body.opened for body in result.walls))
    for owner, mesh in sorted(details, key=lambda row: row[0].detail):
        if result.detailed.details[owner.detail].detail.kind == "cut" and owner.detail in opened:
            continue  # it ends in the walls, which show it
        detail = result.detailed.details[owner.detail].detail
        color = detail.color or _apart(colors[owner.patch])
        finish, opacity = SHOWN_FINISHES[detail.finish]
        yield Shaded(mesh, color=color, opacity=opacity, finish=finish)


def wall_meshes(body: WalledBody, result: ProductResult) -> Iterator[Mesh]:
    """Yield the far side of walls with their rims, and the sides of what is cut through them."""
    if body.wall is None:
        return
    yield body.wall.offset
    details = result.detailed.details
    shown = [
        number != NOBODY
        and own
        and body.owners[number].made
        and details[body.owners[number].detail].detail.kind == "cut"
        for number, own, _ in body.wall.groups
    ]
    if any(shown):
        counts = [count for *_, count in body.wall.groups]
        yield Mesh(body.wall.mesh.vertices, body.wall.mesh.faces[np.repeat(shown, counts)])


EMPTY: Final = Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
"""Of a surface that is wholly cut out."""


def _plain(result: ProductResult, shell: Shell) -> Shell:
    number = result.detailed.shells.index(shell)
    return result.detailed.plain[number]


def _apart(color: Color) -> Color:
    red, green, blue = (round(APART * part) for part in color)
    return red, green, blue


def chosen_outline(result: ProductResult, selected: str) -> Iterator[Lines]:
    """Yield the outline of the chosen detail."""
    for one in result.detailed.details:
        if one.detail.id == selected and one.outlines:
            yield _outline(one, "accent", WIDTH + 1.0)


def problem_outlines(result: ProductResult) -> Iterator[Lines | Label]:
    """Yield the outlines of details that are not carved, which say why."""
    for one in result.detailed.details:
        if one.outlines and one.problem:
            outline = _outline(one, "warning", WIDTH)
            yield outline
            topmost = outline.points[int(np.argmax(outline.points[:, 2]))]
            yield Label(triple(topmost), one.problem.split(". ")[0].rstrip("."), "warning")


def _outline(one: SolvedDetail, color: Paint, width: float) -> Lines:
    points = np.concatenate(one.outlines).astype(np.float32)
    starts = np.cumsum([0, *(len(row) for row in one.outlines[:-1])]).astype(np.int32)
    return Lines(points, starts, color=color, width=width)


def emblem_handles(state: ProductState, result: ProductResult) -> Iterator[Handle]:
    """Yield the handles of the chosen text: its middle, and a corner that turns and sizes it."""
    emblem = state.chosen_of(Emblem)
    grounds = result.detailed.grounds
    if emblem is None or emblem.places is None or not grounds:
        return
    followed = followed_outline(grounds, emblem.places)
    corner = emblem_corner(emblem, grounds)
    if followed is None or corner is None:
        return
    yield Handle(MIDDLE, triple(followed.points[0]), tip="Move the text")
    yield Handle(SIZED, triple(corner), "second", tip="Turn and size")


def emblem_corner(emblem: Emblem, grounds: Sequence[Ground]) -> Array | None:
    """Return the lower right corner of a text in its tangent plane, (3,) mm; None without one."""
    flat = emblem.flat
    followed = None if emblem.places is None else followed_outline(grounds, emblem.places)
    if followed is None or flat is None or not len(flat.starts):
        return None
    at, above = followed.points[:2]
    middle, (x, y, _) = tangent_axes(at, above - at, grounds)
    extent = np.ptp(flat.points, axis=0)
    half = 0.5 * emblem.height * extent / (1.0 if flat.text else extent[1])
    turn = np.radians(emblem.turn)
    across = np.cos(turn) * x + np.sin(turn) * y
    upright = np.cos(turn) * y - np.sin(turn) * x
    return np.asarray(middle + half[0] * across - half[1] * upright)
