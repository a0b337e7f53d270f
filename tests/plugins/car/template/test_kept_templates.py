"""Templates that a person keeps: read as they were written, whatever else lies in the folder."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_car.template import kept_templates as kept
from bozzetto_car.template.kept_templates import (
    MOST_KEPT,
    forget_template,
    keep_template,
    kept_templates,
)
from bozzetto_car.template.loader import bundled, bundled_file
from bozzetto_car.template.schema import LARGEST_FILE


def called(title: str) -> bytes:
    """The file of a sedan of another name."""
    told = json.loads(bundled_file("sedan"))
    return json.dumps(told | {"title": title, "id": title.lower().replace(" ", "_")}).encode()


def test_what_is_kept_is_found_again(tmp_path: Path) -> None:
    folder = tmp_path / "not" / "there yet"
    assert kept_templates(folder) == ()
    for title in ("Wedge", "Anvil"):
        keep_template(folder, called(title))
    found = kept_templates(folder)
    assert [kept.template.title for kept in found] == ["Anvil", "Wedge"]
    assert found[1].source.encode() == called("Wedge")
    assert (found[0].template.positions == bundled("sedan").positions).all()
    assert not list(folder.glob("*.part"))


def test_none_is_written_over(tmp_path: Path) -> None:
    paths = {keep_template(tmp_path, called("Wedge")) for _ in range(3)}
    assert len(paths) == len(kept_templates(tmp_path)) == 3


def test_reading_again_gives_the_same_template(tmp_path: Path) -> None:
    """Or every look at the panel would draw all pictures anew."""
    keep_template(tmp_path, called("Wedge"))
    first, second = kept_templates(tmp_path)[0], kept_templates(tmp_path)[0]
    assert first.template is second.template


def test_what_is_no_template_is_not_kept(tmp_path: Path) -> None:
    for content in (b"", b"{}", b"\xff\xfe", called("Wedge")[:-40]):
        with pytest.raises(UserError):
            keep_template(tmp_path, content)
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_read_is_passed_over(tmp_path: Path) -> None:
    keep_template(tmp_path, called("Wedge"))
    good = called("Anvil")
    rng = np.random.default_rng(1)
    for number in range(40):
        damaged = bytearray(good)
        for at in rng.integers(0, len(good), 3):
            damaged[at] = rng.integers(256)
        if number % 2:
            del damaged[rng.integers(len(good)) :]
        (tmp_path / f"damaged {number}.json").write_bytes(damaged)
    (tmp_path / "huge.json").write_bytes(b" " * (LARGEST_FILE + 1))
    (tmp_path / "folder.json").mkdir()
    (tmp_path / "gone.json").symlink_to(tmp_path / "nowhere")
    (tmp_path / "notes.txt").write_bytes(good)
    titles = [one.template.title for one in kept_templates(tmp_path)]
    assert titles.count("Wedge") == 1
    assert len(titles) < 20


def test_no_more_are_offered_than_a_panel_can_show(tmp_path: Path) -> None:
    for number in range(MOST_KEPT + 3):
        (tmp_path / f"{number:03}.json").write_bytes(called("Wedge"))
    assert len(kept_templates(tmp_path)) == MOST_KEPT


def test_one_is_forgotten_and_the_others_stay(tmp_path: Path) -> None:
    for title in ("Wedge", "Anvil"):
        keep_template(tmp_path, called(title))
    anvil, wedge = kept_templates(tmp_path)
    forget_template(anvil)
    forget_template(anvil)  # it is gone already
    assert [one.path for one in kept_templates(tmp_path)] == [wedge.path]


def test_where_nothing_can_be_written_it_is_said_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "in the way").write_text("a file, and no folder")
    with pytest.raises(UserError, match="Save it as a file"):
        keep_template(tmp_path / "in the way", called("Wedge"))


def test_a_full_disk_leaves_nothing_half_written(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    keep_template(tmp_path, called("Anvil"))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(UserError, match="Save it as a file"):
            keep_template(tmp_path, called("Wedge"))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [path.name for path in tmp_path.iterdir()] == ["anvil.json"]


def test_no_template_is_written_over_however_many_have_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept, "MOST_ALIKE", 3)
    names = [keep_template(tmp_path, called("Wedge")).name for _ in range(2)]
    assert names == ["wedge.json", "wedge_2.json"]
    contents = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(UserError, match="another name"):
        keep_template(tmp_path, called("Wedge"))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == contents
