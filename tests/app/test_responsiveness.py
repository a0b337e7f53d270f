"""The window goes on while others work: pauses between turns of its event loop.

The bound is 50 ms. A loaded machine may take a slice of time from anybody, so by default
the 95th percentile is held and single pauses only to a generous bound; the strict test is
marked slow and compares with the same window at rest.
"""

from __future__ import annotations

import gc
import os
import time
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from bozzetto_app.tidying import Tidier
from tests.app.tablet import Stylus, circle, stroke_of
from tests.app.troublemaker import MODELER, box

BOUND = 0.050
"""Longest pause that a person does not notice, s."""

GENEROUS = 0.5
"""Longest pause on a machine that others use as well, s."""


class Pulse:
    """A timer of 5 ms, and the pauses between its beats."""

    def __init__(self):
        self.timer = QTimer(interval=5)
        self.timer.timeout.connect(self.beat)
        self.pauses = []

    def beat(self):
        now = time.perf_counter()
        self.pauses.append(now - self.last)
        self.last = now

    def during(self, busy, least=0.0):
        """The pauses while something holds, and for `least` seconds."""
        self.pauses, self.last = [], time.perf_counter()
        begun = self.last
        self.timer.start()
        while busy() or time.perf_counter() - begun < least:
            QApplication.processEvents()
            time.sleep(0.0005)
        self.timer.stop()
        self.pauses.append(time.perf_counter() - self.last)
        return np.array(self.pauses)


@pytest.fixture
def drawn(make_window, settle):
    """A window with a real silhouette at the finest resolution, everything imported."""
    window = make_window()
    Stylus(window.canvas).draw(circle(radius=190, samples=200, wave=0.25))
    settle(window.session, window.keeper)
    window.session.set_parameter("resolution", 256)
    settle(window.session, window.keeper)
    return window


def solve_again(window, inflation):
    window.session.set_parameter("inflation", inflation)
    return Pulse().during(lambda: window.session.busy)


def test_a_fine_solve_leaves_the_window_free(drawn):
    pauses = np.concatenate([solve_again(drawn, 1.0 + 0.1 * k) for k in (1, 2)])
    assert pauses.sum() > 0.5
    assert np.percentile(pauses, 95) < BOUND
    assert pauses.max() < GENEROUS


def test_numpy_in_a_plugin_leaves_the_window_free(make_window, boxes, settle):
    window = make_window(MODELER, extra=[boxes.package])
    Stylus(window.canvas).draw(circle())
    settle(window.session)

    def solve(state, job):
        rng, until = np.random.default_rng(0), time.perf_counter() + 1.0
        while time.perf_counter() < until:
            table = rng.standard_normal((400, 400))
            np.linalg.svd(table[:200])
            np.sort(table.ravel())[np.argsort(table.ravel())]
            [math * 2 for math in range(20_000)]
        return [box(state.size, 0.0)]

    boxes.misdeeds["solve"] = solve
    window.session.set_parameter("size", 20.0)
    pauses = Pulse().during(lambda: window.session.busy)
    assert np.percentile(pauses, 95) < BOUND
    assert pauses.max() < GENEROUS


def test_saving_and_journalling_much_ink_leaves_the_window_free(
    make_window, boxes, settle, tmp_path
):
    from bozzetto.ink import Strokes

    window = make_window(MODELER, extra=[boxes.package])
    Stylus(window.canvas).draw(circle())
    settle(window.session)
    boxes.misdeeds["solve"] = lambda state, job: []
    model = window.session.selected_model
    camera = window.session.camera
    ink = Strokes(tuple(stroke_of(circle(radius=50 + 0.01 * k), camera) for k in range(3000)))
    many = replace(model, state=replace(model.state, strokes=ink))
    pulse = Pulse()
    window.session.commit("Many", window.session.document.with_model(many))
    window.session.files.save(tmp_path / "many.bozz")
    pauses = pulse.during(lambda: window.session.busy or window.keeper.busy, least=0.3)
    assert (tmp_path / "many.bozz").exists()
    assert np.percentile(pauses, 95) < BOUND
    assert pauses.max() < GENEROUS


def test_drawing_while_a_solve_is_under_way_gets_every_sample(drawn, settle):
    drawn.session.set_parameter("inflation", 1.7)
    path = circle(640, 360, 60, samples=200)
    stylus = Stylus(drawn.canvas)
    longest = 0.0
    stylus.press(path[0])
    for place in path[1:]:
        begun = time.perf_counter()
        stylus.move(place)
        QApplication.processEvents()
        longest = max(longest, time.perf_counter() - begun)
    stylus.lift(path[-1])
    settle(drawn.session, drawn.keeper)
    strokes = drawn.session.document.models[0].state.parts[0].strokes
    assert len(strokes) == 2  # a hole
    assert len(strokes[1]) >= 198
    assert longest < GENEROUS


@pytest.mark.slow
@pytest.mark.skipif("CI" in os.environ, reason="a shared machine's pauses are not the program's")
def test_no_pause_is_longer_than_a_person_notices(drawn, qapp):
    """Median over several solves of the longest pause in each, with garbage tidied as at work."""
    tidier = Tidier()
    tidier.settle()
    rest = [Pulse().during(lambda: False, least=1.0).max() for _ in range(5)]
    work = [solve_again(drawn, 1.0 + 0.05 * k).max() for k in range(1, 12)]
    noise = max(0.0, float(np.median(rest)) - 0.006)
    assert np.median(work) < BOUND + noise, (rest, work)
    tidier.deleteLater()
    gc.unfreeze()
