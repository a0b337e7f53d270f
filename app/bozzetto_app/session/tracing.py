"""Pictures of drawings on paper, traced into waiting ink."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import msgspec
import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QImage

from bozzetto.document.waiting_ink import WaitingStroke
from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Underlay
    from bozzetto.ink.trace.trace import Sheet, TracedLine
    from bozzetto.plugin.job import Job
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.toolbox import Toolbox
    from bozzetto_app.session.view_state import ViewState

__all__ = ["Place", "Traced", "Tracing"]

PREVIEW_SIDE: Final = 1024
"""Longest side of the picture behind the preview, pixels."""

Place = Literal["picture", "view"]
"""Where the ink goes: along the underlay as it is seen, or as large as it fits into the view."""


class Traced(msgspec.Struct, frozen=True, eq=False):
    """Lines that were found in a picture.

    Attributes
    ----------
    sheet : Sheet
        The picture as it was traced.
    lines : tuple of TracedLine
    image : QImage
        The sheet, small.
    """

    sheet: Sheet
    lines: tuple[TracedLine, ...]
    image: QImage


class Tracing(QObject):
    """Traces one picture after another, and makes waiting ink of what was found.

    Attributes
    ----------
    channel : Channel
        The tracing under way; only the newest wish is kept.

    Signals
    -------
    found : Traced
    failed : str
        What the person is to do instead.
    """

    found = Signal(object)
    failed = Signal(str)

    def __init__(
        self,
        drawing: DocumentModel,
        view: ViewState,
        toolbox: Toolbox,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.channel = Channel("trace", is_patient=True, parent=self)
        notices.watch(self.channel)
        self._drawing, self._view = drawing, view
        self._toolbox, self._notices = toolbox, notices
        drawing.closing.connect(self.channel.cancel)

    @property
    def underlay(self) -> Underlay | None:
        """The underlay that is traced where none is named: the newest that is visible."""
        shown = [one for one in self._drawing.document.underlays if one.visible]
        return shown[-1] if shown else None

    def best_place(self, underlay: Underlay) -> Place:
        """Return where ink of an underlay goes if the person says nothing."""
        from bozzetto.ink.trace.placed_ink import is_seen_square

        height, width = underlay.pixels.shape[:2]
        place = (underlay.corner, underlay.across, underlay.down)
        square = is_seen_square((width, height), place, self._view.camera)
        return "picture" if square else "view"

    def trace(
        self,
        source: Path | Underlay,
        sensitivity: float,
        *,
        page: bool = True,
        known: Sheet | None = None,
    ) -> None:
        """Trace a picture, in a worker; see `found`.

        Parameters
        ----------
        source : Path or Underlay
            The picture.
        sensitivity : float
            0 … 1: how faint a line may be.
        page : bool
            Whether a page is looked for.
        known : Sheet, optional
            The picture as it was prepared before, if the page was looked for then as well.
        """

        def work(job: Job) -> Traced:
            from bozzetto.exchange.import_file import read_image
            from bozzetto.ink.trace.trace import sheet_of, trace

            def reading() -> None:
                assert isinstance(source, Path)
                job.checkpoint(0.0, tr("Files", "Reading {name}", name=source.name))

            sheet = known
            if sheet is None:
                pixels = (
                    read_image(source, checkpoint=reading)
                    if isinstance(source, Path)
                    else source.pixels
                )
                sheet = sheet_of(pixels, page=page, checkpoint=job.checkpoint)
            lines = trace(sheet, sensitivity, checkpoint=job.checkpoint)
            return Traced(sheet, lines, _small(sheet))

        def stopped() -> None:
            self.failed.emit(tr("Session", "Stopped. Move the slider to try again."))

        self.channel.submit(Request(work, self.found.emit, self._fail, stopped=stopped))

    def cancel(self) -> None:
        """Trace no more."""
        self.channel.cancel()

    def take(self, traced: Traced, underlay: Underlay | None, place: Place) -> None:
        """Make waiting ink of what was found, as one step of the history.

        Parameters
        ----------
        traced : Traced
            What was found.
        underlay : Underlay, optional
            The underlay that it was found in. Where the ink goes along it and its page was
            straightened, the straight page takes its place.
        place : {"picture", "view"}
            Where the ink goes; a picture of a file has no place of its own.
        """
        from bozzetto.ink.trace.placed_ink import strokes_in_view, strokes_on_picture

        document, camera = self._drawing.document, self._view.camera
        try:
            if place == "picture" and underlay is not None:
                laid = _straight(underlay, traced.sheet)
                document = _with_underlay(document, laid)
                corners = (laid.corner, laid.across, laid.down)
                strokes = strokes_on_picture(traced.lines, traced.sheet.size, corners, camera)
            else:
                strokes = strokes_in_view(traced.lines, traced.sheet.size, camera)
        except UserError as problem:
            self._notices.complain(problem)
            return
        modeler, tool = self._toolbox.modeler, self._toolbox.tool_for("ink")
        reason = tr("Session", "Traced ink waits. Enter tries it; the eraser takes strokes away.")
        waits = tuple(
            WaitingStroke(stroke, modeler, tool, "unfinished", reason) for stroke in strokes
        )
        document = document.with_waiting((*document.waiting, *waits))
        self._drawing.commit(tr("Session", "Trace into ink"), document)
        self._notices.tell(
            tr(
                "Session",
                "{count} strokes wait. Erase what should not be there, then press Enter; "
                "“Read this ink as…” asks all modelers.",
                count=len(strokes),
            )
        )

    def _fail(self, problem: BaseException) -> None:
        if isinstance(problem, UserError):
            self.failed.emit(problem.message)
        else:
            self._notices.complain(problem)
            self.failed.emit(tr("Session", "This picture could not be traced."))


def _small(sheet: Sheet) -> QImage:
    """Return a sheet as a picture for the window, with fewer pixels."""
    step = max(1, -(-max(sheet.size) // PREVIEW_SIDE))
    pixels = np.ascontiguousarray(sheet.pixels[::step, ::step])
    height, width = pixels.shape[:2]
    image = QImage(pixels.tobytes(), width, height, 4 * width, QImage.Format.Format_RGBA8888)
    return image.copy()


def _straight(underlay: Underlay, sheet: Sheet) -> Underlay:
    """Return an underlay with its page straightened, as large as it was and in its middle."""
    if sheet.corners is None:
        return underlay
    height, width = underlay.pixels.shape[:2]
    corner, across, down = (
        np.array(vector) for vector in (underlay.corner, underlay.across, underlay.down)
    )
    middle = sheet.corners.mean(axis=0)
    new_across, new_down = across * (sheet.size[0] / width), down * (sheet.size[1] / height)
    at = corner + across * (middle[0] / width) + down * (middle[1] / height)
    start = at - 0.5 * (new_across + new_down)
    x, y, z = start.tolist()
    a, b, c = new_across.tolist()
    d, e, f = new_down.tolist()
    return replace(
        underlay, pixels=sheet.pixels, corner=(x, y, z), across=(a, b, c), down=(d, e, f)
    )


def _with_underlay(document: Document, underlay: Underlay) -> Document:
    """Return a document with an underlay in the place of that of its id.

    Raises
    ------
    UserError
        If it is no longer there.
    """
    from bozzetto.document.edit import change_underlay

    return change_underlay(document, underlay).document
