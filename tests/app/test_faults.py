"""A plugin that does every wrong thing at every door: the document and the window stay well."""

from __future__ import annotations

import importlib
import logging
import sys
import threading
import time

import numpy as np
import pytest
from PySide6.QtCore import QTimer

from bozzetto.exchange.export import write_drawing
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto.ink import Strokes
from bozzetto.ink.drawing import Drawing
from bozzetto.scene import Layer, Lines, Scene, Shaded
from bozzetto_app.workers.channel import Channel
from tests.app.seen import part
from tests.app.tablet import circle, draw, stroke_of
from tests.app.troublemaker import MODELER, PLUGIN, UNLUCKY, BoxesState, box
from tests.app.yardstick import Yardstick

pytestmark = pytest.mark.slow

LIMIT = 0.3
"""Seconds after which the tests' channels call a plugin hung."""


@pytest.fixture(scope="module", autouse=True)
def _imported():
    """So that no limit is reached by imports, and no module keeps a limit of these tests.

    What is imported while `LATE_AFTER` is short takes the short one with it, for all later tests.
    """
    silhouette = ("bozzetto_silhouette", "bozzetto_silhouette.modeler")
    window = ("bozzetto_app.main_window", "bozzetto_app.session.session")
    libraries = ("scipy.spatial", "scipy.sparse.linalg", "scipy.optimize", "shapely")
    for name in (*libraries, *silhouette, *window):
        importlib.import_module(name)


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    for module, name in (
        ("gestures", "APPLY_LIMIT"),
        ("gestures", "LATE_AFTER"),
        ("toolbox", "TOOLS_LIMIT"),
        ("solver", "LATE_AFTER"),
        ("hints", "LATE_AFTER"),
        ("view_advice", "LATE_AFTER"),
        ("modeler_commands", "LATE_AFTER"),
    ):
        monkeypatch.setattr(f"bozzetto_app.session.{module}.{name}", LIMIT)
    for name in ("GRACE", "LATE_AFTER"):
        monkeypatch.setattr(f"bozzetto_app.workers.channel.{name}", LIMIT)


let_go = threading.Event()
"""Set at the end of each test, so that no thread sleeps on."""


@pytest.fixture(autouse=True)
def _let_go():
    let_go.clear()
    yield
    let_go.set()


def raises(*arguments):
    raise ValueError("half a thing")


def hangs(*arguments):
    while not let_go.is_set():
        pass


def sleeps(*arguments):
    let_go.wait(60)


def leaves(*arguments):
    sys.exit(3)


def recurses(*arguments):
    return recurses(*arguments)


def scribbles(*arguments):
    """Writes past the freeze of everything it was given."""
    for argument in arguments:
        for name in getattr(argument, "__dataclass_fields__", ()):
            object.__setattr__(argument, name, None)
        if isinstance(argument, dict):
            argument.clear()
            argument["x"] = 1
    raise KeyError("done")


def spoiled(thing, name):
    """A frozen thing into which numbers were smuggled that its maker refuses."""
    array = np.full_like(getattr(thing, name), np.nan)
    object.__setattr__(thing, name, array)
    return thing


NAN_MESH = spoiled(Mesh(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32)), "vertices")
NAN_LINES = spoiled(Lines(np.zeros((2, 3), np.float32)), "points")
GARBAGE = {
    "create": BoxesState(table=(float("nan"), object())),
    "tools": [42],
    "preview": Scene((Layer("x", (NAN_LINES,)),)),
    "apply": "a state, surely",
    "solve": np.nan,
    "scene": Scene((Layer("x", (Shaded(NAN_MESH),)),)),
    "shapes": Shapes(solids=(Solid(NAN_MESH),)),
    "report": [1, 2, 3],
    "read_drawing": None,
    "read_shapes": 7,
    "upgrade": "no dict",
}
MISDEEDS = {
    "raises": raises,
    "hangs": hangs,
    "sleeps": sleeps,
    "leaves": leaves,
    "recurses": recurses,
    "scribbles": scribbles,
}


class Heart:
    """Counts the turns of the event loop, and the longest pause between two of them."""

    def __init__(self):
        self.beats, self.longest, self.last = 0, 0.0, time.perf_counter()
        self.timer = QTimer(interval=0)
        self.timer.timeout.connect(self.beat)
        self.timer.start()

    def beat(self):
        now = time.perf_counter()
        self.beats += 1
        self.longest, self.last = max(self.longest, now - self.last), now


def faults(session):
    """What was said of plugins; the one that behaves and the program itself may only be slow."""
    kinds, well = ("fault", "slow"), ("", "bozzetto.silhouette")
    return [n for n in session.heard if n.kind in kinds and n.plugin not in well]


@pytest.fixture
def session(make_session, boxes, settle):
    """With a document of one good box, so that there is something to damage."""
    made = make_session(MODELER, extra=[boxes.package])

    def stop_what_hangs(notice):
        """A person stops it; what is only slow, as on a loaded machine, may go on."""
        if notice.kind == "slow" and notice.plugin == PLUGIN:
            made.cancel_work()

    made.notices.noticed.connect(stop_what_hangs)
    draw(made, settle)
    assert len(made.drawing.document) == 1
    made.heard.clear()
    return made


