"""Documents of the first version of the silhouette's state open, and look as they did."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.plugin import Job
from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.workbench import Workbench

STORED = Path(__file__).parents[2] / "data" / "documents" / "silhouette-v1.bozz"
"""A ring and a rectangle in one model with inflation 1.5, softness 1.6 and resolution 64,
saved by the program before its state became a tree."""

BOUNDS = [[-122.609, -53.568, -52.550], [140.133, 53.568, 52.550]]
"""Of the shape that the program of then made of it, mm."""


@pytest.fixture(scope="module")
def bench():
    return Workbench(Registry())


@pytest.fixture(scope="module")
def model(bench):
    document, report = read_document(STORED, bench.registry)
    assert report.warnings == ()
    (model,) = document
    return model


def test_parts_get_names_and_what_they_shared(model):
    parts = model.state.parts
    assert [part.name for part in parts] == ["Part 1", "Part 2"]
    assert [len(part.strokes) for part in parts] == [2, 1]
    assert {(part.inflation, part.softness, part.blend) for part in parts} == {(1.5, 1.6, 0.0)}
    assert model.state.resolution == 64
    assert len({part.id for part in parts}) == 2


def test_its_shape_is_as_large_as_it_was(bench, model):
    bounds = np.stack([s.mesh.bounds for s in bench.shapes([model], Job()).solids])
    size = np.ptp(BOUNDS, axis=0)
    across = np.stack([bounds[:, 0].min(0), bounds[:, 1].max(0)])
    assert across[:, [0, 2]] == pytest.approx(np.array(BOUNDS)[:, [0, 2]], abs=0.1)
    assert np.ptp(across, axis=0)[1] == pytest.approx(size[1], rel=0.05)


def test_it_is_saved_as_today_and_opens_again(bench, model, tmp_path):
    document, _ = read_document(STORED, bench.registry)
    write_document(document, tmp_path / "again.bozz")
    again, report = read_document(tmp_path / "again.bozz", bench.registry)
    assert report.warnings == ()
    assert again.models[0].state == model.state
    assert again.models[0].state_version == 4


def test_version_two_kept_whether_handles_were_shown():
    from bozzetto_silhouette.modeler import Silhouette

    kept = {"nodes": [], "selected": "", "resolution": 64}
    assert Silhouette().upgrade({**kept, "held": True}, 2) == kept
