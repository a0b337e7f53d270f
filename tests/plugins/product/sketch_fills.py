"""Surfaces of sketched networks, through the loops that are meant."""

from __future__ import annotations

from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.network.net import Loop, Net
from tests.plugins.product.sketched_network import Sketch


def fills_of_sketch(sketch: Sketch) -> tuple[Fill, ...]:
    """Return the surfaces that do not fold."""
    net = sketch.net()
    rings = [ring_of(net, edges) for edges in sketch.truth(net, strict=False)]
    loops = orient_loops(net, [ring for ring in rings if ring is not None]).loops
    return tuple(fill for fill in fill_net(net, loops) if fill is not None and not fill.folded)


def ring_of(net: Net, edges: frozenset[int]) -> Loop | None:
    """Return edges in their order round a loop."""
    left, first = set(edges), min(edges)
    left.remove(first)
    row, at = [(first, True)], net.edges[first].end
    while left:
        here = (e for e in sorted(left) if at in (net.edges[e].start, net.edges[e].end))
        edge = next(here, None)
        if edge is None:
            return None
        left.remove(edge)
        forward = net.edges[edge].start == at
        row.append((edge, forward))
        at = net.edges[edge].end if forward else net.edges[edge].start
    return tuple(row)
