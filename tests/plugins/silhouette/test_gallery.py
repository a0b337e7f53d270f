"""The gallery: recorded ink and its steps become sound solids, and documents that open."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.document.model import Document
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.exchange.import_file import read_drawing
from bozzetto.geometry import Mesh
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.testing import same
from bozzetto.view import Rays
from bozzetto.workbench.workbench import Workbench
from bozzetto_silhouette.inflation.manifold_check import topology_of, volume_of
from bozzetto_silhouette.solids.draft import draft_of
from bozzetto_silhouette.solids.evaluate import tree_body

INKS = sorted((Path(__file__).parents[3] / "docs" / "gallery").glob("*.json"))
HANDLES = {"cup": 1, "chair": 2, "creature": 0, "face": 0, "fish": 0}
"""Genus: the ring of the cup's handle; the chair's back, and the part of it above the rail.
The tree's branches and crowns may touch or not."""


@pytest.mark.slow
@pytest.mark.parametrize("path", INKS, ids=lambda path: path.stem)
def test_ink_becomes_a_sound_solid_and_a_document(path: Path, tmp_path: Path) -> None:
    bench = Workbench(Registry())
    model = bench.sources.from_drawing(
        "bozzetto.silhouette", read_drawing(path), {"resolution": 40}
    )
    for resolution in (40, 64, 80, 128):
        state = replace(model.state, resolution=resolution)
        body = bench.solve(replace(model, state=state), Job()).body
        found = topology_of(body.vertices, body.faces)
        assert found.watertight
        assert found.components == 1
        assert volume_of(body.vertices, body.faces) > 0.0
        assert found.genus == HANDLES.get(path.stem, found.genus)
    write_document(Document((model,)), tmp_path / "x.bozz")
    opened, report = read_document(tmp_path / "x.bozz", bench.registry)
    assert not report.warnings
    assert same(opened.models[0].state, model.state)


def test_there_are_six() -> None:
    assert {path.stem for path in INKS} == {"creature", "cup", "tree", "fish", "chair", "face"}


@pytest.mark.parametrize("stem", ["creature", "cup", "face"])
def test_what_is_seen_of_a_draft_is_the_solid(stem: str) -> None:
    path = next(path for path in INKS if path.stem == stem)
    bench = Workbench(Registry())
    model = bench.sources.from_drawing(
        "bozzetto.silhouette", read_drawing(path), {"resolution": 48}
    )
    state = replace(model.state, selected="")
    solid, (draft, _) = tree_body(state, 48), draft_of(state, 48)
    assert solid is not None
    assert draft is not None
    low, high = solid.bounds
    for axis in range(3):
        across = [k for k in range(3) if k != axis]
        sides = (np.linspace(low[k], high[k], 60) + 0.01 for k in across)
        origins, ways = np.zeros((3600, 3)), np.zeros((3600, 3))
        origins[:, across] = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
        origins[:, axis], ways[:, axis] = high[axis] + 50.0, -1.0
        one, other = (
            cast_rays(
                Scene((Layer("s", (Shaded(Mesh(b.vertices.astype(np.float32), b.faces)),)),)),
                Rays(origins, ways),
            )
            for b in (solid, draft.body)
        )
        assert (one.hit != other.hit).mean() < 0.005
        both = one.hit & other.hit
        gap = np.abs(one.points[both] - other.points[both]).max(axis=1)
        cell = float((high - low).max()) / 48.0
        assert np.quantile(gap, 0.97) < 0.5 * cell  # only fillets are not evened out
