"""The surfaces of all loops of a network as in the paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from bozzetto_product.fill.edge_pieces import EdgePiece, pieces_of
from bozzetto_product.fill.mirrored_fill import image_loop, mirror_axis, mirrored, with_twins
from bozzetto_product.fill.network_fills import is_run_of, mesh_spacing
from bozzetto_product.network.net import HalfEdge, Loop, Net
from bozzetto_product.paper.paper_surface import PaperSurface, border_points, paper_surface
from bozzetto_product.paper.triangulation import Triangles

PIECES: Final = 2
"""Pieces of each edge: the fewest that fills cut it into."""

CLOSED_PIECES: Final = 8
"""Pieces of a closed curve: each has three segments at least, so it stays round."""


def paper_surfaces(
    net: Net,
    loops: Sequence[Loop],
    *,
    checkpoint: Callable[[], None] = lambda: None,
) -> tuple[PaperSurface, ...]:
    """Return a surface for each loop; that of a mirror image is the image of the other's.

    Parameters
    ----------
    net : Net
        The network.
    loops : sequence of Loop
        Counter-clockwise seen from outside.
    checkpoint : callable
        Called before each loop.
    """
    spacing = mesh_spacing(net, loops)
    axis = mirror_axis(net)
    counts = [CLOSED_PIECES if each.spline.closed else PIECES for each in net.edges]
    cut = [pieces_of(each.spline, many) for each, many in zip(net.edges, counts, strict=True)]
    pieces = with_twins(net, cut, axis)
    made: list[PaperSurface] = []
    known: dict[frozenset[HalfEdge], PaperSurface] = {}
    for loop in loops:
        checkpoint()
        own = tuple(pieces[edge] for edge, _ in loop)
        image = None if axis is None else image_loop(net, loop, axis)
        other = known.get(frozenset(image or ()))
        if image and other is not None and axis is not None and is_run_of(net, image, other.loop):
            found = _image(other, loop, image, own, spacing, axis)
        else:
            found = paper_surface(loop, own, spacing)
            known[frozenset(loop)] = found
        made.append(found)
    return tuple(made)


def _image(
    surface: PaperSurface,
    loop: Loop,
    image: Loop,
    pieces: tuple[tuple[EdgePiece, ...], ...],
    spacing: float,
    axis: int,
) -> PaperSurface:
    """Return the mirror image of a surface as that of a loop, whose own image is ``image``."""
    points, starts = border_points(loop, pieces, spacing)
    count = len(points)
    # The image of a loop runs backward from where the loop starts.
    last = int(surface.starts[surface.loop.index(image[0])])
    order = (last - np.arange(count)) % count
    other = surface.triangles
    number = np.arange(len(other.points))
    number[order] = np.arange(count)
    places = np.concatenate((points, mirrored(other.points[count:], axis)))
    return PaperSurface(loop, Triangles(places, number[other.faces][:, ::-1], count), starts)
