"""Module sources stay unread: PySide otherwise reads each module that is imported after it."""

from __future__ import annotations

import sys

__all__ = ["leave_module_sources_unread"]


def leave_module_sources_unread() -> None:
    """Keep PySide from searching the source of every imported module for its own name.

    It does so to know where ``from __feature__ import snake_case`` may have a meaning
    (PYSIDE-2029); a third of the time that imports take goes there, and `linecache` keeps every
    source. Nothing here switches these features, so that each module is told to be one without,
    which is what PySide finds for a module that uses it. Without effect if its internals are not
    what is expected. To be called before anything else imports modules of ours.
    """
    import PySide6.QtCore  # noqa: F401  (puts the search in place)

    feature = sys.modules.get("shibokensupport.feature")
    if feature is not None and hasattr(feature, "_mod_uses_pyside"):
        vars(feature)["_mod_uses_pyside"] = lambda module: True
