"""Known curves drawn on both sides, in every sense and many views; folds; hostile ink."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.ink.curves.resample import resample
from bozzetto_symmetry.interpretation.folding import Folding, foldings
from bozzetto_symmetry.interpretation.side_pairing import pairings
from bozzetto_symmetry.interpretation.stereo_triangulation import triangulate
from bozzetto_symmetry.stereo.correspondence import Pairing
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry.scenes import (
    ACROSS,
    DIAGONAL,
    LOOPS,
    PAIRS,
    RINGS,
    camera,
    distances,
    drawn,
    real_curves,
)

SENSES = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def percent(stereo: Stereo, pairing: Pairing, curve: np.ndarray, *, closed: bool = False):
    """Distances of what a pairing makes from the truth, % of the box's diagonal."""
    points = stereo.intersected(pairing.near, pairing.far)
    return 100.0 * distances(points, curve, closed=closed) / DIAGONAL


def right(made: tuple[Pairing, ...], opposite: bool) -> Pairing:
    """The candidate with the sense in which the sides were drawn."""
    (found,) = [pairing for pairing in made if pairing.reversed == opposite]
    return found


# -- the gates -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("azimuth", [10, 30, 60, 85])
@pytest.mark.parametrize(("elevation", "kind"), [(20, "perspective"), (30, "orthographic")])
def test_without_noise_partners_are_right(name, azimuth, elevation, kind):
    view = camera(azimuth, elevation, kind)
    stereo, curve = Stereo(view), PAIRS[name]
    for one, other in SENSES:
        for trimmed in (0.0, 0.1):
            far = drawn(curve * MIRROR, view, sense=other, trimmed=trimmed)
            made = pairings(stereo, drawn(curve, view, sense=one), far)
            found = right(made, one != other)
            # The best, or as good as the best: then the other one is a key away.
            assert found.score < 1.1 * made[0].score
            error = percent(stereo, found, curve)
            assert np.median(error) < 0.05
            assert np.percentile(error, 95) < 0.3
            assert (error > 1.0).mean() < 0.01
            assert min(found.coverage) > 0.75


def test_the_hook_seen_from_the_front_without_its_end_stays_in_question():
    view = camera(10, 15)
    stereo, curve = Stereo(view), PAIRS["hook"]
    for sense in (1, -1):
        far = drawn((curve * MIRROR)[::-sense], view, trimmed=0.1)
        made = pairings(stereo, drawn(curve, view), far)
        found = right(made, sense > 0)
        assert found.score < 1.15 * made[0].score
        assert np.percentile(percent(stereo, found, curve), 95) < 0.3


@pytest.mark.parametrize("name", PAIRS)
def test_a_pixel_of_noise_costs_little(name):
    view = camera(30, 20)
    stereo, curve = Stereo(view), PAIRS[name]
    medians = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        near = drawn(curve, view, noise=1.0, random=random)
        far = drawn(curve * MIRROR, view, noise=1.0, random=random, sense=-1)
        made = pairings(stereo, near, far)
        found = right(made, True)
        # The hook fits both ways, and only the size of the box can tell which is meant.
        assert found is made[0] or (name == "hook" and found.score < 1.2 * made[0].score)
        medians.append(np.median(percent(stereo, found, curve)))
    assert np.median(medians) < 0.6


@pytest.mark.slow
def test_recorded_ink_as_curves_in_space():
    curves = real_curves(240)
    if not curves:
        pytest.skip("the recorded ink is not on this machine")
    random = np.random.default_rng(11)
    errors, wrong, clear = [], [], []
    for curve in curves:
        view = camera(random.uniform(20, 70), random.uniform(5, 35), pixels=800.0)
        stereo, sense = Stereo(view), int(random.choice([-1, 1]))
        near = drawn(curve, view, noise=1.0, random=random)
        far = drawn(curve * MIRROR, view, noise=1.0, random=random, sense=sense)
        made = pairings(stereo, near, far)
        errors.append(np.median(percent(stereo, made[0], curve)))
        wrong.append(made[0].reversed != (sense < 0))
        clear.append(len(made) < 2 or made[1].score > 1.5 * made[0].score)
    assert np.median(errors) < 0.5
    assert np.percentile(errors, 90) < 1.2
    assert np.mean(wrong) < 0.04
    assert np.mean(np.array(wrong)[clear]) < 0.02
    assert np.mean(clear) > 0.8


# -- laws ----------------------------------------------------------------------------------------


def noisy(name: str, seed: int = 1, azimuth: float = 40.0) -> tuple[Stereo, np.ndarray, np.ndarray]:
    view, random = camera(azimuth, 20), np.random.default_rng(seed)
    curve = PAIRS[name]
    near = drawn(curve, view, noise=1.5, random=random)
    return Stereo(view), near, drawn(curve * MIRROR, view, noise=1.5, random=random)


@pytest.mark.parametrize("name", PAIRS)
def test_partners_share_their_epipolar_line(name):
    stereo, near, far = noisy(name)
    for made in pairings(stereo, near, far):
        for one, other in zip(made.near, made.far, strict=True):
            turns = (stereo.angles(one) - stereo.angles(other)) / (2.0 * np.pi)
            assert abs(turns - np.round(turns))[0] < 1e-10


