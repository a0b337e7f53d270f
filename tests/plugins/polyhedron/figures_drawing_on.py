"""What is drawn on solids, measured on random ones that nothing was tuned on.

    python -m tests.plugins.polyhedron.figures_drawing_on [--count 200] [--first 62000]

Where BOZZETTO_CAD_READERS names a Python with OpenCASCADE, every result is written as STEP and read
by it. The oracle of volumes is manifold3d on triangles of the parts, never the code that is asked.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import manifold3d
import numpy as np

from bozzetto.errors import UserError
from bozzetto.exchange.export import encode_shapes
from bozzetto.geometry import Shapes
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.added_strokes import with_strokes_added
from bozzetto_polyhedron.drawing_on.body_hits import face_under
from bozzetto_polyhedron.drawing_on.chamfer import (
    cap_at,
    chamfered,
    edge_faces,
    faces_at_edge,
    room_at_edge,
)
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.drawing_on.circles import Circle, circle_on_face, polygon_of
from bozzetto_polyhedron.drawing_on.copies import mirrored
from bozzetto_polyhedron.drawing_on.cylinders import brep_with_cylinders, walls_of
from bozzetto_polyhedron.drawing_on.push import prism_on, pushed
from bozzetto_polyhedron.drawing_on.rounded_edges import (
    half_angle,
    largest_radius,
    rounded_edge,
)
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.face_rings import edges_of, tangents
from bozzetto_polyhedron.solid.pieces import pieces_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import (
    face_triangles,
    triangles_of,
    volume_of,
    within_face,
)
from tests.plugins.polyhedron.figures_solid import off_planes
from tests.plugins.polyhedron.objects import made

EXACTLY, NEARLY = 1e-7, 2e-4
"""Difference of volumes over the volume: of exact surfaces, and of what manifold3d has in single
precision."""

REACH, NOISE = 12.0, 1.5
"""Distance within which ends meet, and standard deviation of where lines end, px."""

Sight = tuple[Camera, int, np.ndarray, float]
"""A view onto a face, and a circle inside that face."""

READER = """
import json, sys
from pathlib import Path
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.STEPControl import STEPControl_Reader
volume = getattr(BRepGProp, "VolumeProperties", None) or BRepGProp.VolumeProperties_s
found = {}
for path in sorted(Path(sys.argv[1]).iterdir()):
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    shape = reader.OneShape()
    measured = GProp_GProps()
    volume(shape, measured)
    found[path.stem] = [bool(BRepCheck_Analyzer(shape).IsValid()), measured.Mass()]
