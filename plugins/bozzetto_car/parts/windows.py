"""Insets of the body: openings in it, and panes, lamps and grilles that stand in them.

An opening is a piece of a patch, sunk into the body; what stands in it is a solid of its own, free
of the body on all sides by a gap.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, Look, Mesh, ParameterCurve, sewn
from bozzetto.geometry.patches import Patchwork, Places, grid, normals_at, shaded, sides_of
from bozzetto_car.parts.looks import (
    DARK,
    GLASS,
    LAMP,
    TAIL,
    CarPart,
    left,
    looking,
    on_both_sides,
)
from bozzetto_car.parts.trimmed_face import bezier, cubic_piece, edge_along, polyline, side_of
from bozzetto_car.parts.wheel_arches import cut_panels
from bozzetto_car.template.model import MIRROR, Inset, Patch, Template
from bozzetto_car.template.network import Network

FRAME: Final = 42.0
"""Width of the frame around a pane, mm."""

WIDEST: Final = 0.3
"""Largest share of the patch that a frame takes on each side."""

LAID: Final = 1.5
"""Distance of a pane outside the body where it is only seen, mm: more than triangles of the body
differ from it."""

SET_IN: Final = 6.0
"""Depth of a pane below the body around it, mm."""

THICKNESS: Final = 4.0
"""Thickness of what stands in an opening, mm."""

CLEARANCE: Final = 1.5
"""Distance of what stands in an opening from its bed, and from its sides in the mean, mm."""

NARROWEST: Final = 0.25
"""Largest share of an opening that the clearance takes on each side."""

DEPTHS: Final = {"headlamp": 3.0, "tail lamp": 3.0, "grille": 24.0}
"""The same of other insets."""

LOOKS: Final = {"headlamp": LAMP, "tail lamp": TAIL, "grille": DARK}


@dataclass(frozen=True, eq=False)
class Window:
    """An inset in a patch of the right half; in the middle of the car it is half of one.

    Attributes
    ----------
    patch : int
    title : str
        Its name; that of the right one where there is a left one, too.
    look : Look
    depth : float
        How far it lies below the body around it, mm.
    box : (2, 2) float
        Lowest and highest u, lowest and highest v.
    open : int
        The side in the middle of the car, over which the pane runs on; -1 for none.
    """

    patch: int
    title: str
    look: Look
    depth: float
    box: Array
    open: int

    @property
    def ring(self) -> list[tuple[float, float]]:
        """The corners in u and v, clockwise, from the one where the open side begins."""
        (u0, u1), (v0, v1) = self.box.tolist()
        corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]
        first = max(self.open, 0)
        return [corners[(first - k) % 4] for k in range(5)]

    @property
    def paths(self) -> list[ParameterCurve]:
        """The sides of the hole that it needs, clockwise, without the open one."""
        return polyline(self.ring[:4] if self.open >= 0 else self.ring)

    @property
    def opening(self) -> tuple[float, float]:
        """Where the open side is cut, 0 … 1 in the sense of the patch's loop."""
        ends = np.array([self.ring[0], self.ring[3]])
        axis = self.open % 2
        along = ends[:, axis] if self.open < 2 else 1.0 - ends[:, axis]
        return float(along[0]), float(along[1])


def windows_of(template: Template, nets: Array) -> tuple[Window, ...]:
    """Return the windows of the right half, then its lamps and grilles."""
    panes = (
        _window(template, nets[number], number, patch)
        for number, patch in enumerate(template.patches)
        if patch.glass and patch.name.endswith(".R")
    )
    numbers = {patch.name: number for number, patch in enumerate(template.patches)}
    return (*panes, *(_inset(inset, numbers[inset.patch]) for inset in template.insets))


def _inset(inset: Inset, number: int) -> Window:
    (u0, u1), (v0, v1) = inset.box
    reached = (v0 == 0.0, u1 == 1.0, v1 == 1.0, u0 == 0.0)
    side = reached.index(True) if True in reached else -1
    title = inset.name.replace("_", " ").capitalize() + (".R" if side < 0 else "")
    box = np.array(inset.box)
    return Window(number, title, LOOKS[inset.kind], DEPTHS[inset.kind], box, side)


def _window(template: Template, net: Array, number: int, patch: Patch) -> Window:
    middle = set(template.centre.tolist())
    inner = [k for k in range(4) if {patch.nodes[k], patch.nodes[(k + 1) % 4]} <= middle]
    box = []
    for way, sides in zip(_sizes(net), ((3, 1), (0, 2)), strict=True):
        frame = min(FRAME / way, WIDEST)
        low, high = (0.0 if side in inner else frame for side in sides)
        box.append((low, 1.0 - high))
    name = patch.name[:-2] if inner else patch.name
    open_ = inner[0] if inner else -1
    return Window(number, f"Glass {name}", GLASS, SET_IN, np.array(box), open_)


def bed(window: Window, net: Array) -> Brep:
    """Return the bottom of an opening in a patch with a control net (4, 4, 3), mm."""
    own = _piece(window.box, net)
    return Brep.of_surface(bezier(own + _sunk(window) * _inward(window, own)))


