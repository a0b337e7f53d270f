"""Hostile files: SVG."""

from __future__ import annotations

import gzip
import math
import random

from tests.hostile_files.families import family, filled


def svg(body: bytes, head: bytes = b"") -> bytes:
    return b'<svg xmlns="http://www.w3.org/2000/svg"' + head + b">" + body + b"</svg>"


def path(data: bytes) -> bytes:
    return svg(b'<path d="' + data + b'"/>')


def polygon(places, extra: bytes = b"") -> bytes:
    row = " ".join(f"{x:.4f},{y:.4f}" for x, y in places).encode()
    return b'<polygon points="' + row + b'"' + extra + b"/>"


def random_places(count: int, seed: int, width: float = 1000.0):
    rng = random.Random(seed)
    return [(rng.uniform(0, width), rng.uniform(0, width)) for _ in range(count)]


@family("svg length of digits")
def _(size):
    return svg(b'<rect width="' + b"1" * size + b'q" height="1"/><path d="M0 0L1 1"/>')


@family("svg length of blanks")
def _(size):
    return svg(b'<rect width="1' + b" " * size + b'q" height="1"/><path d="M0 0L1 1"/>')


@family("svg style without braces")
def _(size):
    return svg(b"<style>" + b"a" * size + b"</style><path d='M0 0L1 1'/>")


@family("svg style of open comments")
def _(size):
    return svg(b"<style>" + filled(b"/* ", size) + b"</style><path d='M0 0L1 1'/>")


