"""The public contract: everything that a plugin may use beside the other rooms of the core.

A plugin imports from here, from `bozzetto.ink`, `bozzetto.view`, `bozzetto.geometry`,
`bozzetto.scene` and `bozzetto.errors`; nothing else of the program is promised to stay.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

API_VERSION = (1, 4)
"""Version of this contract: a plugin's manifest names the range it was written for."""

if TYPE_CHECKING:
    from bozzetto.errors import Cancelled as Cancelled
    from bozzetto.errors import Unfinished as Unfinished
    from bozzetto.errors import UserError as UserError
    from bozzetto.parameters import Parameter as Parameter
    from bozzetto.plugin.cache import Memory as Memory
    from bozzetto.plugin.cautions import Caution as Caution
    from bozzetto.plugin.cautions import Warns as Warns
    from bozzetto.plugin.commands import Command as Command
    from bozzetto.plugin.commands import HasCommands as HasCommands
    from bozzetto.plugin.context import Context as Context
    from bozzetto.plugin.context import PenSettings as PenSettings
    from bozzetto.plugin.gesture import Drag as Drag
    from bozzetto.plugin.gesture import Gesture as Gesture
    from bozzetto.plugin.gesture import Ink as Ink
    from bozzetto.plugin.gesture import Tap as Tap
    from bozzetto.plugin.hooks import hookimpl as hookimpl
    from bozzetto.plugin.job import Job as Job
    from bozzetto.plugin.modeler import Aims as Aims
    from bozzetto.plugin.modeler import Modeler as Modeler
    from bozzetto.plugin.modeler import OffersCurves as OffersCurves
    from bozzetto.plugin.modeler import ReadsDrawings as ReadsDrawings
    from bozzetto.plugin.modeler import ReadsShapes as ReadsShapes
    from bozzetto.plugin.modeler import Reports as Reports
    from bozzetto.plugin.modeler import TakesPictures as TakesPictures
    from bozzetto.plugin.modeler import TellsNext as TellsNext
    from bozzetto.plugin.modeler import Tool as Tool
    from bozzetto.plugin.panel import PanelHost as PanelHost
    from bozzetto.plugin.parts import HasParts as HasParts
    from bozzetto.plugin.parts import ReleasesParts as ReleasesParts
    from bozzetto.plugin.parts import switched_on as switched_on
    from bozzetto.plugin.parts import unused_id as unused_id
    from bozzetto.plugin.parts import unused_name as unused_name
    from bozzetto.plugin.parts import with_part as with_part
    from bozzetto.plugin.view_advice import AdvisesOnResults as AdvisesOnResults
    from bozzetto.plugin.view_advice import AdvisesView as AdvisesView
    from bozzetto.plugin.view_advice import MovesView as MovesView
    from bozzetto.plugin.view_advice import ViewAdvice as ViewAdvice
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.errors": "Cancelled Unfinished UserError",
            "bozzetto.parameters": "Parameter",
            "bozzetto.plugin.cache": "Memory",
            "bozzetto.plugin.cautions": "Caution Warns",
            "bozzetto.plugin.commands": "Command HasCommands",
            "bozzetto.plugin.context": "Context PenSettings",
            "bozzetto.plugin.gesture": "Drag Gesture Ink Tap",
            "bozzetto.plugin.hooks": "hookimpl",
            "bozzetto.plugin.job": "Job",
            "bozzetto.plugin.modeler": "Aims Modeler OffersCurves ReadsDrawings ReadsShapes "
            "Reports TakesPictures TellsNext Tool",
            "bozzetto.plugin.panel": "PanelHost",
            "bozzetto.plugin.parts": "HasParts ReleasesParts switched_on unused_id unused_name "
            "with_part",
            "bozzetto.plugin.view_advice": "AdvisesOnResults AdvisesView MovesView ViewAdvice",
        },
    )
    __all__ += ("API_VERSION",)
