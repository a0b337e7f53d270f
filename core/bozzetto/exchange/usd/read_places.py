"""Where the prims of a USD scene are: transforms put together, as columns."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE
from bozzetto.exchange.usd.usda_text import ReadPrim

ORDER: Final = "xformOpOrder"
RESET: Final = "!resetXformStack!"
INVERTED: Final = "!invert!"


def local_matrix(prim: ReadPrim) -> tuple[Array, bool]:
    """Return the transform (4, 4) of a prim for columns, and whether it forgets those above it.

    Raises
    ------
    FormatError
        If one of its steps cannot be understood, or moves things too far.
    """
    order = prim.values.get(ORDER)
    matrix: Array = np.eye(4)
    resets = False
    for name in order if isinstance(order, list) else ():
        if name == RESET:
            matrix, resets = np.eye(4), True
            continue
        plain = str(name).removeprefix(INVERTED)
        step = _step(prim, plain)
        if plain != name:
            try:
                step = np.asarray(np.linalg.inv(step), np.float64)
            except np.linalg.LinAlgError:
                raise FormatError(f"The transform “{plain[:40]}” cannot be undone.") from None
        with np.errstate(all="ignore"):
            matrix = matrix @ step
    if not (np.abs(matrix) <= MAX_COORDINATE).all():
        raise FormatError("A transform moves its parts further than a scene can reach.")
    return matrix, resets


def moves(prim: ReadPrim) -> bool:
    """Whether a transform of a prim changes in time."""
    return any(name.startswith("xformOp:") and name.endswith(".timeSamples") and len(value) > 1
               for name, value in prim.values.items())  # fmt: skip


def _step(prim: ReadPrim, name: str) -> Array:
    """Return one step of a transform; one without a value does nothing."""
    kind = name.split(":")[1] if ":" in name else ""
    matrix: Array = np.eye(4)
    if kind == "transform":
        rows = prim.numbers(name, 16)
        return matrix if rows is None or len(rows) != 1 else rows[0].reshape(4, 4).T
    if kind == "orient":
        rows = prim.numbers(name, 4)
        if rows is not None and len(rows) == 1:
            with np.errstate(all="ignore"):
                length = float(np.linalg.norm(rows[0]))
            if not 0.0 < length < np.inf:
                raise FormatError("A transform turns by nothing.")
            matrix[:3, :3] = Rotation.from_quat(rows[0][[1, 2, 3, 0]]).as_matrix()
        return matrix
    if kind.startswith("rotate") and set(kind[6:]) <= set("XYZ") and len(kind) in (7, 9):
        axes = kind[6:].lower()
        rows = prim.numbers(name, len(axes))
        if rows is not None and len(rows) == 1:
            if not np.isfinite(rows).all():
                raise FormatError("A transform turns by no number.")
            angles = rows[0] if len(axes) == 1 else rows[0][["xyz".index(axis) for axis in axes]]
            matrix[:3, :3] = Rotation.from_euler(axes, angles, degrees=True).as_matrix()
        return matrix
    rows = prim.numbers(name, 3)
    if rows is None or len(rows) != 1:
        return matrix
    if kind == "translate":
        matrix[:3, 3] = rows[0]
    elif kind == "scale":
        matrix[:3, :3] = np.diag(rows[0])
    else:
        raise FormatError(f"The transform “{name[:40]}” is none that is known.")
    return matrix
