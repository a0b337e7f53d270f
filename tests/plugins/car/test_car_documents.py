"""What the documents say of cars is so: commands run, and files and reports have the keys told."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from bozzetto.cli.main import main
from bozzetto_car.marks_file import VIEW_KEYS, car_from_facts
from bozzetto_car.report import SHORT

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
PAGES = ("README.md", "docs/car.md", "docs/gallery/README.md", "docs/gallery/car/README.md")

CAR_PAGE = (ROOT / "docs" / "car.md").read_text("utf-8")


def commands() -> list[str]:
    """Those that build a car of the gallery, as they stand in the documents."""
    found = re.compile(r"^(?:bozzetto|python3 bootstrap\.py run) (build car docs/.+)$", re.M)
    texts = ((ROOT / page).read_text("utf-8") for page in PAGES)
    return list(dict.fromkeys(line for text in texts for line in found.findall(text)))


def section(title: str) -> str:
    """A section of the page on cars."""
    return re.split(r"^## ", CAR_PAGE.split(f"## {title}", 1)[1], flags=re.M)[0]


def keys_of(text: str) -> set[str]:
    """Words in code in the first column of a section's tables."""
    rows = re.findall(r"^\| (?:… )?(`[^|]+`) \|", text, re.M)
    return {key for row in rows for key in re.findall(r"`([^`]+)`", row)}


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("report")
    file = str(ROOT / "docs" / "gallery" / "car" / "hatchback.json")
    out, told = str(folder / "x.bozz"), folder / "r.json"
    assert main(["build", "car", file, "-o", out, "--report", str(told)]) == 0
    read: dict[str, Any] = json.loads(told.read_text("utf-8"))
    return read


def test_there_are_commands_in_every_document() -> None:
    assert len(commands()) >= 3


@pytest.mark.parametrize("line", commands())
def test_a_command_does_what_it_says(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = line.split()
    monkeypatch.chdir(tmp_path)
    assert main([str(ROOT / word) if word.startswith("docs/") else word for word in words]) == 0
    targets = [words[at + 1] for at, word in enumerate(words) if word in ("-o", "--report")]
    assert targets
    assert all((tmp_path / target).stat().st_size > 10_000 for target in targets)


def test_the_page_tells_all_keys_of_a_marks_file() -> None:
    text = section("Marks files")
    told = keys_of(text)
    assert told >= VIEW_KEYS
    example = json.loads(re.findall(r"^```json\n(.*?)^```", text, re.M | re.S)[0])
    assert set(example) <= told
    assert all(set(view) <= VIEW_KEYS for view in example["views"])
    assert all(f"`{short}`" in text for short in SHORT.values())
    del example["styling"]  # there is no camera yet, through which it could be laid on the body
    state = car_from_facts(example, {})
    assert [sketch.name for sketch in state.sketches] == ["Sketch 1", "Rear"]
    assert state.wheelbase == 2880.0


def test_the_page_tells_all_keys_of_a_report(report: dict[str, Any]) -> None:
    told = keys_of(section("The report"))
    assert told >= {*report}
    (view,) = report["views"]
    assert told >= {*view}
