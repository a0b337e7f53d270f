"""Picturing: pictures that come in go to the modeler that works on them, or under the sheet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QImage

from bozzetto.document import edit
from bozzetto.document.model import Model, Underlay, new_id
from bozzetto.errors import UserError
from bozzetto.plugin.job import Job
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture
    from bozzetto_app.session.session import Session

__all__ = ["Picturing"]

UNDERLAY_WIDTH = 200.0
"""Width at which a picture to trace is laid on the sheet, mm."""

SLOW_AFTER = 60.0
"""Seconds without progress after which reading a picture is told as slow."""


class Picturing(QObject):
    """Takes pictures from files and from the clipboard.

    One that comes while a model is selected whose modeler works on pictures goes to that model;
    with nothing selected, a new model of the active modeler is made of it. All others, and
    those that the person wants there, are laid under the sheet to be traced.

    Signals
    -------
    taken : str
        A model (id) has got a picture.
    progressed : float, str; busy_changed : bool
    """

    taken = Signal(str)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._channel = Channel(
            "picture", keep_all=True, time_limit=SLOW_AFTER, is_patient=True, parent=self
        )
        self._channel.slow.connect(session.tell_slow)
        self._channel.progressed.connect(self.progressed)
        self._channel.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether a picture is still being read."""
        return self._channel.busy

    def cancel(self) -> None:
        """Stop it; nothing comes of what is under way."""
        self._channel.cancel()

    def take_file(self, path: Path, *, under: bool = False) -> None:
        """Bring in a picture from a file.

        Parameters
        ----------
        path : Path
        under : bool
            Whether it is to lie under the sheet in any case.
        """
        modeler, base = ("", None) if under else self._taker()

        def work(job: Job) -> Picture | Underlay:
            from bozzetto.exchange.import_file import read_image, read_picture

            def reading() -> None:
                job.checkpoint(0.0, tr("Files", "Reading {name}", name=path.name))

            if self._takes(modeler):
                return read_picture(path, checkpoint=reading)
            return laid_on_sheet(read_image(path, checkpoint=reading), path.stem)

        self._read(work, modeler, base)

    def take_image(self, image: QImage, name: str, *, under: bool = False) -> None:
        """Bring in a picture that is in no file, such as one from the clipboard."""
        modeler, base = ("", None) if under else self._taker()

        def work(job: Job) -> Picture | Underlay:
            from bozzetto.images.stored_picture import Picture

            pixels = pixels_of(image)
            if self._takes(modeler):
                return Picture.of(pixels, name)
            return laid_on_sheet(pixels, name)

        self._read(work, modeler, base)

    def _taker(self) -> tuple[str, str | None]:
        """The modeler that is asked first, and the model (id) that it would go to."""
        session = self._session
        model = session.selected_model
        if model is None:
            return session.active_modeler, None
        usable = model.visible and not model.locked and not session.workbench.is_foreign(model)
        return (model.modeler, model.id) if usable else ("", None)

    def _takes(self, modeler: str) -> bool:
        """In a worker: whether a modeler works on pictures; its plugin may have to be imported."""
        try:
            return bool(modeler) and self._session.workbench.sources.takes_pictures(modeler)
        except UserError:
            return False  # it cannot be used at all, which is told elsewhere

    def _read(self, work: Any, modeler: str, base: str | None) -> None:
        session = self._session
        history = session.history

        def done(found: Picture | Underlay) -> None:
            if session.history is not history:
                return
            if isinstance(found, Underlay):
                session.edit(edit.add_underlay, found)
            else:
                self._hand_over(found, modeler, base)

        self._channel.submit(Request(work, done, session.complain))

    def _hand_over(self, picture: Picture, modeler: str, base: str | None) -> None:
        """Give a picture to a model, in its turn among the gestures."""
        session = self._session
        bench, context, history = session.workbench, session.context(), session.history

        def work(job: Job) -> tuple[Model | None, Model] | None:
            if base is None:
                return None, bench.sources.from_picture(modeler, picture, {}, context)
            known = next((model for model in session.document if model.id == base), None)
            return (
                None
                if known is None
                else (known, bench.sources.with_picture(known, picture, context))
            )

        def done(answer: tuple[Model | None, Model] | None) -> None:
            if answer is None or session.history is not history:
                return
            before, model = answer
            if before is not None and all(before is not known for known in session.document):
                self._hand_over(picture, modeler, base)  # the document moved on meanwhile
                return
            session.take_drawn(tr("Session", "Add sketch"), model, is_new=before is None)
            self.taken.emit(model.id)
            session.tell(
                tr(
                    "Session",
                    "Sketch added. With Shift, a dropped picture lies under the sheet instead.",
                )
            )

        session.inking.queue(Request(work, done, session.complain))


def pixels_of(image: QImage) -> NDArray[np.uint8]:
    """The pixels of a Qt picture, (h, w, 4) RGBA, straight alpha.

    Raises
    ------
    UserError
        If it has none.
    """
    if image.isNull():
        raise UserError(tr("Session", "There is no picture in it. Copy one first."))
    plain = image.convertToFormat(QImage.Format.Format_RGBA8888)
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(plain.height(), -1)
    return rows[:, : 4 * plain.width()].reshape(plain.height(), plain.width(), 4).copy()


def laid_on_sheet(pixels: NDArray[np.uint8], name: str) -> Underlay:
    """A picture in the plane y = 0, standing on the ground, centred."""
    height, width = pixels.shape[:2]
    tall = UNDERLAY_WIDTH * height / width
    return Underlay(
        new_id(),
        name,
        pixels,
        corner=(-UNDERLAY_WIDTH / 2, 0.0, tall),
        across=(UNDERLAY_WIDTH, 0.0, 0.0),
        down=(0.0, 0.0, -tall),
    )
