"""Shares become probabilities."""

from __future__ import annotations

import ast

import numpy as np
import pytest

from bozzetto_polyhedron.reconstruction.confidence_tables import LEADS, LOG_ODDS, TRAITS
from bozzetto_polyhedron.reconstruction.confidence_weights import CORRECTIONS
from bozzetto_polyhedron.reconstruction.ranking import (
    CORRECTED,
    DRAWN,
    FEATURES,
    HANGING,
    LEAST,
    MOST,
    SURE,
    confidence_of_first,
    confidences,
    corrected_traits,
    scores,
    traits_of,
)
from bozzetto_polyhedron.reconstruction.ranking_weights import WEIGHTS
from tests.plugins.polyhedron.fit_confidence import EVIDENCE, KNOTS, text_of
from tests.plugins.polyhedron.fit_confidence import fitted as fitted_confidence
from tests.plugins.polyhedron.fit_corrections import fitted as fitted_corrections
from tests.plugins.polyhedron.fit_corrections import text_of as text_of_corrections
from tests.plugins.polyhedron.fit_corrections import told
from tests.plugins.polyhedron.fit_ranking import Example, fitted
from tests.plugins.polyhedron.kept_outcomes import Outcome

TYPICAL = np.array([0.5 * (low + high) for low, high, _ in TRAITS.values()])
"""Traits in the middle of all."""


@pytest.mark.parametrize("evidence", LOG_ODDS)
def test_a_larger_lead_is_more_certain(evidence) -> None:
    leads = np.linspace(0.0, 8.0, 30)
    first = [confidences(np.array((lead, 0.0, -1.0)), evidence, TYPICAL, lead)[0] for lead in leads]
    assert (np.diff(first) >= 0.0).all()
    assert first[0] < 0.8 < first[-1]


@pytest.mark.parametrize("evidence", LOG_ODDS)
def test_probabilities_fall_and_sum_to_one_at_most(evidence) -> None:
    rng = np.random.default_rng(5)
    for count in (1, 2, 8):
        values = np.sort(rng.normal(0.0, 3.0, count))[::-1]
        found = confidences(values, evidence, TYPICAL, 1.0)
        assert found.shape == (count,)
        assert (np.diff(found) <= 0.0).all()
        assert found.sum() <= 1.0 + 1e-12
    assert len(confidences(np.zeros(0), evidence, TYPICAL, 0.0)) == 0


def test_scores_far_apart_do_not_overflow() -> None:
    assert np.isfinite(confidences(np.array((1e6, 0.0, -1e6)), "plain", TYPICAL, 6.0)).all()


def test_every_measure_has_a_weight() -> None:
    assert set(WEIGHTS) == set(FEATURES)
    assert np.allclose(scores(np.eye(len(FEATURES))), list(WEIGHTS.values()))
    assert tuple(LOG_ODDS) == EVIDENCE
    assert {len(row) for row in LOG_ODDS.values()} == {len(LEADS)}
    assert LEADS == KNOTS
    assert tuple(TRAITS) == (*FEATURES, *DRAWN)


def test_what_no_drawing_had_is_no_more_certain_than_the_farthest_that_one_had() -> None:
    for number, (name, (low, high, _)) in enumerate(TRAITS.items()):
        lower, upper, _ = CORRECTIONS.get(name, (low, high, 0.0))
        for limit, beyond in ((min(low, lower), -1e9), (max(high, upper), 1e9)):
            near, far = TYPICAL.copy(), TYPICAL.copy()
            near[number], far[number] = limit, beyond
            told = [confidence_of_first(1.0, "plain", each, 1.0) for each in (near, far)]
            assert told[1] <= told[0]
            assert told[1] == told[0] or name in ("open lines", HANGING)


def test_a_larger_lead_over_other_shapes_is_more_certain() -> None:
    leads = np.linspace(-6.0, 6.0, 40)
    told = [confidence_of_first(1.0, "plain", TYPICAL, lead) for lead in leads]
    assert (np.diff(told) >= 0.0).all()
    assert told[-1] > told[0] + 0.3


