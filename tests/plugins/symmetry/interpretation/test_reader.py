"""What drawings are taken for, and where that puts them in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.view import Camera
from bozzetto_symmetry.ink.sides import sides_of
from bozzetto_symmetry.interpretation.candidate import Read
from bozzetto_symmetry.interpretation.side_reading import read
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry.scenes import (
    ACROSS,
    DIAGONAL,
    FLAT,
    LOOPS,
    PAIRS,
    RINGS,
    camera,
    distances,
    drawn,
)

Array = NDArray[np.float64]

BOX = np.array([[-100.0, -50.0, -50.0], [100.0, 50.0, 50.0]])
VIEWS = [(10, 15), (20, 5), (30, 20), (45, 35), (60, 30), (75, 10), (85, 10), (-30, 25)]


def readings(inks: Sequence[Array], view: Camera, asked: str = "auto") -> tuple[Read, ...]:
    strokes = [Stroke(ink[:, 0], ink[:, 1], view) for ink in inks]
    return read(Stereo(view), sides_of(strokes, apart=asked == "pair"), asked, box=BOX)


def ring(ink: Array) -> Array:
    return np.vstack((ink, ink[:1]))


def error(found: Read, curve: Array, *, closed: bool = False) -> float:
    """Median distance from the true curve, % of the diagonal; either side counts."""
    off = [distances(found.points * side, curve, closed=closed) for side in (1.0, MIRROR)]
    return 100.0 * min(float(np.median(one)) for one in off) / DIAGONAL


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "gate"), [(0.0, 0.98), (1.0, 0.95)])
def test_drawings_are_read_as_they_were_meant_in_many_views(noise: float, gate: float) -> None:
    assert np.mean(right_readings(VIEWS, noise)) >= gate


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_drawings_are_read_as_they_were_meant(noise: float) -> None:
    assert all(right_readings([(30, 20)], noise))


def right_readings(views: Sequence[tuple[float, float]], noise: float) -> list[bool]:
    random = np.random.default_rng(11)
    right: list[bool] = []
    for view in views:
        seen = camera(*view)
        for curve in PAIRS.values():
            sense = int(random.choice((1, -1)))
            inks = [
                drawn(curve, seen, noise=noise, random=random),
                drawn(curve * MIRROR, seen, noise=noise, random=random, sense=sense),
            ]
            right.append(readings(inks, seen)[0].reading == "pair")
        for curve in LOOPS.values():
            inks = [
                ring(drawn(side, seen, noise=noise, random=random, closed=True))
                for side in (curve, curve * MIRROR)
            ]
            right.append(readings(inks, seen)[0].reading == "pair")
        for curve in ACROSS.values():
            ink = drawn(curve, seen, noise=noise, random=random)
            right.append(readings([ink], seen)[0].reading == "self")
        for curve in RINGS.values():
            ink = ring(drawn(curve, seen, noise=noise, random=random, closed=True))
            right.append(readings([ink], seen)[0].reading == "self")
        for curve in FLAT.values():
            ink = drawn(curve, seen, noise=noise, random=random)
            right.append(readings([ink], seen)[0].reading == "plane")
    return right


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("sense", [1, -1])
def test_pairs_without_noise_are_where_they_were(
    name: str, kind: Literal["perspective", "orthographic"], sense: int
) -> None:
    seen = camera(30, 20, kind)
    curve = PAIRS[name]
    found = readings([drawn(curve, seen), drawn(curve * MIRROR, seen, sense=sense)], seen)[0]
    assert found.reading == "pair"
    assert error(found, curve) < 0.05
    assert found.coverage > 0.97
    assert not found.warnings
    # They run along the first side as it was drawn.
    assert np.linalg.norm(found.points[0] - curve[0]) < np.linalg.norm(found.points[-1] - curve[0])


@pytest.mark.parametrize("name", ACROSS)
@pytest.mark.parametrize("sense", [1, -1])
def test_curves_across_are_symmetric_about_the_crossing(name: str, sense: int) -> None:
    seen = camera(30, 20)
    curve = ACROSS[name]
    found = readings([drawn(curve, seen, sense=sense)], seen)[0]
    assert found.reading == "self"
    middle = len(found.points) // 2
    assert len(found.points) % 2 == 1
    assert found.points[middle, 1] == 0.0
    np.testing.assert_array_equal(found.points, found.points[::-1] * MIRROR)
    flip = np.diag(MIRROR)
    np.testing.assert_allclose(found.covariances, flip @ found.covariances[::-1] @ flip)
    assert error(found, curve) < 0.05
    # They run as the stroke was drawn, and `near` is the ink of what comes first.
    begin = curve[::sense][0]
    assert np.linalg.norm(found.points[0] - begin) < np.linalg.norm(found.points[-1] - begin)
    image = Stereo(seen).project(found.points[:1])[0]
    assert np.linalg.norm(found.near[0][-1] - image) < 5.0
    np.testing.assert_allclose(found.near[0][0], found.far[0][0])


@pytest.mark.parametrize("name", RINGS)
@pytest.mark.parametrize("sense", [1, -1])
def test_rings_cross_twice(name: str, sense: int) -> None:
    seen = camera(30, 20)
    found = readings([ring(drawn(RINGS[name], seen))[::sense]], seen)[0]
    assert found.reading == "self"
    assert found.ring
    assert found.closed
    assert len(found.crossings) == 2
    half = len(found.points) // 2
    assert (found.points[[0, half], 1] == 0.0).all()
    np.testing.assert_array_equal(found.points[1:half], found.points[:half:-1] * MIRROR)
    assert error(found, RINGS[name], closed=True) < 0.1


@pytest.mark.parametrize("name", ACROSS)
def test_halves_that_meet_on_the_plane_are_one_curve(name: str) -> None:
    seen = camera(30, 20)
    whole = drawn(ACROSS[name], seen)
    found = readings([whole[:300][::-1], whole[299:]], seen)[0]
    assert found.reading == "self"
    assert error(found, ACROSS[name]) < 0.05


@pytest.mark.parametrize("name", list(FLAT))
def test_what_would_be_in_the_box_in_the_plane_is_in_the_plane(name: str) -> None:
    seen = camera(60, 20)
    found = readings([drawn(FLAT[name], seen)], seen)
    assert [one.reading for one in found[:2]] == ["plane", "half"]
    assert found[1].cost < 1.5 * found[0].cost
    assert (found[0].points[:, 1] == 0.0).all()
    assert error(found[0], FLAT[name]) < 0.02


def test_what_would_leave_the_box_in_the_plane_waits() -> None:
    seen = camera(30, 20)
    found = readings([drawn(PAIRS["roof rail"], seen)], seen)
    assert found[0].reading == "half"
    outside = drawn(FLAT["roof line"] + (60.0, 0.0, 0.0), seen)
    assert readings([outside], seen)[0].reading == "half"
    assert readings([outside], seen, "plane")[0].reading == "plane"


def test_what_has_no_partner_is_left_out_and_told() -> None:
    seen = camera(30, 20)
    curve = PAIRS["S-wave"]
    found = readings([drawn(curve, seen), drawn(curve[:240] * MIRROR, seen)], seen)[0]
    assert found.reading == "pair"
    assert len(found.warnings) == 1
    assert found.warnings[0].startswith("The last ")
    assert found.warnings[0].endswith(" % of the first side has no counterpart: they wait for it.")
    assert found.points[:, 0].max() < curve[:, 0].max() - 15.0
    assert error(found, curve) < 0.1


def test_the_other_sense_is_handed_on() -> None:
    seen = camera(30, 20)
    curve = PAIRS["hook"]
    found = readings([drawn(curve, seen), drawn(curve * MIRROR, seen)], seen, "pair")
    assert {one.reading for one in found} == {"pair"}
    costs = [one.cost for one in found]
    assert costs == sorted(costs)


def test_no_reading_is_handed_on_twice() -> None:
    seen = camera(30, 20)
    for curve in ACROSS.values():
        found = [one for one in readings([drawn(curve, seen)], seen) if one.reading == "self"]
        for number, one in enumerate(found):
            assert one.crossings.shape == (1, 2)
            for better in found[:number]:
                assert error(one, better.points) > 0.5


def test_what_is_asked_is_given_or_refused_in_words() -> None:
    seen = camera(30, 20)
    rail = drawn(PAIRS["roof rail"], seen)
    mirrored = drawn(PAIRS["roof rail"] * MIRROR, seen)
    with pytest.raises(UserError, match="only one side"):
        readings([rail], seen, "pair")
    with pytest.raises(UserError, match="do not meet"):
        readings([rail, mirrored], seen, "self")
    with pytest.raises(UserError, match="nowhere crosses"):
        readings([np.column_stack((np.linspace(400, 700, 50), np.linspace(300, 600, 50)))],
                 seen, "self")  # fmt: skip
    with pytest.raises(UserError, match="edge-on"):
        readings([rail], camera(0, 0, "orthographic"), "plane")
    with pytest.raises(UserError, match="no ink"):
        read(Stereo(seen), ())
    for asked in ("half", "plane"):
        assert {one.reading for one in readings([rail], seen, asked)} == {asked}


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        arrays(
            np.float32,
            st.tuples(st.integers(2, 8), st.just(2)),
            elements=st.floats(-500, 1500, width=32),
        ),
        min_size=1,
        max_size=3,
    ),
    st.sampled_from([(0, 0), (0, 20), (30, 20), (90, 0), (45, 90)]),
    st.sampled_from(["perspective", "orthographic"]),
    st.sampled_from(["auto", "pair", "self", "plane", "half"]),
)
def test_any_ink_in_any_view_is_read_or_refused(
    inks: list[Array],
    view: tuple[float, float],
    kind: Literal["perspective", "orthographic"],
    asked: str,
) -> None:
    try:
        found = readings(inks, camera(*view, kind), asked)
    except UserError:
        return
    assert found
    for one in found:
        assert np.isfinite(one.cost)
        assert np.isfinite(one.points).all()
        assert np.isfinite(one.covariances).all()
        assert len(one.points) == len(one.covariances)
        assert asked in ("auto", one.reading)


@pytest.mark.parametrize(
    ("view", "words"),
    [
        (camera(0, 20), "The view lies in the centre plane"),
        (camera(0, 20, "orthographic"), "The view lies in the centre plane"),
        (camera(90, 0, "orthographic"), "left and right are in one place"),
    ],
)
def test_a_view_without_depth_is_named(view: Camera, words: str) -> None:
    curve = PAIRS["S-wave"]
    inks = [drawn(curve, view), drawn(curve * MIRROR, view) + np.array((0.0, 40.0))]
    found = readings(inks, view)
    assert found[0].reading == "half"
    assert any(words in warning for warning in found[0].warnings)
