"""Write the tables of names in ``docs/toolkit.md``: ``python docs/write_toolkit.py``.

Each public room of the core has a table of what it offers, with the first line of every name's
own documentation.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "toolkit.md"
MARK = "<!-- written by docs/write_toolkit.py -->\n"
DOORS = (
    "bozzetto.ink",
    "bozzetto.geometry",
    "bozzetto.geometry.patches",
    "bozzetto.scene",
    "bozzetto.view",
    "bozzetto.view.calibration",
    "bozzetto.errors",
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
        yield f"| `{name}` | {words.replace('|', chr(92) + '|')} |"
    yield ""


def tables() -> str:
    """Return the tables of all doors."""
    return "\n" + "\n".join(line for door in DOORS for line in rows(door)).rstrip() + "\n"


def written(page: str) -> str:
    """Return the page with fresh tables."""
    return page.partition(MARK)[0] + MARK + tables()


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
