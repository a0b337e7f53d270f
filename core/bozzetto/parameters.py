"""Parameters: annotated fields of a state, from which the shell builds its form.

A modeler writes ``softness: Annotated[float, Parameter("Blend softness", 1.25, 2.0)] = 1.4``;
the form, the ``--set`` option of the command line and the checks on both come from that.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from bozzetto.errors import UserError
from bozzetto.typed_data import unaliased

State = TypeVar("State")
Kind = Literal["number", "integer", "switch", "choice", "text", "color"]
Color = tuple[int, int, int]

LONGEST_TEXT = 1000
"""Longest text parameter accepted, characters."""

LARGEST_NUMBER = 1e15
"""Largest number accepted: up to here a float tells whole numbers apart."""


@dataclass(frozen=True)
class Parameter:
    """How a field of the state is shown and what it accepts.

    Parameters
    ----------
    label : str
        Words a designer would use.
    minimum, maximum : float, optional
        Inclusive range of a number.
    step : float, optional
        Sensible increment.
    unit : str
        "mm", "°", "cells" …; empty for a pure number.
    help : str
        One sentence: what it does to the shape.
    advanced : bool
        Folded away at first.
    choices : tuple of (value, label)
        Readable names for a ``Literal`` field's values.
    zero : str
        Words in the place of 0, for a number that is 0 where it is not given, such as
        "as drawn"; clearing the field gives 0.
    idle_while : tuple of (str, tuple)
        Other parameters of the same state, choices, switches or numbers, and their values with
        all of which this one changes nothing: ``(("motor", ("off",)),)``. Forms switch it off
        meanwhile.
    in_forms : bool
        Whether forms show it. False where the window has a better way to say it, such as a panel;
        the command line takes it all the same.
    tools : tuple of str
        Ids of the tools for which it is: with others in the hand, forms leave it out.
    """

    label: str
    minimum: float | None = None
    maximum: float | None = None
    step: float | None = None
    unit: str = ""
    help: str = ""
    advanced: bool = False
    choices: tuple[tuple[str, str], ...] = ()
    zero: str = ""
    idle_while: tuple[tuple[str, tuple[object, ...]], ...] = ()
    in_forms: bool = True
    tools: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.tools, tuple) or not all(isinstance(one, str) for one in self.tools):
            raise TypeError(f"the tools of {self.label!r} must be a tuple of ids of tools")
        low, high = self.minimum, self.maximum
        reached = (low is None or low <= 0) and (high is None or high >= 0)
        if not isinstance(self.zero, str) or (self.zero and not reached):
            raise TypeError(f"{self.label!r}: zero is the words for 0, which must be in the range")
        pairs = self.choices if isinstance(self.choices, tuple) else (None,)
        if not all(isinstance(pair, tuple) and len(pair) == 2 for pair in pairs):
            raise TypeError(
                f"the choices of {self.label!r} must be a tuple of pairs of texts, such as "
                '(("round", "Round ends"), ("flat", "Flat ends"))'
            )


@dataclass(frozen=True)
class Field:
    """A parameter as found on a state type.

    Attributes
    ----------
    name : str
        Name of the field.
    kind : {"number", "integer", "switch", "choice", "text", "color"}
    default : object
    values : tuple of str
        Values of a choice.
    """

    name: str
    parameter: Parameter
    kind: Kind
    default: Any
    values: tuple[str, ...] = ()

    def said(self, value: object) -> str:
        """Return a value of a switch, a choice or a number in words."""
        if self.kind == "switch":
            return "on" if value else "off"
        if self.kind == "choice":
            return f"“{dict(self.parameter.choices).get(str(value), value)}”"
        return self.parameter.zero if self.parameter.zero and value == 0 else f"{value:g}"

    def check(self, value: object) -> Any:
        """Return the value as the field wants it.

        Raises
        ------
        UserError
            If it is of the wrong kind or out of range.
        """
        label = self.parameter.label
        if self.kind == "switch":
            if not isinstance(value, bool):
                raise UserError(f"{label} is on or off.")
            return value
        if self.kind == "choice":
            if value not in self.values:
                raise UserError(f"{label} is one of {', '.join(self.values)}; not {value!r}.")
            return value
        if self.kind == "color":
            return _color(label, value)
        if self.kind == "text":
            if not isinstance(value, str) or len(value) > LONGEST_TEXT:
                raise UserError(f"{label} is a text of at most {LONGEST_TEXT} characters.")
            return value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UserError(f"{label} is a number, not {value!r}.")
        if abs(value) > LARGEST_NUMBER or not math.isfinite(value):
            raise UserError(f"{label} must be a finite number, and not a huge one.")
        if self.kind == "integer" and value != int(value):
            raise UserError(f"{label} is a whole number, not {value}.")
        low, high = self.parameter.minimum, self.parameter.maximum
        if (low is not None and value < low) or (high is not None and value > high):
            shown = f"{low:g}" if low is not None else "…"
            until = f"{high:g}" if high is not None else "…"
            unit = f" {self.parameter.unit}" if self.parameter.unit else ""
            raise UserError(f"{label} goes from {shown} to {until}{unit}; {value:g} is outside.")
        return int(value) if self.kind == "integer" else float(value)


def parameter_fields(state_type: type[Any]) -> tuple[Field, ...]:
    """Return the parameters of a state type, in the order of its fields; remembered."""
    return _parameter_fields(state_type)  # type: ignore[arg-type]  # types are hashable


@functools.cache
def _parameter_fields(state_type: type[Any]) -> tuple[Field, ...]:
    hints = get_type_hints(state_type, include_extras=True)
    found = []
    for entry in dataclasses.fields(state_type):
        hint = unaliased(hints[entry.name])
        notes = [n for n in getattr(hint, "__metadata__", ()) if isinstance(n, Parameter)]
        if not notes:
            continue
        plain = unaliased(get_args(hint)[0])
        values: tuple[str, ...] = ()
        kind: Kind
        if get_origin(plain) is Literal:
            kind, values = "choice", get_args(plain)
            if not all(isinstance(value, str) for value in values):
                raise TypeError(f"{state_type.__name__}.{entry.name}: choices must be texts")
        elif plain is bool:
            kind = "switch"
        elif plain is int:
            kind = "integer"
        elif plain is float:
            kind = "number"
        elif plain is str:
            kind = "text"
        elif plain == Color | None:
            kind = "color"
        else:
            raise TypeError(f"{state_type.__name__}.{entry.name}: {plain} cannot be a parameter")
        if entry.default is not dataclasses.MISSING:
            default = entry.default
        elif entry.default_factory is not dataclasses.MISSING:
            default = entry.default_factory()
        else:
            raise TypeError(f"{state_type.__name__}.{entry.name}: a parameter needs a default")
        unknown = [value for value, _ in notes[0].choices if value not in values]
        if unknown:
            raise TypeError(
                f"{state_type.__name__}.{entry.name}: choices names {unknown[0]!r}, which is no "
                "value of its; its type is a Literal of all values"
            )
        found.append(Field(entry.name, notes[0], kind, default, values))
    _check_idle(state_type, found)
    return tuple(found)


def _check_idle(state_type: type[Any], found: list[Field]) -> None:
    """Refuse parameters that are idle with values that no other parameter can have."""
    known = {field.name: field for field in found}
    for field in found:
        where = f"{state_type.__name__}.{field.name}: idle_while"
        conditions = field.parameter.idle_while
        pairs = conditions if isinstance(conditions, tuple) else (None,)
        if not all(isinstance(pair, tuple) and len(pair) == 2 for pair in pairs):
            raise TypeError(f'{where} is a tuple of pairs, such as (("motor", ("off",)),)')
        for name, values in conditions:
            if name not in known or name == field.name:
                raise TypeError(f"{where} names {name!r}, which is no other parameter")
            if not isinstance(values, tuple):
                raise TypeError(f"{where}: the values of {name!r} must be a tuple")
            try:
                for value in values:
                    known[name].check(value)
            except UserError as problem:
                raise TypeError(f"{where}: {problem.message}") from problem


def idle_parameters(found: Iterable[tuple[Field, Any]]) -> dict[str, str]:
    """Return which parameters change nothing as they are, each with the reason.

    Parameters
    ----------
    found : iterable of (Field, value)
        All parameters of a state, or of a part of one.

    Returns
    -------
    dict
        Sentences by the names of the fields.
    """
    known = {field.name: (field, value) for field, value in found}
    reasons = {}
    for name, (field, _) in known.items():
        holding = [(*known[other], values) for other, values in field.parameter.idle_while]
        if holding and all(value in values for _, value, values in holding):
            said = [f"“{one.parameter.label}” is {one.said(value)}" for one, value, _ in holding]
            words = " and ".join(filter(None, (", ".join(said[:-1]), said[-1])))
            reasons[name] = f"“{field.parameter.label}” changes nothing while {words}."
    return reasons


def valued_fields(state: object) -> tuple[tuple[Field, Any], ...]:
    """Return the parameters of a state, or of a part of one, with their values."""
    return tuple((field, getattr(state, field.name)) for field in parameter_fields(type(state)))


def set_parameters(state: State, values: dict[str, object], owner: str = "this modeler") -> State:
    """Return a state (or a part of one) with parameters changed.

    Parameters
    ----------
    state : dataclass
        The state before.
    values : dict
        New values by the names of the fields.
    owner : str
        Whose parameters these are, for messages.

    Raises
    ------
    UserError
        If a name is unknown or a value not accepted; the message lists what there is.
    """
    fields = {field.name: field for field in parameter_fields(type(state))}
    checked = {}
    for name, value in values.items():
        if name not in fields:
            known = ", ".join(fields) or "none"
            raise UserError(f"There is no parameter {name!r}; {owner} has: {known}.")
        checked[name] = fields[name].check(value)
    changed: State = dataclasses.replace(state, **checked)  # type: ignore[type-var]
    return changed


def parse_parameter(field: Field, text: str) -> object:
    """Read a parameter's value from what a person typed.

    Raises
    ------
    UserError
        If the text does not name a value of the field's kind.
    """
    if field.kind == "switch":
        words = {"on": True, "true": True, "yes": True, "1": True}
        words |= {"off": False, "false": False, "no": False, "0": False}
        if text.strip().lower() not in words:
            raise UserError(f"{field.parameter.label} is on or off, not {text!r}.")
        return words[text.strip().lower()]
    if field.kind in ("choice", "text"):
        return field.check(text)
    if field.kind == "color":
        return field.check(None if text.strip().lower() == "none" else _written_color(text))
    try:
        number = float(text)
    except ValueError:
        raise UserError(f"{field.parameter.label} is a number, not {text!r}.") from None
    return field.check(number)


def _written_color(text: str) -> object:
    """Return the parts of a colour written as ``#rrggbb``, or the text itself."""
    digits = text.strip().removeprefix("#")
    try:
        return tuple(bytes.fromhex(digits)) if len(digits) == 6 else text
    except ValueError:
        return text


def _color(label: str, value: object) -> Color | None:
    if value is None:
        return None
    parts = tuple(value) if isinstance(value, tuple | list) else ()
    whole = all(isinstance(part, int) and not isinstance(part, bool) for part in parts)
    if len(parts) != 3 or not whole or not all(0 <= part <= 255 for part in parts):
        raise UserError(f"{label} is a colour such as #c86432, or none; not {value!r}.")
    red, green, blue = parts
    return red, green, blue
