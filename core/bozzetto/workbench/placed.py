"""Answers of modelers as the document has them: named, coloured and placed; and plain values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
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
