"""The test kit for authors of modelers.

Installed with the program as a pytest plugin: the fixtures `pen`, `document` and `shell` are
there in every test, and a class that derives from `ModelerContract` runs the whole contract
suite against the modeler it names::

    from bozzetto.testing import ModelerContract

    class TestRibbon(ModelerContract):
        modeler = "author.ribbon"
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.testing.contract import ModelerContract as ModelerContract
    from bozzetto.testing.deep_equal import same as same
    from bozzetto.testing.headless_shell import Shell as Shell
    from bozzetto.testing.synthetic_pen import Pen as Pen
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.testing.contract": "ModelerContract",
            "bozzetto.testing.deep_equal": "same",
            "bozzetto.testing.headless_shell": "Shell",
            "bozzetto.testing.synthetic_pen": "Pen",
        },
    )
