"""The small picture in a document's file: made beside the save, and left out where it is late.

No picture, and no plugin that has a say in it, may come between a person and their file.
"""

from __future__ import annotations

import logging
import threading
from typing import TYPE_CHECKING, Final

from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.scene.display_list import Scene

if TYPE_CHECKING:
    from bozzetto.document.model import Document
    from bozzetto.workbench.workbench import Workbench

__all__ = ["SIDE", "SmallPictures"]

log = logging.getLogger(__name__)

SIDE: Final = 256
"""Of the picture that file managers show, pixels."""

PATIENCE: Final = 0.3
"""Seconds that a save waits for it."""


class SmallPictures:
    """Makes the pictures of one session's documents, one at a time."""

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench
        self._painting: threading.Thread | None = None

    def of(self, document: Document, scene: Scene) -> bytes | None:
        """Return a PNG of what is shown; None if that fails, or takes longer than `PATIENCE`."""
        if self._painting is not None and self._painting.is_alive():
            return None  # still at an earlier one
        painted: list[bytes] = []

        def paint() -> None:
            try:
                painted.append(_painted(self._bench, document, scene))
            except Exception:
                log.warning("the document's small picture could not be made", exc_info=True)

        self._painting = threading.Thread(target=paint, name="bozzetto-thumbnail", daemon=True)
        self._painting.start()
        self._painting.join(PATIENCE)
        return painted[0] if painted else None


def _painted(bench: Workbench, document: Document, scene: Scene) -> bytes:
    from bozzetto.images.png import png_bytes
    from bozzetto.scene.snapshot import framed, thumbnail

    view = framed(scene, size=(SIDE, SIDE))
    try:
        hanging = bench.advice_scene(document, view)
    except (UserError, PluginFault):  # the guard has reported it
        hanging = Scene()
    return png_bytes(thumbnail(scene.under(hanging), SIDE, camera=view))
