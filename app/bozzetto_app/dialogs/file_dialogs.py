"""The questions about files: where to, which one, and what about unsaved work."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6 import QtWidgets  # dialogs by their full names: PySide makes a class at its first use
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication

from bozzetto.atomic_files import Over
from bozzetto.errors import UserError
from bozzetto_app.dialogs.film_dialog import FilmDialog
from bozzetto_app.dialogs.turntable_dialog import TurntableDialog
from bozzetto_app.i18n import tr
from bozzetto_app.session.files import DOCUMENT_ENDING, LAST_FOLDER, Hindrance
from bozzetto_app.session.films import LONGEST_FILM
from bozzetto_app.settings import settings

if TYPE_CHECKING:
    from bozzetto.exchange.formats import Format
    from bozzetto.exchange.handover import Handover
    from bozzetto.plugin.commands import Command
    from bozzetto_app.session.session import Session

__all__ = ["FileQuestions"]

PRINTED = frozenset({".stl", ".3mf"})
"""Endings of files that are made for printers."""


def _nothing() -> None:
    """Do nothing after an answer that nobody waits for."""


class FileQuestions:
    """Asks, then lets the session's files do it.

    Parameters
    ----------
    session : Session
    window : QtWidgets.QWidget
        The parent of the dialogs.
    """

    def __init__(self, session: Session, window: QtWidgets.QWidget) -> None:
        self._session = session
        self._window = window
        self._box: QtWidgets.QMessageBox | None = None
        self._exported: tuple[Path | None, Path] | None = None
        session.files.when_hindered = self.ask_hindered
        session.files.locked.connect(self.ask_take_over)
        session.commands.place_wanted.connect(self.ask_written)
        session.drawing.opened.connect(self._forget_export)

    def ask_new(self) -> None:
        """Start on an empty sheet, once unsaved work is safe."""

        def begin() -> None:
            self._session.files.new()
            self._session.notices.tell(tr("Files", "A new sheet."))

        self.when_safe(begin)

    def ask_open(self) -> None:
        """Ask for a document and open it."""
        documents = tr("Files", "Bozzetto documents ({endings})").format(
            endings=f"*{DOCUMENT_ENDING}"
        )
        path = self._chosen(tr("Files", "Open a document"), documents)
        if path is not None:
            self.when_safe(lambda: self._session.files.open(path))

    def ask_import(self) -> None:
        """Ask for drawings, meshes and pictures and import them."""
        from bozzetto.exchange.formats import readers

        endings = " ".join(f"*{ending}" for one in readers() for ending in one.endings)
        kinds = tr("Files", "Drawings, meshes, pictures ({endings})").format(endings=endings)
        names, _ = QtWidgets.QFileDialog.getOpenFileNames(
            self._window, tr("Files", "Import"), self._folder(), kinds
        )
        paths = [path for name in names if (path := self._noted(name)) is not None]
        if paths:
            self._session.files.exchange.import_files(paths)

    def ask_underlay(self) -> None:
        """Ask for a picture and put it under the sheet."""
        path = self.ask_picture(tr("Files", "Place a picture under the sheet"))
        if path is not None:
            self._session.pictures.take_file(path, under=True)

    def ask_drawing(self) -> None:
        """Ask for a drawing and add it to the selected object."""
        from bozzetto.exchange.formats import readers

        endings = " ".join(f"*{ending}" for one in readers("ink") for ending in one.endings)
        kinds = tr("Files", "Drawings ({endings})").format(endings=endings)
        path = self._chosen(tr("Files", "Add a drawing to the object"), kinds)
        if path is not None:
            self._session.files.exchange.drawings.take_file(path)

    def ask_picture(self, title: str) -> Path | None:
        """Ask for the file of a picture; None if the person would rather not.

        Parameters
        ----------
        title : str
            Of the dialog.
        """
        from bozzetto.exchange.formats import readers

        endings = " ".join(f"*{ending}" for one in readers("image") for ending in one.endings)
        return self._chosen(title, tr("Files", "Pictures ({endings})").format(endings=endings))

    def paste(self, *, under: bool = False) -> None:
        """Take what was copied: objects, files, an SVG drawing or a picture."""
        from bozzetto_app.canvas.input.drag_and_drop import take

        if not take(self._session, QGuiApplication.clipboard().mimeData(), under=under):
            nothing = (
                tr("Files", "There is no picture to paste. Copy one first.")
                if under
                else tr(
                    "Files",
                    "There is nothing to paste. Copy objects, a picture, an SVG drawing or files "
                    "first.",
                )
            )
            self._session.notices.complain(UserError(nothing))

    def ask_save(
        self, then: Callable[[], None] = _nothing, refused: Callable[[], None] = _nothing
    ) -> None:
        """Save where the document lies, or ask for a place."""
        if self._session.drawing.path is None or self._session.drawing.read_only:
            self.ask_save_as(then, refused)
        else:
            self._session.files.save(None, then, refused)

    def ask_save_as(
        self, then: Callable[[], None] = _nothing, refused: Callable[[], None] = _nothing
    ) -> None:
        """Ask for a file name and save the document there."""
        documents = tr("Files", "Bozzetto documents ({endings})").format(
            endings=f"*{DOCUMENT_ENDING}"
        )
        path, is_asked = self._place(tr("Files", "Save the document"), documents, DOCUMENT_ENDING)
        if path is None:
            refused()
        else:
            over = Over.ANYTHING if is_asked else None
            self._session.files.save(path, then, refused, over=over)

    def ask_hindered(self, hindrance: Hindrance) -> None:
        """Say what stands in the way of a save, and let the person choose."""
        if self._box is not None:
            self._session.notices.complain(hindrance.problem)
            hindrance.leave()
            return
        from bozzetto.document.recovery.file_lock import Locked
        from bozzetto_app.dialogs.hindrance import explained, said_of

        box = QtWidgets.QMessageBox(self._window)
        box.setObjectName("hindered")
        box.setIcon(QtWidgets.QMessageBox.Icon.NoIcon)
        box.setText(said_of(hindrance.problem))
        box.setInformativeText(explained(hindrance))
        beside = box.addButton(
            tr("Files", "&Keep both"), QtWidgets.QMessageBox.ButtonRole.AcceptRole
        )
        takes = isinstance(hindrance.problem, Locked)
        words = tr("Files", "&Take over and save") if takes else tr("Files", "&Overwrite")
        anyway = box.addButton(words, QtWidgets.QMessageBox.ButtonRole.DestructiveRole)
        box.addButton(tr("Files", "&Cancel"), QtWidgets.QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(beside)

        def answered() -> None:
            self._box = None
            box.deleteLater()
            if box.clickedButton() is beside:
                hindrance.keep_both()
            elif box.clickedButton() is anyway:
                hindrance.go_on()
            else:
                hindrance.leave()

        self._box = box
        box.finished.connect(answered)
        box.open()

    def ask_take_over(self, path: Path) -> None:
        """Offer to take over a read-only document from the person who has it open."""
        if self._box is not None:
            return
        box = QtWidgets.QMessageBox(self._window)
        box.setObjectName("locked")
        box.setIcon(QtWidgets.QMessageBox.Icon.NoIcon)
        box.setText(tr("Files", "“{name}” is open somewhere else.", name=path.name))
        box.setInformativeText(
            tr(
                "Files",
                "You can look at it, and save it under another name. Take it over only if it "
                "is not being worked on there any more.",
            )
        )
        look = box.addButton(
            tr("Files", "&Look at it"), QtWidgets.QMessageBox.ButtonRole.RejectRole
        )
        take = box.addButton(
            tr("Files", "&Take over"), QtWidgets.QMessageBox.ButtonRole.DestructiveRole
        )
        box.setDefaultButton(look)

        def answered() -> None:
            self._box = None
            box.deleteLater()
            if box.clickedButton() is take:
                self._session.files.take_over(path)

        self._box = box
        box.finished.connect(answered)
        # A file that is dropped, or opened by another program, takes the document away meanwhile.
        self._session.drawing.closing.connect(box.reject)
        box.open()

    def ask_export(self) -> None:
        """Ask for formats and how to export; a question that is open comes to the front."""
        from bozzetto_app.dialogs.handover import HandoverDialog

        asking = self._window.findChildren(HandoverDialog)
        dialog = next((one for one in asking if one.isVisible()), None)
        if dialog is None:
            dialog = HandoverDialog(self._session, self, self._window)
            dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()

    def ask_place_of_export(
        self,
        formats: Sequence[Format],
        handover: Handover | None = None,
        names: Sequence[str] | None = None,
    ) -> bool:
        """Ask for a file name and export; whether there was an answer.

        Parameters
        ----------
        formats : sequence of Format
            For each a file of that name is written, with its ending.
        handover, names
            As in `Exchange.export`.
        """
        kinds = ";;".join(
            f"{one.title} ({' '.join(f'*{ending}' for ending in one.endings)})" for one in formats
        )
        first, is_asked = self._place(tr("Files", "Export"), kinds, "", self._exported_before())
        if first is None:
            return False
        paths = [first]
        if len(formats) > 1:
            endings = {one: one.endings[0] for one in formats}
            mine = next((one for one in formats if first.suffix.lower() in one.endings), None)
            stem = first if mine is None else first.with_suffix("")
            endings |= {} if mine is None else {mine: first.suffix}
            paths = [stem.with_name(stem.name + ending) for ending in endings.values()]
        if not all((is_asked and path == first) or self._may_replace(path) for path in paths):
            return False
        known = any(first.suffix.lower() in one.endings for one in formats)
        stem = first.with_suffix("") if known else first
        self._exported = self._session.drawing.path, stem
        self.when_printable(
            paths,
            lambda: self._session.files.exchange.export(*paths, handover=handover, names=names),
        )
        return True

    def ask_written(self, command: Command) -> None:
        """Ask where the file of a modeler's command goes, and have it written."""
        ending = command.writes
        path, is_asked = self._place(command.title, f"{command.title} (*{ending})", ending)
        if path is None:
            return
        if not path.name.lower().endswith(ending):
            path, is_asked = path.with_name(path.name + ending), False
        if is_asked or self._may_replace(path):
            self._session.commands.write(command.id, path)

    def ask_film(self) -> None:
        """Ask for a file and for how long, and make a film of what moves."""
        from bozzetto.workbench.films import ENDINGS

        animation, moving = tr("Files", "Animation"), tr("Files", "Moving picture")
        kinds = f"{animation} (*.glb);;{animation} (*.usdz);;{moving} (*.gif);;{moving} (*.mp4)"
        title = tr("Files", "Film of what moves")
        path, is_asked = self._place(title, kinds, "")
        if path is None or not (is_asked or self._may_replace(path)):
            return
        if path.suffix.lower() not in ENDINGS:
            said = tr("Files", "A film is a .glb, .usdz, .gif or .mp4. Choose one of these.")
            self._session.notices.complain(UserError(said))
            return
        films = self._session.files.exchange.films
        recorded = films.recorded
        if recorded > 0.0:
            FilmDialog(title, recorded, partial(films.make, path), self._window).open()
        else:
            self._ask_seconds(title, path, films.make)

    def ask_turntable(self) -> None:
        """Ask for a file and for how long, and make a turntable."""
        from bozzetto.workbench.turntables import MOVING

        moving = tr("Files", "Moving picture")
        kinds = f"{moving} (*.gif);;{moving} (*.mp4);;{tr('Files', 'Row of pictures')} (*.png)"
        path, is_asked = self._place(tr("Files", "Turntable"), kinds, "")
        if path is None:
            return
        if path.suffix.lower() in MOVING and not (is_asked or self._may_replace(path)):
            return
        films = self._session.files.exchange.films
        TurntableDialog(partial(films.turn, path), self._window).open()

    def _ask_seconds(self, title: str, path: Path, then: Callable[[Path, float], None]) -> None:
        asked = QtWidgets.QInputDialog(self._window)
        asked.setObjectName("film")
        asked.setWindowTitle(title)
        asked.setLabelText(tr("Files", "Seconds"))
        asked.setInputMode(QtWidgets.QInputDialog.InputMode.DoubleInput)
        asked.setDoubleRange(0.2, LONGEST_FILM)
        asked.setDoubleDecimals(1)
        asked.setDoubleValue(4.0)
        asked.doubleValueSelected.connect(lambda seconds: then(path, seconds))
        asked.finished.connect(asked.deleteLater)
        asked.open()

    def when_printable(self, paths: Sequence[Path], then: Callable[[], None]) -> None:
        """Export, after asking where a printer's file would hold what does not print.

        Parameters
        ----------
        paths : sequence of Path
            Their endings say whether they are for a printer.
        then : callable
            Called at once where nothing is known to stand in the way, else after the answer.
        """
        problems = _print_problems(self._session.solver.report)
        for_printer = any(path.suffix.lower() in PRINTED for path in paths)
        if not for_printer or not problems or self._box is not None:
            then()
            return
        box = QtWidgets.QMessageBox(self._window)
        box.setObjectName("printable")
        box.setIcon(QtWidgets.QMessageBox.Icon.NoIcon)
        box.setText(tr("Files", "This may not print well."))
        box.setInformativeText("\n\n".join(problems))
        anyway = box.addButton(
            tr("Files", "&Export anyway"), QtWidgets.QMessageBox.ButtonRole.AcceptRole
        )
        box.addButton(tr("Files", "&Cancel"), QtWidgets.QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(anyway)

        def answered() -> None:
            self._box = None
            box.deleteLater()
            if box.clickedButton() is anyway:
                then()

        self._box = box
        box.finished.connect(answered)
        box.open()

    def when_safe(
        self, then: Callable[[], None], refused: Callable[[], None] | None = None
    ) -> None:
        """Do something that would lose unsaved work, after asking about it.

        Parameters
        ----------
        then : callable
            Called at once where nothing would be lost, else after the answer.
        refused : callable, optional
            Called if the person would rather stay.

        Notes
        -----
        What plays stops first: the answer is about what is there, and nothing comes after it.
        """
        self._session.gestures.motion.stop()
        if not self._session.drawing.is_modified:
            then()
            return
        stay = refused or _nothing
        if self._box is not None:
            self._box.raise_()
            stay()
            return
        box = QtWidgets.QMessageBox(self._window)
        box.setObjectName("unsaved")
        box.setIcon(QtWidgets.QMessageBox.Icon.NoIcon)
        box.setText(
            tr(
                "Files",
                "“{name}” has changes that are not saved.",
                name=self._session.drawing.title,
            )
        )
        save = box.addButton(tr("Files", "&Save"), QtWidgets.QMessageBox.ButtonRole.AcceptRole)
        drop = box.addButton(
            tr("Files", "&Don’t save"), QtWidgets.QMessageBox.ButtonRole.DestructiveRole
        )
        box.addButton(tr("Files", "&Cancel"), QtWidgets.QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(save)

        def answered() -> None:
            self._box = None
            box.deleteLater()
            if box.clickedButton() is drop:
                self._session.files.given_up.emit()
                then()
            elif box.clickedButton() is save:
                # Again: the person may draw on while it is being written.
                self.ask_save(lambda: self.when_safe(then, refused), stay)
            else:
                stay()

        # Not exec(): an event loop within an event loop would hold up a drop or a close.
        self._box = box
        box.finished.connect(answered)
        box.open()

    def _chosen(self, title: str, kinds: str) -> Path | None:
        name, _ = QtWidgets.QFileDialog.getOpenFileName(self._window, title, self._folder(), kinds)
        return self._noted(name)

    def _forget_export(self) -> None:
        self._exported = None

    def _exported_before(self) -> Path | None:
        """Return where this document was exported last, without an ending."""
        if self._exported is None or self._exported[0] != self._session.drawing.path:
            return None
        return self._exported[1]

    def _place(
        self, title: str, kinds: str, ending: str, before: Path | None = None
    ) -> tuple[Path | None, bool]:
        """Return the chosen file, and whether the dialog asked about overwriting it.

        Proposed is the place before, or else the name of the document.
        """
        at = before or Path(self._folder()) / f"{self._session.drawing.title}{ending}"
        name, chosen = QtWidgets.QFileDialog.getSaveFileName(self._window, title, str(at), kinds)
        path = self._noted(name)
        if path is None or path.suffix:
            return path, not ending or (path is not None and path.suffix.lower() == ending)
        first = chosen.partition("(*")[2].split(")")[0].split(" ")[0]
        return path.with_name(path.name + (ending or first)), False

    def _may_replace(self, path: Path) -> bool:
        """Ask about a file whose name came about only after the dialog had asked."""
        if not path.exists():
            return True
        question = tr("Files", "There is a file “{name}” already. Replace it?", name=path.name)
        yes, no = QtWidgets.QMessageBox.StandardButton.Yes, QtWidgets.QMessageBox.StandardButton.No
        title = tr("Files", "Export")
        return QtWidgets.QMessageBox.question(self._window, title, question, yes | no, no) == yes

    def _folder(self) -> str:
        if self._session.drawing.path is not None:
            return str(self._session.drawing.path.parent)
        return str(settings().value(LAST_FOLDER, str(Path.home())))

    def _noted(self, name: str) -> Path | None:
        if not name:
            return None
        settings().setValue(LAST_FOLDER, str(Path(name).parent))
        return Path(name)


def _print_problems(report: Mapping[str, Any]) -> list[str]:
    """Return the ``problems`` in a report under ``print``, which hinder 3D printing."""
    said = report.get("print")
    problems = said.get("problems") if isinstance(said, Mapping) else None
    return [str(problem) for problem in problems] if isinstance(problems, list) else []
