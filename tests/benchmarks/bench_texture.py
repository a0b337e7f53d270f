"""A picture laid on a shape: colours for the screen, and the texture for files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bozzetto_silhouette
from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin import Job
from bozzetto.plugin.context import Context
from bozzetto_silhouette.appearance.picture_projection import axes_of, texel_of
from bozzetto_silhouette.appearance.surface_look import painted, texture_of
from bozzetto_silhouette.appearance.uv_charts import laid_out
from bozzetto_silhouette.model.state import Picture, SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.evaluate import tree_body
from tests.benchmarks.timing import Row, median_ms, processor_ms

DRAWING = Path(bozzetto_silhouette.__file__).parent / "samples" / "fish.json"
PIXELS = (600, 900)
"""Rows and columns of the picture: that of a drawing on a tablet."""

CELLS = 128


def rows() -> Iterator[Row]:
    """Colours of the vertices, the charts, and all of the baking."""
    drawing = read_drawing(DRAWING)
    state = Silhouette().read_drawing(drawing, Context(camera=drawing.camera), Job())
    body = tree_body(state, CELLS)
    assert body is not None
    state = _with_picture(state, body)
    picture = state.picture
    assert picture is not None
    yield Row(
        "texture", f"a picture on the vertices of the fish, {CELLS} cells",
        median_ms(lambda: painted(state, body), repeats=7), budget="≤ 50 ms",
    )  # fmt: skip
    density, axes = 1.0 / texel_of(picture), axes_of(picture)
    layout = laid_out(body.vertices, body.faces, axes, density)
    yield Row(
        "texture", f"charts of {len(body.faces):,} faces in an atlas of "
        f"{layout.size[0]} × {layout.size[1]}",
        median_ms(lambda: laid_out(body.vertices, body.faces, axes, density), repeats=5),
    )  # fmt: skip
    yield Row(
        "texture", f"the texture of the fish, picture of {PIXELS[1]} × {PIXELS[0]}",
        median_ms(lambda: texture_of(_anew(state), body), repeats=5), budget="≤ 1000 ms",
    )  # fmt: skip
    yield Row(
        "texture", "the same, processor time",
        processor_ms(lambda: texture_of(_anew(state), body), repeats=5), budget="≤ 1000 ms",
    )  # fmt: skip


def _anew(state: SilhouetteState) -> SilhouetteState:
    """What was baked before is remembered; a copy of the picture is another one."""
    assert state.picture is not None
    return replace(state, picture=replace(state.picture))


def _with_picture(state: SilhouetteState, body: Body) -> SilhouetteState:
    """The state with a picture over all of its front."""
    random = np.random.default_rng(1)
    pixels: NDArray[np.uint8] = random.integers(0, 256, (*PIXELS, 4)).astype(np.uint8)
    pixels[..., 3] = 255
    low, high = body.bounds
    size = high - low
    return replace(
        state,
        picture=Picture(
            pixels,
            (float(low[0]), 0.0, float(high[2])),
            (float(size[0]), 0.0, 0.0),
            (0.0, 0.0, -float(size[2])),
        ),
    )
