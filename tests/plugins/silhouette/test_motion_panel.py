"""The motion panel: figures of key poses, the time dragged over them, and what changes them."""

from __future__ import annotations

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QWidget

from bozzetto.view import Camera
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.panel.film_strip import BAR, FilmStrip
from bozzetto_silhouette.panel.motion_panel import MotionPanel
from bozzetto_silhouette.rigging.key_poses import ASIDE, at_key, figures_of
from bozzetto_silhouette.rigging.posing import rig_of
from tests.panel_host import StandInHost
from tests.plugins.silhouette.outlines import circle
from tests.plugins.silhouette.rigging.characters import state_of_rings
from tests.plugins.silhouette.rigging.test_motion import PERSON, ran

LEFT = Qt.MouseButton.LeftButton

SNAKE = state_of_rings([np.array([(-60, 0), (60, -4), (62, 0), (60, 4)], float)], 32)


@pytest.fixture
def shown(qtbot):
    holders = []  # a widget without a parent ends with its last name

    def show(state):
        holder = QWidget()
        holders.append(holder)
        qtbot.addWidget(holder)
        host = StandInHost(state)
        panel = MotionPanel(host, holder)
        panel.resize(300, 400)
        holder.show()
        qtbot.waitUntil(lambda: not panel.busy, timeout=20_000)
        return host, panel

    return show


@pytest.fixture
def calm(qtbot):
    return lambda panel: qtbot.waitUntil(lambda: not panel.busy, timeout=20_000)


def touched(strip: FilmStrip, key: int) -> None:
    QTest.mouseClick(strip, LEFT, pos=strip.frame(key).center())


def test_figures_are_the_joints_of_every_key_as_a_camera_at_the_front_right_sees_them():
    state = ran(PERSON, "walk")
    figures = figures_of(state)
    assert figures.shape == (8, len(rig_of(PERSON).joints), 2)
    eye = 1000.0 * np.array((np.sin(ASIDE), -np.cos(ASIDE), 0.0))
    camera = Camera("orthographic", tuple(eye), height=100.0, viewport=(100.0, 100.0))
    for key in range(8):
        pixels, _ = camera.project(rig_of(at_key(state, key)).posed()[1])
        np.testing.assert_allclose(figures[key], (pixels - 50.0) * (1.0, -1.0), atol=1e-6)
    assert figures_of(PERSON).size == 0


def test_a_walk_towards_us_is_seen_in_the_figures():
    figures = figures_of(ran(PERSON, "walk"))
    moved = np.linalg.norm(figures - figures[0], axis=2).max()
    assert moved > 0.08 * np.ptp(figures[..., 1])


def test_a_second_quick_click_is_on_the_same_button(shown, calm):
    host, panel = shown(PERSON)
    place = panel.buttons["Walk"].mapTo(panel, panel.buttons["Walk"].rect().center())
    for _ in range(2):
        QTest.mouseClick(panel.childAt(place), LEFT)
        calm(panel)
    assert host.labels == ["Walk"], "the second one changes nothing, and is no step"
    assert host.problems == ["That is how it is already."]


def test_a_touch_on_a_figure_shows_that_pose(shown, calm):
    host, panel = shown(ran(PERSON, "walk"))
    for key in (3, 7, 0):
        touched(panel.strip, key)
        calm(panel)
        assert host.state.turns == host.state.keys[key].turns
        assert panel.strip.time == pytest.approx(key)
    assert set(host.labels) == {"Go to a key pose"}