print(json.dumps(found))
"""


@dataclass
class Tally:
    """What was measured of one kind of change."""

    tried: int = 0
    right: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    off: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    written: dict[str, float] = field(default_factory=dict)


def random_body(seed: int, rng: np.random.Generator) -> PlanarBody | None:
    """Return a random solid of 100 mm in a random orientation."""
    solid = made(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    middle = solid.vertices - solid.vertices.mean(axis=0)
    vertices = middle * (100.0 / float(np.ptp(middle, axis=0).max())) @ turn.T
    try:
        body = exact_body(Answer(vertices, solid.faces, 1.0, 0.0, True), noise=0.0)
    except UserError:
        return None
    return body if body.closed else None


def clear_view(body: PlanarBody, rng: np.random.Generator) -> Sight:
    """Return a view in which nothing lies before the circle inside the face: one can draw there."""
    turns = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    while True:
        sight = camera, face, middle, radius = random_view(body, rng)
        ring = np.column_stack((np.cos(turns), np.sin(turns))) @ tangents(body.normals[face])
        places, _ = camera.project(middle + 0.95 * radius * ring)
        hits = [face_under(body, camera, place) for place in places]
        if all(hit is not None and hit[1] == face for hit in hits):
            return sight


def random_view(body: PlanarBody, rng: np.random.Generator) -> Sight:
    """Return a view onto a face, with the middle and the radius of a circle inside that face."""
    spots = [largest_circle(body, face) for face in range(len(body.faces))]
    weights = np.array([radius for _, radius in spots]) ** 2
    face = int(rng.choice(len(spots), p=weights / weights.sum()))
    away = body.normals[face] + 0.7 * rng.normal(size=3)
    while away @ body.normals[face] < 0.4 * np.linalg.norm(away):
        away = body.normals[face] + 0.7 * rng.normal(size=3)
    away /= np.linalg.norm(away)
    eye = 450.0 * away
    kind = "orthographic" if rng.random() < 0.5 else "perspective"
    up = tangents(away)[0]
    middle, radius = spots[face]
    opening = float(np.degrees(2.0 * np.arctan(2.5 * radius / 450.0)))
    camera = Camera(
        kind,
        tuple(middle + eye),
        tuple(middle),
        tuple(up),
        height=5.0 * radius,
        fov_y=opening,
        viewport=(1200.0, 900.0),
    )
    return camera, face, middle, radius


def largest_circle(body: PlanarBody, face: int) -> tuple[np.ndarray, float]:
    """Return the largest circle inside a triangle of a face."""
    best = (np.zeros(3), 0.0)
    for triangle in face_triangles(body.vertices, body.faces[face], body.normals[face]):
        a, b, c = body.vertices[triangle]
        sides = np.array([np.linalg.norm(b - c), np.linalg.norm(c - a), np.linalg.norm(a - b)])
        area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a)))
        radius = 2.0 * area / float(sides.sum())
        if radius > best[1]:
            best = (sides @ np.array((a, b, c)) / sides.sum(), radius)
    return best


def in_plane_axes(body: PlanarBody, face: int) -> np.ndarray:
    """Return the direction of the longest side of a face, and that across it."""
    ring = body.vertices[list(body.faces[face][0])]
    sides = np.roll(ring, -1, axis=0) - ring
    along = sides[int(np.argmax(np.linalg.norm(sides, axis=1)))]
    along = along / np.linalg.norm(along)
    return np.stack((along, np.cross(body.normals[face], along)))


def as_manifold(body: PlanarBody) -> manifold3d.Manifold:
    triangles, _ = triangles_of(body)
    return manifold3d.Manifold(
        manifold3d.Mesh64(np.array(body.vertices), triangles.astype(np.uint64))
    )


def added_box(body: PlanarBody, rng: np.random.Generator) -> tuple[PlanarBody, float, bool]:
    """Draw a box on a face line by line; is it there, and as large as it was meant?"""
    camera, face, middle, radius = clear_view(body, rng)
    along, across = in_plane_axes(body, face)
    turned = np.sign(rng.normal(size=2)) * rng.uniform(0.4, 0.56, 2) * radius
    ring = [middle + x * turned[0] * along + y * turned[1] * across
            for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]  # fmt: skip
    height = rng.uniform(0.7, 1.6) * radius
    far = [point + height * body.normals[face] for point in ring]
    pairs = [(ring[k], ring[(k + 1) % 4]) for k in range(4)]
    pairs += list(zip(ring, far, strict=True)) + [(far[k], far[(k + 1) % 4]) for k in range(4)]
    strokes = []
    for pair in pairs:
        ends = camera.project(np.array(pair))[0] + NOISE * rng.normal(size=(2, 2))
        strokes.append(ends[0] + np.linspace(0, 1, 20)[:, None] * (ends[1] - ends[0]))
    _, after = with_strokes_added(Changed(body), strokes, camera, REACH)
    gained = volume_of(after.body) - volume_of(body)
    wanted = 4.0 * abs(turned[0] * turned[1]) * height
    right = not len(after.lines) and abs(gained - wanted) < 0.25 * wanted
    return after.body, volume_of(after.body), right


def loop_over_border(body: PlanarBody, rng: np.random.Generator) -> tuple[PlanarBody, float, bool]:
    """Push a loop about a point of a face's border, in or out."""
    _, face, _, radius = random_view(body, rng)
    ring = body.vertices[list(body.faces[face][0])]
    side = int(rng.integers(len(ring)))
    share = rng.uniform(0.2, 0.8)
    middle = (1 - share) * ring[side] + share * ring[(side + 1) % len(ring)]
    return _pushed_loop(body, face, middle, radius, rng)


