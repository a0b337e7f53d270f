"""Parameters: a form made from the annotations of the selected model's state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QLabel, QScrollArea, QVBoxLayout, QWidget

from bozzetto_app.panels.figures import Figures
from bozzetto_app.panels.parameter_row import ParameterRow
from bozzetto_app.panels.section import Section, hairline
from bozzetto_app.panels.tab_order import put_in_tab_order
from bozzetto_app.settings import settings
from bozzetto_app.words import tr

if TYPE_CHECKING:
    from bozzetto_app.session import Session

__all__ = ["ParametersPanel"]


class ParametersPanel(QScrollArea):
    """The form of the selected model, and the figures of its result."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self.setObjectName("parameters")
        self.setWindowTitle(tr("Parameters", "Parameters"))
        self.setAccessibleName(self.windowTitle())
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMinimumWidth(240)

        self._empty = QLabel()
        self._locked = QLabel(tr("Parameters", "This object is locked."))
        for words in (self._empty, self._locked):
            words.setWordWrap(True)
            words.setProperty("tone", "quiet")
        self._form = QWidget()
        self._rows: dict[str, ParameterRow] = {}
        self._shape: tuple[object, ...] = ()
        self._figures = Figures()
        self._figures_section = Section(tr("Parameters", "Figures"), self._figures)
        self._line = hairline()

        page = QWidget()
        self._column = QVBoxLayout(page)
        self._column.setContentsMargins(12, 8, 12, 12)
        self._column.setSpacing(8)
        for widget in (self._empty, self._locked, self._form, self._line, self._figures_section):
            self._column.addWidget(widget)
        self._column.addStretch(1)
        self.setWidget(page)

        session.parameters_changed.connect(self.refresh)
        session.selection_changed.connect(self.refresh)
        session.document_changed.connect(self.refresh)
        session.report_changed.connect(self._show_report)
        self.refresh()
        self._show_report()

    def focus_parameter(self, name: str) -> None:
        """Bring a parameter into sight and give it the keyboard."""
        row = self._rows.get(name)
        if row is None:
            return
        if row.field.parameter.advanced:
            self._form.findChildren(Section)[0].set_open(True)
        self.ensureWidgetVisible(row)
        row.words.buddy().setFocus(Qt.FocusReason.ShortcutFocusReason)

    def refresh(self) -> None:
        """Show the values that the model has now; the form is only rebuilt for other fields."""
        found = self._session.parameters
        shape = (self._session.selected, *(field for field, _ in found))
        if shape != self._shape:
            self._shape = shape
            self._rebuild()
        for field, value in found:
            self._rows[field.name].show_value(value)
        locked = any(
            model.locked for model in self._session.document if model.id == self._session.selected
        )
        self._locked.setVisible(locked)
        self._form.setEnabled(not locked)
        self._empty.setText(
            tr("Parameters", "Draw or choose an object to see its parameters.")
            if self._session.selected is None
            else tr("Parameters", "This object has no parameters.")
        )
        self._empty.setVisible(not found)
        self._form.setVisible(bool(found))

    def _rebuild(self) -> None:
        old, self._form = self._form, QWidget()
        self._rows = {}
        column = QVBoxLayout(self._form)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(12)
        advanced = QWidget()
        folded = QVBoxLayout(advanced)
        folded.setContentsMargins(0, 4, 0, 0)
        folded.setSpacing(12)
        for field, _ in self._session.parameters:
            row = ParameterRow(field)
            name = field.name
            row.changed.connect(
                lambda value, going, name=name: self._session.set_parameter(
                    name, value, dragging=going
                )
            )
            row.drag_ended.connect(self._session.end_drag)
            self._rows[name] = row
            (folded if field.parameter.advanced else column).addWidget(row)
        if folded.count():
            section = Section(
                tr("Parameters", "Advanced"),
                advanced,
                open_=bool(settings().value("panels/advanced", False, bool)),
            )
            section.folded.connect(lambda shown: settings().setValue("panels/advanced", shown))
            column.addWidget(section)
        else:
            advanced.deleteLater()
        self._column.replaceWidget(old, self._form)
        put_in_tab_order(self, (self._form, self._figures_section))
        old.hide()
        old.deleteLater()

    def _show_report(self) -> None:
        report = self._session.report
        self._figures.show_report(report)
        self._figures_section.setVisible(bool(report))
        self._line.setVisible(bool(report))
