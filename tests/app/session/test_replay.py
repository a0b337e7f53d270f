"""Watching a drawing: the same strokes arrive, one after the other, and a hand stops it."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.ink import Strokes
from bozzetto.ink.drawing import Drawing
from bozzetto_app.session.replay import Replays
from bozzetto_app.session.stroke_replay import StrokeReplay
from tests.app.tablet import Stylus, circle, stroke_of
from tests.app.troublemaker import MODELER
from tests.sizes import sized

pytestmark = pytest.mark.slow

FAST = 40.0
"""Times as fast as the hand was."""


def drawing(session, *shares):
    strokes = [
        stroke_of(circle(radius=50 + 20 * k, share=share), session.view.camera)
        for k, share in enumerate(shares)
    ]
    return Drawing(Strokes(tuple(strokes)), session.view.camera)


def test_the_strokes_arrive_sample_by_sample_and_whole(session, settle, qtbot):
    recorded = drawing(session, 1.0, 1.0)
    growing = []
    session.scene.live_changed.connect(lambda: growing.append(len(session.drawing.document)))
    replay = StrokeReplay(session, recorded, speed=4.0)
    with qtbot.waitSignal(replay.finished, timeout=20_000):
        replay.start()
    settle(session)
    kept = session.drawing.document.models[0].state.strokes
    assert len(kept) == 2
    for mine, theirs in zip(kept, recorded.strokes, strict=True):
        assert np.array_equal(mine.x, theirs.x)
        assert np.array_equal(mine.t, theirs.t)
    assert growing  # it was previewed on the way
    assert session.drawing.history.position == 2


def test_what_is_left_open_at_the_end_is_finished(session, settle, qtbot):
    replay = StrokeReplay(session, drawing(session, 0.6), speed=FAST)
    with qtbot.waitSignal(replay.finished, timeout=20_000):
        replay.start()
    settle(session)
    assert session.drawing.pending == ()
    assert len(session.drawing.document) == 1


def test_strokes_without_time_are_played_too(session, settle, qtbot):
    from bozzetto.ink.stroke import Stroke

    points = circle()
    bare = Stroke(x=points[:, 0], y=points[:, 1], camera=session.view.camera)
    replay = StrokeReplay(session, Drawing(Strokes((bare,)), session.view.camera), speed=FAST)
    with qtbot.waitSignal(replay.finished, timeout=20_000):
        replay.start()
    settle(session)
    assert len(session.drawing.document) == 1


def test_stopping_keeps_what_was_finished_and_nothing_of_the_rest(session, settle, qtbot):
    replay = StrokeReplay(session, drawing(session, *[1.0] * 10), speed=8.0)
    replay.start()
    qtbot.waitUntil(lambda: len(session.drawing.document) == 1, timeout=20_000)
    with qtbot.waitSignal(replay.finished):
        replay.stop()
    settle(session)
    count = len(session.drawing.document.models[0].state.strokes)
    assert count < 10
    assert session.drawing.pending == ()
    assert not session.scene.live.layers
    qtbot.wait(100)
    assert len(session.drawing.document.models[0].state.strokes) == count
    replay.stop()


def test_every_sample_drawing_makes_sound_solids_when_watched(make_window, settle, qtbot):
    window = make_window()
    session = window.session
    for info in session.toolbox.modelers:
        for sample in info.samples[: sized(2, len(info.samples))]:
            window.replays.speed = FAST
            window.watch(info.id, sample)
            if (
                window.replays.current is not None
            ):  # marks on a picture have no strokes to be watched
                with qtbot.waitSignal(window.replays.finished, timeout=400_000):
                    pass
            settle(session, window.keeper)
            assert [n.text for n in session.heard if n.kind in ("error", "fault")] == []
            assert len(session.drawing.document) >= 1
            for part in session.solver.report.get("parts", ()):
                assert part["watertight"]
            session.drawing.history.mark_saved()
    assert not window.welcome.isVisible()


@pytest.mark.parametrize("by", ["hand", "document"])
def test_a_hand_or_another_document_stops_it(make_window, boxes, settle, qtbot, by):
    window = make_window(MODELER, extra=[boxes.package])
    window.replays.play(drawing(window.session, *[1.0] * 10))
    qtbot.wait(100)
    assert window.replays.current is not None
    if by == "hand":
        Stylus(window.canvas).draw(circle(radius=33))
    else:
        window.session.files.new()
    settle(window.session)
    assert window.replays.current is None
    count = sum(len(model.state.strokes) for model in window.session.drawing.document)
    qtbot.wait(300)
    assert sum(len(model.state.strokes) for model in window.session.drawing.document) == count
    assert count == (1 if by == "hand" else 0)


def test_steps_make_what_they_make_without_a_window(make_session, settle, qtbot, tmp_path):
    from bozzetto.exchange.import_file import read_drawing
    from tests.plugins.product.test_product_ink import RECTANGLE, built

    steps = [{"set": {"controls": 9}}, *RECTANGLE, {"rename": "Last"}, {"command": "hide-rough"}]
    _, expected = built(tmp_path, steps)
    drawing = read_drawing(tmp_path / "ink.json")
    session = make_session("bozzetto.product")
    replays = Replays(session)
    replays.speed = FAST
    seen = []
    replays.inked.connect(lambda stroke: seen.append(0 if stroke is None else len(stroke)))
    with qtbot.waitSignal(replays.finished, timeout=60_000):
        replays.play(drawing)
    settle(session)
    (model,) = session.drawing.document.models
    assert model.state.joints == expected.state.joints
    pairs = zip(model.state.nodes, expected.state.nodes, strict=True)
    assert all(ours.name == theirs.name for ours, theirs in pairs)
    for ours, theirs in zip(model.state.nodes[1:5], expected.state.nodes[1:5], strict=True):
        assert (ours.spline.control_points == theirs.spline.control_points).all()
    assert seen.count(len(drawing.strokes[0])) >= 1
    history = session.drawing.history
    drawn = ("Draw curve",) * len(RECTANGLE)
    hidden = "Hide or show the rough shape"
    assert history.entries[-len(steps) :] == (
        "Control points", *drawn, "Rename to “Last”", hidden,
    )  # fmt: skip
    replays.stop()
