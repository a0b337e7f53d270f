"""Documents of the first version of the product's state open, and are what they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.document.storage.state_codec import state_digest
from bozzetto.plugin import Job
from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.workbench import Workbench
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch

STORED = Path(__file__).parents[2] / "data" / "documents" / "product-v1.bozz"
"""The first four curves of a computer mouse, saved while curves kept places that nobody read."""


def test_a_product_of_the_first_version_opens_whole(tmp_path) -> None:
    bench = Workbench(Registry())
    document, report = read_document(STORED, bench.registry)
    assert report.warnings == ()
    (model,) = document
    curves = model.state.of_kind(Curve)
    assert [curve.name for curve in curves] == ["Spine", "Base", "Sole", "Curve 1"]
    assert [len(curve.strokes) for curve in curves] == [2, 2, 2, 2]
    assert [curve.mirrored for curve in curves] == [False, True, False, True]
    ends = curves[1].spline.control_points[[0, -1]]
    np.testing.assert_array_equal(ends[:, 1], 0.0)
    result = bench.solve(model, Job())
    assert len(model.state.of_kind(Patch)) == len([p for p in result.patches if not p.mirrored])
    write_document(document, tmp_path / "again.bozz")
    again, report = read_document(tmp_path / "again.bozz", bench.registry)
    assert report.warnings == ()
    assert state_digest(again.models[0].state) == state_digest(model.state)
    assert again.models[0].state_version == 2
