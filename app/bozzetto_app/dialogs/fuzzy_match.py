"""Finding by name: letters in their order, best where words begin."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from functools import lru_cache

__all__ = ["Match", "fold", "match"]

AT_START = 12.0
"""For a letter at the very beginning."""

AT_WORD = 8.0
"""For a letter at the beginning of a word."""

IN_A_ROW = 9.0
"""For a letter right behind the one matched before."""

ANYWHERE = 1.0
"""For any other letter."""

PER_GAP = 0.2
"""Off for every letter skipped between two matches."""

PER_LETTER_LEFT = 0.02
"""Off for every letter of the text: of two equals the shorter name wins."""


@dataclass(frozen=True)
class Match:
    """How well a text fits what was typed.

    Attributes
    ----------
    score : float
        Larger is better.
    places : tuple of int
        Indices of the matched letters.
    """

    score: float
    places: tuple[int, ...]


@lru_cache(maxsize=2048)  # what is typed meets every name, and every name is met at every letter
def fold(text: str) -> str:
    """Lower case without accents, one letter for one letter."""
    return "".join((unicodedata.normalize("NFKD", letter)[:1] or letter).lower() for letter in text)


def _starts_word(text: str, place: int) -> bool:
    return place == 0 or not text[place - 1].isalnum()


def match(typed: str, text: str) -> Match | None:
    """Fit what was typed to a text: every typed word's letters occur in it in their order.

    Returns
    -------
    Match or None
        The best of all ways to fit, or None where there is none.
    """
    folded = fold(text)[: len(text)]
    score, places = 0.0, set[int]()
    for word in fold(typed).split():
        found = _fit(word, folded)
        if found is None:
            return None
        score += found.score
        places.update(found.places)
    return Match(score - PER_LETTER_LEFT * len(text), tuple(sorted(places)))


def _fit(word: str, text: str) -> Match | None:
    """Return the best alignment of one word, by dynamic programming over (letter, position)."""
    best: dict[int, tuple[float, tuple[int, ...]]] = {-1: (0.0, ())}
    for letter in word:
        reached: dict[int, tuple[float, tuple[int, ...]]] = {}
        for place, other in enumerate(text):
            if other != letter:
                continue
            if place == 0:
                gain = AT_START
            elif _starts_word(text, place):
                gain = AT_WORD
            else:
                gain = ANYWHERE
            for before, (score, places) in best.items():
                if before >= place:
                    continue
                step = max(gain, IN_A_ROW) if before == place - 1 and before >= 0 else gain
                gap = place - before - 1 if before >= 0 else 0
                total = score + step - PER_GAP * gap
                if place not in reached or total > reached[place][0]:
                    reached[place] = (total, (*places, place))
        if not reached:
            return None
        best = reached
    score, places = max(best.values())
    return Match(score, places)
