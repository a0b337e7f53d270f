"""Cameras from marks: how long they take, and how near they come, with SciPy beside."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from bozzetto.view import Camera
from bozzetto.view.calibration import direct_linear_transform, most_helpful, predicted, resect
from tests.benchmarks.timing import Row, processor_ms
from tests.core.view.marked_car import PICTURE, POINTS, Shot, rms, shot, thrown

VIEWS = 100
"""Random views for each figure of accuracy."""

HAND = 3.0
"""Noise of the marks, px per coordinate."""


def marks_of(rng: np.random.Generator, taken: Shot, noise: float = HAND) -> np.ndarray:
    """What a hand marks of a shot."""
    return taken.places[taken.marked] + rng.normal(0.0, noise, (len(taken.marked), 2))


def by_scipy(points: np.ndarray, marks: np.ndarray, start: Camera) -> Callable[[], object]:
    """A robust fit of seven parameters with numerical slopes, from a start that is right."""
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    right, up, forward = start.axes
    frame = np.stack((right, -up, forward))
    focal = 0.5 * PICTURE[1] / np.tan(np.radians(start.fov_y) / 2.0)

    def misses(q: np.ndarray) -> np.ndarray:
        turn = Rotation.from_rotvec(q[:3]).as_matrix() @ frame
        seen = (points - start.eye - 1e3 * q[3:6]) @ turn.T
        places = focal * np.exp(q[6]) * seen[:, :2] / seen[:, 2:] + 0.5 * np.array(PICTURE)
        return np.asarray((places - marks).ravel())

    return lambda: least_squares(misses, np.zeros(7), loss="soft_l1", f_scale=4.0)


def missed(view: str, count: int, noise: float, kind: str = "perspective", moved: float = 0.0):
    """Median over random views of the rms miss of the points that were not marked, px."""
    rng = np.random.default_rng(0)
    found = []
    for _ in range(VIEWS):
        taken = shot(rng, view, count, kind)
        marks = marks_of(rng, taken, noise)
        marks[0] += thrown(rng, moved)
        camera = resect(POINTS[taken.marked], marks, PICTURE)
        hidden = taken.hidden
        found.append(rms(camera.project(POINTS[hidden]) - taken.places[hidden]))
    return float(np.median(found))


def rows() -> Iterator[Row]:
    """Processor times of one view, then misses over many."""
    rng = np.random.default_rng(0)
    for count in (6, 27):
        taken = shot(rng, count=count)
        points, marks = POINTS[taken.marked], marks_of(rng, taken)
        cold = processor_ms(lambda: resect(points, marks, PICTURE), repeats=20)  # noqa: B023
        other = processor_ms(by_scipy(points, marks, taken.camera), repeats=20)
        yield Row(
            "calibration", f"camera of {count} marks, no start", cold, "ms", "< 20 ms",
            "SciPy, one fit from the right start", other,
        )  # fmt: skip
    before = resect(points, marks, PICTURE)
    dragged = marks + np.eye(27, 1) * 2.0
    warm = processor_ms(lambda: resect(points, dragged, PICTURE, before=before), repeats=20)
    yield Row("calibration", "the same, one mark dragged", warm, "ms", "< 5 ms")
    wrong = marks + np.eye(27, 1) * 120.0
    stray = resect(points, wrong, PICTURE)
    warm = processor_ms(lambda: resect(points, wrong + 1.0, PICTURE, before=stray), repeats=20)
    yield Row("calibration", "the same, with a wrong mark", warm, "ms", "< 5 ms")
    ahead = processor_ms(lambda: predicted(before, POINTS).ellipses(), repeats=20)
    yield Row("calibration", "places and ellipses of 39 points", ahead, "ms")
    ahead = processor_ms(lambda: most_helpful(before, POINTS), repeats=20)
    yield Row("calibration", "which of 39 marks helps most", ahead, "ms")
    direct = processor_ms(lambda: direct_linear_transform(points, marks), repeats=20)
    yield Row("calibration", "direct linear transform, 27 marks", direct, "ms")
    for what, figure, budget in (
        ("hidden points, 27 marks at 3 px", missed("three-quarter", 27, HAND), "≤ 3 px"),
        ("hidden points, 8 marks at 3 px", missed("three-quarter", 8, HAND), "≤ 6 px"),
        ("hidden points, side, orthographic", missed("side", 24, 2.0, "orthographic"), "≤ 5 px"),
        ("hidden points, a mark moved by 120 px", missed("three-quarter", 27, HAND, moved=120.0),
         "≤ 3 px"),
    ):  # fmt: skip
        yield Row("calibration", what, figure, "px", budget)
