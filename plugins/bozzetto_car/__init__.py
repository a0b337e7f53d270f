"""The car modeler: from a sketch and a few marks to a styled body that CAD opens exactly."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bozzetto.plugin import Modeler, hookimpl


@hookimpl
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:
    """The one modeler of this plugin."""
    from bozzetto_car.modeler import Car

    return [Car()]


@hookimpl
def bozzetto_faults(file: Path) -> Sequence[str] | None:
    """What is wrong with a car's template."""
    from bozzetto_car.template_file import faults_in, is_template

    return faults_in(file) if is_template(file) else None
