"""The scene in the colours of its thickness, measured in a worker."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.plugin.job import Job
    from bozzetto.scene.display_list import Scene
    from bozzetto.scene.palette import Palette
    from bozzetto.scene.thickness_view import ThicknessView

__all__ = ["ThicknessChannel"]


def _raise(problem: BaseException) -> None:
    raise problem


class ThicknessChannel(QObject):
    """Measures the newest scene that was asked for.

    Attributes
    ----------
    view : ThicknessView or None
        What was measured last; None if nothing is asked for, or it is under way.

    Signals
    -------
    changed
        `view` differs.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.view: ThicknessView | None = None
        self._asked: tuple[Scene, Palette] | None = None
        self._channel = Channel("thickness", parent=self)

    @property
    def busy(self) -> bool:
        """Whether a scene is being measured."""
        return self._channel.busy

    def shown(self, scene: Scene, palette: Palette, *, moving: bool) -> Scene:
        """Return a scene in its colours, or as it is while these are not known.

        A scene that moves is measured when it comes to rest.
        """
        if self._asked != (scene, palette):
            self.forget()
            if not moving:
                self._asked = scene, palette
                self._channel.submit(
                    Request(self._measure, self._take, _raise, inputs=self._wanted)
                )
        return scene if self.view is None else self.view.scene

    def forget(self) -> None:
        """Let go of what was measured; nothing is asked for."""
        self._channel.cancel()
        self._asked = None
        if self.view is not None:
            self.view = None
            self.changed.emit()

    def _wanted(self) -> tuple[Scene, Palette] | None:
        return self._asked

    def _measure(self, job: Job, wanted: tuple[Scene, Palette] | None) -> ThicknessView | None:
        if wanted is None:
            return None
        from bozzetto.scene.thickness_view import thickness_view

        return thickness_view(*wanted, lambda: job.checkpoint(0.0, ""))

    def _take(self, view: ThicknessView | None) -> None:
        self.view = view
        self.changed.emit()
