"""Parameters: a form made from the annotations of the selected model's state and chosen part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QPoint, Qt, QTimer, Signal
from PySide6.QtWidgets import QApplication, QLabel, QVBoxLayout, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.panels.properties.drag_pace import DragPace
from bozzetto_app.panels.properties.place_form import PlaceForm
from bozzetto_app.panels.properties.report import Figures
from bozzetto_app.session.selection import why_locked
from bozzetto_app.settings import settings
from bozzetto_app.toolkit.panel_scroll import PanelScroll
from bozzetto_app.widgets.section import Section, hairline
from bozzetto_app.widgets.tab_order import put_in_tab_order

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.geometry.placement import Placement
    from bozzetto.parameters import Field
    from bozzetto_app.panels.properties.parameter_row import ParameterRow
    from bozzetto_app.panels.properties.underlay_form import UnderlayForm
    from bozzetto_app.session.session import Session

__all__ = ["ParametersPanel"]

KEPT: Final = 6
"""Forms that are kept for when their fields are chosen again: to make one takes longer than a
person who undoes quickly, or goes from one object to another, leaves between two keys."""

SLICE: Final = 0.008
"""Time for rows of a form between two looks at what the person does, s."""

NO_FIELDS: Final = ("",)
"""Those of a model and of a part, with "" between them, where there are none."""


class ParametersPanel(PanelScroll):
    """The forms of the selected model and of its chosen part, and the figures of its result.

    Attributes
    ----------
    form : Form
        The one that is shown.
    """

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self.setObjectName("parameters")
        self.setWindowTitle(tr("Parameters", "Parameters"))
        self.setAccessibleName(self.windowTitle())
        self.setMinimumWidth(264)

        self._empty, self._is_empty = QLabel(), True
        self._locked = QLabel(why_locked())
        for words in (self._empty, self._locked):
            words.setWordWrap(True)
            words.setProperty("tone", "quiet")
        self.form = Form()
        self._forms: dict[tuple[object, ...], Form] = {}
        self._fields: tuple[object, ...] = NO_FIELDS
        self._coming: tuple[Form, Iterator[None]] | None = None
        # A form is made between two frames, row by row: all of it takes longer than one.
        self._soon = QTimer(self, singleShot=True, interval=1)
        self._soon.timeout.connect(self._make)
        self._owner: tuple[str | None, str] = (None, "")
        self.place = PlaceForm()
        pace = DragPace(self._put, self.place)
        self.place.placed.connect(pace.change)
        self.place.drag_ended.connect(pace.end)
        self.place.drag_ended.connect(session.objects.end_drag)
        self._place_pace = pace
        self._place_section = _section(tr("Parameters", "Place"), self.place, "panels/place", False)
        self.underlay: UnderlayForm | None = None
        self._underlay_section: Section | None = None
        self._figures = Figures()
        self._figures_section = Section(tr("Parameters", "Figures"), self._figures)
        self._line = hairline()

        page = QWidget()
        self._column = QVBoxLayout(page)
        self._column.setContentsMargins(12, 8, 12, 12)
        self._column.setSpacing(8)
        for widget in (
            self._empty, self._locked, self.form, self._place_section, self._line,
            self._figures_section,
        ):  # fmt: skip
            self._column.addWidget(widget)
        self._column.addStretch(1)
        self.setWidget(page)

        session.selection.changed.connect(self.refresh)
        session.drawing.changed.connect(self.refresh)
        session.drawing.models_changed.connect(self._value_dragged)
        session.solver.report_changed.connect(self._show_report)
        session.pictures.placing.changed.connect(self._show_underlay)
        session.toolbox.tool_changed.connect(self.refresh)
        session.toolbox.modeler_changed.connect(self.refresh)
        self._show_underlay()
        self.refresh()
        self._show_report()

    @property
    def is_ready(self) -> bool:
        """Whether the form of what is chosen is there; it is made in a few turns of the loop."""
        return not self._soon.isActive()

    def focus_parameter(self, name: str) -> None:
        """Bring a parameter, of the model or of the chosen part, into sight and reach."""
        self._take_tool_of(name)
        while not self.is_ready:
            self._make()
        row = self.form.rows.get(("", name)) or self.form.rows.get(("part", name))
        if row is None:
            return
        around = row.parentWidget()
        while around is not None and around is not self:
            if isinstance(around, Section):
                around.set_open(True)
            around = around.parentWidget()
        self.ensureWidgetVisible(row)
        row.words.buddy().setFocus(Qt.FocusReason.ShortcutFocusReason)

    def _take_tool_of(self, name: str) -> None:
        """Take a tool for which a parameter is, where another one is in the hand."""
        session = self._session
        for field, _ in (*session.objects.parameters, *session.parts.parameters):
            tools = field.parameter.tools
            if field.name == name and tools and session.toolbox.tool not in tools:
                session.toolbox.take_tool(tools[0])

    def _in_hand(self, found: Iterable[tuple[Field, Any]]) -> tuple[tuple[Field, Any], ...]:
        """Return parameters without those that are for other tools than the one in the hand."""
        toolbox, model = self._session.toolbox, self._session.selection.model
        tool = toolbox.tool if model is not None and toolbox.modeler == model.modeler else ""
        return tuple(
            (field, value)
            for field, value in found
            if not field.parameter.tools or tool in field.parameter.tools
        )

    def refresh(self) -> None:
        """Show the values of the selected model and part.

        The form is only rebuilt for other fields, or if a person has the cursor in it while
        another model or part is chosen: every new stroke may choose another part.
        """
        from bozzetto.parameters import idle_parameters

        session = self._session
        own, inner, part = (
            self._in_hand(session.objects.parameters),
            self._in_hand(session.parts.parameters),
            session.parts.chosen,
        )
        chosen = (session.selection.id, "" if part is None else part.id)
        fields = (*(field for field, _ in own), "", *(field for field, _ in inner))
        if chosen != self._owner:
            for pace in (*self.form.paces, self._place_pace):
                pace.forget()
        if fields != self._fields or (chosen != self._owner and self._is_in_use()):
            self._put_away(fields)
        locked = any(
            model.locked for model in session.drawing.document if model.id == session.selection.id
        )
        self._locked.setVisible(locked)  # at once: the form may come later
        self._is_empty = not own and not inner
        if not self.is_ready:
            if not self._is_empty:
                self._empty.hide()  # at once, too
            return
        if chosen != self._owner:
            if chosen[0] != self._owner[0]:
                self.verticalScrollBar().setValue(0)
            QTimer.singleShot(0, self, self._bring_into_sight)  # once it is laid out
        self._owner = chosen
        if self.form.part is not None and part is not None:
            self.form.part.rename(part.name)
        model = session.selection.model
        if model is not None:
            self.place.show_placement(model.placement)
        dragging = session.drawing.is_dragging
        for owner, found in (("", own), ("part", inner)):
            idle = idle_parameters(found)
            for field, value in found:
                key = owner, field.name
                row, values = self.form.rows[key], self.form.values
                row.show_idle(idle.get(field.name, ""))
                if not dragging or key not in values or values[key] != value:
                    values[key] = value
                    row.show_value(value)
        if dragging:
            return
        self.form.setEnabled(not locked)
        self._place_section.setVisible(model is not None)
        self.place.setEnabled(not locked)
        if self._is_empty:
            self._empty.setText(self._why_empty(model))
        self._empty.setVisible(self._is_empty and session.pictures.placing.place is None)
        self.form.setVisible(not self._is_empty)

    def _show_underlay(self) -> None:
        """Show where the chosen underlay lies, above all else; nothing where none is chosen."""
        place = self._session.pictures.placing.place
        if place is not None:
            if self.underlay is None:
                from bozzetto_app.panels.properties.underlay_form import UnderlayForm

                self.underlay = UnderlayForm(self._session)
                title = tr("Parameters", "Picture")
                self._underlay_section = Section(title, self.underlay)
                self._column.insertWidget(0, self._underlay_section)
                put_in_tab_order(self, (self._underlay_section, self.form))
            self.underlay.show_place(place)
        if self._underlay_section is not None:
            self._underlay_section.setVisible(place is not None)
        self._empty.setVisible(self._is_empty and place is None)

    def _why_empty(self, model: Model | None) -> str:
        """Return what stands in the place of parameters where there are none."""
        if self._session.selection.id is None:
            return tr("Parameters", "Draw or choose an object to see its parameters.")
        if model is None or self._session.workbench.is_usable(model):
            return tr("Parameters", "This object has no parameters.")
        from bozzetto.workbench.export_document import unusable

        why = unusable(self._session.workbench, model)
        said = "" if why is None else f"{why.reason}; {why.advice}"
        return tr("Parameters", "This object is kept as it is: {why}.", why=said)

    def _bring_into_sight(self) -> None:
        """Scroll to the form of the chosen part, if its heading is out of sight."""
        section = self.form.part
        if section is None:
            return
        top = section.mapTo(self.viewport(), QPoint()).y()
        if not 0 <= top <= self.viewport().height() - section.heading_height:
            bar = self.verticalScrollBar()
            bar.setValue(bar.value() + top)

    def _value_dragged(self) -> None:
        """Follow the values of a drag; `changed` comes only when it ends or pauses."""
        if self._session.drawing.is_dragging:
            self.refresh()

    def _is_in_use(self) -> bool:
        """Whether something is being typed: it is meant for what was chosen by then."""
        focus = QApplication.focusWidget()
        return focus is not None and self.form.isAncestorOf(focus)

    def _put_away(self, fields: tuple[object, ...]) -> None:
        """Put the form of other fields in the place of the one that is shown, or make it soon.

        One in which something is being typed or dragged is not kept: that was not meant for what
        is chosen when it is shown again.
        """
        gone = []
        if not self.is_ready or self._is_in_use() or self._session.drawing.is_dragging:
            gone.append(self.form)
        else:
            self._forms[self._fields] = self.form
        if self._coming is not None:
            gone.append(self._coming[0])
            self._coming = None
        kept = self._forms.pop(fields, None)
        self._fields = fields
        if kept is None:
            self._soon.start()
        else:
            self._soon.stop()
        self._exchange(kept or Form())
        while len(self._forms) > KEPT:
            gone.append(self._forms.pop(next(iter(self._forms))))
        for form in gone:
            form.deleteLater()

    def _make(self) -> None:
        """Make some rows of the form of what is chosen, and show it when it is whole."""
        self._soon.stop()
        if self._coming is None:
            form = Form()
            self._coming = form, self._rows_of(form)
        form, rows = self._coming
        end = monotonic() + SLICE
        for _ in rows:
            if monotonic() > end:
                self._soon.start()
                return
        empty, self._coming = self.form, None
        self._exchange(form)
        empty.deleteLater()
        self.refresh()

    def _exchange(self, form: Form) -> None:
        """Show another form."""
        old, self.form = self.form, form
        form.fold_as_kept()
        place = self._column.indexOf(old)
        self._column.removeWidget(old)
        self._column.insertWidget(place, form)  # `replaceWidget` gives an item that nobody frees
        put_in_tab_order(self, (form, self._place_section, self._figures_section))
        old.hide()

    def _rows_of(self, form: Form) -> Iterator[None]:
        """Fill a form for what is chosen, a row at a time."""
        session = self._session
        form.drag_ended.connect(session.objects.end_drag)
        column = QVBoxLayout(form)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(12)
        part, inner = session.parts.chosen, self._in_hand(session.parts.parameters)
        change = session.objects.set_parameter
        yield from form.fill(column, "", self._in_hand(session.objects.parameters), change)
        if part is not None and inner:
            below = QWidget()
            rows = QVBoxLayout(below)
            rows.setContentsMargins(0, 4, 0, 0)
            rows.setSpacing(12)
            yield from form.fill(rows, "part", inner, session.parts.set_parameter)
            if column.count():
                column.addWidget(hairline())
            form.part = form.section(part.name, below, "panels/part", True)
            column.addWidget(form.part)

    def _put(self, placement: Placement, going: bool) -> None:
        model_id = self._session.selection.id
        if model_id is not None:
            self._session.objects.set_placement(model_id, placement, dragging=going)

    def _show_report(self) -> None:
        solver, part = self._session.solver, self._session.parts.chosen
        report = solver.report
        self._figures.show_report(report, solver.figures, "" if part is None else part.id)
        self._figures_section.setVisible(bool(report))
        self._line.setVisible(bool(report))


def _changed(change: Callable[..., None], name: str, value: Any, going: bool) -> None:
    change(name, value, dragging=going)


class Form(QWidget):
    """The rows of the fields of a model and of a part.

    Attributes
    ----------
    rows : dict of ParameterRow
        By "" for the model's or "part", and the name of the field.
    values : dict
        What the rows show, by the same.
    paces : list of DragPace
    part : Section or None
        The rows of the part.

    Signals
    -------
    drag_ended
        A slider was let go.
    """

    drag_ended = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.rows: dict[tuple[str, str], ParameterRow] = {}
        self.values: dict[tuple[str, str], Any] = {}
        self.paces: list[DragPace] = []
        self.part: Section | None = None
        self._sections: list[tuple[Section, str, bool]] = []

    def fill(
        self,
        column: QVBoxLayout,
        owner: str,
        found: Iterable[tuple[Field, Any]],
        change: Callable[..., None],
    ) -> Iterator[None]:
        """Make the rows of a model's or a part's parameters, one at a time; fold advanced ones."""
        from bozzetto_app.panels.properties.parameter_row import ParameterRow

        advanced = QWidget()
        folded = QVBoxLayout(advanced)
        folded.setContentsMargins(0, 4, 0, 0)
        folded.setSpacing(12)
        for field, _ in found:
            row = ParameterRow(field)
            pace = DragPace(partial(_changed, change, field.name), row)
            row.changed.connect(pace.change)
            row.drag_ended.connect(pace.end)
            row.drag_ended.connect(self.drag_ended)
            self.paces.append(pace)
            self.rows[owner, field.name] = row
            (folded if field.parameter.advanced else column).addWidget(row)
            yield
        if folded.count():
            words = tr("Parameters", "Advanced")
            column.addWidget(self.section(words, advanced, "panels/advanced", False))
        else:
            advanced.deleteLater()

    def section(self, title: str, content: QWidget, key: str, is_open: bool) -> Section:
        """Return a section in the form that is folded as its like were left."""
        section = _section(title, content, key, is_open)
        self._sections.append((section, key, is_open))
        return section

    def fold_as_kept(self) -> None:
        """Fold and unfold the sections as their like in other forms were left."""
        for section, key, is_open in self._sections:
            section.set_open(_is_open(key, is_open))


def _is_open(key: str, is_open: bool) -> bool:
    return bool(settings().value(key, is_open, bool))


def _section(title: str, content: QWidget, key: str, is_open: bool) -> Section:
    """Return a section that stays folded or open; the settings keep that under a key."""
    section = Section(title, content, open_=_is_open(key, is_open))
    section.folded.connect(lambda shown: settings().setValue(key, shown))
    return section
