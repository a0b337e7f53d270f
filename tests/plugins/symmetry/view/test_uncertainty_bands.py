"""The heat band: nothing lost, nothing twice, hot pieces in dashes, colours that people tell."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bozzetto.scene import DARK, LIGHT, Lines, Palette
from bozzetto.scene.palette import Color
from bozzetto_symmetry.view.uncertainty_bands import COLORS, DASHES, heat_bands
from tests.plugins.symmetry.scenes import DIAGONAL, PAIRS

Array = NDArray[np.float64]

COOL, WARM, HOT = 0.001 * DIAGONAL, 0.015 * DIAGONAL, 0.5 * DIAGONAL


def length(points: NDArray[np.floating]) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def drawn(lines: Lines) -> float:
    """How much line there is, mm."""
    return float(sum(length(lines.points[piece]) for piece in lines.pieces()))


def test_a_curve_that_is_well_known_is_one_green_line() -> None:
    curve = PAIRS["S-wave"]
    (band,) = heat_bands([(curve, np.full(300, COOL))], DIAGONAL)
    assert band.color == COLORS[0]
    assert band.points == pytest.approx(curve.astype(np.float32))
    assert len(list(band.pieces())) == 1


def test_stretches_share_their_ends_and_leave_nothing_out() -> None:
    curve = PAIRS["S-wave"]
    sigma = np.full(300, COOL)
    sigma[100:180] = WARM
    green, yellow = heat_bands([(curve, sigma)], DIAGONAL)
    before, after = (green.points[piece] for piece in green.pieces())
    assert (before[-1] == yellow.points[0]).all()
    assert (yellow.points[-1] == after[0]).all()
    assert len(yellow.points) == 82
    assert drawn(green) + drawn(yellow) == pytest.approx(length(curve), rel=1e-5)


def test_a_hot_curve_is_dashes_on_the_curve() -> None:
    curve = PAIRS["roof rail"]
    (band,) = heat_bands([(curve, np.full(300, HOT))], DIAGONAL)
    pieces = [band.points[piece].astype(float) for piece in band.pieces()]
    assert band.color == COLORS[2]
    assert len(pieces) == DASHES
    assert pieces[0][0] == pytest.approx(curve[0], abs=1e-4)
    assert pieces[-1][-1] == pytest.approx(curve[-1], abs=1e-4)
    dash = length(curve) / (2 * DASHES - 1)
    assert [length(piece) for piece in pieces] == pytest.approx([dash] * DASHES, rel=1e-3)
    gaps = [np.linalg.norm(b[0] - a[-1]) for a, b in itertools.pairwise(pieces)]
    assert gaps == pytest.approx([dash] * (DASHES - 1), rel=1e-2)
    ends = curve[:-1], curve[1:]
    for place in np.vstack(pieces):
        along = ((place - ends[0]) * (ends[1] - ends[0])).sum(axis=1)
        along /= ((ends[1] - ends[0]) ** 2).sum(axis=1)
        feet = ends[0] + np.clip(along, 0, 1)[:, None] * (ends[1] - ends[0])
        assert np.linalg.norm(feet - place, axis=1).min() < 1e-4


def test_a_piece_is_as_hot_as_its_hotter_end() -> None:
    points = np.column_stack((np.arange(5.0), np.zeros((5, 2))))
    green, yellow = heat_bands([(points, np.array([COOL, COOL, WARM, COOL, COOL]))], DIAGONAL)
    assert yellow.points[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert [green.points[p][:, 0].tolist() for p in green.pieces()] == [[0.0, 1.0], [3.0, 4.0]]


def test_several_curves_become_one_item_of_each_heat() -> None:
    curves = [(curve, np.linspace(COOL, HOT, 300)) for curve in PAIRS.values()]
    bands = heat_bands(curves, DIAGONAL)
    assert [band.color for band in bands] == list(COLORS)
    assert [len(list(band.pieces())) for band in bands[:2]] == [4, 4]
    widths = [float(band.width) for band in bands if isinstance(band.width, float)]
    assert widths == sorted(set(widths))


def test_what_is_not_known_leaves_a_gap_or_is_hot() -> None:
    points = np.column_stack((np.arange(7.0), np.zeros((7, 2))))
    points[3] = np.nan
    (green,) = heat_bands([(points, np.full(7, COOL))], DIAGONAL)
    assert [green.points[p][:, 0].tolist() for p in green.pieces()] == [[0, 1, 2], [4, 5, 6]]
    (red,) = heat_bands([(points[:3], np.full(3, np.nan))], DIAGONAL)
    assert red.color == COLORS[2]


@pytest.mark.parametrize("count", [0, 1])
def test_no_line_is_no_band(count: int) -> None:
    assert heat_bands([(np.zeros((count, 3)), np.zeros(count))], DIAGONAL) == ()
    assert heat_bands([], DIAGONAL) == ()


def test_a_curve_without_length_is_drawn_where_it_is() -> None:
    (red,) = heat_bands([(np.ones((3, 3)), np.full(3, HOT))], DIAGONAL)
    assert (red.points == 1.0).all()


@given(
    st.lists(
        st.tuples(
            st.sampled_from([COOL, WARM, HOT, np.nan, np.inf, 0.0]), st.sampled_from([0.0, 1, 1e3])
        ),
        min_size=2,
        max_size=30,
    )
)
@settings(max_examples=80)
def test_any_heat_covers_what_is_not_hot_and_half_of_what_is(
    samples: list[tuple[float, float]],
) -> None:
    sigma = np.array([s for s, _ in samples])
    points = np.column_stack((np.cumsum([d for _, d in samples]), np.zeros((len(samples), 2))))
    bands = heat_bands([(points, sigma)], DIAGONAL)
    total, covered = length(points), sum(drawn(band) for band in bands)
    assert all(np.isfinite(band.points).all() for band in bands)
    assert 0.49 * total <= covered <= total * (1.0 + 1e-5)


def luminance(color: Color) -> float:
    """Relative luminance (WCAG 2.1)."""
    return float(np.array([0.2126, 0.7152, 0.0722]) @ linear(color))


def linear(color: Color) -> Array:
    part = np.array(color) / 255.0
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_every_heat_stands_out_from_the_paper(palette: Palette) -> None:
    paper = luminance(palette.paper)
    for paint in COLORS:
        color = luminance(palette.color(paint))
        contrast = (max(paper, color) + 0.05) / (min(paper, color) + 0.05)
        assert contrast >= 3.0


DEUTERANOPE = np.array(
    [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]
)
PROTANOPE = np.array(
    [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ]
)
"""How linear RGB looks without one kind of cone (Machado, Oliveira and Fernandes 2009)."""

SRGB = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
"""From linear RGB to XYZ (IEC 61966-2-1)."""


def lab(rgb: Array) -> Array:
    """CIE L*a*b* of linear RGB."""
    xyz = SRGB @ np.clip(rgb, 0, 1) / SRGB.sum(axis=1)
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16.0 / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("palette", [LIGHT, DARK])
@pytest.mark.parametrize("eyes", [np.eye(3), DEUTERANOPE, PROTANOPE], ids=["all", "no M", "no L"])
def test_the_heats_are_told_apart_by_all_eyes(palette: Palette, eyes: Array) -> None:
    seen = [lab(eyes @ linear(palette.color(paint))) for paint in COLORS]
    for one, other in itertools.combinations(seen, 2):
        assert np.linalg.norm(one - other) > 20.0