def loop_from_corner(body: PlanarBody, rng: np.random.Generator) -> tuple[PlanarBody, float, bool]:
    """Push a loop with one corner in a corner of its face, and the others inside, in or out.

    Pushed in where the edge at the corner is square to the face, its wall would have no thickness
    along that edge: that has to be refused.
    """
    _, face, inner, radius = random_view(body, rng)
    ring = body.vertices[list(body.faces[face][0])]
    corner = ring[int(np.argmin(np.linalg.norm(ring - inner, axis=1)))]
    across = np.cross(body.normals[face], inner - corner)
    across /= np.linalg.norm(across)
    middle = 0.5 * (corner + inner)
    wide = 0.2 * radius
    loop = np.array((corner, middle - wide * across, inner, middle + wide * across))
    return _checked_push(body, face, loop, 0.3 * radius * rng.choice((-1.0, 1.0)))


def _pushed_loop(
    body: PlanarBody, face: int, middle: np.ndarray, radius: float, rng: np.random.Generator
) -> tuple[PlanarBody, float, bool]:
    angles = np.sort(rng.uniform(0, 2 * np.pi, 5))
    angles = np.arange(5) * 2 * np.pi / 5 + 0.3 * rng.normal(size=5) * 0.5 + angles[0]
    reach = rng.uniform(0.4, 0.9, 5) * radius
    loop = middle + (reach * (np.cos(angles), np.sin(angles))).T @ tangents(body.normals[face])
    depth = (-1.0 if rng.random() < 0.5 else 1.0) * rng.uniform(0.2, 0.8) * radius
    return _checked_push(body, face, loop, depth)


def _checked_push(
    body: PlanarBody, face: int, loop: np.ndarray, depth: float
) -> tuple[PlanarBody, float, bool]:
    after = pushed(body, face, loop, depth)
    tool = as_manifold(prism_on(body.normals[face], float(body.offsets[face]), loop, depth))
    solid = as_manifold(body)
    wanted = (solid + tool if depth > 0 else solid - tool).volume()
    return after, wanted, abs(volume_of(after) - wanted) < 1e-4 * wanted


def drawn_circle(body: PlanarBody, rng: np.random.Generator) -> tuple:
    """Draw an ellipse on a face and push it: is it one exact cylinder where it was meant?"""
    camera, face, middle, radius = clear_view(body, rng)
    true = rng.uniform(0.35, 0.7) * radius
    at = np.linspace(0, 2 * np.pi, 80) + rng.uniform(0, 6)
    wobble = 1 + 0.01 * np.cos(2 * at + 1) + 0.01 * np.cos(3 * at)
    ring = middle + (true * wobble * (np.cos(at), np.sin(at))).T @ tangents(body.normals[face])
    circle = circle_on_face(body, camera.project(ring)[0], camera)
    if circle is None or circle.face != face:
        return body, volume_of(body), False, []
    depth = (1.0 if rng.random() < 0.5 else -0.5) * true
    after = pushed(body, face, polygon_of(circle), depth)
    walls, _ = walls_of(after, [circle])
    near = abs(circle.radius / true - 1) < 0.05 and (
        np.linalg.norm(circle.center - middle) < 0.1 * true
    )
    wanted = volume_of(body) + np.pi * circle.radius**2 * depth
    right = len(walls) == 1 and near and abs(volume_of(after) / wanted - 1) < 1e-9
    return after, wanted, right, [circle]


def bevel(body: PlanarBody, rng: np.random.Generator) -> tuple[PlanarBody, float, bool]:
    """Chamfer a random edge by a fifth of what its faces allow."""
    edges = edges_of(body.faces)
    one, two = (int(v) for v in edges[rng.integers(len(edges))])
    after = chamfered(body, (one, two), 0.2 * room_at_edge(body, (one, two)))
    change = abs(volume_of(after) - volume_of(body))
    return after, volume_of(after), 0.0 < change < 0.2 * volume_of(body)


