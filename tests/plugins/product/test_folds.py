"""A surface that would fold if it were smooth gets creases, and that is told."""

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.fill.normals import smooth_half_edges
from bozzetto_product.loops.finding import find_loops
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.solve.found_patches import with_patches_found
from tests.plugins.product.drawn_networks import DRAWN


@pytest.fixture(scope="module")
def handset():
    """Its two cheeks are bent round like a U, and are to be smooth over four edges each."""
    return DRAWN["handset"]()


def test_cheeks_that_would_fold_get_creases_and_nothing_else_does(handset):
    net = handset.net()
    loops = orient_loops(net, find_loops(net).loops).loops
    fills, asked = fill_net(net, loops), smooth_half_edges(net, loops)
    assert not any(fill.folded for fill in fills)
    kept = [(~np.isnan(fill.g1_degrees)).tolist() for fill in fills]
    changed = [k for k, own in enumerate(kept) if own != list(asked[k])]
    assert len(changed) == 2
    for k in changed:
        assert all(a or not b for a, b in zip(asked[k], kept[k], strict=True))


def test_creases_that_nobody_asked_for_are_told(handset):
    curves, joints = handset.built()
    state = with_patches_found(ProductState(nodes=tuple(curves), joints=tuple(joints)))
    modeler = ProductModeler()
    result = modeler.solve(state, Job())
    told = [one for one in modeler.report(state, result, Job())["warnings"] if "creases at" in one]
    creased = [one for one in result.filled if one.creased]
    assert len(told) == len(creased) > 0
    for sentence, one in zip(told, creased, strict=True):
        assert sentence.startswith(f"{one.name} has creases at ")
        assert not any(one.is_smooth_at(k) for k in one.creased)
