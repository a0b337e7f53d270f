"""Packages that import their names late offer what type checkers see, and nothing else."""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path

import pytest

LAZY = (
    "geometry",
    "geometry.patches",
    "ink",
    "plugin",
    "scene",
    "scene.renderer",
    "testing",
    "view",
)


def seen_by_type_checkers(package):
    """Names that the package imports for type checkers, each with its module."""
    tree = ast.parse(Path(package.__file__).read_text(encoding="utf-8"))
    found = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {
        name.name: node.module for node in found for name in node.names if name.asname == name.name
    }


@pytest.mark.parametrize("name", LAZY)
def test_names_are_those_of_their_modules(name):
    package = import_module(f"bozzetto.{name}")
    names = seen_by_type_checkers(package)
    assert set(package.__all__) - {"API_VERSION"} == set(names)
    for public, module in names.items():
        assert getattr(package, public) is getattr(import_module(module), public)


def test_other_names_are_refused_as_usual():
    package = import_module("bozzetto.ink")
    with pytest.raises(AttributeError, match=r"module 'bozzetto\.ink' has no attribute 'Strike'"):
        package.Strike  # noqa: B018
    with pytest.raises(ImportError):
        from bozzetto.ink import Strike  # noqa: F401
