"""How much of a drawing on paper becomes ink.

    python -m tests.core.ink.trace.figures_paper [--first 9000] [--solids 60]

Outlines and line drawings are drawn on paper in pencil and photographed (`pencil_paper`), with
seeds that nothing was tuned on, and traced. What was drawn is known to the pixel.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.ink.curves.resample import resample
from bozzetto.ink.trace.photographed_page import homography
from bozzetto.ink.trace.trace import Sheet, TracedLine, sheet_of, trace
from bozzetto.view import Camera
from tests.core.ink.trace.distances import hausdorff
from tests.core.ink.trace.pencil_paper import (
    FAINT,
    PHONE,
    SCAN,
    TABLE,
    Conditions,
    paper_picture,
)
from tests.fidelity import FOLDERS, rings_of
from tests.plugins.polyhedron.graph_truth import graph_of, is_right
from tests.plugins.polyhedron.hand import CLEAN, SIZE, owned_strokes_of
from tests.plugins.polyhedron.objects import made, view

Points = NDArray[np.float64]

PAGE = (1600, 1200)
"""Pixels of a page."""

FILLED = 0.8
"""Share of the page that a drawing takes."""

NEAR = 0.01
"""Greatest distance of what was traced from what was drawn, in diagonals of the drawing."""

ALONG = np.cos(np.deg2rad(20.0))
"""Cosine of the largest angle between the two."""

FOLLOWED = 0.9
"""Share of an edge that must be followed."""

CONDITIONS = {"scanner": SCAN, "telephone": PHONE, "faint pencil": FAINT, "page on a table": TABLE}


@dataclass(frozen=True)
class OutlineFound:
    """What became of one drawing of an outline."""

    name: str
    whole: bool
    hausdorff: float
    seconds: float
    megapixels: float


def outlines() -> dict[str, list[Points]]:
    """Closed rings of all outlines there are, by name; y down."""
    found: dict[str, list[Points]] = {}
    for folder in FOLDERS:
        for path in sorted(folder.glob("*.svg")):
            rings = [ring * (1.0, -1.0) for ring in rings_of(path)]
            found.setdefault(path.stem, [np.vstack((ring, ring[:1])) for ring in rings])
    return found


def placed(lines: Sequence[Points]) -> list[Points]:
    """Lay a drawing in the middle of a page."""
    every = np.vstack(lines)
    low, high = every.min(0), every.max(0)
    scale = FILLED * float((np.array(PAGE) / (high - low)).min())
    return [scale * (line - 0.5 * (low + high)) + 0.5 * np.array(PAGE) for line in lines]


def diagonal(lines: Sequence[Points]) -> float:
    return float(np.linalg.norm(np.ptp(np.vstack(lines), axis=0)))


def on_page(sheet: Sheet, corners: Points) -> Callable[[Points], Points]:
    """Return the way from places on the traced sheet to places on the page that was drawn on."""
    back = np.eye(3)
    if sheet.corners is not None:
        width, height = sheet.size
        back = homography(
            np.array([(0, 0), (width, 0), (width, height), (0, height)]), sheet.corners
        )
    whole = np.array([(0, 0), (PAGE[0], 0), PAGE, (0, PAGE[1])], float)
    matrix = homography(np.asarray(corners), whole) @ back

    def moved(points: Points) -> Points:
        image = np.column_stack((points, np.ones(len(points)))) @ matrix.T
        return np.asarray(image[:, :2] / image[:, 2:])

    return moved


def traced(
    lines: Sequence[Points],
    conditions: Conditions,
    seed: int,
    pressures: Sequence[Points] | None = None,
) -> tuple[list[Points], tuple[TracedLine, ...], float, float]:
    """Draw, photograph and trace; lines on the page, seconds and megapixels."""
    pixels, corners = paper_picture(lines, PAGE, conditions, seed, pressures)
    begun = time.process_time()
    try:
        sheet = sheet_of(pixels)
        found = trace(sheet)
    except UserError:
        return [], (), time.process_time() - begun, pixels.shape[0] * pixels.shape[1] / 1e6
    seconds = time.process_time() - begun
    moved = on_page(sheet, corners)
    return (
        [moved(line.points) for line in found],
        found,
        seconds,
        pixels.shape[0] * pixels.shape[1] / 1e6,
    )


def outline_found(
    name: str, rings: Sequence[Points], conditions: Conditions, seed: int
) -> OutlineFound:
    """Whether each ring came back as one closed line, and nothing besides."""
    lines = placed(rings)
    found, raw, seconds, megapixels = traced(lines, conditions, seed)
    size = diagonal(lines)
    closed = [line for line, one in zip(found, raw, strict=True) if one.is_closed]
    worst = 0.0
    for ring in lines:
        apart = [hausdorff(ring, line) for line in closed]
        worst = max(worst, min(apart, default=np.inf) / size)
    return OutlineFound(
        name, len(found) == len(lines) == len(closed) and worst <= NEAR, worst, seconds, megapixels
    )


# -- line drawings ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class EdgesFound:
    """What became of one line drawing of a solid."""

    edges: int
    found: int
    dashed: int
    dashed_found: int
    stray: float
    drawn_right: bool
    traced_right: bool


def directions(lines: Sequence[Points]) -> tuple[Points, Points]:
    """Dense samples of lines, and their directions."""
    places, along = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for line in lines:
        dense = resample(line, spacing=2.0)
        if len(dense) < 2:
            continue
        # Over some samples: the direction of a line and not of its grain.
        step = min(6, len(dense) - 1)
        ahead = np.minimum(np.arange(len(dense)) + step, len(dense) - 1)
        behind = np.maximum(np.arange(len(dense)) - step, 0)
        span = dense[ahead] - dense[behind]
        places.append(dense)
        along.append(span / np.maximum(np.linalg.norm(span, axis=1, keepdims=True), 1e-9))
    return np.vstack(places), np.vstack(along)


def edges_found(seed: int, conditions: Conditions) -> EdgesFound | None:
    """Draw a solid in one view, hidden edges lightly in dashes, and look for its edges."""
    solid = made(seed)
    seen = view(solid, seed)
    if seen is None:
        return None
    upright = seen.plane * (1.0, -1.0)
    edges = [(int(a), int(b)) for a, b in solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    strokes, owners = owned_strokes_of(upright, edges, CLEAN, seed, hidden)
    paths = [stroke.points for stroke in strokes]
    lines = placed(paths)
    size = diagonal(lines)
    found, raw, _, _ = traced(lines, conditions, seed, [np.asarray(s.pressure) for s in strokes])
    places, along = directions(found)
    tree = cKDTree(places) if len(places) else None
    followed = {number: [0, 0] for number in range(len(edges))}
    for number, line in enumerate(lines):
        at, way = directions([line])
        near = [[] for _ in at] if tree is None else tree.query_ball_point(at, NEAR * size)
        for sample, numbers in enumerate(near):
            have = any(abs(float(along[k] @ way[sample])) >= ALONG for k in numbers)
            followed[owners[number]][0] += have
        followed[owners[number]][1] += len(at)
    good = [have >= FOLLOWED * all_of for have, all_of in followed.values()]
    drawn = cKDTree(np.vstack([resample(line, spacing=2.0) for line in lines]))
    stray = float((drawn.query(places)[0] > NEAR * size).mean()) if len(places) else 1.0
    corners = upright * SIZE + 200.0
    return EdgesFound(
        len(edges), sum(good), len(hidden), sum(good[k] for k in hidden), stray,
        is_right(graph_of(strokes), corners, edges),
        _reads_right(found, raw, lines, paths, corners, edges),
    )  # fmt: skip


def _reads_right(
    found: Sequence[Points],
    raw: Sequence[TracedLine],
    lines: Sequence[Points],
    paths: Sequence[Points],
    corners: Points,
    edges: Sequence[tuple[int, int]],
) -> bool:
    """Whether the polyhedron modeler reads the traced ink as the solid's edges."""
    scale = diagonal(paths) / diagonal(lines)
    shift = paths[0][0] - scale * lines[0][0]
    ink = tuple(
        Stroke(*(scale * line + shift).T, Camera(), pressure=one.pressure)
        for line, one in zip(found, raw, strict=True)
    )
    try:
        return bool(ink) and is_right(graph_of(ink), corners, edges)
    except UserError:
        return False


def percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--first", type=int, default=9_000)
    parser.add_argument("--solids", type=int, default=60)
    parser.add_argument("--conditions", nargs="*", default=list(CONDITIONS))
    parser.add_argument("--verbose", action="store_true")
    asked = parser.parse_args()
    every = outlines()
    print("| Picture | outlines | whole | Hausdorff, median | worst | s per megapixel |")
    print("|---|---|---|---|---|---|")
    for word in asked.conditions:
        found = [
            outline_found(name, rings, CONDITIONS[word], asked.first + number)
            for number, (name, rings) in enumerate(every.items())
        ]
        far = [one.hausdorff for one in found if one.whole]
        pace = np.median([one.seconds / one.megapixels for one in found])
        whole = np.mean([one.whole for one in found])
        print(
            f"| {word} | {len(found)} | {percent(float(whole))} | {percent(float(np.median(far)))} "
            f"| {percent(max(far))} | {pace:.2f} |",
            flush=True,
        )
        if asked.verbose:
            print([(one.name, round(one.hausdorff, 4)) for one in found if not one.whole])
    print()
    print(
        "| Picture | drawings | edges | followed | dashed | stray ink | read as drawn | as traced |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for word in asked.conditions:
        seeds = range(asked.first, asked.first + asked.solids)
        solids = [e for seed in seeds if (e := edges_found(seed, CONDITIONS[word])) is not None]
        total, dashed = sum(e.edges for e in solids), sum(e.dashed for e in solids)
        print(
            f"| {word} | {len(solids)} | {total} "
            f"| {percent(sum(e.found for e in solids) / total)} "
            f"| {percent(sum(e.dashed_found for e in solids) / max(1, dashed))} "
            f"| {percent(float(np.mean([e.stray for e in solids])))} "
            f"| {percent(float(np.mean([e.drawn_right for e in solids])))} "
            f"| {percent(float(np.mean([e.traced_right for e in solids])))} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
