"""Pictures of the templates to choose from: bundled ones, those of plugins, and a person's own.

A thread reads what is kept and draws the pictures.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QEvent, QRectF, QSize, QStandardPaths, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QImage,
    QKeySequence,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QShowEvent,
)
from PySide6.QtWidgets import QAbstractButton, QGridLayout, QSizePolicy, QWidget

from bozzetto.errors import UserError
from bozzetto.plugin import TemplateFile, override
from bozzetto.scene import Palette
from bozzetto_app.toolkit import PanelWorker, palette_of
from bozzetto_car.panel.car_picture import Pose, SmallCar, small_car
from bozzetto_car.panel.colors import role
from bozzetto_car.solver.pipeline import template_of
from bozzetto_car.state import CarState
from bozzetto_car.template.kept_templates import (
    KeptTemplate,
    forget_template,
    kept_templates,
    plugin_template,
)
from bozzetto_car.template.loader import TEMPLATES, bundled, bundled_title
from bozzetto_car.template.model import Template, article_of, noun_of

SIZE: Final = (64, 35)
"""Size of a picture, px."""

LINE: Final = 16
"""Height of the name under it, px."""

SMALLER: Final = 0.85
"""Size of the name relative to other text."""

COLUMNS: Final = 4
"""Pictures beside each other."""

POSE: Final = Pose(62.0, 14.0)
"""Nose, side and roof are seen, which tell the templates apart."""

FOLDER: Final = "car templates"
"""Name of the folder with the templates that a person keeps, among the program's own data."""

FORGET: Final = "Remove from the list"

Role = QPalette.ColorRole


def template_folder() -> Path:
    """Return the folder with the templates that a person keeps; it need not exist."""
    kind = QStandardPaths.StandardLocation.AppLocalDataLocation
    return Path(QStandardPaths.writableLocation(kind)) / FOLDER


@dataclass(frozen=True, eq=False)
class Drawn:
    """A template that is offered, and its picture.

    Attributes
    ----------
    key : str
        Id of a bundled one; the file of one of the person's own.
    title : str
        Of the template.
    car : SmallCar
    kept : KeptTemplate or None
        None for a bundled one, one of a plugin, and one that is the car's only.
    plugin : str
        Name of the plugin that brings it; "" for others.
    """

    key: str
    title: str
    car: SmallCar
    kept: KeptTemplate | None = None
    plugin: str = ""


class TemplatePictures(QWidget):
    """Pictures of the bundled templates, those of plugins and of the person, and the car's own.

    Parameters
    ----------
    brought : sequence of TemplateFile
        Those of plugins; of one that cannot be used is told why, once.
    parent : QWidget

    Signals
    -------
    chosen : str, str
        A person chose this one: the template of the state, and the file of an own one or "".
    refused : UserError
        Something could not be done.
    """

    chosen = Signal(str, str)
    refused = Signal(object)

    def __init__(self, brought: Sequence[TemplateFile], parent: QWidget) -> None:
        super().__init__(parent)
        self._brought = tuple(brought)
        self._told: set[str] = set()
        self.setObjectName("car-guide-templates")
        self.setAccessibleName("Templates")
        self._work = PanelWorker(self)
        self._drawn: tuple[Palette, float, str] | None = None
        self._current, self._own = "", ""
        self.buttons: dict[str, PictureButton] = {}
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(4)
        for name in TEMPLATES:
            self._add(name, bundled_title(name))

    @property
    def busy(self) -> bool:
        """Whether pictures are being drawn."""
        return self._work.busy

    def show_template(self, state: CarState) -> None:
        """Show which one is the car's."""
        self._current = state.own if state.template == "own" else state.template
        if state.own != self._own:
            self._own = state.own
            self._draw()
        self._check()

    def look_again(self) -> None:
        """Read anew which templates the person keeps."""
        self._drawn = None
        self._draw()

    def _check(self) -> None:
        for key, button in self.buttons.items():
            button.setChecked(key == self._current)

    def _choose(self, key: str) -> None:
        self._check()
        self.buttons[key].setChecked(True)
        self.chosen.emit(key if key in TEMPLATES else "own", "" if key in TEMPLATES else key)

    # -- the buttons -------------------------------------------------------------------------------

    def _add(
        self, key: str, title: str, kept: KeptTemplate | None = None, plugin: str = ""
    ) -> None:
        button = PictureButton(title, self)
        if plugin:
            button.setToolTip(f"{button.toolTip()}. From the plugin {plugin}")
        button.clicked.connect(partial(self._choose, key))
        if kept is not None:
            button.offer(FORGET, partial(self._forget, kept))
        self.buttons[key] = button
        row, column = divmod(len(self.buttons) - 1, COLUMNS)
        self._grid.addWidget(button, row, column)

    def _drop(self, key: str) -> None:
        button = self.buttons.pop(key)
        self._grid.removeWidget(button)
        button.hide()
        button.deleteLater()

    def _show(self, drawn: list[Drawn], scale: float) -> None:
        """Show the pictures; what has gone or come since has its button no more, or anew."""
        for key in [key for key in self.buttons if key not in TEMPLATES]:
            self._drop(key)
        for one in drawn:
            if one.key not in self.buttons:
                self._add(one.key, one.title, one.kept, one.plugin)
            self.buttons[one.key].show_car(one.car, scale)
        self._check()

    def _forget(self, kept: KeptTemplate) -> None:
        try:
            forget_template(kept)
        except UserError as problem:
            self.refused.emit(problem)
        self.look_again()

    # -- the pictures ------------------------------------------------------------------------------

    def _draw(self) -> None:
        """Ask for the pictures where the colours, the pixels or the templates are others."""
        palette, scale, own = palette_of(self), self.devicePixelRatioF(), self._own
        if (palette, scale, own) == self._drawn or not self.isVisible():
            return
        self._drawn = palette, scale, own
        folder, brought = template_folder(), self._brought

        def work() -> tuple[list[Drawn], list[UserError]]:
            problems: list[UserError] = []
            drawn = [
                Drawn(key, one.title, small_car(one, "", POSE, palette, SIZE, scale), kept, plugin)
                for key, one, kept, plugin in _offered(folder, own, brought, problems)
            ]
            return drawn, problems

        def done(made: tuple[list[Drawn], list[UserError]]) -> None:
            self._show(made[0], scale)
            for problem in made[1]:
                if problem.message not in self._told:
                    self._told.add(problem.message)
                    self.refused.emit(problem)

        self._work.ask(work, done)

    @override
    def showEvent(self, event: QShowEvent) -> None:
        self._draw()

    @override
    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        self._draw()


