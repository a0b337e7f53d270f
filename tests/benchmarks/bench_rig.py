"""A horse of thirty thousand vertices: its rig, its skin, and a joint under the pen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bozzetto.exchange.import_file import read_drawing
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Job
from bozzetto.view import Camera
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.rigging.armature import armature_of
from bozzetto_silhouette.rigging.posing import posed_scene, rig_of
from bozzetto_silhouette.rigging.skinning import followed
from tests.benchmarks.bench_silhouette import SAMPLES
from tests.benchmarks.timing import Row, median_ms, processor_ms

RESOLUTION = 208
"""Cells at which the horse has about thirty thousand vertices."""


def rows() -> Iterator[Row]:
    """Weights of a new shape, and one pen event while posing."""
    modeler = Silhouette()
    drawing = read_drawing(SAMPLES / "horse.json")
    state = replace(
        modeler.read_drawing(drawing, Context(), Job()), resolution=RESOLUTION, posing=True
    )
    body = modeler.solve(state, Job()).body
    armature, rig = armature_of(state), rig_of(state)
    assert body is not None
    assert armature is not None
    assert rig is not None
    count = f"{len(body.vertices) / 1000:.0f}k vertices, {len(rig.joints)} joints"
    taken = processor_ms(lambda: followed(armature, body))
    yield Row("rig", f"Skin weights, {count}, processor time", taken, "ms", "150 ms")

    camera = Camera()
    end = int(np.argmin(rig.joints[:, 2]))
    ((x, y),) = camera.project(rig.joints[[end]])[0]
    path = Stroke(np.linspace(x, x + 40, 9), np.linspace(y, y - 40, 9), camera)
    drag = Drag(f"joint:{end}", path)
    taken = median_ms(lambda: posed_scene(state, drag))
    yield Row("rig", f"A joint dragged, per pen event, {count}", taken, "ms", "33 ms")
