"""Lines and dots with smooth edges, tested against the depth of the surfaces.

A polyline is the union of capsules, one for each segment: so joins and ends are round and
overlaps do not show. Each capsule is walked along its major axis; every step covers a few
pixels across. Whether a step is hidden is decided on the middle of the line, with some
allowance for the surface's slope: a line that lies on a surface is never eaten by it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags, Floats, Index
from bozzetto.scene.renderer.surfaces import Veil
from bozzetto.scene.renderer.view_transform import ViewTransform

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Lines, Points

BIAS = 2.0
"""Depth (in pixel sizes) behind a surface at which a line still counts as lying on it."""

FAINT_WIDTH, FAINT_OPACITY = 0.6, 0.32
"""Width and opacity of hidden parts, as parts of the visible ones."""

DASHED_OPACITY = 0.5
"""Opacity of hidden parts that are dashed."""

DASH, GAP = 5.0, 4.0
"""Lengths along a dashed line, px."""

COVERED, VEILED = 1, 2
"""Flags of what lies behind something opaque and behind something translucent."""

STEPS_AT_ONCE = 500_000
"""Steps along lines worked on in one sweep; bounds the memory used."""

WIDEST = 400.0
"""Widest line, px."""


@dataclass(frozen=True, eq=False)
class Canvas:
    """The picture that marks are drawn on, at one sample per pixel.

    Attributes
    ----------
    pixels : (h · w, 4) float32
        Red, green, blue (0 … 255, already multiplied by opacity), opacity (0 … 1).
    surface : (h, w) float32
        Nearness below which opaque surfaces hide a line at each pixel; −inf for none.
    veil : Veil or None
        What translucent meshes do to the lines behind them; nearness and opacity are
        shaped (h, w).
    sight : ViewTransform
    scale : float
        Device pixels per pixel of width.
    """

    pixels: Floats
    surface: Floats
    veil: Veil | None
    sight: ViewTransform
    scale: float

    def behind(
        self, x: NDArray[np.floating], y: NDArray[np.floating], nearness: Floats
    ) -> tuple[Flags, Flags]:
        """Return which places lie behind an opaque surface, and which behind a translucent one."""
        height, width = self.surface.shape
        pixel = np.clip(y, 0, height - 1).astype(np.intp) * width
        pixel += np.clip(x, 0, width - 1).astype(np.intp)
        covered = nearness < self.surface.ravel()[pixel]
        if self.veil is None:
            return covered, np.zeros(len(pixel), bool)
        return covered, nearness < self.veil.nearness.ravel()[pixel]

    def cover(
        self,
        pixel: Index,
        share: Floats,
        color: NDArray[np.floating],
        opacity: float,
        *,
        veiled: bool = False,
    ) -> None:
        """Blend a colour over pixels, each covered in part; where named twice, most counts.

        Behind a veil, what the colour changes in the picture without the veil is seen
        through it.
        """
        if not len(pixel):
            return
        first = int(pixel.min())
        coverage = np.zeros(int(pixel.max()) + 1 - first, np.float32)
        np.maximum.at(coverage, pixel - first, share)
        touched = np.flatnonzero(coverage > 0)
        alpha = (coverage[touched] * np.float32(opacity))[:, None]
        touched += first
        paint = np.append(np.asarray(color, np.float32), np.float32(1))
        if not veiled or self.veil is None:
            self.pixels[touched] += alpha * (paint - self.pixels[touched])
            return
        behind = self.veil.behind[touched]
        change = alpha * (paint - behind)
        self.veil.behind[touched] = behind + change  # the next line lies over this one
        seen = 1 - self.veil.opacity.ravel()[touched][:, None]
        changed = self.pixels[touched] + seen * change
        self.pixels[touched] = np.clip(changed, 0, np.array((255, 255, 255, 1), np.float32))


def draw_lines(canvas: Canvas, batch: list[Lines], color: NDArray[np.floating]) -> None:
    """Draw polylines of the same style as one union.

    Parameters
    ----------
    canvas : Canvas
        Pixels to draw on, and what may hide lines.
    batch : list of Lines
        Lines of equal opacity that surfaces hide in the same way.
    color : (3,) float
        RGB, 0 … 255.
    """
    begin, end = _segments(batch, canvas)
    begin, end = _cut_to_window(begin, end, canvas)
    if not len(begin):
        return
    hidden, opacity = batch[0].hidden, batch[0].opacity
    steps = _step_counts(begin, end)
    ends = np.cumsum(steps)
    found = []
    first = 0
    while first < len(steps):
        done = int(ends[first - 1]) if first else 0
        last = max(first + 1, int(np.searchsorted(ends, done + STEPS_AT_ONCE, "right")))
        part = slice(first, last)
        found.append(_spread(_walked(begin[part], end[part], steps[part]), canvas, hidden))
        first = last
    pixel, share, flag = (np.concatenate(column) for column in zip(*found, strict=True))
    faint = opacity * (DASHED_OPACITY if hidden == "dashed" else FAINT_OPACITY)
    for covered, veiled in ((COVERED, VEILED), (COVERED, 0), (0, VEILED), (0, 0)):
        part = flag == covered | veiled
        strength = faint if covered else opacity
        canvas.cover(pixel[part], share[part], color, strength, veiled=bool(veiled))


# Columns of a segment's end: x, y (px), nearness, width (px), length along the polyline (px).
X, Y, NEARNESS, WIDTH, ALONG = range(5)


def _segments(batch: list[Lines], canvas: Canvas) -> tuple[Array, Array]:
    """Return both ends of all segments on the sheet, in front of the eye; (n, 5) each."""
    sight = canvas.sight
    points = sight.seen(np.concatenate([item.points for item in batch]))
    widths = [np.broadcast_to(np.float64(item.width), len(item.points)) for item in batch]
    width = np.clip(np.concatenate(widths) * canvas.scale, 0.0, WIDEST)
    first, second = _joined_points(batch)
    a = np.column_stack((points[first], width[first]))
    b = np.column_stack((points[second], width[second]))
    if sight.perspective:
        inside_a, inside_b = a[:, 2] >= sight.near, b[:, 2] >= sight.near
        keep = inside_a | inside_b
        a, b, inside_a, inside_b = a[keep], b[keep], inside_a[keep], inside_b[keep]
        for one, other, inside in ((a, b, inside_a), (b, a, inside_b)):
            cut = np.flatnonzero(~inside)
            t = (sight.near - one[cut, 2]) / (other[cut, 2] - one[cut, 2])
            one[cut] += t[:, None] * (other[cut] - one[cut])
            one[cut, 2] = sight.near
    begin, end = (np.column_stack((sight.placed(s[:, :3]), s[:, 3], s[:, 3])) for s in (a, b))
    length = np.hypot(*(end - begin)[:, :2].T)
    total = np.cumsum(length)
    begin[:, ALONG], end[:, ALONG] = total - length, total
    return begin, end


def _joined_points(batch: list[Lines]) -> tuple[Index, Index]:
    """Return indices of the ends of every segment; a lone point is a segment to itself."""
    pairs = []
    shift = 0
    for item in batch:
        count = len(item.points)
        starts = np.zeros(1, np.intp) if item.starts is None else item.starts.astype(np.intp)
        opens = np.zeros(count + 1, bool)
        opens[starts[starts < count]] = True
        opens[count] = True
        closes = opens[1:]
        begun = np.maximum.accumulate(opens[:count])
        first = np.flatnonzero(begun & (~closes | opens[:count]))
        pairs.append(shift + np.stack((first, first + ~closes[first])))
        shift += count
    first, second = np.concatenate(pairs, 1)
    return first, second


def _cut_to_window(begin: Array, end: Array, canvas: Canvas) -> tuple[Array, Array]:
    """Cut segments to the window and a border as wide as the line (Liang & Barsky, 1984)."""
    span = end - begin
    border = np.maximum(begin[:, WIDTH], end[:, WIDTH]) + 2.0
    enter, leave = np.zeros(len(begin)), np.ones(len(begin))
    for axis, size in ((X, canvas.sight.width), (Y, canvas.sight.height)):
        with np.errstate(divide="ignore", invalid="ignore"):
            one = (-border - begin[:, axis]) / span[:, axis]
            two = (size + border - begin[:, axis]) / span[:, axis]
        # a segment along the border: in or out as a whole
        still = span[:, axis] == 0
        inside = (begin[:, axis] >= -border) & (begin[:, axis] <= size + border)
        one = np.where(still, np.where(inside, -np.inf, np.inf), one)
        two = np.where(still, np.where(inside, np.inf, -np.inf), two)
        enter = np.maximum(enter, np.minimum(one, two))
        leave = np.minimum(leave, np.maximum(one, two))
    keep = enter <= leave
    begin, span, enter, leave = begin[keep], span[keep], enter[keep, None], leave[keep, None]
    return begin + enter * span, begin + leave * span


@dataclass(frozen=True, eq=False)
class _Walk:
    """Steps along segments, one array entry for each.

    On the sheet a step is at `major`, a pixel centre along the segment's major axis, and
    `minor`, where the line's middle is there; `steep` says that the major axis is y. The
    segment runs from (`begin_major`, `begin_minor`) by (`span_major`, `span_minor`).
    """

    steep: Flags
    major: Floats
    minor: Floats
    nearness: Floats
    along: Floats
    width: Floats
    widening: Floats
    begin_major: Floats
    begin_minor: Floats
    span_major: Floats
    span_minor: Floats


def _step_counts(begin: Array, end: Array) -> NDArray[np.int64]:
    """Return the pixels that each segment crosses along its major axis, caps included."""
    low, high = _reach(begin, end)
    return np.asarray(np.floor(high) - np.floor(low) + 1, np.int64)


def _reach(begin: Array, end: Array) -> tuple[Array, Array]:
    """Return the extent of each segment along its major axis, caps included."""
    steep = _steep(begin, end)
    a = np.where(steep, begin[:, Y], begin[:, X])
    b = np.where(steep, end[:, Y], end[:, X])
    cap = 0.5 * np.maximum(begin[:, WIDTH], end[:, WIDTH]) + 0.5
    return np.minimum(a, b) - cap, np.maximum(a, b) + cap


def _steep(begin: Array, end: Array) -> Flags:
    return np.asarray(np.abs(end[:, Y] - begin[:, Y]) > np.abs(end[:, X] - begin[:, X]))


def _walked(begin: Array, end: Array, steps: NDArray[np.int64]) -> _Walk:
    """Return pixel centres along the major axis of every segment, and the line's middle there."""
    low, _ = _reach(begin, end)
    span = end - begin
    steep = _steep(begin, end)
    begin_major = np.where(steep, begin[:, Y], begin[:, X])
    begin_minor = np.where(steep, begin[:, X], begin[:, Y])
    span_major = np.where(steep, span[:, Y], span[:, X])
    span_minor = np.where(steep, span[:, X], span[:, Y])
    slope = np.divide(1.0, span_major, out=np.zeros_like(span_major), where=span_major != 0)

    def each(values: NDArray[np.generic]) -> Floats:
        return np.repeat(values.astype(np.float32), steps)

    first = np.floor(low) - (np.cumsum(steps) - steps) + 0.5
    major = (np.arange(int(steps.sum())) + np.repeat(first, steps)).astype(np.float32)
    base_major, base_minor, rise_minor = each(begin_major), each(begin_minor), each(span_minor)
    t = np.clip((major - base_major) * each(slope), np.float32(0), np.float32(1))
    return _Walk(
        np.repeat(steep, steps),
        major,
        base_minor + t * rise_minor,
        each(begin[:, NEARNESS]) + t * each(span[:, NEARNESS]),
        np.repeat(begin[:, ALONG], steps) + t * each(span[:, ALONG]),
        each(begin[:, WIDTH]),
        each(span[:, WIDTH]),
        base_major,
        base_minor,
        each(span_major),
        rise_minor,
    )


