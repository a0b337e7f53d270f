"""Trim: lips around wheel arches and mirrors, as solids beside the body, and shut lines on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import (
    Brep,
    BSplineSurface,
    Curve,
    Mesh,
    ParameterCurve,
    Placement,
    brep_mesh,
    sewn,
    surface_of_revolution,
)
from bozzetto.geometry.patches import Places, normals_at, points_at
from bozzetto.view import triple
from bozzetto_car.parts.looks import DARK, PAINT, CarPart, on_both_sides
from bozzetto_car.parts.trimmed_face import KNOTS, bezier, cubic_piece
from bozzetto_car.parts.wheel_arches import cut_panels
from bozzetto_car.template.model import MIRROR, Patch, Template
from bozzetto_car.template.network import Network

LIP: Final = ((0.0, 6.0), (18.0, 4.5), (26.0, 1.0), (26.0, -9.0), (0.0, -9.0))
"""Section of a lip, mm: away from the arch along the panel, and out of it. It reaches into the
panel, so that no slit is left where that bends."""

ALONG_LIP: Final = 33
"""Places along an arch through which its lip is laid."""

MIRROR_AT: Final = 0.11
"""Place of a mirror along the foot of the foremost side window, as share of its length."""

MIRROR_OUT: Final = (105.0, 62.0)
"""Centre of a mirror from that place: outward and up, mm."""

MIRROR_HALF: Final = (52.0, 98.0, 66.0)
"""Half length, width and height of a mirror, mm."""

BOXY: Final = 0.8
"""Handles of its section per radius; 0.55 would make an ellipsoid."""

STALK: Final = ((-20.0, -35.0, (18.0, 6.0)), (60.0, 30.0, (22.0, 8.0)))
"""Of the arm of a mirror, at its root inside the body and in the housing: outward and up from the
foot, half its width and its thickness, mm."""

SEEN: Final = 1.0
"""How far triangles for the eye are from a mirror, mm."""

SIDEWAYS: Final = np.array([0.0, 1.0, 0.0])


def trim_of(network: Network, nets: Array, *, with_mirrors: bool) -> list[CarPart]:
    """Return the lips of the wheel arches and the mirrors of both sides.

    Parameters
    ----------
    network : Network
        The car.
    nets : (k, 4, 4, 3) array_like
        Its patches, mm.
    with_mirrors : bool
        Whether it has mirrors. A car without a side window never has.
    """
    parts = _lips(network, nets)
    foot = _mirror_foot(network, nets) if with_mirrors else None
    if foot is not None:
        to = Placement(offset=triple(foot))
        parts += on_both_sides(
            "Mirror", PAINT, lambda: _mirror_mesh().placed(to), lambda: _mirror().placed(to)
        )
    return parts


# -- lips ------------------------------------------------------------------------------------------


def _lips(network: Network, nets: Array) -> list[CarPart]:
    """Return the lips of the arches, with a piece on each panel that an arch cuts."""
    axles = network.positions[network.template.wheels[:, 0]]
    count = [0, 0]
    made: list[CarPart] = []
    for number, panel in cut_panels(network, nets).items():
        for arc in panel.arcs:
            count[panel.wheel] += 1
            piece = count[panel.wheel]
            which = ("front", "rear")[panel.wheel]
            name = f"Arch lip {which}" + (f" {piece}" if piece > 1 else "")
            ring = partial(_lip_ring, nets[number], arc, axles[panel.wheel])
            made += on_both_sides(name, DARK, partial(_lip_mesh, ring), partial(_lip, ring))
    return made


def _lip_ring(net: Array, arc: ParameterCurve, axle: Array) -> Array:
    """Return places of a lip along an arc on a panel, (5, n, 3): the lines of its section."""
    at = np.linspace(0.0, 1.0, ALONG_LIP)
    places = Places(np.zeros(ALONG_LIP, np.intp), np.clip(arc.value(at), 0.0, 1.0))
    points, normals = points_at(net[None], places), normals_at(net[None], places)
    outward = (points - axle) * (1.0, 0.0, 1.0)
    outward -= (outward * normals).sum(axis=1, keepdims=True) * normals
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return np.array([points + along * outward + out * normals for along, out in LIP])


def _lip_mesh(ring: Callable[[], Array]) -> Mesh:
    """Return the sides of a lip as triangles, each flat across."""
    lines = ring()
    ahead = np.roll(lines, -1, axis=0)
    along = np.gradient(0.5 * (lines + ahead), axis=1)
    normals = np.cross(lines - ahead, along)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    vertices = np.stack((lines, ahead), axis=1)
    at = np.arange(vertices[..., 0].size).reshape(vertices.shape[:3])
    a, b, c, d = at[:, 0, :-1], at[:, 0, 1:], at[:, 1, 1:], at[:, 1, :-1]
    faces = np.stack((np.stack((a, b, c), axis=-1), np.stack((a, c, d), axis=-1)), axis=-2)
    return Mesh(
        vertices.reshape(-1, 3).astype(np.float32),
        faces.reshape(-1, 3).astype(np.int32),
        np.repeat(normals[:, None], 2, axis=1).reshape(-1, 3).astype(np.float32),
    )


def _lip(ring: Callable[[], Array]) -> Brep:
    """Return a lip as a solid."""
    from scipy.interpolate import make_interp_spline

    at = np.linspace(0.0, 1.0, ALONG_LIP)
    fits = [make_interp_spline(at, line, k=3) for line in ring()]
    lines = [Curve(3, fit.t, fit.c) for fit in fits]
    faces = [
        Brep.of_surface(
            BSplineSurface(
                (1, 3),
                KNOTS[1],
                one.knots,
                np.stack((one.control_points, other.control_points)),
            )
        )
        for one, other in pairwise([*lines, lines[0]])
    ]
    ends = [np.array([line.control_points[k] for line in lines]) for k in (0, -1)]
    solid = sewn([*faces, *_caps(ends[0]), *(cap.turned_over() for cap in _caps(ends[1]))])
    return solid.turned_over()


def _caps(section: Array) -> list[Brep]:
    """Return an end of a lip: a quadrangle and a triangle, which has a pole."""
    a, b, c, d, e = section
    quads = (((a, b), (e, d)), ((b, c), (d, d)))
    return [Brep.of_surface(bezier(np.array(quad))) for quad in quads]


# -- shut lines ------------------------------------------------------------------------------------


def shut_lines(network: Network, nets: Array) -> Iterator[tuple[str, Array]]:
    """Yield shut lines by name, as Bézier points (4, 3) on the surface, right ones and left ones.

    What a wheel arch has cut away is left out, so a line may have two pieces.

    Parameters
    ----------
    network : Network
        The car.
    nets : (k, 4, 4, 3) array_like
        Its patches, mm.
    """
    template = network.template
    gone: dict[int, tuple[float, float]] = {}
    for number, panel in cut_panels(network, nets).items():
        for side, (start, end) in panel.cut.items():
            signed = template.patches[number].edges[side]
            gone[max(signed, ~signed)] = (start, end) if signed >= 0 else (1.0 - end, 1.0 - start)
    for edge in template.shut_lines:
        first, last = gone.get(edge, (1.0, 1.0))
        name = template.edge_names[edge].replace(".R", "")
        for start, end in ((0.0, first), (last, 1.0)):
            if start < end:
                piece = cubic_piece(network.control_points[edge], start, end)
                yield f"Shut line {name} right", piece
                yield f"Shut line {name} left", piece * MIRROR


# -- mirrors ---------------------------------------------------------------------------------------


def _mirror_foot(network: Network, nets: Array) -> Array | None:
    """Return the place of the right mirror on the foremost side window; None without one."""
    template = network.template
    side = [
        (number, patch)
        for number, patch in enumerate(template.patches)
        if _is_side(template, patch)
    ]
    if not side:
        return None
    front = [network.positions[list(patch.nodes), 0].min() for _, patch in side]
    number, patch = side[int(np.argmin(front))]
    corner = int(np.argmin(network.positions[list(patch.nodes), 0]))
    ends = [network.positions[patch.nodes[(corner + step) % 4]] for step in (1, -1)]
    points = points_at(nets[[number]], Places(np.zeros(2, np.intp), _beside(corner)))
    return np.asarray(points[int(np.argmin([end[2] for end in ends]))])


def _is_side(template: Template, patch: Patch) -> bool:
    """Whether a patch is a window of the right side."""
    return patch.glass and patch.name.endswith(".R") and not {*patch.nodes} & {*template.centre}


def _beside(corner: int) -> Array:
    """Return u and v of the places `MIRROR_AT` along the sides after and before a corner."""
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    here = corners[corner]
    return np.array([here + MIRROR_AT * (corners[(corner + step) % 4] - here) for step in (1, -1)])


@cache
def _mirror_mesh() -> Mesh:
    return brep_mesh(_mirror(), SEEN)


@cache
def _mirror() -> Brep:
    """Return a right mirror with its foot at 0: a housing, and an arm that reaches inward."""
    centre = np.array([0.0, *MIRROR_OUT])
    section = np.array(
        [(0.0, -1.0), (BOXY, -1.0), (1.0, -BOXY), (1.0, 0.0), (1.0, BOXY), (BOXY, 1.0), (0.0, 1.0)]
    )
    points = np.stack((section[:, 0], section[:, 1], np.zeros(len(section))), axis=1)
    knots = np.array([0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0, 1.0])
    ball = surface_of_revolution(Curve(3, knots, points), (0.0, 0.0, 0.0), SIDEWAYS)
    housing = _stretched(ball, np.array(MIRROR_HALF), centre)
    rings = []
    for out, up, half in STALK:
        wide, high = half
        ring = ((-wide, high), (wide, high), (wide, -high), (-wide, -high))
        rings.append(np.array([(x, out, up + z) for x, z in ring]))
    inner, outer = rings
    flanks = [
        np.stack((inner[[k, (k + 1) % 4]], outer[[k, (k + 1) % 4]]), axis=1) for k in range(4)
    ]
    ends = [inner[[[0, 1], [3, 2]]], outer[[[0, 3], [1, 2]]]]
    arm = [Brep.of_surface(bezier(net)) for net in (*flanks, *ends)]
    return sewn([housing, *arm])


def _stretched(part: Brep, half: Array, centre: Array) -> Brep:
    """Return a part of radius 1 stretched along the axes and moved."""

    def moved(points: Array) -> Array:
        return np.asarray(points * half + centre)

    edges = tuple(replace(e, control_points=moved(e.control_points)) for e in part.edges)
    faces = tuple(
        replace(f, surface=replace(f.surface, control_points=moved(f.surface.control_points)))
        for f in part.faces
    )
    return replace(part, edges=edges, faces=faces)
