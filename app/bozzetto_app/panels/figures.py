"""Figures: how good a result is, as rows that can be read at a glance."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from bozzetto_app.icons import paint_icon
from bozzetto_app.panels.known_figures import KnownFigure, known_figures, known_values
from bozzetto_app.theme import tones
from bozzetto_app.words import tr

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

MOST_IN_A_ROW = 4
"""Numbers of a list that are written out; longer lists are counted."""

LARGEST_WRITTEN_OUT = 1e9
"""Beyond it, a number is written with a power of ten."""

THIN_SPACE = "\u202f"
MINUS = "\u2212"

Mark = Literal["", "good", "bad"]


@dataclass(frozen=True)
class Figure:
    """One row: a heading where `value` is None."""

    key: str
    value: str | None
    mark: Mark = ""
    depth: int = 0
    tip: str = ""


def readable_key(key: str) -> tuple[str, str]:
    """A key in words, and the unit that it ends in."""
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
        if known is not None and known.digits >= 0 and abs(value) < LARGEST_WRITTEN_OUT:
            # Adding nothing takes the sign from a zero.
            text = f"{round(known.factor * value, known.digits) + 0.0:,.{known.digits}f}"
            return text.replace(",", THIN_SPACE).replace("-", MINUS)
        return _number(value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        if len(value) <= MOST_IN_A_ROW:
            return ", ".join(_said(entry, known) for entry in value) or "–"
        return tr("Figures", "{count} values", count=len(value))
    return str(value)


def _parts(value: Any) -> list[Mapping[str, Any]]:
    """The entries of a list of reports; none where it is something else."""
    if isinstance(value, list) and all(isinstance(entry, Mapping) for entry in value):
        return value
    return []


def figures_of(report: Mapping[str, Any], depth: int = 0) -> Iterator[Figure]:
    """The rows of a report, in its own order.

    A value whose key also occurs with ``expected_`` before it is good when both agree. A
    single part without a name needs no heading.
    """
    for key, value in report.items():
        parts = _parts(value)
        if isinstance(value, Mapping):
            yield Figure(readable_key(key)[0], None, depth=depth)
            yield from figures_of(value, depth + 1)
        elif len(parts) == 1 and not parts[0].get("name"):
            yield from figures_of(parts[0], depth)
        elif parts:
            for number, part in enumerate(parts, 1):
                own = part.get("name")
                name = readable_key(key)[0].removesuffix("s")
                yield Figure(str(own) if own else f"{name} {number}", None, depth=depth)
                rest = {k: v for k, v in part.items() if k != "name"}
                yield from figures_of(rest, depth + 1)
        elif not (key.startswith("expected_") and key.removeprefix("expected_") in report):
            yield _row(report, key, depth)


def _row(report: Mapping[str, Any], key: str, depth: int) -> Figure:
    value = report[key]
    name, unit = readable_key(key)
    known = known_figures().get(key) or known_figures().get(
        key.rpartition("_")[0] if unit[:2] == "mm" else ""
    )
    if known is not None:
        name, unit = known.label, known.unit
    if value is None:
        unit = ""
    said = _said(value, known)
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
    elif isinstance(value, bool) and key.lower().split("_")[-1] in GOOD_WHEN_TRUE:
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

    def show_report(self, report: Mapping[str, Any]) -> None:
        """Replace all rows."""
        while (item := self._grid.takeAt(0)) is not None:
            widget = item.widget()
            if widget is not None:
                widget.hide()
                widget.deleteLater()
        for row, figure in enumerate(figures_of(report)):
            words = QLabel(figure.key)
            words.setTextFormat(Qt.TextFormat.PlainText)
            words.setIndent(8 * figure.depth)
            if figure.value is None:
                # Names of parts may be long: they take more lines, never more room.
                words.setWordWrap(True)
                words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
                words.setProperty("type", "heading")
                self._grid.addWidget(words, row, 0, 1, 3)
                continue
            words.setProperty("tone", "quiet")
            words.setToolTip(figure.tip)
            value = QLabel(figure.value)
            value.setTextFormat(Qt.TextFormat.PlainText)
            value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            value.setWordWrap(True)
            self._grid.addWidget(words, row, 0)
            self._grid.addWidget(value, row, 1)
            self._grid.addWidget(_Mark(figure.mark), row, 2)