def _spread(walk: _Walk, canvas: Canvas, hidden: str) -> tuple[Index, Floats, NDArray[np.int8]]:
    """Return pixels around each step, how much its capsule covers them, `COVERED` and `VEILED`."""
    x = np.where(walk.steep, walk.minor, walk.major)
    y = np.where(walk.steep, walk.major, walk.minor)
    covered, veiled = canvas.behind(x, y, walk.nearness)
    if hidden == "show":
        covered[:] = veiled[:] = False
    thick = np.where(covered, np.float32(0.5 * FAINT_WIDTH), np.float32(0.5))
    if hidden == "hide":
        thick[covered] = 0.0
    elif hidden == "dashed":
        gap = np.mod(walk.along, (DASH + GAP) * canvas.scale) > DASH * canvas.scale
        thick[covered & gap] = 0.0
    base = walk.width * thick
    wider = walk.widening * thick
    square = walk.span_major * walk.span_major + walk.span_minor * walk.span_minor
    per_length = np.divide(1.0, square, out=np.zeros_like(square), where=square > 0)
    from_major = walk.major - walk.begin_major
    # across the major axis a line is at most √2 thicker than it is wide
    reach = float((np.maximum(base, base + wider).max(initial=0.0) + 0.5) * np.sqrt(2.0))
    first = np.ceil(walk.minor - np.float32(reach + 0.5))
    width, height = canvas.sight.width, canvas.sight.height
    breadth, length = (np.where(walk.steep, a, b) for a, b in ((width, height), (height, width)))
    on_sheet = (thick > 0) & (walk.major > 0) & (walk.major < length)
    flag = covered + np.int8(VEILED) * veiled
    pixels, shares, flags = [], [], []
    for offset in range(int(2.0 * reach) + 1):
        cell = first + np.float32(offset)
        from_minor = cell + np.float32(0.5) - walk.begin_minor
        t = (from_major * walk.span_major + from_minor * walk.span_minor) * per_length
        np.clip(t, 0.0, 1.0, out=t)
        away_major = from_major - t * walk.span_major
        away_minor = from_minor - t * walk.span_minor
        gaps = np.sqrt(away_major * away_major + away_minor * away_minor)
        radius = base + t * wider
        share = np.minimum(radius + np.float32(0.5) - gaps, np.float32(2) * radius)
        hit = np.flatnonzero((share > 0) & on_sheet & (cell >= 0) & (cell < breadth))
        major, minor = walk.major[hit].astype(np.intp), cell[hit].astype(np.intp)
        steep = walk.steep[hit]
        pixels.append(np.where(steep, major, minor) * width + np.where(steep, minor, major))
        shares.append(np.minimum(share[hit], np.float32(1)))
        flags.append(flag[hit])
    return np.concatenate(pixels), np.concatenate(shares), np.concatenate(flags)