def reach(session, boxes, what, tmp_path, settle):
    """Make the session call one of the modeler's functions."""
    if what == "tools":
        session.toolbox.take_modeler("bozzetto.silhouette")
        session.toolbox.take_modeler(MODELER)
    elif what in ("preview", "apply"):
        points = stroke_of(circle(radius=70), session.view.camera)
        session.gestures.stroke_moved(points)
        settle(session)
        session.gestures.stroke_lifted(points)
    elif what == "create":
        session.selection.select(None)
        session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    elif what in ("solve", "scene", "report"):
        session.objects.set_parameter("size", 21.0)
    elif what == "shapes":
        session.files.exchange.export(tmp_path / "out.stl")
    elif what == "read_drawing":
        ink = Strokes((stroke_of(circle(), session.view.camera),))
        write_drawing(Drawing(ink, session.view.camera), tmp_path / "ink.json")
        session.files.exchange.import_file(tmp_path / "ink.json")
    settle(session)


DOORS = (
    "tools",
    "create",
    "preview",
    "apply",
    "solve",
    "scene",
    "report",
    "shapes",
    "read_drawing",
)


@pytest.mark.parametrize("misdeed", [*MISDEEDS, "garbage"])
@pytest.mark.parametrize("what", DOORS)
def test_a_misdeed_is_told_and_nothing_else_changes(
    what, misdeed, session, boxes, settle, tmp_path, caplog
):
    heart, before = Heart(), session.drawing.document
    boxes.misdeeds[what] = MISDEEDS.get(misdeed, lambda *_: GARBAGE[what])
    with caplog.at_level(logging.WARNING, "bozzetto.plugin"), Yardstick() as machine:
        reach(session, boxes, what, tmp_path, settle)
    told = faults(session)
    assert told, [n.text for n in session.heard]
    assert all(notice.plugin == PLUGIN and PLUGIN in notice.text for notice in told)
    if misdeed not in ("garbage",):
        assert told[0].details
    assert any(PLUGIN in record.getMessage() for record in caplog.records)
    assert heart.beats > 1
    if misdeed in ("hangs", "sleeps"):
        # A window that waited for the plugin would stand still for as long as that may hang.
        assert heart.longest < max(0.9 * LIMIT, 3.0 * machine.longest)
    # The one good box is as it was, whatever may have been drawn after it.
    first, was = session.drawing.document.models[0], before.models[0]
    if what in ("solve", "scene", "report"):
        assert first.state.size == 21.0
        assert first.state.strokes is was.state.strokes
    elif what in ("preview",):
        assert len(first.state.strokes) == 2  # one bad preview does not cost the stroke
    else:
        assert session.drawing.document.models is before.models
    assert isinstance(was.state, BoxesState)
    assert was.state.table == ()
    # Ink that it did not take waits, and says why.
    stopped = misdeed in ("hangs", "sleeps")
    assert len(session.drawing.pending) == (what in ("apply", "create"))
    assert all(one.status == "failed" for one in session.drawing.marked_ink)
    assert all(stopped or PLUGIN in one.reason for one in session.drawing.marked_ink)
    assert len(session.drawing.marked_ink) == len(session.drawing.pending)
    session.gestures.clear()
    assert not (tmp_path / "out.stl").exists()
    # The next stroke works: with this modeler if it has come to its senses, else another.
    del boxes.misdeeds[what]
    let_go.set()
    session.findChild(Channel, "solve").time_limit = 60.0
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    count = len(session.drawing.document)
    draw(session, settle, radius=150)
    assert len(session.drawing.document) == count + 1, [n.text for n in session.heard]
    assert session.solver.report["parts"][0]["watertight"]


def test_three_faults_switch_a_plugin_off_and_its_model_stays(session, boxes, settle):
    for number, size in enumerate((20.0, 30.0, 40.0, 50.0), 1):
        boxes.misdeeds["solve"] = raises
        session.objects.set_parameter("size", size)
        settle(session)
        assert len(faults(session)) == min(number, 3)
    assert session.registry.guard.is_off(PLUGIN)
    assert boxes.calls["solve"] == 2 + 3
    assert session.drawing.document.models[0].state.size == 40.0  # the fourth was refused
    off = [notice for notice in session.heard if notice.kind == "error"]
    assert "switched off" in off[-1].text
    assert session.registry.plugins()
    session.drawing.undo()
    settle(session)
    assert session.drawing.document.models[0].state.size == 30.0


def test_a_state_that_fails_over_its_own_values_is_a_fault(session):
    before = session.drawing.document
    session.objects.set_parameter("size", UNLUCKY)
    assert session.drawing.document is before
    assert [notice.plugin for notice in faults(session)] == [PLUGIN]


