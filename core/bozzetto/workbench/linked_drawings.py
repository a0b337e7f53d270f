"""Drawings on the surfaces of other objects, which their files name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from bozzetto.errors import UserError
from bozzetto.ink.drawing import MODELER_FACT
from bozzetto.ink.file_values import an_object
from bozzetto.ink.steps import DrawStep

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.ink.drawing import Drawing
    from bozzetto.plugin.job import Job
    from bozzetto.plugin.tool import Tool
    from bozzetto.workbench.workbench import Workbench

ON_FACT: Final = "on"
"""The fact that names what a drawing is drawn on."""

SHAPES: Final = ("template", "box")
"""Facts that say what else is drawn on."""

MOST: Final = 16
"""Objects that one drawing is drawn on."""


def models_drawn_on(bench: Workbench, drawing: Drawing, job: Job) -> tuple[Model, ...]:
    """Make the models that a drawing's file says it is drawn on; none where it says nothing.

    The fact is `{"drawing": {"file": "head.json"}}`, or a list of such; each file says with which
    modeler it was drawn. An object is called by `"name"`, by default like its file.

    Raises
    ------
    UserError
        If one of them is not there, or does not say with which modeler it was drawn.
    """
    told = drawing.facts.get(ON_FACT, [])
    entries = told if isinstance(told, list) else [told]
    if len(entries) > MOST:
        raise UserError(f"“{ON_FACT}” names {len(entries)} drawings; {MOST} at most can be.")
    made = []
    for entry in entries:
        file, name = _named_in(an_object(entry, ON_FACT))
        ink = drawing.drawings.get(file)
        if ink is None:
            raise UserError(f"The drawing “{file}” is not there. Put it beside the file.")
        modeler = ink.facts.get(MODELER_FACT)
        if not isinstance(modeler, str):
            raise UserError(
                f"“{file}” does not say with which modeler it was drawn. Put “{MODELER_FACT}” in "
                "it."
            )
        if ON_FACT in ink.facts:
            raise UserError(f"“{file}” is drawn on another object itself. Name that one.")
        modeler_id = bench.registry.resolve(modeler)
        made.append(bench.sources.from_drawing(modeler_id, replace(ink, name=name), {}, job=job))
    return tuple(made)


def _named_in(entry: Mapping[str, Any]) -> tuple[str, str]:
    """Return the file that an entry names, and the name of the object."""
    unknown = sorted(set(map(str, entry)) - {"drawing", "name"})
    if unknown:
        raise UserError(f"“{ON_FACT}” has a key “{unknown[0][:40]}”. Known are drawing, name.")
    named = an_object(entry.get("drawing"), f"{ON_FACT}.drawing")
    file = named.get("file")
    if not isinstance(file, str):
        raise UserError(f"“{ON_FACT}.drawing.file” is the name of a drawing.")
    name = entry.get("name", file.rpartition("/")[2].rpartition(".")[0])
    if not isinstance(name, str) or not name.strip():
        raise UserError(f"“{ON_FACT}.name” is a text.")
    return file, name


def with_steps(drawing: Drawing, tools: Sequence[Tool[Any]]) -> Drawing:
    """Return a drawing with steps: without them its curves are drawn one after the other.

    Strokes of one curve are one gesture of the first tool that takes ink, and so is each other
    stroke.
    """
    if drawing.steps:
        return drawing
    tool = next((each.id for each in tools if each.gesture == "ink"), "")
    if not tool or not len(drawing.strokes):
        raise UserError(f"“{drawing.name}” has no strokes to draw on another object.")
    return replace(drawing, steps=tuple(DrawStep(tool, places) for places in _curves(drawing)))


def _curves(drawing: Drawing) -> Iterator[tuple[int, ...]]:
    groups: dict[object, list[int]] = {}
    for number, stroke in enumerate(drawing.strokes):
        groups.setdefault(stroke.group or number, []).append(number)
    yield from map(tuple, groups.values())