def test_the_time_is_dragged_and_jumps_to_keys_that_are_near(shown, calm):
    host, panel = shown(ran(PERSON, "walk"))
    strip = panel.strip
    start, end = (QPoint(round(strip.place_of(time)), BAR // 2) for time in (0.5, 3.5))
    QTest.mousePress(strip, LEFT, pos=start)
    QTest.mouseMove(strip, end)
    QTest.mouseRelease(strip, LEFT, pos=end)
    calm(panel)
    assert host.going[-1] is False
    assert host.state.time / host.state.beat == pytest.approx(3.5, abs=0.1)
    near = QPoint(round(strip.place_of(5) + 3), BAR // 2)
    QTest.mouseClick(strip, LEFT, pos=near)
    calm(panel)
    assert host.state.turns == host.state.keys[5].turns


def test_the_ends_of_the_bar_are_the_first_and_the_last_moment(shown, calm):
    host, panel = shown(ran(PERSON, "walk"))
    for x, time in ((-50, 0.0), (5_000, 8.0)):
        QTest.mousePress(panel.strip, LEFT, pos=QPoint(100, BAR // 2))
        QTest.mouseRelease(panel.strip, LEFT, pos=QPoint(x, BAR // 2))
        calm(panel)
        assert host.state.time / host.state.beat == pytest.approx(time, abs=0.01)
        assert host.state.time < 8 * host.state.beat


def test_arrow_keys_go_from_pose_to_pose_and_round(shown, calm):
    host, panel = shown(ran(PERSON, "walk"))
    for key, number in ((Qt.Key.Key_Left, 7), (Qt.Key.Key_Right, 0), (Qt.Key.Key_Right, 1)):
        QTest.keyClick(panel.strip, key)
        calm(panel)
        assert host.state.turns == host.state.keys[number].turns


def test_buttons_do_what_the_commands_do(shown, calm):
    host, panel = shown(PERSON)
    assert panel.strip.count == 0
    enabled = [word for word, button in panel.buttons.items() if button.isEnabled()]
    assert enabled == ["Walk", "Sway", "Keep pose"]
    steps = [("Walk", "walk"), ("Later", "later-pose"), ("Keep pose", "keep-pose")]
    steps += [("Forget", "forget-pose"), ("Change", "change-pose"), ("Sway", "sway")]
    for word, command in steps:
        wanted = ran(host.state, command)
        panel.buttons[word].click()
        calm(panel)
        assert host.state == wanted
    assert all(button.isEnabled() for button in panel.buttons.values())


def test_earlier_undoes_later(shown, calm):
    host, panel = shown(at_key(ran(PERSON, "walk"), 7))
    before = host.state
    for word in ("Later", "Earlier"):
        panel.buttons[word].click()
        calm(panel)
    assert host.state == before


def test_a_shape_without_joints_says_what_to_do(shown, calm):
    for state in (state_of_rings([circle(0, 0, 20)], 32), SilhouetteState()):
        host, panel = shown(state)
        assert not any(button.isEnabled() for button in panel.buttons.values())
        assert panel.sentence.text().startswith(
            "This shape has no joints" if state.nodes else "Draw"
        )
        touched(panel.strip, 0)
        assert host.labels == []


def test_what_cannot_walk_says_why(shown):
    snake = replace(SNAKE, keys=(), turns=())
    host, panel = shown(snake)
    panel.buttons["Walk"].click()
    assert host.labels == []
    (problem,) = host.problems
    assert "two limbs that point down" in problem


def test_parameters_stay_in_front_and_a_touch_poses_the_shape_in_the_window(window):
    from PySide6.QtWidgets import QTabBar

    from tests.plugins.silhouette.rigging.test_motion import DRAWING

    window.open("silhouette")
    window.draw(*DRAWING.strokes)
    panel = window.window.findChild(MotionPanel, "motion")
    (tabs,) = (b for b in window.window.findChildren(QTabBar) if b.count() and b.isVisible())
    assert tabs.tabText(tabs.currentIndex()) == "Parameters"
    window.wait_until(panel.buttons["Sway"].isEnabled)
    panel.buttons["Sway"].click()
    window.wait_until(lambda: len(window.state.keys) == 8 and not panel.busy)
    touched(panel.strip, 2)
    window.wait_until(lambda: window.state.turns == window.state.keys[2].turns)
    window.settle()
    window.undo()
    assert window.state.turns == window.state.keys[0].turns
