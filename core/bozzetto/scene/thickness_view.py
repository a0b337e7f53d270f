"""Thickness shown in colours: how much material lies under each place of a closed solid.

From every vertex a ray goes straight in, to where it leaves the solid again. Flat surfaces of few
triangles are parted into more, so that what lies behind them shows, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.geometry.bvh import first_hits, tree_of
from bozzetto.geometry.mesh import Mesh
from bozzetto.scene.display_list import Label, Layer, Points, Scene, Shaded
from bozzetto.scene.renderer.normals import corner_normals
from bozzetto.scene.wall_thickness import INSIDE, Walls, walls_of

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Floats, Index
    from bozzetto.scene.palette import Palette

THIN: Final = 0.5
"""Thickness at the thin end of the scale, mm: a wall of one line of most printers."""

MIDDLE: Final = 2.0
"""Thickness in its middle, mm: a usual wall of a housing."""

THICK: Final = 8.0
"""Thickness at its thick end, mm: cast material sinks there."""

SEEN: Final = 0.1
"""Least opacity of what counts as a surface of the solid; less helps drawing only."""

FINENESS: Final = 1.0 / 40.0
"""Longest edge of the parted triangles, as a share of the size."""

MOST_ROUNDS: Final = 7
"""Times that edges are halved at most."""

RAYS_AT_ONCE: Final = 2_000
"""Rays between two looks whether the work is still wanted."""

MOST_RAYS: Final = 20_000
"""Vertices of an item from which rays go; the others have the value of one beside them."""

TURNED: Final = 0.05
"""Distance that stands for a normal turned by 60°, as a share of the size: values are taken from
vertices of the same side."""

AWAY: Final = 0.05
"""Share of the way from a vertex to the middle of its faces at which its ray starts, so that it
does not run along a crease."""


@dataclass(frozen=True, eq=False)
class ThicknessView:
    """A scene in the colours of its thickness.

    Attributes
    ----------
    scene : Scene
        The scene, in which closed surfaces have colours, with a dot and a label at the thinnest
        wall.
    thinnest : Walls or None
        The thinnest wall of all models; None where nothing is closed.
    """

    scene: Scene
    thinnest: Walls | None


def _go_on() -> None:
    """Let the work go on."""


def thickness_view(
    scene: Scene, palette: Palette, checkpoint: Callable[[], None] = _go_on
) -> ThicknessView:
    """Show a scene in the colours of its thickness.

    What no triangle of its model closes keeps its colours, for it has no thickness.

    Parameters
    ----------
    scene : Scene
        What is shown; surfaces of one owner bound one solid.
    palette : Palette
        The colours of the scale: accent, clay and second, from thin to thick.
    checkpoint : callable
        Called now and then; what it raises ends the work and passes.
    """
    thinnest: Walls | None = None
    shown: dict[int, tuple[Shaded, ...]] = {}
    for owner in dict.fromkeys(layer.owner for layer in scene.layers):
        items = [
            item
            for layer in scene.layers
            if layer.owner == owner
            for item in layer.items
            if isinstance(item, Shaded) and _bounds_a_solid(item)
        ]
        solid, closed = _closed_solid([item.mesh for item in items])
        if not len(solid.faces):
            continue
        checkpoint()
        walls = walls_of(solid.vertices.astype(float), solid.faces)
        if thinnest is None or walls.thinnest < thinnest.thinnest:
            thinnest = walls
        for item, flags in zip(items, closed, strict=True):
            if flags.any():
                shown[id(item)] = tuple(_in_colors(item, flags, solid, palette, checkpoint))
    layers = [
        Layer(
            layer.name,
            tuple(one for item in layer.items for one in shown.get(id(item), (item,))),
            layer.owner,
            layer.tool,
            layer.chosen,
        )
        if any(id(item) in shown for item in layer.items)
        else layer
        for layer in scene.layers
    ]
    if thinnest is not None:
        layers.append(_mark(thinnest))
    return ThicknessView(Scene(tuple(layers)), thinnest)


def thickness_colors(thickness: Array, palette: Palette) -> Floats:
    """Return RGBA per vertex by thickness, mm, on a logarithmic scale; (v, 4), 0 … 255.

    Infinite thickness, which nothing bounds, has the colour of thick.
    """
    octave = np.log2(np.clip(thickness, THIN, THICK))
    marks = np.log2((THIN, MIDDLE, THICK))
    stops = np.array((palette.accent, palette.clay, palette.second), float)
    parts = [np.interp(octave, marks, stops[:, k]) for k in range(3)]
    return np.stack((*parts, np.full(len(octave), 255.0)), axis=1).astype(np.float32)


def written_thickness(thickness: float) -> str:
    """Return a thickness in words, such as "0.93 mm"."""
    return f"{thickness:.3g} mm"


def _bounds_a_solid(item: Shaded) -> bool:
    return item.pickable and item.opacity >= SEEN and len(item.mesh.faces) > 0


def _closed_solid(meshes: Iterable[Mesh]) -> tuple[Mesh, list[Flags]]:
    """Return the closed components of meshes together, and for each mesh which faces these have.

    Vertices at the very same place are one.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    parts = list(meshes)
    if not parts:
        return Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32)), []
    begins = np.cumsum([0, *(len(part.vertices) for part in parts)])
    points = np.concatenate([part.vertices for part in parts]) + np.float32(0)
    places, which = np.unique(points, axis=0, return_inverse=True)
    faces = which.ravel()[
        np.concatenate([part.faces + begin for part, begin in zip(parts, begins, strict=False)])
    ]
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    start, end = faces[whole].ravel(), np.roll(faces[whole], -1, axis=1).ravel()
    count = len(places)
    ones = np.ones(len(start))
    balance = coo_array((ones, (start, end)), (count, count)).tocsr()
    balance = balance - balance.T
    gap = np.zeros(count, bool)
    gap[np.unique(balance.nonzero())] = True
    _, component = connected_components(coo_array((ones, (start, end)), (count, count)))
    gapes = np.zeros(component.max() + 1, bool)
    gapes[component[gap]] = True
    closed = ~gapes[component[faces[:, 0]]]
    ends = np.cumsum([len(part.faces) for part in parts])[:-1]
    mesh = Mesh(places, faces[closed & whole].astype(np.int32))
    return mesh, np.split(closed, ends)


