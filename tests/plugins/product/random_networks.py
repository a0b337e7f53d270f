"""Networks from seeds: cells of bodies, sheets with T-joints, tubes; faults of the hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import SphericalVoronoi

from bozzetto.arrays import Array
from tests.plugins.product.sketched_network import Sketch


def cells(seed: int) -> Sketch:
    """A closed body of 8 to 24 cells with three to eight sides, three at each node."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(int(random.integers(8, 25)), 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(3):
        cell = SphericalVoronoi(points)
        points = np.array([cell.vertices[region].mean(axis=0) for region in cell.regions])
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    cell = SphericalVoronoi(points)
    cell.sort_vertices_of_regions()
    axes = random.uniform(30, 100, 3)
    bend = random.uniform(-0.4, 0.4)

    def lifted(place: Array) -> Array:
        x, y, z = place / np.linalg.norm(place) * axes
        return np.array([x, y, z + bend * x * x / axes[0]])

    s = Sketch()
    used = sorted({int(each) for region in cell.regions for each in region})
    for number in used:
        s.nodes[f"n{number}"] = lifted(cell.vertices[number])
    drawn: set[frozenset[int]] = set()
    for region in cell.regions:
        for first, second in zip(region, region[1:] + region[:1], strict=True):
            if frozenset((first, second)) not in drawn:
                drawn.add(frozenset((first, second)))
                ends = cell.vertices[first], cell.vertices[second]
                inner = (lifted((1 - t) * ends[0] + t * ends[1]) for t in (0.33, 0.67))
                s.curve(f"n{first}", *inner, f"n{second}")
        s.face(" ".join(f"n{each}" for each in region))
    return s


def quilt(seed: int) -> Sketch:
    """A bent sheet divided again and again, so that curves end on others."""
    random = np.random.default_rng(seed)
    height, tilt = random.uniform(-0.4, 0.4, 2)

    def lifted(u: float, v: float) -> Array:
        return 100 * np.array([u, v, height * u * u + tilt * u * v + 0.2 * np.sin(3 * v)])

    boxes = [(0.0, 1.0, 0.0, 1.0)]
    lines: list[tuple[int, float, float, float]] = [
        (0, 0.0, 0.0, 1.0),
        (0, 1.0, 0.0, 1.0),
        (1, 0.0, 0.0, 1.0),
        (1, 1.0, 0.0, 1.0),
    ]
    for _ in range(int(random.integers(4, 14))):
        sizes = [(u1 - u0) * (v1 - v0) for u0, u1, v0, v1 in boxes]
        u0, u1, v0, v1 = boxes.pop(int(np.argmax(sizes)))
        share = random.uniform(0.35, 0.65)
        if u1 - u0 > v1 - v0:
            at = u0 + share * (u1 - u0)
            boxes += [(u0, at, v0, v1), (at, u1, v0, v1)]
            lines.append((0, at, v0, v1))
        else:
            at = v0 + share * (v1 - v0)
            boxes += [(u0, u1, v0, at), (u0, u1, at, v1)]
            lines.append((1, at, u0, u1))
    s = Sketch()
    corners = {(u, v) for u0, u1, v0, v1 in boxes for u in (u0, u1) for v in (v0, v1)}
    names = {corner: f"n{k}" for k, corner in enumerate(sorted(corners))}
    for corner, name in names.items():
        s.nodes[name] = lifted(*corner)
    for way, at, low, high in lines:
        on = sorted(each[1 - way] for each in corners if each[way] == at)
        on = [each for each in on if low <= each <= high]
        places: list[str | Array] = []
        for number, each in enumerate(on):
            if number:
                middle = 0.5 * (each + on[number - 1])
                places.append(lifted(*((at, middle) if way == 0 else (middle, at))))
            places.append(names[(at, each) if way == 0 else (each, at)])
        s.curve(*places)
    for u0, u1, v0, v1 in boxes:
        sides = [
            (1, v0, u0, u1, False),
            (0, u1, v0, v1, False),
            (1, v1, u0, u1, True),
            (0, u0, v0, v1, True),
        ]
        ring = []
        for way, at, low, high, back in sides:
            on = sorted(
                (each[1 - way], name)
                for each, name in names.items()
                if each[way] == at and low <= each[1 - way] <= high
            )
            ring += [name for _, name in (reversed(on[1:]) if back else on[:-1])]
        s.face(" ".join(ring))
    return s


