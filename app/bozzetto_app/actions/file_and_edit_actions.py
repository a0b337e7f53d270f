"""Commands of the *File* and *Edit* menus."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from bozzetto_app.actions.registry import Action
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto_app.main_window import Window

__all__ = ["edit_commands", "file_commands"]


def file_commands(window: Window) -> Iterator[Action]:
    """Yield the commands by which documents come, go and are handed over."""
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
        enabled=lambda: session.gestures.motion.player != "",
        why_not=lambda: tr("File", "Nothing moves here. Choose an object that can move."),
        tip=tr("File", "The next seconds as an animated GLB, USDZ or GIF, as Play would show them"),
    )
    yield Action(
        "file.turntable",
        tr("File", "Tu&rntable…"),
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


def edit_commands(window: Window) -> Iterator[Action]:
    """Yield the commands that undo, and those that finish, drop and bring in ink."""
    session, files = window.session, window.files
    clipboard = session.files.exchange.clipboard
    menu = (tr("Menu", "&Edit"),)

    def no_object() -> str:
        if not len(session.drawing.document):
            return tr("Edit", "There is no object to copy yet. Draw one first.")
        return tr("Edit", "No object is selected. Click one in the list of objects.")

    def undo() -> None:
        window.canvas.hand.end()  # what is under the pen is the last that was done
        session.gestures.undo()

    yield Action(
        "edit.undo",
        tr("Edit", "&Undo"),
        undo,
        "undo",
        ("Ctrl+Z",),
        menu,
        enabled=lambda: (
            session.drawing.history.undo_label is not None or session.gestures.edits.busy
        ),
        why_not=lambda: tr("Edit", "There is nothing to undo."),
        repeats=True,
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
        repeats=True,
    )
    yield Action(
        "edit.copy",
        tr("Edit", "&Copy"),
        lambda: clipboard.copy(window.docks.objects.chosen_models()),
        "copy",
        ("Ctrl+C",),
        menu,
        enabled=lambda: session.selection.id is not None,
        why_not=no_object,
        tip=tr("Edit", "The chosen objects, to be pasted here or into another document"),
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
        repeats=True,
        on_sheet=True,
    )
    yield Action(
        "edit.palette",
        tr("Edit", "Find a co&mmand…"),
        window.dialogs.open_palette,
        "command",
        ("Ctrl+K", "F3"),
        menu,
        "find",
    )
    yield Action(
        "edit.preferences",
        tr("Edit", "Pr&eferences…"),
        window.dialogs.open_preferences,
        "settings",
        ("Ctrl+,",),
        menu,
        "find",
    )
