"""A workbench with the linked boxes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.workbench import Workbench
from tests import linked_boxes, plugin_package


@pytest.fixture
def boxes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[linked_boxes.Boxes]:
    """The modeler in a package of its own; `boxes.package` is its name."""
    with plugin_package.imported(
        linked_boxes, linked_boxes.Boxes(), tmp_path, monkeypatch
    ) as modeler:
        yield modeler


@pytest.fixture
def bench(boxes: linked_boxes.Boxes) -> Workbench:
    return Workbench(Registry(extra=[boxes.package]))
