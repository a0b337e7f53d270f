"""Validation of plugins' answers: only what the program can use passes."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.document.model import ID_PATTERN
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.parameters import parameter_fields
from bozzetto.plugin.cautions import Caution
from bozzetto.plugin.commands import Command
from bozzetto.plugin.figures import Figure
from bozzetto.plugin.guard.checked_values import (
    Unsound,
    check_finite,
    check_number,
    check_text,
    check_words,
    expect,
    expect_tuple,
)
from bozzetto.plugin.guard.scene_validation import sound_scene
from bozzetto.plugin.next_step import NextStep
from bozzetto.plugin.parts import Part
from bozzetto.plugin.tool import Preview, Tool
from bozzetto.plugin.view_advice import ViewAdvice
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.plugin.part_tree import PartTree

MOST_FIRST: Final = 3
"""Parameters that a form shows before all others."""

MOST_COMMANDS: Final = 200
"""Commands of one modeler; nobody would find more in a menu."""

LARGEST_CONTENT: Final = 64 << 20
"""Bytes of a file that a command writes."""

MOST_SOURCES: Final = 1_000
"""Models that one model is made from."""


MOST_LEVELS: Final = 50
"""Levels of lists in a report."""

MOST_DIGITS: Final = 9
"""Digits behind the decimal point of a figure."""

LEVELS: Final = ("good", "warn", "refuse")


def sound_tools(tools: Any) -> tuple[Tool[Any], ...]:
    """Return the tools as a tuple if each can be shown and asked.

    Raises
    ------
    Unsound
    """
    if not isinstance(tools, list | tuple):
        raise Unsound(f"{type(tools).__name__} where a list of tools belongs")
    ids = set()
    for tool in tools:
        if not isinstance(tool, Tool):
            raise Unsound(f"{_name_of(tool)} is not derived from bozzetto.plugin.Tool")
        for name in ("id", "title", "icon", "hint", "group"):
            if not isinstance(getattr(tool, name, None), str):
                raise Unsound(f"{type(tool).__name__}.{name} must be a text")
        if not tool.id or tool.id in ids:
            raise Unsound(f"two tools with the id {tool.id!r}" if tool.id else "a tool without id")
        ids.add(tool.id)
        if tool.gesture not in ("ink", "tap", "drag"):
            raise Unsound(f'{type(tool).__name__}.gesture must be "ink", "tap" or "drag"')
        for name in ("aims", "grabs", "plays", "hovers"):
            if not isinstance(getattr(tool, name), bool):
                raise Unsound(f"{type(tool).__name__}.{name} must be True or False")
    return tuple(tools)


def _name_of(thing: Any) -> str:
    return thing.__name__ if isinstance(thing, type) else type(thing).__name__


def sound_preview(preview: Any) -> Preview[Any]:
    """Return the preview of a gesture if it is one.

    Raises
    ------
    Unsound
    """
    if not isinstance(preview, Preview):
        raise Unsound(f"{type(preview).__name__} where a Preview belongs")
    return preview


def sound_next_step(step: Any) -> NextStep:
    """Return a next step if it can be said and shown.

    Raises
    ------
    Unsound
    """
    if type(step) is not NextStep:
        raise Unsound(f"{type(step).__name__} where a NextStep belongs")
    for name in ("sentence", "tool"):
        check_words(getattr(step, name), f"NextStep.{name}")
    if step.place is not None:
        place = np.asarray(step.place, np.float64)
        expect(place.shape == (3,) and bool(np.isfinite(place).all()), "NextStep.place")
    expect(isinstance(step.panel, bool), "NextStep.panel")
    return step


def sound_ink(ink: Any) -> Strokes:
    """Return the strokes if they are strokes; a `Stroke` checks its own columns.

    Raises
    ------
    Unsound
    """
    if type(ink) is not Strokes:
        raise Unsound(f"{type(ink).__name__} where Strokes belong")
    for stroke in ink:
        if type(stroke) is not Stroke:
            raise Unsound(f"{type(stroke).__name__} where a Stroke belongs")
    return ink


def sound_commands(commands: Any) -> tuple[Command, ...]:
    """Return the commands as a tuple if each has what `Command` asks for.

    Raises
    ------
    Unsound
    """
    if not isinstance(commands, list | tuple):
        raise Unsound(f"{type(commands).__name__} where a list of commands belongs")
    expect(len(commands) <= MOST_COMMANDS, "the number of commands")
    for command in commands:
        if not isinstance(command, Command):
            raise Unsound(f"{type(command).__name__} where a Command belongs")
        for name in ("id", "title", "help", "key", "writes", "menu"):
            check_text(getattr(command, name), f"Command.{name}")
        ending = re.fullmatch(r"(\.[a-z0-9]{1,16})*", command.writes)
        expect(ending is not None, f"the ending that the command {command.id!r} writes")
        expect(bool(command.id and command.title), "a command without an id or a title")
        for name in ("run", "enabled"):
            expect(callable(getattr(command, name)), f"{name} of the command {command.id!r}")
    ids = [command.id for command in commands]
    expect(len(set(ids)) == len(ids), "an id of a command (given twice)")
    return tuple(commands)


def sound_content(content: Any) -> bytes:
    """Return the content of a file if it is some.

    Raises
    ------
    Unsound
    """
    if type(content) is not bytes:
        raise Unsound(f"{type(content).__name__} where the bytes of a file belong")
    expect(0 < len(content) <= LARGEST_CONTENT, "the size of a file")
    return content


def sound_advice(advice: Any) -> ViewAdvice | None:
    """Return what was said of a view if it can be shown; None where nothing is said.

    Raises
    ------
    Unsound
    """
    if advice is None:
        return None
    if type(advice) is not ViewAdvice:
        raise Unsound(f"{type(advice).__name__} where a ViewAdvice belongs")
    expect(advice.level in LEVELS, "ViewAdvice.level")
    if advice.message != "" or advice.level != "good" or advice.better is not None:
        check_text(advice.message, "ViewAdvice.message")
    expect(advice.better is None or type(advice.better) is Camera, "ViewAdvice.better")
    expect(isinstance(advice.pinned, bool), "ViewAdvice.pinned")
    expect(isinstance(advice.as_drawn, bool), "ViewAdvice.as_drawn")
    expect(isinstance(advice.follow, bool), "ViewAdvice.follow")
    sound_scene(advice.scene)
    return advice


def sound_view(view: Any) -> Camera | None:
    """Return a view if it is one, or None; a `Camera` checks its own numbers.

    Raises
    ------
    Unsound
    """
    if view is not None and type(view) is not Camera:
        raise Unsound(f"{type(view).__name__} where a Camera belongs")
    return view


def sound_cautions(cautions: Any) -> tuple[Caution, ...]:
    """Return the cautions as a tuple if each can be said.

    Raises
    ------
    Unsound
    """
    if not isinstance(cautions, list | tuple):
        raise Unsound(f"{type(cautions).__name__} where a list of cautions belongs")
    for caution in cautions:
        if type(caution) is not Caution:
            raise Unsound(f"{type(caution).__name__} where a Caution belongs")
        check_words(caution.message, "the message of a caution")
        if not caution.message.strip():
            raise Unsound("a caution needs words")
        expect(isinstance(caution.baseless, bool), "Caution.baseless")
    return tuple(cautions)


def sound_sources(sources: Any) -> tuple[str, ...]:
    """Return ids of models as a tuple if each can be one, and none stands there twice.

    Raises
    ------
    Unsound
    """
    if not isinstance(sources, list | tuple):
        raise Unsound(f"{type(sources).__name__} where a row of ids belongs")
    expect(len(sources) <= MOST_SOURCES, "the number of sources")
    for source in sources:
        fine = isinstance(source, str) and re.match(ID_PATTERN, source) is not None
        expect(fine, f"the id of a source ({source!r})")
    expect(len(set(sources)) == len(sources), "the id of a source (given twice)")
    return tuple(sources)


def sound_times(times: Any) -> tuple[float, ...]:
    """Return times that a modeler has recorded.

    Raises
    ------
    Unsound
        If they are not finite numbers that grow.
    """
    try:
        values = tuple(float(value) for value in times)
    except (TypeError, ValueError):
        raise Unsound(f"the times are {type(times).__name__} and no numbers") from None
    check_finite(values, "the times")
    grow = all(one < other for one, other in itertools.pairwise(values))
    expect(grow, "the times do not grow")
    return values


def sound_report(report: Any) -> dict[str, Any]:
    """Return a report as a dict.

    Raises
    ------
    Unsound
    """
    if not isinstance(report, Mapping):
        raise Unsound(f"{type(report).__name__} where a mapping belongs")
    _check_reported(report, MOST_LEVELS)
    return dict(report)


def _check_reported(value: Any, levels: int) -> None:
    """Raise `Unsound` where a report holds what no JSON file can hold, or has no end.

    Numbers and arrays of numpy are written as plain ones.
    """
    if isinstance(value, str):
        check_words(value, "a text of the report")
    elif isinstance(value, Mapping | list | tuple):
        expect(levels > 0, "the depth of the report")
        if isinstance(value, Mapping):
            for key in value:
                check_words(str(key), "a key of the report")
            value = value.values()
        for each in value:
            _check_reported(each, levels - 1)
    elif not (value is None or isinstance(value, bool | int | float | np.generic | np.ndarray)):
        kind = type(value).__name__
        raise Unsound(f"{kind} in the report, where numbers, texts, lists and mappings belong")


def sound_figures(figures: Any) -> dict[str, Figure]:
    """Return the words of a report's values if each can be said.

    Raises
    ------
    Unsound
    """
    if not isinstance(figures, Mapping):
        raise Unsound(f"{type(figures).__name__} where a mapping of keys to Figure belongs")
    for key, figure in figures.items():
        expect(isinstance(key, str) and bool(key), f"the key {key!r}")
        if type(figure) is not Figure:
            raise Unsound(f"{key}: {type(figure).__name__} where a Figure belongs")
        for name in ("label", "help", "unit", "beyond"):
            check_text(getattr(figure, name), f"{key}: Figure.{name}")
        if figure.label and not figure.help:
            raise Unsound(f"{key}: Figure.help is empty: say in one sentence what it measures")
        check_number(figure.factor, f"{key}: Figure.factor", -math.inf, math.inf)
        expect(
            isinstance(figure.digits, int) and figure.digits <= MOST_DIGITS, f"{key}: Figure.digits"
        )
        expect(isinstance(figure.spread, bool), f"{key}: Figure.spread")
        expect(isinstance(figure.most, int | float), f"{key}: Figure.most")
        _check_bounds(key, figure)
        expect(
            isinstance(figure.values, Mapping)
            and all(isinstance(text, str) for pair in figure.values.items() for text in pair),
            f"{key}: Figure.values",
        )
        expect(
            isinstance(figure.verdicts, Mapping)
            and all(
                isinstance(text, str) and isinstance(fine, bool)
                for text, fine in figure.verdicts.items()
            ),
            f"{key}: Figure.verdicts",
        )
    return dict(figures)


def _check_bounds(key: str, figure: Figure) -> None:
    if figure.good is None and figure.bad is None:
        return
    if figure.good is None or figure.bad is None or figure.good == figure.bad:
        raise Unsound(
            f"{key}: give good and bad, and not the same: together they tell the direction"
        )
    for name in ("good", "bad"):
        check_number(getattr(figure, name), f"{key}: Figure.{name}", -math.inf, math.inf)


def sound_first_parameters(names: Any, state_types: Iterable[type[Any]]) -> tuple[str, ...]:
    """Return the names of the parameters that forms show first if there are such parameters.

    Parameters
    ----------
    names : object
        What the modeler says.
    state_types : iterable of type
        Of its states, and of its parts.

    Raises
    ------
    Unsound
    """
    expect_tuple(names, "first_parameters")
    if not names:
        return ()
    if len(names) > MOST_FIRST or len(set(names)) != len(names):
        raise Unsound(f"first_parameters: name {MOST_FIRST} at most, each once")
    known = {field.name: field for kind in state_types for field in parameter_fields(kind)}
    for name in names:
        if name not in known:
            raise Unsound(f"first_parameters: there is no parameter {name!r}")
        if known[name].parameter.advanced:
            raise Unsound(f"first_parameters: {name!r} is advanced, which is folded away")
    return tuple(names)


def sound_parts(tree: PartTree) -> PartTree:
    """Return the parts of a state if they can be listed.

    Raises
    ------
    Unsound
        If one is no `Part`, two have the same id, or one lies
        within what is no group, or within itself.
    """
    expect_tuple(tree.parts, "the parts")
    for part in tree.parts:
        if not isinstance(part, Part):
            raise Unsound(f"{type(part).__name__} is not derived from bozzetto.plugin.Part")
        for name in ("id", "name", "within"):
            check_text(getattr(part, name), f"{type(part).__name__}.{name}")
        expect(isinstance(part.visible, bool), "the visibility of a part")
    ids = [part.id for part in tree.parts]
    expect(all(ids) and len(set(ids)) == len(ids), "an id of a part (empty, or given twice)")
    expect(tree.selected in {"", *ids}, f"the chosen part {tree.selected!r}")
    within = {part.id: part.within for part in tree.parts}
    for part in tree.parts:
        around, steps = part.within, 0
        while around:
            group = around in tree.groups and around in within
            expect(group and steps < len(ids), f"what {part.name!r} is within")
            around, steps = within[around], steps + 1
    return tree


# -- items of a scene ---------------------------------------------------------------------------


# -- parts of shapes -------------------------------------------------------------------------------
