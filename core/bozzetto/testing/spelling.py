"""Classes of a plugin compared with the contract's: misspelt names, other arguments, what is final.

Such a method is silently never asked for, or fails when it is.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator
from types import FunctionType
from typing import Any, Final

from bozzetto.parameters import parameter_fields
from bozzetto.plugin.host.similar_names import meant_by
from bozzetto.plugin.modeler import Modeler
from bozzetto.plugin.overrides import overrides
from bozzetto.plugin.parts import PartsModeler
from bozzetto.plugin.tool import Preview, Tool
from bozzetto.testing.subject import Subject, ensure

BASES: Final[tuple[type, ...]] = (Modeler, PartsModeler, Tool, Preview)
"""Classes from which a plugin's classes are derived."""

MOST_FIRST: Final = 3
"""Parameters that a form shows first."""


def _names(kind: type) -> frozenset[str]:
    """Return the public names of the contract that a class has."""
    return frozenset(
        name
        for base in kind.__mro__
        if base in BASES
        for name in (*vars(base), *getattr(base, "__annotations__", ()))
        if not name.startswith("_")
    )


MODELER_NAMES: Final = _names(PartsModeler)
"""Public names of the contract of a modeler."""

TOOL_NAMES: Final = _names(Tool)
"""Public names of the contract of a tool."""


def check_spelling(subject: Subject) -> None:
    """Check that no name is a misspelt one of the contract, and methods take what it passes."""
    with subject.shell() as shell:
        modeler = shell.registry.modeler(subject.modeler)
        plugin = shell.registry.info(subject.modeler).plugin
        package = next(p.package for p in shell.registry.plugins() if p.id == plugin)
        owners = [modeler, *shell.tools()]
        kinds = dict.fromkeys([*map(type, owners), *derived_classes(package)])
        found = [fault for kind in kinds for fault in class_faults(kind)]
        for owner in owners:
            found += [
                f"{_title(type(owner))}: {fault}"
                for fault in _misspelt(getattr(owner, "__dict__", ()), type(owner))
            ]
        ensure(not found, "; ".join(found))


def derived_classes(package: str) -> list[type]:
    """Return the classes of an imported package that are derived from the contract's."""
    found: dict[type, None] = {}
    waiting = list(BASES)
    while waiting:
        kinds: list[type] = waiting.pop().__subclasses__()
        for kind in kinds:
            waiting.append(kind)
            if kind.__module__.partition(".")[0] == package:
                found[kind] = None
    return sorted(found, key=lambda kind: (kind.__module__, kind.__qualname__))


def class_faults(kind: type) -> Iterator[str]:
    """Yield a sentence for each thing in a class that the contract does not have like this."""
    own = {
        name: part
        for part in reversed(kind.__mro__)
        if part.__module__.partition(".")[0] != "bozzetto"
        for name in (*vars(part), *getattr(part, "__annotations__", ()))
    }
    faults = [*_misspelt(own, kind), *_other_uses(own, kind), *_first_parameters(kind)]
    for fault in faults:
        yield f"{_title(kind)}: {fault}"


def _title(kind: type) -> str:
    return kind.__qualname__


def _misspelt(names: Iterable[str], kind: type) -> Iterator[str]:
    """Yield what looks like a name of the contract that the class itself does not write."""
    known = _names(kind)
    for name in names:
        if name.startswith("_") or name in known:
            continue
        meant = meant_by(name, known)
        if meant and not overrides(kind, meant):
            yield (
                f"{name!r} looks like {meant!r}; write it so, or let the name begin with an "
                "underscore"
            )


def _other_uses(own: Iterable[str], kind: type) -> Iterator[str]:
    """Yield overrides that cannot be used as the contract uses them."""
    known = _names(kind)
    for name in own:
        if name not in known:
            continue
        base = next((part for part in kind.__mro__ if part in BASES and name in vars(part)), None)
        wanted = None if base is None else vars(base)[name]
        given = inspect.getattr_static(kind, name, None)
        if not isinstance(wanted, FunctionType):
            if isinstance(given, FunctionType):
                yield f"{name!r} is a value in the contract, and here a method"
        elif getattr(wanted, "__final__", False):
            yield f"{name!r} is final; override the methods that it calls: {_called(wanted)}"
        elif not _accepts(given, wanted):
            yield f"{name}{_arguments(given)} must take {name}{_arguments(wanted)}"


def _called(function: FunctionType) -> str:
    return ", ".join(name for name in function.__code__.co_names if name in TOOL_NAMES)


def _accepts(given: Any, wanted: FunctionType) -> bool:
    """Whether a method can be called as the contract's is."""
    function = given.__func__ if isinstance(given, staticmethod | classmethod) else given
    if not callable(function):
        return False
    count = len(inspect.signature(wanted).parameters) - isinstance(given, staticmethod)
    try:
        inspect.signature(function).bind(*range(count))
    except TypeError:
        return False
    except ValueError:  # a function of a C library says nothing of its arguments
        return True
    return True


def _arguments(function: Any) -> str:
    plain = function.__func__ if isinstance(function, staticmethod | classmethod) else function
    try:
        names = inspect.signature(plain).parameters
    except (TypeError, ValueError):
        return " (no method)"
    return f"({', '.join(names)})"


def _first_parameters(kind: type) -> Iterator[str]:
    """Yield names in `first_parameters` that are no parameters of the state."""
    state_type = getattr(kind, "state_type", None)
    if not (issubclass(kind, Modeler) and isinstance(state_type, type)):
        return
    types = (state_type, *getattr(kind, "part_types", ()))
    try:
        known = {field.name for one in types for field in parameter_fields(one)}
    except Exception:  # no dataclass, or annotations that fail: told as what loading refuses
        return
    first = kind.first_parameters
    if len(first) > MOST_FIRST:
        yield f"'first_parameters' has {len(first)} names; {MOST_FIRST} at most"
    for name in first:
        if name not in known:
            meant = meant_by(name, known) or f"one of {', '.join(sorted(known)) or 'none'}"
            yield f"'first_parameters' names {name!r}, which is no parameter; perhaps {meant}"
