"""Run the benchmarks: ``python -m tests.benchmarks [ROOM …] [--write]``.

Every ``bench_ROOM.py`` beside this file has a function ``rows()``. With ``--write`` the
table goes into ``docs/performance.md``.
"""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import sys
from collections.abc import Sequence
from pathlib import Path

from bozzetto_app.__main__ import ONE_THREAD

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
for name in ONE_THREAD:  # as the program itself has it
    os.environ.setdefault(name, "1")
HERE = Path(__file__).parent
DOCUMENT = HERE.parents[1] / "docs" / "performance.md"
HEADINGS = ("Room", "What", "Median", "Budget", "Alternative, same run", "Ratio")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what was asked for and print the table."""
    rooms = sorted(path.stem.removeprefix("bench_") for path in HERE.glob("bench_*.py"))
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks")
    parser.add_argument("rooms", nargs="*", metavar="ROOM", help=f"of {', '.join(rooms)}")
    parser.add_argument("--write", action="store_true", help="write docs/performance.md")
    options = parser.parse_args(arguments)
    if options.write and options.rooms:
        parser.error("--write goes with all rooms")
    unknown = set(options.rooms) - set(rooms)
    if unknown:
        parser.error(f"no room {', '.join(sorted(unknown))}; there are {', '.join(rooms)}")
    table = []
    for room in options.rooms or rooms:
        print(f"… {room}", file=sys.stderr, flush=True)
        module = importlib.import_module(f"tests.benchmarks.bench_{room}")
        table += [row.cells() for row in module.rows()]
    text = _markdown(table)
    print(text)
    if options.write:
        DOCUMENT.write_text(_page(text), encoding="utf-8")
    return 0


def _markdown(table: list[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(HEADINGS) + " |", "|" + " --- |" * len(HEADINGS)]
    lines += ["| " + " | ".join(cells) + " |" for cells in table]
    return "\n".join(lines)


def _page(table: str) -> str:
    return f"""# Performance

Made by `python -m tests.benchmarks --write`; do not edit the table. Medians after a warm-up
on {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}{_load()}. A ratio
above 1 means that Bozzetto is that many times faster than the alternative, which was timed
in turn with it in the same run. Trust the ratios: absolute times depend on the machine.

{table}
"""


def _load() -> str:
    """How busy the machine was with this and other things, where the system says so."""
    if not hasattr(os, "getloadavg"):
        return ""
    return f", with {os.getloadavg()[2]:.1f} processes running on average"


if __name__ == "__main__":
    sys.exit(main())
