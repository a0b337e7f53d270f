"""The curve that grows under the pen."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.ink.curves.resample import resample
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.view.live_preview import REVISED, GrowingCurve
from tests.plugins.symmetry.scenes import DIAGONAL, PAIRS, camera, distances, drawn


def strokes(name: str, sense: int, gap: float) -> tuple[Stereo, np.ndarray, np.ndarray]:
    """The view, the first side, and the second one with a sample every so many pixels."""
    view, random = camera(40, 20), np.random.default_rng(2)
    near = drawn(PAIRS[name], view, noise=0.5, random=random)
    far = drawn(PAIRS[name] * MIRROR, view, noise=0.5, random=random, sense=sense)
    return Stereo(view), near, resample(far, spacing=gap)


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("gap", [1.0, 20.0])
def test_the_curve_grows_true(name, sense, gap):
    stereo, near, far = strokes(name, sense, gap)
    growing, counts, errors = GrowingCurve(stereo, near), [], []
    for drawn_so_far in range(1, len(far) + 1):
        points = growing.points(far[:drawn_so_far])
        counts.append(len(points))
        if drawn_so_far > 0.6 * len(far):
            errors.append(np.median(distances(points, PAIRS[name])) / DIAGONAL)
    assert (np.diff(counts) >= 0).all()
    assert np.median(errors) < 0.01
    final = growing.points(far)
    assert np.median(distances(final, PAIRS[name])) < 0.01 * DIAGONAL
    # As far as it was drawn: both ends of the curve are reached.
    ends = PAIRS[name][[0, -1]][::sense]
    assert np.linalg.norm(final[[0, -1]] - ends, axis=1).max() < 0.08 * DIAGONAL


@pytest.mark.parametrize("name", PAIRS)
def test_how_the_pen_events_come_does_not_matter(name):
    stereo, near, far = strokes(name, 1, 3.0)
    whole, parts = GrowingCurve(stereo, near), GrowingCurve(stereo, near)
    for k in (1, 2, 9, 10, 31, 32, 33, 60, len(far)):
        made = parts.points(far[:k])
    at_once = whole.points(far)
    assert len(at_once) == len(made)
    assert made[-REVISED:] == pytest.approx(at_once[-REVISED:], abs=1e-6)


def test_asking_again_changes_nothing():
    stereo, near, far = strokes("S-wave", -1, 5.0)
    growing = GrowingCurve(stereo, near)
    once = growing.points(far)
    assert (growing.points(far) == once).all()


def test_another_stroke_begins_anew():
    stereo, near, far = strokes("hook", 1, 5.0)
    growing = GrowingCurve(stereo, near)
    growing.points(near[::5])
    growing.points(far[:4])
    assert growing.points(far) == pytest.approx(GrowingCurve(stereo, near).points(far), abs=1e-6)


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("direction", [(0, 0), (90, 0), (90, 90), (45, 20)])
def test_no_ink_and_no_view_gives_anything_but_places(direction, kind):
    stereo = Stereo(camera(*direction, kind))
    random = np.random.default_rng(0)
    line = random.uniform(0, 900, (9, 2))
    for near in (line, line[:1], np.repeat(line[:1], 4, axis=0)):
        growing = GrowingCurve(stereo, near)
        assert growing.points(np.zeros((0, 2))).shape == (0, 3)
        for far in (line[:1], np.repeat(line[:1], 5, axis=0), line[::-1], 1e4 * line[:3]):
            assert np.isfinite(growing.points(far)).all()
