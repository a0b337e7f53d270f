"""From two drawn sides to a curve: every step, and all of them at once."""

from __future__ import annotations

import itertools
import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np

from bozzetto.ink import Stroke, Strokes
from bozzetto.ink.curves.resample import resample
from bozzetto.view import Camera
from bozzetto_symmetry.editing.oversketch import oversketch
from bozzetto_symmetry.fitting.bundle_adjustment import Sight, adjust_bundle
from bozzetto_symmetry.ink.sides import sides_of
from bozzetto_symmetry.interpretation.folding import foldings
from bozzetto_symmetry.interpretation.side_pairing import pairings
from bozzetto_symmetry.interpretation.side_reading import read
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.dynamic_time_warping import first_row, next_row, warpings
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import pair_covariances, sigmas
from bozzetto_symmetry.view.live_preview import GrowingCurve
from bozzetto_symmetry.view.view_advice import advice
from tests.benchmarks.timing import Row, in_turn, median_ms, processor_ms
from tests.plugins.symmetry.scenes import ACROSS, LOOPS, PAIRS, RINGS, S, camera, drawn

VIEW = camera(30, 20)
STEREO = Stereo(VIEW)
PLACES = 200
SAMPLES = 160


def rows() -> Iterator[Row]:
    """In the order from the pen to the curve."""
    yield from solving()
    yield from matching()
    yield from growing()
    yield from reading()
    yield from tracing()
    yield from fitting()
    yield from using()


def solving() -> Iterator[Row]:
    """Points and their uncertainty."""
    curve = PAIRS["S-wave"][:PLACES]
    near, far = VIEW.project(curve)[0], VIEW.project(curve * MIRROR)[0]
    tangents = np.gradient(far, axis=0)
    ours, paper = in_turn(
        lambda: STEREO.intersected(near, far), lambda: by_least_squares(near, far), repeats=15
    )
    name = "least squares for each, as in the paper"
    yield row(f"{PLACES} points solved", ours, "", name, paper)
    both = median_ms(
        lambda: (
            STEREO.intersected(near, far),
            sigmas(pair_covariances(STEREO, near, far, tangents)),
        ),
        repeats=15,
    )
    yield row(f"{PLACES} points solved, with their uncertainty", both, "< 5 ms")


