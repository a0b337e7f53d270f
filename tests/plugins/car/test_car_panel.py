"""The guide panel: what it says of a car, the small car, and what a hand can do there."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Event, current_thread, main_thread

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from bozzetto.plugin import NextStep, TemplateFile
from bozzetto.scene import DARK, LIGHT
from bozzetto_car.body.build import body_of
from bozzetto_car.commands import car_as_template
from bozzetto_car.marking.edit_marks import with_asked, with_skipped
from bozzetto_car.panel import guide_panel, turning_car
from bozzetto_car.panel.car_picture import Pose, between, pose_of, small_car
from bozzetto_car.panel.guide_panel import GuidePanel
from bozzetto_car.panel.node_chart import row_text
from bozzetto_car.panel.turning_car import STILL
from bozzetto_car.panel.view_model import chart_of, guide_of
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.template.kept_templates import keep_template
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.shape_constraints import soundness_names
from bozzetto_car.view.next_step import next_mark_step
from tests.panel_host import StandInHost
from tests.plugins.car.penned import blank, guided, places_of, view_of
from tests.plugins.car.sketched import PICTURE

SEDAN = bundled("sedan")
EXAMPLE = (
    Path(__file__).resolve().parents[3]
    / "docs/examples/bozzetto_roadsters/bozzetto_roadsters/templates/roadster.json"
)
FRONT = view_of(40.0)


@pytest.fixture(scope="module")
def twelve():
    return guided(FRONT, 12)


@pytest.fixture(scope="module")
def astray():
    """Twenty marks, one of them 120 px off; one node noted as not visible."""
    state = guided(FRONT, 20)
    marks = tuple(
        replace(mark, u=mark.u + 120.0) if mark.node == "C3" else mark
        for mark in state.sketch.marks
    )
    return with_skipped(state.with_node(replace(state.sketch, marks=marks)), ["B5.L"])


# -- what it says ----------------------------------------------------------------------------------


def statuses(guide):
    return {row.node: row.status for row in guide.rows}


def test_every_node_has_its_status(astray):
    guide = guide_of(astray)
    found = statuses(guide)
    assert list(found) == [SEDAN.names[n] for n in SEDAN.asked("R")]
    assert found["C3"] == "wrong"
    assert found["B5.L"] == "skipped"
    assert found[guide.asked] == "asked"
    marked = {mark.node for mark in astray.sketch.marks} - {"C3"}
    assert {node for node, status in found.items() if status == "set"} == marked
    row = next(row for row in guide.rows if row.node == "C3")
    assert row.off == pytest.approx(120.0, abs=3.0)
    assert "disagrees by 1" in row_text(row)
    assert guide.count == 20


def test_a_sketch_in_a_few_words(astray, twelve):
    (row,) = guide_of(astray).sketches
    assert row.wrong
    assert row.summary.startswith("1 mark disagrees · 20 marks · ")
    (row,) = guide_of(twelve).sketches
    assert not row.wrong
    assert row.summary.startswith("perspective · 12 marks · 0.0 px")
    assert guide_of(blank()).sketches[0].summary == "0 marks"


def test_where_nothing_is_asked_nothing_is_named():
    assert guide_of(CarState()).rows == ()
    everything = with_skipped(guided(FRONT, 6), SEDAN.names)
    guide = guide_of(everything)
    assert (guide.asked, guide.title, guide.after) == ("", "", "")
    assert guide.before == everything.sketch.marks[-1].node


def test_the_view_that_would_help_most_is_named(twelve):
    """Of a car seen from the front on the right, what is behind is known least."""
    advice = guide_of(twelve).advice
    assert advice.startswith("Would help most: a ")
    now, then = (float(figure) for figure in re.findall(r"([\d.]+)(?= →| mm)", advice))
    assert now > then > 0.0
    assert guide_of(blank()).advice == ""


def test_dimensions_are_those_of_the_body(twelve):
    found = dict(guide_of(twelve).dimensions)
    body = body_of(twelve)
    assert found["Wheelbase"] == pytest.approx(
        np.ptp(body.network.positions[SEDAN.wheels[:, 0], 0])
    )
    assert set(found) == {"Length", "Width", "Height", "Front overhang", "Wheelbase"}


def test_all_constraints_are_there(twelve):
    name = "The windscreen leans back"
    guide = guide_of(replace(twelve, without=(name,)))
    assert tuple(rule.name for rule in guide.rules) == soundness_names(SEDAN)
    assert [rule.name for rule in guide.rules if not rule.is_on] == [name]
    assert not any(rule.is_broken for rule in guide.rules)


# -- drawings --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", TEMPLATES)
@pytest.mark.parametrize("near", ["L", "R"])
def test_in_the_chart_every_node_can_be_hit(name, near):
    """At 250 px no two dots are closer than a pen can tell, and the nose points where it does."""
    template = bundled(name)
    chart = chart_of(template, near)
    assert chart.places.min() >= -1e-9
    assert chart.places[:, 0].max() <= 1.0 + 1e-9
    gaps = np.linalg.norm(chart.places[:, None] - chart.places, axis=2) + np.eye(len(chart.places))
    assert gaps.min() * 230.0 > 4.5
    front = chart.places[template.node[f"WF.{near}"], 0]
    rear = chart.places[template.node[f"WR.{near}"], 0]
    assert (front < rear) == (near == "L")
    assert 0.2 < chart.front.mean() < 1.0


def test_the_small_car_shows_its_node():
    """In the picture, on the car, and on the patch that is tinted where it is on the body."""
    for node in SEDAN.names:
        made = small_car(SEDAN, node, pose_of(SEDAN, node), LIGHT, (120, 60))
        x, y = made.place
        assert 0.0 <= x <= 120.0
        assert 0.0 <= y <= 60.0
        near = made.pixels[max(0, int(y) - 2) : int(y) + 3, max(0, int(x) - 2) : int(x) + 3]
        assert near[..., 3].max() == 255, f"{node} is beside the car"
    plain = small_car(SEDAN, "", Pose(40.0, 15.0), LIGHT, (120, 60))
    tinted = small_car(SEDAN, "S1.R", Pose(40.0, 15.0), LIGHT, (120, 60))
    assert redness(tinted.pixels) > 5.0 * max(redness(plain.pixels), 1.0)


def redness(pixels):
    seen = pixels[pixels[..., 3] > 0].astype(float)
    return (seen[:, 0] - seen[:, 2] > 60.0).sum()


def test_the_small_car_turns_the_shorter_way():
    start, end = Pose(-170.0, 10.0), Pose(160.0, 20.0)
    way = [between(start, end, share) for share in np.linspace(0.0, 1.0, 21)]
    assert way[0] == start
    assert way[-1].azimuth % 360.0 == pytest.approx(160.0)
    turns = np.diff([pose.azimuth for pose in way])
    assert (turns <= 0.0).all()
    assert -turns.sum() == pytest.approx(30.0)
    assert max(abs(turns)) < 3.0 * 30.0 / 20.0


# -- the widget ------------------------------------------------------------------------------------


@pytest.fixture
def shown(qtbot):
    """A function that shows a panel for a state, and waits until it has looked at it."""
    application = QApplication.instance()
    application.setProperty(STILL, True)
    kept = []

    def show(state, templates=()):
        host, parent = StandInHost(state, next_mark_step, templates), QWidget()
        kept.append(parent)
        parent.resize(280, 900)
        qtbot.addWidget(parent)
        panel = GuidePanel(host, parent)
        panel.resize(280, 900)
        parent.show()
        calm(qtbot, panel)
        return panel, host

    yield show
    application.setProperty(STILL, False)


def calm(qtbot, panel):
    qtbot.waitUntil(lambda: not panel.busy, timeout=30_000)
    qtbot.waitUntil(lambda: not panel.busy and not panel.car.busy, timeout=30_000)


def test_the_asked_point_is_told(shown, twelve, qtbot):
    panel, host = shown(twelve)
    guide = guide_of(twelve)
    assert panel.title.text() == guide.title
    assert panel.next_step.text() == host.next_step.sentence
    assert SEDAN.prompts[guide.asked] in panel.next_step.text()
    assert panel.car.node == guide.asked
    assert panel.count.text() == "12 of 39 marked"
    host.put(with_asked(twelve, "C8"))
    calm(qtbot, panel)
    assert panel.title.text() == "Rear bumper, lower edge"
    assert SEDAN.prompts["C8"] in panel.next_step.text()


def test_with_another_tool_the_panel_still_tells_about_its_point(shown, twelve, qtbot):
    panel, host = shown(twelve)
    host.say_next = lambda state: NextStep("Draw along an edge.")
    host.put(with_asked(twelve, "C8"))
    calm(qtbot, panel)
    assert panel.title.text() == "Rear bumper, lower edge"
    assert SEDAN.prompts["C8"] in panel.next_step.text()
    host.put(CarState())
    calm(qtbot, panel)
    assert panel.next_step.text() == "Draw along an edge."


@pytest.mark.parametrize(("height", "has_picture"), [(900, True), (200, False)])
def test_the_buttons_are_in_sight_also_in_a_low_panel(shown, twelve, qtbot, height, has_picture):
    panel, _ = shown(twelve)
    panel.resize(280, height)
    qtbot.waitUntil(lambda: panel.car.isVisible() == has_picture)
    sight = panel.viewport()
    for button in (panel.back, panel.skip, panel.hide_):
        qtbot.waitUntil(
            lambda button=button: sight.rect().contains(
                button.mapTo(sight, button.rect().bottomRight())
            )
        )


def held_up(monkeypatch, module, name, is_held):
    """Let a function wait for some questions; return what says that it waits, and what ends it."""
    real, waits, may_end = getattr(module, name), Event(), Event()

    def slow(question, *more):
        if is_held(question):
            waits.set()
            may_end.wait(30.0)
        return real(question, *more)

    monkeypatch.setattr(module, name, slow)
    return waits, may_end


def test_what_is_taken_back_while_the_panel_looks_at_it_is_not_shown(
    shown, twelve, qtbot, monkeypatch
):
    panel, host = shown(twelve)
    said = panel.count.text()
    other = replace(twelve, template="minivan")
    waits, may_end = held_up(monkeypatch, guide_panel, "guide_of", lambda state: state is other)
    host.put(other)
    qtbot.waitUntil(waits.is_set)
    host.put(twelve)
    qtbot.wait(3 * guide_panel.PATIENCE)
    may_end.set()
    calm(qtbot, panel)
    assert panel.count.text() == said


def test_what_is_taken_back_while_the_small_car_is_drawn_is_not_shown(
    shown, twelve, qtbot, monkeypatch
):
    car = shown(twelve)[0].car
    qtbot.wait(5 * turning_car.BEAT)  # the ring about the point has gone
    node, before = car.node, car.grab().toImage()
    minivan = bundled("minivan")
    waits, may_end = held_up(monkeypatch, turning_car, "small_car", lambda one: one is minivan)
    car.show_node(minivan, node)
    qtbot.waitUntil(waits.is_set)
    car.show_node(SEDAN, node)
    may_end.set()
    qtbot.waitUntil(lambda: not car.busy)
    qtbot.wait(5 * turning_car.BEAT)
    assert car.grab().toImage() == before


def test_buttons_pass_points_over(shown, qtbot):
    panel, host = shown(blank())
    first = guide_of(blank()).asked
    panel.skip.click()
    calm(qtbot, panel)
    second = guide_of(host.state).asked
    assert second != first
    panel.back.click()
    calm(qtbot, panel)
    assert guide_of(host.state).asked == first
    panel.hide_.click()
    calm(qtbot, panel)
    assert host.state.sketch.skipped == (first,)
    assert len(host.labels) == 3


def test_a_click_on_the_chart_asks_for_a_node(shown, twelve, qtbot):
    panel, host = shown(twelve)
    for node in ("S3.R", "C7", "WR.R"):
        QTest.mouseClick(
            panel.chart, Qt.MouseButton.LeftButton, pos=panel.chart.place_of(node).toPoint()
        )
        calm(qtbot, panel)
        assert host.state.asked == node
    panel.chart.chosen.emit("C1")
    before = host.state
    QTest.mouseClick(panel.chart, Qt.MouseButton.LeftButton, pos=QPointF(1.0, 1.0).toPoint())
    assert host.state is before


def test_the_chart_is_of_use_without_a_mouse(shown, twelve, qtbot):
    panel, host = shown(twelve)
    names = [row.node for row in guide_of(twelve).rows]
    asked = guide_of(twelve).asked
    QTest.keyClick(panel.chart, Qt.Key.Key_Right)
    assert panel.chart.accessibleDescription()
    QTest.keyClick(panel.chart, Qt.Key.Key_Return)
    assert host.state.asked == names[(names.index(asked) + 1) % len(names)]


def test_a_click_never_undoes_what_came_after_the_panel_was_drawn(shown, twelve):
    """The panel lags behind by some milliseconds; the newest state counts."""
    panel, host = shown(twelve)
    newer = twelve.with_node(replace(twelve.sketch, opacity=0.3))
    host.put(newer)
    panel.skip.click()
    assert host.state.sketch.opacity == 0.3


def test_sketches_are_chosen(shown, twelve, qtbot):
    marks = tuple(Mark(n, *p) for n, p in places_of(view_of(-90.0)).items() if "R" not in n[1:])
    side = Sketch(id="two", name="Side", width=PICTURE[0], height=PICTURE[1], marks=marks)
    panel, host = shown(twelve.with_node(side))
    from bozzetto_car.panel.widgets import SketchButton

    first, second = sorted(panel.findChildren(SketchButton), key=lambda one: one.row.id)
    assert second.row.in_work
    first.click()
    calm(qtbot, panel)
    assert host.state.selected == "one"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder for the templates that are kept."""
    from bozzetto_car.panel import guide_panel, template_pictures

    for module in (guide_panel, template_pictures):
        monkeypatch.setattr(module, "template_folder", lambda: tmp_path)
    return tmp_path


