"""Write the tables of names in ``docs/toolkit.md``: ``python docs/write_toolkit.py``.

Each public room has a table of what it offers: the first line of every name's own
documentation, its arguments, and what it has.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
from collections.abc import Iterator
from dataclasses import is_dataclass
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from types import MemberDescriptorType, ModuleType

from bozzetto.cached_properties import cached_property

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "toolkit.md"
MARK = "<!-- written by docs/write_toolkit.py -->\n"
DOORS = (
    "bozzetto.arrays",
    "bozzetto.ink",
    "bozzetto.geometry",
    "bozzetto.geometry.patches",
    "bozzetto.scene",
    "bozzetto.typed_data",
    "bozzetto.view",
    "bozzetto.view.calibration",
    "bozzetto.errors",
    "bozzetto_app.toolkit",
)


def imports_of(door: ModuleType) -> dict[str, str]:
    """Return each name that a door offers, with the module that it is from."""
    tree = ast.parse(inspect.getsource(door))
    found = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module or "" for node in found for alias in node.names}


def words_on_constants(module: ModuleType) -> dict[str, str]:
    """Return the strings that stand below assignments of a module."""
    body = ast.parse(inspect.getsource(module)).body
    found: dict[str, str] = {}
    for one, other in pairwise(body):
        target = one.target if isinstance(one, ast.AnnAssign) else None
        if isinstance(one, ast.Assign):
            (target, *_) = one.targets
        if isinstance(target, ast.Name) and isinstance(other, ast.Expr):
            value = other.value
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                found[target.id] = value.value
    return found


def words_on(name: str, module: ModuleType) -> str:
    """Return the first sentence or line of a name's documentation."""
    value = getattr(module, name)
    own = inspect.isclass(value) or inspect.isfunction(value)
    text = inspect.getdoc(value) if own else words_on_constants(module).get(name)
    paragraph = " ".join((text or "").partition("\n\n")[0].split())
    return paragraph if own else paragraph.split(". ")[0].rstrip(".") + "."


def rows(door: str) -> Iterator[str]:
    """Yield the lines of a door's table."""
    package = import_module(door)
    homes = imports_of(package)
    names = getattr(package, "__all__", None) or [
        name for name, value in vars(package).items() if getattr(value, "__module__", "") == door
    ]
    yield from (f"### `{door}`", "", inspect.getdoc(package) or "", "", "| name | |", "|---|---|")
    for name in sorted(names, key=str.lower):
        words = words_on(name, import_module(homes.get(name, door)))
        value = getattr(package, name)
        call = arguments(value)
        words += f" `{name}{call}`" if call else ""
        inner = ", ".join(f"`{text}`" for text in members(value)) if inspect.isclass(value) else ""
        words += f" has {inner}." if inner and not issubclass(value, Exception) else ""
        yield f"| `{name}` | {words.replace('|', chr(92) + '|')} |"
    yield ""


def arguments(value: object) -> str:
    """Return names and plain defaults of arguments; "" for what is not called."""
    if not (inspect.isclass(value) or inspect.isroutine(value)):
        return ""
    try:
        parameters = inspect.signature(value).parameters.values()
    except ValueError:
        return ""
    given: list[str] = []
    for parameter in parameters:
        if parameter.name == "self":
            continue
        star = {parameter.VAR_POSITIONAL: "*", parameter.VAR_KEYWORD: "**"}.get(parameter.kind, "")
        if parameter.kind is parameter.KEYWORD_ONLY and not any("*" in one for one in given):
            given.append("*")
        default = "" if parameter.default is parameter.empty else f"={plain(parameter.default)}"
        given.append(f"{star}{parameter.name}{default}")
    return f"({', '.join(given)})"


def plain(default: object) -> str:
    """Return a default as it is written, or three dots where it is none of a few kinds."""
    if isinstance(default, str):
        return f'"{default}"'
    atoms = (int, float, bool, type(None))
    row = default if isinstance(default, tuple) else (default,)
    return repr(default) if all(isinstance(one, atoms) for one in row) else "..."


def members(kind: type) -> Iterator[str]:
    """Yield public fields, properties and methods of ours, those with arguments with them."""
    fields = [field.name for field in dataclasses.fields(kind)] if is_dataclass(kind) else []
    yield from (name for name in fields if not name.startswith("_"))
    ours = [vars(base) for base in kind.__mro__ if base.__module__.startswith("bozzetto")]
    for name in dir(kind):
        if not any(name in own for own in ours):
            continue
        value = inspect.getattr_static(kind, name)
        if name.startswith("_") or name in fields:
            continue
        if isinstance(value, property | cached_property | MemberDescriptorType):
            yield name
        elif isinstance(value, staticmethod | classmethod) or inspect.isfunction(value):
            yield f"{name}{arguments(getattr(kind, name))}"


def documented(door: str) -> Iterator[tuple[str, object]]:
    """Yield what has documentation of its own among a door's names and their members."""
    package = import_module(door)
    for name in getattr(package, "__all__", ()):
        value = getattr(package, name)
        if inspect.isclass(value) or inspect.isroutine(value):
            yield name, value
        if inspect.isclass(value):
            for inner, member in vars(value).items():
                plain_member = getattr(member, "__func__", getattr(member, "fget", member))
                if inspect.isfunction(plain_member) and not inner.startswith("_"):
                    yield f"{name}.{inner}", plain_member


def named_limits() -> dict[str, tuple[list[str], object, str]]:
    """Return the constants that documentation names and no door offers.

    Returns
    -------
    dict
        By the module and the constant: who names it, its value and its words.
    """
    offered = {name for door in DOORS for name in getattr(import_module(door), "__all__", ())}
    found: dict[str, tuple[list[str], object, str]] = {}
    for door in DOORS:
        for name, value in documented(door):
            module = import_module(str(getattr(value, "__module__", door)))
            for constant in re.findall(r"`([A-Z][A-Z_0-9]{2,})`", inspect.getdoc(value) or ""):
                if constant in offered:
                    continue
                home = import_module(imports_of(module).get(constant) or module.__name__)
                words = words_on(constant, home)
                key = f"{home.__name__}.{constant}"
                namers, *_ = found.setdefault(key, ([], getattr(home, constant), words))
                if name not in namers:
                    namers.append(name)
    return found


def limits() -> Iterator[str]:
    """Yield the table of constants that the names above mention."""
    yield from (
        "### Numbers that these mention",
        "",
        "Where the documentation of a name says `TOLERANCE` or the like, it is this.",
        "",
        "| named by | constant | is | |",
        "|---|---|---|---|",
    )
    for key, (namers, value, words) in sorted(named_limits().items()):
        who = ", ".join(f"`{name}`" for name in namers)
        shown = f"{value:,}" if isinstance(value, int) else f"{value}"
        told = shown if isinstance(value, int | float) else ""
        yield f"| {who} | `{key.rpartition('.')[2]}` | {told} | {words} |"
    yield ""


def tables() -> str:
    """Return the tables of all doors, and of the constants that they mention."""
    lines = [line for door in DOORS for line in rows(door)]
    return "\n" + "\n".join([*lines, *limits()]).rstrip() + "\n"


def written(page: str) -> str:
    """Return the page with fresh tables."""
    return page.partition(MARK)[0] + MARK + tables()


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
