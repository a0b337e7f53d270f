"""Scribbles of known curves, real clusters, hostile ink."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, merge_strokes, stroke_weights
from bozzetto.view.camera import Camera

CLUSTERS = Path(__file__).parents[4] / "shared/data/ink/strokestrip/examples"
T = np.linspace(0, 1, 600)


def polar(degrees, a, b):
    angle = np.radians(degrees) * T
    return np.column_stack((a * np.cos(angle), b * np.sin(angle)))


def arc_up(x, y, radius):
    return np.column_stack((x + radius * np.sin(np.pi * T), y - radius * np.cos(np.pi * T)))


LINE = np.column_stack((400 * T, 0 * T))
W = 2 * T - 1
SHAPES = {
    "wave": np.column_stack((600 * T, 120 * np.sin(2 * np.pi * T))),
    "C": polar(320, 200, 200),
    "ellipse": polar(360, 300, 140),
    "alpha": np.column_stack((416 * W * (W**2 - 0.45), 260 * (1 - W**2))),
    "hook": np.vstack((LINE, arc_up(400, 90, 90))),
    "U": np.vstack((LINE, arc_up(400, 20, 20), LINE[::-1] + np.array([0, 40]))),
}


def along(curve):
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    length = np.append(0, np.cumsum(steps))
    return length / length[-1]


def scribbled(curve, count, seed, noise=2.0, share=1.0):
    """Strokes over a curve with the slow tremor of a hand, set off, in either direction.

    Those that show a share of the curve start one after another along it, and go on over
    the seam of a closed curve.
    """
    rng = np.random.default_rng(seed)
    closed = np.allclose(curve[0], curve[-1])
    strokes = []
    for number in range(count):
        if share < 1.0:
            start = number / count if closed else number / (count - 1) * (1.0 - share)
            at = np.linspace(start, start + share, 250)
            at = np.mod(at, 1.0) if closed else at
        else:
            at = np.linspace(rng.uniform(0, 0.03), rng.uniform(0.97, 1), 250)
        place = np.column_stack([np.interp(at, along(curve), c) for c in curve.T])
        tremor = gaussian_filter1d(rng.normal(size=place.shape), 20, axis=0, mode="nearest")
        place = place + noise * tremor / tremor.std() + rng.normal(size=2) * noise
        strokes.append(place[:: rng.choice([-1, 1])])
    return strokes


def off(made, curve):
    """Rms distance of the curve from the truth, and largest distance either way."""
    there = cKDTree(curve).query(made.points)[0]
    back = cKDTree(made.points).query(curve)[0]
    return np.sqrt((there**2).mean()), max(there.max(), back.max())


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("share", [1.0, 0.5])
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_scribbles_of_loops_and_hooks_settle_on_the_curve(name, share, seed):
    rms, worst = off(merge_strokes(scribbled(SHAPES[name], 6, seed, share=share)), SHAPES[name])
    assert rms < 5.0
    assert worst < 30.0


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("share", [1.0, 0.5])
def test_nearly_all_scribbles_of_loops_and_hooks_settle_on_the_curve(name, share):
    figures = np.array([
        off(merge_strokes(scribbled(SHAPES[name], 6, seed, share=share)), SHAPES[name])
        for seed in range(100, 120)
    ])  # fmt: skip
    assert ((figures[:, 0] < 5.0) & (figures[:, 1] < 30.0)).mean() >= 0.95


def treble(count):
    """A curl that runs through itself into a long bend: the order tells its laps apart."""
    angle = np.linspace(0, 5 * np.pi, count)
    radius = np.linspace(12, 70, count)
    curl = np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))
    return np.vstack((curl, curl[-1] + np.column_stack((60 * T, -260 * T))))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_laps_of_a_curl_stay_apart(seed):
    curve = treble(600)
    rms, worst = off(merge_strokes(scribbled(curve, 4, seed)), curve)
    assert rms < 4.0
    assert worst < 20.0


def test_ends_that_overlap_are_closed():
    ring = SHAPES["ellipse"]
    made = merge_strokes([ring[:550], np.roll(ring[:-1], -300, axis=0)[:400]])
    assert made.closed
    assert off(made, ring)[1] < 8.0


def test_a_stroke_that_strayed_has_less_say():
    wave = SHAPES["wave"]
    strayed = wave + np.column_stack((0 * T, 40 * np.sin(np.pi * T)))
    made = merge_strokes([wave, wave + np.array([0, 1]), wave - np.array([0, 1]), strayed])
    assert off(made, wave)[0] < 6.0  # the mean is 7.1 off


def test_a_wide_scribble_of_a_large_curve_is_sure_and_of_a_small_one_is_not():
    line = np.column_stack((800 * T, 0 * T))
    pair = [line, line + np.array([0, 12])]
    assert merge_strokes(pair).score > 5.0
    assert merge_strokes(pair).sure
    assert not merge_strokes([stroke * np.array([0.5, 1.0]) for stroke in pair]).sure


def test_a_ring_drawn_over_and_over_is_closed_and_the_open_c_is_not():
    assert merge_strokes(
        [np.roll(SHAPES["ellipse"][:-1], 150 * k, axis=0) for k in range(4)]
    ).closed
    assert not merge_strokes(scribbled(SHAPES["C"], 4, 1)).closed


def test_order_and_direction_of_strokes_do_not_matter():
    strokes = scribbled(SHAPES["wave"], 5, 7)
    one = merge_strokes(strokes)
    other = merge_strokes([stroke[::-1] for stroke in strokes[::-1]])
    gap = cKDTree(one.points).query(other.points)[0]
    assert np.percentile(gap, 95) < 1.0


def test_sampling_more_often_does_not_matter():
    strokes = scribbled(SHAPES["hook"], 4, 3)
    dense = [
        np.column_stack([np.interp(np.linspace(0, 249, 5000), np.arange(250), c) for c in s.T])
        for s in strokes
    ]
    gap = cKDTree(merge_strokes(strokes).points).query(merge_strokes(dense).points)[0]
    assert gap.max() < 1.5


def test_a_pen_that_runs_back_over_its_line_draws_one_line():
    line = np.column_stack((300 * T, 0 * T))
    made = merge_strokes([np.vstack((line, line[::-1] + np.array([0, 1.0]), line))])
    assert made.spline.length == pytest.approx(300, rel=0.03)
    assert np.abs(made.points[:, 1]).max() < 2.0


def test_heavier_strokes_pull_the_curve():
    line = np.column_stack((300 * T, 0 * T))
    middles = [
        merge_strokes([line, line + np.array([0, 10])], [1 - share, share]).points[:, 1].mean()
        for share in (0.1, 0.5, 0.9)
    ]
    assert middles[0] < 3.0
    assert middles[1] == pytest.approx(5.0, abs=1.0)
    assert middles[2] > 7.0
    alone = merge_strokes([line, line + np.array([0, 10])], [0.0, 1.0])
    np.testing.assert_allclose(alone.points[:, 1], 10.0, atol=1e-6)


def test_older_and_fainter_strokes_weigh_less():
    def stroke(pressure):
        return Stroke([0, 1], [0, 1], Camera(), pressure=[pressure, pressure])

    weights = stroke_weights([stroke(0.5)] * 4)
    np.testing.assert_allclose(weights[1:] / weights[:-1], 1 / 0.7)
    faint, firm = stroke_weights([stroke(0.1)])[0], stroke_weights([stroke(0.9)])[0]
    assert faint < firm


def test_ink_that_is_no_curve_is_not_sure():
    rng = np.random.default_rng(3)
    assert not merge_strokes([rng.normal(0, 100, (60, 2)) for _ in range(6)]).sure
    assert merge_strokes(scribbled(SHAPES["wave"], 3, 1, noise=0.5)).sure


def test_another_unit_of_length_gives_the_same_curve():
    strokes = scribbled(SHAPES["C"], 4, 2)
    one, other = merge_strokes(strokes), merge_strokes([0.25 * s for s in strokes], pixel=0.25)
    assert other.score == pytest.approx(0.25 * one.score, rel=1e-3)
    assert other.sure == one.sure


@pytest.mark.parametrize(
    "strokes",
    [
        [],
        [[[1, 1]]],
        [[[1, 1]], [[2, 9]]],
        [np.zeros((0, 2))],
        [[[0, 0], [np.nan, 1]]],
        [[[0, 0], [1e200, 1]]],
        [np.eye(3)],
        ["ink"],
    ],
)
def test_what_is_no_ink_is_refused_in_plain_words(strokes):
    with pytest.raises(UserError):
        merge_strokes(strokes)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e6])
@pytest.mark.parametrize("seed", range(4))
def test_any_ink_gives_a_finite_curve(scale, seed):
    rng = np.random.default_rng(seed)
    strokes = [scale * rng.integers(0, 9, (n, 2)) for n in rng.integers(1, 20, 5)]
    made = merge_strokes([*strokes, [[0, 0], [scale, 0]]])
    assert np.isfinite(made.points).all()
    assert np.isfinite(made.score)


def real_clusters():
    """Clusters of two strokes and more, with the longer side of their sheet."""
    for path in sorted(CLUSTERS.rglob("*.scap")):
        text = path.read_text()
        side = max(float(x) for x in text.split("\n")[0].lstrip("#").split()[:2])
        clusters = {}
        for body in re.findall(r"\{([^}]*)\}", text):
            rows = [row.split() for row in body.strip().splitlines() if row.strip()]
            ink = [[float(x) for x in row[:2]] for row in rows[1:] if row[0][0] not in "@#"]
            if ink:
                clusters.setdefault(rows[0][1], []).append(np.array(ink))
        yield from ((side, strokes) for strokes in clusters.values() if len(strokes) > 1)


def settled_clusters(step):
    """Scores of every so manieth real cluster, and the longer sides of their sheets."""
    if not CLUSTERS.exists():
        pytest.skip("the recorded clusters are not on this machine")
    return np.array([
        (merge_strokes(strokes).score, side)
        for number, (side, strokes) in enumerate(real_clusters())
        if number % step == 0
    ]).T  # fmt: skip


def test_real_clusters_settle():
    scores, _ = settled_clusters(step=60)
    assert np.isfinite(scores).all()
    assert np.median(scores) < 3.0


@pytest.mark.slow
def test_nine_of_ten_real_clusters_score_below_five_pixels():
    scores, sides = settled_clusters(step=3)
    assert (scores > 5.0).mean() <= 0.10
    assert (scores * 500.0 / sides > 5.0).mean() <= 0.05  # on sheets of 500 px
