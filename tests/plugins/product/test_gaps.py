"""Ends that nearly meet something, and are not joined, are told by name, width, and what to do."""

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.view.scene import scene_of
from tests.plugins.product.test_network_file import box

FAR = np.hypot(100.0, np.hypot(60.0, 40.0))


def solved(short, scale=1.0, mirror=1.0):
    """A box of which one edge ends too early by a share of the diagonal."""
    facts = box(scale)
    (edge,) = (one for one in facts["network"]["curves"] if one["name"] == "ab")
    edge["points"][1][0] -= scale * short * FAR
    for one in facts["network"]["curves"]:
        one["points"] = (np.array(one["points"]) * [mirror, 1.0, 1.0]).tolist()
    modeler, state = ProductModeler(), product_of_network(facts)
    result = modeler.solve(state, Job())
    return modeler.report(state, result, Job()), scene_of(state, result)


@pytest.mark.parametrize("mirror", [1.0, -1.0])
@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_a_gap_is_told_and_lit(scale, mirror):
    told, scene = solved(0.03, scale, mirror)
    (gap,) = told["gaps"]
    assert gap["curve"] == "ab"
    assert gap["other"] in {"bc", "bf"}
    assert gap["width_mm"] == pytest.approx(scale * 0.03 * FAR, rel=1e-6)
    (sentence,) = [one for one in told["warnings"] if "beside" in one]
    assert sentence.startswith("ab ends")
    assert f"{gap['width_mm']:.3g} mm" in sentence
    assert "Join" in sentence
    (layer,) = [one for one in scene.layers if one.name == "gaps"]
    assert layer.items[0].color == "warning"


@pytest.mark.parametrize("short", [0.0, 0.01, 0.2])
def test_what_meets_is_joined_or_is_far_away_has_no_gap(short):
    told, scene = solved(short)
    assert told["gaps"] == []
    assert "gaps" not in [layer.name for layer in scene.layers]
