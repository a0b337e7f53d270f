"""Cautions: what a result was not made from, or does not keep to, in words."""

from __future__ import annotations

from dataclasses import dataclass


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
