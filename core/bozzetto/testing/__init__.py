"""The test kit for authors of modelers.

Installed with the program as a pytest plugin: the fixtures `pen`, `document` and `shell` are
there in every test, and a class that derives from `ModelerContract` runs the whole contract
suite against the modeler it names::

    from bozzetto.testing import ModelerContract

    class TestRibbon(ModelerContract):
        modeler = "author.ribbon"
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bozzetto.testing.contract import ModelerContract
    from bozzetto.testing.deep_equal import same
    from bozzetto.testing.headless_shell import Shell
    from bozzetto.testing.synthetic_pen import Pen

__all__ = ["ModelerContract", "Pen", "Shell", "same"]

_WHERE = {
    "ModelerContract": "contract",
    "Pen": "synthetic_pen",
    "Shell": "headless_shell",
    "same": "deep_equal",
}


def __getattr__(name: str) -> Any:
    # Every pytest run imports this package: what is not used must not cost anything.
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
