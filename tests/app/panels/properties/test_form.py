"""The form: made from annotations, and calling the session rightly."""

from __future__ import annotations

from dataclasses import replace
from time import monotonic

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QLabel, QLineEdit

from bozzetto.document.model import Model, OpaqueState, new_id
from bozzetto.parameters import parameter_fields
from bozzetto.plugin.host.registry import Registry
from bozzetto_app.panels.properties import form
from bozzetto_app.panels.properties.form import ParametersPanel
from bozzetto_app.panels.properties.parameter_row import ParameterRow
from bozzetto_app.session.selection import why_locked
from bozzetto_app.settings import settings
from bozzetto_app.widgets.choice import ChoiceBox, Segments
from bozzetto_app.widgets.number_field import NumberField
from bozzetto_app.widgets.section import Section
from bozzetto_app.widgets.slider import Slider
from bozzetto_app.widgets.swatch import chart
from bozzetto_app.widgets.toggle import Toggle
from tests.app import fake_session as fakes
from tests.app.seen import button


@pytest.fixture
def panel(qtbot, fake_session):
    made = ParametersPanel(fake_session)
    qtbot.addWidget(made)
    made.resize(264, 800)
    made.show()
    return made


def form_of(panel):
    """The form once all of its rows are made."""
    end = monotonic() + 10.0
    while not panel.is_ready and monotonic() < end:
        QTest.qWait(1)
    assert panel.is_ready
    return panel.form


def row(panel, name, owner="") -> ParameterRow:
    return form_of(panel).rows[owner, name]


def settings_made(session):
    return [
        (*args, kwargs["dragging"]) for args, kwargs in session.calls.named("objects.set_parameter")
    ]


def test_every_kind_has_its_control(panel, fake_session):
    kinds = {
        "inflation": (NumberField, Slider),
        "parts": (NumberField, Slider),
        "mirrored": (Toggle,),
        "ends": (Segments,),
        "material": (ChoiceBox,),
        "note": (QLineEdit,),
        "tolerance": (NumberField,),
    }
    for name, controls in kinds.items():
        for control in controls:
            assert row(panel, name).findChild(control) is not None, (name, control)
    assert row(panel, "tolerance").findChild(Slider) is None, "it has no upper end"
    assert len(panel.findChildren(ParameterRow)) == len(fake_session.objects.parameters)


def test_values_are_shown(panel):
    assert row(panel, "length").findChild(NumberField).text() == "120 mm"
    assert row(panel, "mirrored").findChild(Toggle).isChecked()
    assert row(panel, "ends").findChild(Segments).value == "round"
    assert row(panel, "material").findChild(ChoiceBox).value == "clay"


def test_a_slider_drag_is_one_step(panel, fake_session):
    slider = row(panel, "length").findChild(Slider)
    y = slider.height() // 2
    QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=QPoint(20, y))
    for x in range(20, 120, 10):
        QTest.mouseMove(slider, QPoint(x, y))
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=QPoint(120, y))
    made = settings_made(fake_session)
    assert len(made) >= 2, "the first at once, the last at the end"
    assert all(going for *_, going in made)
    assert len(fake_session.calls.named("objects.end_drag")) == 1
    assert fake_session.calls.made[-1][0] == "objects.end_drag"
    assert fake_session.state.length == made[-1][1]
    assert fake_session.state.length % 1 == 0, "it keeps to the steps"


def test_keys_on_a_slider_are_steps_of_their_own(panel, fake_session):
    slider = row(panel, "parts").findChild(Slider)
    slider.setFocus()
    QTest.keyClick(slider, Qt.Key.Key_Right)
    QTest.keyClick(slider, Qt.Key.Key_End)
    assert settings_made(fake_session) == [("parts", 4, False), ("parts", 12, False)]
    assert isinstance(fake_session.state.parts, int)


