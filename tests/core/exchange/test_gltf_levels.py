"""Levels of detail in one GLB: fewer and fewer triangles of the same parts (MSFT_lod)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.geometry import Shapes
from tests.core.exchange.skinned import skinned
from tests.core.exchange.test_handover import ball, spread
from tests.core.exchange.test_skins import opened


def parts():
    one = replace(skinned(5, 40.0, turned=True), groups=())
    mesh = ball()
    from bozzetto.geometry import Solid

    return Shapes(solids=(one, Solid(mesh, "ball", texture=spread(mesh))))


def triangles(gltf, values, node):
    mesh = gltf["meshes"][gltf["nodes"][node]["mesh"]]
    return sum(gltf["accessors"][one["indices"]]["count"] // 3 for one in mesh["primitives"])


def test_each_part_has_two_coarser_levels_in_the_same_place():
    gltf, values = opened(prepare_export(parts(), "a.glb", handover=Handover(levels=True)).data)
    assert gltf["extensionsUsed"] == ["MSFT_lod"]
    for node in (0, 1):
        levels = [node, *gltf["nodes"][node]["extensions"]["MSFT_lod"]["ids"]]
        counts = [triangles(gltf, values, level) for level in levels]
        assert counts[1] <= 0.3 * counts[0]
        assert counts[2] <= 0.3 * counts[1]
        assert len(gltf["nodes"][node]["extras"]["MSFT_screencoverage"]) == 3
        boxes = [
            gltf["accessors"][
                gltf["meshes"][gltf["nodes"][level]["mesh"]]["primitives"][0]["attributes"][
                    "POSITION"
                ]
            ]
            for level in levels
        ]
        size = max(np.subtract(boxes[0]["max"], boxes[0]["min"]))
        for box in boxes[1:]:
            np.testing.assert_allclose(box["min"], boxes[0]["min"], atol=0.15 * size)
            np.testing.assert_allclose(box["max"], boxes[0]["max"], atol=0.15 * size)
    skins = [gltf["nodes"][k].get("skin") for k in range(2, len(gltf["nodes"]))]
    assert skins.count(0) == 2  # the levels of the worm follow its bones
    shown = gltf["scenes"][0]["nodes"]
    ids = {k for node in gltf["nodes"] for k in
           node.get("extensions", {}).get("MSFT_lod", {}).get("ids", [])}  # fmt: skip
    assert not ids & set(shown)
    assert len(gltf["images"]) == 1


def test_levels_are_read_as_one_and_told(tmp_path):
    made = prepare_export(parts(), "a.glb", handover=Handover(levels=True))
    (tmp_path / "a.glb").write_bytes(made.data)
    read = read_mesh_file(tmp_path / "a.glb", trusted=True)
    assert [part.name for part in read.shapes.meshes()] == ["worm", "ball"]
    assert "coarser levels of 2 parts" in " ".join(read.left_out)


@pytest.mark.parametrize("ending", ["obj", "stl", "ply", "3mf"])
def test_formats_of_one_level_say_so(ending):
    made = prepare_export(parts(), f"a.{ending}", handover=Handover(levels=True))
    assert "one level of detail" in " ".join(made.notes)


def test_without_the_wish_there_is_one_level():
    gltf, _ = opened(prepare_export(parts(), "a.glb").data)
    assert "extensionsUsed" not in gltf
