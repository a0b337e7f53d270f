"""Networks of curves as a designer draws them: objects of daily use, half of them mirrored."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from tests.plugins.product.sketched_network import Sketch

DATA = Path(__file__).parent / "data"


def mouse() -> Sketch:
    """Half a computer mouse: base, waist, spine, button gap, wheel."""
    s = Sketch(mirror=True)
    s.node(f=(60, 0, 0), b=(-60, 0, 0), sf=(45, 28, 0), sb=(-40, 34, 0))
    s.node(wf=(58, 0, 12), wb=(-58, 0, 14), uf=(43, 29, 14), ub=(-42, 33, 20))
    s.node(t=(-5, 0, 42), g=(25, 0, 35), h=(10, 30, 20), k=(0, 25, 34))
    s.node(w1=(38, 0, 29), w2=(28, 5, 33.5))
    s.curve("f", (55, 18, 0), "sf", (5, 32, 0), "sb", (-55, 20, 0), "b")
    s.curve("wf", (54, 18, 12), "uf", "h", "ub", (-54, 22, 17), "wb")
    s.curve("f wf", (50, 0, 22), "w1 g t", (-45, 0, 34), "wb b")
    s.curve("sf uf")
    s.curve("sb ub")
    s.curve("h k t")
    s.curve("k", (25, 15, 30), (40, 7, 24), "wf")
    s.curve("w1 w2 g")
    s.face("f sf uf wf", "sf sb ub h uf", "sb b wb ub", "h k t wb ub", "k h uf wf", "w1 w2 g")
    s.face("k t g w2 w1 wf")
    return s


def helmet() -> Sketch:
    """A bicycle helmet: rim, spine, two ribs a side, vents."""
    s = Sketch(mirror=True)
    s.node(f=(120, 0, 20), b=(-120, 0, 0), m=(0, 0, 100))
    s.node(rf=(90, 60, 10), rb=(-90, 60, 0), r=(0, 85, 0))
    s.node(t1=(60, 0, 82), t2=(-60, 0, 86), p1=(55, 45, 65), p2=(-55, 48, 65), p=(0, 55, 75))
    s.curve("f", (110, 32, 14), "rf", (50, 78, 4), "r", (-50, 78, 0), "rb", (-110, 32, 0), "b")
    s.curve("f", (100, 0, 55), "t1 m t2", (-105, 0, 50), "b")
    s.curve("rf p1 p p2 rb")
    s.curve("t1 p1")
    s.curve("m p", (0, 75, 45), "r")
    s.curve("t2 p2")
    s.node(v1=(90, 12, 62), v2=(70, 20, 74))
    s.curve("v1", (82, 10, 70), "v2", name="va")
    s.curve("v1", (82, 22, 65), "v2", name="vb")
    s.face("f rf p1 t1", "t1 p1 p m", "m p p2 t2", "t2 p2 rb b", "rf p1 p r", "r p p2 rb")
    s.face("v1(va) v2(vb)")
    return s


def bottle() -> Sketch:
    """A bottle: four profiles, rings, a bottom."""
    return _revolved([(30, 0), (34, 60), (30, 110), (12, 140), (12, 165)], 4, bottom=True)


def lamp() -> Sketch:
    """A lampshade open above and below, a foot with a disc below."""
    s = _revolved([(90, 100), (60, 160), (25, 200)], 3)
    foot = _revolved([(60, 0), (45, 12), (8, 20)], 4, bottom=True, name="f")
    return _together(s, foot)


def vase() -> Sketch:
    """A vase with six profiles."""
    return _revolved([(20, 0), (45, 40), (50, 90), (25, 150), (35, 180)], 6, bottom=True)


def mug() -> Sketch:
    """A mug with a handle of two patches along, four round."""
    s = _revolved([(40, 0), (40, 45), (40, 90)], 4, bottom=True)
    ring = [(0, 6), (6, 0), (0, -6), (-6, 0)]
    sections = [((40, 0, 75), 0.0), ((75, 0, 45), 1.5), ((40, 0, 15), 3.1)]
    for i, (centre, angle) in enumerate(sections):
        out = np.array([np.cos(angle - 1.57), 0, -np.sin(angle - 1.57)])
        for k, (y, r) in enumerate(ring):
            s.nodes[f"h{i}{k}"] = np.asarray(centre) + np.array([0, y, 0]) - r * out
        for k in range(4):
            s.curve(f"h{i}{k} h{i}{(k + 1) % 4}")
    for k in range(4):
        s.curve(
            f"h0{k}",
            s.nodes[f"h0{k}"] + [24, 0, 2],
            f"h1{k}",
            s.nodes[f"h2{k}"] + [24, 0, -2],
            f"h2{k}",
        )
        for i in range(2):
            n = (k + 1) % 4
            s.face(f"h{i}{k} h{i}{n} h{i + 1}{n} h{i + 1}{k}")
    return s


def umbrella() -> Sketch:
    """Eight triangles that meet in a point."""
    s = Sketch()
    s.node(top=(0, 0, 30))
    _ring(s, "r", 60, 0, 8, sag=6)
    for k in range(8):
        a = np.pi * k / 4
        s.curve("top", (32 * np.cos(a), 32 * np.sin(a), 23), f"r{k}")
        s.face(f"top r{k} r{(k + 1) % 8}")
    return s


def rounded_box() -> Sketch:
    """A box with rounded edges: faces, strips and corners."""
    s = Sketch()
    size, r = np.array([60.0, 40.0, 25.0]), 8.0
    signs = [(a, b, c) for a in (1, -1) for b in (1, -1) for c in (1, -1)]
    for corner in signs:
        for axis in range(3):
            place = np.array(corner) * (size - r)
            place[axis] += corner[axis] * r
            s.nodes[_corner(corner, axis)] = place
        for a, b in ((0, 1), (1, 2), (2, 0)):
            first, second = s.nodes[_corner(corner, a)], s.nodes[_corner(corner, b)]
            inner = np.array(corner) * (size - r)
            out = first + second - 2 * inner
            s.curve(_corner(corner, a), inner + out * r / np.linalg.norm(out), _corner(corner, b))
        s.face(" ".join(_corner(corner, axis) for axis in range(3)))
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for along in (1, -1):
            ring = []
            for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
                corner = [0, 0, 0]
                corner[axis], corner[u], corner[v] = along, a, b
                ring.append(_corner(tuple(corner), axis))
            s.face(" ".join(ring))
            for first, second in zip(ring, ring[1:] + ring[:1], strict=True):
                s.curve(f"{first} {second}")
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for a in (1, -1):
            for b in (1, -1):
                ends = []
                for along in (1, -1):
                    corner = [0, 0, 0]
                    corner[axis], corner[u], corner[v] = along, a, b
                    ends.append(tuple(corner))
                s.face(
                    f"{_corner(ends[0], u)} {_corner(ends[1], u)} "
                    f"{_corner(ends[1], v)} {_corner(ends[0], v)}"
                )
    return s


def canoe() -> Sketch:
    """A hull of two leaves, with a deck at the bow."""
    s = Sketch(mirror=True)
    s.node(f=(100, 0, 10), b=(-100, 0, 10), d=(70, 14, 6), e=(70, 0, 9))
    s.curve("f d", (0, 28, 0), "b", name="gunwale")
    s.curve("f", (60, 0, -14), (0, 0, -20), (-60, 0, -14), "b", name="keel")
    s.curve("d e")
    s.curve("f e")
    s.face("f(keel) d b")
    s.face("f d e")
    return s


def hull() -> Sketch:
    """A boat with stations, transom and deck with a cockpit."""
    s = Sketch(mirror=True)
    s.node(bow=(100, 0, 20), keel=(85, 0, -5))
    xs = [50, 0, -50, -90]
    for i, x in enumerate(xs):
        w = [24, 32, 32, 26][i]
        s.nodes[f"k{i}"] = np.array([x, 0, -12.0])
        s.nodes[f"c{i}"] = np.array([x, 0.8 * w, -4.0])
        s.nodes[f"g{i}"] = np.array([x, w, 16.0 - i])
    s.nodes["d0"], s.nodes["d3"] = np.array([50, 0, 19.0]), np.array([-90, 0, 15.0])
    s.node(p=(30, 0, 18), q=(-60, 0, 16), o=(-15, 18, 15))
    s.curve("bow", (96, 0, 5), "keel k0 k1 k2 k3")
    s.curve("keel c0 c1 c2 c3")
    s.curve("bow g0 g1 g2 g3")
    for i in range(4):
        s.curve(f"k{i} c{i}")
        s.curve(f"c{i} g{i}")
        if i:
            s.face(f"k{i - 1} c{i - 1} c{i} k{i}", f"c{i - 1} g{i - 1} g{i} c{i}")
    s.face("keel k0 c0", "bow keel c0 g0")
    s.curve("k3 d3")
    s.curve("g3 d3")
    s.curve("bow d0 p")
    s.curve("q d3")
    s.curve("g0 d0")
    s.curve("p", (10, 15, 16), "o", (-45, 15, 15), "q")
    s.face("k3 c3 g3 d3", "bow g0 d0", "d0 g0 g1 g2 g3 d3 q o p")
    return s


def chair() -> Sketch:
    """A shell chair with arms, and a cushion."""
    s = Sketch(mirror=True)
    s.node(f=(25, 0, 42), m=(-20, 0, 38), t=(-32, 0, 85), u=(-22, 0, 62))
    s.node(fs=(22, 22, 43), ms=(-20, 24, 40), ts=(-30, 20, 84), a=(8, 28, 60), us=(-22, 23, 64))
    s.node(c=(14, 0, 45), cs=(12, 14, 46), d=(-12, 0, 43), ds=(-12, 15, 43))
    s.curve("f fs ms us ts t")
    s.curve("f", (0, 0, 40), "m", (-26, 0, 48), "u t")
    s.curve("ms m")
    s.curve("us u")
    s.curve("fs", (20, 28, 55), "a", (-8, 28, 64), "us")
    s.curve("c cs")
    s.curve("cs ds")
    s.curve("d ds")
    s.face("f fs ms m", "m ms us u", "u us ts t", "fs a us ms", "c cs ds d cs' ds'")
    s.faces[-1] = "cs ds d ds' cs' c"
    return s


def shoe() -> Sketch:
    """A shoe: sole, toe cap, vamp, quarters, collar, tongue left open."""
    s = Sketch()
    s.node(toe=(130, 0, 0), heel=(-130, 0, 0), l1=(80, 45, 0), l2=(-60, 32, 0))
    s.node(r1=(70, -40, 0), r2=(-60, -30, 0), tip=(118, 0, 28), cl=(78, 38, 30), cr=(70, -34, 30))
    s.node(cap=(88, 2, 50), throat=(40, 2, 70), al=(-40, 30, 62), ar=(-40, -28, 62))
    s.node(back=(-122, 0, 85), h=(-128, 0, 40))
    s.curve("toe", (115, 32, 0), "l1", (10, 30, 0), "l2", (-115, 22, 0), "heel")
    s.curve("toe", (112, -30, 0), "r1", (5, -26, 0), "r2", (-115, -22, 0), "heel")
    s.curve("toe tip cap throat")
    s.curve("l1 cl cap")
    s.curve("r1 cr cap")
    s.curve("l2 al")
    s.curve("r2 ar")
    s.curve("throat", (0, 28, 66), "al", (-95, 24, 76), "back")
    s.curve("throat", (0, -26, 66), "ar", (-95, -22, 76), "back")
    s.curve("heel h back")
    s.face("toe l1 cl cap tip", "toe r1 cr cap tip", "l1 l2 al throat cap cl")
    s.face("r1 r2 ar throat cap cr", "l2 heel h back al", "r2 heel h back ar")
    s.face("toe l1 l2 heel r2 r1")
    return s


def car() -> Sketch:
    """Half a car: bonnet, screens, roof, doors, wheel arches cut into the side."""
    s = Sketch(mirror=True)
    s.node(n=(200, 0, 55), nb=(205, 0, 25), c=(90, 0, 85), r0=(30, 0, 125), r1=(-90, 0, 128))
    s.node(d=(-150, 0, 95), t=(-195, 0, 90), tb=(-200, 0, 35))
    s.node(sn=(180, 60, 55), sc=(85, 75, 85), s0=(25, 58, 122), s1=(-85, 60, 124))
    s.node(sd=(-145, 72, 95), st=(-185, 62, 88), sb=(190, 65, 25), sbb=(-190, 66, 35))
    s.node(p=(-20, 80, 88), ps=(-25, 62, 125), q=(-20, 82, 22), a=(90, 82, 22))
    s.node(f1=(165, 78, 22), f2=(105, 82, 22), e1=(-105, 82, 24), e2=(-165, 78, 26))
    s.node(fm=(135, 80, 55), em=(-135, 80, 56))
    s.curve("n", (195, 40, 55), "sn sc p", (-90, 80, 92), "sd st", (-193, 40, 89), "t")
    s.curve("nb n c r0", (-30, 0, 131), "r1 d t tb")
    s.curve("nb", (203, 40, 25), "sb")
    s.curve("tb", (-198, 40, 35), "sbb")
    s.curve("sb f1 f2 a q e1 e2 sbb")
    s.curve("sn sb")
    s.curve("st sbb")
    s.curve("f1", (157, 79, 46), "fm", (113, 81, 46), "f2")
    s.curve("e1", (-113, 81, 48), "em", (-157, 79, 48), "e2")
    s.curve("c sc")
    s.curve("sc s0 ps s1 sd")
    s.curve("r0 s0")
    s.curve("r1 s1")
    s.curve("d sd")
    s.curve("p ps")
    s.curve("p q")
    s.curve("sc a")
    s.face("n sn sc c", "c sc s0 r0", "r0 s0 ps s1 r1", "r1 s1 sd d", "d sd st t")
    s.face("nb sb sn n", "tb sbb st t", "sc s0 ps p", "p ps s1 sd", "sc a q p")
    s.face("sn sb f1 fm f2 a sc", "p q e1 em e2 sbb st sd")
    return s


def remote() -> Sketch:
    """A remote control: a body of five sides a half, and buttons lying on top."""
    s = Sketch(mirror=True)
    s.node(f=(80, 0, 0), b=(-80, 0, 0), fs=(75, 20, 0), bs=(-75, 22, 0))
    s.node(tf=(78, 0, 14), tb=(-78, 0, 18), tfs=(73, 17, 14), tbs=(-73, 19, 18))
    s.node(m=(0, 0, 20), ms=(0, 17, 19), o=(0, 20, 0))
    s.curve("f fs", (20, 19, 0), "o", (-40, 21, 0), "bs b")
    s.curve("tf tfs", (20, 16, 17), "ms", (-40, 18, 20), "tbs tb")
    s.curve("tf m tb")
    s.curve("fs tfs")
    s.curve("bs tbs")
    s.curve("m ms")
    s.curve("o ms")
    s.curve("f tf")
    s.curve("b tb")
    s.face("f fs tfs tf", "b bs tbs tb", "fs o ms tfs", "o bs tbs ms", "tf tfs ms m", "m ms tbs tb")
    s.faces.append("f fs o bs b bs' o' fs'")
    for k, x in enumerate((45, 25, -30)):
        a = np.linspace(0, 2 * np.pi, 9)[:-1]
        ring = np.stack((x + 6 * np.cos(a), 8 + 4 * np.sin(a), np.full(8, 19.5)), axis=1)
        s.node(**{f"e{k}": ring[0]})
        s.curve(f"e{k}", *ring[1:], closed=True, name=f"button{k}")
        s.face(f"e{k}(button{k})")
    return s


def iron() -> Sketch:
    """A clothes iron: sole plate with a point, body, and a handle with four sides."""
    s = Sketch(mirror=True)
    s.node(tip=(120, 0, 0), b=(-90, 0, 0), w=(-60, 50, 0), bt=(-85, 0, 40), wt=(-55, 40, 38))
    s.node(n=(90, 0, 30), h0=(55, 0, 45), h1=(-60, 0, 55), g0=(55, 12, 43), g1=(-55, 14, 53))
    s.node(k0=(30, 0, 80), l0=(30, 10, 78), k1=(-50, 0, 85), l1=(-45, 11, 83))
    s.node(i0=(35, 0, 48), j0=(35, 12, 46), i1=(-35, 0, 55), j1=(-35, 14, 53))
    s.node(u0=(20, 0, 68), v0=(20, 10, 68), u1=(-35, 0, 74), v1=(-35, 11, 74))
    s.curve("tip", (60, 40, 0), "w b")
    s.curve("tip n h0")
    s.curve("n", (60, 30, 32), "wt bt")
    s.curve("w wt")
    s.curve("b bt h1")
    s.curve("h0 g0 j0 i0")
    s.curve("h1 g1 j1 i1")
    s.curve("j0 j1")
    s.curve("i0 i1")
    s.curve("h0 k0 k1 h1")
    s.curve("g0 l0 l1 g1")
    s.curve("i0 u0 u1 i1")
    s.curve("j0 v0 v1 j1")
    s.curve("k0 l0")
    s.curve("l0 v0")
    s.curve("v0 u0")
    s.curve("k1 l1")
    s.curve("l1 v1")
    s.curve("v1 u1")
    s.face("tip w b w'", "tip w wt n", "w b bt wt", "n wt bt h1 g1 j1 j0 g0 h0", "i0 j0 j1 i1")
    s.face("h0 g0 l0 k0", "k0 l0 l1 k1", "k1 l1 g1 h1", "g0 l0 v0 j0", "l0 l1 v1 v0")
    s.face("l1 g1 j1 v1", "j0 v0 u0 i0", "v0 v1 u1 u0", "v1 j1 i1 u1")
    return s


def aeroplane() -> Sketch:
    """A fuselage of sections, with a wing and a fin of two leaves each."""
    s = Sketch(mirror=True)
    sections = [(60, 10), (20, 14), (-20, 14), (-70, 6)]
    s.node(nose=(90, 0, 0), tail=(-100, 0, 4))
    for i, (x, r) in enumerate(sections):
        s.nodes[f"t{i}"] = np.array([x, 0.0, r])
        s.nodes[f"s{i}"] = np.array([x, r, 0.0])
        s.nodes[f"b{i}"] = np.array([x, 0.0, -r])
        s.curve(f"t{i}", (x, 0.7 * r, 0.7 * r), f"s{i}", (x, 0.7 * r, -0.7 * r), f"b{i}")
    s.curve("nose t0 t1 t2 t3 tail")
    s.curve("nose s0 s1 s2 s3 tail")
    s.curve("nose b0 b1 b2 b3 tail")
    for side in "tb":
        s.face(f"nose {side}0 s0", f"{side}3 tail s3")
        for i in range(3):
            if i != 1:
                s.face(f"{side}{i} {side}{i + 1} s{i + 1} s{i}")
        s.face(f"{side}1 {side}2 s2 s1({'top' if side == 't' else 'low'})")
    s.node(w1=(-5, 110, 2), w2=(-25, 110, 2))
    s.curve("s1", (0, 14.5, 2.5), "s2", name="top")
    s.curve("s1", (0, 14.5, -2.5), "s2", name="low")
    s.curve("w1", (-15, 110, 3.5), "w2", name="wtop")
    s.curve("w1", (-15, 110, 0.5), "w2", name="wlow")
    s.curve("s1 w1")
    s.curve("s2 w2")
    s.face("s1 w1 w2(wtop) s2", "s1 w1 w2(wlow) s2", "w1(wtop) w2(wlow)")
    s.faces[-3] = "s2 s1(top) w1 w2(wtop)"
    s.faces[-2] = "s2 s1(low) w1 w2(wlow)"
    mirrored = s.curves.pop("c5")[2]
    s.curves["c5a"] = (("nose", "s0", "s1"), False, mirrored)
    s.curves["c5b"] = (("s2", "s3", "tail"), False, mirrored)
    return s


def sandal() -> Sketch:
    """A sandal: a sole with thickness and two straps."""
    s = Sketch()
    outline = [(120, 10), (95, 45), (0, 28), (-80, 32), (-118, 0), (-80, -28), (0, -32), (80, -45)]
    for k, (x, y) in enumerate(outline):
        s.nodes[f"t{k}"] = np.array([x, y, 12 + 8 * np.cos((x + 120) / 240 * np.pi) ** 2])
        s.nodes[f"b{k}"] = np.array([x, y, 0.0])
    for side in "tb":
        names = [f"{side}{k}" for k in range(8)]
        s.curve(" ".join([*names, names[0]]), name=side)
        s.curves[side] = (tuple(names), True, False)
        s.face(" ".join(names))
    for k in (0, 2, 4, 6):
        s.curve(f"t{k} b{k}")
    for k in range(0, 8, 2):
        a, b, c = k, k + 1, (k + 2) % 8
        s.face(f"t{a} t{b} t{c} b{c} b{b} b{a}")
    s.node(a=(60, 0, 60), b=(40, 0, 62))
    s.curve("t1", (90, 25, 50), "a", (75, -25, 50), "t7")
    s.curve("t2", (20, 25, 50), "b", (20, -25, 50), "t6")
    s.curve("a b")
    s.face("t1 a b t2", "t7 a b t6")
    return s


def cushion() -> Sketch:
    """Two curves in one plane, one across: four leaves like a ball's panels."""
    s = Sketch()
    s.node(a=(50, 0, 0), b=(-50, 0, 0))
    for k in range(4):
        y, z = 40 * np.cos(k * np.pi / 2), 25 * np.sin(k * np.pi / 2)
        s.curve("a", (25, 0.87 * y, 0.87 * z), (-25, 0.87 * y, 0.87 * z), "b", name=f"m{k}")
    for k in range(4):
        s.face(f"a(m{k}) b(m{(k + 1) % 4})")
    return s


