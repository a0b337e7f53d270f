"""A small share of the monkey and of the soak, and the tools that look after them."""

from __future__ import annotations

import pytest

from tests.reliability import suite_monkey, suite_soak
from tests.reliability.children import Outcome, play
from tests.reliability.growth import has_grown, spread


def kept(rows) -> None:
    for row in rows:
        assert row.kept, row.cells()


@pytest.mark.slow
def test_a_monkey_for_a_moment() -> None:
    kept(suite_monkey.rows(1e-9))


@pytest.mark.slow
def test_a_day_for_a_moment() -> None:
    outcome = play("soak", ("--seconds", "5"), "offscreen", 300.0, "offscreen")
    kept(suite_soak.rows_of("offscreen", 5.0, outcome))


def test_shares_of_the_actions() -> None:
    assert suite_monkey.lengths_of(1.0) == [5000] * 20
    assert suite_monkey.lengths_of(0.051) == [5000, 100]
    assert suite_monkey.lengths_of(1e-9) == [suite_monkey.LEAST]


def test_a_run_that_died_breaks_the_promise() -> None:
    gone = Outcome("xcb seed 3", None, "1290 pen_stroke", "Segmentation fault")
    first, *others = suite_monkey.rows_of("xcb", [5000], [gone])
    assert not first.kept
    assert "xcb seed 3 at 1290 pen_stroke" in first.figure
    assert all(row.kept for row in others)


def test_a_fault_is_named_so_that_it_can_be_played_again() -> None:
    problems = [
        {"kind": "fault", "action": 17, "text": "…"},
        {"kind": "qt", "action": 2, "text": ""},
    ]
    seen = Outcome("offscreen seed 1", {"problems": problems, "figures": []}, "60", "")
    rows = list(suite_monkey.rows_of("offscreen", [60], [seen]))
    assert [row.kept for row in rows] == [True, False, True]
    assert "offscreen seed 1 at 17" in rows[1].figure


def test_memory_that_grows_breaks_the_promise() -> None:
    figures = [
        {"action": 500 * k, "memory": 300 + 40 * k, "threads": 3, "widgets": 100 + k, "files": 9}
        for k in range(1, 11)
    ]
    seen = Outcome("offscreen seed 1", {"problems": [], "figures": figures}, "5000", "")
    rows = {row.what: row.kept for row in suite_monkey.rows_of("offscreen", [5000], [seen])}
    assert not rows["offscreen: memory after the first 1000 actions"]
    assert not rows["offscreen: runs in which widgets grow"]
    assert rows["offscreen: runs in which threads grow"]


def test_growth() -> None:
    assert has_grown([1, 2, 3, 4])
    assert not has_grown([3, 4, 3, 4])
    assert not has_grown([1, 5])
    assert spread([9.0, 10.0, 11.0]) == pytest.approx(0.1)
