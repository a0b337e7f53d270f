from __future__ import annotations

import pytest

from tests.reliability import suite_pen

pytestmark = pytest.mark.display


def test_a_twentieth_of_it_is_kept() -> None:
    broken = [row for row in suite_pen.rows(0.05) if not row.kept]
    assert not broken