def guitar() -> Sketch:
    """A guitar's body: table and back of one closed curve each with a few nodes, sides, a hole."""
    s = Sketch(mirror=True)
    outline = [(-110, 0), (-70, 70), (0, 45), (55, 55), (95, 0)]
    for side, z in (("t", 20), ("b", -20)):
        for k, (x, y) in enumerate(outline):
            s.nodes[f"{side}{k}"] = np.array([x, y, z], float)
        s.curve(f"{side}0", (-105, 40, z), f"{side}1 {side}2 {side}3", (88, 30, z), f"{side}4")
    for k in (0, 2, 4):
        s.curve(f"t{k} b{k}")
    s.face("t0 t1 t2 t3 t4 t3' t2' t1'", "b0 b1 b2 b3 b4 b3' b2' b1'")
    s.face("t0 t1 t2 b2 b1 b0", "t2 t3 t4 b4 b3 b2")
    return s


def handset() -> Sketch:
    """A telephone handset: a bar between two heads, each closed by a disc."""
    s = Sketch(mirror=True)
    for end, x in (("l", -70), ("r", 70)):
        for k, (dx, y) in enumerate(((-25, 0), (0, 25), (25, 0))):
            s.nodes[f"{end}{k}"] = np.array([x + dx, y, 0.0])
        s.nodes[f"{end}t"] = np.array([x, 0, 35.0])
        s.nodes[f"{end}s"] = np.array([x, 20, 24.0])
        s.curve(f"{end}0", (x - 18, 18, 0), f"{end}1", (x + 18, 18, 0), f"{end}2")
        s.curve(f"{end}1 {end}s {end}t")
        s.face(f"{end}0 {end}1 {end}2 {end}1'")
    s.curve("l0", (-94, 0, 20), "lt rt", (94, 0, 20), "r2")
    s.curve("l2", (-38, 0, 18), (38, 0, 18), "r0")
    s.curve("ls", (0, 14, 24), "rs")
    s.face("l0 l1 ls lt", "r2 r1 rs rt", "lt ls rs rt", "l2 l1 ls rs r1 r0")
    return s


