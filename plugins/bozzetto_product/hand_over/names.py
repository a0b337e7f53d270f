"""Names of pieces of curves, as files and reports have them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from bozzetto_product.model.curves import Curve
from bozzetto_product.network.net import Loop, Net


def piece_names(net: Net, curves: Sequence[Curve]) -> tuple[str, ...]:
    """Return the name of each edge of a net.

    A whole curve has its own name; the pieces of one that is cut at joints are ``c1/1``, ``c1/2``
    …; those of a mirror image have a prime behind the name of the curve.
    """
    named: Mapping[str, str] = {curve.id: curve.name for curve in curves}
    cut: dict[tuple[str, bool], int] = {}
    for edge in net.edges:
        cut[edge.curve, edge.mirrored] = cut.get((edge.curve, edge.mirrored), 0) + 1
    names = []
    for edge in net.edges:
        name = named.get(edge.curve, edge.curve) + ("'" if edge.mirrored else "")
        whole = cut[edge.curve, edge.mirrored] == 1
        names.append(name if whole else f"{name}/{edge.piece + 1}")
    return tuple(names)


def loop_names(loop: Loop, names: Sequence[str]) -> list[str]:
    """Return the names of the edges of a loop, in their order."""
    return [names[edge] for edge, _ in loop]


def group_name(name: str) -> str:
    """Return the name of a surface as OBJ files have it, where blanks would end it."""
    return re.sub(r"\s+", "_", name.strip())