def titles(panel):
    return [button.text() for button in panel.templates.buttons.values()]


def checked(panel):
    return [button.text() for button in panel.templates.buttons.values() if button.isChecked()]


def test_the_window_waits_for_no_template(shown, folder, monkeypatch):
    """All were read and checked before the panel was there: half a second."""
    read = []

    def noted(name):
        read.append(current_thread())
        return bundled(name)

    monkeypatch.setattr("bozzetto_car.panel.template_pictures.bundled", noted)
    panel, _ = shown(CarState())
    assert titles(panel) == [bundled(name).title for name in TEMPLATES]
    assert read
    assert main_thread() not in read


def test_every_template_is_chosen_by_its_picture(shown, folder, qtbot):
    panel, host = shown(CarState())
    assert titles(panel) == [bundled(name).title for name in TEMPLATES]
    for name in ("suv", "pickup", "sedan"):
        panel.templates.buttons[name].click()
        calm(qtbot, panel)
        assert host.state.template == name
        assert checked(panel) == [bundled(name).title]
    assert host.labels == ["Template"] * 3


def test_a_car_is_kept_as_a_template_and_another_begins_with_it(shown, folder, qtbot):
    panel, host = shown(CarState(template="coupe", length=4300.0))
    assert not panel.keep.isEnabled()  # it has no name yet
    panel.name.setText("Wedge")
    panel.keep.click()
    calm(qtbot, panel)
    assert titles(panel)[len(TEMPLATES) :] == ["Wedge"]
    assert panel.name.text() == ""
    assert host.labels == []  # the car is what it was
    assert checked(panel) == ["Coupé"]

    panel, host = shown(CarState())
    assert not panel.name.isEnabled()  # it is a template as it stands
    key = next(key for key in panel.templates.buttons if key not in TEMPLATES)
    panel.templates.buttons[key].click()
    calm(qtbot, panel)
    assert host.state.template == "own"
    assert body_of(host.state).dimensions.length == pytest.approx(4300.0)
    assert checked(panel) == ["Wedge"]
    panel.templates.buttons["van"].click()
    calm(qtbot, panel)
    assert host.state.template == "van"
    assert titles(panel)[len(TEMPLATES) :] == ["Wedge"]