def tent() -> Sketch:
    """A tunnel tent: hoops, ridge, a door of one T-joint."""
    s = Sketch()
    for i, x in enumerate((-60, 0, 60)):
        r = 30 if i == 1 else 25
        s.nodes[f"l{i}"] = np.array([x, r, 0.0])
        s.nodes[f"t{i}"] = np.array([x, 0, 1.1 * r])
        s.nodes[f"r{i}"] = np.array([x, -r, 0.0])
        s.curve(f"l{i}", (x, 0.75 * r, 0.75 * r), f"t{i}", (x, -0.75 * r, 0.75 * r), f"r{i}")
    s.curve("t0 t1 t2")
    s.curve("l0 l1 l2")
    s.curve("r0 r1 r2")
    s.node(d=(20, 0, 32), e=(35, -28.5, 0))
    s.curves["c3"] = (("t0", "t1", "d", "t2"), False, False)
    s.curves["c5"] = (("r0", "r1", "e", "r2"), False, False)
    s.curve("d", (30, -20, 20), "e")
    s.face("l0 t0 t1 l1", "r0 t0 t1 r1", "l1 t1 d t2 l2", "r1 t1 d e", "d t2 r2 e")
    return s


def propeller() -> Sketch:
    """Three blades on a hub: leaves with a root."""
    s = Sketch()
    n = 3
    for k in range(n):
        a = 2 * np.pi * k / n
        turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
        s.nodes[f"a{k}"], s.nodes[f"b{k}"] = turn @ [9, -5, -4], turn @ [9, 5, 4]
        s.nodes[f"tip{k}"] = turn @ [80, 0, 0]
        s.curve(f"a{k}", turn @ [40, -12, -5], f"tip{k}")
        s.curve(f"b{k}", turn @ [40, 12, 5], f"tip{k}")
        s.curve(f"a{k}", turn @ [10.5, 0, 2], f"b{k}", name=f"over{k}")
        s.curve(f"a{k}", turn @ [10.5, 0, -2], f"b{k}", name=f"under{k}")
        s.face(f"a{k} b{k}(over{k}) tip{k}", f"a{k} b{k}(under{k}) tip{k}")
    return s


