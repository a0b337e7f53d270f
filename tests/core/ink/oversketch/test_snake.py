"""The snake: fixed points, locality, pressure, and ink that it has not been made for."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto.ink.curves.resample import arc_length, resample
from bozzetto.ink.curves.smooth import smooth
from bozzetto.ink.oversketch.bending_energy import SOFTNESS, Bending
from bozzetto.ink.oversketch.ordered_feet import ordered_feet
from bozzetto.ink.oversketch.snake import SnakeForces, oversketch_curve

SCRIBBLES = Path(__file__).parents[5] / "shared" / "data" / "ink" / "strokestrip" / "examples"
FINE = np.linspace(0, 1, 2000)


def arch(t, height=80.0):
    return np.column_stack((600 * t, height * np.sin(np.pi * t)))


def ellipse(t, a=300.0, b=150.0):
    return np.column_stack((a * np.cos(2 * np.pi * t), b * np.sin(2 * np.pi * t)))


def pressed(path, pressure=0.5):
    return path, np.full(len(path), pressure)


def away(points, path):
    """Distances from a densely sampled path, by brute search."""
    return cKDTree(resample(path, spacing=0.05)).query(points)[0]


CURVE = arch(np.linspace(0, 1, 120))


def test_no_stroke_changes_nothing():
    made = oversketch_curve(CURVE, [])
    assert (made.points == CURVE).all()
    assert not made.moved.any()


SHAPES = {
    "arch": (CURVE, arch(FINE), False),
    "loop": (
        np.column_stack((300 * (t := np.linspace(0, 1, 200)) + 240 * np.sin(2 * np.pi * t),
                         200 * (1 - np.cos(2 * np.pi * t)))),
        np.column_stack((300 * FINE + 240 * np.sin(2 * np.pi * FINE),
                         200 * (1 - np.cos(2 * np.pi * FINE)))),
        False,
    ),
    "ring": (ellipse(np.linspace(0, 1, 300, endpoint=False)), ellipse(FINE + 0.3), True),
    "line": (np.array([[0.0, 0], [50, 20], [100, 40]]), np.array([[0.0, 0], [100, 40]]), False),
}  # fmt: skip


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("shape", SHAPES)
def test_what_is_drawn_again_stays(shape, sense):
    curve, stroke, closed = SHAPES[shape]
    made = oversketch_curve(curve, [pressed(stroke[::sense])], closed=closed)
    assert np.linalg.norm(made.points - curve, axis=1).max() < 0.05


@pytest.mark.parametrize("strokes", [1, 3])
def test_the_curve_goes_where_it_is_drawn(strokes):
    target = arch(FINE) + np.column_stack((0 * FINE, 40 * np.sin(2 * np.pi * FINE)))
    made = oversketch_curve(CURVE, [pressed(target[::s]) for s in (1, -1, 1)[:strokes]])
    assert away(made.points, target).max() < 0.3
    assert made.moved.sum() > 100


def test_sampling_more_often_changes_nothing():
    target = arch(FINE, 120.0)
    often = oversketch_curve(CURVE, [pressed(target)]).points
    seldom = oversketch_curve(CURVE, [pressed(resample(target, spacing=3.0))]).points
    np.testing.assert_allclose(often, seldom, atol=0.05)


def test_more_nodes_give_the_same_curve():
    bump = FINE[700:1300]
    target = arch(bump) + np.column_stack((0 * bump, 20 * np.sin(np.pi * (bump - 0.35) / 0.3) ** 2))
    coarse = oversketch_curve(arch(np.linspace(0, 1, 150)), [pressed(target)]).points
    fine = oversketch_curve(arch(np.linspace(0, 1, 1100)), [pressed(target)]).points
    assert away(coarse, fine).max() < 0.3


def test_a_part_drawn_anew_leaves_the_rest_alone():
    part = np.linspace(0.35, 0.65, 300)
    target = arch(part) + np.column_stack((0 * part, 25 * np.sin(np.pi * (part - 0.35) / 0.3) ** 2))
    made = oversketch_curve(CURVE, [pressed(target)])
    far = np.abs(CURVE[:, 0] - 300) > 90 + 45
    assert (made.points[far] == CURVE[far]).all()
    assert not made.moved[far].any()
    assert away(made.points[(CURVE[:, 0] > 250) & (CURVE[:, 0] < 350)], target).max() < 0.5


def test_the_firmer_stroke_wins_and_gradually():
    over, under = arch(FINE) - (0, -10), arch(FINE) - (0, 10)
    shares = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
    middle = np.linspace(0.25, 0.75, 60)
    heights = []
    for share in shares:
        made = oversketch_curve(CURVE, [pressed(over, share), pressed(under, 1 - share)]).points
        heights.append(
            np.interp(600 * middle, made[:, 0], made[:, 1]) - 80 * np.sin(np.pi * middle)
        )
    heights = np.median(heights, axis=1)
    assert (np.diff(heights) > 0.5).all()
    np.testing.assert_allclose(heights, -heights[::-1], atol=0.1)
    assert np.abs(heights).max() < 10


def test_without_the_pressure_force_pressure_does_not_count():
    strokes = [pressed(arch(FINE) - (0, -10), 0.9), pressed(arch(FINE) - (0, 10), 0.1)]
    made = oversketch_curve(CURVE, strokes, forces=SnakeForces(pressure=0.0))
    assert np.abs(made.points[30:90] - CURVE[30:90]).max() < 0.2


def test_no_pull_no_change():
    made = oversketch_curve(
        CURVE, [pressed(arch(FINE, 140.0))], forces=SnakeForces(location=0.0, pressure=0.0)
    )
    assert (made.points == CURVE).all()


def test_shaky_strokes_are_averaged():
    random = np.random.default_rng(4)
    target = arch(FINE, 110.0)
    tremor = gaussian_filter1d(random.normal(size=(5, *target.shape)), 60.0, axis=1)
    strokes = list(target + 2.0 * tremor / tremor.std())
    error = [np.sqrt((away(s, target) ** 2).mean()) for s in strokes]
    made = oversketch_curve(CURVE, [pressed(s) for s in strokes])
    assert np.sqrt((away(made.points, target) ** 2).mean()) < 0.8 * np.mean(error)


@pytest.mark.parametrize("turned", [False, True])
def test_a_stroke_that_runs_on_takes_the_end_along(turned):
    path = arch(np.linspace(0.5, 1.25, 600))
    curve = CURVE[::-1] if turned else CURVE
    made = oversketch_curve(curve, [pressed(path)]).points
    made = made[::-1] if turned else made
    assert np.linalg.norm(made[-1] - path[-1]) < 0.5
    assert away(path, made).max() < 1.0
    assert (made[:40] == CURVE[:40]).all()
    gaps = np.linalg.norm(np.diff(made, axis=0), axis=1)
    assert gaps.max() < 4 * gaps.min()


def test_a_stroke_that_stops_short_does_not_shorten():
    made = oversketch_curve(CURVE, [pressed(arch(np.linspace(0.03, 0.97, 900)))])
    assert np.linalg.norm(made.points - CURVE, axis=1).max() < 0.05


def test_a_stroke_across_the_open_mouth_does_not_fold_the_curve():
    u = resample([[0, 0], [0, 250], [120, 250], [120, 0]], count=160)
    mouth = np.column_stack((np.linspace(2, 118, 80), np.linspace(-2, -6, 80)))
    made = oversketch_curve(u, [pressed(mouth)]).points
    assert away([[0, 240], [60, 250], [120, 240]], made).max() < 1.0


def test_a_narrow_u_moves_by_its_own_width():
    u = smooth(resample([[0, 0], [0, 300], [40, 300], [40, 0]], count=220), 6.0)
    target = u - (-40, 0)
    made = oversketch_curve(u, [pressed(target)]).points
    assert np.sqrt((away(target, made) ** 2).mean()) < 1.5
    assert np.linalg.norm(made[[0, -1]] - target[[0, -1]], axis=1).max() < 3.0


@pytest.mark.parametrize("repeat", [False, True])
def test_a_ring_changed_across_its_seam(repeat):
    ring = ellipse(np.linspace(0, 1, 240, endpoint=False))
    ring = np.vstack((ring, ring[:1])) if repeat else ring
    t = np.linspace(-0.1, 0.1, 300)
    target = ellipse(t) * (1 + 0.08 * np.cos(t * np.pi / 0.2)[:, None])
    made = oversketch_curve(ring, [pressed(target)], closed=True)
    assert away(target[60:-60], np.vstack((made.points, made.points[:1]))).max() < 1.5
    assert not made.moved[100:140].any()
    if repeat:
        assert (made.points[0] == made.points[-1]).all()
    grown = oversketch_curve(ring, [pressed(ellipse(2 * FINE, 330, 170))], closed=True)
    assert away(grown.points, ellipse(FINE, 330, 170)).max() < 0.5


BAD = [np.nan, np.inf, -np.inf, 1e300]


@pytest.mark.parametrize("bad", BAD)
def test_broken_numbers_are_refused_with_words(bad):
    broken = CURVE.copy()
    broken[7, 1] = bad
    with pytest.raises(UserError):
        oversketch_curve(broken, [pressed(CURVE)])
    with pytest.raises(UserError):
        oversketch_curve(CURVE, [pressed(broken)])
    with pytest.raises(UserError):
        oversketch_curve(CURVE, [pressed(CURVE, bad)])
    with pytest.raises(UserError):
        SnakeForces(restitution=bad if bad != 1e300 else -1.0)
    with pytest.raises(UserError):
        oversketch_curve(np.zeros((0, 2)), [pressed(CURVE)])


KINDS = st.sampled_from(["grid", "dot", "walk", "spiral", "tiny", "huge"])


def odd_ink(kind, count, random):
    if kind == "grid":
        return 100.0 * random.integers(0, 4, (count, 2))
    if kind == "dot":
        return np.repeat(random.uniform(0, 500, (1, 2)), count, axis=0)
    if kind == "walk":
        steps = random.normal(size=(count, 2)) * random.choice([0, 1e-9, 1, 50], (count, 1))
        return np.cumsum(steps, axis=0)
    if kind == "spiral":
        t = np.linspace(0, random.uniform(0.1, 14), count)
        return np.column_stack((200 * np.cos(t) + 20 * t, 150 * np.sin(t)))
    return random.normal(size=(count, 2)) * (1e-12 if kind == "tiny" else 1e8)


@given(
    st.lists(st.tuples(KINDS, st.sampled_from([1, 2, 3, 30])), min_size=1, max_size=4),
    st.booleans(),
    st.sampled_from(
        [(0.3, 0.4, 0.3), (0, 1, 0), (1e9, 0, 1e-9), (1e-12, 1e3, 0), (1e308, 1e-308, 0)]
    ),
    st.integers(0, 10**6),
)
@settings(max_examples=150, deadline=None)
def test_any_ink_gives_finite_nodes(inks, closed, weights, seed):
    random = np.random.default_rng(seed)
    curve, *strokes = (odd_ink(kind, count, random) for kind, count in inks)
    pressure = [random.choice([0, 0.5, 1], len(s)) for s in strokes]
    made = oversketch_curve(
        curve,
        list(zip(strokes, pressure, strict=True)),
        closed=closed,
        forces=SnakeForces(*weights),
    )
    assert made.points.shape == curve.shape
    assert np.isfinite(made.points).all()
    assert (made.points[~made.moved] == curve[~made.moved]).all()


# -- its parts --------------------------------------------------------------------------------


@pytest.mark.parametrize("ring", [False, True])
def test_the_band_solves_the_dense_equation(ring):
    """Against a dense matrix from finite differences of the energy itself."""
    random = np.random.default_rng(3)
    along = np.cumsum(random.uniform(1, 9, 14)) - 1.0
    length = along[-1] + 4.0 if ring else None
    gain = random.uniform(0.1, 1.0, 14)
    free = np.ones(14, bool)
    free[[5, 9]] = False
    pull = random.normal(size=(14, 2))
    gaps = np.append(np.diff(along), along[0] + length - along[-1] if ring else 0.0)

    def energy(u):
        total, count = 0.0, len(u)
        for k in range(count):
            if not ring and k in (0, count - 1):
                spans = (gaps[0],) if k == 0 else (gaps[-2],)
            else:
                gap = along[k] - along[k - 1] if k else along[0] + (length or 0) - along[-1]
                spans = (
                    gap,
                    (along[k + 1] if k + 1 < count else along[0] + (length or 0)) - along[k],
                )
                slope = (u[(k + 1) % count] - u[k]) / spans[1] - (u[k] - u[k - 1]) / spans[0]
                total += 0.5 * 0.7 * SOFTNESS**4 * slope**2 / (0.5 * sum(spans))
            total += 0.5 * 0.5 * sum(spans) * gain[k] * (u[k] - pull[k, 0]) ** 2
        return total

    made = Bending(along, gain, free, 0.7, length).solve(pull)[:, 0]
    assert (made[~free] == 0).all()
    for k in np.flatnonzero(free):
        step = np.zeros(14)
        step[k] = 1e-3
        slope = (energy(made + step) - energy(made - step)) / 2e-3
        assert abs(slope) < 1e-6 * energy(np.eye(14)[k])


def test_ordered_feet_are_the_best_of_all():
    """Against all monotone assignments of a small case."""
    from itertools import combinations_with_replacement

    random = np.random.default_rng(1)
    for _ in range(5):
        stroke, nodes = random.uniform(0, 9, (4, 2)), random.uniform(0, 9, (5, 2))
        square = ((stroke[:, None] - nodes) ** 2).sum(2)

        def price(feet, square=square):
            total = sum(2.0 * square[row, foot] for row, foot in enumerate(feet))
            for row in range(1, len(feet)):
                total += sum(square[row, k] for k in range(feet[row - 1] + 1, feet[row]))
            return total

        feet = ordered_feet(stroke, 2.0, nodes, np.ones(5)).tolist()
        every = list(combinations_with_replacement(range(5), 4))
        best = min(min(price(f), price(f, square[::-1])) for f in every)
        found = price(feet) if feet[0] <= feet[-1] else price(feet[::-1], square[::-1])
        assert found == pytest.approx(best)


# -- ink of other people ------------------------------------------------------------------------


def clusters(path):
    """Strokes of a .scap file by cluster."""
    found = {}
    for body in re.findall(r"\{(.*?)\}", path.read_text(errors="ignore"), re.DOTALL):
        name = re.search(r"#\d+\s+(-?\d+)", body)
        rows = [line.split()[:2] for line in body.splitlines() if re.match(r"\s*-?\d", line)]
        if name and len(rows) > 1:
            stroke = np.array(rows, float)
            if arc_length(stroke)[-1] > 20:
                found.setdefault(name.group(1), []).append(stroke)
    return [sorted(s, key=lambda k: -arc_length(k)[-1]) for s in found.values() if len(s) > 1]


@pytest.mark.skipif(not SCRIBBLES.exists(), reason="recorded scribbles are not here")
def test_recorded_scribbles_bring_the_curve_to_the_ink():
    """The longest stroke of a cluster is the curve, and the others modify it."""
    files = sorted(SCRIBBLES.rglob("*.scap"))[::12]
    before, after = [], []
    for group in (g for path in files for g in clusters(path)[:8]):
        curve = resample(smooth(group[0], 4.0), count=150)
        ink = np.vstack([resample(s, spacing=3.0) for s in group[1:6]])
        made = oversketch_curve(curve, [pressed(s) for s in group[1:6]]).points
        assert np.isfinite(made).all()
        before.append(np.sqrt((away(ink, curve) ** 2).mean()))
        after.append(np.sqrt((away(ink, made) ** 2).mean()))
    before, after = np.array(before), np.array(after)
    assert len(after) > 30
    assert np.median(after) < 0.5 * np.median(before)
    assert (after > before + 1.0).mean() < 0.03
