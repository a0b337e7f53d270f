"""Parts with cylinders, as a person draws them: edges, rims and sides, hidden ones light or not.

Lengths of a `RoundView` are shares of the diagonal of its picture; x right, y up, z away from the
eye, as in `objects.View`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from manifold3d import CrossSection, Manifold, Mesh

from bozzetto.ink import Stroke
from tests.plugins.polyhedron.hand import SIZE, Hand, stroke
from tests.plugins.polyhedron.objects import TO_CANVAS, random_rotation

FACETS = 96
"""Sides of a cylinder of the truth."""


@dataclass(frozen=True, eq=False)
class Arc:
    """A circle, or a part of one: radians from `first` toward `second`."""

    center: np.ndarray
    first: np.ndarray
    second: np.ndarray
    begin: float = 0.0
    end: float = 2.0 * np.pi

    def at(self, angles):
        turn = np.column_stack((np.cos(angles), np.sin(angles)))
        return self.center + turn @ np.array((self.first, self.second))

    @property
    def whole(self):
        return self.end - self.begin > 2.0 * np.pi - 1e-9


@dataclass(frozen=True, eq=False)
class RoundPart:
    """A solid, its straight edges (m, 2, 3), and its cylinders: an arc, where it goes, hollow."""

    name: str
    solid: Manifold
    lines: np.ndarray
    cylinders: list[tuple[Arc, np.ndarray, bool]]
    planes: int
    genus: int


@dataclass(frozen=True, eq=False)
class RoundView:
    """A part seen from a side; `lines`, `arcs` and `sides` are in the frame of the eye."""

    part: RoundPart
    triangles: np.ndarray
    solid: Manifold
    lines: np.ndarray
    cylinders: list[tuple[Arc, np.ndarray, bool]] = field(default_factory=list)


def _up(x, y, z, radius, height, begin=0.0, end=2.0 * np.pi):
    arc = Arc(np.array((x, y, z), float), np.array((radius, 0, 0.0)), np.array((0, radius, 0.0)))
    return Arc(arc.center, arc.first, arc.second, begin, end), np.array((0.0, 0.0, height))


def _cylinder(x, y, z, radius, height):
    return Manifold.cylinder(height, radius, radius, FACETS).translate((x, y, z))


def _outline(corners, height):
    base = [np.array((x, y, 0.0)) for x, y in corners]
    top = [np.array((x, y, height)) for x, y in corners]
    return base, top


def _box_lines(x, y, z):
    base, top = _outline(((0, 0), (x, 0), (x, y), (0, y)), z)
    found = []
    for ring in (base, top):
        found += list(zip(ring, ring[1:] + ring[:1], strict=True))
    return np.array(found + list(zip(base, top, strict=True)))


def _box(rng):
    x, y = rng.uniform(1.6, 3.0, 2)
    z = rng.uniform(0.7, 1.8)
    return float(x), float(y), float(z)


def hole(rng):
    x, y, z = _box(rng)
    r = rng.uniform(0.22, 0.36) * min(x, y)
    a, b = (rng.uniform(1.25 * r, s - 1.25 * r) for s in (x, y))
    solid = Manifold.cube((x, y, z)) - _cylinder(a, b, -1, r, z + 2)
    return RoundPart("hole in a box", solid, _box_lines(x, y, z),
                     [(*_up(a, b, 0, r, z), True)], 6, 1)  # fmt: skip


def pocket(rng):
    x, y, z = _box(rng)
    z = max(z, 1.2)
    r = rng.uniform(0.22, 0.36) * min(x, y)
    deep = rng.uniform(0.3, 0.6) * z
    a, b = (rng.uniform(1.25 * r, s - 1.25 * r) for s in (x, y))
    solid = Manifold.cube((x, y, z)) - _cylinder(a, b, z - deep, r, z)
    return RoundPart("round pocket", solid, _box_lines(x, y, z),
                     [(*_up(a, b, z - deep, r, deep), True)], 7, 0)  # fmt: skip


def boss(rng):
    x, y, z = _box(rng)
    r = rng.uniform(0.22, 0.36) * min(x, y)
    high = rng.uniform(0.5, 1.4)
    a, b = (rng.uniform(1.25 * r, s - 1.25 * r) for s in (x, y))
    solid = Manifold.cube((x, y, z)) + _cylinder(a, b, 0, r, z + high)
    return RoundPart("cylinder on a box", solid, _box_lines(x, y, z),
                     [(*_up(a, b, z, r, high), False)], 7, 0)  # fmt: skip


def bored_boss(rng):
    x, y, z = _box(rng)
    r = rng.uniform(0.3, 0.38) * min(x, y)
    inner = rng.uniform(0.45, 0.65) * r
    high = rng.uniform(0.5, 1.2)
    a, b = (rng.uniform(1.25 * r, s - 1.25 * r) for s in (x, y))
    solid = Manifold.cube((x, y, z)) + _cylinder(a, b, 0, r, z + high)
    solid = solid - _cylinder(a, b, -1, inner, z + high + 2)
    walls = [(*_up(a, b, z, r, high), False), (*_up(a, b, 0, inner, z + high), True)]
    return RoundPart("boss with a hole", solid, _box_lines(x, y, z), walls, 7, 1)


def cylinder(rng):
    r, h = rng.uniform(0.6, 1.4), rng.uniform(0.7, 2.6)
    return RoundPart("cylinder", _cylinder(0, 0, 0, r, h), np.zeros((0, 2, 3)),
                     [(*_up(0, 0, 0, r, h), False)], 2, 0)  # fmt: skip


def tube(rng):
    r, h = rng.uniform(0.7, 1.4), rng.uniform(0.7, 2.6)
    inner = rng.uniform(0.45, 0.75) * r
    solid = _cylinder(0, 0, 0, r, h) - _cylinder(0, 0, -1, inner, h + 2)
    walls = [(*_up(0, 0, 0, r, h), False), (*_up(0, 0, 0, inner, h), True)]
    return RoundPart("tube", solid, np.zeros((0, 2, 3)), walls, 2, 1)


def _plate(outline, z):
    return CrossSection([np.asarray(outline, float)]).extrude(z)


def link(rng, both=True, bored=True):
    """A bar with a round end, or two, and holes in them."""
    w, length, z = rng.uniform(0.9, 1.6), rng.uniform(2.2, 3.6), rng.uniform(0.35, 1.0)
    r = w / 2
    turn = np.linspace(-np.pi / 2, np.pi / 2, FACETS // 2 + 1)
    right = np.column_stack((length + r * np.cos(turn), r * np.sin(turn)))
    left = np.column_stack((-r * np.cos(turn[::-1]), r * np.sin(turn[::-1])))
    outline = np.vstack((right, left if both else [(0.0, r), (0.0, -r)]))
    solid = _plate(outline, z)
    walls = [(*_up(length, 0, 0, r, z, -np.pi / 2, np.pi / 2), False)]
    lines = [((0, s * r, k), (length, s * r, k)) for s in (-1, 1) for k in (0, z)]
    planes = 4
    if both:
        walls.append((*_up(0, 0, 0, r, z, np.pi / 2, 3 * np.pi / 2), False))
    else:
        lines += [((0, -r, k), (0, r, k)) for k in (0, z)]
        lines += [((0, s * r, 0), (0, s * r, z)) for s in (-1, 1)]
        planes = 5
    genus = 0
    if bored:
        inner = rng.uniform(0.4, 0.6) * r
        for at in (length, 0.0) if both else (length,):
            solid = solid - _cylinder(at, 0, -1, inner, z + 2)
            walls.append((*_up(at, 0, 0, inner, z), True))
            genus += 1
    name = "slotted link" if both else "rounded end"
    return RoundPart(name, solid, np.array(lines, float), walls, planes, genus)


def bracket(rng):
    return link(rng, both=False, bored=bool(rng.random() < 0.5))


def rounded(rng, count=1):
    """A box of which upright edges are round."""
    x, y, z = _box(rng)
    r = rng.uniform(0.2, 0.38) * min(x, y)
    corners = [(0, 0), (x, 0), (x, y), (0, y)]
    chosen = sorted(rng.permutation(4)[:count].tolist())
    outline, walls, lines = [], [], []
    begins, ends = {}, {}
    for k, (a, b) in enumerate(corners):
        if k not in chosen:
            outline.append((a, b))
            begins[k] = ends[k] = (a, b)
            lines.append(((a, b, 0), (a, b, z)))
            continue
        cx, cy = a + (r if a == 0 else -r), b + (r if b == 0 else -r)
        begin = np.pi + k * np.pi / 2
        turn = begin + np.linspace(0, np.pi / 2, FACETS // 4 + 1)
        arc = np.column_stack((cx + r * np.cos(turn), cy + r * np.sin(turn)))
        outline += [tuple(p) for p in arc]
        begins[k], ends[k] = tuple(arc[0]), tuple(arc[-1])
        walls.append((*_up(cx, cy, 0, r, z, begin, begin + np.pi / 2), False))
    for k in range(4):
        one, other = ends[k], begins[(k + 1) % 4]
        lines += [((*one, level), (*other, level)) for level in (0, z)]
    name = "rounded edge" if count == 1 else "four rounded edges"
    return RoundPart(name, _plate(outline, z), np.array(lines, float), walls, 6, 0)


def four_rounded(rng):
    return rounded(rng, 4)


def axle(rng):
    """A wheel on an axle that comes out on both sides."""
    r, h = rng.uniform(1.0, 1.5), rng.uniform(0.4, 0.8)
    thin, out = rng.uniform(0.3, 0.45) * r, rng.uniform(0.8, 1.6)
    solid = _cylinder(0, 0, 0, r, h) + _cylinder(0, 0, 0, thin, h + out)
    walls = [(*_up(0, 0, 0, r, h), False), (*_up(0, 0, h, thin, out), False)]
    return RoundPart("wheel on an axle", solid, np.zeros((0, 2, 3)), walls, 3, 0)


PARTS: dict[str, Callable] = {
    "hole in a box": hole,
    "round pocket": pocket,
    "cylinder on a box": boss,
    "boss with a hole": bored_boss,
    "cylinder": cylinder,
    "tube": tube,
    "wheel on an axle": axle,
    "rounded end": bracket,
    "slotted link": link,
    "rounded edge": rounded,
    "four rounded edges": four_rounded,
}


TOWARD_EYE = ("round pocket", "cylinder on a box", "boss with a hole", "wheel on an axle")
"""Parts of which what is round is on one side, which is drawn so that it is seen."""


def round_view(name: str, seed: int) -> RoundView | None:
    """See a part by chance from a random side; None where corners lie on one another."""
    for number in range(60):
        rng = np.random.default_rng((31, list(PARTS).index(name), seed, number))
        part = PARTS[name](rng)
        shift = int(rng.integers(3))
        turn = random_rotation(rng)
        flipped = 1.0 if rng.random() < 0.5 else -1.0
        if name in TOWARD_EYE:
            outward = np.roll((0.0, 0.0, flipped), shift) @ turn.T
            flipped = flipped if outward[2] < 0.0 else -flipped

        def seen(points, shift=shift, turn=turn, flipped=flipped):
            points = np.asarray(points, float).reshape(-1, 3)
            points = points * (1.0, flipped, flipped)
            return np.roll(points, shift, axis=1) @ turn.T

        mesh = part.solid.to_mesh()
        points = seen(np.asarray(mesh.vert_properties)[:, :3])
        low, high = points[:, :2].min(0), points[:, :2].max(0)
        size = float(np.linalg.norm(high - low))
        middle = np.array((*(low + high) / 2, points[:, 2].mean()))
        origin = seen(np.zeros(3))

        def place(points, seen=seen, middle=middle, size=size):
            return (seen(points) - middle) / size

        def way(vector, seen=seen, origin=origin, size=size):
            return (seen(vector) - origin)[0] / size

        corners = place(np.asarray(mesh.vert_properties)[:, :3])
        lines = place(part.lines.reshape(-1, 3)).reshape(-1, 2, 3)
        walls = [
            (Arc(place(a.center)[0], way(a.first), way(a.second), a.begin, a.end), way(h), hollow)
            for a, h, hollow in part.cylinders
        ]
        if not _is_general(lines, walls):
            continue
        triangles = np.asarray(mesh.tri_verts)
        # handedness: right, up, away is a left-handed frame
        solid = Manifold(Mesh(corners.astype(np.float32), triangles.astype(np.uint32)))
        if solid.volume() < 0:
            solid = Manifold(Mesh(corners.astype(np.float32), triangles[:, ::-1].astype(np.uint32)))
        return RoundView(part, corners[triangles], solid, lines, walls)
    return None


def square_lines(walls):
    """Return lines along the edges that arcs round off, and along square ends, (m, 2, 3)."""
    found = []
    for arc, along, _ in walls:
        if arc.whole:
            continue
        begin, end = arc.at(np.array((arc.begin, arc.end)))
        half = 0.5 * (arc.begin + arc.end)
        if arc.end - arc.begin < 2.0:
            corners = [begin + end - arc.center]
        else:
            outward = arc.at(np.array([half]))[0] - arc.center
            corners = [begin + outward, end + outward]
            found += [(corners[0] + k * along, corners[1] + k * along) for k in (0.0, 1.0)]
        found += [(corner, corner + along) for corner in corners]
    return np.array(found).reshape(-1, 2, 3)


def _is_general(lines, walls):
    """Whether corners, rounded ones too, are apart on the sheet, and off lines of others."""
    lines = np.concatenate((lines, square_lines(walls)))
    if len(lines):
        ends = np.unique(np.round(lines.reshape(-1, 3), 9), axis=0)[:, :2]
        apart = np.linalg.norm(ends[:, None] - ends, axis=2) + np.eye(len(ends))
        if apart.min() < 0.03:
            return False
        begin, span = lines[:, 0, :2], lines[:, 1, :2] - lines[:, 0, :2]
        share = ((ends[:, None] - begin) * span).sum(2) / (span**2).sum(1)
        foot = begin + np.clip(share, 0, 1)[..., None] * span
        away = np.linalg.norm(ends[:, None] - foot, axis=2)
        if ((away < 0.012) & (share > 0.02) & (share < 0.98)).any():
            return False
    for arc, along, _ in walls:
        normal = np.cross(arc.first, arc.second)
        tilt = abs(normal[2]) / np.linalg.norm(normal)
        if not 0.25 < tilt < 0.92 or np.linalg.norm(along[:2]) < 0.05:
            return False
        if np.linalg.norm(arc.first) < 0.05:
            return False
    return True


def hidden(seen: RoundView, points: np.ndarray) -> np.ndarray:
    """Whether points on the surface lie behind it."""
    corners = seen.triangles
    toward = np.array((0.0, 0.0, -1.0))
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    cross = np.cross(toward, second)
    level = (cross * first).sum(1)
    level = np.where(np.abs(level) < 1e-12, 1e-12, level)
    start = points[:, None] - corners[None, :, 0]
    u = (start * cross).sum(2) / level
    turn = np.cross(start, first[None])
    v = (turn @ toward) / level
    t = (turn * second).sum(2) / level
    return ((u > 1e-6) & (v > 1e-6) & (u + v < 1 - 1e-6) & (t > 6e-3)).any(1)


def sides(seen: RoundView) -> np.ndarray:
    """Return the sides of cylinders as they are seen, (m, 2, 3)."""
    found = []
    for arc, along, _ in seen.cylinders:
        # normal cos a · first + sin a · second has no part along the line of sight
        angle = float(np.arctan2(-arc.first[2], arc.second[2]))
        for a in (angle, angle + np.pi):
            inside = (a - arc.begin) % (2 * np.pi)
            if arc.whole or 0.05 < inside < arc.end - arc.begin - 0.05:
                begin = arc.at(np.array([a]))[0]
                found.append((begin, begin + along))
    return np.array(found).reshape(-1, 2, 3)


def strokes_of(
    seen: RoundView, hand: Hand, seed: int, *, hidden_rims: bool = True
) -> tuple[Stroke, ...]:
    """Draw a part: straight edges as `hand.strokes_of` does, rims in the parts that are seen.

    Parameters
    ----------
    seen : RoundView
    hand : Hand
        Centre and half axes of an ellipse are as far off as ends of lines are, and it wobbles as
        much, in three waves, where its radius is a tenth of the drawing or more.
    seed : int
    hidden_rims : bool
        Whether what is hidden of rims and sides is drawn, in light dashes; otherwise not at all.
    """
    rng = np.random.default_rng((seed, 78))
    paths: list[tuple[np.ndarray, float]] = []
    for begin, end in seen.lines:
        share = np.linspace(0.06, 0.94, 9)[:, None]
        unseen = hidden(seen, begin + share * (end - begin)).mean() > 0.5
        paths += _drawn_line(begin[:2], end[:2], bool(unseen), hand, rng)
    for begin, end in sides(seen):
        share = np.linspace(0.06, 0.94, 9)[:, None]
        unseen = hidden(seen, begin + share * (end - begin)).mean() > 0.5
        if hidden_rims or not unseen:
            paths += _drawn_line(begin[:2], end[:2], bool(unseen), hand, rng)
    for arc, along, _ in seen.cylinders:
        for level in (0.0, 1.0):
            shifted = Arc(arc.center + level * along, arc.first, arc.second, arc.begin, arc.end)
            paths += _drawn_arc(seen, shifted, hand, rng, hidden_rims)
    order = rng.permutation(len(paths))
    return tuple(stroke(paths[k][0] * TO_CANVAS * SIZE + 600.0, paths[k][1]) for k in order)


def _drawn_line(begin, end, unseen, hand, rng):
    length = float(np.linalg.norm(end - begin))
    across = np.array((-(end - begin)[1], (end - begin)[0])) / length
    if not unseen:
        p, q = (place + rng.normal(0, hand.jitter / 2, 2) for place in (begin, end))
        x = np.linspace(0, 1, max(8, int(length * 200)))
        off = hand.wobble * rng.normal() * np.sin(np.pi * x) + rng.normal(0, hand.tremble, len(x))
        points = p + (q - p) * x[:, None] + off[:, None] * across
        return [(points if rng.random() < 0.5 else points[::-1], 0.8)]
    count = max(2, round(length / 0.04))
    offset = across * rng.normal(0, hand.jitter / 2)
    made = []
    for k in range(count):
        first, last = k / count, 1.0 if k == count - 1 else (k + 0.62) / count
        p, q = (
            begin + (end - begin) * at + rng.normal(0, hand.jitter / 5, 2) + offset
            for at in (first, last)
        )
        made.append((p + (q - p) * np.linspace(0, 1, 8)[:, None] + rng.normal(0, 0.0005, (8, 2)),
                     0.35))  # fmt: skip
    return made


def _drawn_arc(seen, arc, hand, rng, hidden_rims):
    """An arc in its runs that are seen and that are not; each run is jittered by itself."""
    angles = np.linspace(arc.begin, arc.end, 121)
    places = arc.at(angles)
    unseen = hidden(seen, places + np.array((0.0, 0.0, -1e-4)))
    runs = []
    start = 0
    for k in range(1, 122):
        if k == 121 or unseen[k] != unseen[start]:
            runs.append((start, k - 1, bool(unseen[start])))
            start = k
    runs = [run for run in runs if run[1] - run[0] >= 4]
    if not runs:
        return []
    if arc.whole and len(runs) > 1 and runs[0][2] == runs[-1][2]:
        first, last = runs[0], runs[-1]
        runs = [*runs[1:-1], (last[0], first[1] + 120, first[2])]
    made = []
    for first, last, is_hidden in runs:
        begin, end = arc.begin + (arc.end - arc.begin) * np.array((first, last)) / 120.0
        whole = arc.whole and last - first >= 119
        if is_hidden and not hidden_rims:
            continue
        center, one, two = (v[:2] for v in (arc.center, arc.first, arc.second))
        jitter = hand.jitter / 2
        center = center + rng.normal(0, jitter, 2)
        scale = 1.0 + rng.normal(0, jitter, 2) / np.linalg.norm((one, two), axis=1)
        one, two = one * scale[0], two * scale[1]
        radius = float(np.sqrt(np.linalg.norm(one) * np.linalg.norm(two)))
        waves = rng.normal(0, hand.wobble * min(1.0, radius / 0.1) / np.sqrt(3), 3)
        phases = rng.uniform(0, 2 * np.pi, 3)

        def path(low, high, one=one, two=two, center=center, waves=waves, phases=phases,
                 radius=radius):  # fmt: skip
            turn = np.linspace(low, high, max(8, int((high - low) * radius * 200)))
            off = 1.0 + sum(
                w * np.cos((k + 1) * turn + p) for k, (w, p) in enumerate(zip(waves, phases,
                                                                               strict=True))
            ) / radius  # fmt: skip
            points = center + (off[:, None] * np.column_stack((np.cos(turn), np.sin(turn)))) @ (
                np.array((one, two))
            )
            return points + rng.normal(0, hand.tremble, points.shape)

        if whole:
            begin = begin + rng.uniform(0, 2 * np.pi)
            turns = 1.5 if rng.random() < hand.retraced else 1.0 + rng.uniform(-0.02, 0.06)
            end = begin + 2 * np.pi * turns
        if not is_hidden:
            if whole and rng.random() < hand.split:
                cut = begin + rng.uniform(0.4, 0.6) * (end - begin)
                made += [(path(begin, cut), 0.8), (path(cut, end), 0.8)]
            else:
                points = path(begin, end)
                made.append((points if rng.random() < 0.5 else points[::-1], 0.8))
            continue
        count = max(2, round((end - begin) * radius / 0.04))
        steps = begin + (end - begin) * np.arange(count + 1) / count
        for k in range(count):
            last_one = steps[k + 1] if k == count - 1 else steps[k] + 0.62 * (steps[1] - steps[0])
            made.append((path(steps[k], last_one), 0.35))
    return made
