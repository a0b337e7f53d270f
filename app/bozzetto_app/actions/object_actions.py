"""Commands of the *Object* menu."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from bozzetto_app.actions.registry import Action
from bozzetto_app.i18n import tr
from bozzetto_app.session.selection import why_locked

if TYPE_CHECKING:
    from bozzetto_app.main_window import Window

__all__ = ["object_commands"]


def object_commands(window: Window) -> Iterator[Action]:
    """Yield what can be done with the chosen object."""
    session = window.session
    menu = (tr("Menu", "&Object"),)

    def has_selection() -> bool:
        return session.selection.id is not None

    def free() -> bool:
        model = session.selection.model
        return model is not None and not model.locked

    def no_selection() -> str:
        if not len(session.drawing.document):
            return tr("Object", "There is no object yet. Draw one first.")
        return tr("Object", "No object is selected. Click one in the list of objects.")

    def not_free() -> str:
        if session.selection.model is None:
            return no_selection()
        return why_locked()

    def is_linked() -> bool:
        model = session.selection.model
        return model is not None and bool(model.sources)

    def not_linked() -> str:
        if not free():
            return not_free()
        return tr("Object", "This object follows no other.")

    def no_use_of_drawings() -> str:
        if not free():
            return not_free()
        return tr("Object", "This object has no use for a drawing. A product lays it on a surface.")

    def no_ink() -> str:
        if session.selection.model is None:
            return no_selection()
        return tr("Object", "The plugin of this object is not here, so its ink cannot be read.")

    def no_group() -> str:
        if not free():
            return not_free()
        return tr("Object", "No group is chosen. Click one in the list of objects.")

    yield Action(
        "object.duplicate",
        tr("Object", "&Duplicate"),
        session.parts.duplicate_chosen,
        "duplicate",
        ("Ctrl+D",),
        menu,
        enabled=has_selection,
        why_not=no_selection,
    )
    yield Action(
        "object.delete",
        tr("Object", "De&lete"),
        session.parts.delete_chosen,
        "trash",
        ("Delete",),
        menu,
        enabled=free,
        why_not=not_free,
        on_sheet=True,
    )
    yield Action(
        "object.play",
        tr("Object", "&Play or stop"),
        session.gestures.motion.play,
        "play",
        ("P",),
        menu,
        enabled=lambda: bool(session.gestures.motion.player) or session.gestures.motion.is_playing,
        why_not=lambda: tr("Object", "Nothing moves here. Choose an object that can move."),
        tip=tr("Object", "The object moves on in time until it is stopped"),
    )
    yield Action(
        "object.ungroup",
        tr("Object", "&Ungroup"),
        session.parts.ungroup_chosen,
        "group",
        ("Ctrl+Shift+G",),
        menu,
        enabled=lambda: free() and bool(session.parts.chosen_group),
        why_not=no_group,
        tip=tr("Object", "The chosen group goes; what is in it stays where it is"),
    )
    for info in session.shapes.takers:
        yield Action(
            f"object.use.{info.id}",
            info.title,
            partial(session.shapes.use_chosen, info.id),
            menu=(*menu, tr("Object", "U&se as input for")),
            enabled=has_selection,
            why_not=no_selection,
            tip=(
                tr("Object", "A new object is made from the chosen shape, and follows it")
                if "follow" in info.abilities
                else tr("Object", "A new object starts from a copy of the chosen shape")
            ),
        )
    yield Action(
        "object.add-drawing",
        tr("Object", "Add a dra&wing…"),
        window.files.ask_drawing,
        "import",
        (),
        menu,
        enabled=lambda: session.files.exchange.drawings.is_wanted,
        why_not=no_use_of_drawings,
        tip=tr("Object", "The outlines of an SVG file, for example, on a surface of a product"),
    )
    yield Action(
        "object.unlink",
        tr("Object", "U&nlink, or link again"),
        session.objects.unlink_selected,
        "link-off",
        (),
        menu,
        enabled=lambda: free() and is_linked(),
        why_not=not_linked,
        tip=tr("Object", "The object keeps what it follows as it is now, or follows it again"),
    )
    yield Action(
        "object.read-ink",
        tr("Object", "&Read this ink as…"),
        window.dialogs.open_readings,
        "pen",
        (),
        menu,
        enabled=lambda: session.readings.ink is not None,
        why_not=no_ink,
        tip=tr("Object", "What other modelers make of the waiting or the selected ink"),
    )
    yield Action(
        "object.hide",
        tr("Object", "&Hide or show"),
        window.session.objects.toggle_visible,
        "eye",
        ("Ctrl+H",),
        menu,
        "state",
        enabled=has_selection,
        why_not=no_selection,
    )
    yield Action(
        "object.lock",
        tr("Object", "Loc&k or unlock"),
        window.session.objects.toggle_locked,
        "lock",
        ("Ctrl+L",),
        menu,
        "state",
        enabled=has_selection,
        why_not=no_selection,
    )
