"""The order of work on models, and which answers may still be shown.

Every model that the window asks for is a small state machine of three numbers:

* **asked**: the revision asked for last. Each other model object is a new revision.
* **made**: the newest revision, and how far its stages got, that the worker has answered.
* **shown**: the same of what is on the sheet.

Revisions count upwards and are never used twice, so that what was taken back counts as
new. A revision goes through the stages ``INK < PREVIEW < FINAL < REPORT``. The rules:

1. The worker takes the preview of the newest revision of a model, models without a picture
   and those that have waited longest first; then finals; then the figures of the selected
   model. It never begins work on a revision that is not the newest.
2. A preview that was begun may end, also if its revision has been replaced meanwhile; it
   only gives way to a model that has no picture at all. A final, or a report, of a replaced
   revision is abandoned at once, and so is any while some model waits for its preview.
3. An answer is shown if its model is still asked for and nothing newer of it, or of the
   same revision and further, was shown.
4. While a drag goes on no final is begun: it would be abandoned at the next value.
5. While a drag goes on in a window, one preview of a model is solved while the one before it is
   painted, and no third is begun: a preview that nobody sees takes the time that painting needs.
   Those of models that follow the dragged one are of the same frame, and need not wait for it.

So what is shown never goes back, what is shown last is the last value, and a drag shows a
frame for each preview that the worker can make. One lock guards the numbers: the window
asks and shows, the worker takes and makes.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterable
from enum import IntEnum
from typing import NamedTuple

import msgspec

from bozzetto.document.links import is_same_recipe
from bozzetto.document.model import Model

__all__ = ["MOST_AHEAD", "Revisions", "Stage", "Task"]

MOST_AHEAD = 2
"""Previews made in a drag and not painted yet, at which no further one is begun: one is being
painted, the other is what will be painted next."""


class Stage(IntEnum):
    """How far the work on a revision is."""

    NOTHING = 0
    INK = 1
    PREVIEW = 2
    FINAL = 3
    REPORT = 4


class Task(NamedTuple):
    """One stage of one revision of a model."""

    model: Model
    revision: int
    stage: Stage

    @property
    def progress(self) -> tuple[int, Stage]:
        """Sort key of progress: a newer revision is further than any stage of an older one."""
        return self.revision, self.stage


class _Course(msgspec.Struct):
    """The three numbers of one model, when it was served last, and previews not yet seen.

    `untaken` are those that the window has not taken yet, `unpainted` those that it has.
    """

    model: Model
    asked: int
    made: tuple[int, Stage] = (0, Stage.NOTHING)
    shown: tuple[int, Stage] = (0, Stage.NOTHING)
    served: int = 0
    untaken: int = 0
    unpainted: int = 0

    @property
    def has_picture(self) -> bool:
        """Whether the worker has answered at all."""
        return self.made[1] is not Stage.NOTHING

    def lacks(self, stage: Stage) -> bool:
        """Whether the newest revision has not come as far as a stage."""
        return self.made < (self.asked, stage)

    @property
    def is_far_ahead(self) -> bool:
        """Whether a preview that was begun now would be seen late, if at all."""
        return self.untaken + self.unpainted >= MOST_AHEAD

    def tell_again(self) -> None:
        """Have the figures reported again: the model was selected again."""
        self.made = min(self.made, (self.asked, Stage.FINAL))
        self.shown = min(self.shown, (self.asked, Stage.FINAL))


class Revisions:
    """The revisions of all models of a document."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._turns = itertools.count(1)
        self._courses: dict[str, _Course] = {}
        self._hopeless: dict[str, Model] = {}
        self._selected = ""
        self._running: Task | None = None
        self._dragging = False
        self._paints = False

    # -- the window --

    def ask(self, models: Iterable[Model], selected: str = "", *, dragging: bool = False) -> bool:
        """Say which models are to be shown now.

        Parameters
        ----------
        models : iterable of Model
            The models to be shown, in their newest state.
        selected : str
            Id of the one whose figures are wanted.
        dragging : bool
            Whether more of the same comes in a moment.

        Returns
        -------
        bool
            Whether the task that runs is to be abandoned; it then counts as not running.
        """
        with self._lock:
            old, self._courses = self._courses, {}
            if selected != self._selected and selected in old:
                old[selected].tell_again()
            self._selected, self._dragging = selected, dragging
            if not dragging:
                self._count_afresh()
            for model in models:
                course = old.get(model.id)
                if course is None:
                    course = _Course(model, next(self._numbers))
                elif course.model is not model:
                    course.model, course.asked = model, next(self._numbers)
                hopeless = self._hopeless.get(model.id)
                if hopeless is not None and is_same_recipe(hopeless, model):
                    course.made = (course.asked, Stage.REPORT)
                self._courses[model.id] = course
            unwanted = self._running is not None and self._is_unwanted(self._running)
            if unwanted:
                self._running = None
            return unwanted

    def let_go(self) -> bool:
        """Say that a drag has ended; whether it was under way."""
        with self._lock:
            was, self._dragging = self._dragging, False
            self._count_afresh()
            return was

    def expect_paint(self, paints: bool) -> None:
        """Say whether a viewport paints what is shown, and calls `painted`."""
        with self._lock:
            self._paints = paints
            if not paints:
                self._count_afresh()

    def painted(self, behind: int = 0) -> bool:
        """Note that a frame was painted; return whether a preview had waited for that.

        Parameters
        ----------
        behind : int
            How many scenes newer than the painted one the viewport was given.
        """
        with self._lock:
            courses = self._courses.values()
            waited = [course for course in courses if course.is_far_ahead]
            for course in courses:
                course.unpainted = min(course.unpainted, behind)
            return any(not course.is_far_ahead for course in waited)

    def stop(self) -> None:
        """Note that what runs was abandoned."""
        with self._lock:
            self._running = None

    def forget(self) -> None:
        """Forget everything but the count: another document comes."""
        with self._lock:
            self._courses.clear()
            self._hopeless.clear()
            self._running = None
            self._dragging = False
            self._count_afresh()

    def show(self, task: Task) -> bool:
        """Whether an answer may be shown; it then counts as shown."""
        with self._lock:
            course = self._courses.get(task.model.id)
            if course is not None and task.stage is Stage.PREVIEW and course.untaken:
                course.untaken -= 1
                course.unpainted += 1
            if course is None or task.progress <= course.shown:
                return False
            if task.stage is Stage.INK and course.shown[1] is not Stage.NOTHING:
                return False
            course.shown = task.progress
            return True

    def is_newest(self, task: Task) -> bool:
        """Whether a task is about the revision asked for last."""
        with self._lock:
            course = self._courses.get(task.model.id)
            return course is not None and course.asked == task.revision

    # -- the worker --

    def next(self) -> Task | None:
        """Return the task to be done now, which then counts as running; None if nothing is left."""
        with self._lock:
            self._running = task = self._most_urgent()
            if task is not None:
                self._courses[task.model.id].served = next(self._turns)
            return task

    def has_picture(self, task: Task) -> bool:
        """Whether anything of the task's model was made before."""
        with self._lock:
            course = self._courses.get(task.model.id)
            return course is not None and course.has_picture

    def made(self, task: Task, stage: Stage | None = None) -> None:
        """Note that a task is done, and how far, where that is further than it asked for."""
        with self._lock:
            if self._running is task:
                self._running = None
            course = self._courses.get(task.model.id)
            if course is not None:
                done = task._replace(stage=task.stage if stage is None else stage)
                course.made = max(course.made, done.progress)
                if done.stage is Stage.PREVIEW and self._paints and self._dragging:
                    course.untaken += 1

    def give_up(self, model: Model) -> None:
        """Do not try this state again."""
        with self._lock:
            self._hopeless[model.id] = model
            if self._running is not None and is_same_recipe(self._running.model, model):
                self._running = None
            course = self._courses.get(model.id)
            if course is not None and is_same_recipe(course.model, model):
                course.made = (course.asked, Stage.REPORT)

    @property
    def next_preview(self) -> str:
        """Id of the model of the next task if that is a preview, else ""."""
        with self._lock:
            task = self._most_urgent()
            return task.model.id if task is not None and task.stage is Stage.PREVIEW else ""

    @property
    def running(self) -> Task | None:
        """The task that was taken last and has not ended."""
        with self._lock:
            return self._running

    # -- the rules; the lock is held --

    def _count_afresh(self) -> None:
        """Wait for no painting of what was made before."""
        for course in self._courses.values():
            course.untaken = course.unpainted = 0

    def _most_urgent(self) -> Task | None:
        courses = self._courses.values()
        waiting = [course for course in courses if course.lacks(Stage.PREVIEW)]
        waiting = [c for c in waiting if not (c.is_far_ahead and c.has_picture)]
        if waiting:
            first = min(waiting, key=lambda c: (c.has_picture, c.served))
            return Task(first.model, first.asked, Stage.PREVIEW)
        if self._dragging:
            return None
        for course in courses:
            if course.lacks(Stage.FINAL):
                return Task(course.model, course.asked, Stage.FINAL)
        chosen = self._courses.get(self._selected)
        if chosen is not None and chosen.lacks(Stage.REPORT):
            return Task(chosen.model, chosen.asked, Stage.REPORT)
        return None

    def _is_unwanted(self, task: Task) -> bool:
        course = self._courses.get(task.model.id)
        if course is None:
            return True
        others = [other for other in self._courses.values() if other is not course]
        if task.stage is Stage.PREVIEW:
            bare = any(not other.has_picture for other in others)
            return course.has_picture and bare
        previews_wait = any(other.lacks(Stage.PREVIEW) for other in others)
        return course.asked != task.revision or previews_wait
