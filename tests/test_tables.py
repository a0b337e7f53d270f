"""The programs that fill the tables of the documentation, and the tables themselves."""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bozzetto.cli import COMMANDS
from tests import fidelity
from tests.benchmarks import __main__ as benchmarks
from tests.benchmarks import bench_export
from tests.benchmarks.timing import Row, in_turn

DOCS = Path(__file__).parents[1] / "docs"
ROOMS = sorted(path.stem for path in Path(benchmarks.__file__).parent.glob("bench_*.py"))


# -- benchmarks ------------------------------------------------------------------------------------


@pytest.mark.parametrize("room", ROOMS)
def test_every_room_has_rows(room: str) -> None:
    assert callable(importlib.import_module(f"tests.benchmarks.{room}").rows)


def test_one_small_room_fills_the_page(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = list(bench_export.rows(triangles=200))
    monkeypatch.setattr(bench_export, "rows", lambda: iter(small))
    monkeypatch.setattr(benchmarks, "HERE", tmp_path)
    (tmp_path / "bench_export.py").touch()
    monkeypatch.setattr(benchmarks, "DOCUMENT", tmp_path / "performance.md")
    assert benchmarks.main(["--write"]) == 0
    page = (tmp_path / "performance.md").read_text()
    assert capsys.readouterr().out.strip() in page
    for title in ("STL", "3MF", "glTF", "OBJ", "PLY"):
        assert re.search(rf"\| export \| [^|]*{title}[^|]*\| [\d.e+-]+ ms \|", page)


def test_part_of_the_rooms_never_replaces_the_page() -> None:
    with pytest.raises(SystemExit):
        benchmarks.main(["export", "--write"])
    with pytest.raises(SystemExit):
        benchmarks.main(["nowhere"])


def test_a_ratio_says_how_many_times_faster_we_are() -> None:
    row = Row("room", "what", 2.0, alternative="slower", other=10.0)
    assert row.cells()[-1] == "5.0×"
    assert Row("room", "what", 2.0).cells()[-2:] == ("", "")


def test_works_are_timed_in_turn() -> None:
    calls: list[str] = []
    times = in_turn(lambda: calls.append("a"), lambda: calls.append("b"), repeats=2, warm_up=1)
    assert calls == ["a", "b"] * 3
    assert len(times) == 2
    assert min(times) >= 0.0


# -- documents -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["performance.md", "fidelity.md"])
def test_commands_of_the_tables_exist(name: str) -> None:
    text = (DOCS / name).read_text(encoding="utf-8")
    modules = re.findall(r"python -m ([\w.]+)", text)
    assert modules
    for module in modules:
        assert importlib.util.find_spec(module) is not None
    for command in re.findall(r"`bozzetto (\w+)", text):
        assert command in COMMANDS


def test_the_page_on_performance_is_of_all_rooms() -> None:
    text = (DOCS / "performance.md").read_text(encoding="utf-8")
    assert "| " + " | ".join(benchmarks.HEADINGS) + " |" in text
    found = set(re.findall(r"^\| (\w+) \|", text, re.MULTILINE)) - {"Room"}
    assert {f"bench_{room}" for room in found} == set(ROOMS)


def test_the_page_on_fidelity_is_of_all_committed_outlines() -> None:
    text = (DOCS / "fidelity.md").read_text(encoding="utf-8")
    for case in fidelity.cases([fidelity.ROOT / "tests" / "data" / "silhouettes"]):
        assert f"\n| {case.name} | " in text


# -- the oracle of the fidelity table --------------------------------------------------------------

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (-1, 1) for z in (0, 1)], float)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FACES = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))], np.int64)


