"""Single values of plugins' answers: texts, numbers, points and meshes that can be used."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from bozzetto.geometry.mesh import Mesh

LONGEST_LABEL: Final = 200
"""Characters of a label, and of the names within a scene."""


class Unsound(ValueError):
    """Something that a plugin made cannot be used; the message says what."""


def expect(condition: bool, what: str) -> None:
    """Raise `Unsound` about a thing where a condition does not hold."""
    if not condition:
        raise Unsound(f"{what} is of a wrong kind or out of range")


def expect_tuple(value: Any, what: str) -> None:
    """Raise `Unsound` where a value is no tuple."""
    if type(value) is not tuple:
        raise Unsound(
            f"{what}: {type(value).__name__} where a tuple belongs; "
            "a tuple of one thing is written (thing,)"
        )


def check_finite(values: Any, what: str) -> None:
    """Raise `Unsound` where one of some numbers is not finite."""
    if not np.isfinite(values).all():
        raise Unsound(f"a number that is not finite in {what}")


def check_number(value: Any, what: str, low: float, high: float) -> None:
    """Raise `Unsound` where a value is no number within bounds."""
    fine = isinstance(value, int | float) and math.isfinite(value) and low <= value <= high
    expect(fine, what)


def check_point(value: Any, what: str) -> None:
    """Raise `Unsound` where a value is no place in space."""
    expect(np.shape(value) == (3,), what)
    check_finite(np.asarray(value, float), what)


def check_words(value: Any, what: str) -> None:
    """Raise `Unsound` where a value is no text, or one that no file can hold."""
    expect(isinstance(value, str), what)
    if not value.isascii():
        try:
            value.encode()
        except UnicodeEncodeError:
            raise Unsound(f"{what} has half a character in it") from None


def check_text(value: Any, what: str) -> None:
    """Raise `Unsound` where a value is no text, or too long to be shown."""
    check_words(value, what)
    expect(len(value) <= LONGEST_LABEL, what)


def check_mesh(mesh: Any) -> None:
    """Raise `Unsound` where a value is no mesh, or holds a number that is not finite."""
    expect(type(mesh) is Mesh, "a mesh")
    check_finite(mesh.vertices, "the vertices of a mesh")
    if mesh.normals is not None:
        check_finite(mesh.normals, "the normals of a mesh")