def test_a_preview_that_fails_is_not_asked_again_in_this_session(session, boxes, settle):
    boxes.misdeeds["preview"] = raises
    for _ in range(4):
        session.gestures.stroke_moved(stroke_of(circle(), session.view.camera))
        settle(session)
    assert boxes.calls["preview"] == 1
    assert len(faults(session)) == 1
    draw(session, settle)
    assert len(session.drawing.document.models[0].state.strokes) == 2


@pytest.mark.parametrize("misdeed", ["raises", "hangs", "scribbles", "leaves", "recurses"])
def test_a_document_whose_upgrade_fails_does_not_take_the_window_along(
    misdeed, session, boxes, settle, tmp_path
):
    session.files.save(tmp_path / "old.bozz")
    settle(session)
    before = session.drawing.document
    boxes.misdeeds["upgrade"] = MISDEEDS[misdeed]
    boxes.state_version = 3
    saved = (tmp_path / "old.bozz").read_bytes()
    session.files.open_safely(tmp_path / "old.bozz")
    settle(session)
    assert (tmp_path / "old.bozz").read_bytes() == saved
    let_go.set()
    # Either it was refused, or it is open with the part closed; nothing is half open.
    if session.drawing.document is not before:
        assert all(session.workbench.is_foreign(model) for model in session.drawing.document)
    assert [n for n in session.heard if n.kind in ("fault", "error", "info")]
    session.files.save(tmp_path / "again.bozz")
    settle(session)
    assert (tmp_path / "again.bozz").exists()


def test_a_hung_import_does_not_come_between_a_person_and_their_file(
    session, boxes, settle, tmp_path, qtbot, monkeypatch
):
    session.files.exchange.findChild(Channel).time_limit = 60.0
    boxes.misdeeds["read_drawing"] = sleeps
    ink = Strokes((stroke_of(circle(), session.view.camera),))
    write_drawing(Drawing(ink, session.view.camera), tmp_path / "ink.json")
    session.files.exchange.import_file(tmp_path / "ink.json")
    qtbot.waitUntil(lambda: boxes.calls["read_drawing"] == 1)
    with qtbot.waitSignal(session.files.saved, timeout=10_000):
        session.files.save(tmp_path / "mine.bozz")
    session.cancel_work()
    settle(session)
    assert (tmp_path / "mine.bozz").exists()


def test_a_mesh_that_its_reader_refuses_is_a_fault_of_that_plugin(
    session, settle, tmp_path, monkeypatch
):
    from bozzetto.exchange.export import export

    export(Shapes(solids=(Solid(box(10.0, 0.0)),)), tmp_path / "box.stl")
    reader = session.registry.modeler("bozzetto.mesh")
    monkeypatch.setattr(reader, "read_shapes", raises, raising=False)
    monkeypatch.setattr(type(reader), "read_shapes", raises)
    before = session.drawing.document
    session.files.exchange.import_file(tmp_path / "box.stl")
    settle(session)
    assert session.drawing.document is before
    assert [notice.plugin for notice in faults(session)] == ["bozzetto.mesh"]


@pytest.mark.parametrize("misdeed", ["raises", "hangs", "leaves", "recurses", "garbage"])
def test_a_panel_that_misbehaves_does_not_take_the_window_along(
    misdeed, make_window, boxes, settle, monkeypatch
):
    monkeypatch.setattr("bozzetto_app.workers.time_limit.PATIENCE", LIMIT)
    boxes.misdeeds["panel"] = MISDEEDS.get(misdeed, lambda *_: 42)
    window = make_window(MODELER, extra=[boxes.package])
    session = window.session
    draw(session, settle)
    assert [notice.plugin for notice in faults(session)] == [PLUGIN]
    assert boxes.calls["panel"] == 1
    assert not window.docks.plugin_panel.is_filled
    draw(session, settle)
    assert len(session.drawing.document.models[0].state.strokes) == 2
    assert len(faults(session)) == 1


def test_the_fault_bar_names_the_plugin_and_can_switch_it_off(make_window, boxes, settle, qtbot):
    window = make_window(MODELER, extra=[boxes.package])
    boxes.misdeeds["apply"] = raises
    draw(window.session, settle)
    bar = window.status.faults
    assert bar.isVisible()
    assert PLUGIN in part(bar, "fault-words").text()
    part(bar, "fault-switch-off").click()
    assert not bar.isVisible()
    assert MODELER not in [info.id for info in window.session.toolbox.modelers]
    window.session.toolbox.take_modeler("bozzetto.silhouette")
    settle(window.session)
    draw(window.session, settle)
    assert len(window.session.drawing.document) == 1


def test_a_fault_with_half_a_character_is_kept_on_disk(monkeypatch, tmp_path):
    from bozzetto_app import startup

    monkeypatch.setattr(startup, "log_file", lambda: tmp_path / "log.txt")
    monkeypatch.setattr(logging, "raiseExceptions", True)
    handler = startup.DiskLog()
    handler.emit(logging.makeLogRecord({"msg": "boom \udcff", "levelno": 40, "levelname": "ERROR"}))
    handler.close()
    assert "boom \\udcff" in (tmp_path / "log.txt").read_text()
