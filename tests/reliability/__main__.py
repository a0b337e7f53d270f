"""Run the long reliability suites: ``python -m tests.reliability [SUITE …] [--share S] [--write]``.

Every ``suite_NAME.py`` beside this file has a docstring whose first line is its title, and a
function ``rows(share)`` that does ``share`` (0 to 1) of the full work; one with random cases
may take a ``seed`` as well. With ``--write`` the tables of the suites that were run go into
``docs/reliability.md``, with the text of ``comparison.md``; those of the others stay.
"""

from __future__ import annotations

import argparse
import datetime
import importlib
import inspect
import os
import platform
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).parent
DOCUMENT = HERE.parents[1] / "docs" / "reliability.md"
COMPARISON = HERE / "comparison.md"
"""What other programs promise; part of the page."""

HEADINGS = ("What", "Measured", "Promised", "Kept")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what was asked for, print the tables; 1 if a promise was not kept."""
    suites = sorted(path.stem.removeprefix("suite_") for path in HERE.glob("suite_*.py"))
    parser = argparse.ArgumentParser(prog="python -m tests.reliability")
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=f"of {', '.join(suites)}")
    parser.add_argument("--share", type=float, default=1.0, help="of the full work, 0 to 1")
    parser.add_argument("--seed", type=int, default=0, help="of suites with random cases")
    parser.add_argument("--write", action="store_true", help="write docs/reliability.md")
    options = parser.parse_args(arguments)
    unknown = set(options.suites) - set(suites)
    if unknown:
        parser.error(f"no suite {', '.join(sorted(unknown))}; there are {', '.join(suites)}")
    if not 0.0 < options.share <= 1.0:
        parser.error("--share is more than 0 and at most 1")
    kept = True
    for name in options.suites or suites:
        print(f"… {name}", file=sys.stderr, flush=True)
        module = importlib.import_module(f"tests.reliability.suite_{name}")
        started = time.monotonic()
        seeded = "seed" in inspect.signature(module.rows).parameters
        rows = list(module.rows(options.share, **({"seed": options.seed} if seeded else {})))
        seconds = time.monotonic() - started
        kept = kept and all(row.kept for row in rows)
        title = (module.__doc__ or name).splitlines()[0].rstrip(".")
        text = _section(title, [row.cells() for row in rows], options.share, seconds)
        print(text, flush=True)
        if options.write:
            _write(name, text)
    if options.write:
        _write("comparison", COMPARISON.read_text(encoding="utf-8").strip())
    return 0 if kept else 1


def _write(name: str, text: str) -> None:
    """Put a section onto the page."""
    page = DOCUMENT.read_text(encoding="utf-8")
    DOCUMENT.write_text(with_section(page, name, text), encoding="utf-8")


def with_section(page: str, name: str, text: str) -> str:
    """Return the page with one suite's section replaced, or added at its end."""
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    section = f"{begin}\n{text}\n{end}"
    pattern = re.compile(re.escape(begin) + r".*?" + re.escape(end), re.DOTALL)
    if pattern.search(page):
        return pattern.sub(lambda _: section, page)
    return page.rstrip("\n") + f"\n\n{section}\n"


def _section(title: str, table: list[tuple[str, ...]], share: float, seconds: float) -> str:
    lines = [f"## {title}", ""]
    lines += ["| " + " | ".join(HEADINGS) + " |", "|" + " --- |" * len(HEADINGS)]
    lines += ["| " + " | ".join(cells) + " |" for cells in table]
    part = "All of it" if share == 1.0 else f"{share:.0%} of it"
    day = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    lines += ["", f"{part}, {day}, {os.cpu_count()} cores, {platform.system()}, "]
    lines[-1] += f"Python {platform.python_version()}, {seconds / 60:.1f} minutes, "
    # Pauses and times that are not kept on a busy machine say little.
    lines[-1] += f"{os.getloadavg()[2]:.0f} processes ready to run on average."
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