def _offered(
    folder: Path, own: str, brought: Sequence[TemplateFile], problems: list[UserError]
) -> Iterator[tuple[str, Template, KeptTemplate | None, str]]:
    """Yield what can be chosen: its key, the template, what the person keeps of it, its plugin."""
    for name in TEMPLATES:
        yield name, bundled(name), None, ""
    mine = json.loads(own) if own else None
    there: list[tuple[KeptTemplate, str]] = []
    for file in brought:
        try:
            there.append((plugin_template(file), file.plugin_name))
        except UserError as problem:
            problems.append(problem)
    for kept, plugin in (*there, *((kept, "") for kept in kept_templates(folder))):
        # A file that was imported is written otherwise in the car, and the same template.
        is_mine = mine is not None and json.loads(kept.source) == mine
        mine = None if is_mine else mine
        yield own if is_mine else kept.source, kept.template, None if plugin else kept, plugin
    if mine is not None:
        with suppress(UserError):  # the program tells it, where it solves the car
            yield own, template_of(CarState(template="own", own=own)), None, ""


class PictureButton(QAbstractButton):
    """A template to choose: its picture and its name."""

    def __init__(self, title: str, parent: QWidget) -> None:
        super().__init__(parent)
        noun = noun_of(title)
        self.setText(title)
        self.setAccessibleName(title)
        self.setToolTip(f"The car takes its shape from {article_of(noun)} {noun}; marks stay")
        self.setCheckable(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setFixedHeight(SIZE[1] + LINE + 8)
        self._image = QImage()

    def offer(self, words: str, done: Callable[[], None]) -> None:
        """Offer something in the context menu, and by the Delete key."""
        action = QAction(words, self)
        action.setShortcut(QKeySequence(QKeySequence.StandardKey.Delete))
        action.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        action.triggered.connect(done)
        self.addAction(action)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def show_car(self, car: SmallCar, scale: float) -> None:
        """Show a picture of the template."""
        height, width = car.pixels.shape[:2]
        image = QImage(car.pixels.tobytes(), width, height, QImage.Format.Format_RGBA8888)
        self._image = image.copy()  # the bytes go with the call
        self._image.setDevicePixelRatio(scale)
        self.update()

    @override
    def sizeHint(self) -> QSize:
        return QSize(SIZE[0] + 4, SIZE[1] + LINE + 8)

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        ground = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(Qt.PenStyle.NoPen)
        if self.isChecked() or self.underMouse():
            painter.setBrush(role(self, Role.Accent if self.isChecked() else Role.WindowText, 0.14))
            painter.drawRoundedRect(ground, 4.0, 4.0)
        if self.isChecked() or self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(role(self, Role.Link if self.hasFocus() else Role.Accent), 1.0))
            painter.drawRoundedRect(ground, 4.0, 4.0)
        wide = min(float(SIZE[0]), self.width() - 6.0)
        high = wide * SIZE[1] / SIZE[0]
        left, top = 0.5 * (self.width() - wide), 4.0 + 0.5 * (SIZE[1] - high)
        painter.drawImage(QRectF(left, top, wide, high), self._image)
        painter.setPen(role(self, Role.WindowText))
        font = self.font()
        font.setPixelSize(round(SMALLER * self.fontInfo().pixelSize()))
        painter.setFont(font)
        below = self.rect().adjusted(2, SIZE[1] + 4, -2, -2)
        words = painter.fontMetrics().elidedText(
            self.text(), Qt.TextElideMode.ElideRight, below.width()
        )
        painter.drawText(below, Qt.AlignmentFlag.AlignCenter, words)
