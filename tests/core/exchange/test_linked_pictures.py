"""Files that name pictures, and files that are nothing but facts."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

from bozzetto.cli.file_facts import facts_of
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.images.png import write_png
from bozzetto.view import Camera

MARKS = {
    "image": {"file": "front.png", "width": 8, "height": 6},
    "template": "sedan",
    "views": [
        {"kind": "auto", "marks": {"C1": [3.0, 4.5]}},
        {"kind": "auto", "image": {"file": "more/rear.png"}, "marks": {}},
    ],
}


def picture(path, shade, size=(6, 8)):
    path.parent.mkdir(exist_ok=True)
    write_png(path, np.full((*size, 4), shade, np.uint8))


@pytest.fixture
def folder(tmp_path):
    inner = tmp_path / "job"
    picture(inner / "front.png", 200)
    picture(inner / "more" / "rear.png", 90)
    picture(tmp_path / "outside.png", 10)
    return inner


def read(folder, said, name="marks.json"):
    path = folder / name
    path.write_text(json.dumps(said), encoding="utf-8")
    return read_drawing(path)


def test_marks_are_a_drawing_without_strokes(folder):
    drawing = read(folder, MARKS)
    assert len(drawing.strokes) == 0
    assert drawing.facts == MARKS
    assert drawing.camera == Camera()
    assert drawing.name == "marks"
    assert list(drawing.pictures) == ["front.png", "more/rear.png"]
    assert drawing.pictures["front.png"].pixels[0, 0, 0] == 200
    assert drawing.pictures["more/rear.png"].name == "rear"
    assert drawing.pictures["more/rear.png"].width == 8


def test_ink_may_name_pictures_too(folder):
    ink = {
        "format": "bozzetto-ink/1",
        "canvas": {"width": 800, "height": 600},
        "camera": {"kind": "orthographic", "eye": [0, -9, 0], "target": [0, 0, 0], "height": 50},
        "strokes": [{"x": [1, 2], "y": [3, 4]}],
        "image": {"file": "front.png"},
    }
    drawing = read(folder, ink)
    assert len(drawing.strokes) == 1
    assert list(drawing.pictures) == ["front.png"]


@pytest.mark.parametrize(
    "said",
    [
        {"image": {"width": 8, "height": 6}},
        {"image": "front.png", "views": {"image": {"file": "front.png"}}},
        {"views": [None, 3, "x", {"image": None}, {"image": []}]},
        {"image": None},
    ],
)
def test_what_names_no_file_needs_none(folder, said):
    assert read(folder, said).pictures == {}


def test_one_picture_of_several_views_is_read_once(folder):
    views = [{"image": {"file": "front.png"}}] * 9
    assert list(read(folder, {"views": views}).pictures) == ["front.png"]


def test_a_missing_picture_is_named(folder):
    with pytest.raises(UserError, match=r"marks\.json: The picture “side\.png” is not there"):
        read(folder, {"image": {"file": "side.png"}})


@pytest.mark.parametrize(
    "name",
    ["../outside.png", "/etc/passwd.png", "more/../../outside.png", "..\\outside.png",
     "C:outside.png", "", ".", "a\0.png", "\n.png"],
)  # fmt: skip
def test_names_that_lead_elsewhere_are_refused(folder, name):
    with pytest.raises(FormatError, match="not in the folder"):
        read(folder, {"image": {"file": name}})


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_links_out_of_the_folder_are_refused(folder):
    (folder / "link.png").symlink_to(folder.parent / "outside.png")
    with pytest.raises(FormatError, match="link out"):
        read(folder, {"image": {"file": "link.png"}})
    (folder / "near.png").symlink_to(folder / "front.png")
    assert list(read(folder, {"image": {"file": "near.png"}}).pictures) == ["near.png"]


@pytest.mark.parametrize("name", ["more", "x" * 4000 + ".png"])
def test_folders_and_endless_names_are_refused_in_words(folder, name):
    with pytest.raises(UserError, match=r"^marks\.json"):
        read(folder, {"image": {"file": name}})


def test_files_that_are_no_pictures_are_refused(folder):
    (folder / "front.png").write_text("words")
    with pytest.raises(FormatError, match=r"marks\.json: front\.png: "):
        read(folder, {"image": {"file": "front.png"}})
    (folder / "notes.txt").write_text("words")
    with pytest.raises(UserError, match=r"\.txt"):
        read(folder, {"image": {"file": "notes.txt"}})
    with pytest.raises(FormatError, match="name of a picture"):
        read(folder, {"image": {"file": ["front.png"]}})


def test_too_many_pictures_are_refused_before_any_is_read(folder):
    views = [{"image": {"file": f"{number}.png"}} for number in range(65)]
    with pytest.raises(FormatError, match="65 pictures"):
        read(folder, {"views": views})


@pytest.mark.parametrize("said", [{}, [], [MARKS], "x", 3, None])
def test_what_holds_no_facts_is_no_drawing(folder, said):
    with pytest.raises(FormatError):
        read(folder, said)


@pytest.mark.parametrize("key", ["format", "strokes", "canvas", "camera", "steps"])
def test_half_an_ink_file_is_not_taken_for_facts(folder, key):
    with pytest.raises(FormatError):
        read(folder, {key: [], "template": "sedan"})


def test_what_a_file_of_facts_holds_is_told(folder):
    (folder / "marks.json").write_text(json.dumps(MARKS))
    told = facts_of(folder / "marks.json")
    assert told["strokes"] == 0
    assert told["facts"] == ["image", "template", "views"]
    assert told["pictures"] == ["front.png, 8 × 6 px", "more/rear.png, 8 × 6 px"]