def test_a_kept_template_is_forgotten_and_a_car_has_it_still(shown, folder, qtbot):
    keep_template(folder, car_as_template(CarState(length=4300.0), "Wedge"))
    panel, host = shown(CarState())
    key = next(key for key in panel.templates.buttons if key not in TEMPLATES)
    panel.templates.buttons[key].click()
    calm(qtbot, panel)
    panel.templates.buttons[key].actions()[0].trigger()
    calm(qtbot, panel)
    assert list(folder.iterdir()) == []
    assert checked(panel) == ["Wedge"]  # the car's own
    assert not panel.templates.buttons[key].actions()
    assert body_of(host.state).dimensions.length == pytest.approx(4300.0)


def test_an_imported_template_is_one_with_the_file_that_is_kept(shown, folder, qtbot):
    source = car_as_template(CarState(length=4300.0), "Wedge")
    keep_template(folder, source)
    panel, _ = shown(CarState(template="own", own=json.dumps(json.loads(source))))
    assert titles(panel)[len(TEMPLATES) :] == checked(panel) == ["Wedge"]


def test_why_a_car_cannot_be_kept_is_told_and_its_name_stays(shown, folder, qtbot):
    panel, host = shown(blank())  # a sketch whose camera is not known
    panel.name.setText("Wedge")
    panel.keep.click()
    calm(qtbot, panel)
    assert "Mark its points" in host.problems[0]
    assert panel.name.text() == "Wedge"
    assert panel.keep.isEnabled()
    assert list(folder.iterdir()) == []


