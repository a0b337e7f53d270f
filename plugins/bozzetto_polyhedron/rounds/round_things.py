"""What is round in a line drawing: rims, the two rims of a cylinder, and rounded corners."""

from __future__ import annotations

from dataclasses import dataclass

from bozzetto.arrays import Array, Flags
from bozzetto_polyhedron.drawing_on.circles import Circle
from bozzetto_polyhedron.rounds.ellipses import Ellipse


@dataclass(frozen=True, eq=False)
class Rim:
    """A circle as it is seen.

    Parameters
    ----------
    ellipse : Ellipse
        px.
    strokes : tuple of int
        That draw it.
    is_whole : bool
        Whether it is drawn all round; otherwise it is known by the other rim of its cylinder.
    light : bool
        Whether it is drawn as what is hidden.
    """

    ellipse: Ellipse
    strokes: tuple[int, ...]
    is_whole: bool
    light: bool


@dataclass(frozen=True, eq=False)
class Barrel:
    """Two rims of a cylinder.

    Parameters
    ----------
    near, far : int
        Numbers of rims; the near one is drawn whole.
    tangents : tuple of int
        Strokes that are its sides as they are seen.
    outside : bool
        Whether it is seen from outside: what is drawn firmly of the far rim lies beside the near
        one, and not within.
    """

    near: int
    far: int
    tangents: tuple[int, ...]
    outside: bool


@dataclass(frozen=True, eq=False)
class Bend:
    """An arc between two lines, and the same on the other side of the body.

    Parameters
    ----------
    arc : (n, 2) float64
        px.
    corners : (1, 2) or (2, 2) float64
        Where the lines would meet; of a half turn, the corners of the square end in its place.
    shift : (2,) float64
        To the other side, px.
    ends : tuple of (stroke, place, corner)
        Lines that end at the arc, or at the other one: the number of the stroke, where the arc
        begins, and where the line would end, (2,) px each; a number of −1 for one in dashes.
    strokes : tuple of int
        Of both arcs, and of what is tangent to both.
    light : (bool, bool)
        Whether either side is drawn as what is hidden.
    """

    arc: Array
    corners: Array
    shift: Array
    ends: tuple[tuple[int, Array, Array], ...]
    strokes: tuple[int, ...]
    light: tuple[bool, bool]


@dataclass(frozen=True, eq=False)
class Reading:
    """What of a drawing is round.

    Parameters
    ----------
    rims : tuple of Rim
    barrels : tuple of Barrel
    bends : tuple of Bend
    dashes : frozenset of int
        Single dashes about what is round.
    straight : int
        How many straight strokes are left, and rows of dashes.
    light : (s,) bool
        Which strokes were drawn lightly.
    size : float
        Diagonal of the drawing, px.
    """

    rims: tuple[Rim, ...]
    barrels: tuple[Barrel, ...]
    bends: tuple[Bend, ...]
    dashes: frozenset[int]
    straight: int
    light: Flags
    size: float

    @property
    def strokes(self) -> frozenset[int]:
        """Strokes that are no edge: rims, sides of cylinders, arcs."""
        rims = [number for rim in self.rims for number in rim.strokes]
        sides = [number for barrel in self.barrels for number in barrel.tangents]
        bends = [number for bend in self.bends for number in bend.strokes]
        return frozenset((*rims, *sides, *bends, *self.dashes))


@dataclass(frozen=True)
class RoundSizes:
    """Typed sizes of something round, mm; 0 where they are those of the ink.

    Parameters
    ----------
    diameter : float
    depth : float
        How deep a hole is, or how high what stands out.
    """

    diameter: float = 0.0
    depth: float = 0.0


@dataclass(frozen=True, eq=False)
class PlacedRound:
    """What is round, on a body.

    Parameters
    ----------
    circle : Circle
        mm.
    depth : float
        mm; 0 for what goes through, and for arcs.
    """

    circle: Circle
    depth: float = 0.0
