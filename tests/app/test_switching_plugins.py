"""A plugin that is switched off: its modeler leaves the hand, its objects stay as they are."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel

from bozzetto.plugin.host.switched_off import switched_off
from bozzetto_app.settings import DISABLED_PLUGINS, disabled_plugins, settings
from tests.app.seen import names
from tests.app.tablet import circle, stroke_of


def told(session):
    return [notice.text for notice in session.heard if notice.kind == "info"]


def switch(window, plugin, on):
    """As the dialog does it."""
    window.session.registry.set_disabled(plugin, not on)
    window.dialogs.plugin_switched(plugin, on)


def test_a_modeler_that_is_switched_off_leaves_the_hand(make_window, settle):
    window = make_window()
    session = window.session
    plugin = session.registry.info(session.toolbox.modeler).plugin
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session, window.keeper)
    document, scene = session.drawing.document, session.scene.visible
    assert len(document) == 1
    switch(window, plugin, False)
    settle(session, window.keeper)
    other = session.toolbox.modelers[0]
    assert session.toolbox.modeler == other.id
    assert other.plugin != plugin
    assert session.toolbox.tools
    assert f"you draw with {other.title} now" in told(session)[-1]
    assert session.drawing.document is document
    assert [layer.name for layer in session.scene.visible.layers] == [
        layer.name for layer in scene.layers
    ]
    assert other.title in names(window.modelers)
    assert "Silhouette" not in names(window.modelers)
    switch(window, plugin, True)
    settle(session, window.keeper)
    assert "Silhouette" in names(window.modelers)
    assert session.toolbox.modeler == other.id


def test_the_form_of_what_is_switched_off_says_so_and_comes_back(make_window, settle, qtbot):
    window = make_window()
    session, form = window.session, window.docks.parameters
    plugin = session.registry.info(session.toolbox.modeler).plugin
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session, window.keeper)
    qtbot.waitUntil(lambda: form.is_ready)
    assert not form.form.isHidden()
    switch(window, plugin, False)
    qtbot.waitUntil(lambda: form.is_ready)
    assert form.form.isHidden()
    assert any("is switched off" in each.text() for each in form.findChildren(QLabel))
    switch(window, plugin, True)
    qtbot.waitUntil(lambda: form.is_ready)
    assert not form.form.isHidden()
    assert form.form.rows


def test_where_no_modeler_is_left_the_hand_is_empty(make_window, settle):
    window = make_window()
    session = window.session
    plugins = [info.plugin for info in session.toolbox.modelers]
    for plugin in plugins:
        switch(window, plugin, False)
    settle(session, window.keeper)
    assert session.toolbox.modeler == ""
    assert not session.toolbox.tools
    assert "no other modeler" in told(session)[-1]
    switch(window, plugins[0], True)
    settle(session, window.keeper)
    assert session.toolbox.modeler


def test_another_plugin_that_is_switched_off_changes_nothing(make_window, settle):
    window = make_window()
    before, heard = window.session.toolbox.modeler, len(told(window.session))
    switch(window, "bozzetto.car", False)
    assert window.session.toolbox.modeler == before
    assert len(told(window.session)) == heard


def test_what_the_window_kept_before_is_taken_over(qapp):
    settings().setValue(DISABLED_PLUGINS, ["a.one", "b.two"])
    assert disabled_plugins() == {"a.one", "b.two"}
    assert switched_off() is None
