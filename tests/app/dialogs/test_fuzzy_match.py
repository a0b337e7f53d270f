"""Finding by name."""

from __future__ import annotations

import itertools
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto_app.dialogs.fuzzy_match import fold, match

words = st.text(alphabet="abcdeABC ", min_size=1, max_size=9)


@given(words, st.text(alphabet="abcde", min_size=1, max_size=4))
def test_it_matches_exactly_the_subsequences(text, typed):
    folded = text.lower()
    possible = any(
        all(folded[i] == letter for i, letter in zip(places, typed, strict=True))
        for places in itertools.combinations(range(len(folded)), len(typed))
    )
    found = match(typed, text)
    assert (found is not None) == possible
    if found is not None:
        assert "".join(folded[place] for place in found.places) == typed


@pytest.mark.parametrize(
    ("typed", "better", "worse"),
    [
        ("sa", "Save", "Close all"),
        ("sa", "Save as…", "Pause"),
        ("save", "Save", "Save as…"),
        ("nd", "New drawing", "Undo"),
        ("un", "Undo", "Run"),
        ("grid", "Ground grid", "Great big slide"),
        ("fs", "Frame selection", "Offset"),
    ],
)
def test_what_a_person_means_comes_first(typed, better, worse):
    good, bad = match(typed, better), match(typed, worse)
    assert good is not None
    assert bad is None or good.score > bad.score


def test_words_may_come_in_any_order():
    assert match("horse rock", "Rocking horse") is not None
    assert match("horse cow", "Rocking horse") is None


def test_accents_and_case_do_not_matter():
    assert match("coupe", "Coupé") is not None
    assert match("COUPÉ", "coupe") is not None


@given(st.text(max_size=30))
def test_folding_keeps_places(text):
    assert len([fold(letter)[:1] for letter in text]) == len(text)
    found = match(text, text)
    assert found is not None
    assert all(0 <= place < len(text) for place in found.places)


def test_nothing_typed_fits_everything():
    found = match("  ", "Save")
    assert found is not None
    assert found.places == ()


def test_a_letter_more_folds_no_name_again(monkeypatch):
    names = [f"Name of something {number}" for number in range(300)]
    folded = []

    def counted(form, letter, plain=unicodedata.normalize):
        folded.append(letter)
        return plain(form, letter)

    monkeypatch.setattr(unicodedata, "normalize", counted)
    for typed in ("x" * 400, "x" * 401):
        folded.clear()
        for name in names:
            match(typed, name)
    assert len(folded) == 401
