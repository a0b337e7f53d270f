"""Small files that ask for much, and files that are no files: refused or read, at a bounded cost.

The cost is processor time; what is compared are three sizes of one family, so that a slow or
busy machine changes nothing.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import time

import numpy as np
import pytest

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange import import_file as importing
from bozzetto.exchange.limits import Budget, at_most, budget_for, unlimited
from bozzetto.exchange.mesh.text_words import word_count
from bozzetto.exchange.read_files import read_bytes
from bozzetto.exchange.read_process import parent as reading_process
from bozzetto.geometry import Shapes
from bozzetto.testing.machine_speed import slowness
from tests.hostile_files import FAMILIES

SIZES = (20_000, 40_000, 80_000)

FREE = 0.3
"""Seconds below which growth is not looked at: start-up and the clock's own grain."""

GROWTH = 3.2
"""What twice the size may cost; twice is linear, and four times is not."""

PICTURES = (".png", ".tif", ".webp", ".jpg")
"""Their cost is of their pixels, which the size of the file says nothing of."""

HEAVY = (
    "all overlap", "two random", "a comb", "a star", "nodes without", "symbol times", "used",
    "blocks in blocks", "a block in", "a mesh in",
)  # fmt: skip
"""Words in the names of families whose small files already keep a machine busy for a second."""

OUTSIDE = (".step", ".iges")
"""Their kernel may end the process: it is asked only in one of its own, as the program does."""

MEASURED = [one for one in FAMILIES if one.ending not in (*PICTURES, *OUTSIDE)]
BOUNDED = [one for one in MEASURED if any(word in one.name for word in HEAVY)]
"""Most of them cost what their pairs do, up to a limit: more are refused with a sentence."""

AT_LIMIT = ("a comb", "blocks in blocks", "a block in", "a mesh in")
"""All boxes of a comb overlap: its cost grows with the square, up to that limit. Blocks in blocks
reach the limit of lines at every size."""

GROWING = [one for one in MEASURED if not any(word in one.name for word in AT_LIMIT)]

LARGE = 16 * SIZES[-1]


def seconds(family, size):
    """Processor time; of the slowest, where several readers take the ending."""
    data = family.make(size)
    taken = []
    for chosen in importing.readers():
        if family.ending not in chosen.endings:
            continue
        is_mesh, is_ink = (kind in chosen.holds for kind in ("mesh", "ink"))
        name = "read_shapes" if is_mesh else "read_drawing" if is_ink else "read_pixels"
        given = (data, "a") if name == "read_drawing" else (data,)
        started = time.process_time()
        with contextlib.suppress(UserError):
            importing.function(chosen, name)(*given)
        taken.append(time.process_time() - started)
    return max(taken)


def test_every_format_that_is_read_has_such_files():
    read = {one.endings[0] for one in importing.readers()}
    assert read <= {family.ending for family in FAMILIES}


@pytest.mark.slow
@pytest.mark.parametrize("family", GROWING, ids=lambda family: family.name)
def test_the_cost_grows_no_faster_than_the_file(family):
    if seconds(family, SIZES[-1]) < FREE:
        return
    first, second, third = (min(seconds(family, size) for _ in range(3)) for size in SIZES)
    assert third < max(FREE * slowness(), GROWTH * second, GROWTH**2 * first)


@pytest.mark.quiet
@pytest.mark.parametrize("family", BOUNDED, ids=lambda family: family.name)
def test_the_cost_of_pairs_is_bounded(family):
    assert all(seconds(family, size) < 5.0 * slowness() for size in (*SIZES, LARGE))


def test_a_reading_that_takes_too_long_is_ended(tmp_path):
    family = next(one for one in FAMILIES if one.name == "inkml traces of one sample")
    (tmp_path / "a.inkml").write_bytes(family.make(2_000_000))
    with pytest.raises(FormatError, match="1 seconds"):
        importing.read_in_child("drawing", tmp_path / "a.inkml", Budget(seconds=1))


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is limited on Linux")
def test_a_reading_that_takes_too_much_memory_is_refused(tmp_path):
    family = next(one for one in FAMILIES if one.name == "stl triangles without end")
    (tmp_path / "a.stl").write_bytes(family.make(32_000_000))
    with pytest.raises(FormatError, match="memory"):
        importing.read_in_child("mesh", tmp_path / "a.stl", Budget(megabytes=5))