@pytest.mark.parametrize("name", ["open lines", HANGING])
def test_what_is_open_or_hangs_in_the_air_is_asked_about(name: str) -> None:
    sure = TYPICAL.copy()
    assert confidence_of_first(6.0, "plain", sure, 6.0) > 0.9
    sure[list(TRAITS).index(name)] = 0.1
    assert confidence_of_first(6.0, "plain", sure, 6.0) < SURE


def test_sheets_may_be_open() -> None:
    features = np.full(len(FEATURES), 0.2)
    tetrahedron = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
    number = FEATURES.index("open lines")
    assert traits_of(features, tetrahedron, 0.01)[number] == 0.2
    assert traits_of(features, tetrahedron[:-1], 0.01)[number] == 0.0


def test_the_corrections_find_what_is_said_too_surely() -> None:
    """Answers whose rivals are of another shape are right less often than what is said."""
    rng = np.random.default_rng(4)
    every, true = [], []
    for _ in range(4000):
        lead, apart = rng.uniform(-3.0, 6.0), rng.uniform(-1.0, 6.0)
        odds = float(corrected_traits(lead, "plain", TYPICAL, apart)[0])
        true.append(1.0 / (1.0 + np.exp(-(0.5 * odds + 0.8 * apart - 1.5))))
        every.append(Outcome("plain", lead, TYPICAL, bool(rng.uniform() < true[-1]), apart))
    made = fitted_corrections(every)
    assert np.abs([told(made, each) for each in every] - np.clip(true, LEAST, MOST)).mean() < 0.03
    module = ast.parse(text_of_corrections(made))
    rows = [row for row in module.body if isinstance(row, ast.AnnAssign)]
    kept = {ast.unparse(row.target): ast.literal_eval(row.value) for row in rows}
    assert tuple(kept["CORRECTIONS"]) == CORRECTED == tuple(CORRECTIONS)


def test_the_fit_finds_the_measure_that_tells_right_from_wrong() -> None:
    rng = np.random.default_rng(2)
    examples = []
    for _ in range(200):
        features = rng.normal(0.0, 0.5, (6, len(FEATURES)))
        right = np.zeros(6, bool)
        right[features[:, 3].argmax()] = True
        examples.append(Example(features, right))
    weights = fitted(examples)
    assert weights[3] == max(weights)
    hits = [each.right[(each.features @ weights).argmax()] for each in examples]
    assert np.mean(hits) > 0.8


def test_the_fit_says_how_often_it_was_right_by_lead_and_traits() -> None:
    rng = np.random.default_rng(8)
    every, true = [], []
    for _ in range(4000):
        traits, lead = rng.normal(0.0, 1.0, len(TRAITS)), float(rng.uniform(-3.0, 5.0))
        true.append(1.0 / (1.0 + np.exp(-(0.7 * lead - 0.4 + 1.1 * traits[4]))))
        every.append(Outcome("loose", lead, traits, bool(rng.uniform() < true[-1])))
    found = fitted_confidence(every)
    assert (np.diff(found.odds, axis=1) >= 0.0).all()
    odds = np.array([np.interp(each.lead, KNOTS, found.odds[1]) for each in every])
    low, high, weights = found.traits.T
    odds += np.clip([each.traits for each in every], low, high) @ weights
    said, true = 1.0 / (1.0 + np.exp(-odds)), np.array(true)
    assert np.abs(said - true).mean() < 0.04
    for least in np.arange(0.0, 1.0, 0.2):
        some = (said >= least) & (said < least + 0.2)
        assert said[some].mean() == pytest.approx(true[some].mean(), abs=0.05)
    rows = [row for row in ast.parse(text_of(found)).body if isinstance(row, ast.AnnAssign)]
    kept = {ast.unparse(row.target): ast.literal_eval(row.value) for row in rows}
    assert kept["LEADS"] == KNOTS
    assert list(kept["TRAITS"]) == list(TRAITS)
