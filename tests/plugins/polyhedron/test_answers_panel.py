"""The answers panel: pictures of what a drawing could mean, in words, and the choice of one."""

from __future__ import annotations

import os

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
import pytest

pytest.importorskip("PySide6")

from PySide6.QtWidgets import QWidget

from bozzetto.scene import DARK, LIGHT
from bozzetto_polyhedron.commands.answers import with_answer
from bozzetto_polyhedron.model.assign_stroke import new_body
from bozzetto_polyhedron.model.state import Choice, PolyhedronState
from bozzetto_polyhedron.panel.answer_pictures import gallery_of, words_of
from bozzetto_polyhedron.panel.answers_panel import AnswersPanel
from bozzetto_polyhedron.solve.pipeline import solved
from tests.panel_host import StandInHost
from tests.plugins.polyhedron.drawn_bodies import fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS

SIZE = (90, 70)


def drawn(name: str, turned: bool = True) -> PolyhedronState:
    solid = OBJECTS[name]
    strokes = strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=9300)
    return new_body(PolyhedronState(), tuple(strokes), Choice() if turned else None)


@pytest.fixture(scope="module")
def house() -> PolyhedronState:
    return drawn("house")


def test_words_follow_confidence() -> None:
    words = [words_of(share) for share in np.linspace(0.0, 1.0, 201)]
    order = ["Unlikely", "Doubtful", "Perhaps", "Likely", "Almost certain"]
    assert list(dict.fromkeys(words)) == order


def test_pictures_are_of_all_answers_and_differ(house: PolyhedronState) -> None:
    gallery = gallery_of(house, LIGHT, SIZE)
    found = solved(house.nodes[0], house)
    assert gallery.chosen == found.number == 0
    assert [each.share for each in gallery.pictures] == [
        each.confidence for each in found.answers[: len(gallery.pictures)]
    ]
    for each in gallery.pictures:
        assert each.pixels.shape == (SIZE[1], SIZE[0], 4)
        covered = (each.pixels[..., 3] > 0).mean()
        assert 0.1 < covered < 0.95
        assert not each.pixels[0, :, 3].any()
    first, second = (each.pixels.astype(float) for each in gallery.pictures[:2])
    assert np.abs(first - second).mean() > 1.0


def test_the_answer_turned_inside_out_is_among_them_and_says_so(house: PolyhedronState) -> None:
    words = [each.words for each in gallery_of(house, LIGHT, SIZE).pictures]
    assert words.count("Inside out") == 1


@pytest.mark.parametrize("name", ["house", "L", "box"])
def test_a_picture_says_the_same_whichever_is_chosen(name: str) -> None:
    """The likeliest one lost its “Almost certain” as soon as its mirror image was chosen."""
    state = drawn(name)
    count = len(solved(state.nodes[0], state).answers)
    said = []
    for number in range(count):
        shown = gallery_of(with_answer(state, state.nodes[0], number), LIGHT, SIZE)
        assert shown.chosen == number
        said.append({each.number: each.words for each in shown.pictures})
    for words in said:
        assert all(words[number] == each for number, each in said[0].items())


def test_pictures_follow_the_theme(house: PolyhedronState) -> None:
    light, dark = (gallery_of(house, theme, SIZE).pictures[0].pixels for theme in (LIGHT, DARK))
    assert (light != dark).any()


def test_a_drawing_without_answers_says_what_to_do() -> None:
    state = drawn("box", turned=False)
    body = state.nodes[0]
    open_one = new_body(PolyhedronState(), tuple(body.strokes)[:3], None)
    for each in (PolyhedronState(), open_one):
        gallery = gallery_of(each, LIGHT, SIZE)
        assert gallery.pictures == ()
        assert gallery.sentence.endswith(".")


def test_a_touch_on_a_picture_chooses_that_answer(qtbot, house: PolyhedronState) -> None:
    holder = QWidget()
    qtbot.addWidget(holder)
    host = StandInHost(house)
    panel = AnswersPanel(host, holder)
    qtbot.waitUntil(lambda: bool(panel.cards) and not panel.busy, timeout=10_000)
    assert [card.isChecked() for card in panel.cards].index(True) == 0
    panel.cards[1].click()
    assert host.labels == ["Choose an answer"]
    body = host.state.nodes[0]
    assert solved(body, host.state).number == 1
    qtbot.waitUntil(lambda: not panel.busy, timeout=10_000)
    assert [card.isChecked() for card in panel.cards].index(True) == 1


def test_the_window_shows_the_answers_of_a_drawing(window) -> None:
    solid = OBJECTS["box"]
    window.open("polyhedron")
    window.draw(*strokes_of(fitted(solid), solid.edges, jitter=1.5, seed=9200))
    panel = window.window.findChild(AnswersPanel, "answers")
    assert panel is not None
    window.wait_until(lambda: len(panel.cards) > 1 and not panel.busy)
    panel.cards[1].click()
    window.settle()
    body = window.state.nodes[0]
    assert solved(body, window.state).number == 1
    assert "solid" in {layer.name for layer in window.shown().layers}
    window.undo()
    assert window.state.nodes[0].choice is None