def test_the_slider_catches_the_default(panel, fake_session):
    fake_session.objects.set_parameter("inflation", 0.3)
    slider = row(panel, "inflation").findChild(Slider)
    middle = slider.width() // 2
    QTest.mouseClick(slider, Qt.MouseButton.LeftButton, pos=QPoint(middle + 1, 8))
    assert fake_session.state.inflation == 1.0


def test_a_switch_and_choices_call_once(panel, fake_session):
    row(panel, "mirrored").findChild(Toggle).click()
    segments = row(panel, "ends").findChild(Segments)
    button(segments, "Flat").click()
    box = row(panel, "material").findChild(ChoiceBox)
    box.setCurrentIndex(2)
    box.activated.emit(2)
    assert settings_made(fake_session) == [
        ("mirrored", False, False),
        ("ends", "flat", False),
        ("material", "wax", False),
    ]


def test_text_is_taken_when_it_is_finished(panel, fake_session):
    text = row(panel, "note").findChild(QLineEdit)
    text.setFocus()
    QTest.keyClicks(text, "left ear")
    assert settings_made(fake_session) == []
    QTest.keyClick(text, Qt.Key.Key_Return)
    text.clearFocus()
    assert settings_made(fake_session) == [("note", "left ear", False)]


def test_a_double_click_on_the_words_restores_the_default(panel, fake_session):
    fake_session.objects.set_parameter("length", 200.0)
    fake_session.calls.made.clear()
    words = row(panel, "length").words
    QTest.mouseDClick(words, Qt.MouseButton.LeftButton)
    assert settings_made(fake_session) == [("length", 120.0, False)]


def test_a_changed_value_is_marked_and_can_be_put_back(panel, fake_session):
    assert row(panel, "length").reset.isHidden()
    fake_session.objects.set_parameter("length", 200.0)
    reset = row(panel, "length").reset
    assert not reset.isHidden()
    reset.click()
    assert fake_session.state.length == 120.0
    assert reset.isHidden()


def test_help_shows_on_hover(panel):
    assert "swells" in row(panel, "inflation").words.toolTip()


def test_what_changes_nothing_is_switched_off_and_says_why(panel, fake_session):
    idle = row(panel, "parts")
    number = idle.findChild(NumberField)
    help_ = number.toolTip()
    assert idle.isEnabled()
    fake_session.objects.set_parameter("ends", "open")
    assert not idle.isEnabled()
    assert not number.isEnabled()
    for widget in (idle, idle.words, number):
        assert widget.toolTip() == "“Parts” changes nothing while “Ends” is “Open”."
    assert row(panel, "ends").isEnabled()
    fake_session.objects.set_parameter("ends", "flat")
    assert number.isEnabled()
    assert number.toolTip() == help_
    assert not idle.toolTip()


def test_advanced_is_folded_and_remembered(qtbot, panel, fake_session):
    form_of(panel)
    (section,) = (s for s in panel.findChildren(Section) if s.findChildren(ParameterRow))
    inside = [r.field.name for r in section.findChildren(ParameterRow)]
    assert inside == ["resolution", "tolerance"]
    assert not section.is_open
    button(section, "Advanced").click()
    again = ParametersPanel(fake_session)
    qtbot.addWidget(again)
    form_of(again)
    assert any(s.is_open and s.findChildren(ParameterRow) for s in again.findChildren(Section))


def test_changing_values_keeps_the_controls(panel, fake_session):
    before = row(panel, "length")
    fake_session.objects.set_parameter("length", 33.0)
    assert row(panel, "length") is before


def test_another_selection_makes_another_form(panel, fake_session):
    fake_session.selection.id = None
    fake_session.selection.changed.emit()
    assert form_of(panel).rows == {}
    assert "Draw or choose an object" in words(panel)


def choose(session, model_id):
    session.selection.id = model_id
    session.selection.changed.emit()


