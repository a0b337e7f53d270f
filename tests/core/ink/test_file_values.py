"""Plain values of drawings' files: what is wrong is told as a rule, with the place in the file."""

from __future__ import annotations

import re

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import PIXELS, PLANE, SPACE, a_list, a_number, a_point


@pytest.mark.parametrize("coordinates", [SPACE, PLANE, PIXELS])
def test_a_point_has_a_number_for_each_coordinate(coordinates):
    names, farthest = coordinates
    row = [float(k) for k in range(len(names))]
    assert np.array_equal(a_point(row, "here", coordinates), row)
    told = re.escape(f"“here” must be a point [{', '.join(names)}].")
    for wrong in (row[:-1], [*row, 1.0]):
        with pytest.raises(UserError, match=told):
            a_point(wrong, "here", coordinates)
    with pytest.raises(UserError, match="“here” must be a number from"):
        a_point([2.0 * farthest, *row[1:]], "here", coordinates)


@pytest.mark.parametrize("value", [True, "1", None, float("nan"), 11])
def test_what_is_no_number_within_bounds_is_told_as_a_rule(value):
    with pytest.raises(UserError, match="“width” must be a number from 0 to 10"):
        a_number(value, "width", 0.0, 10.0)


@pytest.mark.parametrize(("most", "told"), [(1, "1 entry at most"), (2, "2 entries at most")])
def test_a_list_that_is_too_long_tells_how_long_it_is(most, told):
    assert a_list([0] * most, "rows", most) == [0] * most
    with pytest.raises(UserError, match=f"“rows” has 3 entries; write {told}"):
        a_list([0] * 3, "rows", most)
