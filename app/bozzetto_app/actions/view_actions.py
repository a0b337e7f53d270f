"""Commands of the *View* menu."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Literal, get_args

from bozzetto_app.actions.registry import Action
from bozzetto_app.i18n import tr
from bozzetto_app.session.view_state import Shading

if TYPE_CHECKING:
    from bozzetto_app.main_window import Window

__all__ = ["view_commands"]

View = Literal["front", "back", "right", "left", "top", "bottom", "three-quarter"]

VIEW_KEYS: dict[str, tuple[str, ...]] = {
    "front": ("Num+1", "F5"),
    "back": ("Ctrl+Num+1",),
    "right": ("Num+3", "F6"),
    "left": ("Ctrl+Num+3",),
    "top": ("Num+7", "F7"),
    "bottom": ("Ctrl+Num+7",),
    "three-quarter": ("Num+0", "F8"),
}
"""As in the programs that designers come from."""

VIEW_ICONS = {"front": "view-front", "right": "view-right", "top": "view-top"}
"""A cube with the side that is looked at; the sides that no icon can show get the bare cube."""


def view_commands(window: Window) -> Iterator[Action]:
    """Yield how the sheet is looked at, and what is seen on it."""
    session, canvas = window.session, window.canvas
    menu = (tr("Menu", "&View"),)

    def shades(shading: str) -> bool:
        return session.view.shading == shading

    titles: dict[str, str] = {
        "front": tr("View", "Front"),
        "back": tr("View", "Back"),
        "right": tr("View", "Right"),
        "left": tr("View", "Left"),
        "top": tr("View", "Top"),
        "bottom": tr("View", "Bottom"),
        "three-quarter": tr("View", "Three-quarter"),
    }
    yield Action(
        "view.fit",
        tr("View", "Show &all"),
        canvas.views.fit,
        "home",
        ("Home",),
        menu,
        on_sheet=True,
    )
    yield Action(
        "view.frame",
        tr("View", "&Frame the selection"),
        canvas.views.frame_selection,
        "fit",
        ("F",),
        menu,
    )
    yield Action(
        "view.projection",
        tr("View", "&Perspective or orthographic"),
        canvas.views.toggle_projection,
        "perspective",
        ("Num+5",),
        menu,
    )
    for view in get_args(View):
        yield Action(
            f"view.{view}",
            titles[view],
            partial(canvas.views.look, view),
            VIEW_ICONS.get(view, "cube"),
            VIEW_KEYS[view],
            (*menu, tr("View", "&Look from")),
        )
    yield Action(
        "view.keep",
        tr("View", "Keep this &view…"),
        window.keep_view,
        "plus",
        (),
        (*menu, tr("View", "&Kept views")),
        tip=tr("View", "Keeps this view with the document, under a name"),
    )
    yield Action(
        "view.better",
        tr("View", "&Turn to the better view"),
        canvas.views.turn_to_better,
        "orbit",
        ("T",),
        menu,
        enabled=lambda: canvas.views.better_view is not None,
        why_not=lambda: tr("View", "No better view is known: this one will do."),
        tip=tr("View", "To the view that the light above the sheet suggests"),
    )
    shadings: dict[str, str] = {
        "clay": tr("View", "Clay"),
        "zebra": tr("View", "Zebra stripes"),
        "curvature": tr("View", "Curvature"),
        "normals": tr("View", "Normals"),
        "xray": tr("View", "X-ray"),
        "draft": tr("View", "Draft angle"),
        "thickness": tr("View", "Wall thickness"),
    }
    for shading in get_args(Shading):
        yield Action(
            f"view.shading.{shading}",
            shadings[shading],
            partial(session.view.set_shading, shading),
            shading,
            (),
            (*menu, tr("View", "&Shading")),
            checked=partial(shades, shading),
        )
    yield Action(
        "view.grid",
        tr("View", "&Ground grid"),
        lambda: session.view.set_show_grid(not session.view.show_grid),
        "grid",
        ("G",),
        menu,
        "show",
        checked=lambda: session.view.show_grid,
    )
    yield Action(
        "view.ghost",
        tr("View", "Processed &ink"),
        lambda: session.view.set_show_ghost_ink(not session.view.show_ghost_ink),
        "ghost-ink",
        ("I",),
        menu,
        "show",
        checked=lambda: session.view.show_ghost_ink,
    )
    yield Action(
        "view.panels",
        tr("View", "Pa&nels"),
        window.toggle_panels,
        "panels",
        ("Tab",),
        menu,
        "show",
        checked=lambda: window.panels_shown,
        on_sheet=True,
    )
    yield Action(
        "view.theme",
        tr("View", "&Dark theme"),
        window.toggle_theme,
        "theme",
        ("Ctrl+Shift+D",),
        menu,
        "show",
        checked=lambda: window.is_dark,
    )
    yield Action(
        "view.radial",
        tr("View", "&Radial menu"),
        canvas.open_menu,
        "",
        ("Q",),
        menu,
        "show",
    )