@pytest.mark.parametrize("name", PAIRS)
def test_places_are_on_the_ink(name):
    stereo, near, far = noisy(name)
    (made, *_) = pairings(stereo, near, far)
    assert distances_to_polyline(made.near, near).max() < 1e-9
    assert np.percentile(distances_to_polyline(made.far, far), 95) < 4.0
    assert (np.diff(made.stations) >= 0).all()
    assert (np.diff(made.far_stations) >= 0).all()
    fine = resample(near, count=20001)
    at = fine[np.rint(made.stations * 20000).astype(int)]
    assert np.linalg.norm(at - made.near, axis=1).max() < 1.5


@pytest.mark.parametrize("name", PAIRS)
def test_drawing_a_side_backwards_changes_nothing_else(name):
    stereo, near, far = noisy(name)
    there, back = pairings(stereo, near, far)[0], pairings(stereo, near, far[::-1])[0]
    assert there.reversed != back.reversed
    assert back.near == pytest.approx(there.near)
    assert back.far == pytest.approx(there.far, abs=1e-6)
    assert back.far_stations == pytest.approx(1.0 - there.far_stations, abs=1e-9)


@pytest.mark.parametrize("name", PAIRS)
def test_the_other_side_first_gives_the_mirrored_curve(name):
    stereo, near, far = noisy(name)
    one, other = pairings(stereo, near, far)[0], pairings(stereo, far, near)[0]
    points = stereo.intersected(one.near, one.far)
    image = stereo.intersected(other.near, other.far) * MIRROR
    assert np.median(distances(image, points)) < 0.002 * DIAGONAL


@pytest.mark.parametrize("azimuth", [150, 179.5, 181, 270, 350])
def test_angles_may_wrap_anywhere(azimuth):
    view = camera(azimuth, 12)
    stereo = Stereo(view)
    for name, curve in PAIRS.items():
        made = pairings(stereo, drawn(curve, view), drawn(curve * MIRROR, view))
        if abs(stereo.slant) > np.radians(5):
            assert np.median(percent(stereo, right(made, False), curve)) < 0.05, name


@pytest.mark.parametrize("missing", [0.1, 0.2, 0.3])
def test_missing_ends_are_told_as_coverage(missing):
    view = camera(35, 25)
    stereo, curve = Stereo(view), PAIRS["S-wave"]
    far = drawn(curve * MIRROR, view, trimmed=missing)
    (made, *_) = pairings(stereo, drawn(curve, view), far)
    # By lengths on the sheet, not by the points of the curve.
    steps = np.linalg.norm(np.diff(drawn(curve, view), axis=0), axis=1)
    rest = steps[round(missing * 300) :].sum() / steps.sum()
    assert made.coverage[0] == pytest.approx(rest, abs=0.04)
    assert made.coverage[1] > 0.95
    assert made.stations[0] == pytest.approx(1.0 - rest, abs=0.04)


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_straight_piece_across_is_bridged(kind):
    # In, straight across parallel to the plane's normal, and on.
    s = np.linspace(0.0, 1.0, 100)[:, None]
    corners = np.array([[-60.0, 10, -30], [0, 12, 20], [0, 42, 20], [70, 45, -10]])
    curve = np.vstack([a + s * (b - a) for a, b in pairwise(corners)])
    view = camera(35, 25, kind)
    stereo = Stereo(view)
    made = right(pairings(stereo, drawn(curve, view), drawn(curve * MIRROR, view)), False)
    assert 0.1 < made.weak.mean() < 0.5
    bridged = stereo.intersected(made.near, made.far)[made.weak]
    assert np.abs(bridged[:, [0, 2]] - (0.0, 20.0)).max() < 0.01 * DIAGONAL
    assert percent(stereo, made, curve).max() < 1.0


# -- loops ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("azimuth", [20, 50, 80])
@pytest.mark.parametrize("sense", [1, -1])
def test_loops_are_matched_wherever_they_were_begun(name, azimuth, sense):
    view = camera(azimuth, 15)
    stereo, curve = Stereo(view), LOOPS[name]
    for shift in (0, 70, 211):
        far = np.roll(drawn(curve * MIRROR, view, sense=sense), shift, axis=0)
        made = pairings(stereo, drawn(curve, view), far, closed=True)
        assert len(made) == 2
        found = right(made, sense < 0)
        assert found.closed
        error = percent(stereo, found, curve, closed=True)
        assert np.median(error) < 0.05
        assert np.percentile(error, 95) < 0.3
        assert (np.diff(found.stations) >= 0).all()
        if name == "wheel":
            # The circle rather than the upright ellipse.
            slender = [triangulate(stereo, each).slender for each in made]
            assert made[int(np.argmin(slender))] is found
    shares = np.diff(found.far_stations) * sense
    assert ((shares > -1e-9) | (shares < -0.5)).all()  # once past the beginning at most


# -- one stroke across the plane -------------------------------------------------------------------


