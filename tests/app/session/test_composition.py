"""The session is a composition: few names, no base class of ours, and parts that stand alone."""

from __future__ import annotations

import gc
import threading

import pytest
from PySide6.QtCore import QObject

from bozzetto.plugin.host.registry import Registry
from bozzetto_app.session.session import Session
from tests.app.tablet import circle, stroke_of

MOST = 25


@pytest.fixture
def session(qapp, _tidy):
    made = Session(Registry(no_plugins=True))
    yield made
    made.cancel_all()


def public(session):
    """The names that a session adds to those of Qt's object."""
    names = {*dir(session), *vars(session)} - set(dir(QObject))
    return {name for name in names if not name.startswith("_")}


def test_a_session_has_few_public_names_and_no_base_class_of_ours(session):
    assert len(public(session)) <= MOST, sorted(public(session))
    assert Session.__mro__[1] is QObject


def test_no_part_holds_the_session(session):
    """A part may be Qt's child of the session; it has no reference of its own to it."""
    parts = [getattr(session, name) for name in public(session)]
    holders = [
        type(part).__name__
        for part in parts
        if hasattr(part, "__dict__") and any(value is session for value in vars(part).values())
    ]
    assert holders == []


def test_workers_start_from_what_the_window_had_when_their_turn_came(
    make_session, boxes, settle, monkeypatch
):
    """While a worker runs, the window's state is read on the window's thread only."""
    session = make_session(draw_with=boxes.id, extra=[boxes.package])
    window, strangers = threading.get_ident(), []
    kinds = (type(session.selection), type(session.drawing))
    for kind, name in ((kinds[0], "model"), (kinds[1], "document"), (kinds[1], "pending")):
        read = vars(kind)[name].fget

        def watched(self, read=read, name=name):
            if threading.get_ident() != window:
                strangers.append(name)
            return read(self)

        monkeypatch.setattr(kind, name, property(watched))
    for radius in (100.0, 60.0):
        session.gestures.stroke_lifted(stroke_of(circle(radius=radius), session.view.camera))
    settle(session)
    session.objects.set_parameter("size", 42.0, dragging=True)
    session.objects.end_drag()
    settle(session)
    assert len(session.drawing.document)
    assert strangers == []
    gc.collect()
