"""Icons: one family, tinted, and crisp."""

from __future__ import annotations

import ast
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QImage, QPainter

import bozzetto_app
from bozzetto.scene.palette import DARK, LIGHT
from bozzetto_app.style.icons import (
    FOLDER,
    LARGEST_FILE,
    icon,
    icon_from_file,
    icon_names,
    paint_icon,
)

APP = Path(bozzetto_app.__file__).parent


def painted(name: str, side: int = 20, color: tuple[int, int, int] = (255, 0, 0)) -> QImage:
    image = QImage(side, side, QImage.Format.Format_ARGB32)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    assert paint_icon(painter, name, QRectF(0, 0, side, side), color)
    painter.end()
    return image


def inked(image: QImage) -> list[tuple[int, int]]:
    return [
        (x, y)
        for x in range(image.width())
        for y in range(image.height())
        if image.pixelColor(x, y).alpha() > 40
    ]


@pytest.mark.parametrize("name", icon_names())
def test_an_icon_belongs_to_the_family(qapp, name):
    root = ElementTree.fromstring((FOLDER / f"{name}.svg").read_text())
    assert root.get("viewBox") == "0 0 20 20"
    assert root.get("stroke") == "currentColor"
    assert root.get("stroke-width") == "1.5"
    places = inked(painted(name))
    assert 8 <= len(places) <= 300
    assert all(1 <= x <= 18 and 1 <= y <= 18 for x, y in places), "it leaves the grid's margin"


def test_an_icon_takes_the_colour_asked_for(qapp):
    image = painted("stop", 40, (12, 200, 34))
    solid = [image.pixelColor(x, y) for x, y in inked(image)]
    strongest = max(solid, key=lambda color: color.alpha())
    assert (strongest.red(), strongest.green(), strongest.blue()) == (12, 200, 34)


def test_both_themes_differ(qapp):
    light = icon("cube", LIGHT).pixmap(QSize(20, 20)).toImage()
    dark = icon("cube", DARK).pixmap(QSize(20, 20)).toImage()
    assert light != dark


@pytest.mark.parametrize("scale", [1.0, 1.25, 1.5, 2.0, 3.0])
def test_a_qicon_is_exact_on_every_usual_screen(qapp, scale):
    pixmap = icon("cube", LIGHT).pixmap(QSize(20, 20), scale)
    assert pixmap.width() == round(20 * scale)


def test_an_unknown_name_is_a_mistake(qapp):
    with pytest.raises(KeyError):
        icon("no-such-icon", LIGHT)


@pytest.mark.parametrize(
    "content", [b"", b"not svg", b"\xff\xfe\x00", b"<svg", b"x" * (LARGEST_FILE + 1)]
)
def test_a_plugins_bad_icon_is_only_missing(qapp, tmp_path, content):
    path = tmp_path / "bad.svg"
    path.write_bytes(content)
    assert icon_from_file(path, LIGHT).isNull()
    assert icon_from_file(tmp_path / "absent.svg", LIGHT).isNull()


def test_every_icon_that_the_shell_names_exists():
    """In calls of IconButton, paint_icon and Action, as far as it is written out there."""
    known, asked = set(icon_names()), set()
    for path in APP.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            called = getattr(node.func, "id", "")
            place = {"IconButton": 0, "paint_icon": 1, "icon": 0, "Action": 3}.get(called)
            if place is not None and len(node.args) > place:
                value = node.args[place]
                if isinstance(value, ast.Constant) and isinstance(value.value, str):
                    asked.add(value.value or "cube")
    assert len(asked) >= 8
    assert asked <= known
