"""Families of files: small generators under names, in the order in which they were written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["FAMILIES", "Family", "families", "family", "filled"]


@dataclass(frozen=True)
class Family:
    """Files of one kind.

    Attributes
    ----------
    name : str
        Begins with the ending.
    make : callable
        The content of a file of about so many bytes.
    """

    name: str
    make: Callable[[int], bytes]

    @property
    def ending(self) -> str:
        return "." + self.name.split()[0]


FAMILIES: list[Family] = []


def family(name: str):
    """Keep a generator under a name."""

    def keep(make: Callable[[int], bytes]) -> Callable[[int], bytes]:
        FAMILIES.append(Family(name, make))
        return make

    return keep


def families(ending: str = "") -> list[Family]:
    """All, or those of one ending."""
    return [one for one in FAMILIES if not ending or one.ending == ending]


def filled(unit: bytes, size: int) -> bytes:
    return unit * max(1, size // len(unit))