def test_a_reading_is_ended_when_nobody_wants_it(tmp_path):
    class Enough(Exception):
        pass

    def enough():
        raise Enough

    family = next(one for one in FAMILIES if one.name == "inkml traces of one sample")
    (tmp_path / "a.inkml").write_bytes(family.make(2_000_000))
    with pytest.raises(Enough):
        importing.read_drawing(tmp_path / "a.inkml", checkpoint=enough)


@pytest.mark.parametrize(
    "family", [one for one in FAMILIES if one.ending in OUTSIDE], ids=lambda family: family.name
)
def test_a_kernel_that_falls_takes_nobody_along(tmp_path, family):
    path = tmp_path / f"a{family.ending}"
    path.write_bytes(family.make(SIZES[-1]))
    with pytest.raises(UserError):
        importing.read_mesh(path)


def test_a_trusted_file_has_no_limits_of_number(tmp_path):
    with pytest.raises(FormatError):
        at_most(2, 1, "things")
    with unlimited():
        at_most(2, 1, "things")
    family = next(one for one in FAMILIES if one.name == "svg transforms that overflow")
    content = family.make(200_000).replace(b"scale(1e9)", b"scale(1.0)")
    (tmp_path / "a.svg").write_bytes(content)
    with pytest.raises(FormatError, match="transforms"):
        importing.read_drawing(tmp_path / "a.svg")
    assert len(importing.read_drawing(tmp_path / "a.svg", trusted=True).strokes) == 1


@pytest.fixture
def started(monkeypatch):
    """The processes that are started, in order."""
    made, start = [], subprocess.Popen

    def noted(*asked, **more):
        made.append(start(*asked, **more))
        return made[-1]

    monkeypatch.setattr(subprocess, "Popen", noted)
    return made


def test_the_process_that_reads_is_used_again_and_replaced_when_it_is_gone(tmp_path, started):
    reading_process.end_idle()  # what others left may be about to end
    (tmp_path / "a.obj").write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    first = importing.read_mesh(tmp_path / "a.obj")
    importing.read_mesh(tmp_path / "a.obj")
    (kept,) = started
    kept.kill()
    kept.wait()
    again = importing.read_mesh(tmp_path / "a.obj")
    assert isinstance(first, Shapes)
    assert len(again.surfaces) == len(first.surfaces) == 1
    assert len(started) == 2


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is limited on Linux")
def test_a_large_program_reads_again_and_again_with_one_process(tmp_path, started):
    """The system counts what the starter takes into the child's largest memory."""
    large = np.ones(300 << 20, np.uint8)
    reading_process.end_idle()
    (tmp_path / "a.obj").write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    importing.read_mesh(tmp_path / "a.obj")
    importing.read_mesh(tmp_path / "a.obj")
    assert len(started) == 1
    assert large.all()


def test_larger_files_get_more_in_proportion():
    usual, large = budget_for(1), budget_for(256 << 20)
    assert (usual.seconds, usual.megabytes) == (Budget().seconds, Budget().megabytes)
    assert (large.seconds, large.megabytes) == (4 * usual.seconds, 4 * usual.megabytes)


def test_words_are_counted_as_split_finds_them():
    for text in (
        b"",
        b" ",
        b"a",
        b" a bb\n\nc ",
        b"a" * (1 << 20) + b"b c",
        b" " * (1 << 20) + b"a",
    ):
        assert word_count(text) == len(text.split())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are pipes with names")
def test_what_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "a.obj")
    (tmp_path / "b.obj").symlink_to("b.obj")
    (tmp_path / "c.obj").mkdir()
    (tmp_path / "d.obj").symlink_to("/dev/zero")
    for name in ("a.obj", "b.obj", "c.obj", "d.obj", "e.obj"):
        with pytest.raises(UserError) as told:
            importing.read_mesh(tmp_path / name)
        assert name in str(told.value)


def test_a_file_that_grows_is_read_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "a"
    path.write_bytes(b"one")
    size_of = os.fstat

    def growing(handle):
        found = size_of(handle)
        with path.open("ab") as file:
            file.write(b" more")
        return found

    monkeypatch.setattr(os, "fstat", growing)
    content = read_bytes(path, 100)
    assert content.startswith(b"one")
    assert len(content) <= 8


def test_a_refusal_shows_no_address_of_an_object(tmp_path):
    (tmp_path / "a.png").write_bytes(b"no picture")
    with pytest.raises(FormatError) as told:
        importing.read_image(tmp_path / "a.png")
    assert "0x" not in told.value.message
