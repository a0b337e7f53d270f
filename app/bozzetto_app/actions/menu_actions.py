"""What a person can ask the window to do: one list, from which menus and keys are made."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Literal, get_args

from bozzetto_app.actions.registry import Action
from bozzetto_app.i18n import tr
from bozzetto_app.session.tool_groups import TOOL_KEYS
from bozzetto_app.session.view_state import Shading

if TYPE_CHECKING:
    from bozzetto_app.main_window import Window

__all__ = ["commands_of", "number_keys"]

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


def commands_of(window: Window) -> Iterator[Action]:
    """All commands of a window, in the order of its menus."""
    yield from _file(window)
    yield from _edit(window)
    yield from _object(window)
    yield from _view(window)
    yield from _help(window)


def _file(window: Window) -> Iterator[Action]:
    session, files = window.session, window.files
    menu = (tr("Menu", "&File"),)
    yield Action("file.new", tr("File", "&New"), files.ask_new, "file-new", ("Ctrl+N",), menu)
    yield Action("file.open", tr("File", "&Open…"), files.ask_open, "open", ("Ctrl+O",), menu)
    yield Action(
        "file.import",
        tr("File", "&Import…"),
        files.ask_import,
        "import",
        ("Ctrl+I",),
        menu,
        tip=tr("File", "Drawings, meshes, and pictures to work on or to trace"),
    )
    yield Action(
        "file.underlay",
        tr("File", "Place as &underlay…"),
        files.ask_underlay,
        "",
        (),
        menu,
        tip=tr("File", "A picture under the sheet, to be traced; so does Shift with a drop"),
    )
    yield Action(
        "file.trace",
        tr("File", "&Trace into ink…"),
        window.dialogs.open_trace,
        "pen",
        ("Ctrl+T",),
        menu,
        tip=tr("File", "Strokes from the lines of an underlay, or of a sketch in a file"),
    )
    yield Action(
        "file.save",
        tr("File", "&Save"),
        files.ask_save,
        "save",
        ("Ctrl+S",),
        menu,
        "save",
        enabled=lambda: not session.drawing.read_only,
        why_not=lambda: tr(
            "File", "This document can only be looked at here. Use Save as to keep changes."
        ),
    )
    yield Action(
        "file.save_as",
        tr("File", "Save &as…"),
        files.ask_save_as,
        "",
        ("Ctrl+Shift+S",),
        menu,
        "save",
    )
    yield Action(
        "file.export",
        tr("File", "&Export…"),
        files.ask_export,
        "export",
        ("Ctrl+E",),
        menu,
        "save",
        enabled=lambda: len(session.drawing.document) > 0,
        why_not=lambda: (
            tr("File", "Ink is waiting. Finish it with Enter, then export.")
            if session.drawing.pending
            else tr("File", "There is nothing to export yet. Draw something first.")
        ),
        tip=tr("File", "For a 3D printer, for Blender, for the web"),
    )
    yield Action(
        "file.film",
        tr("File", "&Film of what moves…"),
        files.ask_film,
        "play",
        (),
        menu,
        "save",
        enabled=lambda: session.gestures.motion.can_play,
        why_not=lambda: tr("File", "Nothing moves here. Take a tool that moves an object."),
        tip=tr("File", "The next seconds as an animated GLB or GIF, as Play would show them"),
    )
    yield Action(
        "file.turntable",
        tr("File", "&Turntable…"),
        files.ask_turntable,
        "play",
        (),
        menu,
        "save",
        enabled=lambda: len(session.drawing.document) > 0,
        why_not=lambda: tr("File", "There is nothing to turn yet. Draw something first."),
        tip=tr("File", "What is drawn from all around, as a GIF or a row of pictures"),
    )
    yield Action("file.quit", tr("File", "&Quit"), window.close, "quit", ("Ctrl+Q",), menu, "quit")


def _edit(window: Window) -> Iterator[Action]:
    session, files = window.session, window.files
    menu = (tr("Menu", "&Edit"),)
    yield Action(
        "edit.undo",
        tr("Edit", "&Undo"),
        session.drawing.undo,
        "undo",
        ("Ctrl+Z",),
        menu,
        enabled=lambda: session.drawing.history.undo_label is not None,
        why_not=lambda: tr("Edit", "There is nothing to undo."),
    )
    yield Action(
        "edit.redo",
        tr("Edit", "&Redo"),
        session.drawing.redo,
        "redo",
        ("Ctrl+Shift+Z", "Ctrl+Y"),
        menu,
        enabled=lambda: session.drawing.history.redo_label is not None,
        why_not=lambda: tr("Edit", "There is nothing to do again: nothing was undone."),
    )
    yield Action("edit.paste", tr("Edit", "&Paste"), files.paste, "", ("Ctrl+V",), menu)
    yield Action(
        "edit.paste_under",
        tr("Edit", "Paste as underla&y"),
        partial(files.paste, under=True),
        "",
        ("Ctrl+Shift+V",),
        menu,
        tip=tr("Edit", "The copied picture, under the sheet"),
    )
    yield Action(
        "edit.commit",
        tr("Edit", "&Finish the stroke, or start a new object"),
        session.gestures.commit,
        "commit",
        ("Return", "Enter"),
        menu,
        "ink",
        on_sheet=True,
    )
    yield Action(
        "edit.drop",
        tr("Edit", "Take &back the last waiting stroke"),
        session.gestures.drop_last,
        "",
        ("Backspace",),
        menu,
        "ink",
        enabled=lambda: bool(session.drawing.pending),
        why_not=lambda: tr("Edit", "No stroke is waiting. Undo takes back what is done."),
        on_sheet=True,
    )
    yield Action(
        "edit.palette",
        tr("Edit", "Find a &command…"),
        window.dialogs.open_palette,
        "command",
        ("Ctrl+K", "F3"),
        menu,
        "find",
    )
    yield Action(
        "edit.preferences",
        tr("Edit", "&Preferences…"),
        window.dialogs.open_preferences,
        "settings",
        ("Ctrl+,",),
        menu,
        "find",
    )


def _object(window: Window) -> Iterator[Action]:
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
        return tr("Object", "This object is locked. Unlock it to change it.")

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
        enabled=lambda: session.gestures.motion.can_play or session.gestures.motion.is_playing,
        why_not=lambda: tr("Object", "Nothing moves here. Take a tool that moves an object."),
        tip=tr("Object", "The tool in the hand moves the object on in time, until it is stopped"),
        on_sheet=True,
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
        tr("Object", "Unlin&k, or link again"),
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


def _view(window: Window) -> Iterator[Action]:
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
        "view.fit", tr("View", "Show &all"), canvas.fit, "home", ("Home",), menu, on_sheet=True
    )
    yield Action(
        "view.frame",
        tr("View", "&Frame the selection"),
        canvas.frame_selection,
        "fit",
        ("F",),
        menu,
    )
    yield Action(
        "view.projection",
        tr("View", "&Perspective or orthographic"),
        canvas.toggle_projection,
        "perspective",
        ("Num+5",),
        menu,
    )
    for view in get_args(View):
        yield Action(
            f"view.{view}",
            titles[view],
            partial(canvas.look, view),
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
        tip=tr("View", "With the document, under a name"),
    )
    yield Action(
        "view.better",
        tr("View", "&Turn to the better view"),
        canvas.turn_to_better,
        "orbit",
        ("T",),
        menu,
        enabled=lambda: canvas.better_view is not None,
        why_not=lambda: tr("View", "No better view is known: this one will do."),
        tip=tr("View", "Where the light above the sheet points"),
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


def _help(window: Window) -> Iterator[Action]:
    menu = (tr("Menu", "&Help"),)
    yield Action(
        "help.guide",
        tr("Help", "&Guide"),
        window.dialogs.open_guide,
        "help",
        ("Shift+F1",),
        menu,
        tip=tr("Help", "How everything works, with pictures; nothing is fetched from the web"),
    )
    yield Action(
        "help.shortcuts",
        tr("Help", "&Keys and gestures"),
        window.dialogs.open_shortcuts,
        "keyboard",
        ("F1",),
        menu,
    )
    for info in window.session.toolbox.modelers:
        for sample, title in zip(info.samples, info.sample_titles, strict=True):
            yield Action(
                f"help.watch.{info.id}.{sample.stem}",
                f"{info.title}: {title}",
                partial(window.watch, info.id, sample),
                "play",
                (),
                (*menu, tr("Help", "&Watch a drawing")),
            )
    yield Action(
        "help.pen",
        tr("Help", "&Pen tester"),
        window.dialogs.open_pen_tester,
        "pen-tester",
        (),
        menu,
    )
    yield Action(
        "help.plugins", tr("Help", "P&lugins"), window.dialogs.open_plugins, "plugin", (), menu
    )
    yield Action(
        "help.about", tr("Help", "&About Bozzetto"), window.dialogs.open_about, "info", (), menu
    )


def number_keys(window: Window) -> Iterator[Action]:
    """1 … 9 and 0 take what the buttons of the tool rail show, and then the next of their group."""

    def there_is(place: int) -> bool:
        return place < len(window.session.toolbox.groups)

    def take(place: int) -> None:
        if there_is(place):
            window.session.toolbox.take_group(place)

    def too_few() -> str:
        session = window.session
        if not session.toolbox.modeler:
            return tr("Tool", "Choose a modeler at the top right first.")
        title = session.registry.info(session.toolbox.modeler).title
        count = len(session.toolbox.groups)
        return tr("Tool", "{title} has keys up to {count}.", title=title, count=count)

    for number, key in enumerate(TOOL_KEYS, 1):
        yield Action(
            f"tool.{number}",
            tr("Tool", "Tool {number}").format(number=number),
            partial(take, number - 1),
            keys=(key,),
            enabled=partial(there_is, number - 1),
            why_not=too_few,
            on_sheet=True,
        )
