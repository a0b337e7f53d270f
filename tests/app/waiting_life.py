"""One session that a person lives in, and what was lifted there: the law of waiting ink."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

from PySide6.QtWidgets import QApplication

from bozzetto.atomic_files import Over
from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto.plugin.guard import guard
from bozzetto.plugin.host.registry import Registry
from bozzetto_app.session.autosave import Keeper
from bozzetto_app.session.session import Session
from tests.app.tablet import circle, stroke_of
from tests.app.two_boxes import MODELERS, TOOLS, two_boxes
from tests.dead_process import left_behind
from tests.document_kit import documents_of

__all__ = ["ACTS", "MOODS", "Life", "life_in", "random_act"]

MOODS = ("well", "refuse", "raise", "garbage")
ACTS = tuple(
    "enter escape back clear erase undo redo jump modeler tool new delete slide "
    "undo_at_once save_and_open crash_and_recover stop hurry".split()
)
SETTLED = 30.0
"""Seconds that work may take."""


class Life:
    """One session, what was lifted in it, and what a person can do there."""

    def __init__(self, folder, modelers, packages):
        self.folder, self.modelers = folder, modelers
        self.registry = Registry(extra=packages)
        self.session = Session(self.registry)
        self.session.view.camera = self.session.view.camera.with_viewport(987.0, 727.0)
        self.drawn = 0
        self.keeper = Keeper(self.session, folder / "recovery")
        self.session.toolbox.take_modeler(MODELERS[0])
        self.settle()

    def settle(self):
        until = time.monotonic() + SETTLED
        for _ in range(2):
            while self.session.busy or self.keeper.busy:
                assert time.monotonic() < until, "the session does not come to rest"
                QApplication.processEvents()
                time.sleep(0.0005)
            QApplication.processEvents()

    def begin(self):
        for modeler in self.modelers:
            modeler.mood = "well"
        self.session.files.new()
        self.session.toolbox.take_modeler(MODELERS[0])
        self.settle()
        self.lifted = set()

    def snapshots(self):
        return documents_of(self.session.drawing.history)

    def check(self):
        reachable = set().union(*map(strokes_in, self.snapshots()))
        assert self.lifted <= reachable
        assert self.session.drawing.pending == tuple(
            w.stroke for w in self.session.drawing.document.waiting
        )

    # -- what a person does --

    def do(self, what, *details):
        getattr(self, what)(*details)
        self.check()

    def mood(self, mood):
        for modeler in self.modelers:
            modeler.mood = mood

    def draw(self, kind, patient):
        number, self.drawn = self.drawn, self.drawn + 1
        share = 1.0 if kind == "closed" else 0.6
        path = circle(300.0 + 40 * (number % 10), 360.0, 40.0 + 0.01 * number, 24, share)
        stroke = stroke_of(path, self.session.view.camera)
        self.lifted.add(stroke.digest)
        self.session.gestures.stroke_lifted(stroke)
        if patient:
            self.settle()

    def hurry(self, count):
        for _ in range(count):
            self.draw("closed", False)

    def enter(self, _):
        self.session.gestures.commit()
        self.settle()

    def escape(self, _):
        self.session.escape()
        self.settle()

    def stop(self, _):
        self.draw("closed", False)
        self.session.cancel_work()
        self.settle()

    def back(self, _):
        self.session.gestures.drop_last()

    def clear(self, _):
        self.session.gestures.clear()

    def erase(self, place):
        x = 300.0 + 80 * place
        rub = stroke_of([(x, 250.0), (x, 470.0)], self.session.view.camera, tool="eraser")
        for modeler in self.modelers:
            modeler.mood = "refuse"  # an eraser that meets no ink would be a box to these
        self.session.gestures.stroke_lifted(rub)
        self.settle()

    def undo(self, _):
        self.session.drawing.undo()
        self.settle()

    def undo_at_once(self, _):
        self.draw("closed", False)
        self.session.drawing.undo()
        self.check()
        self.settle()

    def redo(self, _):
        self.session.drawing.redo()
        self.settle()

    def jump(self, place):
        self.session.drawing.go_to(place)
        self.settle()

    def modeler(self, place):
        self.session.toolbox.take_modeler(MODELERS[place % 2])
        if place > 2:
            self.settle()

    def tool(self, place):
        self.session.toolbox.take_tool(TOOLS[place % 2])

    def new(self, _):
        self.session.selection.select(None)

    def delete(self, place):
        models = self.session.drawing.document.models
        if len(models):
            self.session.objects.delete(models[place % len(models)].id)

    def slide(self, place):
        self.session.objects.set_parameter("size", 10.0 + place, dragging=place % 2 == 0)

    def save_and_open(self, _):
        path = self.folder / "drawing.bozz"
        before = self.session.drawing.document
        self.session.files.save(path, over=Over.ANYTHING)
        self.settle()
        if self.session.drawing.document is before:
            assert not self.session.drawing.is_modified
        self.session.files.open(path)
        self.settle()
        self.comes_back(before, self.session.drawing.document)

    def crash_and_recover(self, _):
        self.settle()
        before = self.session.drawing.document
        if not self.session.drawing.is_modified:
            return
        with left_behind(self.folder / "recovery") as left:
            self.session.files.given_up.emit()  # what the crash left is all that there is
            self.session.files.new()
            self.settle()
        # Drawings that left the sheet without an answer lie there as well.
        sessions = RecoveryStore(self.folder / "recovery").crashed_sessions()
        (crashed,) = (one for one in sessions if [one.id] == left)
        self.keeper.recover(crashed)
        self.settle()
        self.comes_back(before, self.session.drawing.document)

    def comes_back(self, before, after):
        """Another document is here, with all that was on the sheet; its history begins."""
        assert strokes_in(after) == strokes_in(before)
        assert [told(one) for one in after.waiting] == [told(one) for one in before.waiting]
        self.lifted = strokes_in(before)

    def live(self, acts):
        """Do one thing after the other on an empty sheet, then walk back to its beginning."""
        self.begin()
        for act in acts:
            self.do(*act)
        self.settle()
        self.check()
        seen, history = set(), self.session.drawing.history
        self.session.drawing.go_to(len(history.entries) - 1)
        while True:
            seen |= strokes_in(history.document)
            if not history.position:
                break
            history.undo()
        assert self.lifted <= seen
        self.session.drawing.go_to(0)
        self.settle()


def told(one):
    return one.stroke.digest, one.modeler, one.tool, one.status, one.reason, one.places


def strokes_in(document):
    waiting = {one.stroke.digest for one in document.waiting}
    return waiting.union(*({s.digest for s in model.state.strokes} for model in document))


@contextmanager
def life_in(folder: Path) -> Iterator[Life]:
    """A life that keeps its files in a folder."""
    # Faults are counted; a plugin that is off would refuse all that follows.
    with (
        two_boxes(folder) as (first, second, packages),
        mock.patch.object(guard, "MOST_FAULTS", math.inf),
    ):
        life = Life(folder, (first, second), packages)
        yield life
        life.settle()
        life.session.cancel_all()
        life.session.files.close()
        life.keeper.close()
        life.session.deleteLater()


def random_act(rng: random.Random) -> tuple:
    """Something that a person does, drawing more often than anything else."""
    choice = rng.random()
    if choice < 0.15:
        return "mood", rng.choice(MOODS)
    if choice < 0.5:
        return "draw", rng.choice(("closed", "open")), rng.random() < 0.5
    return rng.choice(ACTS), rng.randrange(6)
