"""The public contract: everything that a plugin may use beside the other rooms of the core.

A plugin imports from here, from `bozzetto.ink`, `bozzetto.view`, `bozzetto.geometry`,
`bozzetto.scene` and `bozzetto.errors`, each exactly at that level; nothing else of the program is
promised to stay. (`bozzetto.geometry.patches` and `bozzetto.view.calibration` are doors too.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

API_VERSION = (2, 4)
"""Version of this contract: a plugin's manifest names the range it was written for."""

if TYPE_CHECKING:
    from typing_extensions import override as override

    from bozzetto.cached_properties import cached_property as cached_property
    from bozzetto.errors import Cancelled as Cancelled
    from bozzetto.errors import Unfinished as Unfinished
    from bozzetto.errors import UserError as UserError
    from bozzetto.parameters import Parameter as Parameter
    from bozzetto.plugin.cache import Remembered as Remembered
    from bozzetto.plugin.cache import remembered as remembered
    from bozzetto.plugin.cautions import Caution as Caution
    from bozzetto.plugin.commands import Command as Command
    from bozzetto.plugin.context import Context as Context
    from bozzetto.plugin.context import PenSettings as PenSettings
    from bozzetto.plugin.figures import Figure as Figure
    from bozzetto.plugin.gesture import Drag as Drag
    from bozzetto.plugin.gesture import Gesture as Gesture
    from bozzetto.plugin.gesture import Ink as Ink
    from bozzetto.plugin.gesture import Tap as Tap
    from bozzetto.plugin.hooks import hookimpl as hookimpl
    from bozzetto.plugin.host.listing import TemplateFile as TemplateFile
    from bozzetto.plugin.job import Job as Job
    from bozzetto.plugin.modeler import Modeler as Modeler
    from bozzetto.plugin.next_step import NextStep as NextStep
    from bozzetto.plugin.panel import PanelHost as PanelHost
    from bozzetto.plugin.parts import Group as Group
    from bozzetto.plugin.parts import Part as Part
    from bozzetto.plugin.parts import PartsModeler as PartsModeler
    from bozzetto.plugin.parts import PartsState as PartsState
    from bozzetto.plugin.tool import Preview as Preview
    from bozzetto.plugin.tool import Tool as Tool
    from bozzetto.plugin.view_advice import ViewAdvice as ViewAdvice
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.cached_properties": "cached_property",
            "bozzetto.errors": "Cancelled Unfinished UserError",
            "bozzetto.parameters": "Parameter",
            "bozzetto.plugin.cache": "Remembered remembered",
            "bozzetto.plugin.cautions": "Caution",
            "bozzetto.plugin.commands": "Command",
            "bozzetto.plugin.context": "Context PenSettings",
            "bozzetto.plugin.figures": "Figure",
            "bozzetto.plugin.gesture": "Drag Gesture Ink Tap",
            "bozzetto.plugin.hooks": "hookimpl",
            "bozzetto.plugin.host.listing": "TemplateFile",
            "bozzetto.plugin.job": "Job",
            "bozzetto.plugin.modeler": "Modeler",
            "bozzetto.plugin.next_step": "NextStep",
            "bozzetto.plugin.panel": "PanelHost",
            "bozzetto.plugin.parts": "Group Part PartsModeler PartsState",
            "bozzetto.plugin.tool": "Preview Tool",
            "bozzetto.plugin.view_advice": "ViewAdvice",
            "typing_extensions": "override",
        },
    )
    __all__ += ("API_VERSION",)
