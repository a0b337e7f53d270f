"""Figures: how good a result is, as rows that can be read at a glance."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import takewhile
from time import monotonic
from typing import Any, Final, Literal, NamedTuple

from PySide6.QtCore import QRectF, QSize, Qt, QTimer
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from bozzetto.plugin.figures import Figure, figure_of, without_unit
from bozzetto_app.i18n import tr
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import tones

__all__ = ["Figures", "Row", "readable_key", "rows_of"]

ACRONYMS = {"iou": "IoU", "rms": "RMS", "id": "id"}
"""Words that are written in their own way."""

UNREAD = frozenset({"id", "unit"})
"""Keys that are there for other programs."""

MOST_ROWS = 12
"""Entries of a mapping that get rows; of a longer one, such as all nodes of a network, only a
sum of its numbers is for people."""

MOST_PARTS = 3
"""Parts that are told of one after the other; of more only one that is chosen is, and all others
are counted: each takes some milliseconds of the window's time."""

MOST_WARNINGS = 8
"""Warnings that get a row each; more of them are counted."""

MOST_IN_A_ROW = 4
"""Numbers of a list that are written out; longer ones, and lists of lists, are no figures."""

LARGEST_WRITTEN_OUT = 1e9
"""Beyond it, a number is written with a power of ten."""

SLICE: Final = 0.008
"""Time for rows between two looks at what the person does, s."""

THIN_SPACE = "\u202f"
MINUS = "\u2212"

Mark = Literal["", "good", "bad"]


NOTHING_SAID = Figure("")
"""Of a value whose modeler says nothing about it: it is shown by its key."""


class Row(NamedTuple):
    """One row: a heading where `value` is None, a remark where it is empty."""

    key: str
    value: str | None
    mark: Mark = ""
    depth: int = 0
    tip: str = ""


def readable_key(key: str) -> tuple[str, str]:
    """Return a key in words, and the unit that it ends in."""
    bare, unit = without_unit(key)
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", bare).replace("-", "_").split("_")
    words = [word for word in words if word]
    text = " ".join(ACRONYMS.get(word.lower(), word.lower()) for word in words)
    return text[:1].upper() + text[1:], unit


def _number(value: float) -> str:
    if isinstance(value, int):
        return f"{value:,}".replace(",", THIN_SPACE).replace("-", MINUS)
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        text = f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.0f}".replace(",", THIN_SPACE)
        return text.replace("-", MINUS)
    return f"{value:.2e}"


