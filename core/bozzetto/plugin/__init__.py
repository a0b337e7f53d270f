"""The public contract: everything that a plugin may use beside the other rooms of the core.

A plugin imports from here, from `bozzetto.ink`, `bozzetto.view`, `bozzetto.geometry`,
`bozzetto.scene` and `bozzetto.errors`; nothing else of the program is promised to stay.
"""

from __future__ import annotations

from bozzetto.errors import Cancelled, Unfinished, UserError
from bozzetto.parameters import Parameter
from bozzetto.plugin.cache import Memory
from bozzetto.plugin.cautions import Caution, Warns
from bozzetto.plugin.commands import Command, HasCommands
from bozzetto.plugin.context import Context, PenSettings
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.hooks import hookimpl
from bozzetto.plugin.job import Job
from bozzetto.plugin.modeler import (
    Aims,
    Modeler,
    OffersCurves,
    ReadsDrawings,
    ReadsShapes,
    Reports,
    TakesPictures,
    TellsNext,
    Tool,
)
from bozzetto.plugin.panel import PanelHost
from bozzetto.plugin.parts import (
    HasParts,
    ReleasesParts,
    switched_on,
    unused_id,
    unused_name,
    with_part,
)
from bozzetto.plugin.view_advice import AdvisesView, MovesView, ViewAdvice

__all__ = [
    "API_VERSION",
    "AdvisesView",
    "Aims",
    "Cancelled",
    "Caution",
    "Command",
    "Context",
    "Drag",
    "Gesture",
    "HasCommands",
    "HasParts",
    "Ink",
    "Job",
    "Memory",
    "Modeler",
    "MovesView",
    "OffersCurves",
    "PanelHost",
    "Parameter",
    "PenSettings",
    "ReadsDrawings",
    "ReadsShapes",
    "ReleasesParts",
    "Reports",
    "TakesPictures",
    "Tap",
    "TellsNext",
    "Tool",
    "Unfinished",
    "UserError",
    "ViewAdvice",
    "Warns",
    "hookimpl",
    "switched_on",
    "unused_id",
    "unused_name",
    "with_part",
]

API_VERSION = (1, 4)
"""Version of this contract: a plugin's manifest names the range it was written for."""