def test_a_form_is_there_again_with_the_values_and_folds_of_now(panel, fake_session):
    before, chosen = form_of(panel), fake_session.selection.id
    (section,) = (s for s in panel.findChildren(Section) if s.findChildren(ParameterRow))
    button(section, "Advanced").click()
    panel.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    panel.setFocus()
    choose(fake_session, None)
    assert not before.isVisible()
    settings().setValue("panels/advanced", False)  # another form's was folded
    choose(fake_session, chosen)
    fake_session.objects.set_parameter("length", 41.0)
    assert form_of(panel) is before
    assert before.isVisible()
    assert not section.is_open
    assert row(panel, "length").findChild(NumberField).value() == 41.0
    QTest.mouseClick(row(panel, "mirrored").findChild(Toggle), Qt.MouseButton.LeftButton)
    assert len(settings_made(fake_session)) == 2, "once each"


def test_a_form_in_which_something_is_typed_or_dragged_is_not_kept(panel, fake_session):
    chosen = fake_session.selection.id
    panel.activateWindow()
    typed = form_of(panel)
    row(panel, "note").findChild(QLineEdit).setFocus()
    is_in_use = QApplication.focusWidget() is not None
    choose(fake_session, None)
    choose(fake_session, chosen)
    assert (form_of(panel) is typed) != is_in_use
    dragged = form_of(panel)
    fake_session.drawing.is_dragging = True
    choose(fake_session, None)
    fake_session.drawing.is_dragging = False
    choose(fake_session, chosen)
    assert form_of(panel) is not dragged


def test_a_locked_object_cannot_be_changed(panel, fake_session):
    fake_session.selection.id = "m4"
    fake_session.selection.changed.emit()
    assert not row(panel, "length").isEnabled()
    assert why_locked() in words(panel)
    models = tuple(replace(m, locked=False) for m in fake_session.drawing.document.models)
    fake_session.drawing.document = replace(fake_session.drawing.document, models=models)
    fake_session.drawing.changed.emit()
    assert row(panel, "length").isEnabled()


def test_a_parameter_can_be_brought_under_the_keyboard(qtbot, panel):
    panel.activateWindow()
    panel.focus_parameter("tolerance")
    assert row(panel, "tolerance").isVisible(), "its section was unfolded"
    assert panel.focusWidget() is row(panel, "tolerance").findChild(NumberField)
    panel.focus_parameter("no such parameter")
    for name, kind in (("mirrored", Toggle), ("material", ChoiceBox), ("note", QLineEdit)):
        panel.focus_parameter(name)
        assert panel.focusWidget() is row(panel, name).findChild(kind)
    panel.focus_parameter("ends")
    assert panel.focusWidget().accessibleName() == "Round"


# -- the chosen part ------------------------------------------------------------------------------


@pytest.fixture
def with_parts(panel, fake_session):
    fake_session.trees["m1"] = fakes.horse_parts()
    fake_session.drawing.changed.emit()
    return panel


def heading(panel):
    return form_of(panel).part.findChildren(QAbstractButton)[0].accessibleName()


def test_the_chosen_parts_form_stands_under_its_name(with_parts, fake_session):
    assert heading(with_parts) == "Head"
    assert row(with_parts, "inflation").isVisible(), "the model's own come first"
    softness = row(with_parts, "softness", "part")
    assert softness.isVisible()
    kernel = row(with_parts, "kernel", "part")
    assert not kernel.isVisible(), "advanced ones are folded"
    top = softness.mapTo(with_parts, softness.rect().topLeft()).y()
    own = row(with_parts, "note")
    assert top > own.mapTo(with_parts, own.rect().topLeft()).y()
    fake_session.trees["m1"] = fake_session.trees["m1"].renamed("n2", "Skull")
    fake_session.drawing.changed.emit()
    assert heading(with_parts) == "Skull"
    assert row(with_parts, "softness", "part") is softness, "a new name keeps the controls"


