"""Places in a picture to come (UVs): all parts of a file share one square."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.geometry.shapes import Solid, Surface

Places = NDArray[np.float32]

Checkpoint = Callable[[float, str], None]

STEP = "Texture coordinates"


def no_checkpoint(fraction: float, step: str) -> None:
    """Ignore progress that no one watches."""


def picture_places(
    parts: Sequence[Solid | Surface], checkpoint: Checkpoint = no_checkpoint
) -> list[Places | None]:
    """Return the places of all parts that have no picture, in one square; None for the others.

    Parameters
    ----------
    parts : sequence of Solid or Surface
        In one frame; those with a skin are laid out as they are at rest.

    checkpoint : callable
        Called with the fraction done (0 … 1) and the step's name; may raise to stop it.

    Returns
    -------
    list of (f, 3, 2) float32 array or None
        u to the right, v down, 0 to 1, of the corners of each triangle that names no vertex twice.
    """
    from bozzetto.geometry.atlas.unwrapping import unwrapped_together

    bare = [part for part in parts if part.texture is None]
    rest = [
        part.mesh if part.skin is None or part.skin.rest is None else part.skin.rest
        for part in bare
    ]
    faces = [mesh.faces[~is_degenerate(mesh.faces)].astype(np.int64) for mesh in rest]
    if not any(map(len, faces)):
        return [None] * len(parts)
    rows = [(mesh.vertices.astype(np.float64), own) for mesh, own in zip(rest, faces, strict=True)]
    laid = iter(unwrapped_together(rows, lambda done: checkpoint(done, STEP)))
    return [
        next(laid).corners.astype(np.float32) if part.texture is None else None for part in parts
    ]