def draw_points(canvas: Canvas, item: Points, color: NDArray[np.floating]) -> None:
    """Draw dots, hidden ones in their own way (a dot has no dashes: they count as faint)."""
    sight = canvas.sight
    seen = sight.seen(item.points)
    places = sight.placed(seen[seen[:, 2] >= sight.near])
    covered, veiled = canvas.behind(places[:, 0], places[:, 1], places[:, 2].astype(np.float32))
    if item.hidden == "show":
        covered[:] = veiled[:] = False
    radius = 0.5 * item.size * canvas.scale
    for behind in (True, False):
        chosen = veiled == behind
        if item.hidden in ("faint", "dashed"):
            faint = item.opacity * FAINT_OPACITY
            small = FAINT_WIDTH * radius
            draw_discs(canvas, places[chosen & covered], small, color, faint, veiled=behind)
        shown = places[chosen & ~covered]
        draw_discs(canvas, shown, radius, color, item.opacity, veiled=behind)


def draw_discs(
    canvas: Canvas,
    places: Array,
    radius: float,
    color: NDArray[np.floating],
    opacity: float,
    *,
    veiled: bool = False,
) -> None:
    """Draw discs of one radius (px) around places (n, 2 or more: x, y), as one union."""
    if not len(places):
        return
    width, height = canvas.sight.width, canvas.sight.height
    radius = float(np.clip(radius, 0.0, WIDEST))
    x, y = places[:, 0], places[:, 1]
    near = (np.abs(x - width / 2) < width / 2 + radius + 1) & (
        np.abs(y - height / 2) < height / 2 + radius + 1
    )
    x, y = x[near, None], y[near, None]
    reach = int(np.ceil(radius + 0.5))
    side = np.arange(-reach, reach + 1)
    across, down = (grid.ravel() for grid in np.meshgrid(side, side))
    column, row = np.floor(x) + across, np.floor(y) + down
    gap = np.hypot(column + 0.5 - x, row + 0.5 - y)
    share = np.clip(radius + 0.5 - gap, 0.0, min(1.0, np.pi * radius * radius))
    keep = (share > 0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    pixel = (row[keep] * width + column[keep]).astype(np.intp)
    canvas.cover(pixel, share[keep].astype(np.float32), color, opacity, veiled=veiled)