def teapot() -> Sketch:
    """The edges of the Utah teapot's patches, each one a curve."""
    data = json.loads((DATA / "utah_teapot.json").read_text())
    vertices = np.array(data["vertices"])
    s = Sketch()
    names: dict[tuple[float, ...], str] = {}
    known: dict[frozenset[tuple[float, ...]], str] = {}
    for numbers in data["patches"]:
        net = vertices[np.reshape(numbers, (4, 4))]
        face = []
        for side in (net[:, 0], net[3], net[::-1, 3], net[0, ::-1]):
            if np.ptp(side, axis=0).max() < 1e-9:
                continue
            for place in (side[0], side[-1]):
                key = tuple(np.round(place, 6))
                if key not in names:
                    names[key] = f"n{len(names)}"
                    s.nodes[names[key]] = place
            start, end = (names[tuple(np.round(side[k], 6))] for k in (0, -1))
            t = np.linspace(0, 1, 7)[:, None]
            points = (
                (1 - t) ** 3 * side[0]
                + 3 * t * (1 - t) ** 2 * side[1]
                + 3 * t * t * (1 - t) * side[2]
                + t**3 * side[3]
            )
            middle = frozenset([tuple(np.round(points[3], 5))])
            key = frozenset([*middle, (start, end) if start < end else (end, start)])
            if key not in known:
                known[key] = f"c{len(s.curves)}"
                s.curve(start, *points[1:-1], end, name=known[key])
            face.append(f"{end}({known[key]})")
        s.face(" ".join(face))
    return s


