"""What becomes of a region, and the shell that it becomes part of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bozzetto.arrays import Array
from bozzetto_product.details.floor_places import LaidFloor
from bozzetto_product.details.shell import Shell
from bozzetto_product.model.details import DetailKind

Near = Callable[[Array], Array]
"""A place of the chart, (2,), to a point in space near the surface meant there, (3,) mm."""


@dataclass(frozen=True)
class Form:
    """Result of carving a region.

    Parameters
    ----------
    kind : str
    depth : float
        mm.
    draft : float
        Radians.
    gap : float
        mm.
    """

    kind: DetailKind
    depth: float
    draft: float
    gap: float

    @property
    def height(self) -> float:
        """How far its floor is above the surface, mm; below 0 under it."""
        return self.depth if self.kind == "raised" else -self.depth


@dataclass(frozen=True, eq=False)
class Carved:
    """A shell with a region carved.

    Parameters
    ----------
    shell : Shell
    floors : tuple of LaidFloor
        What its walls end in, if that is floors.
    """

    shell: Shell
    floors: tuple[LaidFloor, ...] = ()