def _said(value: Any, figure: Figure = NOTHING_SAID) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return tr("Figures", "yes") if value else tr("Figures", "no")
    if isinstance(value, int | float):
        if value >= figure.most:
            return figure.beyond
        if figure.factor != 1.0:
            value = figure.factor * value
        if figure.digits >= 0 and abs(value) < LARGEST_WRITTEN_OUT:
            # Adding nothing takes the sign from a zero.
            text = f"{round(value, figure.digits) + 0.0:,.{figure.digits}f}"
            return text.replace(",", THIN_SPACE).replace("-", MINUS)
        return _number(value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        if _is_spread(value, figure):
            return _spread(value, figure)
        return ", ".join(_said(entry, figure) for entry in value) or "–"
    return figure.values.get(str(value), str(value))


def _is_spread(value: Any, figure: Figure) -> bool:
    """Whether a value is a list of numbers that is summed up."""
    return figure.spread and isinstance(value, list) and bool(value) and all(map(_is_number, value))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _spread(values: Sequence[float], figure: Figure) -> str:
    """Return the median of many numbers, and the largest of them."""
    from statistics import median

    middle, largest = _said(median(values), figure), _said(max(values), figure)
    return tr("Figures", "{middle}, at most {largest}", middle=middle, largest=largest)


def _parts(value: Any) -> list[Mapping[str, Any]]:
    """Return the entries of a list of reports; none if it is something else."""
    if isinstance(value, list) and all(isinstance(entry, Mapping) for entry in value):
        return value
    return []


def rows_of(
    report: Mapping[str, Any], figures: Mapping[str, Figure], depth: int = 0, part: str = ""
) -> Iterator[Row]:
    """Return the rows of a report, in its own order, after what it warns of.

    A value whose key also occurs with ``expected_`` before it is good when both agree. A
    single part without a name needs no heading; many are counted. Mappings and long lists are
    summed up where their figure says so; other long ones, and ids, are for other programs.

    Parameters
    ----------
    report : mapping
        Values by their keys, as the modeler reports them.
    figures : mapping of str to Figure
        How the modeler wants them said, by the keys without units. Any other is made readable
        from its key.
    depth : int
        How far the rows are set in.
    part : str
        Id of the part that is chosen: where a list tells of it, only this part is shown.
    """
    for key, value in sorted(report.items(), key=lambda entry: entry[0] != "warnings" or depth):
        figure = figure_of(key, figures)
        if key in UNREAD or not (figure is None or figure.label):
            continue
        said = figure or NOTHING_SAID
        parts = _parts(value)
        parts = [entry for entry in parts if part and entry.get("id") == part] or parts
        heading = said.label or readable_key(key)[0]
        if isinstance(value, Mapping) and _is_spread([*value.values()], said):
            yield _row({key: [*value.values()]}, key, said, depth)
        elif isinstance(value, Mapping) and len(value) > MOST_ROWS:
            continue
        elif isinstance(value, Mapping):
            yield Row(heading, None, depth=depth, tip=said.help)
            yield from rows_of(value, figures, depth + 1, part)
        elif len(parts) == 1 and not parts[0].get("name"):
            yield from rows_of(parts[0], figures, depth, part)
        elif len(parts) > MOST_PARTS:
            tip = tr("Figures", "Choose one of them to see its figures.")
            yield Row(heading, _number(len(parts)), depth=depth, tip=tip)
        elif parts:
            for number, entry in enumerate(parts, 1):
                own = entry.get("name")
                name = heading.removesuffix("s")
                yield Row(str(own) if own else f"{name} {number}", None, depth=depth)
                rest = {k: v for k, v in entry.items() if k != "name"}
                yield from rows_of(rest, figures, depth + 1, part)
        elif key == "warnings" and isinstance(value, list):
            words = [str(words) for words in value if words]
            more = len(words) - MOST_WARNINGS
            if more > 0:
                words[MOST_WARNINGS:] = [tr("Figures", "And {count} more.", count=more)]
            yield from (Row(each, "", "bad", depth) for each in words)
        elif _is_shown(report, key, said):
            yield _row(report, key, said, depth)


def _is_shown(report: Mapping[str, Any], key: str, figure: Figure) -> bool:
    """Whether a value is for people: long lists and what is only expected are not."""
    if key.startswith("expected_") and key.removeprefix("expected_") in report:
        return False
    value = report[key]
    if not isinstance(value, list) or _is_spread(value, figure):
        return True
    return 0 < len(value) <= MOST_IN_A_ROW and not any(isinstance(e, list) for e in value)


def _row(report: Mapping[str, Any], key: str, figure: Figure, depth: int) -> Row:
    value = report[key]
    name, unit = readable_key(key)
    unit = figure.unit or unit
    said = _said(value, figure)
    if value is None or (figure.beyond and said == figure.beyond):
        unit = ""
    if f"expected_{key}" in report:
        expected = report[f"expected_{key}"]
        fine: bool | None = value == expected
        if not fine:
            said = tr(
                "Figures",
                "{value}, expected {expected}",
                value=said,
                expected=_said(expected, figure),
            )
    else:
        fine = figure.verdict(value)
    mark: Mark = "" if fine is None else "good" if fine else "bad"
    joint = {"": "", "°": "", "%": THIN_SPACE}.get(unit, "\u00a0")
    return Row(figure.label or name, f"{said}{joint}{unit}", mark, depth, figure.help)


class _Mark(QWidget):
    """A tick or a warning sign; the words beside it say the same."""

    def __init__(self, mark: Mark) -> None:
        super().__init__()
        self._mark = mark
        self.setFixedSize(QSize(16, 16))
        said = {"good": tr("Figures", "good"), "bad": tr("Figures", "needs a look"), "": ""}[mark]
        self.setAccessibleName(said)
        self.setToolTip(said)

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._mark:
            painter = QPainter(self)
            colors = tones()
            name, color = (
                ("check", colors.good) if self._mark == "good" else ("warning", colors.warning)
            )
            paint_icon(painter, name, QRectF(self.rect()), color)


class Figures(QWidget):
    """A report as two columns: what, how much."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(tr("Figures", "Figures"))
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(8)
        self._grid.setVerticalSpacing(4)
        self._grid.setColumnStretch(1, 1)
        self._rows: tuple[Row, ...] = ()
        self._made: list[_MadeRow] = []
        # Rows are made between two frames, as those of forms are: all of them take longer than one.
        self._soon = QTimer(self, singleShot=True, interval=1)
        self._soon.timeout.connect(self._make_more)

    @property
    def is_ready(self) -> bool:
        """Whether all rows are there; many are made in a few turns of the loop."""
        return not self._soon.isActive()

    def show_report(
        self, report: Mapping[str, Any], figures: Mapping[str, Figure], part: str = ""
    ) -> None:
        """Show other rows; of the part of that id alone where the report tells of it.

        Rows of the same kinds only get other words: reports come with every stroke, and
        making a row takes a millisecond or two of the window's time.
        """
        self._rows = tuple(rows_of(report, figures, part=part))
        kinds = zip(self._made, map(_kind, self._rows), strict=False)
        kept = list(takewhile(lambda both: both[0].kind == both[1], kinds))
        for made in self._made[len(kept) :]:
            made.remove_from(self._grid)
        del self._made[len(kept) :]
        for made, row in zip(self._made, self._rows, strict=False):
            made.show_words(row)
        self._make_more()

    def _make_more(self) -> None:
        """Make rows for a moment; the others follow."""
        self._soon.stop()
        end = monotonic() + SLICE
        while len(self._made) < len(self._rows):
            if monotonic() > end:
                self._soon.start()
                return
            self._made.append(_MadeRow(self._grid, len(self._made), self._rows[len(self._made)]))


class _MadeRow:
    """The widgets of a row.

    Attributes
    ----------
    kind : tuple
        What of the row cannot be changed any more.
    """

    def __init__(self, grid: QGridLayout, place: int, row: Row) -> None:
        self.kind = _kind(row)
        self._words, self._value = words, value = QLabel(row.key), QLabel(row.value or "")
        self._mark = None if row.value is None else _Mark(row.mark)
        words.setToolTip(row.tip)
        for label in (words, value):
            label.setTextFormat(Qt.TextFormat.PlainText)
        words.setIndent(8 * row.depth)
        if row.value:
            words.setProperty("tone", "quiet")
            value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            value.setWordWrap(True)
            grid.addWidget(words, place, 0)
            grid.addWidget(value, place, 1)
        else:
            # Names of parts and remarks may be long: they take more lines, never more room.
            words.setWordWrap(True)
            words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
            words.setProperty("type", "heading" if row.value is None else "")
            grid.addWidget(words, place, 0, 1, 3 if row.value is None else 2)
        if self._mark is not None:
            grid.addWidget(self._mark, place, 2)

    def show_words(self, row: Row) -> None:
        """Show the words of another row of the same kind."""
        self._words.setText(row.key)
        self._words.setToolTip(row.tip)
        self._value.setText(row.value or "")

    def remove_from(self, grid: QGridLayout) -> None:
        """Take the row off the panel."""
        for widget in filter(None, (self._words, self._value, self._mark)):
            grid.removeWidget(widget)
            widget.hide()
            widget.deleteLater()


def _kind(row: Row) -> tuple[int, Mark, bool, bool]:
    """Return the parts of a row that are not only words."""
    return row.depth, row.mark, row.value is None, row.value == ""
