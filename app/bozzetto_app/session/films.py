"""Films of what moves, and turntables, made in a worker; the document stays as it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject

from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.view_state import ViewState

__all__ = ["LONGEST_FILM", "Films"]

RATE: Final = 25.0
"""Frames a second."""

LONGEST_FILM: Final = 60.0
"""Seconds."""

TURN_RATE: Final = 12.0
"""Pictures a second of a turntable."""

TURN_SIZE: Final = (640, 480)
"""Of its pictures, px."""

TALLEST: Final = 480
"""Height of a GIF, px: larger ones are slow to open everywhere."""


class Films(QObject):
    """Lets a copy of the document go, and writes what it does."""

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        view: ViewState,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.channel = Channel("film", keep_all=True, parent=self)
        self._workbench, self._drawing = workbench, drawing
        self._view, self._notices = view, notices

    def make(self, path: Path, seconds: float) -> None:
        """Write a film of the next seconds, with the view as it is now.

        Parameters
        ----------
        path : Path
            Its ending, .glb, .usdz or .gif, says what is written.
        seconds : float
            How long it is.
        """
        bench, document = self._workbench, self._drawing.document
        camera = self._view.camera
        width, height = camera.viewport
        scale = min(1.0, TALLEST / height)
        size = (max(2, round(width * scale)), max(2, round(height * scale)))
        seen = camera.with_viewport(*map(float, size))

        def work(job: Job) -> None:
            from bozzetto.atomic_files import write_bytes
            from bozzetto.workbench.films import animation_of, frames, gif_of

            films = frames(bench, document, seconds, RATE, job)
            ending = path.suffix.lower()
            if ending == ".gif":
                data = gif_of(bench, films, RATE, size, lambda scene, document: seen)
            else:
                data = animation_of(bench, films, RATE, ending)
            write_bytes(path, data)

        def done(_: None) -> None:
            self._notices.tell(tr("Films", "Made the film “{name}”.", name=path.name))

        self.channel.submit(Request(work, done, self._notices.complain))

    def turn(self, path: Path, seconds: float) -> None:
        """Write a turntable of all that is visible.

        Parameters
        ----------
        path : Path
            Its ending says what is written: .gif, .mp4, or a row of .png.
        seconds : float
            How long one turn takes.
        """
        bench, document = self._workbench, self._drawing.document

        def work(job: Job) -> tuple[Path, ...]:
            from bozzetto.workbench.turntables import write_turntable

            count = max(2, round(seconds * TURN_RATE))
            return write_turntable(
                bench, document, path, count, seconds, job, replaces=False, size=TURN_SIZE
            )

        def done(paths: tuple[Path, ...]) -> None:
            self._notices.tell(tr("Films", "Made the turntable “{name}”.", name=paths[0].name))

        self.channel.submit(Request(work, done, self._notices.complain))
