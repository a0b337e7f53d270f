"""Parts as a workshop would draw them, that nothing was tuned on: they are here to be measured.

Weights and confidence are fitted to those of ``objects.py`` and ``cad_parts.py``; none is of these
kinds.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from manifold3d import CrossSection, Manifold

from tests.plugins.polyhedron.cad_parts import Random, extruded, regular, upright
from tests.plugins.polyhedron.objects import Polyhedron, box, chance_made

THINNEST = 0.05
"""Least length of an edge, and distance of a vertex from a foreign edge, in diagonals."""


def trimmed(solid: Manifold, normal: object, through: object) -> Manifold:
    """Return what of a solid lies on the side of a plane that its normal points to."""
    unit = np.asarray(normal, float) / np.linalg.norm(np.asarray(normal, float))
    return solid.trim_by_plane(tuple(unit), float(unit @ np.asarray(through, float)))


def h_profile(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 1.2, 1.8), (3.2, 3.0, 2.6))
    t, k = 0.27 * w, 0.36 * h
    outline = [(0, 0), (t, 0), (t, k), (w - t, k), (w - t, 0), (w, 0), (w, h), (w - t, h),
               (w - t, h - k), (t, h - k), (t, h), (0, h)]  # fmt: skip
    return upright(outline, d)


def l_profile_with_cut_ends(rng: Random) -> Manifold:
    w, d, h = rng.uniform((1.8, 3.0, 1.8), (2.4, 3.6, 2.4))
    t = 0.3 * w
    made = upright([(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)], d)
    made = trimmed(made, (-0.5, 1.0, 0.0), (0, 0, 0))
    return trimmed(made, (-0.4, -1.0, 0.0), (0, d, 0))


def u_profile_with_slots(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 2.6, 1.8), (3.0, 3.4, 2.4))
    t = 0.22 * w
    outline = [(0, 0), (w, 0), (w, h), (w - t, h), (w - t, t), (t, t), (t, h), (0, h)]
    return upright(outline, d) - box((9, 0.3 * d, 9), (-1, 0.35 * d, 0.55 * h))


def pillow_block(rng: Random) -> Manifold:
    w, d, h = rng.uniform((3.2, 1.4, 0.5), (3.8, 2.0, 0.7))
    made = box((w, d, h)) + box((0.45 * w, d, 1.4), (0.27 * w, 0, h - 0.05))
    return made - box((0.2 * w, 9, 0.6), (0.395 * w, -1, h + 0.35))


def stepped_shaft(rng: Random) -> Manifold:
    a, b = rng.uniform((1.0, 0.8), (1.6, 1.4))
    made = extruded(regular(6, 1.2), a)
    return made + box((1.0, 0.8, b + 0.05), (-0.5, -0.4, a - 0.05))


def square_shaft_with_flat(rng: Random) -> Manifold:
    a, b, c = rng.uniform((1.6, 0.9, 0.9), (2.0, 1.3, 1.3))
    made = box((a, a, b)) + box((0.6 * a, 0.6 * a, c + b), (0.2 * a, 0.2 * a, 0))
    return made - box((9, 9, 9), (0.6 * a, -1, b + 0.3 * c))


def octagonal_shaft_with_collar(rng: Random) -> Manifold:
    a, b = rng.uniform((0.7, 1.2), (1.0, 1.8))
    return box((2.4, 2.4, a), (-1.2, -1.2, 0)) + extruded(regular(8, 0.85), a + b)


def gusset(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.2, 0.5, 2.0), (3.0, 0.9, 2.8))
    k = float(rng.uniform(0.2, 0.35))
    return upright([(0, 0), (w, 0), (w, k * h), (k * w, h), (0, h)], d)


def double_gusset(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 2.4, 2.0), (3.0, 3.0, 2.6))
    t = 0.5
    made = upright([(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)], d)
    rib = upright([(t, t), (0.85 * w, t), (t, 0.85 * h)], 0.4)
    return made + rib.translate((0, 0.18 * d, 0)) + rib.translate((0, 0.66 * d, 0))


def stairs_with_landing(rng: Random) -> Manifold:
    d = float(rng.uniform(1.4, 2.0))
    a, b, c = rng.uniform((0.5, 0.5, 1.2), (0.7, 0.7, 1.8))
    outline = [(0, 0), (3 * a + c, 0), (3 * a + c, b), (2 * a + c, b), (2 * a + c, 2 * b),
               (a + c, 2 * b), (a + c, 3 * b), (0, 3 * b)]  # fmt: skip
    return upright(outline, d)


def stairs_round_a_corner(rng: Random) -> Manifold:
    a, b, w = rng.uniform((0.7, 0.5, 1.2), (0.9, 0.7, 1.6))
    made = box((w, w, 3 * b)) + box((a, w, 2 * b), (w, 0, 0)) + box((a, w, b), (w + a, 0, 0))
    return made + box((w, a, 4 * b), (0, w, 0)) + box((w, a, 5 * b), (0, w + a, 0))


def house_with_dormer(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 2.6, 1.0), (3.0, 3.4, 1.4))
    k = float(rng.uniform(1.1, 1.5))
    made = upright([(0, 0), (w, 0), (w, h), (w / 2, h + k), (0, h)], d)
    return made + box((0.35 * w, 0.3 * d, 0.55 * k), (0.55 * w, 0.35 * d, h + 0.1))


def house_with_porch(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 2.0, 1.2), (2.6, 2.6, 1.6))
    k = float(rng.uniform(0.7, 1.1))
    made = upright([(0, 0), (w, 0), (w, h), (w / 2, h + k), (0, h)], d)
    return made + upright([(w, 0), (1.5 * w, 0), (1.5 * w, 0.45 * h), (w, 0.8 * h)], 0.5 * d)


def house_with_hipped_roof(rng: Random) -> Manifold:
    w, d, h, k = rng.uniform((1.6, 2.4, 0.9, 0.8), (2.2, 3.2, 1.3, 1.2))
    corners = [(x, y, z) for x in (0, w) for y in (0, d) for z in (0, h)]
    return Manifold.hull_points([*corners, (w / 2, 0.28 * d, h + k), (w / 2, 0.72 * d, h + k)])


def bench(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.8, 1.0, 1.2), (3.4, 1.5, 1.6))
    t = 0.36
    made = box((w, d, t), (0, 0, h - t))
    return made + box((t, d, h), (0.5, 0, 0)) + box((t, d, h), (w - 0.5 - t, 0, 0))


def drawer(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 2.2, 0.9), (3.2, 3.0, 1.3))
    t = 0.36
    made = box((w, d, h)) - box((w - 2 * t, d - 2 * t, 9), (t, t, t))
    return made + box((0.3 * w, 0.35, 0.3), (0.35 * w, -0.35, 0.4 * h))


def cupboard(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 1.2, 2.6), (2.4, 1.6, 3.2))
    made = box((w, d, h)) - box((w - 0.6, 0.7 * d, 0.36 * h), (0.3, -0.05, 0.12 * h))
    return made - box((w - 0.6, 0.7 * d, 0.3 * h), (0.3, -0.05, 0.58 * h))


def hexagonal_bolt(rng: Random) -> Manifold:
    h = float(rng.uniform(0.6, 0.9))
    return extruded(regular(6, 1.1), h) + box((0.8, 0.8, 2.4), (-0.4, -0.4, h - 0.01))


def pyramid_on_cube(rng: Random) -> Manifold:
    a, h = rng.uniform((1.8, 1.0), (2.2, 1.6))
    s = 0.6 * a
    apex = (a / 2, a / 2, a + h)
    low, high = (a - s) / 2, (a + s) / 2
    roof = Manifold.hull_points(
        [(low, low, a), (high, low, a), (high, high, a), (low, high, a), apex]
    )
    return box((a, a, a)) + roof


def obelisk(rng: Random) -> Manifold:
    h = float(rng.uniform(2.2, 3.0))
    shaft = CrossSection.square((1.3, 1.3), True).extrude(h, scale_top=(0.65, 0.65))
    tip = Manifold.hull_points([(x, y, h) for x in (-0.4225, 0.4225) for y in (-0.4225, 0.4225)]
                               + [(0, 0, h + 0.6)])  # fmt: skip
    return shaft + tip


def chamfered_block(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 1.6, 1.4), (2.8, 2.4, 2.0))
    made = box((w, d, h))
    made = trimmed(made, (-1.0, 0.0, -1.0), (w - 0.6, 0, h))
    return trimmed(made, (0.0, 1.0, -1.0), (0, 0.6, h))


def block_with_cut_corner(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 1.8, 1.6), (2.8, 2.6, 2.4))
    a = rng.uniform((0.8, 0.8, 0.7), (1.2, 1.2, 1.1))
    return trimmed(box((w, d, h)), -1.0 / a, (w - a[0], d, h))


def block_with_oblique_end(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 1.2, 1.2), (3.4, 1.8, 1.8))
    a, b = rng.uniform(0.25, 0.6, 2)
    return trimmed(box((w, d, h)), (-1.0, -a, -b), (w, -0.2, -0.2))


def block_with_two_pockets(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.8, 1.8, 1.2), (3.4, 2.4, 1.6))
    made = box((w, d, h)) - box((0.3 * w, 0.5 * d, 9), (0.12 * w, 0.22 * d, 0.45 * h))
    return made - box((0.28 * w, 0.45 * d, 9), (0.6 * w, 0.3 * d, 0.6 * h))


def block_with_hexagonal_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.2, 2.0, 1.0), (2.8, 2.6, 1.6))
    return box((w, d, h)) - extruded(regular(6, 0.6), 9).translate((0.48 * w, 0.52 * d, -1))


def block_with_step_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.4, 1.4), (3.0, 2.8, 1.9))
    made = box((w, d, h)) - box((0.6 * w, 0.58 * d, 9), (0.2 * w, 0.22 * d, 0.6 * h))
    return made - box((0.26 * w, 0.26 * d, 9), (0.38 * w, 0.37 * d, -1))


def dovetail_slide(rng: Random) -> Manifold:
    w, d = rng.uniform((2.8, 2.0), (3.4, 2.8))
    a, b = 0.3 * w, 0.2 * w
    outline = [(0, 0), (a, 0), (b, 0.7), (w - b, 0.7), (w - a, 0), (w, 0), (w, 1.8),
               (0.65 * w, 1.8), (0.65 * w, 1.3), (0, 1.3)]  # fmt: skip
    return upright(outline, d)


def v_block_with_feet(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 1.6, 1.6), (3.2, 2.4, 2.2))
    k = 0.6 * h
    outline = [(-0.5, 0), (w + 0.5, 0), (w + 0.5, 0.4), (w, 0.4), (w, h), (0.78 * w, h),
               (w / 2, h - k), (0.22 * w, h), (0, h), (0, 0.4), (-0.5, 0.4)]  # fmt: skip
    return upright(outline, d)


def fork_lever(rng: Random) -> Manifold:
    w = float(rng.uniform(2.6, 3.2))
    made = upright([(0, 0), (w, 0.5), (w, 1.2), (0, 1.5)], 1.6)
    return made - box((1.0, 0.6, 9), (w - 0.8, 0.5, -1))


def tapered_rib_on_plate(rng: Random) -> Manifold:
    w, d = rng.uniform((2.6, 1.8), (3.2, 2.4))
    rib = upright([(0.15 * w, 0), (0.85 * w, 0), (0.7 * w, 1.6), (0.3 * w, 1.6)], 0.5)
    return box((w, d, 0.5)) + rib.translate((0, 0.35 * d, 0.45))


def arrow(rng: Random) -> Manifold:
    a = float(rng.uniform(0.8, 1.4))
    outline = [(0, 0.6), (1.6, 0.6), (1.6, 0), (3.0, 1.1), (1.6, 2.2), (1.6, 1.6), (0, 1.6)]
    return extruded(outline, a)


def tee_of_beams(rng: Random) -> Manifold:
    a, b, c = rng.uniform((2.6, 1.2, 1.2), (3.4, 1.8, 1.8))
    made = box((a, 0.8, 0.8)) + box((0.8, b + 0.8, 0.8), (0.3 * a, 0, 0))
    return made + box((0.8, 0.8, c + 0.8), (0.3 * a, 0, 0))


def truncated_octagon_block(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 2.0, 1.0), (2.6, 2.6, 1.6))
    c = 0.55
    outline = [(c, 0), (w - c, 0), (w, c), (w, d - c), (w - c, d), (c, d), (0, d - c), (0, c)]
    return extruded(outline, h) - box((0.35 * w, 9, 0.4 * h), (0.32 * w, -1, 0.6 * h))


WORKSHOP: dict[str, Callable[[Random], Manifold]] = {
    made.__name__.replace("_", " "): made
    for made in (
        h_profile, l_profile_with_cut_ends, u_profile_with_slots, pillow_block, stepped_shaft,
        square_shaft_with_flat, octagonal_shaft_with_collar, gusset, double_gusset,
        stairs_with_landing, stairs_round_a_corner, house_with_dormer, house_with_porch,
        house_with_hipped_roof, bench, drawer, cupboard,
        hexagonal_bolt, pyramid_on_cube, obelisk, chamfered_block,
        block_with_cut_corner, block_with_oblique_end, block_with_two_pockets,
        block_with_hexagonal_hole, block_with_step_hole, dovetail_slide, v_block_with_feet,
        fork_lever, tapered_rib_on_plate, arrow, tee_of_beams, truncated_octagon_block,
    )
}  # fmt: skip


def workshop_part(name: str, seed: int) -> Polyhedron | None:
    """Make one of `WORKSHOP`; None where chance made it too thin."""
    return chance_made(WORKSHOP[name], 29, seed, name, THINNEST)