def round_edge(body: PlanarBody, rng: np.random.Generator) -> tuple:
    """Round a random edge by a fifth of what its faces allow: is it one exact cylinder?"""
    edges = edges_of(body.faces)
    one, two = (int(v) for v in edges[rng.integers(len(edges))])
    radius = 0.2 * largest_radius(body, (one, two))
    after, arc = rounded_edge(body, (one, two), radius)
    change = volume_beside_arc(body, (one, two), radius)
    wanted = volume_of(body) + change
    walls, cut = walls_of(after, [arc])
    step = arc.sweep / arc.sides
    beside = radius**2 * (np.tan(0.5 * arc.sweep) - 0.5 * arc.sweep)
    strips = 0.5 * radius**2 * arc.sides * (step - np.sin(step))
    near = abs(volume_of(after) - wanted) < 1.5 * strips / beside * abs(change)
    return after, wanted, len(walls) == 1 and not cut and near, [arc]


def volume_beside_arc(body: PlanarBody, edge: tuple[int, int], radius: float) -> float:
    """Return what a round edge adds to a body, mm³; less than 0 where it takes.

    The length along the edge, up to the faces and the caps that end it, is integrated over what is
    between its faces and the arc, by Gauss and Legendre in polar coordinates about the axis.
    """
    first, second, start, end = edge_faces(body, edge)
    into = np.array(faces_at_edge(body, edge))
    half = half_angle(body, edge)
    along = body.vertices[end] - body.vertices[start]
    length = float(np.linalg.norm(along))
    along = along / length
    inward = into.sum(axis=0) / np.linalg.norm(into.sum(axis=0))
    aside = np.cross(along, inward)
    center = body.vertices[start] + radius / np.sin(half) * inward
    nodes, weights = np.polynomial.legendre.leggauss(6)
    most, panels = 0.5 * np.pi - half, 120
    panel = most / panels
    turns = (panel * (np.arange(panels)[:, None] + 0.5 + 0.5 * nodes)).ravel()
    of_turns = np.tile(0.5 * panel * weights, panels)
    turns, of_turns = np.concatenate((-turns, turns)), np.concatenate((of_turns, of_turns))
    deep = radius / np.cos(most - np.abs(turns)) - radius
    reach = radius + deep[:, None] * (0.5 + 0.5 * nodes)
    measure = of_turns[:, None] * 0.5 * deep[:, None] * weights * reach
    spots = center + (
        reach[..., None] * (np.multiply.outer(np.sin(turns), aside)[:, None])
        - reach[..., None] * (np.multiply.outer(np.cos(turns), inward)[:, None])
    )
    spots = spots.reshape(-1, 3)
    low, high = np.full(len(spots), -np.inf), np.full(len(spots), np.inf)
    for vertex, out in ((start, -along), (end, along)):
        normal, offset = cap_at(body, vertex, (first, second), out)
        limit = (offset - spots @ normal) / (along @ normal)
        low, high = (low, np.minimum(high, limit)) if out @ along > 0 else (limit, high)
    middle = 0.5 * (low + high)
    for number, normal in enumerate(body.normals):
        if abs(normal @ along) > 1e-9:
            at = (body.offsets[number] - spots @ normal) / (along @ normal)
            met = within_face(body, number, spots + np.multiply.outer(at, along))
            low = np.where(met & (at < middle), np.maximum(low, at), low)
            high = np.where(met & (at > middle), np.minimum(high, at), high)
    volume = float(measure.ravel() @ np.maximum(0.0, high - low))
    return volume if into[0] @ body.normals[second] > 0 else -volume


def mirror_image(body: PlanarBody, rng: np.random.Generator) -> tuple[PlanarBody, float, bool]:
    """Join a body with its image in one of its faces."""
    face = int(rng.integers(len(body.faces)))
    image = mirrored(body, body.normals[face], float(body.offsets[face]))
    whole = combined(body, image, "union")
    wanted = (as_manifold(body) + as_manifold(image)).volume()
    return whole, wanted, abs(volume_of(whole) / wanted - 1) < 1e-4


