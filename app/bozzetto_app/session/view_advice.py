"""Advising: what the active modeler says of the view, asked while the view turns.

One question at a time, in a worker, ten times a second at most; what was overtaken is not shown.
While a value is dragged only a view that is pinned is asked about, if answers come quickly.
"""

from __future__ import annotations

from collections import deque
from time import perf_counter
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.document.model import Model
from bozzetto.errors import UserError
from bozzetto.plugin.context import Context
from bozzetto.plugin.job import Job
from bozzetto.plugin.view_advice import AdvisesView, ViewAdvice
from bozzetto.scene.display_list import Scene
from bozzetto.view.camera import Camera
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["Advising"]

INTERVAL = 100
"""Time between two questions, milliseconds."""

QUICK = 0.1
"""How long an answer may take for the next to be asked for in a drag, seconds."""

MOST_PINNED = 32
"""Earlier states of a model that are known as seen: a hand that drags a mark and lets it go, or
takes a few steps back, passes through no more before the view has gone along."""

ADVICE_LIMIT = 10.0
"""Seconds a modeler may think about a view before it counts as hung."""


Question = tuple[str, Model | None, Camera] | None
"""Modeler, model (None for one that is still to be drawn) and view; None for nothing to ask."""


class Advising(QObject):
    """What there is to say of the view.

    Attributes
    ----------
    advice : ViewAdvice or None
        In the world; None where the modeler gives none.
    about : Model or None
        The model that it is about; None for one that is still to be drawn.

    Signals
    -------
    changed
        It is another one.
    """

    changed = Signal()

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.advice: ViewAdvice | None = None
        self.about: Model | None = None
        self._seen = session.camera
        self._took = 0.0
        self._asked: Question = None
        self._silent: set[str] = set()
        self._empty: dict[str, Model] = {}
        self._pinned: deque[Model] = deque(maxlen=MOST_PINNED)
        self._history = session.history
        self._channel = Channel("advice", time_limit=ADVICE_LIMIT, parent=self)
        self._pace = QTimer(self, singleShot=True, interval=INTERVAL)
        self._pace.timeout.connect(self._ask)
        for signal in (session.camera_changed, session.selection_changed, session.modeler_changed):
            signal.connect(self.look)
        session.document_changed.connect(self._look_at_change)
        session.scene_changed.connect(self._look_at_frame)
        session.rested.connect(self.look)
        session.tool_changed.connect(self._other_tool)

    @property
    def busy(self) -> bool:
        """Whether the newest view still waits for its answer."""
        late = self._pace.isActive() and not _same(self._question(), self._asked)
        return self._channel.busy or late

    @property
    def scene(self) -> Scene:
        """What the advice shows on the sheet."""
        layers = () if self.advice is None else self.advice.scene.layers
        return Scene(tuple(filter(self._session.is_seen, layers)))

    def holds_eye(self, camera: Camera) -> bool:
        """Whether a view stands where a picture was drawn from; see `ViewAdvice.pinned`.

        It does so as long as the eye is where the advice was given, before the next comes.
        """
        pinned = self.advice is not None and self.advice.pinned
        return pinned and camera.kind == self._seen.kind and camera.eye == self._seen.eye

    def seen(self, model: Model | None) -> tuple[Model, ...]:
        """A model as it was a moment ago, newest first, while the view was pinned to it."""
        if model is None:
            return ()
        return tuple(known for known in self._pinned if known.id == model.id)

    def seen_states(self, model: Model | None) -> tuple[Any, ...]:
        """Their states; see `Context.seen`."""
        return tuple(known.state for known in self.seen(model))

    def look(self) -> None:
        """See whether there is a new view, model or modeler; ask when it is time."""
        if not self._pace.isActive():
            self._ask()

    def look_later(self) -> None:
        """The same in a moment: the shape that a stroke has just made comes first."""
        if not self._pace.isActive():
            self._pace.start()

    def _look_at_change(self) -> None:
        """A picture may have another camera now: its view should go along with it at once."""
        if self._history is not self._session.history:
            # Models of a closed document would be held with all their pictures.
            self._history = self._session.history
            self._pinned.clear()
        if not self._session.is_dragging:
            self._look_soon()

    def _look_at_frame(self) -> None:
        """While a value is dragged, a view that is pinned goes along with what is shown of it.

        Any other has time until the drag rests, and so has one that takes long: the shape
        comes first.
        """
        pinned = self.advice is not None and self.advice.pinned
        if self._session.is_dragging and pinned and self._took <= QUICK:
            self.look()

    def _look_soon(self) -> None:
        if self.advice is not None and self.advice.pinned:
            self.look()
        else:
            self.look_later()

    def _other_tool(self) -> None:
        if self.advice is not None and any(layer.tool for layer in self.advice.scene.layers):
            self._session.live_changed.emit()

    def is_about(self, camera: Camera) -> bool:
        """Whether the newest advice was given on a view."""
        return self.advice is not None and self._seen == camera

    def _question(self) -> Question:
        session = self._session
        modeler = session.active_modeler
        # Without tools nothing can be drawn, or the plugin is still being imported.
        if modeler in self._silent or not session.tools:
            return None
        model = session.inking.target(modeler)
        if model is not None and session.is_dragging:
            # What is shown has been solved; the newest value is not worth another solve.
            model = session.showing.shown(model.id) or model
        return modeler, model, session.camera

    def _ask(self) -> None:
        question = self._question()
        if _same(question, self._asked):
            return
        if question is None:
            self._asked = None
            self._channel.cancel()
            self._take(None)
            return
        self._pace.start()
        if self._channel.busy:
            return
        self._asked = question
        modeler, model, camera = question

        seen = self.seen(model)
        begun = perf_counter()

        def work(job: Job) -> ViewAdvice | None:
            return self._advice_on(modeler, model, camera, seen)

        def done(advice: ViewAdvice | None) -> None:
            self._took = perf_counter() - begun
            if advice is None:
                self._silent.add(modeler)
            if self._session.active_modeler == modeler:
                self.about, self._seen = model, camera
                self._remember(model, advice)
                self._take(advice)

        def failed(problem: BaseException) -> None:
            self._take(None)
            if not isinstance(problem, UserError):
                self._silent.add(modeler)
                self._session.complain(problem)

        self._channel.submit(Request(work, done, failed, "preview"))

    def _remember(self, model: Model | None, advice: ViewAdvice | None) -> None:
        """Keep in mind to which state of a model the view is pinned."""
        pinned = advice is not None and advice.pinned and not advice.follow
        if pinned and model is not None and (not self._pinned or self._pinned[0] is not model):
            self._pinned.appendleft(model)

    def _advice_on(
        self, modeler: str, model: Model | None, camera: Camera, seen: tuple[Model, ...]
    ) -> ViewAdvice | None:
        """In the worker: the advice; None where the modeler never gives any."""
        bench = self._session.workbench
        if not isinstance(self._session.registry.modeler(modeler), AdvisesView):
            return None
        if model is None:
            if modeler not in self._empty:
                self._empty[modeler] = bench.create(modeler, Context(camera=camera))
            model = self._empty[modeler]
        return bench.view_advice(model, camera, seen)

    def _take(self, advice: ViewAdvice | None) -> None:
        if advice is not None or self.advice is not None:
            shown = bool(self.scene.layers)
            self.advice = advice
            self.changed.emit()
            if shown or self.scene.layers:
                self._session.live_changed.emit()


def _same(one: Question, other: Question) -> bool:
    """Whether two questions are about the very same things; states are not compared."""
    if one is None or other is None:
        return one is other
    return one[0] == other[0] and one[1] is other[1] and one[2] == other[2]
