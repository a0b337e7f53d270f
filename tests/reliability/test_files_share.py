"""A share of the suite of strangers' files, for every long test run."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import sys

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="memory and waiting are measured on Linux"),
]

MUTATED = 6_000
MODELS = 120
HOSTILE_BYTES = 400_000


def test_mutated_files_are_read_or_refused():
    from tests.reliability.suite_files import mutated_row

    row = mutated_row(MUTATED, 2)
    assert row.kept, row


def test_mutated_documents_that_load_can_be_used():
    from tests.reliability.suite_files import models_row

    row = models_row(MODELS, 2)
    assert row.kept, row


def test_hostile_files_keep_to_the_budget():
    # In a process begun anew: what this one holds would be counted in the peak of those it forks.
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        lost = pool.submit(_hostile_files_lost, HOSTILE_BYTES).result()
    assert not lost


def _hostile_files_lost(size):
    from tests.reliability.suite_files import hostile_rows

    return [row for row in hostile_rows(size) if not row.kept]