KINDS: dict[str, Callable[..., tuple]] = {
    "boxes drawn on faces, 1.5 px of noise": added_box,
    "loops over the border of a face": loop_over_border,
    "loops from a corner of a face": loop_from_corner,
    "circles drawn on faces": drawn_circle,
    "chamfers": bevel,
    "round edges": round_edge,
    "mirror images in faces": mirror_image,
}


EXACT = tuple(name for name in KINDS if KINDS[name] not in (added_box, drawn_circle, round_edge))
"""Kinds that need no ink: what is not refused has to be right."""


def measure(name: str, seed: int, tally: Tally, folder: Path) -> None:
    rng = np.random.default_rng((62, seed))
    body = random_body(seed, rng)
    if body is None:
        return
    tally.tried += 1
    start = time.process_time()
    try:
        after, wanted, right, *rest = KINDS[name](body, rng)
    except UserError as problem:
        words = str(problem)
        tally.refused[words] = tally.refused.get(words, 0) + 1
        return
    tally.seconds.append(time.process_time() - start)
    tally.right += right
    tally.off.append(off_planes(after))
    if not os.environ.get("BOZZETTO_CAD_READERS"):
        return
    circles: list[Circle] = rest[0] if rest else []
    stem = f"{list(KINDS).index(name)}-{seed}"
    path = folder / f"{stem}.step"
    tally.written[stem] = wanted
    try:
        breps = tuple(brep_with_cylinders(piece, circles) for piece in pieces_of(after))
    except UserError as problem:
        words = f"not handed over: {problem}"
        tally.refused[words] = tally.refused.get(words, 0) + 1
        return
    path.write_bytes(encode_shapes(Shapes(breps=breps), path))


def read_back(folder: Path) -> dict[str, list]:
    """Return what OpenCASCADE says of every file: whether it is valid, and its volume."""
    python = os.environ.get("BOZZETTO_CAD_READERS")
    if not python:
        return {}
    done = subprocess.run(
        [python, "-c", READER, str(folder)], capture_output=True, text=True, check=True
    )
    return dict(json.loads(done.stdout.strip().splitlines()[-1]))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=62_000)
    parser.add_argument("--only", default="", help="measure kinds with this in their name")
    parser.add_argument("--why", action="store_true", help="say what was refused, and how often")
    asked = parser.parse_args()
    tallies = {name: Tally() for name in KINDS if asked.only in name}
    with tempfile.TemporaryDirectory() as place:
        for name, tally in tallies.items():
            for seed in range(asked.first, asked.first + asked.count):
                measure(name, seed, tally, Path(place))
        read = read_back(Path(place))
    print(
        "| what | right | refused with advice | worst corner off planes "
        "| OpenCASCADE: valid, same volume | median | asked | kept |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, tally in tallies.items():
        same = EXACTLY if KINDS[name] in (drawn_circle, round_edge) else NEARLY
        valid = sum(
            stem in read and read[stem][0] and abs(read[stem][1] - wanted) < same * wanted
            for stem, wanted in tally.written.items()
        )
        told = f"{valid} of {len(tally.written)}" if read else "not asked"
        kept = max(tally.off, default=0.0) < 1e-9 and (not read or valid == len(tally.written))
        asked_of = "exact and valid"
        if name in EXACT:
            asked_of = "exact, valid, none wrong"
            kept = kept and tally.right + sum(tally.refused.values()) == tally.tried
        print(
            f"| {name} | {tally.right} of {tally.tried} | {sum(tally.refused.values())} "
            f"| {max(tally.off, default=0.0):.1e} mm | {told} "
            f"| {1e3 * float(np.median(tally.seconds or [0.0])):.0f} ms | {asked_of} "
            f"| {'yes' if kept else 'no'} |"
        )
        if asked.why:
            for words, count in tally.refused.items():
                print(f"  {count} × {words}")


if __name__ == "__main__":
    main()
