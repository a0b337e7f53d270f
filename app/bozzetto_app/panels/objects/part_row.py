"""A row of the object list that stands for one part of a model.

What a part has is told by its parameters: one called `operation` is shown as a sign, `opacity` as
a slider, as that of an underlay, and `locked` as a lock.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout

from bozzetto.parameters import parameter_fields
from bozzetto_app.i18n import tr
from bozzetto_app.panels.objects.object_row import GUTTER, Eye, Fold, NamedRow, Sign
from bozzetto_app.widgets.icon_button import IconButton
from bozzetto_app.widgets.slider import Slider

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["PartRow"]

INDENT: Final = 16
"""How far what is in a group stands to the right of it, px."""

DEEPEST: Final = 6
"""Levels after which rows stand no farther to the right: names need room too."""

SIGNS: Final = {"add": "plus", "merge": "merge", "carve": "minus", "intersect": "intersect"}
"""Icons for what a parameter called `operation` may be."""


class PartRow(NamedRow):
    """Arrow, sign, name and eye of one part; a slider and a lock where it has such parameters.

    Signals
    -------
    folded : bool
        A person unfolded (True) or folded the group.
    """

    folded = Signal(bool)

    def __init__(self, session: Session, model_id: str, part_id: str) -> None:
        super().__init__()
        self.renamed.connect(lambda name: session.parts.rename(model_id, part_id, name))
        self.fold = Fold()
        self.fold.clicked.connect(self.folded)
        self.sign = Sign()
        self.eye = Eye()
        self.eye.clicked.connect(lambda off: session.parts.set_visible(model_id, part_id, not off))
        self.opacity = Slider(tr("Objects", "Opacity"), 0.0, 1.0, 0.01, 0.5)
        self.opacity.setFixedWidth(48)
        self.opacity.slid.connect(
            lambda value, going: session.parts.set_value(
                model_id, part_id, "opacity", value, dragging=going
            )
        )
        self.opacity.drag_ended.connect(session.objects.end_drag)
        self.lock = IconButton("unlock", "", on="lock", side=24, glyph=16, faint=True)
        self.lock.clicked.connect(
            lambda on: session.parts.set_value(model_id, part_id, "locked", bool(on))
        )
        self._row = QHBoxLayout(self)
        self._row.setSpacing(0)
        self._row.addWidget(self.fold)
        self._row.addWidget(self.sign)
        self._row.addSpacing(4)
        self._row.addWidget(self.name, 1)
        self._row.addWidget(self.editor, 1)
        self._row.addSpacing(4)
        self._row.addWidget(self.opacity)
        self._row.addWidget(self.lock)
        self._row.addWidget(self.eye)

    def show_part(self, part: Any, depth: int, is_open: bool | None) -> None:
        """Show the part as it is now.

        Parameters
        ----------
        part : Part
            The part of this row.
        depth : int
            Groups that it is in.
        is_open : bool, optional
            Whether what is in it is listed; None for what is no group.
        """
        self.show_name(part.name, visible=part.visible)
        self.fold.show_fold(is_open, part.name)
        operation = getattr(part, "operation", "")
        words = _words_of(part, operation)
        plain_group = is_open is not None and operation in ("", "add")
        self.sign.show_sign("group" if plain_group else SIGNS.get(operation, ""), words)
        self.eye.show_visible(part.visible, part.name)
        names = {field.name for field in parameter_fields(type(part))}
        self.opacity.setVisible("opacity" in names)
        if "opacity" in names:
            said = tr("Objects", "Opacity of {name}", name=part.name)
            self.opacity.setAccessibleName(said)
            self.opacity.setToolTip(said)
            self.opacity.set_silently(part.opacity)
        self.lock.setVisible("locked" in names)
        if "locked" in names:
            self.lock.setChecked(part.locked)
            self.lock.rename(
                tr("Objects", "Unlock {name}", name=part.name)
                if part.locked
                else tr("Objects", "Lock {name}", name=part.name)
            )
        left = GUTTER + INDENT * (1 + min(depth, DEEPEST))
        self._row.setContentsMargins(left, 0, 8, 0)


def _words_of(part: Any, operation: str) -> str:
    """Return the name of a part's operation in the form; "" if it has none."""
    for field in parameter_fields(type(part)):
        if field.name == "operation":
            return dict(field.parameter.choices).get(operation, operation)
    return ""
