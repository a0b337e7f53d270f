"""Files for a monkey to open, drop and paste: good ones, and what people take for good ones."""

from __future__ import annotations

import random
from pathlib import Path

from PySide6.QtGui import QImage, QPainter

from bozzetto.plugin.host.registry import Registry

__all__ = ["write_files"]

CUBE = """\
o cube
v 0 0 0\nv 40 0 0\nv 40 40 0\nv 0 40 0\nv 0 0 40\nv 40 0 40\nv 40 40 40\nv 0 40 40
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
"""
DRAWING = """\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 300 200">
<path d="M 40 100 C 40 20 260 20 260 100 S 40 180 40 100 z" fill="none" stroke="black"/></svg>
"""
INKML = """\
<ink xmlns="http://www.w3.org/2003/InkML"><trace>10 10, 20 30, 40 60, 80 60, 90 10</trace></ink>
"""


def write_files(folder: Path, registry: Registry, chance: random.Random) -> list[Path]:
    """Fill a folder and return what can be opened: these files, and the modelers' samples."""
    folder.mkdir(parents=True, exist_ok=True)
    words = {
        "cube.obj": CUBE,
        "drawing.svg": DRAWING,
        "ink.inkml": INKML,
        "notes.txt": "Milk, bread, clay.",
        "empty.obj": "",
        "broken.svg": DRAWING[:70],
        "broken.json": '{"format": ',
        "no document.bozz": "This is no document.",
    }
    made = []
    for name, text in words.items():
        (folder / name).write_text(text, encoding="utf-8")
        made.append(folder / name)
    for name in ("noise.png", "noise.stl", "noise.glb", "noise.bozz", "noise"):
        (folder / name).write_bytes(chance.randbytes(3000))
        made.append(folder / name)
    picture = QImage(320, 240, QImage.Format.Format_RGB32)
    picture.fill(0xFFEEDDCC)
    painter = QPainter(picture)
    painter.drawEllipse(60, 40, 200, 160)
    painter.end()
    for name in ("picture.png", "picture.jpg"):
        picture.save(str(folder / name))
        made.append(folder / name)
    samples = [sample for info in registry.modelers() for sample in info.samples]
    return [*made, folder / "missing.obj", folder, *samples]
