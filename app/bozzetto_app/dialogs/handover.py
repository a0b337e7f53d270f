"""“Export”: formats, unit, axes, size and triangles, with what the files would be beside them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, cast

from PySide6.QtCore import QLocale, Qt, QTimer
from PySide6.QtGui import QImage, QPixmap, QShowEvent
from PySide6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QWidget,
)

from bozzetto.exchange.handover import FEWEST_QUADS, SCALES, Handover, Lines, Unit, Up
from bozzetto_app.dialogs.dialog import Page, label, quiet
from bozzetto_app.i18n import tr
from bozzetto_app.session.exchange import PictureCanvas
from bozzetto_app.session.format_order import offered_formats
from bozzetto_app.settings import settings
from bozzetto_app.style.theme import FRAME
from bozzetto_app.toolkit import palette_of
from bozzetto_app.toolkit.panel_scroll import PanelScroll
from bozzetto_app.widgets.choice import Segments
from bozzetto_app.widgets.number_field import NumberField
from bozzetto_app.widgets.toggle import Toggle

if TYPE_CHECKING:
    from bozzetto_app.dialogs.file_dialogs import FileQuestions
    from bozzetto_app.session.exchange import Foreseen
    from bozzetto_app.session.session import Session

__all__ = ["HandoverDialog"]

KEPT: Final = "handover/"
"""Where the last choice stands in the settings."""

USUAL: Final = "usual"
PAUSE_MS: Final = 250
"""Time after a change before anything is made, ms: typing and dragging change often."""

COLUMNS: Final = 4
"""Formats in a row."""

WIDE: Final = 880
"""Width of a screen, px, from which on the picture and what is said stand beside the switches."""

PICTURE: Final = (400, 160)
PICTURE_BESIDE: Final = (320, 280)
"""Width and height of the picture below the switches and beside them, pixels of the window."""

LIST_HEIGHT: Final = 96
LABEL_WIDTH: Final = 120
MOST_TRIANGLES: Final = 5e7
MOST_QUADS: Final = 2e5
USUAL_QUADS: Final = 5000.0


class HandoverDialog(Page):
    """Asks what to export and how, and shows what the files would be.

    Parameters
    ----------
    session : Session
    questions : FileQuestions
        Asks where the files go.
    parent : QWidget, optional
    """

    def __init__(
        self, session: Session, questions: FileQuestions, parent: QWidget | None = None
    ) -> None:
        super().__init__("handover", tr("Handover", "Export"), parent)
        self._session, self._questions = session, questions
        self._kept = settings()
        self._is_wide = self.screen().availableGeometry().width() >= WIDE
        self._picture_size = PICTURE_BESIDE if self._is_wide else PICTURE
        self._add_formats()
        self._add_objects()
        self._add_choices()
        self._add_what_is_told()
        cancel = self.add_button(tr("Handover", "&Cancel"))
        cancel.clicked.connect(self.reject)
        self.go = self.add_button(tr("Handover", "&Export…"), default=True)
        self.go.clicked.connect(self._export)
        self._pause = QTimer(self)
        self._pause.setSingleShot(True)
        self._pause.setInterval(PAUSE_MS)
        self._pause.timeout.connect(self._look)
        session.files.exchange.foreseen.connect(self._show)
        session.files.exchange.not_foreseen.connect(self._refuse)
        session.drawing.changed.connect(self._change)
        session.drawing.closing.connect(self.reject)
        self.finished.connect(session.files.exchange.forget)
        self._change()

    def _add_formats(self) -> None:
        self.column.addWidget(label(tr("Handover", "Formats"), kind="heading"))
        offered = offered_formats(self._session)
        last = str(self._kept.value(f"{KEPT}formats", "")).split()
        chosen = [one.id for one in offered if one.id in last] or [offered[0].id]
        grid = QGridLayout()
        grid.setVerticalSpacing(8)
        self.formats: dict[str, Toggle] = {}
        for number, one in enumerate(offered):
            toggle = Toggle(one.title)
            toggle.setToolTip(one.title)
            toggle.setChecked(one.id in chosen)
            toggle.toggled.connect(self._change)
            cell = QHBoxLayout()
            cell.setSpacing(8)
            cell.addWidget(toggle)
            name = QLabel(one.short)
            name.setToolTip(one.title)
            cell.addWidget(name, 1)
            grid.addLayout(cell, number // COLUMNS, number % COLUMNS)
            self.formats[one.id] = toggle
        self._offered = {one.id: one for one in offered}
        self.column.addLayout(grid)

    def _add_objects(self) -> None:
        """List the objects, those that are seen ticked; one alone needs no list."""
        self.objects = QListWidget()
        self.objects.setAccessibleName(tr("Handover", "Objects"))
        self.objects.setMaximumHeight(LIST_HEIGHT)
        names = dict.fromkeys(model.name for model in self._session.drawing.document)
        seen = {model.name for model in self._session.drawing.document if model.visible}
        for name in names:
            item = QListWidgetItem(name)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
            ticked = Qt.CheckState.Checked if name in seen else Qt.CheckState.Unchecked
            item.setCheckState(ticked)
            self.objects.addItem(item)
        self._seen = tuple(name for name in names if name in seen)
        self.objects.itemChanged.connect(lambda _: self._change())
        if len(names) > 1:
            self.column.addWidget(label(tr("Handover", "Objects"), kind="heading"))
            self.column.addWidget(self.objects)

    def _add_choices(self) -> None:
        usual = (USUAL, tr("Handover", "Usual"))
        units = [usual, *((unit, unit) for unit in ("mm", "cm", "m", "in"))]
        self.unit = self._segments(tr("Handover", "Unit"), "unit", units)
        self.up = self._segments(tr("Handover", "Up axis"), "up", [usual, ("y", "Y"), ("z", "Z")])
        self.scale = NumberField(
            tr("Handover", "Scale"), self, minimum=SCALES[0], maximum=SCALES[1], step=0.1, unit="×"
        )
        self.scale.set_silently(_number(self._kept.value(f"{KEPT}scale", 1.0), 1.0))
        self.scale.edited.connect(self._change)
        self._add_row(tr("Handover", "Scale"), self.scale)
        kinds = [("triangles", tr("Handover", "Triangles")), ("quads", tr("Handover", "Quads"))]
        self.mesh = self._segments(tr("Handover", "Meshes of"), "mesh", kinds)
        self.triangles = NumberField(
            tr("Handover", "Triangle budget"),
            self,
            minimum=0.0,
            maximum=MOST_TRIANGLES,
            step=1000.0,
            whole=True,
            zero=tr("Handover", "all"),
        )
        self.triangles.set_silently(_number(self._kept.value(f"{KEPT}triangles", 0), 0.0))
        self.triangles.edited.connect(self._change)
        self._add_row(tr("Handover", "Triangle budget"), self.triangles)
        self.quads = NumberField(
            tr("Handover", "Number of quads"),
            self,
            minimum=float(FEWEST_QUADS),
            maximum=MOST_QUADS,
            step=500.0,
            whole=True,
        )
        self.quads.set_silently(_number(self._kept.value(f"{KEPT}quads", USUAL_QUADS), USUAL_QUADS))
        self.quads.edited.connect(self._change)
        self._add_row(tr("Handover", "Number of quads"), self.quads)
        self.levels = self._toggle(tr("Handover", "Coarser levels (LOD)"), "levels")
        self.uvs = self._toggle(tr("Handover", "Texture coordinates (UVs)"), "uvs")
        self.separate_parts = self._toggle(
            tr("Handover", "Parts as separate objects"), "separate_parts"
        )
        self.curves_alone = self._toggle(tr("Handover", "Curves alone"), "curves_alone")
        self.lay_flat = self._toggle(tr("Handover", "Lay flat for printing"), "lay_flat")
        drawings = [
            ("curves", tr("Handover", "Curves")),
            ("outlines", tr("Handover", "Outlines")),
            ("blueprint", tr("Handover", "Blueprint")),
        ]
        self.lines = self._segments(tr("Handover", "Drawing (SVG, DXF)"), "lines", drawings)
        self.hidden = self._toggle(tr("Handover", "Hidden lines, dashed"), "hidden")

    def _add_what_is_told(self) -> None:
        """Add the picture of what would be written, its size and warnings, with room for them."""
        self.state = quiet("")
        self.state.setMinimumHeight(54)
        self.state.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.picture = QLabel()
        self.picture.setFixedHeight(self._picture_size[1])
        self.picture.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.picture.setAccessibleName(tr("Handover", "Picture of what will be written"))
        self.warning = label("", tone="warning")
        self.warning.hide()
        if self._is_wide:
            self.setMinimumWidth(820)
            self.column.addStretch(1)
            beside, warnings = self.add_beside(), PanelScroll(self)
            self.warning.setAlignment(Qt.AlignmentFlag.AlignTop)
            warnings.setWidget(self.warning)
            warnings.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            for widget in (self.picture, self.state, warnings):
                widget.setFixedWidth(self._picture_size[0])
                beside.addWidget(widget)
            beside.setStretchFactor(warnings, 1)  # many are scrolled: the buttons stay in reach
        else:
            self.setMinimumWidth(460)
            self.in_sight.append(self.state)
            for widget in (self.state, self.picture, self.warning):
                self.column.addWidget(widget)
            self.column.addStretch(
                1
            )  # what is said takes the room: nothing moves under the pointer

    def _segments(self, words: str, key: str, options: list[tuple[str, str]]) -> Segments:
        made = Segments(words, options)
        kept = str(self._kept.value(f"{KEPT}{key}", options[0][0]))
        made.set_silently(kept if kept in dict(options) else options[0][0])
        made.chosen.connect(self._change)
        self._add_row(words, made)
        return made

    def _toggle(self, words: str, key: str) -> Toggle:
        made = Toggle(words)
        made.setChecked(str(self._kept.value(f"{KEPT}{key}", "")) == "yes")
        made.toggled.connect(self._change)
        self._add_row(words, made)
        return made

    def _add_row(self, words: str, widget: QWidget) -> None:
        row = QHBoxLayout()
        row.setSpacing(12)
        name = label(words)
        name.setFixedWidth(LABEL_WIDTH)
        row.addWidget(name)
        row.addWidget(widget, 0 if isinstance(widget, Toggle) else 1)
        if isinstance(widget, Toggle):
            row.addStretch(1)
        self.column.addLayout(row)

    # -- what is chosen --

    @property
    def handover(self) -> Handover:
        """Choices that the controls show."""
        unit, up, lines = (
            one.value if one.isEnabled() else "" for one in (self.unit, self.up, self.lines)
        )
        return Handover(
            unit=None if unit in ("", USUAL) else cast(Unit, unit),
            up=None if up in ("", USUAL) else cast(Up, up),
            scale=self.scale.value(),
            triangles=(int(self.triangles.value()) or None) if self.triangles.isEnabled() else None,
            quads=int(self.quads.value()) if self.quads.isEnabled() else None,
            lay_flat=self.lay_flat.isChecked(),
            lines=None if lines in ("", "curves") else cast(Lines, lines),
            hidden=_is_on(self.hidden),
            levels=_is_on(self.levels),
            uvs=_is_on(self.uvs),
            separate_parts=_is_on(self.separate_parts),
            curves_alone=_is_on(self.curves_alone),
        )

    @property
    def chosen(self) -> tuple[str, ...]:
        """Ids of the chosen formats."""
        return tuple(name for name, toggle in self.formats.items() if toggle.isChecked())

    @property
    def names(self) -> tuple[str, ...] | None:
        """Names of the chosen objects; None for all that are visible."""
        items = [self.objects.item(row) for row in range(self.objects.count())]
        ticked = tuple(i.text() for i in items if i.checkState() is Qt.CheckState.Checked)
        return None if ticked == self._seen else ticked

    # -- what it would be --

    def _offer_what_is_kept(self) -> None:
        """Grey out what none of the chosen formats would heed."""
        heeds = {wish for one in self.chosen for wish in self._offered[one].heeds}
        heeded: dict[QWidget, bool] = {
            self.unit: "unit" in heeds or ("lines" in heeds and self.lines.value == "blueprint"),
            self.up: "up" in heeds,
            self.mesh: "quads" in heeds,
            self.triangles: "triangles" in heeds and self.mesh.value == "triangles",
            self.quads: "quads" in heeds and self.mesh.value == "quads",
            self.levels: "levels" in heeds,
            self.uvs: "uvs" in heeds,
            self.separate_parts: "separate_parts" in heeds,
            self.curves_alone: "curves_alone" in heeds,
            self.lines: "lines" in heeds,
            self.hidden: "hidden" in heeds and self.lines.value != "curves",
        }
        for widget, is_heeded in heeded.items():
            widget.setEnabled(is_heeded)
            words = tr("Handover", "This changes nothing in the chosen formats.")
            widget.setToolTip("" if is_heeded else words)

    def _change(self, *_: object) -> None:
        self._offer_what_is_kept()
        self.go.setEnabled(False)
        self.warning.setText("")  # it was about something else; its place stays until the answer
        if not self.chosen:
            self.state.setText(tr("Handover", "Choose a format."))
        elif self.names == ():
            self.state.setText(tr("Handover", "Choose an object."))
        else:
            self.state.setText(tr("Handover", "Measuring what will be written…"))
            self._pause.start()

    def _look(self) -> None:
        endings = [self._offered[one].endings[0] for one in self.chosen]
        if endings and self.names != ():
            ratio = self.devicePixelRatioF()
            canvas = PictureCanvas(palette_of(self), self._picture_size, ratio)
            self._session.files.exchange.foresee(endings, self.handover, self.names, canvas)

    def _show(self, seen: Foreseen) -> None:
        if self._pause.isActive():
            return
        locale = QLocale()
        size = " × ".join(f"{side:.4g}" for side in seen.size)
        files = ", ".join(
            f"{ending.removeprefix('.').upper()} {locale.formattedDataSize(count)}"
            for ending, count in seen.files
        )
        count = locale.toString(seen.triangles)
        quads = locale.toString(seen.quads)
        if seen.quads:
            said = tr(
                "Handover",
                "{size} mm · {quads} quads, {count} triangles",
                size=size,
                quads=quads,
                count=count,
            )
        else:
            said = tr("Handover", "{size} mm · {count} triangles", size=size, count=count)
        self.state.setText(f"{said}\n{files}")
        if seen.picture is not None:
            height, width = seen.picture.shape[:2]
            pixels = seen.picture.tobytes()
            image = QImage(pixels, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
            image.setDevicePixelRatio(width / self._picture_size[0])
            self.picture.setPixmap(QPixmap.fromImage(image))
        self.warning.setText("\n".join(seen.warnings))
        self.warning.setVisible(bool(seen.warnings))
        self._grow()
        if seen.warnings and self.is_scrolled and not self._is_wide:
            below = tr("Handover", "The warnings stand below the switches.")
            self.state.setText(f"{self.state.text()}\n{below}")
        self.go.setEnabled(True)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._grow()

    def _grow(self) -> None:
        """Make room for what is said, as far as the screen has it."""
        wanted = max(self.height(), self.sizeHint().height())
        self.resize(
            self.width(), min(wanted, self.screen().availableGeometry().height() - FRAME[1])
        )

    def _refuse(self, words: str) -> None:
        self.picture.clear()
        self.state.setText(words)
        self.warning.hide()

    def _export(self) -> None:
        wanted = self.handover
        kept: dict[str, object] = {
            "formats": " ".join(self.chosen),
            "unit": self.unit.value,
            "up": self.up.value,
            "scale": wanted.scale,
            "triangles": int(self.triangles.value()),
            "mesh": self.mesh.value,
            "quads": int(self.quads.value()),
            "lines": self.lines.value,
        }
        toggles = {
            "lay_flat": self.lay_flat,
            "hidden": self.hidden,
            "levels": self.levels,
            "uvs": self.uvs,
            "separate_parts": self.separate_parts,
            "curves_alone": self.curves_alone,
        }
        kept |= {key: "yes" if toggle.isChecked() else "" for key, toggle in toggles.items()}
        for key, value in kept.items():
            self._kept.setValue(f"{KEPT}{key}", value)
        formats = [self._offered[one] for one in self.chosen]
        if self._questions.ask_place_of_export(formats, wanted, self.names):
            self.accept()


def _is_on(toggle: Toggle) -> bool:
    return toggle.isEnabled() and toggle.isChecked()


def _number(kept: object, otherwise: float) -> float:
    """Return a number from the settings, where a person may have written anything."""
    try:
        value = float(str(kept))
    except ValueError:
        return otherwise
    return value if math.isfinite(value) else otherwise
