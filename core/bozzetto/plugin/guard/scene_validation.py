"""Validation of scenes: only what can be shown passes."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Integral
from typing import Any, Final

import numpy as np

from bozzetto.plugin.guard.checked_values import (
    Unsound,
    check_finite,
    check_mesh,
    check_number,
    check_point,
    check_text,
    expect,
    expect_tuple,
)
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

MOST_ITEMS: Final = 20_000
"""Items of one model's scene; beyond that a viewport crawls. Lines and points hold many."""

MOST_LABELS: Final = 2_000
"""Labels and handles of one model's scene."""

HIDDEN: Final = ("hide", "faint", "dashed", "show")


def sound_scene(scene: Any) -> Scene:
    """Return the scene if it can be shown.

    Raises
    ------
    Unsound
        If it is no scene, or an item is of a wrong type, not finite or out of bounds.
    """
    if type(scene) is not Scene:
        raise Unsound(f"{type(scene).__name__} where a Scene belongs")
    expect_tuple(scene.layers, "Scene.layers")
    items = labels = 0
    for layer in scene.layers:
        if type(layer) is not Layer:
            raise Unsound(f"{type(layer).__name__} where a Layer belongs")
        check_text(layer.name, "the name of a layer")
        expect_tuple(layer.items, f"the items of the layer {layer.name!r}")
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


def _paint(paint: Any) -> None:
    """Refuse what is no paint; names of roles were checked when the item was made."""
    fine = isinstance(paint, str) or all(isinstance(part, Integral) for part in paint)
    if not fine:
        raise Unsound(f"the colour {paint!r}: write three whole numbers from 0 to 255, or a role")


def _shaded(item: Shaded) -> None:
    check_mesh(item.mesh)
    check_number(item.opacity, "the opacity of a mesh", 0.0, 1.0)


def _lines(item: Lines) -> None:
    check_finite(item.points, "the points of lines")
    check_finite(item.width, "the widths of lines")
    expect(bool((np.asarray(item.width) >= 0).all()), "the width of lines")
    check_number(item.opacity, "the opacity of lines", 0.0, 1.0)
    expect(item.hidden in HIDDEN, "how lines are hidden")
    if item.starts is not None and len(item.starts):
        first, last = int(item.starts[0]), int(item.starts[-1])
        rising = bool((np.diff(item.starts) >= 0).all())
        expect(rising and first >= 0 and last <= len(item.points), "the starts of lines")


def _points(item: Points) -> None:
    check_finite(item.points, "points")
    check_number(item.size, "the size of points", 0.0, 1000.0)
    check_number(item.opacity, "the opacity of points", 0.0, 1.0)
    expect(item.hidden in HIDDEN, "how points are hidden")


def _label(item: Label) -> None:
    check_point(item.point, "the place of a label")
    check_text(item.text, "the text of a label")
    check_number(item.size, "the size of a label", 0.0, 1000.0)


def _image(item: Image) -> None:
    for name in ("corner", "across", "down"):
        check_point(getattr(item, name), f"the {name} of an image")
    check_number(item.opacity, "the opacity of an image", 0.0, 1.0)


def _handle(item: Handle) -> None:
    check_text(item.id, "the id of a handle")
    expect(item.id != "", "the id of a handle")
    check_point(item.point, "the place of a handle")
    check_text(item.tip, "the tip of a handle")


_ITEM_CHECKS: Final[dict[type[Any], Callable[[Any], None]]] = {
    Shaded: _shaded,
    Lines: _lines,
    Points: _points,
    Label: _label,
    Image: _image,
    Handle: _handle,
}
