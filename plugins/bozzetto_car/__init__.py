"""The car modeler: from a sketch and a few marks to a styled body that CAD opens exactly."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bozzetto.plugin import Modeler, PanelHost, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """Return the one modeler of this plugin."""
    from bozzetto_car.modeler import Car

    return [Car()]


@hookimpl
def bozzetto_faults(file: Path) -> Sequence[str] | None:
    """Return what is wrong with a car's template."""
    from bozzetto_car.template.loader import faults_in, is_template

    return faults_in(file) if is_template(file) else None


@hookimpl
def bozzetto_panel(modeler_id: str, parent: object, host: PanelHost) -> object:
    """Return the guide panel: the next mark, all marks, and what is known of the car."""
    from PySide6.QtWidgets import QWidget

    from bozzetto_car.panel.guide_panel import GuidePanel

    assert isinstance(parent, QWidget)
    return GuidePanel(host, parent)
