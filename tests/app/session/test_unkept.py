"""A disk without room, a folder that goes: a person is told once, and nothing drawn is lost."""

from __future__ import annotations

import errno
import os
import shutil

import numpy as np
import pytest

from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto_app.session.autosave import Keeper
from tests.app.tablet import circle, stroke_of
from tests.app.troublemaker import MODELER
from tests.disk_faults import watch


class Disk:
    """A disk that is full or not."""

    def __init__(self):
        self.problem = 0

    def before(self, name, size):
        if self.problem and name in ("write", "mkdir"):
            raise OSError(self.problem, os.strerror(self.problem))


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "recovery"


@pytest.fixture
def disk(folder):
    disk = Disk()
    with watch(folder, disk.before):
        yield disk


@pytest.fixture
def kept(make_session, boxes, folder, disk):
    session = make_session(MODELER, extra=[boxes.package])
    keeper = Keeper(session, folder)
    yield session, keeper
    disk.problem = 0
    keeper.close()
    keeper.wait()


@pytest.fixture
def draw(kept, settle):
    session, keeper = kept

    def draw(times=1):
        for _ in range(times):
            session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
            settle(session, keeper)

    return draw


def errors(session):
    return [notice.text for notice in session.heard if notice.kind == "error"]


def after_a_crash(session, keeper, folder, tmp_path):
    """Strokes that would be brought back if the process died now."""
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("lock"))
    store = RecoveryStore(copy)
    found = [store.recover(one, session.registry).document for one in store.crashed_sessions()]
    shutil.rmtree(copy)
    return sorted(sum(len(model.state.strokes) for model in document) for document in found)


@pytest.mark.parametrize("begun", [0, 2])
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO])
def test_a_full_disk_is_told_once_and_what_was_drawn_is_kept_when_there_is_room(
    kept, draw, disk, folder, tmp_path, begun, number
):
    session, keeper = kept
    draw(begun)
    disk.problem = number
    draw(4)
    (said,) = errors(session)
    assert str(folder) in said
    assert "Save the drawing" in said
    assert "journal" not in said
    files = [path.name for path in folder.rglob("*.b*")]
    assert len(files) <= 3, "leftovers of each attempt"
    disk.problem = 0
    draw()
    assert "safe from a crash again" in session.heard[-1].text
    assert after_a_crash(session, keeper, folder, tmp_path) == [begun + 5]
    disk.problem = number
    draw()
    assert len(errors(session)) == 2  # it happened again


@pytest.mark.parametrize("gone", ["all", "session", "journal"])
def test_recovery_data_that_were_deleted_are_written_anew(kept, draw, disk, folder, tmp_path, gone):
    session, keeper = kept
    draw(3)
    for path in {"all": [folder], "session": folder.iterdir()}.get(gone, ()):
        shutil.rmtree(path)
    if gone == "journal":
        for path in folder.rglob("journal-*"):
            path.unlink()
    draw()
    assert after_a_crash(session, keeper, folder, tmp_path) == [4]
    draw()
    assert after_a_crash(session, keeper, folder, tmp_path) == [5]
    assert errors(session) == []


def test_a_drawing_that_cannot_be_set_aside_is_not_said_to_be_kept(
    kept, draw, disk, folder, settle, tmp_path
):
    session, keeper = kept
    draw(2)
    disk.problem = errno.ENOSPC
    draw()
    session.files.new()
    settle(session, keeper)
    assert not [notice for notice in session.heard if "is kept" in notice.text]
    disk.problem = 0
    draw()
    assert [notice for notice in session.heard if "is kept" in notice.text]
    assert after_a_crash(session, keeper, folder, tmp_path) == [1, 3]


def test_paint_that_no_disk_held_comes_back_when_there_is_room(
    make_session, settle, folder, disk, tmp_path
):
    session = make_session("bozzetto.silhouette")
    keeper = Keeper(session, folder)
    camera = session.view.camera

    def drag(points, tool):
        session.toolbox.take_tool(tool)
        session.gestures.stroke_lifted(stroke_of(points, camera))
        settle(session, keeper)

    drag(circle(), "draw")
    middle = circle().mean(axis=0)
    across = np.linspace((-40.0, 0.0), (40.0, 0.0), 30)
    disk.problem = errno.ENOSPC
    for height in (-15.0, 0.0, 15.0):
        drag(middle + across + (0.0, height), "brush")
    assert len(errors(session)) == 1
    (model,) = session.drawing.document
    painted = model.state
    disk.problem = 0
    drag(middle + across + (0.0, 5.0), "brush")
    session.drawing.undo()
    settle(session, keeper)
    keeper.close()
    keeper.wait()
    store = RecoveryStore(folder)
    (crashed,) = store.crashed_sessions()
    (again,) = store.recover(crashed, session.registry).document
    assert again.state == painted
