"""Cautions: what a result was not made from, or does not keep to, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable


@dataclass(frozen=True)
class Caution:
    """One thing that a person must know of a result.

    Parameters
    ----------
    message : str
        One sentence or two: what of the input was not used, or what the result does not keep
        to, and what to do about it.
    baseless : bool
        Whether the result is not made from the input at all, such as a template of which nobody
        knows where it lies on the sketch. The command line then writes a shape only if it is
        asked for one all the same.
    """

    message: str
    baseless: bool = False


@runtime_checkable
class Warns(Protocol):
    """A modeler that may leave some of its input unused."""

    def cautions(self, state: Any, result: Any) -> Sequence[Caution]:
        """Return what a person must know of a result; empty where all is well.

        Asked after a final solve, before shapes are handed over: quick.
        """
        ...
