"""Validation of plugins' answers: only what can be shown and exported passes."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from numbers import Integral
from typing import Any, Final

import numpy as np

from bozzetto.document.model import ID_PATTERN
from bozzetto.geometry.brep.brep import Brep, Face
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.geometry.shapes import Curve, Shapes, Skeleton, Solid, Surface
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.parameters import parameter_fields
from bozzetto.plugin.cautions import Caution
from bozzetto.plugin.commands import Command
from bozzetto.plugin.figures import Figure
from bozzetto.plugin.next_step import NextStep
from bozzetto.plugin.part_tree import PartTree
from bozzetto.plugin.parts import Part
from bozzetto.plugin.tool import Preview, Tool
from bozzetto.plugin.view_advice import ViewAdvice
from bozzetto.scene.display_list import (
    Handle,
    Image,
    Label,
    Layer,
    Lines,
    Points,
    Scene,
    Shaded,
)
from bozzetto.view.camera import Camera

MOST_ITEMS: Final = 20_000
"""Items of one model's scene; beyond that a viewport crawls. Lines and points hold many."""

MOST_LABELS: Final = 2_000
"""Labels and handles of one model's scene."""

LONGEST_LABEL: Final = 200
"""Characters of a label, and of the names within a scene."""

MOST_PARTS: Final = 20_000
"""Parts that one model hands over."""

MOST_FIRST: Final = 3
"""Parameters that a form shows before all others."""

MOST_COMMANDS: Final = 200
"""Commands of one modeler; nobody would find more in a menu."""

MOST_SOURCES: Final = 1_000
"""Models that one model is made from."""

HIDDEN: Final = ("hide", "faint", "dashed", "show")

MOST_DIGITS: Final = 9
"""Digits behind the decimal point of a figure."""

LEVELS: Final = ("good", "warn", "refuse")


class Unsound(ValueError):
    """Something that a plugin made cannot be used; the message says what."""


def sound_scene(scene: Any) -> Scene:
    """Return the scene if it can be shown.

    Raises
    ------
    Unsound
        If it is no scene, or an item is of a wrong type, not finite or out of bounds.
    """
    if type(scene) is not Scene:
        raise Unsound(f"{type(scene).__name__} where a Scene belongs")
    _expect_tuple(scene.layers, "Scene.layers")
    items = labels = 0
    for layer in scene.layers:
        if type(layer) is not Layer:
            raise Unsound(f"{type(layer).__name__} where a Layer belongs")
        _text(layer.name, "the name of a layer")
        _expect_tuple(layer.items, f"the items of the layer {layer.name!r}")
        for item in layer.items:
            check = _ITEM_CHECKS.get(type(item))
            if check is None:
                raise Unsound(f"{type(item).__name__} is not a display item")
            check(item)
            _paint(getattr(item, "color", "ink"))
            items += 1
            labels += isinstance(item, Label | Handle)
    if items > MOST_ITEMS or labels > MOST_LABELS:
        raise Unsound(
            f"{items} items with {labels} labels and handles; "
            f"at most {MOST_ITEMS} and {MOST_LABELS} can be shown"
        )
    return scene


def sound_shapes(shapes: Any) -> Shapes:
    """Return the shapes if other programs can use them.

    Raises
    ------
    Unsound
        If a part is of a wrong type, not finite, or there are too many.
    """
    if type(shapes) is not Shapes:
        raise Unsound(f"{type(shapes).__name__} where Shapes belong")
    count = 0
    kinds = (Solid, Surface, Curve, Skeleton, Patchwork, Brep)
    for entry, kind in zip(fields(Shapes), kinds, strict=True):
        parts = getattr(shapes, entry.name)
        _expect_tuple(parts, f"Shapes.{entry.name}")
        count += len(parts)
        for part in parts:
            if type(part) is not kind:
                raise Unsound(f"{type(part).__name__} among Shapes.{entry.name}")
            _check_part(part)
    if count > MOST_PARTS:
        raise Unsound(f"{count} parts; at most {MOST_PARTS} can be handed over")
    return shapes


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
        for name in ("id", "title", "icon", "hint"):
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
        _expect(isinstance(getattr(step, name), str), f"NextStep.{name}")
    if step.place is not None:
        place = np.asarray(step.place, np.float64)
        _expect(place.shape == (3,) and bool(np.isfinite(place).all()), "NextStep.place")
    _expect(isinstance(step.panel, bool), "NextStep.panel")
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
    _expect(len(commands) <= MOST_COMMANDS, "the number of commands")
    for command in commands:
        if not isinstance(command, Command):
            raise Unsound(f"{type(command).__name__} where a Command belongs")
        for name in ("id", "title", "help", "key"):
            _text(getattr(command, name), f"Command.{name}")
        _expect(bool(command.id and command.title), "a command without an id or a title")
        for name in ("run", "enabled"):
            _expect(callable(getattr(command, name)), f"{name} of the command {command.id!r}")
    ids = [command.id for command in commands]
    _expect(len(set(ids)) == len(ids), "an id of a command (given twice)")
    return tuple(commands)


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
    _expect(advice.level in LEVELS, "ViewAdvice.level")
    if advice.message != "" or advice.level != "good" or advice.better is not None:
        _text(advice.message, "ViewAdvice.message")
    _expect(advice.better is None or type(advice.better) is Camera, "ViewAdvice.better")
    _expect(isinstance(advice.pinned, bool), "ViewAdvice.pinned")
    _expect(isinstance(advice.follow, bool), "ViewAdvice.follow")
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
        if not isinstance(caution.message, str) or not caution.message.strip():
            raise Unsound("a caution needs words")
        _expect(isinstance(caution.baseless, bool), "Caution.baseless")
    return tuple(cautions)