def crossings_apart(folding: Folding, curve: np.ndarray, stereo: Stereo) -> float:
    """Worst distance of a crossing from where the curve crosses, px."""
    true = stereo.project(curve[np.abs(curve[:, 1]) < 1e-9])
    return max(np.linalg.norm(true - place, axis=1).min() for place in folding.crossings)


@pytest.mark.parametrize("name", ACROSS)
@pytest.mark.parametrize("azimuth", [15, 30, 60])
def test_one_stroke_is_folded_where_it_crosses(name, azimuth):
    view = camera(azimuth, 20)
    stereo, curve = Stereo(view), ACROSS[name]
    for trimmed, sense in [(0.0, 1), (0.0, -1), (0.15, 1)]:
        (best, *_) = foldings(stereo, drawn(curve, view, sense=sense, trimmed=trimmed))
        assert crossings_apart(best, curve, stereo) < 2.5
        error = percent(stereo, best.pairing, curve)
        assert np.median(error) < 0.05
        assert np.percentile(error, 95) < 0.5
        assert best.pairing.near[0] == pytest.approx(best.crossings[0], abs=1e-6)
        assert best.pairing.far[0] == pytest.approx(best.crossings[0], abs=0.1)
        # The longer half is the near one: of it a piece may have no partner.
        assert best.pairing.coverage[1] > 0.9


def test_the_half_that_was_drawn_longer_is_the_near_one():
    view = camera(60, 20)
    stereo, curve = Stereo(view), ACROSS["windscreen base"]
    for sense in (1, -1):
        ink = drawn(curve[::sense], view)
        for missing, first in ((ink[150:], False), (ink[:-150], True)):
            (best, *_) = foldings(stereo, missing)
            assert best.first == first
            assert best.pairing.coverage[0] < 0.8
            end = missing[0 if first else -1]
            far_end = missing[-1 if first else 0]
            assert np.linalg.norm(best.pairing.far[-1] - far_end) < 3.0
            assert np.linalg.norm(best.pairing.near[-1] - end) > 20.0


@pytest.mark.parametrize("name", ACROSS)
def test_folds_bear_a_pixel_of_noise(name):
    view = camera(35, 20)
    stereo, curve = Stereo(view), ACROSS[name]
    medians = []
    for seed in range(8):
        random = np.random.default_rng(seed)
        (best, *_) = foldings(stereo, drawn(curve, view, noise=1.0, random=random))
        medians.append(np.median(percent(stereo, best.pairing, curve)))
    assert np.median(medians) < 0.8


@pytest.mark.parametrize("name", RINGS)
@pytest.mark.parametrize("azimuth", [15, 40, 80])
def test_rings_cross_twice(name, azimuth):
    view = camera(azimuth, 25)
    stereo, curve = Stereo(view), RINGS[name]
    for shift in (0, 40, 190):
        ink = np.roll(drawn(curve, view), shift, axis=0)
        (best, *_) = foldings(stereo, ink, closed=True)
        assert best.crossings.shape == (2, 2)
        assert crossings_apart(best, curve, stereo) < 8.0
        error = percent(stereo, best.pairing, curve, closed=True)
        assert np.median(error) < 0.05
        assert np.percentile(error, 95) < 1.0


def test_a_line_that_never_turns_is_not_folded():
    view = camera(30, 20)
    rising = np.linspace([-80.0, 20, -40], [80, 30, 40], 50)
    assert foldings(Stereo(view), drawn(rising, view)) == ()


# -- hostile ink -----------------------------------------------------------------------------------

places = st.tuples(st.floats(-2000, 3000), st.floats(-2000, 3000))
ink = st.lists(places, min_size=1, max_size=12)


@settings(max_examples=30, deadline=None)
@given(ink, ink, st.booleans(), st.sampled_from([(0, 0), (30, 20), (89.9, 0), (90, 0), (45, 90)]),
       st.sampled_from(["perspective", "orthographic"]))  # fmt: skip
def test_any_ink_in_any_view_gives_finite_places(near, far, closed, direction, kind):
    stereo = Stereo(camera(*direction, kind))
    for made in pairings(stereo, near, far, closed=closed):
        check(made)
    for folding in foldings(stereo, near, closed=closed):
        check(folding.pairing)
        assert np.isfinite(folding.crossings).all()


def check(made: Pairing) -> None:
    for values in (made.near, made.far, made.stations, made.far_stations, made.cost, made.score):
        assert np.isfinite(values).all()
    assert len(made.near) == len(made.far) == len(made.stations) == len(made.weak)
    assert (made.stations >= 0).all()
    assert (made.stations <= 1).all()
    assert 0.0 <= min(made.coverage) <= max(made.coverage) <= 1.0


@pytest.mark.parametrize("dot", [[(5.0, 5.0)], [(5.0, 5.0)] * 3])
def test_dots_have_no_partners(dot):
    stereo = Stereo(camera(30, 20))
    line = [(0.0, 0.0), (300.0, 200.0)]
    assert pairings(stereo, dot, line) == ()
    assert pairings(stereo, line, dot) == ()
    assert foldings(stereo, dot) == ()
