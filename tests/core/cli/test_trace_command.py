"""``bozzetto trace``, as a person would use it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.images.png import write_png
from tests.core.ink.trace.pencil_paper import PHONE, TABLE, paper_picture
from tests.core.ink.trace.test_trace import SIZE, circle


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)

    def command(*words):
        capfd.readouterr()
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = end.code
        return code, capfd.readouterr().err

    return command


@pytest.fixture
def sketch(tmp_path):
    def made(conditions=PHONE):
        pixels, _ = paper_picture([circle(400, 300, 200)], SIZE, conditions, 8)
        write_png(tmp_path / "sketch.png", pixels)

    return made


def test_a_sketch_becomes_ink_and_the_ink_a_solid(run, sketch, tmp_path):
    sketch()
    code, said = run("trace", "sketch.png", "-o", "new/ink.json")
    assert code == 0
    assert "1 strokes, 1 of them closed" in said
    ink = json.loads((tmp_path / "new" / "ink.json").read_text())
    assert ink["canvas"] == {"width": 800.0, "height": 600.0}
    (stroke,) = ink["strokes"]
    assert len(stroke["pressure"]) == len(stroke["x"])
    assert np.ptp(stroke["x"]) == pytest.approx(400, abs=8)
    code, _ = run("build", "silhouette", "new/ink.json", "-o", "ball.stl")
    assert code == 0
    assert (tmp_path / "ball.stl").stat().st_size > 1000


def test_a_page_is_straightened_unless_the_whole_picture_is_wanted(run, sketch, tmp_path):
    sketch(TABLE)
    assert "straightened" in run("trace", "sketch.png", "-o", "page.json")[1]
    run("trace", "sketch.png", "-o", "whole.json", "--whole")
    page, whole = (
        json.loads((tmp_path / name).read_text())["canvas"] for name in ("page.json", "whole.json")
    )
    assert whole == {"width": 1000.0, "height": 750.0}
    assert page["width"] < whole["width"]


@pytest.mark.parametrize(
    ("words", "advice"),
    [
        (("gone.png", "-o", "ink.json"), "gone.png"),
        (("sketch.png", "-o", "ink.stl"), ".json"),
        (("sketch.png", "-o", "sketch.png"), "replace an input"),
        (("sketch.png", "-o", "ink.json", "--sensitivity", "2"), "from 0"),
        (("notes.txt", "-o", "ink.json"), "is no picture"),
        (("torn.png", "-o", "ink.json"), "torn.png"),
    ],
)
def test_a_mistake_is_told_in_one_line_and_nothing_is_written(run, sketch, tmp_path, words, advice):
    sketch()
    (tmp_path / "notes.txt").write_text("no picture")
    (tmp_path / "torn.png").write_bytes((tmp_path / "sketch.png").read_bytes()[:2000])
    code, said = run("trace", *words)
    assert code == 2
    assert said.startswith("error: ")
    assert advice in said
    assert said.count("\n") == 1
    assert not (tmp_path / "ink.json").exists()
