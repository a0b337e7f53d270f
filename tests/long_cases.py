"""Which tests the default run leaves out, so that it ends within minutes: by their measured cost.

``python -m tests.long_cases RUN.txt`` writes the list anew from what a run on a quiet machine has
printed: ``python3 bootstrap.py test -m 'long or not (slow or interop or gl or kill or display or
quiet)' --durations=0 --durations-min=0.02 > RUN.txt``. Nobody edits the list: a new test is in the
default run until it is measured.

Of a test with many cases the first stays in the default run. All others have the mark ``long`` and
are run by ``python3 bootstrap.py test -m long``.

Where not even that has the time, as in `.ci/run`, ``--share 3:7`` takes a third of the cases of
each test, and with another number than 7 another third. Tests of fewer cases take turns.
"""

from __future__ import annotations

import re
import sys
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

LIST = Path(__file__).with_name("long_cases.txt")

ALL_CASES = 0.35
"""Seconds of the cheapest case from which no case of a test is in the default run."""

MORE_CASES = 0.2
"""Seconds of all cases together from which only the first is."""

_TIME = re.compile(r"\s*([\d.]+)s (?:call|setup|teardown)\s+(\S.*)$")


def costs(lines: Iterable[str]) -> dict[str, list[float]]:
    """Return for each test the seconds of its cases, from lines that pytest has printed."""
    cases: defaultdict[str, float] = defaultdict(float)
    for line in lines:
        if found := _TIME.match(line):
            cases[found[2]] += float(found[1])
    tests: defaultdict[str, list[float]] = defaultdict(list)
    for name, seconds in cases.items():
        tests[name.split("[")[0]].append(seconds)
    return dict(tests)


def chosen(tests: Mapping[str, list[float]]) -> dict[str, str]:
    """Return for each test that is left out, in whole or in part, which cases: all or more."""
    kept = {}
    for name, seconds in sorted(tests.items()):
        if min(seconds) >= ALL_CASES:
            kept[name] = "all"
        elif len(seconds) > 1 and sum(seconds) >= MORE_CASES:
            kept[name] = "more"
    return kept


def listed() -> dict[str, str]:
    """Return the list as it was written last."""
    rows = (line.split() for line in LIST.read_text(encoding="utf-8").splitlines())
    return {name: cases for cases, name in rows}


def long_ones(names: Iterable[str]) -> list[bool]:
    """Tell for each collected test, in their order, whether the default run leaves it out."""
    known, met = listed(), set[str]()
    answers = []
    for full in names:
        name = full.split("[")[0]
        cases = known.get(name)
        answers.append(cases == "all" or (cases == "more" and name in met))
        met.add(name)
    return answers


def taken(names: Iterable[str], share: str) -> list[bool]:
    """Tell for each selected test, in their order, whether a share takes it.

    Parameters
    ----------
    names : iterable of str
    share : str
        ``"3"`` or ``"3:7"``: one of three cases of each test; which one, by the number. In three
        numbers that follow one another every case has its turn once.

    Raises
    ------
    ValueError
        If it is no such share.
    """
    parts, number = (int(each) for each in (*share.split(":"), "0")[:2])
    if parts < 1:
        raise ValueError(f"a share is one of 1 or more, not of {parts}")
    met: Counter[str] = Counter()
    answers = []
    for name in (full.split("[")[0] for full in names):
        turn = met[name] + zlib.crc32(name.encode())  # not all first cases in one share
        answers.append((turn + number) % parts == 0)
        met[name] += 1
    return answers


def main(arguments: list[str]) -> int:
    """Write the list from a run's output."""
    (path,) = arguments
    rows = chosen(costs(Path(path).read_text(encoding="utf-8").splitlines()))
    LIST.write_text("".join(f"{cases} {name}\n" for name, cases in rows.items()), encoding="utf-8")
    print(f"{len(rows)} tests have cases of the long run")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
