"""Characters to rig: outlines put together from limbs, and how their skins stretch."""

from __future__ import annotations

import itertools

import numpy as np
import shapely
from scipy.spatial.transform import Rotation

from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Job
from bozzetto.view import Camera
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.modeler import Silhouette

FRONT = Camera("orthographic", eye=(0, -500, 0), height=300.0, viewport=(900, 900))

MODELER = Silhouette()


def drawn(points, camera=FRONT):
    """A stroke through places on the sheet, mm."""
    pixels, _ = camera.project(np.column_stack([points[:, 0], 0 * points[:, 0], points[:, 1]]))
    return Stroke(*pixels.T, camera)


def state_of_rings(rings, resolution=64):
    """One part of closed rings, mm."""
    strokes = Strokes(drawn(np.vstack([ring, ring[:1]])) for ring in rings)
    return SilhouetteState(
        nodes=(Part(id="n1", name="Part 1", strokes=strokes),), resolution=resolution
    )


def fitted(rings, size=160.0):
    """Rings of a picture, y down, brought to a size around the middle, y up."""
    rings = [ring * [1.0, -1.0] for ring in rings]
    low, high = np.vstack(rings).min(axis=0), np.vstack(rings).max(axis=0)
    return [(ring - 0.5 * (low + high)) * size / (high - low).max() for ring in rings]


def limb(*balls):
    """The hull of each two balls (x, y, radius) in a row."""
    discs = [shapely.Point(x, y).buffer(r, 32) for x, y, r in balls]
    hulls = [a.union(b).convex_hull for a, b in itertools.pairwise(discs)]
    return shapely.unary_union(hulls)


def man(arms=0.0, seed=None):
    """The outline of a person who faces us, (n, 2), mm; arms raised by degrees.

    With a seed no two measures are those of another.
    """
    share = (lambda: 1.0) if seed is None else np.random.default_rng(seed).uniform
    vary = (lambda v: v) if seed is None else (lambda v: v * share(0.85, 1.15))
    pieces = [
        limb((0, -20, vary(17)), (0, 25, vary(20))),
        limb((0, 25, 10), (0, 50, 9)),
        shapely.Point(0, 62).buffer(vary(17), 32),
    ]
    turn = np.radians(arms)
    arm = np.array([[31, -4], [63, -12], [71, -14]]) * vary(1.0)
    arm = arm @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]] + [9, 32]
    leg = np.array([[16, -60], [18, -85], [24, -88]]) * vary(1.0)
    thick, thin = vary(9), vary(7)
    for side in (-1, 1):
        pieces.append(limb((9 * side, 32, thick), *((side * x, y, thin) for x, y in arm)))
        pieces.append(limb((9 * side, -25, 11), *((side * x, y, thin) for x, y in leg)))
    rounded = shapely.unary_union(pieces).buffer(-3).buffer(6).buffer(-3)
    return np.array(rounded.exterior.coords)[:-1]


def person_of_parts(seed, ears=True):
    """A person who faces us, every limb an outline of its own as a hand draws it.

    Broad ends of limbs lie in the body, feet and ears are parts too, in a random order.
    """
    rng = np.random.default_rng(seed)
    vary = lambda v: v * rng.uniform(0.85, 1.15)  # noqa: E731
    body, tall = vary(28), vary(40)
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ball = np.column_stack([np.cos(angle), np.sin(angle)])
    rings = [ball * [body, tall], ball * vary(20) + [0, tall + 14]]
    shoulder, hand, hip, foot = vary(0.5 * tall), vary(55), vary(12), tall + vary(45)
    reach = body + hand
    arm = [[0.6 * body, shoulder + 7], [reach, shoulder - 36], [reach - 3, shoulder - 48],
           [0.7 * body, shoulder - 16]]  # fmt: skip
    leg = [[hip - 8, -0.7 * tall], [hip + 8, -0.7 * tall], [hip + 11, -foot], [hip - 3, -foot]]
    shoe = [[hip - 5, 6 - foot], [hip + 12, 6 - foot], [hip + 24, -foot - 7], [hip - 5, -foot - 8]]
    pairs = [arm, leg, shoe]
    if ears:
        top = tall + 28
        pairs.append([[5, top], [14, top - 4], [vary(16), top + 32], [vary(11), top + 33]])
    for ring in pairs:
        for side in (-1.0, 1.0):
            jitter = rng.normal(0.0, 0.4, (4, 2))
            rings.append(shapely.Polygon((np.array(ring) + jitter) * [side, 1.0]))
    nodes = []
    for number, ring in enumerate(rings, 1):
        if isinstance(ring, shapely.Polygon):
            ring = np.array(ring.buffer(2.0, 8).exterior.segmentize(4.0).coords)[:-1]
        strokes = Strokes([drawn(np.vstack([ring, ring[:1]]))])
        nodes.append(Part(id=f"n{number}", name=f"Part {number}", strokes=strokes))
    order = [0, *(1 + rng.permutation(len(nodes) - 1))]
    return SilhouetteState(nodes=tuple(nodes[k] for k in order), resolution=48)


def dense(skin):
    """Weights as a table, (v, n)."""
    table = np.zeros((len(skin.weights), len(skin.rig.joints)))
    np.add.at(table, (np.arange(len(table))[:, None], skin.joints.astype(int)), skin.weights)
    return table


def followers(skin):
    """The share of each vertex that follows a joint or one beyond it, (v, n)."""
    table = dense(skin)
    for joint in range(len(skin.rig.parents) - 1, 0, -1):
        if skin.rig.parents[joint] >= 0:
            table[:, skin.rig.parents[joint]] += table[:, joint]
    return table


def stretches(mesh, skin, degrees=40.0):
    """For each joint the largest ratio of an edge's length after and before a turn about any axis.

    Linear blend skinning, written down anew: x + C (R - 1)(x - p).
    """
    vertices = mesh.vertices.astype(float)
    edges = np.sort(np.concatenate([mesh.faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    a, b = np.unique(edges, axis=0).T
    length = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    real = length > 1e-6 * np.ptp(vertices, axis=0).max()
    moved = followers(skin)
    worst = np.ones(len(skin.rig.joints))
    axes = [*np.eye(3), *-np.eye(3), *(np.array([[1, 1, 1], [1, -1, 0], [0, 1, -1]]) / 1.6)]
    for joint, place in enumerate(skin.rig.joints):
        for axis in axes:
            vector = np.radians(degrees) * axis / np.linalg.norm(axis)
            turn = Rotation.from_rotvec(vector).as_matrix()
            after = vertices + moved[:, [joint]] * ((vertices - place) @ (turn - np.eye(3)).T)
            ratio = np.linalg.norm(after[a] - after[b], axis=1)[real] / length[real]
            worst[joint] = max(worst[joint], ratio.max())
    return worst


def solid_of(state):
    """The solid of a state, with its skin."""
    return MODELER.shapes(state, MODELER.solve(state, Job("preview"))).solids[0]
