"""A workbench with the linked boxes."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.workbench import Workbench
from tests import linked_boxes


@pytest.fixture
def boxes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[linked_boxes.Boxes]:
    """The modeler in a package of its own; `boxes.package` is its name."""
    package = f"made_up_boxes_{tmp_path.name.replace('-', '_')}"
    linked_boxes.write_package(tmp_path / "packages", package)
    monkeypatch.syspath_prepend(tmp_path / "packages")
    importlib.invalidate_caches()
    modeler = linked_boxes.Boxes()
    importlib.import_module(package).given.append(modeler)
    modeler.package = package
    yield modeler
    sys.modules.pop(package, None)


@pytest.fixture
def bench(boxes: linked_boxes.Boxes) -> Workbench:
    return Workbench(Registry(extra=[boxes.package]))