def torus(count: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """A ring of radius 3 about the y axis, of radius 1 in section."""
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    u, v = 2 * np.pi * i / count, 2 * np.pi * j / count
    points = np.stack(
        ((3 + np.cos(v)) * np.cos(u), np.sin(v), (3 + np.cos(v)) * np.sin(u)), axis=-1
    )
    a, b = i * count + j, (i + 1) % count * count + j
    c, d = (i + 1) % count * count + (j + 1) % count, i * count + (j + 1) % count
    faces = np.concatenate((np.stack((a, c, b), -1), np.stack((a, d, c), -1))).reshape(-1, 3)
    return points.reshape(-1, 3), faces.astype(np.int64)


def test_oracle_counts_handles_and_bodies() -> None:
    points, faces = torus()
    assert fidelity.topology(FACES) == (0, 1)
    assert fidelity.topology(faces) == (1, 1)
    both = np.concatenate((faces, FACES + len(points)))
    assert fidelity.topology(both) == (1, 2)
    assert fidelity.is_closed(both)


def test_oracle_sees_holes_and_turned_faces() -> None:
    assert fidelity.is_closed(FACES)
    assert not fidelity.is_closed(FACES[1:])
    turned = FACES.copy()
    turned[0] = turned[0, ::-1]
    assert not fidelity.is_closed(turned)
    assert fidelity.volume(CUBE + 1e4, FACES) == pytest.approx(2.0)
    assert fidelity.volume(CUBE, FACES[:, ::-1]) == pytest.approx(-2.0)


def test_oracle_projects_along_y() -> None:
    seen = fidelity.shadow(CUBE * [3.0, 1.0, 2.0], FACES)
    assert seen.bounds == pytest.approx((0.0, 0.0, 3.0, 2.0))
    assert seen.area == pytest.approx(6.0)
    points, faces = torus(48)
    ring = fidelity.shadow(points, faces)
    assert len(ring.interiors) == 1
    assert ring.area == pytest.approx(np.pi * (16 - 4), rel=0.01)


def test_oracle_measures_distances_both_ways() -> None:
    square = fidelity.even_odd([np.array([[0, 0], [10, 0], [10, 10], [0, 10.0]])])
    notched = fidelity.even_odd(
        [np.array([[0, 0], [10, 0], [10, 10], [6, 10], [5, 7], [4, 10], [0, 10.0]])]
    )
    assert fidelity.hausdorff(square, notched, 0.01) == pytest.approx(3.0, abs=0.02)
    assert fidelity.hausdorff(notched, square, 0.01) == pytest.approx(3.0, abs=0.02)
    assert fidelity.hausdorff(square, square, 0.1) == 0.0


def test_oracle_sees_asymmetry() -> None:
    assert fidelity.asymmetry(CUBE) == 0.0
    assert fidelity.asymmetry(CUBE + np.array([0.0, 0.01, 0.0])) == pytest.approx(0.01)


def test_oracle_merges_corners_by_their_bits(tmp_path: Path) -> None:
    corners = CUBE[FACES].astype("<f4")
    corners[corners == 0.0] *= -1.0  # zeros of either sign are one place
    corners[0] = np.abs(corners[0]) * np.sign(CUBE[FACES][0] + 0.5)
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *c.ravel(), 0) for c in corners)
    path = tmp_path / "cube.stl"
    path.write_bytes(bytes(80) + struct.pack("<I", len(FACES)) + records)
    vertices, faces = fidelity.read_stl(path)
    assert len(vertices) == 8
    assert fidelity.is_closed(faces)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(ValueError, match="promised"):
        fidelity.read_stl(path)


def test_one_outline_is_measured_through_the_command_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert fidelity.main(["heart"]) == 0
    said = capsys.readouterr().out
    row = next(line for line in said.splitlines() if line.startswith("| heart |"))
    assert re.match(r"\| heart \| 0\.99\d+ \| 0\.\d+ % \| 0 / 0 \| 1 / 1 \| yes \|", row)


# -- threads ---------------------------------------------------------------------------------------


def test_the_program_asks_for_one_thread_before_numpy_is_there() -> None:
    code = (
        "import os, sys; from bozzetto_app.__main__ import ONE_THREAD, main\n"
        "assert 'numpy' not in sys.modules\n"
        "assert main(['plugins']) == 0\n"
        "assert [os.environ[name] for name in ONE_THREAD] == ['3', '1'], os.environ\n"
    )
    first, second = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
    environment = {k: v for k, v in os.environ.items() if k != second}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**environment, first: "3"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
