"""What the default run leaves out: chosen by cost, and every test is in some run."""

from __future__ import annotations

import pytest

from tests import long_cases
from tests.setup.test_bootstrap import ROOT

PRINTED = """
============ slowest durations ============
3.00s call     tests/a.py::test_heavy
0.20s setup    tests/a.py::test_cases[one]
0.20s call     tests/a.py::test_cases[one]
0.30s call     tests/a.py::test_cases[two [2]]
0.09s call     tests/a.py::TestKit::test_cheap[one]
0.09s teardown tests/a.py::TestKit::test_cheap[two]
"""


def test_costs_are_those_of_whole_cases():
    found = long_cases.costs(PRINTED.splitlines())
    assert {name: sorted(seconds) for name, seconds in found.items()} == {
        "tests/a.py::test_heavy": [3.0],
        "tests/a.py::test_cases": [0.3, 0.4],
        "tests/a.py::TestKit::test_cheap": [0.09, 0.09],
    }


def test_what_costs_much_is_left_out_and_of_many_cases_the_first_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(long_cases, "LIST", tmp_path / "list.txt")
    (tmp_path / "run.txt").write_text(PRINTED, encoding="utf-8")
    long_cases.main([str(tmp_path / "run.txt")])
    names = [
        "tests/a.py::test_heavy",
        "tests/a.py::test_cases[one]",
        "tests/a.py::test_cases[two [2]]",
        "tests/a.py::TestKit::test_cheap[one]",
        "tests/a.py::TestKit::test_cheap[two]",
        "tests/a.py::test_new",
    ]
    assert long_cases.long_ones(names) == [True, False, True, False, False, False]


def test_the_list_names_tests_that_there_are():
    inherited = {"test_contract", "runTest"}  # from kits: ours for modelers, a state machine's
    gone = []
    for name in long_cases.listed():
        path, function = name.split("::")[0], name.split("::")[-1]
        known = f"def {function}(" in (ROOT / path).read_text(encoding="utf-8")
        if not known and function not in inherited:
            gone.append(name)
    assert not gone


@pytest.mark.parametrize("parts", [1, 2, 3, 7])
def test_shares_take_every_case_once_and_are_of_one_size(parts):
    tests = {"a.py::one": 5, "a.py::two": 1, **{f"b.py::of two, {k}": 2 for k in range(100)}}
    names = [f"{test}[{k}]" for test, count in tests.items() for k in range(count)]
    shares = [long_cases.taken(names, f"{parts}:{number}") for number in range(12, 12 + parts)]
    assert [sum(answers) for answers in zip(*shares, strict=True)] == [1] * len(names)
    for share in shares:
        assert sum(share) == pytest.approx(len(names) / parts, rel=0.5)
        many = [is_taken for name, is_taken in zip(names, share, strict=True) if "one" in name]
        assert sum(many) in (5 // parts, -(-5 // parts))


def test_what_is_no_share_is_refused():
    for share in ("0", "-2", "half"):
        with pytest.raises(ValueError, match=r"share|invalid"):
            long_cases.taken(["a"], share)