def gap(window: Window, net: Array) -> list[Brep]:
    """Return the sides of an opening, from the panel to the bed."""
    step = _sunk(window) * _inward(window, _piece(window.box, net))
    edges = (edge_along(bezier(net), path).control_points[::-1] for path in window.paths)
    return [_wall(edge, step) for edge in edges]


def inserts(network: Network, nets: Array) -> list[CarPart]:
    """Return the panes, lamps and grilles of a car, those of both sides.

    Parameters
    ----------
    network : Network
        The car.
    nets : (k, 4, 4, 3) array_like
        Its patches, mm. A patch that a wheel arch cuts has none.
    """
    cut = cut_panels(network, nets)
    made: list[CarPart] = []
    for window in windows_of(network.template, nets):
        if window.patch in cut:
            continue
        net, name, look = nets[window.patch], _words(window.title), window.look
        half, laid = partial(_insert, window, net), _piece(window.box, net)
        if window.open >= 0:
            exact = partial(_whole, half, name, look)
            pieces = [laid, laid.swapaxes(0, 1) * MIRROR]
            made.append(CarPart(name, look, partial(_laid, pieces), exact))
        else:
            mesh, exact = partial(_laid, [laid]), partial(_sewn, half)
            made += on_both_sides(name, look, mesh, exact)
    return made


def _sewn(half: Callable[[], list[Brep]]) -> Brep:
    return sewn(half())


def _whole(half: Callable[[], list[Brep]], name: str, look: Look) -> Brep:
    """Return what stands in the middle of the car, of which a half is given."""
    right = half()
    return looking(sewn([*right, *map(left, right)]), name, look)


def _words(title: str) -> str:
    """Return the name of a part for people: `Glass glass_front.R` is a *Glass front*."""
    own = title.removesuffix(".R").replace("Glass glass_", "Glass ").replace("_glass", "")
    return own.replace("_", " ")


def _insert(window: Window, net: Array) -> list[Brep]:
    """Return the faces of what stands in an opening; not those in the middle of the car."""
    inward = _inward(window, _piece(window.box, net))
    front = _piece(_narrowed(window, net), net) + window.depth * inward
    back = THICKNESS * inward
    faces = [Brep.of_surface(bezier(front)), Brep.of_surface(bezier(front + back)).turned_over()]
    sides = (side for side in range(4) if side != window.open)
    return [*faces, *(_wall(side_of(front, side)[::-1], back) for side in sides)]


def _narrowed(window: Window, net: Array) -> Array:
    """Return the box of an opening without the clearance."""
    box = window.box.copy()
    ways = _sizes(_piece(box, net))
    reached = (window.open == 3, window.open == 1), (window.open == 0, window.open == 2)
    for axis, way in enumerate(ways):
        share = min(CLEARANCE / way, NARROWEST) * np.ptp(box[axis])
        low, high = (0.0 if is_open else share for is_open in reached[axis])
        box[axis] += (low, -high)
    return box


def _wall(edge: Array, step: Array) -> Brep:
    return Brep.of_surface(bezier(np.stack((edge, edge + step), axis=1)))


def _sunk(window: Window) -> float:
    """Return the depth of the bed of an opening, mm."""
    return window.depth + THICKNESS + CLEARANCE


def _laid(pieces: list[Array]) -> Mesh:
    """Return pieces of patches as triangles for the eye, `LAID` outside the body."""
    nets = np.array(pieces)
    sides = np.arange(4 * len(nets), dtype=np.int32).reshape(-1, 4)
    mesh = shaded(Patchwork(nets, sides_of(nets).reshape(-1, 4, 3), sides))
    assert mesh.normals is not None
    return replace(mesh, vertices=mesh.vertices + np.float32(LAID) * mesh.normals)


def _piece(box: Array, net: Array) -> Array:
    """Return the control net of the patch within a box of u and v, (4, 4, 3)."""
    (u0, u1), (v0, v1) = box
    return cubic_piece(cubic_piece(net, u0, u1).swapaxes(0, 1), v0, v1).swapaxes(0, 1)


def _sizes(net: Array) -> tuple[float, float]:
    """Return the mean lengths of a patch along u and along v, mm."""
    at = np.linspace(0.0, 1.0, 9)
    places = grid(net[None], at, at)[0]
    by_axis = (np.linalg.norm(np.diff(places, axis=k), axis=-1).sum(axis=k) for k in (0, 1))
    along_u, along_v = (float(way.mean()) for way in by_axis)
    return along_u, along_v


def _inward(window: Window, piece: Array) -> Array:
    """Return the direction into the body, of length 1; without y for what is half of one."""
    at = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, 5)]), axis=-1).reshape(-1, 2)
    inward = -normals_at(piece[None], Places(np.zeros(len(at), np.intp), at)).mean(axis=0)
    if window.open >= 0:
        inward[1] = 0.0
    return np.asarray(inward / np.linalg.norm(inward))
