"""The light above the sheet: what it shows, where it lies, and what it lets through."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest

from bozzetto.plugin import ViewAdvice
from bozzetto.scene import DARK, LIGHT
from bozzetto.view.camera import Camera
from bozzetto_car.template.loader import TEMPLATES, bundled

TURNED = Camera(eye=(300.0, -400.0, 200.0))


def pixels(widget):
    picture = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), -1)
    return rows[:, : 3 * picture.width()].reshape(picture.height(), picture.width(), 3).astype(int)


def test_nothing_is_shown_without_advice(canvas):
    assert not canvas.light.isVisible()
    assert not canvas.light.button.isVisible()


def test_it_lies_at_the_top_centre_and_keeps_off_the_cube(canvas, session):
    session.advice.say(ViewAdvice("good", "words " * 200, TURNED))
    place = canvas.light.geometry()
    assert canvas.light.isVisible()
    assert abs(place.center().x() - canvas.rect().center().x()) <= 1
    assert not place.intersects(canvas.cube.geometry())
    assert place.contains(canvas.light.button.geometry())
    assert canvas.light.words.endswith("…")


@pytest.mark.parametrize("extra", range(1, 120, 3))
def test_the_first_sentence_stands_alone_where_there_is_no_room_for_more(canvas, session, extra):
    message = f"Lines run towards each other. Turn {'i' * extra} down: 2.7 times more exact."
    session.advice.say(ViewAdvice("warn", message, TURNED))
    assert canvas.light.words in (message, "Lines run towards each other.")


@pytest.mark.parametrize("width", range(300, 700, 37))
def test_a_sentence_is_whole_on_a_narrow_sheet(canvas, session, width):
    """On 300 px it was cut to "Only one…", which says nothing."""
    said = "Only one line is drawn of this face: draw the others, or take it away"
    canvas.resize(width, 400)
    session.advice.say(ViewAdvice("warn", f"{said}. Turn for more.", TURNED))
    place = canvas.light.geometry()
    assert canvas.light.words.startswith(said)
    assert canvas.rect().contains(place)
    assert place.contains(canvas.light.button.geometry())
    assert not place.intersects(canvas.cube.geometry())


@pytest.mark.parametrize("words", range(3, 14))
@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0])
def test_what_has_room_in_one_line_is_drawn_in_one(canvas, session, words, scale):
    """Advances are no whole pixels: the last word went to a second line, beyond the chip."""
    said = " ".join(["Draw", "a", "line", "on", "the", "body,", "from", "any", "side."] * 2)
    said = " ".join(said.split()[:words])
    session.advice.say(ViewAdvice("good", said))
    light = canvas.light
    assert light.words == said
    picture = QImage(
        round(scale * light.width()), round(scale * light.height()), QImage.Format.Format_RGB888
    )
    picture.setDevicePixelRatio(scale)
    picture.fill(Qt.GlobalColor.white)
    light.render(picture)
    rows = np.frombuffer(picture.constBits(), np.uint8).reshape(picture.height(), -1)
    rows = rows[:, : 3 * picture.width()].reshape(picture.height(), picture.width(), 3)
    inside = rows[:, round(36 * scale) : -round(16 * scale)].astype(int)
    dark = np.flatnonzero((inside.sum(axis=2) < 300).any(axis=1)) / scale
    assert len(dark)
    assert np.ptp(dark) < light.fontMetrics().height()


def test_what_a_point_of_a_car_is_called_has_room(canvas, session):
    """On a sheet of 1100 px, as in a window of 1600, none of the 400 points is cut short."""
    canvas.resize(1100, 800)
    for template in map(bundled, TEMPLATES):
        for prompt in template.prompts.values():
            session.advice.say(ViewAdvice("good", f"Touch: {prompt}, on the near side."))
            assert not canvas.light.words.endswith("…"), prompt


def test_it_makes_way_for_what_covers_the_left(canvas, session):
    session.advice.say(ViewAdvice("good", "Fine"))
    before = canvas.light.geometry().center().x()
    canvas.leave_room(200)
    assert canvas.light.geometry().center().x() == pytest.approx(before + 100, abs=1)


def test_the_button_is_there_only_for_a_better_view(canvas, session):
    session.advice.say(ViewAdvice("warn", "Flat"))
    assert not canvas.light.button.isVisible()
    session.advice.say(ViewAdvice("warn", "Flat", TURNED))
    assert canvas.light.button.isVisible()
    session.advice.say(None)
    assert not canvas.light.button.isVisible()


def test_a_click_on_the_button_turns_and_does_not_draw(canvas, session):
    canvas.motion.reduced = True
    session.advice.say(ViewAdvice("warn", "Flat", TURNED))
    QTest.mouseClick(canvas.light.button, Qt.MouseButton.LeftButton)
    assert session.view.camera.eye == TURNED.eye
    assert session.view.camera.viewport == (canvas.width(), canvas.height())
    assert session.strokes == []


def test_ink_begins_on_the_words(canvas, session):
    """The chip itself is no obstacle: what lies under the pen there is the sheet."""
    session.advice.say(ViewAdvice("warn", "Flat", TURNED))
    place = canvas.light.geometry()
    under = canvas.childAt(place.left() + 20, place.center().y())
    assert under is not canvas.light
    assert under is None or under in [v.widget for v in [canvas.viewports.current]]
    assert canvas.childAt(canvas.light.button.geometry().center()) is canvas.light.button


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
def test_levels_differ_in_shape_and_not_only_in_colour(canvas, session, palette):
    """As grey pictures of equal mean brightness, no two lamps look alike."""
    canvas.set_palette(palette)
    masks = {}
    for level in ("good", "warn", "refuse"):
        session.advice.say(ViewAdvice(level, "x"))
        lamp = pixels(canvas.light)[6:24, 10:26]
        ground = pixels(canvas.light)[4, 30]
        masks[level] = np.abs(lamp - ground).max(axis=2) > 60
    for one, other in (("good", "warn"), ("warn", "refuse"), ("good", "refuse")):
        assert (masks[one] ^ masks[other]).sum() > 10, (one, other)


def test_it_says_what_it_shows_to_a_screen_reader(canvas, session):
    session.advice.say(ViewAdvice("refuse", "3° to the plane"))
    assert "3° to the plane" in canvas.light.accessibleName()
    assert "No view" in canvas.light.accessibleName()