def test_another_part_has_another_form_and_none_has_none(with_parts, fake_session):
    fake_session.trees["m1"] = fake_session.trees["m1"].chosen("n5")
    fake_session.selection.changed.emit()
    assert heading(with_parts) == "Saddle pit"
    fake_session.trees["m1"] = fake_session.trees["m1"].chosen("")
    fake_session.selection.changed.emit()
    assert form_of(with_parts).part is None
    assert row(with_parts, "inflation").isVisible()


def test_a_part_of_the_same_kind_keeps_the_form_unless_somebody_types_in_it(
    qtbot, with_parts, fake_session
):
    """Every stroke may choose another part: making its form anew would stop the window."""

    def choose(part):
        fake_session.trees["m1"] = fake_session.trees["m1"].chosen(part)
        fake_session.selection.changed.emit()

    first = fake_session.parts.chosen
    fields = [field for field, _ in fake_session.parts.parameters]
    other = next(
        part
        for part in fake_session.trees["m1"].parts
        if part.id != first.id and type(part) is type(first)
    )
    form = form_of(with_parts)
    with_parts.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    with_parts.setFocus()
    choose(other.id)
    assert [field for field, _ in fake_session.parts.parameters] == fields
    assert form_of(with_parts) is form
    assert heading(with_parts) == other.name
    with_parts.activateWindow()
    next(iter(form_of(with_parts).rows.values())).words.buddy().setFocus()
    choose(first.id)
    assert (form_of(with_parts) is form) == (QApplication.focusWidget() is None)


def test_the_form_of_a_part_that_is_chosen_comes_into_sight(qtbot, with_parts, fake_session):
    """Whoever read the figures below and chooses another part must not look for its form."""

    def choose(part):
        fake_session.trees["m1"] = fake_session.trees["m1"].chosen(part)
        fake_session.selection.changed.emit()
        form_of(with_parts)
        qtbot.wait(20)

    def seen_at():
        return form_of(with_parts).part.mapTo(with_parts.viewport(), QPoint()).y()

    ids = [part.id for part in fake_session.trees["m1"].parts]
    with_parts.resize(264, 300)
    form_of(with_parts)
    qtbot.wait(20)
    bar = with_parts.verticalScrollBar()
    for away in (bar.maximum(), 0):
        bar.setValue(away)
        assert not 0 <= seen_at() < 260
        choose(next(one for one in ids if one != fake_session.parts.chosen.id))
        assert 0 <= seen_at() < 260
    bar.setValue(bar.value() - 40)
    there = bar.value()
    choose(next(one for one in ids if one != fake_session.parts.chosen.id))
    assert bar.value() == there, "it was in sight"


def test_a_colour_is_chosen_from_the_chart_or_taken_back(with_parts, fake_session):
    color = row(with_parts, "color", "part")
    swatch = color.words.buddy()
    assert "Clay" in swatch.accessibleName()
    popup = swatch.open_chart()
    wanted = dict(chart())["Slate"]
    button(popup, "Slate").click()
    assert fake_session.calls.named("parts.set_parameter") == [
        (("color", wanted), {"dragging": False})
    ]
    assert "Slate" in swatch.accessibleName()
    color.reset.click()
    assert fake_session.parts.chosen.color is None


def test_a_parts_parameter_can_be_brought_under_the_keyboard(with_parts):
    with_parts.focus_parameter("kernel")
    kernel = row(with_parts, "kernel", "part")
    assert kernel.isVisible()


def test_a_long_name_does_not_widen_the_panel(with_parts, fake_session):
    before = with_parts.widget().minimumSizeHint().width()
    fake_session.trees["m1"] = fake_session.trees["m1"].renamed("n2", "n" * 200)
    fake_session.drawing.changed.emit()
    assert with_parts.widget().minimumSizeHint().width() <= max(before, with_parts.width())


