"""Pieces of curves lie on the curves, and together they are the curve."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_symmetry.editing.trim import piece, share_of, trim
from tests.plugins.symmetry.edited_curves import (
    ACROSS,
    ALL,
    FLAT,
    LOOP,
    PAIR,
    RING,
    check,
    farthest,
)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("stretch", [(0.0, 0.4), (0.4, 1.0), (0.25, 0.7)])
def test_a_piece_lies_on_the_curve(name, stretch):
    curve = ALL[name]
    kept = trim(curve, *stretch)
    assert not kept.closed
    assert farthest(kept.spline, curve.spline) < 1e-9
    check(kept)


@pytest.mark.parametrize("curve", [PAIR, FLAT])
def test_pieces_of_an_open_curve_are_as_long_as_the_curve(curve):
    lengths = [trim(curve, *cut).spline.length for cut in ((0, 0.3), (0.3, 0.8), (0.8, 1))]
    assert sum(lengths) == pytest.approx(curve.spline.length, rel=1e-9)


def test_a_curve_across_the_plane_leaves_its_middle_and_a_pair():
    middle, rest = trim(ACROSS, 0.0, 0.6), trim(ACROSS, 0.6, 1.0)
    assert (middle.reading, rest.reading) == ("self", "pair")
    whole = middle.spline.length + 2.0 * rest.spline.length
    assert whole == pytest.approx(ACROSS.spline.length, rel=1e-9)
    meeting = middle.spline.value(middle.spline.range[1:])
    np.testing.assert_allclose(meeting, rest.spline.value(rest.spline.range[:1]), atol=1e-9)


def test_a_ring_is_cut_into_two_curves_across_the_plane():
    first, second = trim(RING, 0.0, 0.3), trim(RING, 0.3, 1.0)
    assert (first.reading, second.reading) == ("self", "self")
    whole = first.spline.length + second.spline.length
    assert whole == pytest.approx(RING.spline.length, rel=1e-9)
    ends = [curve.spline.value(curve.spline.range[1:])[0] for curve in (first, second)]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def test_a_closed_curve_is_opened_and_cut_over_its_seam():
    opened = trim(LOOP, 0.3, 1.3)
    assert not opened.closed
    assert opened.spline.length == pytest.approx(LOOP.spline.length, rel=1e-9)
    np.testing.assert_allclose(*opened.spline.value(opened.spline.range), atol=1e-9)
    over, under = trim(LOOP, 0.8, 1.2), trim(LOOP, 0.2, 0.8)
    both = over.spline.length + under.spline.length
    assert both == pytest.approx(LOOP.spline.length, rel=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_the_whole_stretch_of_what_cannot_be_opened_is_the_curve_itself(name):
    curve = ALL[name]
    kept = trim(curve, 0.0, 1.0)
    assert (kept is curve) == (name != "loop")


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("stretch", [(0.5, 0.5), (0.7, 0.2), (np.nan, 1.0), (0.0, np.nan)])
def test_nothing_is_refused(name, stretch):
    with pytest.raises(UserError, match="Nothing would be left"):
        trim(ALL[name], *stretch)


@pytest.mark.parametrize("name", ALL)
def test_shares_lead_back_to_places(name):
    curve = ALL[name]
    begin, end = curve.spline.range
    at = 0.5 * (begin + end) + 0.31 * (end - begin)
    share = share_of(curve, at)
    kept = trim(curve, 0.0, share)
    ends = kept.spline.value(kept.spline.range)
    place = curve.spline.value([at])
    assert np.linalg.norm(ends * (1, np.sign(place[0, 1]) or 1, 1) - place, axis=1).min() < 40
    assert np.linalg.norm(np.abs(ends) - np.abs(place), axis=1).min() < 1e-9


@pytest.mark.parametrize("off", [1e-14, -1e-14])
def test_a_cut_beside_a_knot_makes_no_sliver(off):
    knot = float(PAIR.spline.knots[6])
    for kept in (piece(PAIR.spline, 0.0, knot + off), piece(PAIR.spline, knot + off, 1.0)):
        assert np.diff(np.unique(kept.knots)).min() > 1e-3
        speed = np.linalg.norm(kept.derivative(kept.range), axis=1)
        place = [u for u in kept.range if 0.0 < u < 1.0]
        expected = np.linalg.norm(PAIR.spline.derivative(place), axis=1)
        assert speed.min() == pytest.approx(expected[0]) or speed.max() == pytest.approx(
            expected[0]
        )
