"""Figures: how good a result is, as rows that can be read at a glance."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any, Literal

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.panels.properties.figure_labels import KnownFigure, known_figures, known_values
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import tones

__all__ = ["Figure", "Figures", "figures_of", "readable_key"]

UNITS = {
    "mm": "mm",
    "mm2": "mm²",
    "mm3": "mm³",
    "px": "px",
    "deg": "°",
    "percent": "%",
    "ms": "ms",
    "s": "s",
}
"""What a key may end in, and how it is written behind the value."""

GOOD_WHEN_TRUE = frozenset(
    {"watertight", "closed", "ok", "sound", "valid", "converged", "manifold", "ready"}
)
"""Last words of keys that are a verdict; other yes and no is only said."""

ACRONYMS = {"iou": "IoU", "rms": "RMS", "id": "id"}
"""Words that are written in their own way."""

UNREAD = frozenset({"id", "unit", "degree", "camera"})
"""Keys that are there for other programs."""

MOST_ROWS = 12
"""Entries of a mapping that get rows; of a longer one, such as all nodes of a network, only a
sum of its numbers is for people."""

MOST_IN_A_ROW = 4
"""Numbers of a list that are written out; longer ones, and lists of lists, are no figures."""

LARGEST_WRITTEN_OUT = 1e9
"""Beyond it, a number is written with a power of ten."""

THIN_SPACE = "\u202f"
MINUS = "\u2212"

Mark = Literal["", "good", "bad"]


@dataclass(frozen=True)
class Figure:
    """One row: a heading where `value` is None, a remark where it is empty."""

    key: str
    value: str | None
    mark: Mark = ""
    depth: int = 0
    tip: str = ""


def readable_key(key: str) -> tuple[str, str]:
    """Return a key in words, and the unit that it ends in."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", key).replace("-", "_").split("_")
    words = [word for word in words if word]
    unit = UNITS.get(words[-1], "") if len(words) > 1 else ""
    if unit:
        words = words[:-1]
    text = " ".join(ACRONYMS.get(word.lower(), word.lower()) for word in words)
    return text[:1].upper() + text[1:], unit


def _number(value: float) -> str:
    if isinstance(value, int):
        return f"{value:,}".replace(",", THIN_SPACE).replace("-", MINUS)
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        text = f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.0f}".replace(",", THIN_SPACE)
        return text.replace("-", MINUS)
    return f"{value:.2e}"