def by_least_squares(near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """Bae, Kijima and Kim 2004, equations (6) to (8): one small system for every pair."""
    first, second = STEREO.rays(near), STEREO.rays(far)
    found = []
    for origin, one, start, other in zip(*first, *second, strict=True):
        system = np.column_stack((one, -other * MIRROR))
        ways = np.linalg.lstsq(system, start * MIRROR - origin, rcond=None)[0]
        found.append(origin + ways[0] * one)
    return np.array(found)


def matching() -> Iterator[Row]:
    """Which place of one side belongs to which of the other."""
    curve, loop = PAIRS["S-wave"], LOOPS["wheel"]
    near, far = drawn(curve, VIEW, noise=1.0), drawn(curve * MIRROR, VIEW, noise=1.0, sense=-1)
    one, other = drawn(loop, VIEW), drawn(loop * MIRROR, VIEW)
    across, ring = drawn(ACROSS["wavy bumper"], VIEW, noise=1.0), drawn(RINGS["grille"], VIEW)
    costs = np.random.default_rng(0).random((2, SAMPLES, SAMPLES))
    ours, plain = in_turn(
        lambda: warpings(costs, step=0.1, begin=0.1, end=0.1),
        lambda: [plain_warping(cost) for cost in costs],
        repeats=7,
    )
    name = f"two warpings {SAMPLES} × {SAMPLES}"
    yield row(name, ours, "", "dynamic programming in plain Python", plain)
    works = {
        f"pair at {SAMPLES} samples, both senses": (lambda: pairings(STEREO, near, far), "< 60 ms"),
        "pair of loops": (lambda: pairings(STEREO, one, other, closed=True), ""),
        "fold of one stroke": (lambda: foldings(STEREO, across), ""),
        "fold of a ring": (lambda: foldings(STEREO, ring, closed=True), ""),
    }
    for what, (work, budget) in works.items():
        yield row(what, median_ms(work, repeats=15), budget)


def plain_warping(cost: np.ndarray, step: float = 0.1) -> list[list[float]]:
    """The table of dynamic time warping (Sakoe and Chiba, 1978), cell by cell."""
    values = cost.tolist()
    table = [list(itertools.accumulate(values[0], lambda total, c: total + c + step))]
    for line in values[1:]:
        above, made = table[-1], [table[-1][0] + line[0] + step]
        for j in range(1, len(line)):
            best = min(above[j - 1], above[j] + step, made[-1] + step)
            made.append(best + line[j])
        table.append(made)
    return table


def growing() -> Iterator[Row]:
    """The second side while it is drawn."""
    curve = PAIRS["S-wave"]
    near, far = drawn(curve, VIEW, noise=1.0), drawn(curve * MIRROR, VIEW, noise=1.0, sense=-1)
    costs = np.random.default_rng(0).random((2, SAMPLES, SAMPLES))
    before = first_row(costs[:, 0], 0.0)
    each = median_ms(lambda: next_row(before, costs[:, 1], 0.1), repeats=50)
    yield row("live row, both senses", each, "< 1 ms")
    for gap in (2.0, 20.0):
        ink = resample(far, spacing=gap)

        def grown(ink: np.ndarray = ink) -> None:
            side = GrowingCurve(STEREO, near)
            for count in range(1, len(ink) + 1):
                side.points(ink[:count])

        spent = processor_ms(grown, repeats=5) / len(ink)
        anew = processor_ms(lambda ink=ink: pairings(STEREO, near, ink), repeats=5)
        name = "matching the whole stroke anew"
        yield row(f"live pen event, {gap:g} px apart", spent, "< 1 ms", name, anew)


def reading() -> Iterator[Row]:
    """What strokes are."""
    for name, strokes in drawings().items():
        sides = sides_of(strokes)
        took = median_ms(lambda sides=sides: read(STEREO, sides), repeats=15)
        yield row(f"reading of a {name}", took)


def tracing() -> Iterator[Row]:
    """From the strokes to the curve with its uncertainty, nothing remembered."""
    state = SymmetryState()
    for name, strokes in drawings().items():
        fresh = unknown(strokes)
        took = median_ms(
            lambda fresh=fresh: trace_of(Curve(strokes=Strokes(fresh())), state), repeats=9
        )
        yield row(f"{name}, from ink to curve", took)
    times = []
    for _ in range(9):  # of the last drawing, the pair of three strokes a side
        strokes = fresh()
        trace_of(Curve(strokes=Strokes(strokes[:-1])), state)
        start = time.process_time()
        trace_of(Curve(strokes=Strokes(strokes)), state)
        times.append(1000.0 * (time.process_time() - start))
    yield row("the same pair, its last stroke, processor time", statistics.median(times))


def drawings() -> dict[str, tuple[Stroke, ...]]:
    """Strokes of a hand that shakes by a pixel: a pair, a ring, a pair drawn over and over."""
    side, around = PAIRS["S-wave"], RINGS["grille"]
    closed = np.vstack((around, around[:1]))
    random = np.random.default_rng(3)
    scribbled = [
        stroke(half, random, sense)
        for half in (side, side * MIRROR)
        for sense in (1, -1, 1)
    ]  # fmt: skip
    return {
        "plain pair": (stroke(side, random), stroke(side * MIRROR, random, -1)),
        "ring": (stroke(closed, random),),
        "pair of three strokes a side": tuple(scribbled),
    }


def stroke(curve: np.ndarray, random: np.random.Generator, sense: int = 1) -> Stroke:
    ink = drawn(curve, VIEW, noise=1.0, sense=sense, random=random)
    return Stroke(ink[:, 0], ink[:, 1], VIEW)


def unknown(strokes: tuple[Stroke, ...]) -> Callable[[], list[Stroke]]:
    """Makes strokes that nobody has seen yet: each time they lie a little farther right."""
    times = itertools.count(1)

    def made() -> list[Stroke]:
        aside = 1e-4 * next(times)
        return [Stroke(s.points[:, 0] + aside, s.points[:, 1], s.camera) for s in strokes]

    return made


def fitting() -> Iterator[Row]:
    """One symmetric spline through the ink of two views."""
    side = PAIRS["S-wave"]
    stereos = [Stereo(camera(30, 20)), Stereo(camera(55, 35))]
    sights = [
        Sight(
            stereo,
            (drawn(side, stereo.camera, noise=1.0),),
            (drawn(side * MIRROR, stereo.camera, noise=1.0),),
            1.0,
        )
        for stereo in stereos
    ]
    covariances = np.tile(np.eye(3), (len(side), 1, 1))
    ours, dense = in_turn(
        lambda: adjust_bundle("pair", side, covariances, sights, controls="seven"),
        lambda: dense_fit(side, sights),
        repeats=5,
    )
    name = "scipy.optimize.least_squares, dense"
    yield row("fit of 7 control points to two views", ours, "", name, dense)
    took = median_ms(lambda: adjust_bundle("pair", side, covariances, sights), repeats=7)
    yield row("the same, as many as the ink needs", took)


def dense_fit(start: np.ndarray, sights: list[Sight], count: int = 7) -> np.ndarray:
    """Control points that bring the image nearest to the ink, derivatives by differences."""
    from scipy.interpolate import BSpline, make_lsq_spline
    from scipy.optimize import least_squares
    from scipy.spatial import cKDTree

    knots = np.concatenate((np.zeros(3), np.linspace(0.0, 1.0, count - 2), np.ones(3)))
    begin = make_lsq_spline(np.linspace(0.0, 1.0, len(start)), start, knots, 3).c
    at = np.linspace(0.0, 1.0, 400)

    def gaps(flat: np.ndarray) -> np.ndarray:
        points = BSpline(knots, flat.reshape(-1, 3), 3)(at)
        found = []
        for sight in sights:
            for inks, image in ((sight.near, points), (sight.far, points * MIRROR)):
                tree = cKDTree(sight.stereo.project(image))
                found += [tree.query(ink)[0] / sight.noise for ink in inks]
        return np.concatenate(found)

    return np.asarray(least_squares(gaps, begin.ravel()).x)


def using() -> Iterator[Row]:
    """A stroke drawn over a curve, and advice on the view."""
    state = SymmetryState()
    side = PAIRS["S-wave"]
    strokes = drawings()["plain pair"]
    curve = trace_of(Curve(strokes=Strokes(strokes)), state).curve
    assert curve is not None
    hump = np.sin(np.pi * np.clip((S - 0.3) / 0.4, 0.0, 1.0))[:, None] ** 2
    ink = VIEW.project(side + hump * (0.0, 0.0, 8.0))[0][90:210]
    over = [Stroke(ink[:, 0], ink[:, 1], VIEW)]
    took = median_ms(lambda: oversketch(curve, STEREO, over), repeats=9)
    yield row("a curve modified by one stroke", took, "≤ 60 ms")
    level = Camera(eye=(600.0, 40.0, 200.0))
    took = processor_ms(lambda: advice(level, CentrePlane(), (0.0, 0.0, 0.0), state.diagonal))
    yield row("advice on a view, processor time", took)


def row(
    what: str, measured: float, budget: str = "", alternative: str = "", other: float = float("nan")
) -> Row:
    return Row("symmetry", what, measured, "ms", budget, alternative, other)
