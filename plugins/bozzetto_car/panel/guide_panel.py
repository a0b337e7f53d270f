"""The guide panel: what to mark next, what is marked, and what is known of the car."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal, cast

from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from bozzetto.errors import UserError
from bozzetto.plugin import PanelHost, override
from bozzetto_app.toolkit import PanelScroll, PanelWorker
from bozzetto_car.commands import car_as_template, is_shaped
from bozzetto_car.marking.edit_marks import with_asked, with_skipped
from bozzetto_car.panel.node_chart import NodeChart
from bozzetto_car.panel.template_pictures import TemplatePictures, template_folder
from bozzetto_car.panel.turning_car import TurningCar
from bozzetto_car.panel.view_model import Guide, guide_of
from bozzetto_car.panel.widgets import Fold, Progress, SketchButton, label
from bozzetto_car.state import CarState
from bozzetto_car.template.kept_templates import keep_template
from bozzetto_car.template.loader import Bundled

PATIENCE: Final = 60
"""Time from a change to the update of the panel, ms: the program solves the car first, and its
answer is then remembered."""

ROOMY: Final = 270
"""Height of the panel from which there is room for the picture of the car above what is to be done
next and its buttons, px."""

WORDS: Final = ("Back", "Skip", "Not visible")

TIPS: Final = (
    "Ask once more for the point before",
    "Ask for the next point; this one comes again",
    "Do not ask for this point any more in this sketch",
)

NAME, KEEP = "Name", "Keep as template"

KEEP_TIP: Final = "Add the car as it is to the templates that further cars can begin with"

LONGEST_NAME: Final = 60
"""Most characters of the name of a template, for a picture has room for a few."""

CHECKED, UNCHECKED = Qt.CheckState.Checked, Qt.CheckState.Unchecked


class GuidePanel(PanelScroll):
    """The panel that guides a person through the marking of a car's sketches.

    Parameters
    ----------
    host : PanelHost
        Access to the selected car.
    parent : QWidget
        The widget that holds the panel.
    """

    def __init__(self, host: PanelHost, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("car-guide")
        self._host = host
        self._guide: Guide | None = None
        self._asked: CarState | None = None
        self._work, self._keeping = PanelWorker(self), PanelWorker(self)
        self._soon = QTimer(self, singleShot=True, interval=PATIENCE)
        self._soon.timeout.connect(self._look)
        self._build()
        host.on_change(self._change_seen)
        self._change_seen()

    @property
    def busy(self) -> bool:
        """Whether the panel does not show the newest state yet."""
        works = (self._work, self._keeping, self.templates)
        return self._soon.isActive() or any(work.busy for work in works)

    @override
    def sizeHint(self) -> QSize:
        return QSize(280, 560)

    @override
    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.car.setVisible(self.viewport().height() >= ROOMY)

    # -- what there is -----------------------------------------------------------------------------

    def _build(self) -> None:
        inside = QWidget()
        column = QVBoxLayout(inside)
        column.setContentsMargins(0, 0, 4, 0)
        column.setSpacing(6)
        self.car = TurningCar(inside)
        self.title = label(inside, kind="heading")
        self.next_step = label(inside)
        self.next_step.setObjectName("next-step")
        self.progress = Progress(inside)
        self.count = label(inside, kind="small", tone="quiet")
        self.chart = NodeChart(inside)
        self.chart.chosen.connect(self._choose)
        for widget in (self.car, self.title, self.next_step):
            column.addWidget(widget)
        column.addLayout(self._buttons(inside))
        column.addSpacing(2)
        column.addWidget(self.progress)
        column.addWidget(self.count)
        column.addWidget(self.chart)
        self._rows = QWidget(inside)
        self._sketches = QVBoxLayout(self._rows)
        self._sketches.setContentsMargins(0, 0, 0, 0)
        self._sketches.setSpacing(2)
        self.advice = label(self._rows, kind="small", tone="quiet")
        self._sketches.addWidget(self.advice)
        found = QWidget(inside)
        self._found = QFormLayout(found)
        self._found.setContentsMargins(20, 0, 8, 0)
        self._found.setVerticalSpacing(2)
        self.rules = QListWidget(inside)
        self.rules.setObjectName("car-guide-rules")
        self.rules.setAccessibleName("Soundness")
        self.rules.setWordWrap(True)
        self.rules.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.rules.setMinimumHeight(220)
        self.rules.itemChanged.connect(self._switch)
        self._kinds = Fold("Template", self._kinds_of_cars(inside), inside, is_open=True)
        column.insertWidget(0, self._kinds)
        column.addWidget(Fold("Sketches", self._rows, inside, is_open=True))
        column.addWidget(Fold("Dimensions as found", found, inside, is_open=False))
        column.addWidget(Fold("Soundness", self.rules, inside, is_open=False))
        column.addStretch(1)
        self.setWidget(inside)

    def _buttons(self, inside: QWidget) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(6)
        self.back, self.skip, self.hide_ = (QPushButton(words, inside) for words in WORDS)
        for button, tip in zip((self.back, self.skip, self.hide_), TIPS, strict=True):
            button.setToolTip(tip)
            button.setProperty("type", "small")
            row.addWidget(button, 1)
        self.back.clicked.connect(self._go_back)
        self.skip.clicked.connect(self._pass_over)
        self.hide_.clicked.connect(self._not_visible)
        return row

    def _kinds_of_cars(self, inside: QWidget) -> QWidget:
        """Return the pictures of the templates, and below them a row to keep this car as one."""
        whole = QWidget(inside)
        column = QVBoxLayout(whole)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(6)
        self.templates = TemplatePictures(self._host.templates, whole)
        self.templates.chosen.connect(self._choose_template)
        self.templates.refused.connect(self._host.complain)
        column.addWidget(self.templates)
        row = QHBoxLayout()
        row.setSpacing(6)
        self.name = QLineEdit(whole)
        self.name.setPlaceholderText(NAME)
        self.name.setAccessibleName("Name of this car as a template")
        self.name.setMaxLength(LONGEST_NAME)
        self.keep = QPushButton(KEEP, whole)
        self.keep.setProperty("type", "small")
        self.keep.setToolTip(KEEP_TIP)
        self.keep.clicked.connect(self._keep)
        self.name.returnPressed.connect(self.keep.click)
        self.name.textChanged.connect(self._may_keep)
        row.addWidget(self.name, 1)
        row.addWidget(self.keep)
        column.addLayout(row)
        return whole

    # -- what is shown -----------------------------------------------------------------------------

    def _change_seen(self) -> None:
        self._show_words()
        self._soon.start()

    def _show_words(self) -> None:
        """Show what to do at the point that is named above, or with the tool where none is."""
        words = "" if self._guide is None else self._guide.words
        self.next_step.setText(words or self._host.next_step.sentence)

    def _look(self) -> None:
        state = self._host.state
        if isinstance(state, CarState) and state is not self._asked:
            self._asked = state
            self._work.ask(lambda: guide_of(state), lambda guide: self._show(state, guide))

    def _show(self, state: CarState, guide: Guide) -> None:
        begins, began = not guide.count, self._guide is None or not self._guide.count
        if self._guide is None or begins != began:
            self._kinds.heading.setChecked(begins)  # then the room is for the points
        self._guide = guide
        self.templates.show_template(state)
        self._may_keep()
        self.car.show_node(guide.template, guide.asked)
        self.title.setText(guide.title)
        self.title.setVisible(bool(guide.title))
        self._show_words()
        self.progress.set_share(guide.count / len(guide.template.names))
        self.count.setText(f"{guide.count} of {len(guide.template.names)} marked")
        self.chart.show_guide(guide)
        self.back.setEnabled(bool(guide.before))
        self.skip.setEnabled(bool(guide.after))
        self.hide_.setEnabled(bool(guide.asked))
        self._show_sketches(guide)
        self._show_dimensions(guide)
        self._show_rules(guide)

    def _show_sketches(self, guide: Guide) -> None:
        while self._sketches.count() > 1:
            item = self._sketches.takeAt(0)
            widget = None if item is None else item.widget()
            if widget is not None:
                widget.hide()
                widget.deleteLater()
        for number, row in enumerate(guide.sketches):
            button = SketchButton(row, self._rows)
            button.clicked.connect(lambda _, key=row.id: self._choose_sketch(key))
            self._sketches.insertWidget(number, button)
        self.advice.setText(guide.advice)
        self.advice.setVisible(bool(guide.advice))

    def _show_dimensions(self, guide: Guide) -> None:
        while self._found.rowCount():
            self._found.removeRow(0)
        for name, value in guide.dimensions:
            figure = QLabel(f"{value:,.0f} mm".replace(",", "\u2009"))
            figure.setAlignment(Qt.AlignmentFlag.AlignRight)
            words = QLabel(name)
            words.setProperty("tone", "quiet")
            self._found.addRow(words, figure)

    def _show_rules(self, guide: Guide) -> None:
        self.rules.blockSignals(True)
        names = [self.rules.item(number).text() for number in range(self.rules.count())]
        if names != [rule.name for rule in guide.rules]:
            self.rules.clear()
            for rule in guide.rules:
                self.rules.addItem(QListWidgetItem(rule.name))
        for number, rule in enumerate(guide.rules):
            item = self.rules.item(number)
            item.setCheckState(CHECKED if rule.is_on else UNCHECKED)
            item.setToolTip("The car violates this constraint." if rule.is_broken else "")
        self.rules.blockSignals(False)

    # -- what can be done --------------------------------------------------------------------------

    def _choose(self, node: str) -> None:
        self._change(lambda state: with_asked(state, node), "Choose a point")

    def _choose_template(self, name: str, own: str) -> None:
        state = self._host.state
        if isinstance(state, CarState):
            kept = own or state.own  # the car's own stays, should the person come back to it
            kind: Bundled | Literal["own"] = "own" if own else cast(Bundled, name)
            self._host.change(replace(state, template=kind, own=kept), "Template")

    def _may_keep(self) -> None:
        state = self._host.state
        is_own = isinstance(state, CarState) and is_shaped(state)
        self.name.setEnabled(is_own)
        self.keep.setEnabled(is_own and bool(self.name.text().strip()) and not self._keeping.busy)

    def _keep(self) -> None:
        """Keep the car as a template, in a thread: it may have to be solved first."""
        state, name, folder = self._host.state, self.name.text(), template_folder()
        if not isinstance(state, CarState):
            return

        def work() -> Path:
            return keep_template(folder, car_as_template(state, name))

        def done(path: Path) -> None:
            self.name.clear()
            self.templates.look_again()

        def failed(problem: UserError) -> None:
            self._may_keep()
            self._host.complain(problem)

        self._keeping.ask(work, done, failed)
        self.keep.setEnabled(False)

    def _choose_sketch(self, key: str) -> None:
        self._change(lambda state: replace(state, selected=key, asked=""), "Choose a sketch")

    def _go_back(self) -> None:
        if self._guide is not None and self._guide.before:
            self._choose(self._guide.before)

    def _pass_over(self) -> None:
        if self._guide is not None and self._guide.after:
            self._choose(self._guide.after)

    def _not_visible(self) -> None:
        if self._guide is not None and self._guide.asked:
            node = self._guide.asked
            self._change(lambda state: with_skipped(state, [node]), "Point is not visible")

    def _switch(self, item: QListWidgetItem) -> None:
        name, is_on = item.text(), item.checkState() == CHECKED

        def switched(state: CarState) -> CarState:
            others = tuple(other for other in state.without if other != name)
            return replace(state, without=others if is_on else (*others, name))

        self._change(switched, "Switch soundness")

    def _change(self, change: Callable[[CarState], CarState], label: str) -> None:
        """Change the newest state, which may be newer than what is shown."""
        state = self._host.state
        if isinstance(state, CarState) and state.sketch is not None:
            self._host.change(change(state), label)