def _said(value: Any, known: KnownFigure | None = None) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return tr("Figures", "yes") if value else tr("Figures", "no")
    if isinstance(value, int | float):
        if known is not None and value >= known.most:
            return known.beyond
        if known is not None and known.digits >= 0 and abs(value) < LARGEST_WRITTEN_OUT:
            # Adding nothing takes the sign from a zero.
            text = f"{round(known.factor * value, known.digits) + 0.0:,.{known.digits}f}"
            return text.replace(",", THIN_SPACE).replace("-", MINUS)
        return _number(value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        if known is not None and _is_spread(value, known):
            return _spread(value, known)
        return ", ".join(_said(entry, known) for entry in value) or "–"
    return str(value)


def _is_figure(report: Mapping[str, Any], key: str) -> bool:
    """Whether a value is for people: long lists and what is only expected are not."""
    if key.startswith("expected_") and key.removeprefix("expected_") in report:
        return False
    value = report[key]
    if not isinstance(value, list):
        return True
    if _is_spread(value, _known(key)):
        return True
    return 0 < len(value) <= MOST_IN_A_ROW and not any(isinstance(e, list) for e in value)


def _is_spread(value: Any, known: KnownFigure | None) -> bool:
    """Whether a value is a list of numbers that is summed up."""
    numbers = isinstance(value, list) and bool(value) and all(map(_is_number, value))
    return numbers and known is not None and known.spread


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _spread(values: Sequence[float], known: KnownFigure) -> str:
    """Return the median of many numbers, and the largest of them."""
    middle, largest = _said(median(values), known), _said(max(values), known)
    return tr("Figures", "{middle}, at most {largest}", middle=middle, largest=largest)


def _parts(value: Any) -> list[Mapping[str, Any]]:
    """Return the entries of a list of reports; none if it is something else."""
    if isinstance(value, list) and all(isinstance(entry, Mapping) for entry in value):
        return value
    return []


def figures_of(report: Mapping[str, Any], depth: int = 0, part: str = "") -> Iterator[Figure]:
    """Return the rows of a report, in its own order.

    A value whose key also occurs with ``expected_`` before it is good when both agree. A
    single part without a name needs no heading. Mappings and long lists are summed up where it
    is known how; other long ones, and ids, are for other programs.

    Parameters
    ----------
    report : mapping
        Figures by their keys, as the modeler reports them.
    depth : int
        How far the rows are set in.
    part : str
        Id of the part that is chosen: where a list tells of it, only this part is shown.
    """
    for key, value in report.items():
        if key in UNREAD:
            continue
        parts = _parts(value)
        parts = [entry for entry in parts if part and entry.get("id") == part] or parts
        if isinstance(value, Mapping) and _is_spread([*value.values()], _known(key)):
            yield _row({key: [*value.values()]}, key, depth)
        elif isinstance(value, Mapping) and len(value) > MOST_ROWS:
            continue
        elif isinstance(value, Mapping):
            yield Figure(readable_key(key)[0], None, depth=depth)
            yield from figures_of(value, depth + 1, part)
        elif len(parts) == 1 and not parts[0].get("name"):
            yield from figures_of(parts[0], depth, part)
        elif parts:
            for number, entry in enumerate(parts, 1):
                own = entry.get("name")
                name = readable_key(key)[0].removesuffix("s")
                yield Figure(str(own) if own else f"{name} {number}", None, depth=depth)
                rest = {k: v for k, v in entry.items() if k != "name"}
                yield from figures_of(rest, depth + 1, part)
        elif key == "warnings" and isinstance(value, list):
            yield from (Figure(str(words), "", "bad", depth) for words in value if words)
        elif _is_figure(report, key):
            yield _row(report, key, depth)


def _is_verdict(report: Mapping[str, Any], key: str) -> bool:
    """Whether yes is good; a curve need not be closed."""
    return key.lower().split("_")[-1] in GOOD_WHEN_TRUE and "knots" not in report


def _known(key: str) -> KnownFigure | None:
    """Return what is known of a figure, by its key with or without the unit."""
    bare = key.rpartition("_")[0] if readable_key(key)[1] else ""
    return known_figures().get(key) or known_figures().get(bare)


def _row(report: Mapping[str, Any], key: str, depth: int) -> Figure:
    value = report[key]
    name, unit = readable_key(key)
    known = _known(key)
    if known is not None:
        name, unit = known.label, known.unit
    said = _said(value, known)
    if value is None or (known is not None and said == known.beyond):
        unit = ""
    mark: Mark = ""
    if isinstance(value, str) and value in known_values():
        said, verdict = known_values()[value]
        mark = "" if verdict is None else "good" if verdict else "bad"
    if f"expected_{key}" in report:
        expected = report[f"expected_{key}"]
        mark = "good" if value == expected else "bad"
        if mark == "bad":
            said = tr(
                "Figures",
                "{value}, expected {expected}",
                value=said,
                expected=_said(expected, known),
            )
    elif isinstance(value, bool) and _is_verdict(report, key):
        mark = "good" if value else "bad"
    joint = {"": "", "°": "", "%": THIN_SPACE}.get(unit, "\u00a0")
    return Figure(name, f"{said}{joint}{unit}", mark, depth, known.tip if known else "")


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
        self._rows: tuple[Figure, ...] = ()
        self._labels: list[tuple[QLabel, QLabel]] = []

    def show_report(self, report: Mapping[str, Any], part: str = "") -> None:
        """Show other rows; of the part of that id alone where the report tells of it.

        Rows of the same kinds only get other words: reports come with every stroke, and
        making a row takes a millisecond or two of the window's time.
        """
        rows = tuple(figures_of(report, part=part))
        if list(map(_kind, rows)) != list(map(_kind, self._rows)):
            self._make_rows(rows)
        for figure, (words, value) in zip(rows, self._labels, strict=True):
            words.setText(figure.key)
            words.setToolTip(figure.tip)
            value.setText(figure.value or "")
        self._rows = rows

    def _make_rows(self, rows: Sequence[Figure]) -> None:
        while (item := self._grid.takeAt(0)) is not None:
            widget = item.widget()
            if widget is not None:
                widget.hide()
                widget.deleteLater()
        self._labels = [self._make_row(place, figure) for place, figure in enumerate(rows)]

    def _make_row(self, place: int, figure: Figure) -> tuple[QLabel, QLabel]:
        words, value = QLabel(), QLabel()
        for label in (words, value):
            label.setTextFormat(Qt.TextFormat.PlainText)
        words.setIndent(8 * figure.depth)
        if figure.value:
            words.setProperty("tone", "quiet")
            value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            value.setWordWrap(True)
            self._grid.addWidget(words, place, 0)
            self._grid.addWidget(value, place, 1)
        else:
            # Names of parts and remarks may be long: they take more lines, never more room.
            words.setWordWrap(True)
            words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
            words.setProperty("type", "heading" if figure.value is None else "")
            self._grid.addWidget(words, place, 0, 1, 3 if figure.value is None else 2)
        if figure.value is not None:
            self._grid.addWidget(_Mark(figure.mark), place, 2)
        return words, value


def _kind(figure: Figure) -> tuple[int, Mark, bool, bool]:
    """Return the parts of a row that are not only words."""
    return figure.depth, figure.mark, figure.value is None, figure.value == ""
