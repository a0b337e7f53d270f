"""The window for tests of plugins: the fixture `window`, loaded by pytest with the program.

`WindowShell` is the type of the fixture::

    from bozzetto_app.testing import WindowShell

    def test_a_ribbon_is_drawn(window: WindowShell, pen: Pen) -> None: ...
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto_app.testing.window_shell import WindowShell as WindowShell
else:
    __getattr__, __all__ = lazy_names(
        __name__, {"bozzetto_app.testing.window_shell": "WindowShell"}
    )
