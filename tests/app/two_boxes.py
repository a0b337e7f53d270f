"""Two plugins of boxes, each with two tools that a test can make refuse, fail or hang."""

from __future__ import annotations

import importlib
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bozzetto.errors import UserError
from tests.app import troublemaker
from tests.app.troublemaker import Boxes, DrawBox

FIRST, SECOND = troublemaker.MODELER, "spare.boxes"
MODELERS = (FIRST, SECOND)
TOOLS = ("draw", "trace")

REFUSAL = "The box crosses itself at the marked place. Draw it again."
PLACE = (500.0, 360.0)


class Trace(DrawBox):
    """The second tool; it does what the first one does."""

    id, title = "trace", "Trace"


class MoodyBoxes(Boxes):
    """Boxes whose tools do what `mood` says.

    Attributes
    ----------
    mood : {"well", "refuse", "raise", "garbage", "hang"}
    gate : Event
        What hangs goes on when it is set.
    """

    def __init__(self, name: str) -> None:
        super().__init__()
        self.id = name
        self.mood = "well"
        self.gate = threading.Event()

    def tools(self):
        return DrawBox(self), Trace(self)

    def do(self, what, well, *arguments):
        self.calls[what] += 1
        if what != "apply" or self.mood == "well":
            return well()
        if self.mood == "refuse":
            raise UserError(REFUSAL, places=[PLACE])
        if self.mood == "raise":
            raise ValueError("half a thing")
        if self.mood == "hang":
            self.gate.wait(60)
        return "a state, surely"


@contextmanager
def two_boxes(folder: Path) -> Iterator[tuple[MoodyBoxes, MoodyBoxes, list[str]]]:
    """The two modelers, and the packages that bring them to a registry."""
    packages = []
    modelers = tuple(map(MoodyBoxes, MODELERS))
    sys.path.insert(0, str(folder))
    manifest = troublemaker.MANIFEST
    try:
        for place, modeler in enumerate(modelers):
            package = f"moody_{place}_{folder.name.replace('-', '_')}"
            owner = modeler.id.partition(".")[0]
            troublemaker.MANIFEST = manifest.replace("trouble.", f"{owner}.")
            troublemaker.write_package(folder, package)
            importlib.invalidate_caches()
            importlib.import_module(package).given.append(modeler)
            packages.append(package)
        yield *modelers, packages
    finally:
        troublemaker.MANIFEST = manifest
        sys.path.remove(str(folder))
        for modeler in modelers:
            modeler.gate.set()
        for package in packages:
            sys.modules.pop(package, None)
