"""The fake sessions promise nothing that the real one does not have."""

from __future__ import annotations

import inspect
from operator import attrgetter

import pytest
from PySide6.QtCore import Signal

from bozzetto.plugin.host.registry import Registry
from bozzetto_app.session.session import Session
from tests.app.fake_session import PARTS


@pytest.fixture
def real(qapp, _tidy):
    session = Session(Registry(no_plugins=True))
    yield session
    session.cancel_all()


@pytest.mark.parametrize("name", PARTS)
def test_what_widgets_call_and_listen_to_is_there(real, name):
    part, fake = attrgetter(name)(real), PARTS[name]
    own = {key for key, kind in vars(fake).items() if isinstance(kind, Signal)}
    assert all(hasattr(part, key) for key in own)
    assert all(callable(getattr(part, key, None)) for key in fake.recorded.split())


@pytest.mark.parametrize(
    ("part", "name"),
    [("objects", "set_parameter"), ("objects", "set_underlay_opacity"), ("parts", "set_parameter")],
)
def test_arguments_agree(real, part, name):
    assert "dragging" in inspect.signature(getattr(getattr(real, part), name)).parameters
