"""Bodies whose planes are known, and how a hand would draw them: the truth of the tests."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from bozzetto.view import Camera
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.solid.face_rings import area_vectors
from bozzetto_polyhedron.solid.planar_body import PlanarBody


@dataclass(frozen=True, eq=False)
class True3D:
    """Corners, faces as tuples of rings, genus (None for a sheet) and volume."""

    name: str
    vertices: np.ndarray
    faces: tuple
    genus: int | None
    volume: float | None
    orthogonal: bool


def polygon_area(points):
    x, y = np.asarray(points, float).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def prism(outline, height, holes=()):
    """A prism over an outline (counter-clockwise), through which holes (clockwise) run."""
    rings = [np.asarray(r, float) for r in (outline, *holes)]
    flat = np.concatenate(rings)
    count = len(flat)
    vertices = np.vstack((np.c_[flat, np.zeros(count)], np.c_[flat, np.full(count, float(height))]))
    starts = np.cumsum([0, *map(len, rings)])
    numbers = [tuple(range(a, b)) for a, b in itertools.pairwise(starts)]
    top = tuple(tuple(v + count for v in ring) for ring in numbers)
    bottom = tuple(ring[::-1] for ring in numbers)
    sides = [
        ((a, b, b + count, a + count),)
        for ring in numbers
        for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
    ]
    area = sum(polygon_area(r) for r in rings)
    return vertices, (bottom, top, *sides), area * height


def of_prism(name, outline, height, holes=(), *, orthogonal=True):
    vertices, faces, volume = prism(outline, height, holes)
    return True3D(name, vertices, faces, len(holes), volume, orthogonal)


def frustum(count=4, base=60.0, top=30.0, height=50.0):
    turns = np.arange(count) * 2 * np.pi / count + np.pi / count
    ring = np.c_[np.cos(turns), np.sin(turns)]
    vertices, faces, _ = prism(ring, 1.0)
    vertices[:count, :2] *= base
    vertices[count:, :2] *= top
    vertices[:, 2] *= height
    unit = polygon_area(ring)
    volume = unit * height * (base**2 + base * top + top**2) / 3
    return True3D(f"frustum{count}", vertices, faces, 0, volume, False)


def pyramid(count=4, base=60.0, height=70.0):
    turns = np.arange(count) * 2 * np.pi / count + np.pi / count
    ring = base * np.c_[np.cos(turns), np.sin(turns), 0 * turns]
    vertices = np.vstack((ring, (0.0, 0.0, height)))
    sides = tuple(((i, (i + 1) % count, count),) for i in range(count))
    faces = ((tuple(range(count))[::-1],), *sides)
    volume = polygon_area(ring[:, :2]) * height / 3
    return True3D(f"pyramid{count}", vertices, faces, 0, volume, False)


def cuboid_with_loop(depth, *, genus=0):
    """A block with a square pocket (depth > 0) or boss (depth < 0) off the middle of its top."""
    vertices, faces, volume = prism([(0, 0), (90, 0), (90, 70), (0, 70)], 50.0)
    loop = np.array([(15, 12), (55, 12), (55, 40), (15, 40.0)])
    rim = np.c_[loop, np.full(4, 50.0)]
    far = np.c_[loop, np.full(4, 50.0 - depth)]
    vertices = np.vstack((vertices, rim, far))
    ring = (8, 9, 10, 11)
    sides = zip(ring, ring[1:] + ring[:1], strict=True)
    walls = [((a, b, b + 4, a + 4),) for a, b in sides]
    faces = (faces[0], (*faces[1], ring[::-1]), *faces[2:], *walls, ((12, 13, 14, 15),))
    name = "pocket" if depth > 0 else "boss"
    return True3D(name, vertices, faces, 0, volume - depth * polygon_area(loop), True)


def notched():
    """A cube without one of its corners."""
    vertices = 40.0 * np.array(
        [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (0, 2, 2), (2, 1, 2),
         (1, 1, 2), (1, 2, 2), (2, 2, 1), (2, 1, 1), (1, 1, 1), (1, 2, 1)]
    )  # fmt: skip
    faces = [(0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 6, 3), (1, 2, 10, 11, 7, 5), (2, 3, 6, 9, 13, 10),
             (4, 5, 7, 8, 9, 6), (7, 11, 12, 8), (8, 12, 13, 9), (11, 10, 13, 12)]  # fmt: skip
    return True3D("notched", vertices, tuple((f,) for f in faces), 0, 7 * 40.0**3, True)


def open_box():
    """A box without its lid: a sheet of five faces."""
    vertices, faces, _ = prism([(0, 0), (80, 0), (80, 60), (0, 60)], 40.0)
    return True3D("open box", vertices, (faces[0], *faces[2:]), None, None, True)


def folded_sheet():
    """A U of three faces."""
    vertices, faces, _ = prism([(0, 0), (80, 0), (80, 60), (0, 60)], 40.0)
    return True3D("folded", vertices, (faces[0], faces[2], faces[4]), None, None, True)


def all_bodies():
    hexagon = 40.0 * np.c_[np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)]
    return [
        of_prism("box", [(0, 0), (70, 0), (70, 50), (0, 50)], 90),
        of_prism("L", [(0, 0), (80, 0), (80, 40), (35, 40), (35, 90), (0, 90)], 60),
        of_prism("U", [(0, 0), (90, 0), (90, 60), (60, 60), (60, 25), (30, 25), (30, 60), (0, 60)],
                 50),
        of_prism("stairs", [(0, 0), (90, 0), (90, 30), (60, 30), (60, 60), (30, 60), (30, 90),
                            (0, 90)], 60),
        of_prism("wedge", [(0, 0), (90, 0), (0, 55)], 60, orthogonal=False),
        of_prism("house", [(0, 0), (80, 0), (80, 45), (40, 80), (0, 45)], 100, orthogonal=False),
        of_prism("hexagon", hexagon, 50, orthogonal=False),
        of_prism("hole", [(0, 0), (90, 0), (90, 90), (0, 90)], 50,
                 [[(25, 20), (25, 60), (60, 60), (60, 20)]]),
        frustum(), frustum(3), pyramid(4), pyramid(5), notched(), cuboid_with_loop(25.0),
        cuboid_with_loop(-25.0), open_box(), folded_sheet(),
    ]  # fmt: skip


def random_turn(rng):
    """A rotation as an oblique view gives it: rows are right, up and away in the world."""
    azimuth, elevation = rng.uniform(0.35, 1.2), rng.uniform(0.3, 0.8)
    roll = rng.normal(0, 0.05)
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    cr, sr = np.cos(roll), np.sin(roll)
    about = np.array([(ca, -sa, 0), (sa, ca, 0), (0, 0, 1)])
    tilt = np.array([(1, 0, 0), (0, ce, -se), (0, se, ce)])
    rolled = np.array([(cr, 0, -sr), (0, 1, 0), (sr, 0, cr)])
    return rolled @ tilt @ about


def drawn(body, share, rng, *, turn=None):
    """The body as an answer: turned, about the origin, and every corner off by normal noise.

    `share` is the standard deviation of a corner as share of the diagonal of the drawing; depth,
    which follows from the picture, is off by as much. Returns the answer, the noise in mm, and the
    true corners.
    """
    turn = random_turn(rng) if turn is None else turn
    true = (body.vertices - body.vertices.mean(axis=0)) @ turn.T
    diagonal = float(np.linalg.norm(np.ptp(true[:, [0, 2]], axis=0)))
    noise = share * diagonal
    vertices = true + rng.normal(0.0, noise / np.sqrt(2.0), true.shape)
    return Answer(vertices, body.faces, 1.0, 0.0, body.genus is not None), noise, true


def parallel_camera():
    return Camera("orthographic", height=200.0)


def face_areas(body: PlanarBody) -> np.ndarray:
    """Return the areas of faces, holes taken off, mm², (f,)."""
    return np.linalg.norm(area_vectors(body.vertices, body.faces), axis=1)
