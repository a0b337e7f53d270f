"""Write `contract.md`: everything between a plugin and the program, read from the code.

    python docs/write_contract.py

`bozzetto.plugin` stands there as its source has it, without the bodies of functions. The names of
the other public packages stand in `toolkit.md`; see `write_toolkit.py`.
"""

from __future__ import annotations

import ast
import importlib
import inspect
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import get_args

from bozzetto.plugin import API_VERSION, hooks
from bozzetto.plugin.host import manifest

PAGE = Path(__file__).parent / "contract.md"

PLUGIN = "bozzetto.plugin"

CHAPTERS = {
    "Modelers": ("Modeler",),
    "Tools": ("Tool", "Preview"),
    "Gestures": ("Ink", "Tap", "Drag", "Gesture"),
    "Models made of parts": ("Part", "Group", "PartsState", "PartsModeler"),
    "What a person is told": ("NextStep", "Figure", "Caution", "ViewAdvice"),
    "Commands and parameters": ("Command", "Parameter"),
    "The world around": ("Context", "PenSettings", "Job", "remembered", "Remembered"),
    "Errors": ("UserError", "Unfinished", "Cancelled"),
    "Panels": ("PanelHost",),
}
"""The names of `bozzetto.plugin` in the order in which they are read."""

BESIDE = ("cached_property", "API_VERSION", "hookimpl", "override")
"""Names that a chapter explains in words."""

HEAD = f"""# The contract

Everything between a plugin and the program, in version {API_VERSION[0]}.{API_VERSION[1]} \
(`bozzetto.plugin.API_VERSION`). This page is
written from the code by `python docs/write_contract.py`. The [guide](plugin-authors-guide.md) shows
how the pieces go together, and the [toolkit](toolkit.md) lists what else may be imported: strokes,
geometry, scenes, cameras, errors.

World coordinates are right-handed millimetres with Z up; canvas coordinates are pixels with y down.
Arrays that are given are copied and made read-only; a wrong shape, a number that is not finite or
an index that does not exist raises `ValueError`.

`override` is `typing.override` (on Python 3.11 that of `typing_extensions`): written over a method,
it makes a type checker refuse a name or a signature that the contract does not have.
`cached_property` is that of `functools`; on Python 3.11 it is one without a lock, for which no
thread waits while another computes.
"""

HOOKS = """## Hooks

Functions of the plugin's package with these names and the decorator `hookimpl`. Arguments come by
keyword; those that are not needed may be left out.
"""

MANIFEST = """## The manifest

`plugin.toml`, beside the package's `__init__.py`. Keys without a default must be there.
"""


def page() -> str:
    """Return the whole page."""
    public = importlib.import_module(PLUGIN).__all__
    placed = {name for names in CHAPTERS.values() for name in names}
    further = tuple(sorted(set(public) - placed - set(BESIDE)))
    chapters = CHAPTERS | ({"Further names": further} if further else {})
    parts = [HEAD]
    for title, names in chapters.items():
        parts.append(f"## {title}\n")
        parts += [_code(outline(PLUGIN, name)) for name in names if name in public]
    parts += [HOOKS, *(_code(outline(hooks.__name__, name)) for name in _hooks())]
    parts += [MANIFEST, *_manifest()]
    return "\n".join(parts)


def _code(text: str) -> str:
    return f"```python\n{text}\n```\n"


# -- outlines of source ----------------------------------------------------------------------


def outline(package: str, name: str) -> str:
    """Return a public name as its module has it, without bodies and without private names."""
    value = getattr(importlib.import_module(package), name)
    home = getattr(value, "__module__", "")
    module = home if home.startswith("bozzetto.") else _home_of_alias(package, name)
    statement = next(node for node in _statements(module) if name in _names(node))
    return ast.unparse(_bare(statement))


def _home_of_alias(package: str, name: str) -> str:
    """Return the module that the package imports a plain value from."""
    for node in ast.walk(_tree(package)):
        if isinstance(node, ast.ImportFrom) and any(alias.name == name for alias in node.names):
            return str(node.module)
    return package


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(inspect.getsource(importlib.import_module(module)))


def _statements(module: str) -> list[ast.stmt]:
    return _tree(module).body


def _names(node: ast.AST) -> tuple[str, ...]:
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return (node.name,)
    if isinstance(node, ast.AnnAssign):
        return (ast.unparse(node.target),)
    if isinstance(node, ast.Assign):
        return tuple(ast.unparse(target) for target in node.targets)
    return ()


def _bare(node: ast.stmt) -> ast.stmt:
    """Return a statement with what a reader needs of it."""
    if isinstance(node, ast.FunctionDef):
        said = ast.get_docstring(node, clean=False)
        node.body = node.body[:1] if said else [ast.Expr(ast.Constant(...))]
    if isinstance(node, ast.ClassDef):
        kept = [part for part in node.body if _is_read(part)]
        node.body = [_bare(part) for part in kept] or [ast.Pass()]
    return node


def _is_read(node: ast.stmt) -> bool:
    names = _names(node)
    if "__init__" in names:
        return True
    if names:
        return not names[0].startswith("_")
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


# -- hooks and the manifest --------------------------------------------------------------------


def _hooks() -> list[str]:
    return [name for name in vars(hooks) if name.startswith("bozzetto_")]


def _manifest() -> Iterator[str]:
    for title, kind in (
        ("The plugin", manifest.Manifest),
        ("Every `[[modeler]]`", manifest.ModelerEntry),
    ):
        told = _attributes(inspect.getdoc(kind) or "")
        yield f"### {title}\n\n| key | default | |\n|---|---|---|"
        for key, default in _defaults(kind):
            if key == "warnings":  # it is made while the file is read
                continue
            if key == manifest.MODELER:
                key, told = "[[modeler]]", told | {"[[modeler]]": "A table for every modeler."}
            yield f"| `{key}` | {default} | {told.get(key, '')} |"
        yield ""
    abilities = ", ".join(f'`"{name}"`' for name in get_args(manifest.Ability))
    yield f"Abilities: {abilities}.\n"


def _defaults(table: type) -> Iterator[tuple[str, str]]:
    """Yield the keys of a table with their defaults, those that must be there first."""
    fields = table.__struct_encode_fields__  # type: ignore[attr-defined]
    defaults = table.__struct_defaults__  # type: ignore[attr-defined]
    required = len(fields) - len(defaults)
    for key, default in zip(fields, (None,) * required + defaults, strict=True):
        if default is None:
            yield key, ""
        elif isinstance(default, int):
            yield key, f"`{default}`".lower()
        else:
            yield key, "none"


def _attributes(text: str) -> dict[str, str]:
    """Return what a docstring in numpydoc says of each attribute, on one line."""
    told: dict[str, str] = {}
    names: list[str] = []
    for line in text.partition("----------\n")[2].splitlines():
        if line and not line.startswith(" "):
            names = [name.strip() for name in line.partition(":")[0].split(",")]
        for name in names if line.startswith(" ") else ():
            told[name] = f"{told.get(name, '')} {line.strip()}".strip()
    return told


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
