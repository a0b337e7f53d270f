"""Sums in number fields, against Python's own fractions."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto_app.widgets.expression import compute

numbers = st.decimals(
    min_value=0, max_value=10_000, places=3, allow_nan=False, allow_infinity=False
).map(lambda d: (format(d, "f"), Fraction(d)))


def _combined(children):
    """Pairs of (text, exact value or None where it divides by zero)."""

    def join(parts):
        (left, a), sign, (right, b), gap = parts
        text = f"({left}){gap}{sign}{gap}({right})"
        if a is None or b is None or (sign == "/" and b == 0):
            return text, None
        exact = {"+": a.__add__, "-": a.__sub__, "*": a.__mul__, "/": a.__truediv__}[sign](b)
        return text, exact

    def negate(part):
        text, value = part
        return f"-({text})", None if value is None else -value

    pairs = st.tuples(children, st.sampled_from("+-*/"), children, st.sampled_from(["", " "]))
    return st.one_of(pairs.map(join), children.map(negate))


sums = st.recursive(numbers, _combined, max_leaves=6).filter(lambda pair: len(pair[0]) <= 120)


@given(sums)
def test_it_computes_exactly(pair):
    text, exact = pair
    if exact is None:
        with pytest.raises(UserError, match="zero"):
            compute(text)
    else:
        assert compute(text) == exact


@given(st.lists(st.integers(0, 999), min_size=2, max_size=8), st.data())
def test_signs_bind_as_in_python(values, data):
    signs = [data.draw(st.sampled_from("+-*")) for _ in values[1:]]
    text = str(values[0]) + "".join(f"{s}{v}" for s, v in zip(signs, values[1:], strict=True))
    by_python = str(values[0])
    for sign, value in zip(signs, values[1:], strict=True):
        by_python += f" {sign} {value}"
    terms, total = [Fraction(values[0])], Fraction(0)
    for sign, value in zip(signs, values[1:], strict=True):
        if sign == "*":
            terms[-1] *= value
        else:
            terms.append(Fraction(value if sign == "+" else -value))
    total = sum(terms, Fraction(0))
    assert compute(text) == total


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("120/2+5", 65),
        ("0.1+0.2", Fraction(3, 10)),
        ("1,5 × 2", 3),
        ("10 ÷ 4", Fraction(5, 2)),
        ("− 3", -3),
        ("2 * -3", -6),
        (".5", Fraction(1, 2)),
        ("8/4/2", 1),
        ("8-4-2", 2),
    ],
)
def test_examples(text, value):
    assert compute(text) == value


NO_SUMS = """
1+|(1|1)|1 2|abc|1e9|2**3|__import__('os')|1;2|--|()|nan|inf|1..2|1,2,3|0x10|1_000|٣x
""".strip().split("|")
TOO_MUCH = ["(" * 60 + "1" + ")" * 60, "-" * 60 + "1", "9" * 200]


@pytest.mark.parametrize("text", ["", " ", *NO_SUMS, *TOO_MUCH])
def test_what_is_not_a_sum_is_refused(text):
    with pytest.raises(UserError):
        compute(text)


@given(st.text(max_size=60))
def test_any_text_gives_a_number_or_a_refusal(text):
    try:
        value = compute(text)
    except UserError:
        return
    assert isinstance(value, Fraction)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 cm", "mm", 100),
        ("1.5m", "mm", 1500),
        ("1/2 in", "mm", Fraction("12.7")),
        ("2 * 3 in + 4 mm", "mm", Fraction("156.4")),
        ("(1 + 2) cm / 4", "mm", Fraction("7.5")),
        ("1 ft + 6″", "mm", Fraction("457.2")),
        ("254 mm", "in", 10),
        ("3 min", "s", 180),
        ("3 cells", "cells", 3),
    ],
)
def test_other_units_are_converted(text, unit, value):
    assert compute(text, unit) == value


def test_half_a_turn_is_pi():
    assert float(compute("3.14159265358979 rad", "°")) == pytest.approx(180.0, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "unit"),
    [("3 s", "mm"), ("3 mm", "°"), ("3 cm", ""), ("2 in * 3 in", "mm"), ("mm", "mm")],
)
def test_units_that_mean_nothing_here_are_refused(text, unit):
    with pytest.raises(UserError):
        compute(text, unit)


@given(st.decimals(1, 10_000_000, places=2), st.sampled_from(" ,.\u202f'"), st.sampled_from(".,"))
def test_thousands_are_read_as_they_are_written_anywhere(number, parting, point):
    """Where both signs are there, nothing is left to guess."""
    if parting == point:
        return
    text = f"{number:,.2f}".translate(str.maketrans({",": parting, ".": point}))
    assert compute(text) == Fraction(number)


@given(st.integers(1_000, 999_999))
def test_a_comma_parts_thousands_where_it_does_in_that_country(number):
    text = f"{number:,}"
    assert compute(text, comma_parts=True) == number
    assert compute(text) * 1000 == number  # else it is the decimal one


@pytest.mark.parametrize("text", ["0,125", "12,5", "1234,567", "4,2615", "4.261"])
def test_what_is_no_thousand_is_a_decimal_everywhere(text):
    assert compute(text, comma_parts=True) == Fraction(text.replace(",", "."))


def test_digits_of_other_keyboards():
    assert compute("１２．５×２") == 25
    assert compute("٣٫٥") == Fraction("3.5")