def sheet(rows: int, columns: int) -> Sketch:
    """A bent sheet of four-sided patches, each edge a curve of its own."""
    s = Sketch()

    def at(i: float, j: float) -> tuple[float, float, float]:
        x, y = 2 * i / (rows - 1) - 1, 2 * j / (columns - 1) - 1
        return 100 * x, 100 * y, 30 * np.sin(2 * x) * np.cos(1.5 * y)

    for i in range(rows):
        for j in range(columns):
            s.nodes[f"n{i}.{j}"] = np.array(at(i, j))
    for i in range(rows):
        for j in range(columns):
            if i:
                s.curve(f"n{i - 1}.{j}", at(i - 2 / 3, j), at(i - 1 / 3, j), f"n{i}.{j}")
            if j:
                s.curve(f"n{i}.{j - 1}", at(i, j - 2 / 3), at(i, j - 1 / 3), f"n{i}.{j}")
            if i and j:
                s.face(f"n{i - 1}.{j - 1} n{i}.{j - 1} n{i}.{j} n{i - 1}.{j}")
    return s


# -- parts of networks -----------------------------------------------------------------------


def _corner(corner: tuple[int, ...], axis: int) -> str:
    return "".join("pm"[each < 0] for each in corner) + "xyz"[axis]


def _ring(s: Sketch, name: str, radius: float, z: float, count: int, sag: float = 0.0) -> None:
    """Add a ring of nodes and of curves between them."""
    for k in range(count):
        a = 2 * np.pi * k / count
        s.nodes[f"{name}{k}"] = np.array([radius * np.cos(a), radius * np.sin(a), z])
    for k in range(count):
        a = 2 * np.pi * (k + 0.5) / count
        middle = (radius * np.cos(a), radius * np.sin(a), z + sag)
        s.curve(f"{name}{k}", middle, f"{name}{(k + 1) % count}")


