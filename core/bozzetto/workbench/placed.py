"""Answers of modelers as the document has them: named, coloured and placed; and plain values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from itertools import count
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from bozzetto.errors import UserError
from bozzetto.scene.display_list import Scene, Shaded

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.geometry.shapes import Shapes

Answer = TypeVar("Answer", Scene, "Shapes")


def scene_in_world(scene: Scene, model: Model) -> Scene:
    """Return a modeler's scene in the world: in the model's colour, placed, marked as its own."""
    if model.color is not None:
        scene = _tinted(scene, model.color)
    return _placed(scene, model).owned(model.id)


def _tinted(scene: Scene, color: tuple[int, int, int]) -> Scene:
    """Return shaded parts in the model's colour, where they carry no colours of their own."""

    def tint(item: Any) -> Any:
        bare = isinstance(item, Shaded) and item.color == "clay"
        return replace(item, color=color) if bare else item

    return Scene(
        tuple(
            replace(layer, items=tuple(tint(item) for item in layer.items))
            for layer in scene.layers
        )
    )


def shapes_in_world(shapes: Shapes, model: Model) -> Shapes:
    """Return a modeler's shapes in the world: named, in the model's colour, placed."""
    return _placed(_named(shapes, model), model)


def told_apart(rows: Sequence[tuple[str, Shapes]]) -> list[Shapes]:
    """Return the shapes of objects so that no part has the name of another object's part.

    Where two objects have parts of one name, such as two cars, all their parts are named with
    their object, and objects of one name are numbered. Anything else stays as it is.

    Parameters
    ----------
    rows : sequence of (str, Shapes)
        The name of each object, and its shapes.
    """
    owners: dict[str, set[int]] = {}
    for number, (_, shapes) in enumerate(rows):
        for name in _names(shapes):
            owners.setdefault(name, set()).add(number)
    mixed = {number for some in owners.values() if len(some) > 1 for number in some}
    taken = {name for name, some in owners.items() if not some <= mixed}
    made = []
    for number, (name, shapes) in enumerate(rows):
        if number in mixed:
            labels = (name if at == 1 else f"{name} {at}" for at in count(1))
            renamed = (_renamed(shapes, name, label) for label in labels)
            shapes = next(tried for tried in renamed if not _names(tried) & taken)
            taken |= _names(shapes)
        made.append(shapes)
    return made


def _names(shapes: Shapes) -> set[str]:
    return {part.name for entry in fields(shapes) for part in getattr(shapes, entry.name)}


def _renamed(shapes: Shapes, owner: str, label: str) -> Shapes:
    """Return shapes with an object's label; parts that are named after it are not named twice."""

    def renamed(part: Any) -> Any:
        after = part.name == owner or part.name.startswith(f"{owner} ")
        name = label + part.name.removeprefix(owner) if after else f"{label}: {part.name}"
        return replace(part, name=name)

    rows = {
        entry.name: tuple(map(renamed, getattr(shapes, entry.name))) for entry in fields(shapes)
    }
    return replace(shapes, **rows)


def _placed(answer: Answer, model: Model) -> Answer:
    """Place an answer; raise `UserError` where the numbers get too large for that."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            return answer.placed(model.placement)
    except ValueError as problem:
        raise UserError(
            f"“{model.name}” is moved or stretched further than can be shown. Undo the move, or "
            "make the object smaller."
        ) from problem


def _named(shapes: Shapes, model: Model) -> Shapes:
    """Return parts in the model's colour; those without a name are named after it and numbered."""

    def named(parts: tuple[Any, ...]) -> tuple[Any, ...]:
        made = []
        for number, part in enumerate(parts, 1):
            changes: dict[str, Any] = {}
            if part.name == type(part).name:
                name = model.name if len(parts) == 1 else f"{model.name} {number}"
                changes["name"] = name
            if hasattr(part, "color") and part.color is None:
                changes["color"] = model.color
            made.append(replace(part, **changes))
        return tuple(made)

    rows = {entry.name: named(getattr(shapes, entry.name)) for entry in fields(shapes)}
    return replace(shapes, **rows)


def plain(value: Any) -> Any:
    """Return a report as JSON values; numbers that are not finite become None."""
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return str(value)
