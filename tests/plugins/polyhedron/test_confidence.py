"""What is said of first answers is how often they are right; where readings changed, fit anew.

Drawings are of seeds that neither fit nor table has seen. If this fails after readings or weights
changed: ``python -m tests.plugins.polyhedron.fit_confidence``.
"""

from __future__ import annotations

import functools
from itertools import pairwise

import numpy as np
import pytest

from bozzetto_polyhedron.reconstruction.confidence_tables import TRAITS
from tests.plugins.polyhedron.figures_confidence import FIRST_SEED, said
from tests.plugins.polyhedron.fit_confidence import BINS, EVIDENCE, SEEDS, outcome
from tests.plugins.polyhedron.kept_outcomes import Outcome

DRAWINGS = range(80_000, 80_600)

TOLERANCE = 0.05
"""Share by which a bin may be off beyond its sampling error."""

ERRORS = 2.5
"""Standard errors of a bin that chance is allowed: one bin in eighty."""

FEWEST = 12
"""Drawings in a bin below which it tells nothing."""


@functools.cache
def outcomes() -> tuple[Outcome, ...]:
    return tuple(each for seed in DRAWINGS if (each := outcome(seed)) is not None)


def off(found: list[Outcome]) -> float:
    """Return by how much more than chance and the tolerance a bin is off; negative if it holds."""
    told = np.array([said(each) for each in found])
    error = float(np.sqrt((told * (1.0 - told)).sum())) / len(told)
    right = float(np.mean([each.right for each in found]))
    return abs(float(told.mean()) - right) - TOLERANCE - ERRORS * error


def test_seeds_are_those_of_no_fit_and_no_table() -> None:
    assert not set(DRAWINGS) & set(SEEDS)
    assert DRAWINGS.start >= FIRST_SEED + 2400


def test_a_bin_that_is_too_sure_is_off() -> None:
    traits = np.array([0.5 * (low + high) for low, high, _ in TRAITS.values()])
    lead = next(each for each in np.arange(0.0, 6.0, 0.1) if sure(float(each), traits) > 0.5)
    share = sure(float(lead), traits)
    for right, holds in ((share, True), (share - 0.3, False), (min(1.0, share + 0.3), False)):
        found = [Outcome("plain", float(lead), traits, k < 100 * right, lead) for k in range(100)]
        assert (off(found) < 0.0) == holds


def sure(lead: float, traits: np.ndarray) -> float:
    return said(Outcome("plain", lead, traits, True, lead))


@pytest.mark.slow
@pytest.mark.parametrize("evidence", ["", *EVIDENCE])
def test_what_is_said_is_how_often_it_is_right(evidence: str) -> None:
    every = [each for each in outcomes() if evidence in ("", each.evidence)]
    assert len(every) > 60
    for low, high in pairwise(BINS):
        found = [each for each in every if low <= said(each) < high]
        if len(found) >= FEWEST:
            assert off(found) < 0.0, (low, high, len(found))