def tube(seed: int) -> Sketch:
    """A bent tube of changing width: rings cut by three to six profiles, open or closed ends."""
    random = np.random.default_rng(seed)
    count, rings = int(random.integers(3, 7)), int(random.integers(2, 6))
    radius = random.uniform(15, 40, rings + 2)
    bend = random.uniform(-0.01, 0.01)
    squash = random.uniform(0.5, 1.0)

    def at(i: float, k: float) -> Array:
        r = float(np.interp(i, range(rings), radius[:rings]))
        angle = 2 * np.pi * k / count
        x = 60.0 * i
        return np.array(
            [x, r * np.cos(angle), squash * r * np.sin(angle) + bend * (x - 30 * rings) ** 2]
        )

    s = Sketch()
    for i in range(rings):
        for k in range(count):
            s.nodes[f"n{i}.{k}"] = at(i, k)
        for k in range(count):
            s.curve(f"n{i}.{k}", at(i, k + 0.33), at(i, k + 0.67), f"n{i}.{(k + 1) % count}")
    for k in range(count):
        s.curve(*(f"n{i}.{k}" for i in range(rings)))
        n = (k + 1) % count
        for i in range(rings - 1):
            s.face(f"n{i}.{k} n{i + 1}.{k} n{i + 1}.{n} n{i}.{n}")
    if random.random() < 0.5:
        s.nodes["tip"] = at(rings - 1, 0) * [0, 0, 0] + [
            60.0 * rings,
            0,
            bend * (60.0 * rings - 30 * rings) ** 2,
        ]
        for k in range(count):
            s.curve(f"n{rings - 1}.{k}", "tip")
            s.face(f"n{rings - 1}.{k} n{rings - 1}.{(k + 1) % count} tip")
    return s


def faulty(
    sketch: Sketch, seed: int, *, noise: float = 0.01, missing: float = 0.0, over: float = 0.0
) -> Sketch:
    """Return a network with the faults of a hand.

    Each curve sways with three waves of its own, and takes along what ends on its inside; corners
    move by themselves.

    Parameters
    ----------
    sketch : Sketch
    seed : int
    noise : float
        Standard deviation of corners, per diagonal of the box around all, and of each wave's
        height, per length of the curve and number of the wave.
    missing, over : float
        Shares of the curves with an end that misses its joint, and that is drawn too far.
    """
    random = np.random.default_rng(seed)
    made = replace(sketch, nodes={}, curves={})
    size = float(np.linalg.norm(np.ptp(np.array(list(sketch.nodes.values())), axis=0)))
    sways, inside = {}, {name: [] for name in sketch.nodes}
    for name, (places, closed, _) in sketch.curves.items():
        points = np.array([sketch.place(each) for each in places])
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        along = np.concatenate(([0.0], np.cumsum(steps)))
        heights = random.normal(size=(3, 3)) * noise * along[-1] / np.arange(1, 4)[:, None]
        share = along / along[-1]
        sways[name] = np.sin(np.pi * np.outer(share, np.arange(1, 4))) @ heights
        for k, each in enumerate(places):
            if isinstance(each, str) and (closed or 0 < k < len(places) - 1):
                flip = [1, -1, 1] if each.endswith("'") else 1
                inside[each.removesuffix("'")].append(sways[name][k] * flip)
    for name, place in sketch.nodes.items():
        corner = random.normal(size=3) * noise * size
        step = np.mean(inside[name], axis=0) if inside[name] else corner
        on_plane = sketch.mirror and abs(place[1]) < 1e-12
        made.nodes[name] = place + step * ([1, 0, 1] if on_plane else [1, 1, 1])
    for name, (places, closed, mirrored) in sketch.curves.items():
        through = _swayed(sketch, made, places, sways[name])
        fault = random.random()
        if not closed and fault < missing + over:
            _spoil_end(made, through, random, fault < missing)
        made.curves[name] = (tuple(through), closed, mirrored)
    return made


def _swayed(
    before: Sketch, after: Sketch, places: tuple[str | Array, ...], sway: Array
) -> list[str | Array]:
    """Return where a curve runs through: it sways between nodes that moved."""
    points = np.array([before.place(each) for each in places])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate(([0.0], np.cumsum(steps)))
    at_node = [k for k, each in enumerate(places) if isinstance(each, str)]
    moves = np.array([after.place(places[k]) - points[k] - sway[k] for k in at_node])
    rest = np.stack([np.interp(along, along[at_node], column) for column in moves.T], axis=1)
    moved = points + sway + rest
    flat = before.mirror and np.abs(points[:, 1]).max() < 1e-12
    moved[:, 1] *= not flat
    return [each if isinstance(each, str) else moved[k] for k, each in enumerate(places)]


def _spoil_end(
    sketch: Sketch, through: list[str | Array], random: np.random.Generator, missing: bool
) -> None:
    """Draw one end of a curve short of its joint, or beyond it."""
    end = int(random.integers(2)) * (len(through) - 1)
    place, inner = (sketch.place(through[k]) for k in (end, 1 if end == 0 else -2))
    if missing:
        through[end] = place - 0.05 * (place - inner)
    else:
        through.insert(end + (end > 0), place + random.uniform(0.05, 0.2) * (place - inner))
