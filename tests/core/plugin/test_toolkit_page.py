"""What the page on the toolkit says is so: its tables are the code's, and its pieces run."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from docs import write_toolkit

ROOT = Path(__file__).resolve().parents[3]
PAGE = write_toolkit.PAGE.read_text("utf-8")


def test_the_tables_are_those_of_the_code():
    assert write_toolkit.written(PAGE) == PAGE, "run: python docs/write_toolkit.py"


def test_every_name_has_words():
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", PAGE.partition(write_toolkit.MARK)[2], re.M)
    assert len(rows) > 100
    assert not [name for name, words in rows if len(words) < 10]


def test_the_doors_are_those_that_the_linter_opens():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    (public,) = (
        each for each in project["tool"]["importlinter"]["contracts"] if "ignore_imports" in each
    )
    opened = {line.removeprefix("** -> ") for line in public["ignore_imports"]}
    assert opened == {*write_toolkit.DOORS, "bozzetto.plugin"}
    assert set(re.findall(r"^\| `(bozzetto(?:_app)?\.[\w.]+)` \|", PAGE, re.M)) == set(
        write_toolkit.DOORS
    )


def test_pieces_of_code_run():
    pieces = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    assert len(pieces) == 2
    for piece in pieces:
        exec(piece, {})  # noqa: S102


def test_every_number_that_documentation_mentions_has_its_value_and_words():
    told = write_toolkit.named_limits()
    assert {"LEAST_ANGLE", "GAP_SHARE"} <= {key.rpartition(".")[2] for key in told}
    for key, (namers, _, words) in told.items():
        assert namers, key
        assert len(words) > 10, f"{key} has no words below it"
