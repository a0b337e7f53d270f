"""Copies of prims that a USD scene scatters at points (``PointInstancer``)."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE, MAX_PARTS, at_most
from bozzetto.exchange.usd.usda_text import ReadPrim

SCATTER: Final = "PointInstancer"
"""The type of prims that scatter copies."""


class Copy(NamedTuple):
    """A copy of a prim.

    Attributes
    ----------
    path : str
        Of what is repeated.
    matrix : array (4, 4)
        From what holds the repeated prim to the prim that scatters it, as columns.
    """

    path: str
    matrix: Array


def copies_of(prim: ReadPrim) -> list[Copy]:
    """Return the copies that a prim scatters, where they are at the first time.

    A copy is scaled, then turned, then moved (schema ``UsdGeomPointInstancer``). Those without
    a kind that exists are left out, and those that are hidden.

    Raises
    ------
    FormatError
        If its lists are not as long as each other, or a place is no number.
    """
    kinds, places = prim.numbers("protoIndices", 1), prim.numbers("positions", 3)
    paths = prim.targets("prototypes")
    if kinds is None or places is None or not paths:
        return []
    count = len(kinds)
    at_most(count, MAX_PARTS, "copies")
    sizes, names = prim.numbers("scales", 3), prim.numbers("ids", 1)
    turns = prim.numbers("orientationsf", 4)  # the finer ones are the stronger ones
    if turns is None:
        turns = prim.numbers("orientations", 4)
    if any(table is not None and len(table) not in (0, count) for table in (places, sizes, turns)):
        raise FormatError("What is scattered has not as many places as copies.")
    matrices = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
    if turns is not None and len(turns):
        with np.errstate(all="ignore"):
            lengths = np.linalg.norm(turns, axis=1)
        if not ((lengths > 0.0) & (lengths < np.inf)).all():
            raise FormatError("A copy is turned by nothing.")
        matrices[:, :3, :3] = Rotation.from_quat(turns[:, [1, 2, 3, 0]]).as_matrix()
    if sizes is not None and len(sizes):
        matrices[:, :3, :3] *= sizes[:, None, :]
    if len(places):
        matrices[:, :3, 3] = places
    if not (np.abs(matrices) <= MAX_COORDINATE).all():
        raise FormatError("A copy lies further away than a scene can reach.")
    ids = np.arange(count) if names is None or len(names) != count else names[:, 0]
    shown = (kinds[:, 0] >= 0) & (kinds[:, 0] < len(paths))
    for hidden in (prim.numbers("invisibleIds", 1), prim.said.get("inactiveIds")):
        if hidden is not None:
            shown &= ~np.isin(ids, np.ravel(hidden))
    return [Copy(paths[int(kinds[row, 0])], matrices[row]) for row in np.flatnonzero(shown)]
