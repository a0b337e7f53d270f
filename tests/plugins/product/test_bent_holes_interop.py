"""Bent faces with holes, read by Open CASCADE (BOZZETTO_CAD_READERS names a Python that has it)."""

from __future__ import annotations

import pytest

from bozzetto.exchange.export import export
from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.modeler import ProductModeler
from tests.core.exchange.test_breps import OPENCASCADE
from tests.core.exchange.test_curve_interop import ask, messages
from tests.plugins.product.holed_bends import random_cylinder
from tests.plugins.product.test_rough_files import turned

pytestmark = pytest.mark.interop


@pytest.mark.parametrize("seed", [7305, 7308])
def test_opencascade_reads_one_valid_solid_of_the_volume_that_a_cylinder_has(tmp_path, seed):
    made = random_cylinder(seed)
    state = product_of_network(made.facts(turned(seed)))
    shapes = shapes_of(state, ProductModeler().solve(state, Job()))
    path = tmp_path / "a.step"
    export(shapes, path)
    said, answer = ask(OPENCASCADE, path)
    assert messages(said) == []
    assert answer["valid"]
    assert (answer["solids"], answer["shells"]) == (1, 1)
    (solid,) = shapes.solids
    assert answer["faces"] == len(solid.exact.faces)
    assert answer["volume"] == pytest.approx(made.volume, rel=2e-4)
