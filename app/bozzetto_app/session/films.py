"""Films of what moves, and turntables, made in a worker; the document stays as it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject

from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request
from bozzetto_app.workers.time_limit import in_time

if TYPE_CHECKING:
    from bozzetto.document.model import Model
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
"""Height of the pictures of a film, px: larger GIFs are slow to open everywhere."""


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

    @property
    def recorded(self) -> float:
        """How long the motion is that was recorded in the document, s; 0 where there is none."""
        from bozzetto.workbench.films import recorded_times, recordings

        known = recordings(self._workbench, self._drawing.document, self._times_of)
        return recorded_times(known)[-1] if known else 0.0

    def _times_of(self, model: Model) -> tuple[float, ...]:
        """Return when an object recorded how it moved; none, and a word, if its plugin fails."""
        bench = self._workbench
        guard = bench.registry.guard
        try:
            return in_time(guard, model.modeler, "recorded", lambda: bench.recorded(model))
        except (UserError, PluginFault) as problem:
            self._notices.complain(problem)
            return ()

    def make(self, path: Path, seconds: float | None) -> None:
        """Write a film of the next seconds, or of what was recorded, with the view as it is now.

        Parameters
        ----------
        path : Path
            Its ending, .glb, .usdz, .gif or .mp4, says what is written.
        seconds : float, optional
            How long it is; by default it shows what was recorded.
        """
        bench, document = self._workbench, self._drawing.document
        camera = self._view.camera
        width, height = camera.viewport
        scale = min(1.0, TALLEST / height)
        size = (max(2, round(width * scale)), max(2, round(height * scale)))
        seen = camera.with_viewport(*map(float, size))

        def work(job: Job) -> None:
            from bozzetto.atomic_files import write_bytes
            from bozzetto.workbench import films

            ending = path.suffix.lower()
            is_animation = ending in films.ANIMATIONS
            if seconds is None:
                known = films.recordings(bench, document)
                times = films.recorded_times(known, None if is_animation else RATE)
                rows = films.replayed(bench, document, known, times, job)
            else:
                times = films.frame_times(seconds, RATE)
                rows = films.frames(bench, document, seconds, RATE, job)
            if is_animation:
                data = films.animation_of(bench, rows, times, ending)
            else:
                data = films.picture_film_of(
                    bench,
                    rows,
                    films.pace_of(times, RATE),
                    size,
                    lambda scene, document: seen,
                    ending,
                )
            write_bytes(path, data)

        def done(_: None) -> None:
            self._notices.tell(tr("Films", "Made the film “{name}”.", name=path.name))

        self.channel.submit(Request(work, done, self._notices.complain))

    def turn(self, path: Path, seconds: float, from_sketch: bool = False) -> None:
        """Write a turntable of all that is visible.

        Parameters
        ----------
        path : Path
            Its ending says what is written: .gif, .mp4, or a row of .png.
        seconds : float
            How long one turn takes.
        from_sketch : bool
            Whether it begins with the sketch, in the view as it is now if something of it is there.
        """
        bench, document, camera = self._workbench, self._drawing.document, self._view.camera

        def work(job: Job) -> tuple[Path, ...]:
            from bozzetto.workbench.turntables import write_turntable

            count = max(2, round(seconds * TURN_RATE))
            return write_turntable(
                bench,
                document,
                path,
                count,
                seconds,
                job,
                replaces=False,
                from_sketch=from_sketch,
                camera=camera,
                size=TURN_SIZE,
            )

        def done(paths: tuple[Path, ...]) -> None:
            self._notices.tell(tr("Films", "Made the turntable “{name}”.", name=paths[0].name))

        self.channel.submit(Request(work, done, self._notices.complain))
