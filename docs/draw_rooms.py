"""Draw the rooms of the code: ``python docs/draw_rooms.py`` writes ``docs/pictures/rooms.svg``.

A room is a module or folder directly below a package. What is drawn is measured from the code's
own imports: a room stands in a row above every room that it imports. ``--sizes`` prints a table
of files, lines, rooms, imports between rooms, and circles of rooms.
"""

from __future__ import annotations

import argparse
import ast
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "pictures" / "rooms.svg"
COLUMNS = (
    (("core", "bozzetto"), ("app", "bozzetto_app")),
    (
        ("plugins", "bozzetto_silhouette"),
        ("plugins", "bozzetto_symmetry"),
        ("plugins", "bozzetto_car"),
    ),
    (
        ("plugins", "bozzetto_product"),
        ("plugins", "bozzetto_polyhedron"),
        ("plugins", "bozzetto_mesh"),
        ("plugins", "bozzetto_skin"),
    ),
)
WIDTH, MARGIN, ROW, GAP, TITLE = 500, 24, 40, 8, 40
CHARACTER = 8.2
"""Width of a letter at 13 px, px."""


@dataclass(frozen=True)
class Package:
    """A package's modules, their lines, and which room imports which.

    Parameters
    ----------
    name : str
    lines : mapping of room to its lines
    files : int
    imports : mapping of room to the rooms that it imports
    """

    name: str
    lines: Mapping[str, int]
    files: int
    imports: Mapping[str, AbstractSet[str]]

    def rows(self) -> tuple[list[list[str]], list[str]]:
        """Rows of rooms from the bottom, and the rooms that lie in or above a circle."""
        left, rows = set(self.lines), []
        while row := sorted(r for r in left if not (self.imports[r] & left)):
            rows.append(row)
            left.difference_update(row)
        return rows, sorted(left)


def measured(folder: str, name: str) -> Package:
    """Read a package's imports as text; nothing is imported."""
    top = ROOT / folder / name
    modules = {_module(path, top.parent): path for path in sorted(top.rglob("*.py"))}
    lines: dict[str, int] = {}
    imports: dict[str, set[str]] = {}
    for module, path in modules.items():
        text = path.read_text(encoding="utf-8")
        room = _room(module)
        if not room:  # the package's own __init__ may name anything
            continue
        lines[room] = lines.get(room, 0) + text.count("\n")
        found = _imported(ast.parse(text), modules)
        reached = {_room(other) for other in found if other in modules}
        imports.setdefault(room, set()).update(reached - {room, ""})
    return Package(name, lines, len(modules), imports)


def _module(path: Path, base: Path) -> str:
    parts = path.relative_to(base).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _room(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def _imported(tree: ast.Module, modules: Mapping[str, Path]) -> Iterator[str]:
    typing_only = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if id(node) in typing_only:
            continue
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                yield whole if whole in modules else node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def drawn(columns: Sequence[Sequence[Package]]) -> str:
    """Draw every package as rows of boxes, side by side, as SVG."""
    body: list[str] = []
    height = 0.0
    for number, packages in enumerate(columns):
        left = float(MARGIN + number * WIDTH)
        top = float(MARGIN)
        for package in packages:
            rows, circle = package.rows()
            total = sum(package.lines.values())
            title = f"{package.name}: {package.files} files, {total:,} lines"
            body.append(_text(left, top + 18, title, "title"))
            top += TITLE
            for row in [*([circle] if circle else []), *reversed(rows)]:
                top = _draw_row(body, package, row, left, top)
            top += MARGIN
        height = max(height, top)
    wide = WIDTH * len(columns) + MARGIN
    style = (
        "text{font-family:system-ui,sans-serif;font-size:13px;fill:#24211d}.title{font-weight:600;font-size:15px}"
        ".lines{font-size:11px;fill:#6b655c}rect{fill:#f6f4ef;stroke:#b9b2a5}"
        ".page{fill:#fffdf8;stroke:none}"
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {height:.0f}">'
    page = f'<rect class="page" width="{wide}" height="{height:.0f}"/>'
    return "\n".join([head, f"<style>{style}</style>", page, *body, "</svg>", ""])


def _draw_row(
    body: list[str], package: Package, row: Sequence[str], start: float, top: float
) -> float:
    left = start
    for room in row:
        lines = f"{package.lines[room]:,}"
        wide = CHARACTER * len(room) + 6.2 * len(lines) + 34
        if left + wide > start + WIDTH - MARGIN:
            left, top = start, top + ROW
        box = f'<rect x="{left:.0f}" y="{top:.0f}" width="{wide:.0f}" height="{ROW - GAP}" rx="4"/>'
        body.append(box)
        body.append(_text(left + 10, top + 21, room, ""))
        body.append(_text(left + 18 + CHARACTER * len(room), top + 21, lines, "lines"))
        left += wide + GAP
    return top + ROW


def _text(x: float, y: float, text: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x:.0f}" y="{y:.0f}">{escape(text)}</text>'


def sizes(packages: Sequence[Package]) -> str:
    """Return a table of sizes in Markdown."""
    lines = ["| package | files | lines | rooms | imports between rooms | rooms in circles |"]
    lines.append("|" + " --- |" * 6)
    for package in packages:
        _, circle = package.rows()
        arrows = sum(len(reached) for reached in package.imports.values())
        cells = (
            package.name, f"{package.files}", f"{sum(package.lines.values()):,}",
            f"{len(package.lines)}", f"{arrows}", f"{len(circle)}",
        )  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Write the picture, or print the sizes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", action="store_true", help="print a table instead")
    columns = [[measured(*where) for where in column] for column in COLUMNS]
    if parser.parse_args().sizes:
        print(sizes([package for column in columns for package in column]))
    else:
        PICTURE.write_text(drawn(columns), encoding="utf-8")


if __name__ == "__main__":
    main()
