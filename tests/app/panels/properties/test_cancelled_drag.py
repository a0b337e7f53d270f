"""A drag that Escape takes back, or that ends where it began, leaves nothing behind."""

from __future__ import annotations

import pytest

from bozzetto_app.testing.stylus import Stylus
from tests.app.tablet import circle


@pytest.fixture
def window(make_window, settle):
    window = make_window()
    Stylus(window.canvas).draw(circle(radius=60.0))
    settle(window.session, window.keeper)
    return window


def drags(window):
    """Return what is dragged, by name: a call with a value, and the values out and back."""
    session = window.session
    model = session.selection.model
    stands = model.placement
    moved = type(stands)(offset=(5.0, 0.0, 0.0))
    return {
        "of the object": (session.objects.set_parameter, "resolution", 48, model.state.resolution),
        "of a part": (session.parts.set_parameter, "inflation", 0.5, 1.0),
        "of the place": (session.objects.set_placement, model.id, moved, stands),
    }


@pytest.mark.parametrize("name", ["of the object", "of a part", "of the place"])
def test_a_drag_back_to_where_it_began_is_no_step(window, settle, name):
    session = window.session
    history = session.drawing.history
    entries, document = history.entries, session.drawing.document
    change, which, out, back = drags(window)[name]
    change(which, out, dragging=True)
    assert len(history.entries) == len(entries) + 1
    change(which, back, dragging=True)
    session.objects.end_drag()
    settle(session, window.keeper)
    assert history.entries == entries
    assert session.drawing.document is document
    change(which, out, dragging=True)
    session.objects.end_drag()
    settle(session, window.keeper)
    assert len(history.entries) == len(entries) + 1
    change(which, back, dragging=True)  # another drag, which begins elsewhere
    session.objects.end_drag()
    settle(session, window.keeper)
    assert len(history.entries) == len(entries) + 2
