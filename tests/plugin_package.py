"""Packages of modelers that tests make up: written into a folder, and imported from there."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

CODE = """
from bozzetto.plugin import hookimpl

given = []

@hookimpl
def bozzetto_modelers():
    return given
"""

ICON = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 20 20"><path d="M2 2h16"/></svg>'


def write(folder: Path, name: str, manifest: str, code: str = CODE) -> None:
    """Write a package without its modeler, which is put into `given` once it is imported."""
    package = folder / name
    package.mkdir(parents=True)
    (package / "__init__.py").write_text(code)
    (package / "icon.svg").write_text(ICON)
    (package / "plugin.toml").write_text(manifest)


def fixture_of(source: str, modeler: str) -> Any:
    """A fixture: a new modeler of a module, in a package of its own.

    Parameters
    ----------
    source : str
        The module, which has a `MANIFEST`, and `CODE` of its package if that is not the usual one;
        it is imported when a test asks for the modeler.
    modeler : str
        Its class of modelers.
    """

    @pytest.fixture
    def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
        module = importlib.import_module(source)
        with imported(module, getattr(module, modeler)(), tmp_path, monkeypatch) as one:
            yield one

    return made


@contextmanager
def imported(source: ModuleType, modeler: Any, tmp_path: Path, monkeypatch: Any) -> Iterator[Any]:
    """The modeler in a package of its own, described by `source`; `modeler.package` is its name."""
    package = f"made_up_{source.__name__.rpartition('.')[2]}_{tmp_path.name.replace('-', '_')}"
    write(tmp_path / "packages", package, source.MANIFEST, getattr(source, "CODE", CODE))
    monkeypatch.syspath_prepend(tmp_path / "packages")
    importlib.invalidate_caches()
    importlib.import_module(package).given.append(modeler)
    modeler.package = package
    yield modeler
    sys.modules.pop(package, None)
