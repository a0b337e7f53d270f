"""“Trace into ink”: the lines of a picture, shown over it while the sensitivity is set."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QWidget

from bozzetto.document.model import Underlay
from bozzetto_app.dialogs.dialog import Page, label, quiet
from bozzetto_app.i18n import tr
from bozzetto_app.style.theme import qcolor, tones
from bozzetto_app.widgets.choice import Segments
from bozzetto_app.widgets.slider import Slider
from bozzetto_app.widgets.toggle import Toggle

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session
    from bozzetto_app.session.tracing import Place, Traced

__all__ = ["TraceDialog"]

PREVIEW: Final = QSize(560, 400)
"""Least size of the preview, pixels of the screen's own measure."""

MIDDLE: Final = 0.5
"""Sensitivity that suits most pictures."""

FADED: Final = 0.45
"""Opacity of the picture behind the lines."""


class TraceDialog(Page):
    """Shows what tracing a picture gives, and makes ink of it.

    Parameters
    ----------
    session : Session
    source : Path or Underlay
        The picture.
    parent : QWidget, optional
    """

    def __init__(
        self, session: Session, source: Path | Underlay, parent: QWidget | None = None
    ) -> None:
        super().__init__("trace-picture", tr("Trace", "Trace into ink"), parent)
        self._session, self._source = session, source
        self._underlay = source if isinstance(source, Underlay) else None
        self._traced: Traced | None = None
        self.preview = _Preview()
        self.column.addWidget(self.preview, 1)
        self.state = quiet("")
        self.column.addWidget(self.state)
        self.sensitivity = Slider(tr("Trace", "Sensitivity"), 0.0, 1.0, 0.01, MIDDLE)
        self.sensitivity.set_silently(MIDDLE)
        self.sensitivity.slid.connect(lambda value, going: self._ask())
        self._add_row(tr("Trace", "Sensitivity"), self.sensitivity)
        self.straighten = Toggle(tr("Trace", "Straighten the page"))
        self.straighten.setChecked(True)
        self.straighten.toggled.connect(lambda on: self._ask(anew=True))
        self._add_row(tr("Trace", "Straighten the page"), self.straighten)
        self.place = Segments(
            tr("Trace", "Where the ink goes"),
            (
                ("picture", tr("Trace", "Along the picture")),
                ("view", tr("Trace", "As large as the view")),
            ),
        )
        self._place: Place = "view"
        if self._underlay is not None:
            self._place = session.pictures.tracing.best_place(self._underlay)
            self.place.set_silently(self._place)
            self.place.chosen.connect(self._set_place)
            self._add_row(tr("Trace", "Where the ink goes"), self.place)
        cancel = self.add_button(tr("Trace", "&Cancel"))
        cancel.clicked.connect(self.reject)
        self.go = self.add_button(tr("Trace", "&Trace into ink"), default=True)
        self.go.setEnabled(False)
        self.go.clicked.connect(self._take)
        session.pictures.tracing.found.connect(self._show)
        session.pictures.tracing.failed.connect(self._tell)
        self.finished.connect(session.pictures.tracing.cancel)
        session.drawing.closing.connect(self.reject)
        self._ask(anew=True)

    def _add_row(self, words: str, widget: QWidget) -> None:
        row = QHBoxLayout()
        row.setSpacing(12)
        name = label(words)
        name.setFixedWidth(150)
        row.addWidget(name)
        row.addWidget(widget, 1 if not isinstance(widget, Toggle) else 0)
        if isinstance(widget, Toggle):
            row.addStretch(1)
        self.column.addLayout(row)

    def _set_place(self, value: str) -> None:
        self._place = "picture" if value == "picture" else "view"

    def _ask(self, *, anew: bool = False) -> None:
        """Have the picture traced as the controls say."""
        self.state.setText(tr("Trace", "Looking for lines…"))
        known = None if anew or self._traced is None else self._traced.sheet
        self._session.pictures.tracing.trace(
            self._source,
            self.sensitivity.number,
            page=self.straighten.isChecked(),
            known=known,
        )

    def _show(self, traced: Traced) -> None:
        self._traced = traced
        self.preview.show_traced(traced)
        self.go.setEnabled(True)
        closed = sum(line.is_closed for line in traced.lines)
        said = tr(
            "Trace", "{count} strokes, {closed} of them closed outlines.",
            count=len(traced.lines), closed=closed,
        )  # fmt: skip
        if traced.sheet.corners is not None:
            said = tr("Trace", "{said} The page was found and straightened.", said=said)
        self.state.setText(said)

    def _tell(self, words: str) -> None:
        self.state.setText(words)
        self.go.setEnabled(False)

    def _take(self) -> None:
        if self._traced is not None:
            self._session.pictures.tracing.take(self._traced, self._underlay, self._place)
        self.accept()


class _Preview(QWidget):
    """A picture with the lines that were found in it."""

    def __init__(self) -> None:
        super().__init__()
        self._traced: Traced | None = None
        self._lines: list[QPolygonF] = []
        self.setMinimumSize(PREVIEW)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName(tr("Trace", "Picture with the lines that were found"))

    def show_traced(self, traced: Traced) -> None:
        """Show a picture and its lines."""
        self._traced = traced
        self._lines = [
            QPolygonF([QPointF(x, y) for x, y in line.points.tolist()]) for line in traced.lines
        ]
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.fillRect(self.rect(), qcolor(tones().field))
        if self._traced is None:
            return
        width, height = self._traced.sheet.size
        scale = min(self.width() / width, self.height() / height)
        painter.translate(
            0.5 * (self.width() - scale * width), 0.5 * (self.height() - scale * height)
        )
        painter.scale(scale, scale)
        whole = QRectF(0, 0, width, height)
        painter.fillRect(whole, Qt.GlobalColor.white)
        painter.setOpacity(FADED)
        painter.drawImage(whole, self._traced.image)
        painter.setOpacity(1.0)
        pen = QPen(qcolor(tones().accent), 2.0)
        pen.setCosmetic(True)
        painter.setPen(pen)
        for line in self._lines:
            painter.drawPolyline(line)
