"""The fake session promises nothing that the real one does not have."""

from __future__ import annotations

import inspect

from bozzetto_app.session.session import Notice, Session, ToolInfo


def test_what_panels_may_call_is_there(fakes):
    missing = {name for name in fakes.RECORDED if not callable(getattr(Session, name, None))}
    assert missing == set()


def test_arguments_agree():
    for name, keywords in (
        ("set_parameter", {"dragging"}),
        ("set_underlay_opacity", {"dragging"}),
        ("set_part_parameter", {"dragging"}),
    ):
        assert keywords <= set(inspect.signature(getattr(Session, name)).parameters), name


def test_signals_agree(fakes):
    from PySide6.QtCore import Signal

    fake = {name for name, kind in vars(fakes.FakeSession).items() if isinstance(kind, Signal)}
    assert fake <= {name for name in dir(Session) if isinstance(getattr(Session, name), Signal)}


def test_records_agree(fakes):
    for fake, real in ((fakes.Notice, Notice), (fakes.ToolInfo, ToolInfo)):
        assert set(fake.__dataclass_fields__) == set(real.__dataclass_fields__)
