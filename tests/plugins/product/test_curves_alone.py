"""Curves of a product without its surfaces, in files of CAD programs."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.export import prepare_file
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.ready_shapes import Ready
from bozzetto.geometry import Shapes
from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.solve.solver import solve_product
from tests.plugins.product.test_creased_pieces import facts

ALONE = Handover(curves_alone=True)


@pytest.fixture(scope="module")
def sheet() -> Shapes:
    state = product_of_network(facts())
    return shapes_of(state, solve_product(state, Job()))


@pytest.mark.parametrize("ending", ["step", "iges"])
def test_curves_come_back_exactly_and_no_surface(sheet: Shapes, ending, tmp_path) -> None:
    path = tmp_path / f"alone.{ending}"
    made = prepare_file(Ready(sheet, ALONE), path, None)
    path.write_bytes(made.data)
    back = read_mesh_file(path).shapes
    assert not list(back.meshes())
    assert not back.breps
    assert len(back.curves) == len(sheet.curves) == 6
    for ours, theirs in zip(sheet.curves, back.curves, strict=True):
        assert np.allclose(ours.control_points, theirs.control_points, atol=1e-9)
    assert not made.left_out
    whole = prepare_file(Ready(sheet), path, None)
    assert len(whole.data) > 2 * len(made.data)


def test_formats_without_curves_hold_the_surfaces_and_say_so(sheet: Shapes) -> None:
    made = prepare_file(Ready(sheet, ALONE), "a.obj", None)
    assert list(made.parts.meshes())
    assert any("no curves" in note for note in made.notes)


def test_where_no_curve_is_that_is_an_error(sheet: Shapes) -> None:
    bare = Shapes(surfaces=sheet.surfaces)
    with pytest.raises(UserError):
        prepare_file(Ready(bare, ALONE), "a.step", None)
