"""Reports, drawings that are read and advice can be stopped, in every bundled modeler."""

from __future__ import annotations

import os
import signal
import time

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.errors import Cancelled
from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin import Job, ViewAdvice
from bozzetto.plugin.guard.earlier_plugins import with_job
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen
from bozzetto.testing.job_checks import check_stopping, stop_at
from bozzetto.testing.spelling import check_spelling
from bozzetto.testing.subject import Broken
from bozzetto.workbench.workbench import Workbench
from bozzetto_silhouette.modeler import Silhouette


def swallowing(state, result, job):
    for _ in range(3):
        try:
            job.checkpoint(0.5, "half")
        except Cancelled:
            return {}
    return {"size": result}


def keeping_halves():
    """A report that remembers half of itself when it is cancelled."""
    kept = {}

    def report(state, result, job):
        if id(state) not in kept:
            kept[id(state)] = {"half": 1}, state
            job.checkpoint(0.5, "half")
            kept[id(state)] = {"size": result}, state
        return kept[id(state)][0]

    return report


def busy(state, result, job):
    begun = time.thread_time()
    while time.thread_time() - begun < 0.2:
        pass
    return {}


WRONG = {
    "cancelling swallowed": (lambda: swallowing, "went on although"),
    "half a report that is kept": (keeping_halves, "another one when asked again"),
    "no look in long work": (lambda: busy, "without a look at its job"),
}


@pytest.mark.parametrize("name", WRONG)
def test_the_suite_finds_what_cannot_be_stopped(subject, faulty, name, monkeypatch):
    monkeypatch.setattr("bozzetto.testing.job_checks.LONGEST_UNSEEN", 0.1)
    monkeypatch.setattr("bozzetto.testing.job_checks.slowness", lambda: 1.0)
    make, said = WRONG[name]
    faulty.misdeeds["report"] = make()
    with pytest.raises(Broken, match=said):
        check_stopping(subject)


def test_only_the_question_itself_is_watched(subject, faulty, monkeypatch):
    """What is drawn and solved before, and asked to be cancelled, was taken for work unseen."""
    monkeypatch.setattr("bozzetto.testing.job_checks.LONGEST_UNSEEN", 0.1)
    monkeypatch.setattr("bozzetto.testing.job_checks.slowness", lambda: 1.0)

    def slow_solve(state, job):
        busy(state, None, job)
        return state.size * len(state.strokes)

    faulty.misdeeds["solve"] = slow_solve
    faulty.misdeeds["report"] = lambda state, result, job: {"size": result}
    check_stopping(subject)


def test_a_plugin_of_version_2_0_works_as_before_and_is_told(subject, faulty, workshop):
    kind = type(faulty)

    class Old(kind):
        def report(self, state, result):
            return {"size": result}

        def read_drawing(self, drawing, context):
            return self.state_type(drawing.strokes)

        def view_advice(self, state, camera):
            return ViewAdvice("good", "")

    faulty.__class__ = Old
    workshop.draw(Pen().circle())
    bench, model = workshop.workbench, workshop.model
    assert bench.report(model, Job()) == {"size": 1.0}
    assert bench.view_advice(model, workshop.camera).level == "good"
    drawing = bench.readings.drawing_of([model])
    assert bench.sources.from_drawing("faulty.modeler", drawing, {}).state.strokes
    with pytest.raises(Broken, match=r"report\(self, state, result\) must take"):
        check_spelling(subject)


def test_a_job_goes_to_whoever_takes_it():
    job = Job()
    assert with_job(lambda a, b: None, 1, 2, job=job) == (1, 2)
    assert with_job(lambda a, b, job: None, 1, 2, job=job) == (1, 2, job)
    assert with_job(lambda *_: None, 1, 2, job=job) == (1, 2, job)
    assert with_job(max, 1, 2, job=job) == (1, 2, job)  # says nothing of its arguments


SAMPLES = [
    (info.id, min(drawn, key=lambda path: path.stat().st_size))
    for info in Registry().modelers()
    if info.listed
    if (drawn := [path for path in info.samples if path.suffix in (".json", ".svg")])
]
"""The smallest drawing of each modeler."""


@pytest.mark.slow
@pytest.mark.parametrize(("modeler", "path"), SAMPLES, ids=lambda it: getattr(it, "stem", it))
def test_bundled_modelers_are_stopped_at_any_look_and_then_give_the_whole(modeler, path):
    bench = Workbench(Registry())
    drawing = read_drawing(path, trusted=True)
    model = bench.sources.from_drawing(modeler, drawing, {})
    bench.solve(model, Job())

    def report(job):
        return bench.report(model, job)

    def read(job):
        return bench.sources.from_drawing(modeler, drawing, {}, job=job)

    whole = report(Job())
    for look in (1, 2, 3, 7):
        stop_at(look, "report", report)
        stop_at(look, "read_drawing", read)
    assert report(Job()) == whole
    fresh = Workbench(Registry())
    told = fresh.report(fresh.sources.from_drawing(modeler, drawing, {}), Job())
    assert same_but_ids(told, whole)


def same_but_ids(one, other):
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(
            key == "id" or same_but_ids(one[key], other[key]) for key in one
        )
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same_but_ids, one, other))
    return one == other or (isinstance(one, float) and np.isclose(one, other, rtol=1e-9))


def test_ctrl_c_in_a_report_leaves_nothing_behind(tmp_path, monkeypatch, capfd, request):
    looks = []

    def report(self, state, result, job):
        for _ in range(1000):
            job.checkpoint(0.5, "for long")
            looks.append(1)
            os.kill(os.getpid(), signal.SIGINT)
        return {}

    # Earlier tests of this process may have left the handler of a window.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))
    monkeypatch.setattr(Silhouette, "report", report)
    monkeypatch.chdir(tmp_path)
    ring = '<svg xmlns="http://www.w3.org/2000/svg"><circle cx="50" cy="50" r="40"/></svg>'
    (tmp_path / "ring.svg").write_text(ring)
    command = ["build", "silhouette", "ring.svg", "-o", "ring.stl", "--report", "r.json"]
    assert main(command) == 130
    assert looks
    assert "half-written" in capfd.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["ring.svg"]
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert main(command) == 0
    assert (tmp_path / "r.json").exists()
