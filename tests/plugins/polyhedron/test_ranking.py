"""Shares become probabilities."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.reconstruction.confidence_tables import CONFIDENCES, SHARES
from bozzetto_polyhedron.reconstruction.ranking import FEATURES, confidences, scores
from bozzetto_polyhedron.reconstruction.ranking_weights import WEIGHTS
from tests.plugins.polyhedron.fit_confidence import SHARES as KNOTS
from tests.plugins.polyhedron.fit_confidence import table
from tests.plugins.polyhedron.fit_ranking import Example, fitted


@pytest.mark.parametrize("evidence", CONFIDENCES)
def test_a_larger_lead_is_more_certain(evidence) -> None:
    leads = np.linspace(0.0, 8.0, 30)
    first = [confidences(np.array((lead, 0.0, -1.0)), evidence)[0] for lead in leads]
    assert (np.diff(first) >= 0.0).all()
    assert first[0] < 0.8 < first[-1]


@pytest.mark.parametrize("evidence", CONFIDENCES)
def test_probabilities_fall_and_sum_to_one_at_most(evidence) -> None:
    rng = np.random.default_rng(5)
    for count in (1, 2, 8):
        values = np.sort(rng.normal(0.0, 3.0, count))[::-1]
        found = confidences(values, evidence)
        assert found.shape == (count,)
        assert (np.diff(found) <= 0.0).all()
        assert found.sum() <= 1.0 + 1e-12
    assert len(confidences(np.zeros(0), evidence)) == 0


def test_scores_far_apart_do_not_overflow() -> None:
    assert np.isfinite(confidences(np.array((1e6, 0.0, -1e6)), "plain")).all()


def test_every_measure_has_a_weight() -> None:
    assert set(WEIGHTS) == set(FEATURES)
    assert np.allclose(scores(np.eye(len(FEATURES))), list(WEIGHTS.values()))
    assert {len(row) for row in CONFIDENCES.values()} == {len(SHARES)}
    assert SHARES == KNOTS


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


def test_the_table_is_how_often_it_was_right_and_never_falls() -> None:
    rng = np.random.default_rng(8)
    shares = rng.uniform(0.0, 1.0, 3000)
    true = np.interp(shares, (0.0, 0.4, 1.0), (0.3, 0.8, 0.9))
    found = table(shares, (rng.uniform(0.0, 1.0, 3000) < true).astype(float))
    assert (np.diff(found) >= 0.0).all()
    said = np.interp(shares, KNOTS, found)
    for low, high in ((0.1, 0.3), (0.4, 0.6), (0.7, 0.95)):
        some = (shares > low) & (shares < high)
        assert said[some].mean() == pytest.approx(true[some].mean(), abs=0.05)
