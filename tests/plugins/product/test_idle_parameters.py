"""What is said to change nothing of a detail or a wall changes nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bozzetto.parameters import parameter_fields
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.details import Detail
from tests.plugins.product.detail_kit import ball, body, loop_around, solved, with_detail

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


def roof():
    """Two bowed sheets that meet over the curve "ridge" at an angle, as a network."""
    curves = [
        {"name": "ridge", "points": [(-30.0, 0.0, 20.0), (0.0, 0.0, 24.0), (30.0, 0.0, 20.0)]}
    ]
    for side, y in (("front", -25.0), ("back", 25.0)):
        eave = [(-30.0, y, 0.0), (0.0, y, 3.0), (30.0, y, 0.0)]
        left = [(-30.0, 0.0, 20.0), (-30.0, y / 2.0, 13.0), eave[0]]
        right = [(30.0, 0.0, 20.0), (30.0, y / 2.0, 13.0), eave[-1]]
        for name, points in (("eave", eave), ("left", left), ("right", right)):
            curves.append({"name": f"{side} {name}", "points": points})
    return product_of_network({"network": {"curves": curves}, "unit": "mm"})


def test_the_crease_counts_only_between():
    """How surfaces meet over a curve is asked of the value only where it is not said in words."""
    plain = roof()
    (ridge,) = (curve for curve in plain.of_kind(Curve) if curve.name == "ridge")

    def shape(edge, crease):
        result = solved(plain.with_node(replace(ridge, edge=edge, crease=crease)))
        return b"".join(one.mesh.vertices.tobytes() for one in result.patches)

    idle = next(f for f in parameter_fields(Curve) if f.name == "crease").parameter.idle_while
    assert idle == (("edge", ("auto", "smooth", "crease")),)
    for edge in idle[0][1]:
        assert shape(edge, 0.1) == shape(edge, 0.9)
    assert shape("between", 0.1) != shape("between", 0.9)
