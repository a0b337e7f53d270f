"""Fixtures for tests of modelers, loaded by pytest wherever the program is installed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from bozzetto.document.model import Document
    from bozzetto.testing.headless_shell import Shell
    from bozzetto.testing.synthetic_pen import Pen

pytest.register_assert_rewrite("bozzetto.testing.contract")


OURS = {"bozzetto", "bozzetto_app"}
"""Packages in which no assertion is a test's."""


def pytest_configure(config: pytest.Config) -> None:
    """Make the mark known that the slow articles of the contract bear.

    For the fixtures' sake pytest would parse the whole program to rewrite its assertions, in the
    program's threads, too, where Python 3.11 fails at it now and then (CPython issue 106905). There
    is no public way to refuse.
    """
    config.addinivalue_line("markers", "slow: takes many seconds")
    marked: set[str] = getattr(config.pluginmanager.rewrite_hook, "_must_rewrite", set())
    marked -= OURS


@pytest.fixture
def pen() -> Pen:
    """Provide a steady pen on a canvas of 1200 × 900 px in front view; see `Pen`."""
    from bozzetto.testing.synthetic_pen import Pen

    return Pen()


@pytest.fixture
def document() -> Document:
    """Provide an empty document."""
    from bozzetto.document.model import Document

    return Document()


@pytest.fixture
def shell(tmp_path: Path) -> Shell:
    """Provide the program without its window, with all installed plugins; see `Shell`."""
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.testing.headless_shell import Shell

    return Shell(Registry(), tmp_path)
