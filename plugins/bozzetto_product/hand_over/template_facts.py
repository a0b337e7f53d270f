"""The rough shape that a file of ink gives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, get_args

from bozzetto.errors import UserError
from bozzetto_product.model.rough_shapes import RoughKind, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.rough_shapes.shapes import SIZES

EXTENT: Final = ("length", "width", "height")
KEYS: Final = ("kind", "centre", *EXTENT)


def with_template(state: ProductState, facts: Mapping[str, Any]) -> ProductState:
    """Return the state with the rough shapes that a file gives under “template”.

    It is the kind of a rough shape; or an object with ``kind`` and, if wanted, ``length``,
    ``width``, ``height`` (mm, else as such things are) and ``centre`` (else it stands on the
    ground); or a list of such.

    Raises
    ------
    UserError
        If it is no rough shape; the message names the key.
    """
    given = facts.get("template", ())
    for number, value in enumerate(given if isinstance(given, list | tuple) else [given]):
        state = state.with_node(_shape(value, state, f"template[{number}]"))
    return state


def _shape(value: object, state: ProductState, where: str) -> RoughShape:
    if isinstance(value, str):
        value = {"kind": value}
    if not isinstance(value, Mapping):
        raise UserError(f"“{where}” is no object {{…}} with the kind of a rough shape.")
    unknown = sorted(set(map(str, value)) - set(KEYS))
    if unknown:
        raise UserError(f"“{where}” has a key “{unknown[0][:40]}”. Known are {', '.join(KEYS)}.")
    kind = next((one for one in get_args(RoughKind) if one == value.get("kind")), None)
    if kind is None:
        raise UserError(f"“{where}.kind” is one of {', '.join(get_args(RoughKind))}.")
    length, width, height = (
        _number(value.get(name, usual), f"{where}.{name}", 1e-3)
        for name, usual in zip(EXTENT, SIZES[kind], strict=True)
    )
    centre = value.get("centre", (0.0, 0.0, 0.5 * height))
    if not isinstance(centre, list | tuple) or len(centre) != 3:
        raise UserError(f"“{where}.centre” is a point [x, y, z].")
    x, y, z = (_number(part, f"{where}.centre", -1e6) for part in centre)
    name = state.unused_name("Rough shape")
    return RoughShape(
        state.unused_id(),
        name,
        centre=(x, y, z),
        kind=kind,
        length=length,
        width=width,
        height=height,
    )


def _number(value: object, where: str, least: float) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and least <= value <= 1e6:
        return float(value)
    raise UserError(f"“{where}” is a number from {least:g} to 1e+06.")