def _in_colors(
    item: Shaded, closed: Flags, solid: Mesh, palette: Palette, checkpoint: Callable[[], None]
) -> Iterator[Shaded]:
    """Yield the closed part of a surface in colours, and the rest as it is."""
    mesh = item.mesh
    normals = corner_normals(mesh)
    used, faces = np.unique(normals.corners[closed], return_inverse=True)
    points = np.zeros((len(normals.vectors), 3))
    points[normals.corners.ravel()] = mesh.vertices[mesh.faces.ravel()]
    size = float(np.ptp(solid.vertices, axis=0).max())
    points, across, faces = _parted(
        points[used], normals.vectors[used].astype(float), faces.reshape(-1, 3), FINENESS * size
    )
    thickness = _thickness(points, across, faces, solid, size, checkpoint)
    colors = thickness_colors(thickness, palette).astype(np.uint8)
    colored = Mesh(
        points.astype(np.float32), faces.astype(np.int32), across.astype(np.float32), colors
    )
    yield replace(item, mesh=colored, opacity=1.0, texture=None)
    if not closed.all():
        texture = None if item.texture is None else item.texture.of_faces(~closed)
        yield replace(item, mesh=replace(mesh, faces=mesh.faces[~closed]), texture=texture)


def _thickness(
    points: Array,
    normals: Array,
    faces: Index,
    solid: Mesh,
    size: float,
    checkpoint: Callable[[], None],
) -> Array:
    """Return the length of the ray inward from each vertex, (v,); inf where nothing is met."""
    from scipy.spatial import cKDTree

    asked = np.random.default_rng(0).permutation(len(points))
    asked, rest = np.split(asked, [MOST_RAYS])
    middle = np.zeros_like(points)
    np.add.at(middle, faces.ravel(), np.repeat(points[faces].mean(axis=1), 3, axis=0))
    middle /= np.maximum(np.bincount(faces.ravel(), minlength=len(points)), 1)[:, None]
    inwards = -normals[asked]
    start = points[asked] + AWAY * (middle - points)[asked] + INSIDE * size * inwards
    tree = tree_of(solid)
    thickness = np.full(len(points), np.inf)
    for begin in range(0, len(asked), RAYS_AT_ONCE):
        checkpoint()
        some = slice(begin, begin + RAYS_AT_ONCE)
        along, _ = first_hits(tree, start[some], inwards[some])
        thickness[asked[some]] = along + INSIDE * size
    if len(rest):
        seen = np.concatenate((points, TURNED * size * normals), axis=1)
        thickness[rest] = thickness[asked][cKDTree(seen[asked]).query(seen[rest])[1]]
    return thickness


def _parted(
    points: Array, normals: Array, faces: Index, longest: float
) -> tuple[Array, Array, Index]:
    """Halve edges that are longer than some length, until none is; neighbours stay joined."""
    for _ in range(MOST_ROUNDS):
        ends = np.sort(np.stack((faces, np.roll(faces, -1, axis=1)), axis=2), axis=2)
        keys, which = np.unique(ends[..., 0] * len(points) + ends[..., 1], return_inverse=True)
        pairs = np.stack(np.divmod(keys, len(points)), axis=1)
        length = np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1)
        long = length > longest
        if not long.any():
            break
        number = np.full(len(pairs), -1)
        number[long] = len(points) + np.arange(long.sum())
        cut = pairs[long]
        mean = normals[cut].sum(axis=1)
        mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-30)
        points = np.concatenate((points, points[cut].mean(axis=1)))
        normals = np.concatenate((normals, mean))
        faces = _halved(faces, number[which.reshape(-1, 3)])
    return points, normals, faces


def _halved(faces: Index, middles: Index) -> Index:
    """Return faces (f, 3) parted at the middles of their edges; -1 where an edge stays whole.

    Edge k goes from corner k to the next one.
    """
    count = (middles >= 0).sum(axis=1)
    # Turned so that the first edge is cut, and of two cut ones the other follows it.
    first = np.argmax(middles >= 0, axis=1)
    wraps = (count == 2) & (first == 0) & (middles[:, 1] < 0)
    turn = (np.arange(3) + np.where(wraps, 2, first)[:, None]) % 3
    (a, b, c), (p, q, r) = (np.take_along_axis(rows, turn, 1).T for rows in (faces, middles))
    parts = (
        (count == 0, ((a, b, c),)),
        (count == 1, ((a, p, c), (p, b, c))),
        (count == 2, ((a, p, c), (p, q, c), (p, b, q))),
        (count == 3, ((a, p, r), (p, b, q), (r, q, c), (p, q, r))),
    )
    return np.concatenate([np.stack(face, axis=1)[which] for which, made in parts for face in made])


def _mark(walls: Walls) -> Layer:
    place = np.array(walls.place, np.float32)[None]
    return Layer(
        "thinnest wall",
        (
            Points(place, color="ink", size=9.0, hidden="show"),
            Label(walls.place, written_thickness(walls.thinnest), color="ink"),
        ),
    )
