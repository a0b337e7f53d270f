"""Strokes refuse what no document could keep, before anybody draws on."""

from __future__ import annotations

import pytest

from bozzetto.errors import UserError
from bozzetto.ink.stroke import Stroke
from bozzetto.view.camera import Camera


@pytest.mark.parametrize(
    "facts",
    [
        {"tool": "axe"},
        {"color": (0, 0, 256)},
        {"color": (0, -1, 0)},
        {"color": (0, 0)},
        {"group": "x" * 1001},
        {"group": "\ud800"},
    ],
)
def test_facts_that_cannot_be_kept_are_refused(facts):
    with pytest.raises(UserError):
        Stroke([1.0], [2.0], Camera(), **facts)
    assert Stroke([1.0], [2.0], Camera(), tool="mouse", color=(0, 255, 9), group="rim ✎\x01")