def sound_sources(sources: Any) -> tuple[str, ...]:
    """Return ids of models as a tuple if each can be one, and none stands there twice.

    Raises
    ------
    Unsound
    """
    if not isinstance(sources, list | tuple):
        raise Unsound(f"{type(sources).__name__} where a row of ids belongs")
    _expect(len(sources) <= MOST_SOURCES, "the number of sources")
    for source in sources:
        fine = isinstance(source, str) and re.match(ID_PATTERN, source) is not None
        _expect(fine, f"the id of a source ({source!r})")
    _expect(len(set(sources)) == len(sources), "the id of a source (given twice)")
    return tuple(sources)


def sound_report(report: Any) -> dict[str, Any]:
    """Return a report as a dict.

    Raises
    ------
    Unsound
    """
    if not isinstance(report, Mapping):
        raise Unsound(f"{type(report).__name__} where a mapping belongs")
    return dict(report)


def sound_figures(figures: Any) -> dict[str, Figure]:
    """Return the words of a report's values if each can be said.

    Raises
    ------
    Unsound
    """
    if not isinstance(figures, Mapping):
        raise Unsound(f"{type(figures).__name__} where a mapping of keys to Figure belongs")
    for key, figure in figures.items():
        _expect(isinstance(key, str) and bool(key), f"the key {key!r}")
        if type(figure) is not Figure:
            raise Unsound(f"{key}: {type(figure).__name__} where a Figure belongs")
        for name in ("label", "help", "unit", "beyond"):
            _text(getattr(figure, name), f"{key}: Figure.{name}")
        _expect(bool(figure.help) or not figure.label, f"{key}: Figure.help")
        _number(figure.factor, f"{key}: Figure.factor", -math.inf, math.inf)
        _expect(
            isinstance(figure.digits, int) and figure.digits <= MOST_DIGITS, f"{key}: Figure.digits"
        )
        _expect(isinstance(figure.spread, bool), f"{key}: Figure.spread")
        _expect(isinstance(figure.most, int | float), f"{key}: Figure.most")
        _check_bounds(key, figure)
        _expect(
            isinstance(figure.values, Mapping)
            and all(isinstance(text, str) for pair in figure.values.items() for text in pair),
            f"{key}: Figure.values",
        )
        _expect(
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
        _number(getattr(figure, name), f"{key}: Figure.{name}", -math.inf, math.inf)


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
    _expect_tuple(names, "first_parameters")
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
    _expect_tuple(tree.parts, "the parts")
    for part in tree.parts:
        if not isinstance(part, Part):
            raise Unsound(f"{type(part).__name__} is not derived from bozzetto.plugin.Part")
        for name in ("id", "name", "within"):
            _text(getattr(part, name), f"{type(part).__name__}.{name}")
        _expect(isinstance(part.visible, bool), "the visibility of a part")
    ids = [part.id for part in tree.parts]
    _expect(all(ids) and len(set(ids)) == len(ids), "an id of a part (empty, or given twice)")
    _expect(tree.selected in {"", *ids}, f"the chosen part {tree.selected!r}")
    within = {part.id: part.within for part in tree.parts}
    for part in tree.parts:
        around, steps = part.within, 0
        while around:
            group = around in tree.groups and around in within
            _expect(group and steps < len(ids), f"what {part.name!r} is within")
            around, steps = within[around], steps + 1
    return tree


# -- items of a scene ---------------------------------------------------------------------------


def _expect(condition: bool, what: str) -> None:
    if not condition:
        raise Unsound(f"{what} is of a wrong kind or out of range")


def _expect_tuple(value: Any, what: str) -> None:
    if type(value) is not tuple:
        raise Unsound(
            f"{what}: {type(value).__name__} where a tuple belongs; "
            "a tuple of one thing is written (thing,)"
        )


def _paint(paint: Any) -> None:
    """Refuse what is no paint; names of roles were checked when the item was made."""
    fine = isinstance(paint, str) or all(isinstance(part, Integral) for part in paint)
    if not fine:
        raise Unsound(f"the colour {paint!r}: write three whole numbers from 0 to 255, or a role")


def _finite(values: Any, what: str) -> None:
    if not np.isfinite(values).all():
        raise Unsound(f"{what} hold a number that is not finite")


def _number(value: Any, what: str, low: float, high: float) -> None:
    fine = isinstance(value, int | float) and math.isfinite(value) and low <= value <= high
    _expect(fine, what)


def _point(value: Any, what: str) -> None:
    _expect(np.shape(value) == (3,), what)
    _finite(np.asarray(value, float), what)


def _text(value: Any, what: str) -> None:
    _expect(isinstance(value, str) and len(value) <= LONGEST_LABEL, what)


def _mesh(mesh: Any) -> None:
    _expect(type(mesh) is Mesh, "a mesh")
    _finite(mesh.vertices, "the vertices of a mesh")
    if mesh.normals is not None:
        _finite(mesh.normals, "the normals of a mesh")


def _shaded(item: Shaded) -> None:
    _mesh(item.mesh)
    _number(item.opacity, "the opacity of a mesh", 0.0, 1.0)


def _lines(item: Lines) -> None:
    _finite(item.points, "the points of lines")
    _finite(item.width, "the widths of lines")
    _expect(bool((np.asarray(item.width) >= 0).all()), "the width of lines")
    _number(item.opacity, "the opacity of lines", 0.0, 1.0)
    _expect(item.hidden in HIDDEN, "how lines are hidden")
    if item.starts is not None and len(item.starts):
        first, last = int(item.starts[0]), int(item.starts[-1])
        rising = bool((np.diff(item.starts) >= 0).all())
        _expect(rising and first >= 0 and last <= len(item.points), "the starts of lines")


def _points(item: Points) -> None:
    _finite(item.points, "points")
    _number(item.size, "the size of points", 0.0, 1000.0)
    _number(item.opacity, "the opacity of points", 0.0, 1.0)
    _expect(item.hidden in HIDDEN, "how points are hidden")


def _label(item: Label) -> None:
    _point(item.point, "the place of a label")
    _text(item.text, "the text of a label")
    _number(item.size, "the size of a label", 0.0, 1000.0)


def _image(item: Image) -> None:
    for name in ("corner", "across", "down"):
        _point(getattr(item, name), f"the {name} of an image")
    _number(item.opacity, "the opacity of an image", 0.0, 1.0)


def _handle(item: Handle) -> None:
    _text(item.id, "the id of a handle")
    _expect(item.id != "", "the id of a handle")
    _point(item.point, "the place of a handle")
    _text(item.tip, "the tip of a handle")


_ITEM_CHECKS: Final[dict[type[Any], Callable[[Any], None]]] = {
    Shaded: _shaded,
    Lines: _lines,
    Points: _points,
    Label: _label,
    Image: _image,
    Handle: _handle,
}


# -- parts of shapes -------------------------------------------------------------------------------


def _check_part(part: Any) -> None:
    _expect(isinstance(part.name, str), "the name of a part")
    if isinstance(part, Solid | Surface):
        _mesh(part.mesh)
    elif isinstance(part, Curve):
        _curve(part, "a curve")
    elif isinstance(part, Patchwork):
        _finite(part.nets, "the control points of a patchwork")
        _finite(part.edges, "the edges of a patchwork")
        _expect(all(isinstance(n, str) for n in part.patch_names), "the names of patches")
    elif isinstance(part, Brep):
        _brep(part)
    else:
        _finite(part.joints, "the joints of a skeleton")
        _finite(part.radii, "the radii of a skeleton")
        count = len(part.joints)
        fits = part.bones.size == 0 or (part.bones.min() >= 0 and part.bones.max() < count)
        _expect(len(part.radii) == count and bool(fits), "a skeleton")


def _curve(part: Any, what: str) -> None:
    _finite(part.knots, f"the knots of {what}")
    _finite(part.control_points, f"the control points of {what}")
    if part.weights is not None:
        _finite(part.weights, f"the weights of {what}")


def _brep(part: Brep) -> None:
    """Check what a frozen brep could be given all the same; it has checked itself when made."""
    _expect_tuple(part.edges, "Brep.edges")
    _expect_tuple(part.faces, "Brep.faces")
    for edge in part.edges:
        _expect(type(edge) is Curve, "an edge of a brep")
        _curve(edge, "an edge")
    for face in part.faces:
        _expect(type(face) is Face, "a face of a brep")
        _expect(isinstance(face.name, str), "the name of a face")
        surface = face.surface
        _expect(type(surface) is BSplineSurface, "the surface of a face")
        _finite(surface.control_points, "the control points of a surface")
        if surface.weights is not None:
            _finite(surface.weights, "the weights of a surface")
