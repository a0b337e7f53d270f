"""Loops turned alike and outward."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_product.loops.finding import find_loops
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import reversed_outline
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.random_networks import cells
from tests.plugins.product.sketched_network import Sketch


def _volume(net: Net, loops: tuple[Loop, ...]) -> float:
    """Return the volume within flat cones over loops, by the divergence theorem."""
    total = 0.0
    for loop in loops:
        ring = np.vstack(
            [net.edges[e].spline.sampled(17)[:: 1 if on else -1][:-1] for e, on in loop]
        )
        apex = ring.mean(axis=0)
        total += (
            np.linalg.det(
                np.stack((np.broadcast_to(apex, ring.shape), ring, np.roll(ring, -1, 0)), 1)
            ).sum()
            / 6
        )
    return float(total)


@pytest.mark.parametrize("seed", [2001, 2002, 2003])
def test_a_closed_body_is_closed_and_faces_outward(seed: int) -> None:
    net = cells(seed).net()
    loops = find_loops(net).loops
    random = np.random.default_rng(seed)
    mixed = [reversed_outline(each) if random.random() < 0.5 else each for each in loops]
    made = orient_loops(net, mixed)
    assert made.closed == (True,)
    assert not made.open_edges
    assert not made.one_sided
    halves = [half for loop in made.loops for half in loop]
    assert len(set(halves)) == len(halves) == 2 * len(net.edges)
    assert _volume(net, made.loops) > 0
    assert orient_loops(net, made.loops).loops == made.loops


def test_an_open_sheet_faces_up_and_tells_its_rim() -> None:
    net = DRAWN["sheet"]().net()
    made = orient_loops(net, find_loops(net).loops)
    assert made.closed == (False,)
    assert len(made.open_edges) == 16


def test_parts_are_turned_each_by_itself() -> None:
    net = DRAWN["lamp"]().net()
    made = orient_loops(net, find_loops(net).loops)
    assert len(made.parts) == 2


def test_a_moebius_strip_is_told() -> None:
    s = Sketch()
    n = 6
    for k in range(n):
        a, half = 2 * np.pi * k / n, np.pi * k / n
        out = np.array([np.cos(a), np.sin(a), 0.0])
        across = np.cos(half) * np.array([0, 0, 1.0]) + np.sin(half) * out
        s.nodes[f"a{k}"], s.nodes[f"b{k}"] = 50 * out + 12 * across, 50 * out - 12 * across
        s.curve(f"a{k} b{k}")
    for k in range(n):
        a, b = (f"a{k + 1}", f"b{k + 1}") if k + 1 < n else ("b0", "a0")
        s.curve(f"a{k} {a}")
        s.curve(f"b{k} {b}")
        s.face(f"a{k} {a} {b} b{k}")
    net = s.net()
    found = {frozenset(e for e, _ in loop): loop for loop in find_loops(net).candidates}
    strip = [found[face] for face in s.truth(net)]
    made = orient_loops(net, strip)
    assert made.one_sided
    assert made.closed == (False,)


def test_a_third_loop_at_an_edge_is_told() -> None:
    s = Sketch()
    s.node(a=(0, 0, 0), b=(10, 0, 0))
    s.curve("a b")
    for k in range(3):
        turn = 2 * np.pi * k / 3
        s.curve("a", (5, 5 * np.cos(turn), 5 * np.sin(turn)), "b")
    net = s.net()
    book = [loop for loop in find_loops(net).candidates if any(edge == 0 for edge, _ in loop)]
    made = orient_loops(net, book)
    assert made.crowded_edges == (0,)
    assert made.closed == (False,) * len(made.closed)