def test_quick_clicks_on_templates_end_with_the_last(shown, folder, qtbot):
    panel, host = shown(CarState())
    for name in ("suv", "van", "suv", "pickup"):
        panel.templates.buttons[name].click()
    calm(qtbot, panel)
    assert host.state.template == "pickup"
    assert checked(panel) == ["Pickup"]


def test_constraints_are_switched_off_and_on(shown, twelve, qtbot):
    panel, host = shown(twelve)
    item = panel.rules.item(1)
    item.setCheckState(Qt.CheckState.Unchecked)
    assert host.state.without == (item.text(),)
    calm(qtbot, panel)
    panel.rules.item(1).setCheckState(Qt.CheckState.Checked)
    assert host.state.without == ()


@pytest.fixture
def unstyled(qapp):
    """Without the style sheet that a window before may have left: it decides over palettes."""
    before = qapp.styleSheet()
    qapp.setStyleSheet("")
    yield
    qapp.setStyleSheet(before)


@pytest.mark.usefixtures("unstyled")
def test_both_themes_are_followed(shown, twelve, qtbot):
    panel, _ = shown(twelve)
    for palette in (DARK, LIGHT):
        made = QPalette()
        made.setColor(QPalette.ColorRole.Window, QColor(*palette.panel))
        made.setColor(QPalette.ColorRole.WindowText, QColor(*palette.ink))
        panel.setPalette(made)
        QApplication.sendEvent(panel.car, QEvent(QEvent.Type.PaletteChange))
        # the dot has the theme's own accent, once the car has been drawn anew
        qtbot.waitUntil(partial(_has_color, panel.car, palette.accent), timeout=20_000)


