"""What an edit does not reach is the very same afterwards."""

import pytest

from bozzetto.plugin import Job
from bozzetto_product import modeler
from bozzetto_product.model.curves import Curve
from tests.plugins.product.shaver import bent, shaver


@pytest.mark.slow
def test_an_edit_of_a_shaver_solves_what_is_near_it_only():
    product = modeler.ProductModeler()
    state = shaver()
    curves = state.of_kind(Curve)
    assert len(curves) + sum(curve.mirrored for curve in curves) == 107
    before = product.solve(state, Job())
    assert len(before.filled) == 50
    assert before.is_closed
    after = product.solve(bent(state, "upper-6", 0.02), Job())
    assert len(after.filled) == 50
    same = {id(one.fill) for one in before.filled} & {id(one.fill) for one in after.filled}
    assert 25 <= len(same) <= 47
