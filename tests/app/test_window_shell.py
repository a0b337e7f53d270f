"""The window for tests of plugins: drawn, dragged, tapped and read in few words."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from bozzetto.errors import UserError
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene.display_list import Lines
from bozzetto.testing import Pen
from bozzetto_app.testing.window_shell import CANVAS, WindowShell

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "bozzetto_ribbon"
PEN = Pen()


@pytest.fixture
def ribbons(qapp, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLE)
    shell = WindowShell(Registry(extra=["bozzetto_ribbon"]), tmp_path)
    shell.open("ribbon")
    yield shell
    shell.close()
    for name in [name for name in sys.modules if name.partition(".")[0] == "bozzetto_ribbon"]:
        del sys.modules[name]


def test_a_ribbon_is_drawn_moved_and_taken_away(ribbons):
    canvas = ribbons.window.canvas
    assert (canvas.width(), canvas.height()) == CANVAS
    assert ribbons.hint.startswith("Draw a stroke")
    assert ribbons.state is None
    ribbons.draw(PEN.along([(300, 450), (900, 450)]))
    (band,) = ribbons.state.bands
    assert len(ribbons.shapes().surfaces) == 1
    ribbons.take("move")
    assert ribbons.hint.startswith("Drag the dot")
    ribbons.drag("0", PEN.along([(300, 440), (300, 350)]))
    (moved,) = ribbons.state.bands
    assert moved.shift[2] > 0.0
    assert moved.stroke == band.stroke
    with pytest.raises(UserError, match="there are: 0"):
        ribbons.drag("7", PEN.along([(0, 0), (9, 9)]))
    ribbons.press("Ctrl+Z")
    assert ribbons.state.bands == (band,)
    ribbons.take("erase")
    ribbons.tap(600, 200)
    assert "no ribbon here" in " ".join((*ribbons.notices, ribbons.hint))
    ribbons.tap(600, 450)
    assert ribbons.state.bands == ()
    ribbons.undo()
    assert ribbons.state.bands == (band,)


def test_a_preview_is_seen_while_the_pen_is_down(ribbons):
    ribbons.draw(PEN.along([(300, 450), (700, 500)]), lift=False)

    def preview():
        return [
            i for layer in ribbons.shown().layers if layer.name == "preview" for i in layer.items
        ]

    ribbons.wait_until(lambda: bool(preview()))
    assert isinstance(preview()[0], Lines)