def _has_color(widget, color):
    image = widget.grab().toImage()
    return any(
        image.pixelColor(x, y).getRgb()[:3] == color
        for x in range(image.width())
        for y in range(image.height())
    )


def test_nothing_is_lost_when_the_panel_goes_while_it_works(twelve, qtbot):
    host, parent = StandInHost(twelve, next_mark_step), QWidget()
    qtbot.addWidget(parent)
    panel = GuidePanel(host, parent)
    parent.show()
    qtbot.wait(70)
    panel.deleteLater()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    qtbot.wait(150)


def test_templates_of_plugins_are_offered_and_broken_ones_told_once(shown, tmp_path, qtbot):
    source = EXAMPLE.read_text("utf-8")
    broken = tmp_path / "broken.json"
    broken.write_text(source.replace('"C2.x', '"C99.x', 1))
    files = [TemplateFile("a.b", "“Roadsters” (a.b)", path) for path in (EXAMPLE, broken)]
    panel, host = shown(CarState(), files)
    qtbot.waitUntil(lambda: not panel.templates.busy, timeout=30_000)
    button = panel.templates.buttons[source]
    assert button.text() == "Roadster"
    assert "Roadsters" in button.toolTip()
    assert len(panel.templates.buttons) == len(TEMPLATES) + 1
    panel.templates.look_again()
    calm(qtbot, panel)
    qtbot.waitUntil(lambda: not panel.templates.busy, timeout=30_000)
    (told,) = host.problems
    assert "broken.json" in told
    assert "Roadsters" in told
    panel.templates.buttons[source].click()
    assert host.state.template == "own"
    assert json.loads(host.state.own) == json.loads(source)
