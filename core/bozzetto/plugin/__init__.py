"""The public contract: everything that a plugin may use beside the other rooms of the core.

A plugin imports from here, from `bozzetto.ink`, `bozzetto.view`, `bozzetto.geometry`,
`bozzetto.scene` and `bozzetto.errors`; nothing else of the program is promised to stay.
"""

from __future__ import annotations

from bozzetto.errors import Cancelled, Unfinished, UserError
from bozzetto.plugin.context import Context, PenSettings
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.hooks import hookimpl
from bozzetto.plugin.job import Job
from bozzetto.plugin.memory import Memory
from bozzetto.plugin.modeler import Modeler, ReadsDrawings, ReadsShapes, Reports, Tool
from bozzetto.plugin.panel import PanelHost
from bozzetto.plugin.parameters import Parameter
from bozzetto.plugin.parts import HasParts, switched_on

__all__ = [
    "API_VERSION",
    "Cancelled",
    "Context",
    "Drag",
    "Gesture",
    "HasParts",
    "Ink",
    "Job",
    "Memory",
    "Modeler",
    "PanelHost",
    "Parameter",
    "PenSettings",
    "ReadsDrawings",
    "ReadsShapes",
    "Reports",
    "Tap",
    "Tool",
    "Unfinished",
    "UserError",
    "hookimpl",
    "switched_on",
]

API_VERSION = (1, 1)
"""Version of this contract: a plugin's manifest names the range it was written for."""