def _revolved(
    profile: list[tuple[float, float]], count: int, bottom: bool = False, name: str = "r"
) -> Sketch:
    """A surface of revolution: rings cut by profiles, open above; closed below or not."""
    s = Sketch()
    for i, (radius, z) in enumerate(profile):
        _ring(s, f"{name}{i}.", radius, z, count)
    for k in range(count):
        s.curve(" ".join(f"{name}{i}.{k}" for i in range(len(profile))))
        n = (k + 1) % count
        for i in range(len(profile) - 1):
            s.face(f"{name}{i}.{k} {name}{i + 1}.{k} {name}{i + 1}.{n} {name}{i}.{n}")
    if bottom:
        s.face(" ".join(f"{name}0.{k}" for k in range(count)))
    return s


def _together(first: Sketch, second: Sketch) -> Sketch:
    curves = {**first.curves, **{f"{name} 2": each for name, each in second.curves.items()}}
    faces = first.faces + second.faces
    return Sketch(first.mirror, {**first.nodes, **second.nodes}, curves, faces)


DRAWN: dict[str, Callable[[], Sketch]] = {
    each.__name__: each
    for each in (
        mouse,
        helmet,
        bottle,
        lamp,
        vase,
        mug,
        umbrella,
        rounded_box,
        canoe,
        hull,
        chair,
        shoe,
        car,
        remote,
        iron,
        aeroplane,
        sandal,
        cushion,
        guitar,
        handset,
        tent,
        propeller,
        teapot,
    )
} | {"sheet": partial(sheet, 5, 5)}
