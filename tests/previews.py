"""What is seen of a gesture while the pen is down, as the program asks for it."""

from __future__ import annotations

from typing import Any

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Tool
from bozzetto.plugin.gesture import Gesture
from bozzetto.scene import Scene


def preview_of(tool: Tool[Any], state: Any, gesture: Gesture, context: Context) -> Scene:
    """Return the preview of a gesture as it is by now; empty where the tool refuses it."""
    try:
        return tool.begin(state, context).update(gesture)
    except UserError:
        return Scene()
