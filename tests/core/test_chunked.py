"""A chunked sequence is a tuple that shares what did not change."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.chunked import Chunked

items = st.lists(st.integers(0, 9), max_size=150)


@settings(max_examples=200, deadline=None)
@given(items, st.data())
def test_it_does_what_a_list_does(start, data):
    row, plain = Chunked(start), list(start)
    for _ in range(data.draw(st.integers(0, 12))):
        kind = data.draw(st.sampled_from(["extend", "insert", "remove", "replace"]))
        value = data.draw(st.integers(10, 99))
        place = data.draw(st.integers(-len(plain), len(plain)))
        if kind == "extend":
            row, plain = row.extended([value, value]), [*plain, value, value]
        elif kind == "insert":
            place = abs(place)
            row = row.inserted(place, value)
            plain.insert(place, value)
        elif plain and place < len(plain):
            if kind == "remove":
                row = row.without(place)
                del plain[place]
            else:
                row = row.replaced(place, value)
                plain[place] = value
        assert list(row) == plain
        assert len(row) == len(plain)
        assert row == Chunked(plain)
        assert hash(row) == hash(Chunked(plain))
        assert all(0 < len(chunk) <= Chunked.CHUNK for chunk in row.chunks)
    for place in range(-len(plain), len(plain)):
        assert row[place] == plain[place]
    cut = data.draw(st.slices(max(1, len(plain))))
    assert list(row[cut]) == plain[cut]


def test_a_change_shares_all_chunks_but_one():
    row = Chunked(range(1000))
    for changed in (row.replaced(500, -1), row.without(500), row.extended([1])):
        shared = {id(chunk) for chunk in row.chunks} & {id(chunk) for chunk in changed.chunks}
        assert len(shared) == len(row.chunks) - 1


def test_it_is_read_only_and_bounds_are_errors():
    row = Chunked("abc")
    with pytest.raises(AttributeError):
        row.chunks = ()
    for call in (
        lambda: row[3],
        lambda: row[-4],
        lambda: row.without(3),
        lambda: row.inserted(9, 1),
    ):
        with pytest.raises(IndexError):
            call()
    assert row != ("a", "b", "c")
    assert repr(row) == "Chunked(3)"
