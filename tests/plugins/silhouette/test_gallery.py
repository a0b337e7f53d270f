"""The gallery: recorded ink and its steps become sound solids, and documents that open."""

from __future__ import annotations

from pathlib import Path

import pytest

from bozzetto.document.model import Document
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.testing import same
from bozzetto.workbench.workbench import Workbench
from bozzetto_silhouette.inflation.manifold_check import topology_of, volume_of

INKS = sorted((Path(__file__).parents[3] / "docs" / "gallery").glob("*.json"))
HANDLES = {"cup": 1, "chair": 2, "creature": 0, "face": 0, "fish": 0}
"""Genus: the ring of the cup's handle; the chair's back, and the part of it above the rail.
The tree's branches and crowns may touch or not."""


@pytest.mark.slow
@pytest.mark.parametrize("resolution", [40, 64, 80, 128])
@pytest.mark.parametrize("path", INKS, ids=lambda path: path.stem)
def test_ink_becomes_a_sound_solid_and_a_document(
    path: Path, resolution: int, tmp_path: Path
) -> None:
    bench = Workbench(Registry())
    model = bench.sources.from_drawing(
        "bozzetto.silhouette", read_drawing(path), {"resolution": resolution}
    )
    result = bench.solve(model, Job())
    vertices, faces = result.body.vertices, result.body.faces
    found = topology_of(vertices, faces)
    assert found.watertight
    assert found.components == 1
    assert volume_of(vertices, faces) > 0.0
    assert found.genus == HANDLES.get(path.stem, found.genus)
    write_document(Document((model,)), tmp_path / "x.bozz")
    opened, report = read_document(tmp_path / "x.bozz", bench.registry)
    assert not report.warnings
    assert same(opened.models[0].state, model.state)


def test_there_are_six() -> None:
    assert {path.stem for path in INKS} == {"creature", "cup", "tree", "fish", "chair", "face"}
