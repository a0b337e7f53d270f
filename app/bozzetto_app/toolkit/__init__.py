"""Widgets for the panels of plugins. Imports Qt, so only the module of the panel may name it."""

from bozzetto_app.toolkit.panel_scroll import PanelScroll as PanelScroll
from bozzetto_app.toolkit.panel_worker import PanelWorker as PanelWorker
from bozzetto_app.toolkit.sheet_palette import palette_of as palette_of

__all__ = ["PanelScroll", "PanelWorker", "palette_of"]
