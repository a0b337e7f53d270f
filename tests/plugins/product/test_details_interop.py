"""Bodies with details, read by Open CASCADE (BOZZETTO_CAD_READERS names a Python that has it)."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.exchange.export import export
from bozzetto.geometry import Shapes
from tests.core.exchange.test_breps import OPENCASCADE
from tests.core.exchange.test_curve_interop import ask, messages
from tests.plugins.product.detail_kit import (
    ball,
    body,
    loop_around,
    manifold,
    polygon_around,
    with_detail,
)
from tests.plugins.product.test_details_on_floors import POCKET, disc
from tests.plugins.product.test_details_on_floors import solved as solved_on_box
from tests.plugins.product.test_details_over_edges import over_edge, solved
from tests.plugins.product.test_network_file import box

pytestmark = pytest.mark.interop

PLACE = (1.5, 38.0, 8.0)
"""Near a corner of four surfaces."""


@pytest.mark.parametrize("kind", ["in", "raised", "cut", "button", "split"])
def test_opencascade_reads_one_valid_closed_solid(tmp_path, kind):
    triangle = 7.0 * np.array([(0.0, 1.0), (-0.9, -0.5), (0.9, -0.5)])
    points, marks = polygon_around(ball(), (22.0, 22.0, 25.0), triangle)
    state = with_detail(ball(), [points], [marks], kind=kind, depth=1.2, draft=1.0)
    round_ = loop_around(ball(), PLACE, 6.0, (0.1,))
    state = with_detail(state, [round_], kind=kind, depth=1.2, draft=1.0)
    solid = body(state)
    path = tmp_path / "a.step"
    export(Shapes(solids=(solid,)), path)
    said, answer = ask(OPENCASCADE, path)
    assert messages(said) == []
    assert answer["valid"]
    assert (answer["solids"], answer["shells"]) == (1, 1)
    assert answer["faces"] == len(solid.exact.faces)
    assert answer["volume"] == pytest.approx(manifold(solid.mesh).volume(), rel=1e-3)


@pytest.mark.parametrize("draft", [0.0, 4.0])
def test_opencascade_reads_a_window_across_an_edge(tmp_path, draft):
    _, (solid,) = solved(box(), kind="cut", draft=draft, outlines=[over_edge()])
    path = tmp_path / "a.step"
    export(Shapes(solids=(solid,)), path)
    said, answer = ask(OPENCASCADE, path)
    assert messages(said) == []
    assert answer["valid"]
    assert (answer["solids"], answer["shells"]) == (1, 1)
    assert answer["volume"] == pytest.approx(manifold(solid.mesh).volume(), rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "x"),
    [(kind, 50.0) for kind in ("in", "raised", "cut", "button", "split")]
    + [("cut", 70.0), ("split", 70.0)],
)
def test_opencascade_reads_what_lies_on_a_floor_and_cuts_over_its_rim(tmp_path, kind, x):
    inner = {"kind": kind, "depth": 1.5, "outlines": [disc(8.0, x=x)], "draft": 4.0}
    result, solid = solved_on_box({**POCKET, "draft": 4.0}, inner)
    assert [one.problem for one in result.detailed.details] == ["", ""]
    path = tmp_path / "a.step"
    export(Shapes(solids=(solid,)), path)
    said, answer = ask(OPENCASCADE, path)
    assert messages(said) == []
    assert answer["valid"]
    assert (answer["solids"], answer["shells"]) == (1, 1)
    assert answer["faces"] == len(solid.exact.faces)
    assert answer["volume"] == pytest.approx(manifold(solid.mesh).volume(), rel=1e-3)


@pytest.mark.parametrize("draft", [0.0, 4.0])
@pytest.mark.parametrize("kind", ["in", "raised", "button"])
def test_opencascade_reads_floors_that_meet_over_an_edge(tmp_path, kind, draft):
    _, (solid,) = solved(box(), kind=kind, gap=0.5, draft=draft, outlines=[over_edge()])
    path = tmp_path / "a.step"
    export(Shapes(solids=(solid,)), path)
    said, answer = ask(OPENCASCADE, path)
    assert messages(said) == []
    assert answer["valid"]
    assert (answer["solids"], answer["shells"]) == (1, 1)
    assert answer["faces"] == len(solid.exact.faces)
    assert answer["volume"] == pytest.approx(manifold(solid.mesh).volume(), rel=1e-3)
