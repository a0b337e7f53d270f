"""The surface of a loop, in the simplest form that it has."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.half_sides import Side
from bozzetto_product.fill.loop_frame import LoopSides
from bozzetto_product.fill.patch_fill import patch_fill
from bozzetto_product.fill.plane_fill import plane_fill
from bozzetto_product.network.net import Loop

SHORTEST: Final = 1e-9
"""Least length of half a side, as a share of the longest."""

SEGMENTS: Final = 24
"""Segments of a mesh along the diagonal of a loop, where no spacing is given."""

PLANE_DEGREES: Final = 0.02
"""Largest angle to the normals along smooth edges at which a plane is as smooth as patches are."""


def fill_loop(
    sides: Sequence[Side],
    *,
    loop: Loop = (),
    spacing: float | None = None,
) -> Fill:
    """Fill a loop: by its plane where it lies in one, else by patches.

    A plane loop whose edges are smooth to something bent gets patches, too, unless they fold.

    Parameters
    ----------
    sides : sequence of Side
        At least three, head to tail.
    loop : Loop
        What the fill is of.
    spacing : float, optional
        Length of the segments of edges in the mesh, mm.

    Raises
    ------
    UserError
        If a side of the loop has no length, or no surface goes through its sides.
    """
    _check_lengths(sides)
    frame = LoopSides.of(sides)
    step = frame.size / SEGMENTS if spacing is None else spacing
    loop = loop or tuple((number, True) for number in range(len(sides)))
    key = key_of(frame, step)
    plane = plane_fill((sides,), loop, step, key)
    if plane is None:
        return patch_fill(frame, loop, step, key)
    if np.nanmax([0.0, *plane.g1_degrees]) > PLANE_DEGREES and plane.bent is not None:
        return plane.bent
    return plane


def fill_with_holes(
    outlines: Sequence[Sequence[Side]], *, loop: Loop, spacing: float
) -> Fill | None:
    """Fill a loop with holes by its plane; None where it lies in none.

    Parameters
    ----------
    outlines : sequence of sequence of Side
        Of the outline, and of each hole.
    loop, spacing
        See `fill_loop`.

    Raises
    ------
    UserError
        If a side has no length.
    """
    sides = [side for each in outlines for side in each]
    _check_lengths(sides)
    return plane_fill(outlines, loop, spacing, key_of(LoopSides.of(sides), spacing))


def _check_lengths(sides: Sequence[Side]) -> None:
    lengths = [half.length for side in sides for half in side.halves]
    if not min(lengths) > SHORTEST * max(lengths):
        raise UserError("A curve of a loop has no length. Draw it longer, or delete it.")


def key_of(frame: LoopSides, spacing: float) -> bytes:
    """Return what tells whether the sides of a loop are the same to the last bit."""
    made = blake2b(digest_size=16)
    made.update(repr(spacing).encode())
    made.update(frame.normals.tobytes())
    for side in frame.sides:
        for half in side.halves:
            for values in (half.points, half.knots, half.breaks):
                made.update(np.ascontiguousarray(values).tobytes())
    return made.digest()
