"""Machine parts with flat faces as a CAD program makes them, that nothing was fitted to.

Profiles, shafts of hexagonal section, gussets, ribs, pockets in pockets, chamfers and tapers. Sides
are thinner, corners closer, and lines more than in ``cad_parts.py`` and ``workshop_parts.py``. The
measurements of a part are chance within limits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from manifold3d import CrossSection, Manifold

from tests.plugins.polyhedron.cad_parts import Random, extruded, regular, upright
from tests.plugins.polyhedron.objects import Polyhedron, box, chance_made
from tests.plugins.polyhedron.workshop_parts import trimmed

THINNEST = 0.045
"""Least length of an edge, and distance of a vertex from a foreign edge, in diagonals."""


def tapered(below: object, height: float, share: float) -> Manifold:
    """Return a frustum over an outline about the origin, from z = 0."""
    return CrossSection([np.asarray(below, float)]).extrude(height, scale_top=(share, share))


def rectangle(w: float, d: float) -> np.ndarray:
    """Return a rectangle about the origin, (4, 2)."""
    return 0.5 * np.array([(-w, -d), (w, -d), (w, d), (-w, d)])


def _l_outline(w: float, h: float, t: float) -> list[tuple[float, float]]:
    return [(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)]


def angle_with_rib(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((2.2, 2.2, 2.0, 0.35), (3.0, 3.0, 2.8, 0.5))
    a = float(rng.uniform(0.5, 0.8))
    rib = upright([(0.5 * t, 0.5 * t), (t + a * (w - t), t), (t, t + a * (h - t))], 0.4)
    return upright(_l_outline(w, h, t), d) + rib.translate((0, 0.4 * d, 0))


def angle_with_notched_legs(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((2.0, 2.4, 2.0, 0.4), (2.8, 3.2, 2.6, 0.55))
    made = upright(_l_outline(w, h, t), d)
    made -= box((9, 0.35 * d, 9), (w - 0.35 * w, 0.33 * d, -1))
    return made - box((9, 0.3 * d, 9), (-1, 0.3 * d, 0.7 * h))


def angle_with_slanted_leg(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((2.0, 1.6, 2.0, 0.4), (2.8, 2.6, 2.6, 0.5))
    made = upright(_l_outline(w, h, t), d)
    return trimmed(made, (0.0, -1.0, -0.6), (0, d, 0.55 * h))


def hat_profile(rng: Random) -> Manifold:
    w, d, h, t, f = rng.uniform((1.6, 1.8, 1.2, 0.35, 0.7), (2.2, 3.0, 1.8, 0.45, 1.0))
    outline = [(-f, 0), (t, 0), (t, h - t), (w - t, h - t), (w - t, 0), (w + f, 0), (w + f, t),
               (w, t), (w, h), (0, h), (0, t), (-f, t)]  # fmt: skip
    return upright(outline, d)


def lipped_channel(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((2.2, 2.0, 1.8, 0.35), (2.8, 3.0, 2.4, 0.42))
    b = float(rng.uniform(0.35, 0.45)) * w
    outline = [(0, 0), (w, 0), (w, h), (w - b, h), (w - b, h - t), (w - t, h - t), (w - t, t),
               (t, t), (t, h - t), (b, h - t), (b, h), (0, h)]  # fmt: skip
    return upright(outline, d)


def z_profile_with_cut_end(rng: Random) -> Manifold:
    a, b, h, d, t = rng.uniform((1.0, 1.0, 1.6, 2.4, 0.38), (1.6, 1.6, 2.4, 3.2, 0.5))
    outline = [(0, 0), (a, 0), (a, h - t), (a + b, h - t), (a + b, h), (a - t, h), (a - t, t),
               (0, t)]  # fmt: skip
    return trimmed(upright(outline, d), (-0.45, -1.0, 0.0), (0, d, 0))


def t_beam_with_stiffener(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((1.8, 2.6, 1.6, 0.36), (2.4, 3.4, 2.2, 0.45))
    a = 0.5 * (w - t)
    outline = [(0, h - t), (a, h - t), (a, 0), (w - a, 0), (w - a, h - t), (w, h - t), (w, h),
               (0, h)]  # fmt: skip
    return upright(outline, d) + box((0.8 * a, 0.36, h - 0.5 * t), (w - 1.05 * a, 0.45 * d, 0))


def t_slot_nut(rng: Random) -> Manifold:
    w, d, h, k = rng.uniform((2.2, 1.8, 0.7, 0.7), (2.8, 2.4, 1.0, 1.0))
    a = 0.26 * w
    outline = [(0, 0), (w, 0), (w, h), (w - a, h), (w - a, h + k), (a, h + k), (a, h), (0, h)]
    return upright(outline, d) - box((0.24 * w, 0.36 * d, 9), (0.38 * w, 0.32 * d, -1))


def dovetail_key(rng: Random) -> Manifold:
    w, d, h = rng.uniform((1.6, 2.4, 0.9), (2.2, 3.2, 1.2))
    a = float(rng.uniform(0.18, 0.28)) * w
    made = upright([(a, 0), (w - a, 0), (w, h), (0, h)], d)
    return made - box((9, 0.34 * d, 9), (-1, 0.33 * d, 0.55 * h))


def dovetail_joint(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.2, 2.6, 0.8), (3.0, 3.2, 1.3))
    a, b, k = 0.36 * w, 0.24 * w, float(rng.uniform(0.6, 0.9))
    outline = [(0, 0), (w, 0), (w, d), (w - a, d), (w - b, d + k), (b, d + k), (a, d), (0, d)]
    return extruded(outline, h)


def stepped_hexagonal_shaft(rng: Random) -> Manifold:
    a, b, r = rng.uniform((0.8, 1.0, 0.55), (1.4, 1.8, 0.75))
    return extruded(regular(6, 1.1), a) + extruded(regular(6, r), a + b)


def hexagonal_shaft_with_square_ends(rng: Random) -> Manifold:
    a, b, c = rng.uniform((0.8, 0.7, 0.7), (1.4, 1.2, 1.2))
    made = extruded(regular(6, 1.1), a) + box((0.85, 0.85, b), (-0.42, -0.42, a - 0.01))
    return made + box((1.0, 1.0, c), (-0.5, -0.5, 0.01 - c))


def hexagonal_shaft_with_keyway(rng: Random) -> Manifold:
    h = float(rng.uniform(1.8, 2.8))
    return extruded(regular(6, 1.2), h) - box((0.7, 9, 9), (-0.35, 0.45, 0.45 * h))


def socket_head(rng: Random) -> Manifold:
    h = float(rng.uniform(0.9, 1.4))
    head = extruded(regular(8, 1.3), h)
    return head - extruded(regular(6, 0.6), 9).translate((0, 0, 0.45 * h))


def gusset_plate_with_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 2.2, 0.45), (3.2, 3.0, 0.8))
    k = float(rng.uniform(0.25, 0.35))
    made = extruded([(0, 0), (w, 0), (w, k * d), (k * w, d), (0, d)], h)
    return made - box((0.24 * w, 0.24 * d, 9), (0.16 * w, 0.18 * d, -1))


def corner_gusset(rng: Random) -> Manifold:
    w, t = rng.uniform((2.2, 0.4), (2.8, 0.55))
    made = box((w, w, t)) + box((t, w, w)) + box((w, t, w))
    k = 0.62 * w
    web = Manifold.hull_points([(t, t, t), (k, t, t), (t, k, t), (t, t, k)])
    return made + web


def pocket_in_pocket(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.8, 2.4, 1.4), (3.4, 3.0, 2.0))
    made = box((w, d, h)) - box((0.7 * w, 0.66 * d, 9), (0.14 * w, 0.16 * d, 0.62 * h))
    return made - box((0.34 * w, 0.34 * d, 9), (0.24 * w, 0.34 * d, 0.3 * h))


def block_with_lying_square_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 1.8, 1.6), (3.0, 2.6, 2.2))
    return box((w, d, h)) - box((9, 0.42 * d, 0.4 * h), (-1, 0.26 * d, 0.32 * h))


def block_with_diamond_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.2, 2.2, 0.8), (2.8, 2.8, 1.6))
    return box((w, d, h)) - extruded(regular(4, 0.62), 9).translate((0.46 * w, 0.52 * d, -1))


def step_wedge(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 1.4, 1.4), (3.4, 2.2, 2.0))
    a, b = float(rng.uniform(0.3, 0.45)) * w, float(rng.uniform(0.45, 0.6)) * h
    return upright([(0, 0), (w, 0), (w - a, b), (a, b), (a, h), (0, h)], d)


def wedge_with_slot(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.0, 1.4), (3.4, 2.8, 2.0))
    made = upright([(0, 0), (w, 0), (w, 0.25 * h), (0.2 * w, h), (0, h)], d)
    return made - box((9, 0.32 * d, 9), (0.5 * w, 0.33 * d, -1))


def pyramid_beside_the_middle(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.0, 0.6), (3.2, 2.6, 1.0))
    top = Manifold.hull_points([(0.2, 0.3, h), (0.2 + 0.55 * w, 0.3, h), (0.2, 0.3 + 0.5 * d, h),
                                (0.2 + 0.55 * w, 0.3 + 0.5 * d, h),
                                (0.2 + 0.27 * w, 0.3 + 0.25 * d, h + 1.2)])  # fmt: skip
    return box((w, d, h)) + top


def pencil(rng: Random) -> Manifold:
    h, k = rng.uniform((1.4, 0.8), (2.4, 1.4))
    rings = [(x, y, z) for z in (0, h) for x, y in regular(6, 0.9).tolist()]
    return Manifold.hull_points([*rings, (0, 0, h + k)])


def block_chamfered_all_round(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 1.6, 0.7), (2.8, 2.4, 1.2))
    c = float(rng.uniform(0.3, 0.45))
    rings = ((0, 0), (h, 0), (h + c, c))
    return Manifold.hull_points(
        [(x, y, z) for z, e in rings for x in (e, w - e) for y in (e, d - e)]
    )


def block_with_chamfered_edges_and_pocket(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.2, 1.0), (3.2, 2.8, 1.6))
    c = float(rng.uniform(0.4, 0.6))
    made = extruded([(c, 0), (w, 0), (w, d - c), (w - c, d), (0, d), (0, c)], h)
    return made - box((0.4 * w, 0.38 * d, 9), (0.28 * w, 0.3 * d, 0.5 * h))


def block_with_three_cut_corners(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.2, 2.0, 1.8), (2.8, 2.6, 2.4))
    made = box((w, d, h))
    for x, y, z in ((0, 0, 1), (1, 1, 1), (1, 0, 0)):
        normal = np.array((1 - 2 * x, 1 - 2 * y, 1 - 2 * z), float)
        corner = np.array((x * w, y * d, z * h)) + normal * (0, 0, rng.uniform(0.5, 0.8))
        made = trimmed(made, normal, corner)
    return made


def rib_between_blocks(rng: Random) -> Manifold:
    w, d, h = rng.uniform((3.0, 1.6, 1.2), (3.8, 2.2, 1.8))
    a = 0.28 * w
    made = box((a, d, h)) + box((a, d, 0.75 * h), (w - a, 0, 0))
    return made + box((w - 2 * a + 0.02, 0.3 * d, 0.5 * h), (a - 0.01, 0.35 * d, 0))


def two_bosses_on_plate(rng: Random) -> Manifold:
    w, d, h = rng.uniform((3.0, 2.0, 0.5), (3.8, 2.6, 0.8))
    made = box((w, d, h)) + box((0.24 * w, 0.4 * d, 0.9), (0.12 * w, 0.25 * d, h))
    return made + box((0.26 * w, 0.45 * d, 0.6), (0.58 * w, 0.3 * d, h))


def boss_with_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.8, 2.4, 0.5), (3.4, 3.0, 0.8))
    made = box((w, d, h)) + box((0.56 * w, 0.56 * d, 0.9), (0.2 * w, 0.22 * d, h))
    return made - box((0.26 * w, 0.26 * d, 9), (0.33 * w, 0.36 * d, -1))


def v_block_with_cross_slot(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.2, 2.4, 1.6), (3.0, 3.2, 2.2))
    k = float(rng.uniform(0.4, 0.5)) * h
    made = upright([(0, 0), (w, 0), (w, h), (0.8 * w, h), (w / 2, h - k), (0.2 * w, h), (0, h)], d)
    return made - box((9, 0.3 * d, 0.3 * h), (-1, 0.35 * d, -0.02))


def crank(rng: Random) -> Manifold:
    a, b, c, d = rng.uniform((1.0, 1.0, 1.2, 0.9), (1.4, 1.6, 1.8, 1.4))
    outline = [(0, 0), (a, 0), (a + b, c), (2 * a + b, c), (2 * a + b, c + 0.7), (0.8 * a + b,
               c + 0.7), (0.8 * a, 0.7), (0, 0.7)]  # fmt: skip
    return upright(outline, d)


def hook(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((2.0, 1.0, 2.2, 0.4), (2.6, 1.8, 3.0, 0.55))
    outline = [(0, 0), (w, 0), (w, 0.45 * h), (w - t, 0.45 * h), (w - t, t), (t, t), (t, h - t),
               (0.6 * w, h - t), (0.6 * w, h), (0, h)]  # fmt: skip
    return upright(outline, d)


def clamp(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((2.2, 1.0, 2.2, 0.5), (2.8, 1.8, 2.8, 0.65))
    outline = [(0, 0), (w, 0), (w, t), (t, t), (t, h - 1.2 * t), (w, h - t), (w, h - 0.3 * t),
               (0.3 * w, h), (0, h)]  # fmt: skip
    return upright(outline, d)


def bridge(rng: Random) -> Manifold:
    w, d, h = rng.uniform((3.0, 1.2, 1.4), (3.8, 2.0, 2.0))
    outline = [(0, 0), (0.18 * w, 0), (0.32 * w, 0.6 * h), (0.68 * w, 0.6 * h), (0.82 * w, 0),
               (w, 0), (w, h), (0, h)]  # fmt: skip
    return upright(outline, d)


def plug(rng: Random) -> Manifold:
    w, d, h = rng.uniform((1.8, 1.6, 1.2), (2.4, 2.2, 1.8))
    made = tapered(rectangle(w, d), h, 0.72)
    return made + box((1.25 * w, 1.25 * d, 0.5), (-0.625 * w, -0.625 * d, -0.5))


def cover(rng: Random) -> Manifold:
    w, d, h, t = rng.uniform((2.4, 2.0, 0.9, 0.35), (3.0, 2.6, 1.3, 0.45))
    made = box((w, d, h)) - box((w - 2 * t, d - 2 * t, h), (t, t, -t))
    return made + box((0.3 * w, 0.3 * d, 0.4), (0.35 * w, 0.3 * d, h))


def octagonal_ring(rng: Random) -> Manifold:
    h, r = rng.uniform((0.5, 0.65), (1.2, 0.8))
    inner = extruded(regular(8, r), 9).translate((0, 0, -1))
    return extruded(regular(8, 1.3), h) - inner


def chevron(rng: Random) -> Manifold:
    w, h, d, t = rng.uniform((2.4, 0.8, 1.2, 0.5), (3.2, 1.4, 2.6, 0.7))
    outline = [(0, 0), (0.5 * w, h), (w, 0), (w, t), (0.5 * w, h + t), (0, t)]
    return upright(outline, d)


def rod_end(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.8, 1.2, 1.2), (3.6, 1.6, 1.6))
    made = upright([(0, 0.2 * h), (0.5 * w, 0), (w, 0), (w, h), (0.5 * w, h), (0, 0.8 * h)], d)
    return made - box((0.24 * w, 9, 0.4 * h), (0.62 * w, -1, 0.3 * h))


MACHINE: dict[str, Callable[[Random], Manifold]] = {
    made.__name__.replace("_", " "): made
    for made in (
        angle_with_rib, angle_with_notched_legs, angle_with_slanted_leg, hat_profile,
        lipped_channel, z_profile_with_cut_end, t_beam_with_stiffener, t_slot_nut, dovetail_key,
        dovetail_joint, stepped_hexagonal_shaft, hexagonal_shaft_with_square_ends,
        hexagonal_shaft_with_keyway, socket_head, gusset_plate_with_hole, corner_gusset,
        pocket_in_pocket, block_with_lying_square_hole, block_with_diamond_hole, step_wedge,
        wedge_with_slot, pyramid_beside_the_middle, pencil, block_chamfered_all_round,
        block_with_chamfered_edges_and_pocket, block_with_three_cut_corners, rib_between_blocks,
        two_bosses_on_plate, boss_with_hole, v_block_with_cross_slot, crank, hook, clamp, bridge,
        plug, cover, octagonal_ring, chevron, rod_end,
    )
}  # fmt: skip


def machine_part(name: str, seed: int) -> Polyhedron | None:
    """Make one of `MACHINE`; None where chance made it too thin."""
    return chance_made(MACHINE[name], 31, seed, name, THINNEST)
