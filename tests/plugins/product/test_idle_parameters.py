"""What is said to change nothing of a detail or a wall changes nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bozzetto.parameters import parameter_fields
from bozzetto_product.model.details import Detail
from tests.plugins.product.detail_kit import ball, body, loop_around, with_detail

OTHER = {"depth": 2.5, "draft": 12.0, "gap": 1.5}
CASES = [
    (field.name, kind)
    for field in parameter_fields(Detail)
    for _, kinds in field.parameter.idle_while
    for kind in kinds
]


def vertices(state):
    return body(state).mesh.vertices.tobytes()


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_a_value_that_a_kind_of_detail_does_not_heed_leaves_the_body(name, kind):
    loop = loop_around(ball(), (1.0, 1.0, 1.0), 9.0)
    plain = with_detail(ball(), [loop], kind=kind)
    assert vertices(plain) == vertices(
        with_detail(ball(), [loop], kind=kind, **{name: OTHER[name]})
    )


def test_without_a_wall_its_side_is_nothing():
    assert vertices(ball()) == vertices(replace(ball(), wall_side="outside"))
