"""Curves that are learnt when a tool first asks for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, overload

from bozzetto.cached_properties import cached_property

if TYPE_CHECKING:
    from bozzetto.geometry.shapes import Curve


class LazyCurves(Sequence["Curve"]):
    """A row of curves that is made when it is first looked at, and then kept.

    Parameters
    ----------
    make : callable
        Gives the curves; what it raises reaches who looks, and who looks again asks again.
    """

    def __init__(self, make: Callable[[], tuple[Curve, ...]]) -> None:
        self._make = make

    @cached_property
    def _curves(self) -> tuple[Curve, ...]:
        return self._make()

    @overload
    def __getitem__(self, index: int) -> Curve: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Curve, ...]: ...
    def __getitem__(self, index: int | slice) -> Curve | tuple[Curve, ...]:
        return self._curves[index]

    def __len__(self) -> int:
        return len(self._curves)

    def __add__(self, other: tuple[Curve, ...]) -> tuple[Curve, ...]:
        return (*self, *other)

    def __radd__(self, other: tuple[Curve, ...]) -> tuple[Curve, ...]:
        return (*other, *self)
