"""The active modeler's advice on the view, asked for while the view turns.

One question at a time goes to a worker, ten in a second at most; replaced answers are not shown.
While a value is dragged only a pinned view is asked about: with each preview where the modeler
advises on results, else only if answers come quickly.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.document.model import Model
from bozzetto.errors import UserError
from bozzetto.scene.display_list import Scene
from bozzetto.view.camera import Camera
from bozzetto_app.workers.channel import LATE_AFTER, Channel, Request

if TYPE_CHECKING:
    from bozzetto.plugin.job import Job
    from bozzetto.plugin.view_advice import ViewAdvice
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.scene_model import SceneModel
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.solver import Solver
    from bozzetto_app.session.toolbox import Toolbox
    from bozzetto_app.session.view_state import ViewState

__all__ = ["ViewAdviser"]

INTERVAL = 100
"""Time between two questions, ms."""

QUICK = 0.1
"""How long an answer may take for the next to be asked for in a drag, seconds."""

MOST_SEEN = 32
"""Earlier states of a model that are remembered as seen: a hand that drags a mark and lets it
go, or takes a few steps back, passes through no more before the view has followed."""

SAME_WAY = 1e-9
"""Difference of the axes of two views that look the same way."""


Question = tuple[str, Model | None, Camera, Any] | None
"""Modeler, model (None for one that is still to be drawn), view, and what the advice rests on: the
result that the modeler advises on (None for one that does not), or of a model that is still to be
drawn all that is visible; None for nothing to ask."""


class ViewAdviser(QObject):
    """Keeps the advice of the active modeler up to date.

    Attributes
    ----------
    advice : ViewAdvice or None
        In world coordinates; None if the modeler gives none.
    about : Model or None
        The model that the advice is about; None for one that is still to be drawn.

    Signals
    -------
    changed
        The advice differs.
    """

    changed = Signal()

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        view: ViewState,
        toolbox: Toolbox,
        solver: Solver,
        scene: SceneModel,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.advice: ViewAdvice | None = None
        self.about: Model | None = None
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._view, self._toolbox, self._solver = view, toolbox, solver
        self._scene, self._notices = scene, notices
        self._seen = view.camera
        self._took = 0.0
        self._asked: Question = None
        self._silent: set[str] = set()
        self._empty: tuple[str, Scene, Model] | None = None
        self._pinned: deque[Model] = deque(maxlen=MOST_SEEN)
        self._as_drawn: deque[Model] = deque(maxlen=MOST_SEEN)
        self._channel = Channel("advice", time_limit=LATE_AFTER, parent=self)
        self._pace = QTimer(self, singleShot=True, interval=INTERVAL)
        self._pace.timeout.connect(self._ask)
        for signal in (view.camera_changed, selection.changed, toolbox.modeler_changed):
            signal.connect(self.look)
        drawing.closing.connect(self._forget)
        drawing.changed.connect(self._look_at_change)
        scene.changed.connect(self._look_at_frame)
        solver.busy_changed.connect(self._look_at_rest)

    @property
    def busy(self) -> bool:
        """Whether the newest view still waits for its answer."""
        late = self._pace.isActive() and not _same(self._question(), self._asked)
        return self._channel.busy or late

    @property
    def may_follow(self) -> bool:
        """Whether a pinned view may still go along with the newest result, which waits for it."""
        goes_along = self._is_pinned or self._shows_as_drawn
        if not goes_along or not self._advises_on_results:
            return False
        # In a drag only a question that was asked is worth waiting for: the next frame is near.
        return self._channel.busy if self._drawing.is_dragging else self.busy

    def holds_eye(self, camera: Camera) -> bool:
        """Return whether a view stands where a picture was drawn from; see `ViewAdvice.pinned`.

        It does so as long as the eye is where the advice was given, before the next comes.
        """
        return self._is_pinned and camera.kind == self._seen.kind and camera.eye == self._seen.eye

    def seen(self, model: Model | None) -> tuple[Model, ...]:
        """Return the recent states of a model that the view went along with, newest first.

        It was pinned to them, or has shown them as they were drawn and was not turned since.
        """
        if model is None:
            return ()
        known = (*self._as_drawn, *self._pinned)
        return tuple(each for each in known if each.id == model.id)

    def seen_states(self, model: Model | None) -> tuple[Any, ...]:
        """Return the same as the states of the modeler; see `Context.seen`."""
        return tuple(known.state for known in self.seen(model))

    def look(self) -> None:
        """Ask about a new view, model or modeler when it is time."""
        if not self._pace.isActive():
            self._ask()

    def look_later(self) -> None:
        """Ask in a moment: the shape that a stroke has just made comes first."""
        if not self._pace.isActive():
            self._pace.start()

    def is_about(self, camera: Camera) -> bool:
        """Return whether the newest advice was given on a view."""
        return self.advice is not None and self._seen == camera

    @property
    def _is_pinned(self) -> bool:
        return self.advice is not None and self.advice.pinned

    @property
    def _shows_as_drawn(self) -> bool:
        return self.advice is not None and self.advice.as_drawn

    def _forget(self) -> None:
        """Let go of a closed document: models hold all their pictures, a scene all its meshes."""
        self._channel.cancel()
        self._asked = None
        self._pinned.clear()
        self._as_drawn.clear()
        self._empty = None

    def _look_at_change(self) -> None:
        """Follow a picture at once, whose camera may differ; anything else can wait."""
        if self._is_pinned or self._shows_as_drawn:
            self.look()
        else:
            self.look_later()

    def _look_at_frame(self) -> None:
        """Ask about another result; let a pinned view follow while a value is dragged.

        Any other has time until the drag pauses, and so has one for which the modeler would have
        to solve: the shape comes first.
        """
        dragging = self._drawing.is_dragging
        if self._asked is not None and self._asked[1] is None and not dragging:
            self.look_later()
        if self._advises_on_results:
            if self._is_pinned or not dragging:
                self._ask()
        elif dragging and self._is_pinned and self._took <= QUICK:
            self.look()

    def _look_at_rest(self, busy: bool) -> None:
        """Ask where there is no result to wait for: a model may have no solution, or be hidden."""
        if not busy:
            self.look_later()

    @property
    def _advises_on_results(self) -> bool:
        """Whether the advice is about what is shown, which may be a preview."""
        # Without tools the plugin may still have to be imported.
        modeler = self._toolbox.modeler if self._toolbox.tools else ""
        return bool(modeler) and self._workbench.advises_on_results(modeler)

    def _question(self) -> Question:
        modeler = self._toolbox.modeler
        # Without tools nothing can be drawn, or the plugin is still being imported.
        if modeler in self._silent or not self._toolbox.tools:
            return None
        model = self._selection.target(modeler)
        if model is not None and self._drawing.is_dragging:
            # What is shown has been solved; the newest value is not worth another solve.
            model = self._solver.shown(model.id) or model
        if model is None:
            return modeler, None, self._view.camera, self._scene.visible
        result = self._result_of(model) if self._advises_on_results else None
        return modeler, model, self._view.camera, result

    def _result_of(self, model: Model) -> Any | None:
        """Return the result that is seen: a view that went along with the next would be ahead."""
        shown = self._solver.shown_result(model)
        if shown is not None or self._solver.busy:
            return shown
        return self._workbench.best_result(model)

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
            if self._is_overtaken(question):
                self._channel.cancel()
                self._asked = None
            return
        modeler, model, camera, rests_on = question
        if not _looks_the_same_way(camera, self._seen):
            self._as_drawn.clear()  # the view was turned: what it shows is not as it was drawn
        waits = self._advises_on_results and rests_on is None
        if waits and self._solver.busy:
            return  # it is being solved: to solve it here as well would take longer
        self._asked = question
        # The model itself as well: what its preview showed has another camera in the final result.
        seen = (*(() if model is None else (model,)), *self.seen(model))
        begun = perf_counter()

        def work(job: Job) -> ViewAdvice | None:
            model_now = self._begun(modeler, camera, rests_on) if model is None else model
            result = None if model is None else rests_on
            return self._workbench.view_advice(model_now, camera, seen, job, result)

        def done(advice: ViewAdvice | None) -> None:
            self._took = perf_counter() - begun
            if advice is None and not self._workbench.advises(modeler):
                self._silent.add(modeler)
            if self._toolbox.modeler == modeler:
                self.about, self._seen = model, camera
                self._remember(model, advice)
                self._take(self._allowed(model, advice))

        def failed(problem: BaseException) -> None:
            self._take(None)
            if not isinstance(problem, UserError):
                self._silent.add(modeler)
                self._notices.complain(problem)

        self._channel.submit(Request(work, done, failed, "preview"))

    def _is_overtaken(self, question: Question) -> bool:
        """Return whether what is being asked is about a model that is another one by now.

        While a value is dragged it is another one at each turn, and no answer would ever come.
        """
        if question is None or self._asked is None or self._drawing.is_dragging:
            return False
        asked, now = self._asked[1], question[1]
        return self._asked[0] != question[0] or (
            asked is not now and (asked is None or now is None or asked.state is not now.state)
        )

    def _remember(self, model: Model | None, advice: ViewAdvice | None) -> None:
        """Remember the state of a model that the view goes along with."""
        if model is None or advice is None:
            return
        for goes_along, seen in (
            (advice.pinned, self._pinned),
            (advice.as_drawn and not advice.follow, self._as_drawn),
        ):
            if goes_along and (not seen or seen[0] is not model):
                seen.appendleft(model)

    def _allowed(self, model: Model | None, advice: ViewAdvice | None) -> ViewAdvice | None:
        """Return the advice; no view follows one model alone where it shows others as well."""
        if advice is None or advice.pinned or not (advice.follow and advice.as_drawn):
            return advice
        alone = self._workbench.is_alone(self._drawing.document, model)
        return advice if alone else replace(advice, better=None, follow=False)

    def _begun(self, modeler: str, camera: Camera, visible: Scene) -> Model:
        """Return the model that a stroke would begin beside what is visible, in the worker."""
        known = self._empty
        if known is not None and known[0] == modeler and known[1] is visible:
            return known[2]
        from bozzetto.plugin.context import Context

        model = self._workbench.create(modeler, Context(camera=camera, scene=visible))
        self._empty = modeler, visible, model
        return model

    def _take(self, advice: ViewAdvice | None) -> None:
        if advice is not None or self.advice is not None:
            self.advice = advice
            alone = self.about if self._is_pinned else None
            self._scene.show_alone("" if alone is None else alone.id)
            self._scene.show_advice(Scene() if advice is None else advice.scene)
            self.changed.emit()


def _looks_the_same_way(one: Camera, other: Camera) -> bool:
    """Return whether a view was moved at most since, and not turned."""
    return bool(abs(one.axes - other.axes).max() < SAME_WAY)


def _same(one: Question, other: Question) -> bool:
    """Return whether two questions are about the very same objects; states are not compared."""
    if one is None or other is None:
        return one is other
    same_objects = one[1] is other[1] and one[3] is other[3]
    return same_objects and one[0] == other[0] and one[2] == other[2]
