"""A workbench with the linked boxes."""

from __future__ import annotations

import pytest

from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.workbench import Workbench
from tests import linked_boxes, plugin_package

boxes = plugin_package.fixture_of("tests.linked_boxes", "Boxes")


@pytest.fixture
def bench(boxes: linked_boxes.Boxes) -> Workbench:
    return Workbench(Registry(extra=[boxes.package]))
