from __future__ import annotations

import gc
import os
from time import monotonic

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from PySide6.QtCore import QEvent, QSettings
from PySide6.QtWidgets import QApplication

from tests import plugin_package


@pytest.fixture(autouse=True)
def _settings_apart(tmp_path):
    """No test reads or writes what the person's own program remembers."""
    QSettings.setPath(
        QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings")
    )


@pytest.fixture
def fake_session(qapp):
    from bozzetto_app.style.icons import FOLDER
    from tests.app.fake_session import FakeSession

    return FakeSession(FOLDER)


boxes = plugin_package.fixture_of("tests.app.troublemaker", "Boxes")
marks = plugin_package.fixture_of("tests.adviser", "Marks")
sketches = plugin_package.fixture_of("tests.tracer", "Sketches")
springs = plugin_package.fixture_of("tests.spring", "Springs")


# -- the real session and the real window ------------------------------------------------------

SETTLED = 30_000
"""How long work may take before a test gives up, ms; a loaded machine needs most of it."""

AT_ONCE = 0.2
"""Time in which most work is done, s: that long it is looked at every millisecond."""


@pytest.fixture
def settle(qtbot):
    """Wait until a session, and the keepers given, have nothing to do."""

    def wait(session, *keepers):
        def calm():
            return not session.busy and not any(keeper.busy for keeper in keepers)

        # Twice: an answer may be the reason for the next request. `waitUntil` looks every 10 ms,
        # and most answers take one or two: thousands of these waits are half a minute of the run.
        for _ in range(2):
            begun = monotonic()
            while not calm() and monotonic() - begun < AT_ONCE:
                qtbot.wait(1)
            qtbot.waitUntil(calm, timeout=SETTLED)
            qtbot.wait(2)

    return wait


@pytest.fixture(scope="module", autouse=True)
def _collect_here():
    """No garbage is collected in a worker's thread: it would take Qt objects along.

    What lives before a module begins (thousands of test items, libraries) is frozen: the
    collections after each test look at what that test left, not at everything.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    yield
    gc.enable()


@pytest.fixture
def _tidy(qapp):
    """Leave nothing of a session or window behind."""
    yield
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    gc.collect()


@pytest.fixture
def make_session(qtbot, settle, _tidy):
    """A function that makes sessions; `draw_with` is the modeler that is active at once."""
    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.session.session import Session

    made = []

    def make(draw_with="bozzetto.silhouette", extra=()):
        session = Session(Registry(extra=extra))
        session.heard = []
        session.notices.noticed.connect(session.heard.append)
        session.view.camera = session.view.camera.with_viewport(987.0, 727.0)
        session.toolbox.take_modeler(draw_with)
        settle(session)
        made.append(session)
        return session

    yield make
    for session in made:
        session.cancel_all()
        session.files.close()
        session.deleteLater()


@pytest.fixture
def make_window(qtbot, tmp_path, settle, _tidy):
    """A function that opens windows, each with a session of its own."""
    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.main_window import Window
    from bozzetto_app.session.session import Session

    made = []

    def make(draw_with="bozzetto.silhouette", extra=(), recovery=None):
        session = Session(Registry(extra=extra))
        session.heard = []
        session.notices.noticed.connect(session.heard.append)
        session.toolbox.take_modeler(draw_with)
        window = Window(session, recovery or tmp_path / "recovery")
        window.canvas.motion.reduced = True
        window.resize(1280, 800)
        window.show()
        qtbot.waitExposed(window)
        settle(session, window.keeper)
        made.append(window)
        return window

    yield make
    for window in made:
        window.close_without_asking()
        window.keeper.wait()
        window.deleteLater()
        window.session.deleteLater()


@pytest.fixture
def session(make_session, boxes):
    """A session that draws boxes: everything but the mathematics is real."""
    from tests.app.troublemaker import MODELER

    return make_session(MODELER, extra=[boxes.package])
