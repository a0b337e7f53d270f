"""Preferences: few, and every one takes effect at once."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from bozzetto_app.dialogs.dialog import Page, quiet
from bozzetto_app.i18n import tr
from bozzetto_app.settings import settings
from bozzetto_app.style.theme import Theme
from bozzetto_app.widgets.choice import Segments
from bozzetto_app.widgets.number_field import NumberField
from bozzetto_app.widgets.toggle import Toggle

__all__ = [
    "BACKEND",
    "BACKUPS",
    "RECENT",
    "REDUCED_MOTION",
    "SETTLE_TILT",
    "THEME",
    "PreferencesDialog",
]

THEME = "view/theme"
REDUCED_MOTION = "view/reduced_motion"
SETTLE_TILT = "view/settle_tilt"
BACKEND = "view/backend"
BACKUPS = "files/backups"
RECENT = "recent/files"

WORDS_WIDTH = 264
"""Width of the explanations, px: two lines at most."""


class PreferencesDialog(Page):
    """The settings that a person may want to change.

    Signals
    -------
    changed : str
        The key of the setting that has a new value.
    theme_chosen : Theme
    pen_tester_wanted
    """

    changed = Signal(str)
    theme_chosen = Signal(object)
    pen_tester_wanted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("preferences", tr("Preferences", "Preferences"), parent)
        self._grid = QGridLayout()
        self._grid.setHorizontalSpacing(24)
        self._grid.setVerticalSpacing(12)
        self._grid.setColumnStretch(0, 1)
        self.column.addLayout(self._grid)
        self.column.addStretch(1)

        self._heading(tr("Preferences", "Look"))
        self.theme = self._segments(
            THEME,
            tr("Preferences", "Theme"),
            (
                (Theme.SYSTEM.value, tr("Preferences", "System")),
                (Theme.LIGHT.value, tr("Preferences", "Light")),
                (Theme.DARK.value, tr("Preferences", "Dark")),
            ),
        )
        self.theme.chosen.connect(lambda value: self.theme_chosen.emit(Theme(value)))
        self.tilt = self._toggle(
            SETTLE_TILT,
            True,
            tr("Preferences", "Tilt a new shape once"),
            tr("Preferences", "The view tilts and returns, so that the eye sees depth."),
        )
        self.motion = self._toggle(
            REDUCED_MOTION,
            False,
            tr("Preferences", "Reduced motion"),
            tr("Preferences", "Views change at once; nothing tilts."),
        )
        self.backend = self._segments(
            BACKEND,
            tr("Preferences", "Viewport"),
            (
                ("auto", tr("Preferences", "Automatic")),
                ("gl", tr("Preferences", "OpenGL")),
                ("software", tr("Preferences", "Software")),
            ),
            tr("Preferences", "Takes effect at the next start."),
        )
        self._heading(tr("Preferences", "Pen"))
        self.pen = self._button(
            tr("Preferences", "Pressure curve"), tr("Preferences", "Open the pen tester…")
        )
        self.pen.clicked.connect(self.pen_tester_wanted)
        self._heading(tr("Preferences", "Files"))
        self.backups = NumberField(
            tr("Preferences", "Backups kept"), minimum=0, maximum=20, whole=True
        )
        self.backups.setFixedWidth(96)
        self.backups.setValue(float(_value(BACKUPS, 3, int)))
        self.backups.edited.connect(lambda value, going: self._set(BACKUPS, round(value)))
        self._row(
            tr("Preferences", "Backups kept"),
            self.backups,
            tr("Preferences", "How many older versions are kept beside each document."),
        )
        self.recent = self._button(
            tr("Preferences", "Recent files"), tr("Preferences", "Clear the list")
        )
        self._enable_recent()
        self.recent.clicked.connect(self._clear_recent)
        self.add_button(tr("Preferences", "&Close"), default=True).clicked.connect(self.accept)
        self.setMinimumWidth(600)

    def _set(self, key: str, value: object) -> None:
        settings().setValue(key, value)
        self.changed.emit(key)

    def _heading(self, words: str) -> None:
        label = QLabel(words)
        label.setProperty("type", "heading")
        label.setContentsMargins(0, 8 if self._grid.count() else 0, 0, 0)
        self._grid.addWidget(label, self._grid.rowCount(), 0, 1, 2)

    def _row(self, words: str, control: QWidget, help_: str = "") -> None:
        column = QVBoxLayout()
        column.setSpacing(2)
        column.addWidget(QLabel(words))
        if help_:
            explained = quiet(help_)
            explained.setMinimumWidth(WORDS_WIDTH)
            column.addWidget(explained)
        beside = QHBoxLayout()
        beside.addStretch(1)
        beside.addWidget(control)
        row = self._grid.rowCount()
        self._grid.addLayout(column, row, 0)
        self._grid.addLayout(beside, row, 1)

    def _toggle(self, key: str, default: bool, words: str, help_: str) -> Toggle:
        toggle = Toggle(words)
        toggle.setChecked(bool(_value(key, default, bool)))
        toggle.clicked.connect(lambda on: self._set(key, bool(on)))
        self._row(words, toggle, help_)
        return toggle

    def _segments(
        self, key: str, words: str, options: tuple[tuple[str, str], ...], help_: str = ""
    ) -> Segments:
        segments = Segments(words, options)
        segments.setMinimumWidth(segments.needed_width())
        kept = str(_value(key, options[0][0], str))
        segments.set_silently(kept if kept in dict(options) else options[0][0])
        segments.chosen.connect(lambda value: self._set(key, value))
        self._row(words, segments, help_)
        return segments

    def _button(self, words: str, on_button: str) -> QPushButton:
        button = QPushButton(on_button)
        button.setAutoDefault(False)
        self._row(words, button)
        return button

    def _enable_recent(self) -> None:
        there_are = bool(settings().value(RECENT))
        self.recent.setEnabled(there_are)
        self.recent.setToolTip("" if there_are else tr("Preferences", "The list is empty."))

    def _clear_recent(self) -> None:
        settings().remove(RECENT)
        self._enable_recent()
        self.changed.emit(RECENT)


def _value(key: str, default: object, kind: type[Any]) -> Any:
    """Return a setting; an unusable value in the file counts as the default."""
    try:
        return settings().value(key, default, kind)
    except (TypeError, ValueError):
        return default
