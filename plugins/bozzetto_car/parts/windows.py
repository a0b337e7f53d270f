"""Insets of the body behind a gap: panes within frames, lamps, grilles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, Mesh, ParameterCurve
from bozzetto.geometry.patches import Patchwork, Places, grid, normals_at, shaded, sides_of
from bozzetto_car.parts.looks import DARK, GLASS, LAMP, TAIL, Look
from bozzetto_car.parts.trimmed_face import bezier, cubic_piece, edge_along, polyline
from bozzetto_car.template.model import MIRROR, Inset, Patch, Template

FRAME: Final = 42.0
"""Width of the frame around a pane, mm."""

WIDEST: Final = 0.3
"""Largest share of the patch that a frame takes on each side."""

LAID: Final = 1.5
"""Distance of a pane outside the body where it is only seen, mm: more than triangles of the body
differ from it."""

SET_IN: Final = 6.0
"""Depth of a pane below the body around it, mm."""

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
    at = np.linspace(0.0, 1.0, 9)
    places = grid(net[None], at, at)[0]
    box = []
    for axis, sides in ((0, (3, 1)), (1, (0, 2))):
        way = np.linalg.norm(np.diff(places, axis=axis), axis=-1).sum(axis=axis).mean()
        frame = min(FRAME / way, WIDEST)
        low, high = (0.0 if side in inner else frame for side in sides)
        box.append((low, 1.0 - high))
    name = patch.name[:-2] if inner else patch.name
    open_ = inner[0] if inner else -1
    return Window(number, f"Glass {name}", GLASS, SET_IN, np.array(box), open_)


def pane(window: Window, net: Array) -> Brep:
    """Return the pane of a window in a patch with a control net (4, 4, 3), mm."""
    own = _piece(window, net)
    return Brep.of_surface(bezier(own + _step(window, own)))


def gap(window: Window, net: Array) -> list[Brep]:
    """Return the faces that lead from the frame of a window to its pane."""
    step = _step(window, _piece(window, net))
    edges = (edge_along(bezier(net), path).control_points[::-1] for path in window.paths)
    return [Brep.of_surface(bezier(np.stack((edge, edge + step), axis=1))) for edge in edges]


def inset_meshes(template: Template, nets: Array) -> list[tuple[Mesh, Look]]:
    """Return all insets of one look as triangles for the eye, `LAID` outside the body."""
    windows = windows_of(template, nets)
    looks = dict.fromkeys(window.look for window in windows)
    return [
        (_laid([_piece(w, nets[w.patch]) for w in windows if w.look == look]), look)
        for look in looks
    ]


def _laid(right: list[Array]) -> Mesh:
    pieces = np.array([*right, *(piece.swapaxes(0, 1) * MIRROR for piece in right)])
    sides = np.arange(4 * len(pieces), dtype=np.int32).reshape(-1, 4)
    mesh = shaded(Patchwork(pieces, sides_of(pieces).reshape(-1, 4, 3), sides))
    assert mesh.normals is not None
    return replace(mesh, vertices=mesh.vertices + np.float32(LAID) * mesh.normals)


def _piece(window: Window, net: Array) -> Array:
    """Return the control net of the patch within the frame, (4, 4, 3)."""
    (u0, u1), (v0, v1) = window.box
    return cubic_piece(cubic_piece(net, u0, u1).swapaxes(0, 1), v0, v1).swapaxes(0, 1)


def _step(window: Window, piece: Array) -> Array:
    """Return the way from the frame to the pane, mm; without y for half a pane."""
    at = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, 5)]), axis=-1).reshape(-1, 2)
    inward = -normals_at(piece[None], Places(np.zeros(len(at), np.intp), at)).mean(axis=0)
    if window.open >= 0:
        inward[1] = 0.0
    return np.asarray(window.depth * inward / np.linalg.norm(inward))
