"""What has the accent colour is what the next key changes: nothing of an object not selected."""

from __future__ import annotations

import pytest

from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.workbench.workbench import Workbench

SAMPLES = {
    "silhouette": "fish",
    "symmetry": "boat",
    "car": "hatchback",
    "product": "remote-control",
    "polyhedron": "four-bar",
}
"""A drawing of each modeler, some of whose parts are shown in the accent colour when chosen."""

MOST = 6
"""Parts that are chosen one after the other, spread over all."""


def accents(bench, model, *, selected):
    """Return the layers of items in the accent colour that are seen of a model."""
    scene = bench.model_scene(model, bench.solve(model, Job()))
    return sorted(
        layer.name
        for layer, item in scene.items()
        if getattr(item, "color", None) == "accent"
        and not layer.tool
        and (selected or not layer.chosen)
    )


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=pytest.mark.slow) if one == "product" else one for one in SAMPLES],
)
def test_the_chosen_part_is_in_the_accent_colour_only_while_its_object_is_selected(name):
    told = 0
    bench, modeler = Workbench(Registry()), f"bozzetto.{name}"
    samples = bench.registry.info(modeler).samples
    path = next(path for path in samples if path.stem == SAMPLES[name])
    model = bench.sources.from_drawing(modeler, read_drawing(path, trusted=True), {})
    parts = bench.parts.of(model).parts
    none = accents(bench, bench.parts.select(model, ""), selected=False)
    for part in parts[:: max(1, len(parts) // MOST)]:
        chosen = bench.parts.select(model, part.id)
        assert accents(bench, chosen, selected=False) == none, part.name
        told += len(accents(bench, chosen, selected=True)) > len(none)
    assert told or name == "car"  # no styling curve was drawn on this one