@family("svg selectors times declarations")
def _(size):
    row = b",".join(b".a%d" % k for k in range(size // 20))
    said = b";".join(b"p%d:1" % k for k in range(size // 20))
    return svg(b"<style>" + row + b"{" + said + b"}</style><path d='M0 0L1 1'/>")


@family("svg use times path")
def _(size):
    curve = b"M0 0" + filled(b"L1 2", size // 2)
    uses = filled(b'<use href="#p"/>', size // 2)
    return svg(b'<defs><path id="p" d="' + curve + b'"/></defs>' + uses)


@family("svg use times transform")
def _(size):
    turns = filled(b"scale(1)", size // 2)
    uses = filled(b'<use href="#p"/>', size // 2)
    return svg(b'<path id="p" transform="' + turns + b'" d="M0 0L1 1"/>' + uses)


@family("svg clip times elements")
def _(size):
    clip = b'<clipPath id="c"><path d="M0 0' + filled(b"L9 7", size // 2) + b'"/></clipPath>'
    return svg(clip + filled(b'<path clip-path="url(#c)" d="M0 0L1 1"/>', size // 2))


@family("svg many clips of many lines")
def _(size):
    count = size // 150
    clips = b"".join(
        b'<clipPath id="c%d"><circle cx="5" cy="5" r="4"/></clipPath>' % k for k in range(count)
    )
    return svg(clips + b"".join(
        b'<path clip-path="url(#c%d)" stroke="red" d="M0 0L9 9"/>' % k for k in range(count)
    ))  # fmt: skip


@family("svg clips of clips in a ring")
def _(size):
    one = b'<clipPath id="c%d" clip-path="url(#c%d)"><rect width="9" height="9"/></clipPath>'
    count = max(1, size // 80)
    clips = b"".join(one % (k, (k + 1) % count) for k in range(count))
    return svg(clips + b'<path clip-path="url(#c0)" stroke="red" d="M0 0L20 1"/>')


@family("svg a clip of a star, of a scribble")
def _(size):
    count = size // 24
    star = b"".join(b"L%d %d" % (k * 7919 % 997, k * 104729 % 991) for k in range(count))
    clip = b'<clipPath id="c"><path clip-rule="evenodd" d="M0 0%s"/></clipPath>' % star
    return svg(clip + b'<path clip-path="url(#c)" stroke="red" fill="none" d="M9 1%s"/>' % star)


@family("svg clips in clips")
def _(size):
    depth, clip = 60, b'<clipPath id="c"><rect width="9" height="9"/></clipPath>'
    inside = filled(b'<path d="M0 0L1 1"/>', size)
    return svg(clip + b'<g clip-path="url(#c)">' * depth + inside + b"</g>" * depth)


@family("svg transform of a style times classes")
def _(size):
    look = b"<style>.a{transform:" + filled(b"scale(1)", size // 2) + b"}</style>"
    return svg(look + filled(b'<path class="a" d="M0 0L1 1"/>', size // 2))


@family("svg use times classes")
def _(size):
    classes = filled(b"a b ", size // 2)
    uses = filled(b'<use href="#p"/>', size // 2)
    look = b"<style>a{fill:red}</style>"
    return svg(look + b'<path id="p" class="' + classes + b'" d="M0 0L1 1"/>' + uses)


@family("svg symbol times attributes")
def _(size):
    many = b" ".join(b'a%d="1"' % k for k in range(size // 24))
    uses = filled(b'<use href="#p"/>', size // 2)
    return svg(b'<symbol id="p" ' + many + b'><path d="M0 0L1 1"/></symbol>' + uses)


@family("svg use of use, doubling")
def _(size):
    levels = min(60, max(2, size // 60))
    row = b"".join(
        b'<g id="g%d"><use href="#g%d"/><use href="#g%d"/></g>' % (k, k - 1, k - 1)
        for k in range(1, levels)
    )
    return svg(b'<g id="g0"><path d="M0 0L1 1"/></g>' + row)


@family("svg use of itself")
def _(size):
    return svg(b'<g id="a">' + filled(b'<use href="#a"/>', size) + b'</g><path d="M0 0L1 1"/>')


@family("svg groups of nothing, used")
def _(size):
    empty = filled(b"<g/>", size // 2)
    return svg(b'<g id="a">' + empty + b"</g>" + filled(b'<use href="#a"/>', size // 2))


@family("svg one random polygon")
def _(size):
    return svg(polygon(random_places(size // 20, 1)))


@family("svg two random polygons")
def _(size):
    both = (polygon(random_places(size // 40, seed)) for seed in (1, 2))
    return svg(b"".join(both))


@family("svg a comb of diagonals")
def _(size):
    teeth = size // 40
    places = [p for k in range(teeth) for p in ((k * 1e-3, 0.0), (1000 + k * 1e-3, 1000.0))]
    return svg(polygon(places))


@family("svg a star of spokes")
def _(size):
    spokes = max(3, size // 40)
    turn = 2 * math.pi / spokes
    places = [
        p
        for k in range(spokes)
        for p in ((0.0, 0.0), (900 * math.cos(k * turn), 900 * math.sin(k * turn)))
    ]
    return svg(polygon(places))


@family("svg squares on each other")
def _(size):
    return svg(filled(b'<rect width="9" height="9"/>', size).replace(b'"9"', b'"8.5"', 1))


@family("svg squares that all overlap")
def _(size):
    count = max(2, size // 45)
    return svg(b"".join(b'<rect x="%d" width="99999" height="%d"/>' % (k, k + 1)
                        for k in range(count)))  # fmt: skip


@family("svg path of small steps")
def _(size):
    return path(b"M0 0" + b"h1" * (size // 2))


@family("svg path of arcs")
def _(size):
    return path(b"M0 0" + filled(b"a9 9 0 1 1 1 1", size))


@family("svg path of moves")
def _(size):
    return path(filled(b"M1 1", size) + b"L2 2")


@family("svg path of blanks")
def _(size):
    return path(b"M0 0" + b" ," * (size // 2) + b"#")


@family("svg transforms without an end")
def _(size):
    return svg(b'<path d="M0 0L1 1" transform="' + b"a" * size + b'"/>')


@family("svg transforms that overflow")
def _(size):
    return svg(b'<path d="M0 0L1 1" transform="' + filled(b"scale(1e9)", size) + b'"/>')


@family("svg elements without end")
def _(size):
    return svg(filled(b"<g/>", size) + b"<path d='M0 0L1 1'/>")


@family("svg attributes without end")
def _(size):
    return svg(b"<path " + b" ".join(b'a%d=""' % k for k in range(size // 11)) + b" d='M0 0L1 1'/>")


@family("svg nested deeply")
def _(size):
    count = max(1, size // 7)
    return svg(b"<g>" * count + b"</g>" * count)


@family("svg of entities")
def _(size):
    rows = "".join(f'<!ENTITY a{k} "&a{k - 1};&a{k - 1};">' for k in range(1, 40))
    return f'<!DOCTYPE svg [<!ENTITY a0 "x">{rows}]><svg>&a39;</svg>'.encode()


@family("svg of comments")
def _(size):
    return svg(filled(b"<!-- -->", size) + b"<path d='M0 0L1 1'/>")


@family("svg a huge curve")
def _(size):
    return path(b"M0 0C" + filled(b"1e9 -1e9 -1e9 1e9 1 1 ", size))


@family("svgz lines without end")
def _(size):
    random = random_places(size // 8, 5)
    return gzip.compress(svg(polygon(random)), 1, mtime=0)


@family("svgz a thousand times larger inside")
def _(size):
    spaces = b" " * (1000 * size)
    return gzip.compress(svg(b"<g>" + spaces + b"</g><path d='M0 0L1 1'/>"), 1, mtime=0)


@family("svgz within svgz")
def _(size):
    return gzip.compress(gzip.compress(bytes(size), mtime=0), mtime=0)


@family("svgz cut short")
def _(size):
    return gzip.compress(svg(polygon(random_places(size // 8, 6))), 1, mtime=0)[:-9]
