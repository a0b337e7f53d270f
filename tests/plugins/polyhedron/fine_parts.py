"""Parts with thin floors, thin walls, small steps and narrow chamfers.

Their corners are hardly farther apart than a hand is unsteady, so lines and readings of them are
wrong more often than of the parts in ``machine_parts.py``. Measurements are chance within limits.
"""

from __future__ import annotations

from collections.abc import Callable

from manifold3d import Manifold

from tests.plugins.polyhedron.cad_parts import Random, extruded, upright
from tests.plugins.polyhedron.objects import Polyhedron, box, chance_made
from tests.plugins.polyhedron.workshop_parts import trimmed

THINNEST = 0.03
"""Least length of an edge, and distance of a vertex from a foreign edge, in diagonals."""


def _block(rng: Random) -> tuple[float, float, float]:
    w, d, h = rng.uniform((1.6, 1.2, 0.6), (3.0, 2.4, 1.8))
    return float(w), float(d), float(h)


def _hollow(rng: Random, floor: float, wall: tuple[float, float]) -> Manifold:
    """Return a block with a pocket from above; without a floor where that is negative."""
    w, d, h = _block(rng)
    a, b, c, e = rng.uniform(*wall, 4)
    return box((w, d, h)) - box((w - a - b, d - c - e, 2 * h), (a, c, floor * h))


def tray(rng: Random) -> Manifold:
    return _hollow(rng, float(rng.uniform(0.06, 0.35)), (0.2, 0.45))


def tray_with_thin_walls(rng: Random) -> Manifold:
    return _hollow(rng, float(rng.uniform(0.1, 0.5)), (0.1, 0.2))


def frame(rng: Random) -> Manifold:
    return _hollow(rng, -1.0, (0.12, 0.5))


def thin_angle(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    t = float(rng.uniform(0.1, 0.25))
    return upright([(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)], d)


def thin_channel(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    t, s = rng.uniform(0.1, 0.25, 2)
    outline = [(0, 0), (w, 0), (w, h), (w - s, h), (w - s, t), (s, t), (s, h), (0, h)]
    return upright(outline, d)


def lipped_channel(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    t, lip = rng.uniform((0.12, 0.25), (0.2, 0.45))
    outline = [(0, 0), (w, 0), (w, h), (w - lip, h), (w - lip, h - t), (w - t, h - t), (w - t, t),
               (t, t), (t, h - t), (lip, h - t), (lip, h), (0, h)]  # fmt: skip
    return upright(outline, d)


def block_with_small_step(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a, b = rng.uniform(0.1, 0.3, 2)
    return box((w, d, h)) - box((a, 9, 9), (w - a, -1, h - b))


def block_with_small_notch(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a, b, c = rng.uniform(0.1, 0.35, 3)
    return box((w, d, h)) - box((9, 9, 9), (w - a, d - b, h - c))


def block_with_rabbets(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a, b, c, e = rng.uniform(0.1, 0.3, 4)
    made = box((w, d, h)) - box((a, 9, 9), (w - a, -1, h - b))
    return made - box((c, 9, 9), (0, -1, h - e))


def narrow_chamfer(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a, b = rng.uniform(0.12, 0.3, 2)
    return upright([(0, 0), (w, 0), (w, h - a), (w - b, h), (0, h)], d)


def two_narrow_chamfers(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a, b = rng.uniform(0.12, 0.25, 2)
    return upright([(0, 0), (w, 0), (w, h - a), (w - a, h), (b, h), (0, h - b)], d)


def corner_cut(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a = float(rng.uniform(0.15, 0.35))
    return trimmed(box((w, d, h)), (1.0, 1.0, 1.0), (w - a, d, h))


def plate_with_narrow_slot(rng: Random) -> Manifold:
    w, d, _ = _block(rng)
    t, s = rng.uniform((0.12, 0.12), (0.35, 0.3))
    return box((w, d, t)) - box((0.6 * w, s, 9), (0.5 * w, 0.5 * (d - s), -1))


def plate_on_plate(rng: Random) -> Manifold:
    w, d, _ = _block(rng)
    t, s, rim = rng.uniform((0.12, 0.12, 0.15), (0.35, 0.35, 0.4))
    return box((w, d, t)) + box((w - 2 * rim, d - 2 * rim, s), (rim, rim, t))


def plate_with_ledge(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    t, s = rng.uniform(0.12, 0.3, 2)
    return box((w, d, t)) + box((w, s, h), (0, d - s, 0))


def spool(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    t, rim = rng.uniform((0.12, 0.15), (0.3, 0.4))
    made = box((w, d, t)) + box((w - 2 * rim, d - 2 * rim, h), (rim, rim, 0))
    return made + box((w, d, t), (0, 0, h))


def stairs_with_low_steps(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a, b = rng.uniform(0.12, 0.3, 2)
    outline = [(0, 0), (w, 0), (w, h - a - b), (0.66 * w, h - a - b), (0.66 * w, h - a),
               (0.33 * w, h - a), (0.33 * w, h), (0, h)]  # fmt: skip
    return upright(outline, d)


def tongue(rng: Random) -> Manifold:
    w, d, h = _block(rng)
    a, b = rng.uniform(0.12, 0.25, 2)
    x, y = 0.6 * w, d + a
    outline = [(0, 0), (w, 0), (w, d), (x, d), (x, y), (x - b, y), (x - b, d), (0, d)]
    return extruded(outline, h)


FINE: dict[str, Callable[[Random], Manifold]] = {
    make.__name__: make
    for make in (
        tray,
        tray_with_thin_walls,
        frame,
        thin_angle,
        thin_channel,
        lipped_channel,
        block_with_small_step,
        block_with_small_notch,
        block_with_rabbets,
        narrow_chamfer,
        two_narrow_chamfers,
        corner_cut,
        plate_with_narrow_slot,
        plate_on_plate,
        plate_with_ledge,
        spool,
        stairs_with_low_steps,
        tongue,
    )
}


def fine_part(name: str, seed: int) -> Polyhedron | None:
    """Make one of `FINE`; None where chance made it too thin."""
    return chance_made(FINE[name], 37, seed, name, THINNEST)