def test_a_part_with_a_long_name_in_the_report_does_not_widen_the_panel(panel, fake_session):
    long = " ".join(["a nose with a long name"] * 6)
    fake_session.solver.report = {
        "parts": [{"name": long, "genus": 0}, {"name": "<b>x</b>", "genus": 1}]
    }
    fake_session.solver.report_changed.emit()
    assert panel.widget().minimumSizeHint().width() <= panel.viewport().width()


def test_no_slider_of_a_bundled_modeler_jumps_by_more_than_what_is_usual(qtbot):
    """A limit that only keeps out nonsense makes no slider: a pixel of it would be metres."""
    registry = Registry()
    for info in registry.modelers():
        modeler = registry.modeler(info.id)
        for owner in (modeler.state_type, *getattr(modeler, "part_types", ())):
            for field in parameter_fields(owner):
                if field.kind not in ("number", "integer"):
                    continue
                made = ParameterRow(field)
                qtbot.addWidget(made)
                slider, number = made.findChild(Slider), made.findChild(NumberField)
                usual = abs(field.default) or 100.0
                if slider is not None:
                    span = field.parameter.maximum - field.parameter.minimum
                    assert span / 200.0 <= 2.5 * usual, (info.id, owner.__name__, field.name)
                step = number.step_at(float(field.default))
                assert step <= 0.2 * usual or step == 1.0, (info.id, owner.__name__, field.name)


# -- a form is made between two frames --


@pytest.fixture
def fresh(qtbot, fake_session, monkeypatch):
    """A function that makes panels whose forms come a row at a time."""
    monkeypatch.setattr(form, "SLICE", 0.0)

    def make():
        made = ParametersPanel(fake_session)
        qtbot.addWidget(made)
        made.show()
        return made

    return make


def test_a_form_comes_whole(fresh, fake_session):
    panel, seen = fresh(), []
    while not panel.is_ready:
        seen.append(len(panel.findChildren(ParameterRow)))
        QTest.qWait(1)
    assert set(seen) == {0}, "nothing that is half made is shown"
    assert len(seen) > 1
    assert len(panel.form.rows) == len(fake_session.objects.parameters)
    assert row(panel, "length").findChild(NumberField).text() == "120 mm"


def test_a_choice_that_changes_while_a_form_is_made_has_the_form_of_the_last(fresh, fake_session):
    chosen = fake_session.selection.id
    for turns in range(12):
        panel = fresh()
        for _ in range(turns):
            QTest.qWait(1)
        choose(fake_session, None)
        assert form_of(panel).rows == {}
        choose(fake_session, chosen)
        assert len(form_of(panel).rows) == len(fake_session.objects.parameters)
        shown = [each for each in panel.findChildren(form.Form) if each.isVisible()]
        assert shown == [panel.form]


def test_a_value_that_changes_while_its_form_is_made_is_the_one_that_is_shown(fresh, fake_session):
    panel = fresh()
    QTest.qWait(1)
    fake_session.objects.set_parameter("length", 41.0)
    assert row(panel, "length").findChild(NumberField).value() == 41.0


def test_a_parameter_is_brought_under_the_keyboard_though_its_form_is_not_there_yet(fresh):
    panel = fresh()
    panel.focus_parameter("length")
    assert panel.is_ready
    assert row(panel, "length").isVisible()


def words(panel):
    """All that is said in the panel now."""
    return " ".join(each.text() for each in panel.findChildren(QLabel) if not each.isHidden())


def test_an_object_whose_plugin_is_absent_says_so(qtbot, make_session):
    session = make_session()
    shown = ParametersPanel(session)
    qtbot.addWidget(shown)
    foreign = Model(new_id(), "Vase", "nobody.knows", OpaqueState(1, b"{}", (), ()))
    session.drawing.commit("Open", session.drawing.document.with_model(foreign))
    assert "Draw or choose" in words(shown)
    session.selection.select(foreign.id)
    said = words(shown)
    assert "its plugin is not installed" in said
    assert "nobody.knows" in said
