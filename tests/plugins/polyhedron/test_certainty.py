"""How likely lines are right: what is said, and where it is told."""

from __future__ import annotations

import ast
import functools
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import bozzetto_polyhedron.graph.certainty_numbers as written
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.certainty import certainty_of
from bozzetto_polyhedron.graph.live import LEAST_SURE, LiveGraph, searched, with_certainty
from bozzetto_polyhedron.graph.second_reading import closest_other
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron.fine_parts import FINE, fine_part
from tests.plugins.polyhedron.fit_certainty import (
    SEEDS,
    Fit,
    Lines,
    are_right,
    drawing,
    fitted,
    text_of,
    told,
)
from tests.plugins.polyhedron.fit_confidence import BINS
from tests.plugins.polyhedron.hand import Hand, strokes_of
from tests.plugins.polyhedron.objects import CAMERA, OBJECTS, TO_CANVAS, view
from tests.plugins.polyhedron.test_confidence import ERRORS, FEWEST, TOLERANCE

DRAWINGS = range(310_000, 310_080)


def read(strokes: tuple[Stroke, ...]) -> LiveGraph:
    return decided(searched(strokes), CAMERA, lambda *_: None)


def box_strokes(jitter: float = 0.005) -> tuple[Stroke, ...]:
    seen = view(OBJECTS["box"], 3)
    assert seen is not None
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    return strokes_of(seen.plane * TO_CANVAS, edges, Hand(jitter=jitter), 3)


@functools.cache
def outcomes() -> tuple[tuple[LiveGraph, bool], ...]:
    found = []
    for seed in DRAWINGS:
        drawn = drawing(seed)
        if drawn is not None:
            live = read(drawn[1])
            found.append((live, are_right(live, drawn[0])))
    return tuple(found)


def test_seeds_are_those_of_no_fit() -> None:
    assert not set(DRAWINGS) & set(SEEDS)


def test_every_kind_of_fine_part_is_made() -> None:
    assert all(any(fine_part(name, seed) is not None for seed in range(8)) for name in FINE)


def test_a_plain_box_is_nearly_certain_and_nothing_is_told() -> None:
    graph = read(box_strokes()).graph
    assert graph.certainty > 0.97
    assert graph.health == ()


def test_the_order_of_strokes_and_the_size_of_the_sheet_do_not_matter() -> None:
    strokes = box_strokes()
    larger = tuple(
        Stroke(3.0 * each.x + 40.0, 3.0 * each.y - 7.0, each.camera, pressure=each.pressure)
        for each in strokes
    )
    known = read(strokes).graph.certainty
    assert read(strokes[::-1]).graph.certainty == pytest.approx(known, abs=1e-3)
    assert read(larger).graph.certainty == pytest.approx(known, abs=1e-3)


def test_answers_are_as_much_less_likely_as_lines_are_uncertain() -> None:
    graph = read(box_strokes()).graph
    sure = answers_of(replace(graph, certainty=1.0), CAMERA)
    half = answers_of(replace(graph, certainty=0.5), CAMERA)
    assert np.allclose([each.confidence for each in half], [0.5 * each.confidence for each in sure])


def test_limits_of_traits_hold_and_odds_add_up() -> None:
    low, high, weights = np.array(list(written.TRAITS.values())).T
    assert (low <= high).all()
    middle = 0.5 * (low + high)
    for k in range(len(low)):
        beyond = middle.copy()
        beyond[k] = high[k] + 10.0
        at_limit = middle.copy()
        at_limit[k] = high[k]
        assert certainty_of(beyond) == certainty_of(at_limit)
        rises = certainty_of(at_limit) - certainty_of(middle)
        assert np.sign(rises) == np.sign(weights[k] * (high[k] - middle[k]))


def test_what_is_written_says_what_the_fit_says() -> None:
    rng = np.random.default_rng(4)
    count = len(written.TRAITS)
    every = [Lines(rng.normal(size=count), bool(rng.random() < 0.8)) for _ in range(200)]
    fit = fitted(every)
    odds, traits = (
        ast.literal_eval(each.value)
        for each in ast.parse(text_of(fit)).body
        if isinstance(each, ast.AnnAssign) and each.value is not None
    )
    kept = Fit(odds, np.array(list(traits.values())))
    said = [(told(kept, each), told(fit, each)) for each in every]
    assert np.allclose(*np.array(said).T, atol=2e-3)


def test_a_fit_finds_the_trait_that_tells() -> None:
    rng = np.random.default_rng(5)
    count = len(written.TRAITS)
    traits = rng.normal(size=(600, count))
    right = rng.random(600) < 1.0 / (1.0 + np.exp(-2.0 * traits[:, 3]))
    fit = fitted([Lines(*each) for each in zip(traits, right.tolist(), strict=True)])
    weights = np.abs(fit.traits[:, 2])
    assert weights.argmax() == 3
    assert weights[3] > 4.0 * np.delete(weights, 3).max()


@pytest.mark.long
def test_lines_in_doubt_are_told_where_another_way_to_join_them_differs() -> None:
    found = [live for live, _ in outcomes() if live.graph.certainty < LEAST_SURE]
    assert found
    for live in found:
        assert live.draft is not None
        assert live.graph.health or closest_other(live.draft)[1] is None
        again = with_certainty(live)
        assert again.graph.health == live.graph.health


@pytest.mark.long
def test_most_wrong_lines_are_told_and_few_right_ones() -> None:
    wrong = [bool(live.graph.health) for live, right in outcomes() if not right]
    right = [bool(live.graph.health) for live, right in outcomes() if right]
    assert len(wrong) > 8
    assert np.mean(wrong) >= 0.8
    assert np.mean(right) <= 0.25


@pytest.mark.long
def test_certainty_is_how_often_lines_are_right() -> None:
    said = np.array([live.graph.certainty for live, _ in outcomes()])
    right = np.array([each for _, each in outcomes()])
    for low, high in pairwise(BINS):
        here = (said >= low) & (said < high)
        if here.sum() >= FEWEST:
            error = float(np.sqrt((said[here] * (1.0 - said[here])).sum())) / here.sum()
            off = abs(float(said[here].mean() - right[here].mean()))
            assert off < TOLERANCE + ERRORS * error, (low, high, here.sum())
