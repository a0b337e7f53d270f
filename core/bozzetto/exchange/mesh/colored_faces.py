"""Meshes whose faces have colours, as they are read: faces of one colour become a group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.mesh.polygons import checked_mesh, is_degenerate, triangulate
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import Color, FaceGroup, Surface

MAX_COLORS: Final = 1_000
"""Colours of faces that become groups; of more a person would not find one."""


def colored_part(
    places: NDArray[np.float64],
    corners: NDArray[np.int64],
    sizes: NDArray[np.int64],
    of_faces: Sequence[Color | None],
    colors: NDArray[np.uint8] | None,
    kind: str,
    reading: Reading,
) -> Surface:
    """Return polygons as a part.

    Parameters
    ----------
    places : (v, 3) float array
        Of the vertices.
    corners, sizes : int arrays
        The vertices of all polygons in turn, and how many each has.
    of_faces : sequence of Color or None
        The colour of each polygon.
    colors : (v, 4) uint8 array or None
        Of the vertices.
    kind : str
        Of the file, for messages.
    reading : Reading
        Where it is told what is left out.
    """
    cut = triangulate(places, corners, sizes)
    owner = np.repeat(np.arange(len(sizes)), np.maximum(sizes - 2, 0))
    proper = ~is_degenerate(cut)
    cut, owner = cut[proper], owner[proper]
    known = list(dict.fromkeys(of_faces))
    if len(known) > MAX_COLORS:
        reading.tell(
            f"Left out of the {kind} file: the colours of its faces, {len(known):,} different "
            "ones. Save it as PLY with colours of vertices."
        )
        known = [None]
    if len(known) < 2:
        color = known[0] if known else None
        return Surface(checked_mesh(places, cut, colors=colors), "", color)
    number = {color: k for k, color in enumerate(known)}
    which = np.array([number[color] for color in of_faces])[owner]
    order = np.argsort(which, kind="stable")
    counts = np.bincount(which, minlength=len(known))
    groups = tuple(
        FaceGroup("" if color is None else "#{:02x}{:02x}{:02x}".format(*color), int(n), color)
        for color, n in zip(known, counts, strict=True)
        if n
    )
    return Surface(checked_mesh(places, cut[order], colors=colors), "", None, groups)
