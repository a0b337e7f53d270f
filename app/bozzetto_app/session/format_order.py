"""The order in which formats are offered for the objects on the sheet."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from bozzetto.exchange.formats import Format, writers

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["offered_formats", "suiting_first"]


def suiting_first(formats: Iterable[Format], *, exact: bool) -> tuple[Format, ...]:
    """Return the formats, suitable ones first.

    Parameters
    ----------
    formats : iterable of Format
        The formats in any order.
    exact : bool
        Whether all objects have exact curves and surfaces: formats for CAD come first, then
        those that hold curves alone. Otherwise meshes come first.
    """

    def rank(one: Format) -> int:
        if not exact:
            return 0 if "mesh" in one.holds else 1
        return 0 if "surfaces" in one.holds else 1 if "curves" in one.holds else 2

    return tuple(sorted(formats, key=rank))


def offered_formats(session: Session) -> tuple[Format, ...]:
    """Return the formats for shapes, those first that suit the visible objects."""
    visible = [model for model in session.drawing.document if model.visible]
    curves = session.workbench.curves
    exact = bool(visible) and all(curves.of([model]) for model in visible)
    return suiting_first(writers("mesh", "curves"), exact=exact)
