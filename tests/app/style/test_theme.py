"""The look: legible in both themes, and dressed from one place."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QLabel, QLineEdit

from bozzetto.scene.contrast import contrast, readable
from bozzetto.scene.palette import DARK, LIGHT
from bozzetto_app.style import theme
from bozzetto_app.style.colors import tones_of
from bozzetto_app.style.theme import Theme, apply_theme, current_palette, palette_for, style_sheet
from bozzetto_app.widgets.number_field import NumberField

BOTH = pytest.mark.parametrize("palette", [LIGHT, DARK], ids=lambda p: p.name)


def test_contrast_agrees_with_published_pairs():
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21.0)
    # the grey that WCAG tutorials name as just failing, and the one that just passes
    assert contrast((0x77, 0x77, 0x77), (255, 255, 255)) == pytest.approx(4.48, abs=0.01)
    assert contrast((0x76, 0x76, 0x76), (255, 255, 255)) == pytest.approx(4.54, abs=0.01)


@BOTH
@pytest.mark.parametrize("text", ["text", "quiet", "accent_text", "second", "warning", "good"])
@pytest.mark.parametrize("ground", ["panel", "field", "raised", "chosen"])
def test_text_is_legible(palette, text, ground):
    mixed = tones_of(palette)
    assert contrast(getattr(mixed, text), getattr(mixed, ground)) >= 4.5


@BOTH
def test_text_on_the_accent_is_legible(palette):
    mixed = tones_of(palette)
    assert contrast(mixed.on_accent, mixed.accent_fill) >= 4.5


@BOTH
def test_marks_stand_out_from_their_ground(palette):
    """WCAG 1.4.11: what must be seen, but not read, needs 3:1."""
    mixed = tones_of(palette)
    for ground in (mixed.panel, mixed.field):
        assert contrast(mixed.accent, ground) >= 3.0
        assert contrast(mixed.second, ground) >= 3.0


def test_a_legible_colour_is_left_alone():
    assert readable((10, 10, 10), (0, 0, 0), (255, 255, 255)) == (10, 10, 10)


@BOTH
def test_the_program_is_dressed(qtbot, qapp, palette):
    apply_theme(qapp, palette)
    label = QLabel("x")
    qtbot.addWidget(label)
    label.ensurePolished()
    shown = label.palette().color(QPalette.ColorRole.WindowText)
    assert (shown.red(), shown.green(), shown.blue()) == palette.ink
    assert current_palette() is palette


@BOTH
def test_what_cannot_be_changed_is_grey(qtbot, qapp, palette):
    """The number in a field that is off was as dark as any."""
    apply_theme(qapp, palette)
    for widget in (NumberField("Share"), QLineEdit("Name"), QLabel("Label")):
        qtbot.addWidget(widget)
        widget.setEnabled(False)
        widget.ensurePolished()
        text = getattr(widget, "lineEdit", lambda one=widget: one)()
        shown = text.palette().color(QPalette.ColorGroup.Disabled, text.foregroundRole())
        assert shown.getRgb()[:3] == tones_of(palette).disabled, type(widget).__name__


@BOTH
def test_the_style_sheet_names_only_what_there_is(qapp, palette):
    sheet = style_sheet(palette)
    assert "$" not in sheet
    for part in sheet.split("url(")[1:]:
        assert os.path.exists(part.split(")")[0])


def test_themes_resolve(qapp):
    assert palette_for(Theme.LIGHT) is LIGHT
    assert palette_for(Theme.DARK) is DARK
    assert palette_for(Theme.SYSTEM) in (LIGHT, DARK)


def test_everything_doubles_on_a_screen_of_200_percent():
    script = (
        "from PySide6.QtWidgets import QApplication\n"
        "app = QApplication([])\n"
        "from bozzetto.scene.palette import LIGHT\n"
        "from bozzetto_app.style.theme import apply_theme\n"
        "from bozzetto_app.widgets.icon_button import IconButton\n"
        "apply_theme(app, LIGHT)\n"
        "button = IconButton('cube', 'Cube')\n"
        "button.setFixedSize(20, 20)\n"
        "image = button.grab().toImage()\n"
        "def inked(x, y): return image.pixelColor(x, y).lightness() < 128\n"
        "rows = [sum(inked(x, y) for x in range(40)) for y in range(40)]\n"
        "print(image.width(), image.height(), any(a != b for a, b in zip(rows[::2], rows[1::2])))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "QT_SCALE_FACTOR": "2", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    # neighbouring rows differ somewhere: the drawing was rendered, not blown up
    assert done.stdout.split() == ["40", "40", "True"], done.stderr


def test_the_style_sheets_icons_are_kept_and_no_temporary_folder_is_left(home, qapp, monkeypatch):
    monkeypatch.setattr(tempfile, "mkdtemp", None)
    folders = set()
    for palette in (LIGHT, DARK, LIGHT):
        sheet = style_sheet(palette)
        folders |= {part.split(")")[0] for part in sheet.split("url(")[1:]}
    files = {Path(name.strip("\"'")) for name in folders}
    assert files
    for file in files:
        assert home in file.parents
        assert b"currentColor" not in file.read_bytes()


def test_a_cache_that_cannot_be_written_costs_the_icons_only(home, qapp, monkeypatch):
    (home / "file").write_bytes(b"")
    monkeypatch.setattr(theme, "cache_folder", lambda: home / "file")
    assert "url(" in theme.style_sheet(LIGHT)


def test_the_style_is_ours_whatever_the_system_wants():
    script = (
        "from bozzetto_app.application import Application\n"
        "print(Application(['bozzetto']).style().name())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={
            **os.environ,
            "QT_STYLE_OVERRIDE": "Windows",
            "PYTHONPATH": os.pathsep.join(sys.path),
        },
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert done.stdout.strip().lower() == "fusion"
