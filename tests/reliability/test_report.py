"""The page of reliability is made of sections that replace only themselves."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from tests.reliability import __main__ as reliability
from tests.reliability.figures import Row

SUITES = sorted(path.stem for path in Path(reliability.__file__).parent.glob("suite_*.py"))


@pytest.mark.parametrize("suite", SUITES)
def test_every_suite_has_rows_and_a_title(suite: str) -> None:
    module = importlib.import_module(f"tests.reliability.{suite}")
    assert callable(module.rows)
    assert (module.__doc__ or "").splitlines()[0]


def test_a_section_replaces_only_itself() -> None:
    page = reliability.with_section("# Title\n", "pen", "first")
    page = reliability.with_section(page, "kills", "second")
    again = reliability.with_section(page, "pen", "third")
    assert "first" not in again
    assert again.index("third") < again.index("second")
    assert reliability.with_section(again, "pen", "third") == again


def test_a_broken_promise_is_told() -> None:
    assert Row("what", "3", "2", kept=False).cells()[-1] == "**no**"


def test_an_unknown_suite_is_refused() -> None:
    with pytest.raises(SystemExit):
        reliability.main(["nowhere"])
