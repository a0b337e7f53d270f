"""Networks of daily objects that no weight was tuned on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.plugins.product.sketched_network import Sketch


def saddle() -> Sketch:
    """A bicycle saddle: top of three strips a half, a skirt below."""
    s = Sketch(mirror=True)
    s.node(n=(140, 0, 10), a=(60, 0, 16), b=(-60, 0, 20), r=(-120, 0, 26))
    s.node(ns=(130, 14, 6), sa=(60, 22, 12), sb=(-60, 60, 14), rs=(-115, 65, 20))
    s.node(
        nl=(128, 13, -20), sal=(60, 24, -22), sbl=(-55, 58, -14), rl=(-110, 60, 0), nb=(136, 0, -22)
    )
    s.node(rb=(-118, 0, 4))
    s.curve("n a b r")
    s.curve("n ns sa", (0, 34, 12), "sb rs", (-122, 30, 24), "r")
    s.curve("a sa")
    s.curve("b sb")
    s.curve("nb nl sal", (0, 36, -20), "sbl rl", (-120, 30, 3), "rb")
    s.curve("sa sal")
    s.curve("sb sbl")
    s.curve("n nb")
    s.curve("r rb")
    s.face("n ns sa a", "a sa sb b", "b sb rs r")
    s.face("n ns sa sal nl nb", "sa sb sbl sal", "sb rs r rb rl sbl")
    return s


def sofa() -> Sketch:
    """A sofa of flat faces; its sides are concave."""
    s = Sketch()
    outline = [(0, 0), (80, 0), (80, 40), (25, 45), (15, 85), (0, 85)]
    for side, y in (("l", 0.0), ("r", 150.0)):
        for k, (x, z) in enumerate(outline):
            s.nodes[f"{side}{k}"] = np.array([x, y, z], float)
        for k in range(6):
            s.curve(f"{side}{k} {side}{(k + 1) % 6}")
        s.face(" ".join(f"{side}{k}" for k in range(6)))
    for k in range(6):
        s.curve(f"l{k} r{k}")
        n = (k + 1) % 6
        s.face(f"l{k} r{k} r{n} l{n}")
    return s


def bridge() -> Sketch:
    """A block with a round tunnel through it."""
    s = Sketch()
    for side, y in (("f", 0.0), ("b", 40.0)):
        places = [(-60, 0), (-60, 60), (60, 60), (60, 0), (30, 0), (0, 32), (-30, 0)]
        for k, (x, z) in enumerate(places):
            s.nodes[f"{side}{k}"] = np.array([x, y, z], float)
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 4), (6, 0)):
            s.curve(f"{side}{a} {side}{b}")
        s.curve(f"{side}4", (22, y, 23), f"{side}5", (-22, y, 23), f"{side}6")
        s.face(" ".join(f"{side}{k}" for k in range(7)))
    for k in (0, 1, 2, 3, 4, 6):
        s.curve(f"f{k} b{k}")
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 4), (6, 0)):
        s.face(f"f{a} f{b} b{b} b{a}")
    s.face("f4 f5 f6 b6 b5 b4")
    return s


def headphones() -> Sketch:
    """Two cups and a band between them."""
    s = Sketch(mirror=True)
    for ring, y, r in (("i", 70, 30), ("o", 95, 38), ("c", 105, 20)):
        for k in range(4):
            a = np.pi * k / 2 + 0.3
            s.nodes[f"{ring}{k}"] = np.array([r * np.cos(a), y, r * np.sin(a)])
        for k in range(4):
            a = np.pi * (k + 0.5) / 2 + 0.3
            s.curve(f"{ring}{k}", (r * np.cos(a), y, r * np.sin(a)), f"{ring}{(k + 1) % 4}")
    for k in range(4):
        n = (k + 1) % 4
        s.curve(f"i{k} o{k} c{k}")
        s.face(f"i{k} o{k} o{n} i{n}", f"o{k} c{k} c{n} o{n}")
    s.face("c0 c1 c2 c3")
    s.node(p=(10, 92, 45), q=(-10, 92, 45), pm=(12, 60, 110), qm=(-12, 60, 110), pt=(14, 0, 135))
    s.node(qt=(-14, 0, 135))
    s.curve("p pm pt")
    s.curve("q qm qt")
    s.curve("p q")
    s.curve("pm qm")
    s.curve("pt qt")
    s.face("p pm qm q", "pm pt qt qm")
    return s


def dryer() -> Sketch:
    """A hair dryer: a barrel, a grip that ends on it, a nozzle left open."""
    s = Sketch(mirror=True)
    rings = [(90, 18), (60, 30), (-30, 34), (-60, 20)]
    for i, (x, r) in enumerate(rings):
        s.node(**{f"t{i}": (x, 0, r), f"s{i}": (x, r, 0), f"b{i}": (x, 0, -r)})
        s.curve(f"t{i}", (x, 0.71 * r, 0.71 * r), f"s{i}", (x, 0.71 * r, -0.71 * r), f"b{i}")
    s.curve("t0 t1 t2 t3")
    s.curve("s0 s1 s2 s3")
    s.node(gf=(20, 0, -33), gb=(-12, 0, -34), ef=(30, 0, -110), eb=(0, 0, -112), es=(14, 14, -111))
    s.node(gs=(4, 14, -30))
    s.curve("b0 b1 gf")
    s.curve("gb b2 b3")
    s.curve("gf", (14, 10, -31), "gs", (-6, 10, -31), "gb")
    s.curve("ef", (24, 10, -110), "es", (4, 10, -112), "eb")
    s.curve("gf ef")
    s.curve("gb eb")
    s.curve("gs es")
    for i in (0, 2):
        s.face(f"t{i} t{i + 1} s{i + 1} s{i}", f"s{i} s{i + 1} b{i + 1} b{i}")
    s.face("t1 t2 s2 s1", "s1 s2 b2 gb gs gf b1")
    s.face("gf gs es ef", "gs gb eb es", "ef es eb es'", "t3 s3 b3 s3'")
    return s


def controller() -> Sketch:
    """A game controller: top, sides, grips, two sticks as closed curves."""
    s = Sketch(mirror=True)
    s.node(f=(30, 0, 20), b=(-25, 0, 22), fs=(35, 45, 15), g=(-60, 70, 5), k=(-30, 28, 18))
    s.node(fl=(30, 0, -5), bl=(-25, 0, -8), fsl=(34, 45, -6), gl=(-58, 68, -10), kl=(-30, 28, -8))
    s.curve("f", (36, 25, 19), "fs", (0, 80, 12), "g", (-55, 50, 8), "k", (-26, 10, 21), "b")
    s.curve("fl", (35, 25, -5), "fsl", (0, 78, -9), "gl", (-54, 50, -12), "kl", (-26, 10, -9), "bl")
    s.curve("f b")
    s.curve("fl bl")
    s.curve("f fl")
    s.curve("b bl")
    s.curve("fs fsl")
    s.curve("g gl")
    s.curve("k kl")
    s.face("f fs g k b", "fl fsl gl kl bl", "f fs fsl fl", "fs g gl fsl", "g k kl gl", "k b bl kl")
    a = np.linspace(0, 2 * np.pi, 9)[:-1]
    ring = np.stack((8 * np.cos(a), 25 + 8 * np.sin(a), np.full(8, 20.0)), axis=1)
    s.node(e=ring[0])
    s.curve("e", *ring[1:], closed=True, name="stick")
    s.face("e(stick)")
    return s


def kayak() -> Sketch:
    """A kayak: hull and deck as leaves with ribs, an oval cockpit."""
    s = Sketch(mirror=True)
    s.node(bow=(200, 0, 10), stern=(-200, 0, 10))
    for i, x in enumerate((90, 0, -90)):
        w = (22, 30, 24)[i]
        s.node(**{f"g{i}": (x, w, 8), f"k{i}": (x, 0, -14), f"d{i}": (x, 0, 20)})
        s.curve(f"k{i}", (x, 0.8 * w, -6), f"g{i}")
    s.curve("bow g0 g1 g2 stern")
    s.curve("bow k0 k1 k2 stern")
    s.curve("bow d0")
    s.curve("d2 stern")
    s.curve("g0 d0")
    s.curve("g2 d2")
    s.node(c=(0, 16, 18))
    s.curve("d0", (50, 13, 19), "c", (-50, 13, 19), "d2")
    s.curve("g1 c")
    s.nodes.pop("d1")
    s.face("bow k0 g0", "k0 k1 g1 g0", "k1 k2 g2 g1", "k2 stern g2")
    s.face("bow d0 g0", "stern d2 g2", "g0 d0 c g1", "g1 c d2 g2")
    return s


def cup_with_spoon() -> Sketch:
    """A six-sided cup, and a spoon beside it: two leaves and a stem."""
    s = Sketch()
    for i, (r, z) in enumerate(((25, 0), (35, 60))):
        for k in range(6):
            a = np.pi * k / 3
            s.nodes[f"{'ab'[i]}{k}"] = np.array([r * np.cos(a), r * np.sin(a), z])
        for k in range(6):
            s.curve(f"{'ab'[i]}{k} {'ab'[i]}{(k + 1) % 6}")
    for k in range(6):
        s.curve(f"a{k} b{k}")
        n = (k + 1) % 6
        s.face(f"a{k} b{k} b{n} a{n}")
    s.face(" ".join(f"a{k}" for k in range(6)))
    s.node(
        h=(70, 0, 5),
        t=(70, 40, 5),
        u=(68, 0, 5.5),
        v=(68, -80, 12),
        w=(72, -80, 12),
        x=(72, 0, 5.5),
    )
    s.curve("u", (58, 18, 5), "t", (82, 18, 5), "x")
    s.curve("t", (70, 20, -2), "h")
    s.curve("u h x")
    s.curve("u v")
    s.curve("x w")
    s.curve("v w")
    s.face("u t h", "x t h", "u h x w v")
    return s


HELD_OUT: dict[str, Callable[[], Sketch]] = {
    each.__name__: each
    for each in (saddle, sofa, bridge, headphones, dryer, controller, kayak, cup_with_spoon)
}
