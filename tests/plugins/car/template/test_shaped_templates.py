"""The templates that `docs/write_car_templates.py` writes: their files are what it says."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from bozzetto_car.template.loader import PAPER_TEMPLATES, TEMPLATES, bundled_file
from tests.plugins.car.drawn_cars import in_docs

SHAPED = [name for name in TEMPLATES if name not in PAPER_TEMPLATES]


def without_edges(file: bytes) -> dict[str, Any]:
    told: dict[str, Any] = json.loads(file)
    return {key: value for key, value in told.items() if key != "edges"}


@pytest.mark.parametrize("name", SHAPED)
def test_the_file_is_what_the_script_writes(name: str) -> None:
    """All words and places; tangents but for rounding on another machine."""
    made, kept = in_docs("write_car_templates").template_of(name), bundled_file(name)
    assert without_edges(made) == without_edges(kept)
    edges, others = (json.loads(file)["edges"] for file in (made, kept))
    assert list(edges) == list(others)
    for key, tangents in edges.items():
        np.testing.assert_allclose(tangents, others[key], atol=1e-3, err_msg=key)
