"""“Read this ink as …”: what other modelers make of ink that is there.

A worker asks one modeler after the other; what can be read is offered with a picture of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import msgspec
from PySide6.QtCore import QObject, Signal

from bozzetto.awake_time import awake_time
from bozzetto.document.model import Model
from bozzetto.document.waiting_ink import strokes_of
from bozzetto.errors import Cancelled, UserError
from bozzetto.geometry.placement import Placement
from bozzetto.ink.stroke import Stroke
from bozzetto_app.i18n import tr
from bozzetto_app.session.selection import why_locked
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.ink.drawing import Drawing
    from bozzetto.plugin.job import Job
    from bozzetto.scene.palette import Palette
    from bozzetto.workbench.readings import Reading
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection

__all__ = ["Ink", "InkReadings"]

READING_LIMIT: Final = 15.0
"""Seconds that a modeler has to read ink and solve it; what takes longer is not offered."""


class Ink(msgspec.Struct, frozen=True, eq=False):
    """Ink to be read.

    Attributes
    ----------
    name : str
        Of the object that it belongs to; "" for ink that waits.
    readers : tuple of str
        Modelers that are asked.
    model : Model or None
        The object as it was then.
    strokes : tuple of Stroke
        The ink that waits.
    """

    name: str
    readers: tuple[str, ...]
    model: Model | None = None
    strokes: tuple[Stroke, ...] = ()


class InkReadings(QObject):
    """Asks other modelers to read ink, and puts what they make of it into the document.

    Attributes
    ----------
    channel : Channel
        The work of asking.

    Signals
    -------
    found : Reading
        A modeler can read the ink.
    ended
        All have been asked.
    """

    found = Signal(object)
    ended = Signal()

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        context: GestureContext,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.channel = Channel("read-ink", keep_all=True, time_limit=READING_LIMIT, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._context, self._notices = context, notices
        self._left = 0
        drawing.closing.connect(self.cancel)

    @property
    def ink(self) -> Ink | None:
        """The ink to be read: what waits, or else that of the selected object; None for none."""
        waiting, model = self._drawing.document.waiting, self._selection.model
        if waiting:
            used = {one.modeler for one in waiting}
            others = self._workbench.readings.readers(without=used if len(used) == 1 else ())
            return Ink("", others, strokes=strokes_of(waiting))
        return None if model is None else self.ink_of(model)

    def ink_of(self, model: Model) -> Ink | None:
        """Return the ink of an object, also of a hidden one; None where its plugin is absent."""
        if self._workbench.is_foreign(model):
            return None
        readers = self._workbench.readings.readers(without=(model.modeler,))
        return Ink(model.name, readers, replace(model, visible=True))

    def ask(self, ink: Ink, palette: Palette, side: int) -> None:
        """Ask all readers, one after the other; see `found`.

        Parameters
        ----------
        ink : Ink
            What they read.
        palette : Palette
            Colours of the pictures.
        side : int
            Size of the pictures, pixels.
        """
        self.cancel()
        readings, context = self._workbench.readings, self._context.now()
        drawings: list[Drawing] = []

        def drawing() -> Drawing:
            """Return the ink; the first reader's turn finds it."""
            if not drawings:
                drawings.append(
                    readings.drawing_of_strokes(ink.strokes, tr("Session", "Drawing"))
                    if ink.model is None
                    else readings.drawing_of([ink.model])
                )
            return drawings[0]

        def request(reader: str) -> Request:
            def work(job: Job) -> Reading:
                return _in_time(
                    job,
                    lambda job: readings.reading(
                        reader, drawing(), context, job, side=side, palette=palette
                    ),
                )

            return Request(work, self._answered, self._failed)

        self._left = len(ink.readers)
        for reader in ink.readers:
            self.channel.submit(request(reader))
        if not ink.readers:
            self.ended.emit()

    def cancel(self) -> None:
        """Ask no more."""
        self.channel.cancel()

    def take(self, ink: Ink, reading: Reading, *, in_place: bool) -> None:
        """Put a reading into the document, as one step of the history.

        Parameters
        ----------
        ink : Ink
            What was read. Ink that waited is part of the new object.
        reading : Reading
            What was made of it.
        in_place : bool
            Whether it takes the place of the object that the ink belongs to, or stands beside it.
        """
        self.cancel()
        document = self._drawing.document
        title = self._workbench.registry.info(reading.model.modeler).title
        label = tr("Session", "Read as {title}", title=title)
        waits = set(map(id, self._drawing.pending))
        old = next((one for one in document if ink.model and one.id == ink.model.id), None)
        changed = old is None or ink.model is None or old.state is not ink.model.state
        try:
            if any(id(stroke) not in waits for stroke in ink.strokes) or (in_place and changed):
                words = tr("Session", "The ink has changed meanwhile. Read it again.")
                raise UserError(words)
            if not in_place or old is None:
                model = replace(reading.model, name=ink.name or reading.model.name)
                self._drawing.apply_model(label, model, is_new=True, used=ink.strokes)
                return
            if old.locked:
                raise UserError(why_locked())
        except UserError as problem:
            self._notices.complain(problem)
            return
        # The ink was read where it stands in the world.
        kept = replace(
            old,
            modeler=reading.model.modeler,
            state=reading.model.state,
            state_version=reading.model.state_version,
            placement=Placement(),
        )
        self._drawing.commit(label, document.with_model(kept))

    def _answered(self, reading: Reading) -> None:
        self.found.emit(reading)
        self._count_down()

    def _failed(self, problem: BaseException) -> None:
        """Offer nothing; what is no answer of a modeler that works well is told."""
        if not isinstance(problem, UserError):
            self._notices.complain(problem)
        self._count_down()

    def _count_down(self) -> None:
        self._left -= 1
        if not self._left:
            self.ended.emit()


def _in_time(job: Job, read: Callable[[Job], Reading]) -> Reading:
    """Read, and give up when the time is over; a modeler without checkpoints is left behind.

    Raises
    ------
    UserError
        If it takes too long.
    """
    until = awake_time() + READING_LIMIT

    def is_late() -> bool:
        return awake_time() > until

    try:
        return read(replace(job, cancelled=lambda: job.cancelled() or is_late()))
    except Cancelled:
        if job.cancelled() or not is_late():
            raise
        raise UserError(tr("Session", "Reading this ink takes too long.")) from None
