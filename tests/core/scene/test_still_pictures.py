"""Pictures of a scene show nothing that is there for the hand only."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry import Mesh
from bozzetto.scene import Handle, Layer, Lines, Scene, Shaded
from bozzetto.scene.snapshot import picture, thumbnail

BOX = Shaded(
    Mesh(
        np.array([(0, 0, 0), (40, 0, 0), (0, 0, 40), (0, 40, 0)], np.float32),
        np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)], np.int32),
    )
)
INK = Layer("ink", (Lines([(0, 0, 0), (60, 0, 60)]),))
HANDLE = Handle("move", (20, 0, 20))
RING = Lines([(-400, 0, 0), (400, 0, 0), (0, 0, 400)])


@pytest.mark.parametrize(
    "layers",
    [
        (Layer("shape", (BOX,)), INK, Layer("any name", (RING, HANDLE))),
        (Layer("shape", (BOX, HANDLE)), INK),
    ],
    ids=["a layer of handles", "a handle beside a surface"],
)
def test_handles_are_left_out(layers) -> None:
    bare = Scene((Layer("shape", (BOX,)), INK))
    assert np.array_equal(thumbnail(Scene(layers), 96), thumbnail(bare, 96))
    assert np.array_equal(picture(Scene(layers), size=(90, 60)), picture(bare, size=(90, 60)))


def test_ink_alone_is_shown() -> None:
    assert (thumbnail(Scene((INK,)), 64)[..., :3] != thumbnail(Scene(), 64)[..., :3]).any()
