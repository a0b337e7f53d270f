"""Details in network files: what is there is what was meant, and odd values are told by name."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.testing import same
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.details import Detail
from tests.plugins.product.detail_kit import RADIUS, ball, ball_curves, body, manifold, solved

A = np.linspace(0.0, 2.0 * np.pi, 33)[:-1]
RING = np.column_stack((6.0 * np.cos(A), 6.0 * np.sin(A)))
STAR = (4.0 + 2.0 * (np.arange(10) % 2))[:, None] * np.column_stack(
    (np.cos(np.arange(10) * np.pi / 5), np.sin(np.arange(10) * np.pi / 5))
)


def file_with(*details, unit="mm"):
    scale = {"mm": 1.0, "cm": 0.1}[unit]
    curves = [
        {"name": c["name"], "points": (scale * np.array(c["points"])).tolist()}
        for c in ball_curves()
    ]
    return {"network": {"curves": curves, "details": list(details)}, "unit": unit}


def flat(**values):
    place = (RADIUS / np.sqrt(3.0) * np.ones(3)).tolist()
    return {"flat": [RING.tolist()], "at": place, "width": 12.0, **values}


def test_a_flat_outline_lies_where_it_was_put_as_wide_as_it_was_asked():
    state = product_of_network(file_with(flat(kind="raised", depth=1.0, name="Logo")))
    (detail,) = state.of_kind(Detail)
    assert (detail.name, detail.kind, detail.depth) == ("Logo", "raised", 1.0)
    (solved_detail,) = solved(state).detailed.details
    assert solved_detail.problem == ""
    outline = solved_detail.outlines[0]
    assert np.linalg.norm(outline.mean(axis=0) - RADIUS / np.sqrt(3.0)) < 1.0
    assert np.linalg.norm(outline[0] - outline[len(outline) // 2]) == pytest.approx(12.0, rel=0.02)
    assert np.abs(np.linalg.norm(outline, axis=1) - RADIUS).max() < 0.02


@pytest.mark.slow
def test_a_star_with_a_hole_keeps_its_corners():
    hole = (0.3 * RING).tolist()
    values = flat(flat=[STAR.tolist(), hole], kind="in", depth=0.6, draft=2.0)
    state = product_of_network(file_with(values))
    assert solved(state).detailed.details[0].problem == ""
    places = state.of_kind(Detail)[0].places
    assert places.corners.sum() == 10
    assert len(places.starts) == 2
    assert manifold(body(state).mesh).genus() == 0


def test_sizes_are_in_the_unit_of_the_file():
    values = flat(depth=0.2, gap=0.05, draft=4.0, kind="button")
    values["at"] = (0.1 * np.array(values["at"])).tolist()
    values["width"] = 1.2
    (detail,) = product_of_network(file_with(values, unit="cm")).of_kind(Detail)
    assert (detail.depth, detail.gap, detail.draft) == pytest.approx((2.0, 0.5, 4.0))


def test_outlines_in_space_are_those_on_the_surface():
    place = np.array(flat()["at"])
    normal = place / np.linalg.norm(place)
    x = np.cross(normal, (0.0, 0.0, 1.0))
    x /= np.linalg.norm(x)
    points = place + RING[:, :1] * x + RING[:, 1:] * np.cross(normal, x)
    points *= RADIUS / np.linalg.norm(points, axis=1, keepdims=True)
    state = product_of_network(file_with({"outlines": [points.tolist()], "kind": "cut"}))
    outline = solved(state).detailed.details[0].outlines[0][:-1]
    assert np.linalg.norm(outline - points, axis=1).max() < 0.02


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"kind": "dented"}, "kind"),
        ({"depth": -1.0}, "depth"),
        ({"draft": 90.0}, "draft"),
        ({"colour": [1, 2, 3]}, "colour"),
        ({"color": [1, 2]}, "color"),
        ({"flat": []}, "flat"),
        ({"flat": [[[0, 0], [0, 0], [0, 0]]]}, "points"),
        ({"flat": [[[0, 0], [1, float("nan")], [0, 1]]]}, "flat"),
        ({"width": 0.0}, "width"),
        ({"width": 500.0}, "surface"),
        ({"at": [1, 2]}, "at"),
        ({"outlines": [[[0, 0, 0]] * 3]}, "either"),
        ({"mirrored": 1}, "mirrored"),
    ],
)
def test_odd_values_are_refused_by_their_names(change, words):
    values = deepcopy(flat())
    values.update(change)
    with pytest.raises(UserError, match=words):
        product_of_network(file_with(values))


def test_a_file_without_details_is_what_it_was():
    assert same(product_of_network(file_with()), ball())


@pytest.mark.parametrize("off", [0.0, 2e-16, 1e-12])
def test_an_outline_may_end_nearly_where_it_began(off):
    """The sine of a whole turn is no nought; the spline through such points failed."""
    whole = np.vstack((RING, RING[:1] + off))
    state = product_of_network(file_with(flat(flat=[whole.tolist()], kind="in", depth=0.5)))
    (solved_detail,) = solved(state).detailed.details
    assert solved_detail.problem == ""
    (places,) = (detail.places for detail in state.of_kind(Detail))
    assert len(places.corners) == len(RING)


def test_points_over_one_another_are_one_and_too_few_are_told():
    at = RADIUS * np.array([[0.6, 0.6, 0.53], [0.6, 0.5, 0.62], [0.5, 0.6, 0.62]])
    at *= RADIUS / np.linalg.norm(at, axis=1, keepdims=True)
    enough, too_few = np.repeat(at, 2, axis=0), np.repeat(at[:2], 2, axis=0)
    enough[::2] *= 1.0 + 1e-13
    too_few[::2] *= 1.0 + 1e-13
    values = {"kind": "in", "depth": 0.2}
    state = product_of_network(file_with({"outlines": [enough.tolist()], **values}))
    assert solved(state).detailed.details[0].problem == ""
    with pytest.raises(UserError, match="three points that differ"):
        product_of_network(file_with({"outlines": [too_few.tolist()], **values}))
