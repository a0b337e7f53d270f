"""Parts with flat faces as they come out of a CAD program, with dimensions by chance.

Brackets, channels, blocks with grooves, frames and heaps that the generator in ``objects.py`` does
not make: none of its kinds of solid and none of the learned numbers come from here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from manifold3d import CrossSection, Manifold

from tests.plugins.polyhedron.objects import Polyhedron, box, chance_made

Random = np.random.Generator

THINNEST = 0.06
"""Least length of an edge, and distance of a vertex from a foreign edge, in diagonals."""


def extruded(outline: object, height: float) -> Manifold:
    """Return a prism over an outline in x and y."""
    return CrossSection([np.asarray(outline, float)]).extrude(height)


def upright(outline: object, width: float) -> Manifold:
    """Return a prism over an outline in x and z, from y = 0 to the width."""
    return extruded(outline, width).rotate((90.0, 0.0, 0.0)).translate((0.0, width, 0.0))


def regular(count: int, radius: float) -> np.ndarray:
    """Return a regular polygon, (count, 2)."""
    turn = np.arange(count) * 2 * np.pi / count
    return radius * np.column_stack((np.cos(turn), np.sin(turn)))


def _bracket(rng: Random) -> tuple[Manifold, float, float, float, float]:
    w, d, h = rng.uniform((2.4, 1.8, 2.2), (3.2, 2.6, 3.0))
    t = float(rng.uniform(0.5, 0.7))
    return upright([(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)], d), w, d, h, t


def bracket_with_hole(rng: Random) -> Manifold:
    made, w, d, _, t = _bracket(rng)
    x, y = rng.uniform(0.45, 0.8), rng.uniform(0.45, 0.8)
    at = (t + 0.4 * (w - t), 0.35 * d, -1)
    return made - box((x, y, 9), at)


def bracket_with_two_holes(rng: Random) -> Manifold:
    made, w, d, h, t = _bracket(rng)
    made -= box((0.7, 0.4 * d, 9), (t + 0.35 * (w - t), 0.3 * d, -1))
    return made - box((9, 0.45 * d, 0.6), (-1, 0.25 * d, t + 0.4 * (h - t)))


def bracket_with_gusset(rng: Random) -> Manifold:
    made, w, d, h, t = _bracket(rng)
    thick = 0.3 * d
    rib = [(t, t), (t + 0.75 * (w - t), t), (t, t + 0.7 * (h - t))]
    return made + upright(rib, thick).translate((0, 0.35 * d, 0))


def bracket_with_flush_gusset(rng: Random) -> Manifold:
    made, w, d, h, t = _bracket(rng)
    rib = [(t, t), (w, t), (t, h)]
    return made + upright(rib, 0.3 * d)


def bracket_with_cut_corner(rng: Random) -> Manifold:
    made, w, d, _, t = _bracket(rng)
    cut = extruded([(w - 0.45 * (w - t), d), (w, 0.55 * d), (w + 1, d), (w, d + 1)], 9)
    return made - cut.translate((0, 0, -1))


def channel_with_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.8, 2.0, 1.4), (3.4, 3.0, 2.0))
    t = float(rng.uniform(0.5, 0.65))
    outline = [(0, 0), (w, 0), (w, h), (w - t, h), (w - t, t), (t, t), (t, h), (0, h)]
    hole = box((0.4 * (w - 2 * t), 0.4 * d, 9), (t + 0.25 * (w - 2 * t), 0.35 * d, -1))
    return upright(outline, d) - hole


def clevis(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.2, 1.6, 2.2), (2.8, 2.2, 3.0))
    t = 0.28 * w
    outline = [(0, 0), (w, 0), (w, h), (w - t, h), (w - t, t), (t, t), (t, h), (0, h)]
    return upright(outline, d) - box((9, 0.4 * d, 0.35 * h), (-1, 0.35 * d, 0.5 * h))


def t_bracket(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 1.4, 2.0), (3.4, 2.4, 2.8))
    t = float(rng.uniform(0.5, 0.7))
    x = float(rng.uniform(0.3, 0.5)) * w
    outline = [(0, 0), (w, 0), (w, t), (x + t, t), (x + t, h), (x, h), (x, t), (0, t)]
    return upright(outline, d) - box((9, 0.35 * d, 0.6), (-1, 0.3 * d, 0.6 * h))


def z_bracket(rng: Random) -> Manifold:
    a, b, h, d = rng.uniform((1.2, 1.2, 1.8, 1.5), (1.8, 1.8, 2.6, 2.4))
    t = float(rng.uniform(0.45, 0.6))
    outline = [
        (0, 0), (a, 0), (a, h - t), (a + b, h - t), (a + b, h), (a - t, h), (a - t, t), (0, t)
    ]  # fmt: skip
    return upright(outline, d)


def z_bracket_with_hole(rng: Random) -> Manifold:
    low, high = np.array((made := z_bracket(rng)).bounding_box()).reshape(2, 3)
    w, d = (high - low)[:2]
    return made - box((0.2 * w, 0.4 * d, 0.9), (0.7 * w, 0.3 * d, high[2] - 0.9))


def dovetail(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.0, 0.8), (3.4, 3.0, 1.2))
    a, b, k = 0.32 * w, 0.2 * w, float(rng.uniform(0.6, 0.9))
    outline = [(0, 0), (w, 0), (w, h), (w - a, h), (w - b, h + k), (b, h + k), (a, h), (0, h)]
    return upright(outline, d)


def dovetail_groove(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.0, 1.5), (3.4, 3.0, 2.2))
    a, b, k = 0.36 * w, 0.24 * w, 0.45 * h
    outline = [
        (0, 0), (w, 0), (w, h), (w - a, h), (w - b, h - k), (b, h - k), (a, h), (0, h)
    ]  # fmt: skip
    return upright(outline, d)


def v_block(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 1.8, 1.8), (3.2, 3.0, 2.4))
    a, k = 0.22 * w, float(rng.uniform(0.45, 0.65)) * h
    return upright([(0, 0), (w, 0), (w, h), (w - a, h), (w / 2, h - k), (a, h), (0, h)], d)


def v_block_with_slot(rng: Random) -> Manifold:
    low, high = np.array((made := v_block(rng)).bounding_box()).reshape(2, 3)
    w, d, h = high - low
    return made - box((0.4 * w, d + 2, 0.25 * h), (0.3 * w, -1, -0.05 * h))


def step_with_pocket(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.0, 1.6), (3.4, 3.0, 2.2))
    made = upright([(0, 0), (w, 0), (w, 0.5 * h), (0.5 * w, 0.5 * h), (0.5 * w, h), (0, h)], d)
    return made - box((0.28 * w, 0.45 * d, 9), (0.62 * w, 0.3 * d, 0.22 * h))


def step_with_tunnel(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.0, 1.8), (3.4, 3.0, 2.4))
    made = upright([(0, 0), (w, 0), (w, 0.5 * h), (0.45 * w, 0.5 * h), (0.45 * w, h), (0, h)], d)
    return made - box((0.24 * w, d + 2, 0.45 * h), (0.1 * w, -1, 0.3 * h))


def slotted_plate(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.8, 2.0, 0.6), (3.6, 2.8, 0.9))
    made = box((w, d, h)) - box((0.35 * w, 0.3 * d, 9), (0.75 * w, 0.35 * d, -1))
    return made - box((0.25 * w, 0.4 * d, 9), (0.2 * w, 0.3 * d, -1))


def plate_with_two_holes(rng: Random) -> Manifold:
    w, d, h = rng.uniform((3.0, 2.0, 0.6), (3.8, 2.8, 1.0))
    made = box((w, d, h)) - box((0.22 * w, 0.45 * d, 9), (0.15 * w, 0.25 * d, -1))
    return made - box((0.25 * w, 0.5 * d, 9), (0.6 * w, 0.2 * d, -1))


def nut(rng: Random) -> Manifold:
    h = float(rng.uniform(0.9, 1.6))
    inner = regular(6, 0.55).tolist()
    return extruded(regular(6, 1.2), h) - extruded(inner, 9).translate((0, 0, -1))


def nut_with_square_hole(rng: Random) -> Manifold:
    h = float(rng.uniform(0.9, 1.6))
    return extruded(regular(6, 1.2), h) - box((0.9, 0.75, 9), (-0.45, -0.4, -1))


def pyramid_on_box(rng: Random) -> Manifold:
    w, d, h = rng.uniform((1.6, 1.4, 0.8), (2.4, 2.2, 1.6))
    roof = Manifold.hull_points(
        [(0, 0, h), (w, 0, h), (w, d, h), (0, d, h), (w / 2, d / 2, h + rng.uniform(0.9, 1.6))]
    )
    return box((w, d, h)) + roof


def cut_pyramid_on_plate(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 2.0, 0.5), (3.0, 2.8, 0.8))
    top = CrossSection.square((0.65 * w, 0.6 * d), True).extrude(1.1, scale_top=(0.55, 0.55))
    return box((w, d, h)) + top.translate((w / 2, d / 2, h))


def cut_pyramid_with_pocket(rng: Random) -> Manifold:
    w, d = rng.uniform((2.2, 2.0), (2.8, 2.6))
    h = float(rng.uniform(1.2, 1.8))
    made = CrossSection.square((w, d), True).extrude(h, scale_top=(0.65, 0.65))
    return made - box((0.28 * w, 0.28 * d, 9), (-0.13 * w, -0.15 * d, 0.55 * h))


def wedge_with_hole(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 1.8, 1.6), (3.2, 2.6, 2.2))
    return upright([(0, 0), (w, 0), (0, h)], d) - box(
        (0.25 * w, d + 2, 0.3 * h), (0.12 * w, -1, 0.18 * h)
    )


def wedge_on_box(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 1.8, 0.7), (2.8, 2.6, 1.1))
    return box((w, d, h)) + upright([(0, h), (0.7 * w, h), (0, 2.1 * h)], 0.6 * d)


def ramp_between_walls(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.2, 1.4), (3.2, 2.8, 2.0))
    ramp = upright([(0, 0.3 * h), (w, h), (w, h + 1), (0, h + 1)], 0.5 * d)
    return box((w, d, h)) - ramp.translate((0, 0.25 * d, 0))


def heap_in_the_middle(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.4, 0.6), (3.2, 3.0, 0.9))
    made = box((w, d, h)) + box((0.6 * w, 0.6 * d, h), (0.18 * w, 0.2 * d, h))
    return made + box((0.28 * w, 0.3 * d, h), (0.3 * w, 0.3 * d, 2 * h))


def heap_in_a_corner(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.4, 0.7), (3.2, 3.0, 1.0))
    made = box((w, d, h)) + box((0.65 * w, 0.6 * d, h), (0, 0, h))
    return made + box((0.3 * w, 0.28 * d, h), (0, 0, 2 * h))


def frame(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 2.0, 0.6), (3.2, 2.8, 1.2))
    t = float(rng.uniform(0.5, 0.7))
    return box((w, d, h)) - box((w - 2 * t, d - 2 * t, 9), (t, t, -1))


def frame_on_feet(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 1.6, 2.0), (3.4, 2.2, 2.6))
    t = 0.2 * w
    made = box((w, d, h)) - box((w - 2 * t, d + 2, h - 2 * t), (t, -1, t))
    return made - box((w - 3 * t, d + 2, 0.6 * t), (1.5 * t, -1, -0.1 * t))


def house_with_chimney(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 2.4, 1.0), (2.6, 3.2, 1.4))
    k = float(rng.uniform(0.8, 1.2))
    made = upright([(0, 0), (w, 0), (w, h), (w / 2, h + k), (0, h)], d)
    return made + box((0.18 * w, 0.18 * d, h + k + 0.3), (0.7 * w, 0.6 * d, 0.1))


def house_with_door(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 2.2, 1.2), (2.6, 3.0, 1.6))
    k = float(rng.uniform(0.7, 1.1))
    made = upright([(0, 0), (w, 0), (w, h), (w / 2, h + k), (0, h)], d)
    return made - box((0.3 * w, 0.3 * d, 0.7 * h), (0.3 * w, 0, 0))


def corner_plates(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 2.0, 2.0), (3.0, 3.0, 3.0))
    t = float(rng.uniform(0.5, 0.7))
    return box((w, d, h)) - box((9, 9, 9), (t, t, t))


def octagon_with_boss(rng: Random) -> Manifold:
    h = float(rng.uniform(0.6, 1.0))
    return extruded(regular(8, 1.4), h) + box((1.0, 0.9, 0.7), (-0.5, -0.4, h))


def cross_with_pocket(rng: Random) -> Manifold:
    h = float(rng.uniform(0.9, 1.4))
    made = box((3.2, 1.2, h), (0, 1.0, 0)) + box((1.2, 3.2, h), (1.0, 0, 0))
    return made - box((0.6, 0.55, 9), (1.3, 1.35, 0.5 * h))


def triangle_frame(rng: Random) -> Manifold:
    w, h = rng.uniform((2.4, 1.8), (3.2, 2.6))
    outer = np.array([(0, 0), (w, 0), (0.2 * w, h)])
    inner = outer.mean(0) + 0.42 * (outer - outer.mean(0))
    return extruded(outer, float(rng.uniform(0.6, 1.0))) - extruded(inner, 9).translate((0, 0, -1))


def t_slot(rng: Random) -> Manifold:
    w, d, h = rng.uniform((3.0, 1.8, 1.8), (3.6, 2.6, 2.4))
    a, b = 0.38 * w, 0.2 * w
    outline = [
        (0, 0), (w, 0), (w, h), (w - a, h), (w - a, 0.65 * h), (w - b, 0.65 * h), (w - b, 0.3 * h),
        (b, 0.3 * h), (b, 0.65 * h), (a, 0.65 * h), (a, h), (0, h)
    ]  # fmt: skip
    return upright(outline, d)


def pentagon_with_notch(rng: Random) -> Manifold:
    h = float(rng.uniform(1.0, 1.8))
    return extruded(regular(5, 1.3), h) - box((9, 0.7, 0.5 * h), (0.2, -0.35, 0.5 * h))


def anvil(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.4, 1.8, 0.7), (3.0, 2.4, 1.0))
    top = upright([(0.25 * w, h), (0.75 * w, h), (1.0 * w, 2.2 * h), (0, 2.2 * h)], 0.6 * d)
    return box((w, d, h)) + top.translate((0, 0.2 * d, 0))


def block_with_cross_tunnels(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.6, 2.2, 1.8), (3.2, 2.8, 2.4))
    made = box((w, d, h)) - box((0.35 * w, 0.4 * d, 9), (0.12 * w, 0.25 * d, -1))
    return made - box((0.25 * w, 0.35 * d, 0.6 * h), (0.62 * w, 0.3 * d, 0.5 * h))


def rail(rng: Random) -> Manifold:
    w, d, h = rng.uniform((1.8, 2.4, 2.0), (2.4, 3.2, 2.6))
    t, a = 0.25 * h, 0.35 * w
    outline = [
        (0, 0), (w, 0), (w, t), (w - a, t), (w - a, h - t), (w, h - t), (w, h), (0, h),
        (0, h - t), (a, h - t), (a, t), (0, t)
    ]  # fmt: skip
    return upright(outline, d)


def lectern(rng: Random) -> Manifold:
    w, d, h = rng.uniform((2.0, 1.8, 1.6), (2.6, 2.6, 2.2))
    outline = [(0, 0), (w, 0), (w, 0.5 * h), (0.5 * w, h), (0, h)]
    return upright(outline, d) - box((0.26 * w, 0.4 * d, 9), (0.12 * w, 0.3 * d, 0.4 * h))


PARTS: dict[str, Callable[[Random], Manifold]] = {
    made.__name__.replace("_", " "): made
    for made in (
        bracket_with_hole, bracket_with_two_holes, bracket_with_gusset, bracket_with_flush_gusset,
        bracket_with_cut_corner, channel_with_hole, clevis, t_bracket, z_bracket,
        z_bracket_with_hole, dovetail, dovetail_groove, v_block, v_block_with_slot,
        step_with_pocket, step_with_tunnel, slotted_plate, plate_with_two_holes, nut,
        nut_with_square_hole, pyramid_on_box, cut_pyramid_on_plate, cut_pyramid_with_pocket,
        wedge_with_hole, wedge_on_box, ramp_between_walls, heap_in_the_middle, heap_in_a_corner,
        frame, frame_on_feet, house_with_chimney, house_with_door, corner_plates,
        octagon_with_boss, cross_with_pocket, triangle_frame, t_slot,
        pentagon_with_notch, anvil, block_with_cross_tunnels, rail, lectern,
    )
}  # fmt: skip


def part(name: str, seed: int) -> Polyhedron | None:
    """Make one of `PARTS`; None where chance made it too thin."""
    return chance_made(PARTS[name], 23, seed, name, THINNEST)
