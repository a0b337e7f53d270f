"""Public names of a package that are imported when they are first asked for (PEP 562).

A package that imports all it offers makes everyone pay for all of it: the list of plugins would
import numpy for the sake of a scene that nobody shows.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazy_names(
    package: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], Any], tuple[str, ...]]:
    """Return what a package needs to import its public names late.

    Parameters
    ----------
    package : str
        ``__name__`` of the package.
    modules : mapping of str to str
        Full names of modules, each with the public names that it holds, divided by blanks.

    Returns
    -------
    callable, tuple of str
        ``__getattr__`` and ``__all__`` of the package.
    """
    homes = {name: module for module, names in modules.items() for name in names.split()}

    def find(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(homes[name]), name)
        setattr(sys.modules[package], name, value)  # the next one finds it without asking here
        return value

    return find, tuple(sorted(homes))
