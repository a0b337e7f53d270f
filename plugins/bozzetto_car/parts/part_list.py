"""The one list of a car's parts, of which the view, renders and every file are made."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, Look, Mesh, Patchwork
from bozzetto.geometry.patches import shaded
from bozzetto.plugin import remembered
from bozzetto_car.body.body import Body
from bozzetto_car.body.wheels import on_tyres
from bozzetto_car.parts.body_lines import body_lines
from bozzetto_car.parts.closed_body import closed_body
from bozzetto_car.parts.looks import GLASS, PAINT, CarPart
from bozzetto_car.parts.trim import shut_lines, trim_of
from bozzetto_car.parts.wheel_arches import cut_panels
from bozzetto_car.parts.wheels import wheels_of
from bozzetto_car.parts.windows import inserts
from bozzetto_car.state import CarState

DIVISIONS: Final = 12
"""Steps along each side of a patch in the mesh that is shown."""

REMEMBERED: Final = 16
"""Number of bodies whose meshes are remembered."""

EXACT: Final = 2
"""Number of bodies whose exact parts are: triangles for files are kept with them, and take longer
than the parts."""


@remembered(
    limit=EXACT,
    key=lambda state, body: (body, state.wheels, state.tyre, state.complete and state.body),
)
def wheel_parts(state: CarState, body: Body) -> Sequence[CarPart]:
    """Return the wheels; none where they are hidden. Those of a complete car stand in arches."""
    if not state.wheels:
        return ()
    network = on_tyres(body.network, state.tyre)
    return wheels_of(network, body.nets, state.tyre, sunk=state.complete and state.body)


@remembered(
    limit=EXACT,
    key=lambda state, body: (body, state.mirrors, state.tyre, state.complete and state.body),
)
def added_parts(state: CarState, body: Body) -> Sequence[CarPart]:
    """Return what a complete car has besides its body and its wheels."""
    if not (state.complete and state.body):
        return ()
    network = on_tyres(body.network, state.tyre)
    trim = trim_of(network, body.nets, with_mirrors=state.mirrors)
    return [*inserts(network, body.nets), *trim]


def added_lines(state: CarState, body: Body) -> Iterator[tuple[str, Array]]:
    """Yield the lines of a complete car by name, as Bézier points (4, 3) on its surface, mm."""
    if not (state.complete and state.body):
        return iter(())
    network, nets = on_tyres(body.network, state.tyre), body.nets
    return chain(shut_lines(network, nets), body_lines(network, nets, cut_panels(network, nets)))


# -- the body --------------------------------------------------------------------------------------


def panel_looks(state: CarState, body: Body) -> tuple[Look, ...]:
    """Return the look of each patch: of glass, where no pane stands in it, or painted."""
    painted = state.complete
    return tuple(GLASS if p.glass and not painted else PAINT for p in body.template.patches)


@remembered(limit=EXACT, key=lambda state, body: (body, state.complete, state.tyre))
def exact_body(state: CarState, body: Body) -> Brep | Patchwork:
    """Return the body as it is handed over: closed if the car is complete, else its surfaces.

    Raises
    ------
    UserError
        If a complete body cannot be closed.
    """
    if state.complete:
        return closed_body(on_tyres(body.network, state.tyre), body.nets)
    return replace(body.patchwork, patch_looks=panel_looks(state, body))


def seen_body(state: CarState, body: Body) -> Iterator[tuple[Mesh, Look]]:
    """Yield the body as triangles for the eye, all panels of one look together."""
    looks = panel_looks(state, body)
    for look in dict.fromkeys(looks):
        yield panels_mesh(body, tuple(own == look for own in looks)), look


@remembered(limit=REMEMBERED)
def panels_mesh(body: Body, chosen: tuple[bool, ...]) -> Mesh:
    """Return the triangles of some patches, which are the same over a drawing and beside it."""
    whole = whole_mesh(body)
    if all(chosen):
        return whole
    assert whole.normals is not None
    flags = np.array(chosen)
    each = len(whole.vertices) // len(flags)
    faces = whole.faces[: len(whole.faces) // len(flags)]
    vertices, normals = (
        rows.reshape(len(flags), each, 3)[flags].reshape(-1, 3)
        for rows in (whole.vertices, whole.normals)
    )
    starts = each * np.arange(int(flags.sum()), dtype=np.int32)
    return Mesh(vertices, (faces + starts[:, None, None]).reshape(-1, 3), normals)


@remembered(limit=REMEMBERED)
def whole_mesh(body: Body) -> Mesh:
    """Return the triangles of all patches."""
    return shaded(body.patchwork, DIVISIONS)


# -- parts for the eye -----------------------------------------------------------------------------


def seen_parts(parts: Iterable[CarPart]) -> Iterator[tuple[Mesh, Look]]:
    """Yield parts as triangles for the eye, all of one look together: a view draws them as one."""
    rows: dict[Look, list[Mesh]] = {}
    for part in parts:
        rows.setdefault(part.look, []).append(part.mesh())
    for look, meshes in rows.items():
        yield _joined(meshes), look


def _joined(meshes: list[Mesh]) -> Mesh:
    """Return meshes together; all have normals, and all or none have colours."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(faces).astype(np.int32),
        np.concatenate([mesh.vertex_normals() for mesh in meshes]),
        _colors(meshes),
    )


def _colors(meshes: list[Mesh]) -> NDArray[np.uint8] | None:
    colors = [mesh.colors for mesh in meshes if mesh.colors is not None]
    return np.concatenate(colors) if colors else None
