"""Bozzetto's core: ink, cameras, geometry, documents, pictures and the plugin contract.

Nothing here imports a widget toolkit; see ``docs/architecture.md`` for the rooms.
"""

from __future__ import annotations

from bozzetto.errors import Cancelled, DocumentError, FormatError, Unfinished, UserError

__all__ = ["Cancelled", "DocumentError", "FormatError", "Unfinished", "UserError", "__version__"]

__version__ = "0.1.0"
