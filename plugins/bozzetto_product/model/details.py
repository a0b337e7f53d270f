"""Details of finished surfaces, by places that go along with these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.ink import Strokes
from bozzetto.plugin import Parameter, Part
from bozzetto_product.model.appearance import FINISHES, Color, Finish

DetailKind = Literal["in", "raised", "cut", "button", "split"]

KINDS: Final = (
    ("in", "Pressed in"),
    ("raised", "Raised"),
    ("cut", "Cut through"),
    ("button", "Button with a gap"),
    ("split", "Split"),
)
"""Kinds of details, and what people call them."""


@dataclass(frozen=True, eq=False)
class OutlinePlaces:
    """Places of outlines on the surfaces of patches, which go along when these change.

    Parameters
    ----------
    patches : tuple of str
        Ids of the patches.
    rows : (n, 3) int32
        Of each place: number of its patch in `patches`, whether on its mirror image (0, 1), and
        number of the piece of the surface.
    parameters : (n, 2) float64
        u and v there.
    points : (n, 3) float64
        Where they were when they were drawn, mm.
    corners : (n,) uint8
        1 where the outline has a corner, else 0.
    starts : (k,) int32
        First place of each outline.
    pieces : tuple of int
        Of how many pieces the surface of each patch was, 0 for a plane: of more or fewer, the same
        number means another piece. Empty where that is not known, in documents of before.
    """

    patches: tuple[str, ...]
    rows: NDArray[np.int32]
    parameters: NDArray[np.float64]
    points: NDArray[np.float64]
    corners: NDArray[np.uint8]
    starts: NDArray[np.int32]
    pieces: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", frozen(self.rows, np.int32, 3))
        object.__setattr__(self, "parameters", frozen(self.parameters, np.float64, 2))
        object.__setattr__(self, "points", frozen(self.points, np.float64, 3))
        object.__setattr__(self, "corners", frozen(self.corners, np.uint8))
        object.__setattr__(self, "starts", frozen(self.starts, np.int32))
        counts = {len(self.rows), len(self.parameters), len(self.points), len(self.corners)}
        if len(counts) != 1:
            raise ValueError("every place needs a row, parameters, a point and whether a corner")
        if self.pieces and len(self.pieces) != len(self.patches):
            raise ValueError("each patch needs its number of pieces")
        which = self.rows[:, 0]
        if len(which) and not 0 <= which.min() <= which.max() < len(self.patches):
            raise ValueError("a place names a patch that is not there")
        ends = np.append(self.starts, len(self.rows))
        if len(self.starts) and (ends[0] != 0 or (np.diff(ends) < 2).any()):
            raise ValueError("an outline needs two places at least")


@dataclass(frozen=True)
class Detail(Part):
    """A region of a finished surface that is pressed in, raised, cut out, or told apart.

    Parameters
    ----------
    strokes : Strokes
        Raw ink, each stroke with its camera.
    places : OutlinePlaces, optional
        The outlines. None only of the kind of part, before one is drawn.
    closed : bool
        Whether outlines are closed; else they run from border to border, and split only.
    mirrored : bool
        The mirror image in the state's symmetry plane is there as well.
    """

    strokes: Strokes = Strokes()
    places: OutlinePlaces | None = None
    closed: bool = True
    mirrored: Annotated[
        bool, Parameter("Mirrored", help="The same on the other side of the symmetry plane.")
    ] = False
    kind: Annotated[
        DetailKind,
        Parameter(
            "Kind",
            help="What becomes of the area inside.",
            choices=KINDS,
        ),
    ] = "in"
    depth: Annotated[
        float,
        Parameter(
            "Depth",
            1e-3,
            1e4,
            unit="mm",
            help="Of what is pressed in, raised, or a gap.",
            idle_while=(("kind", ("cut", "split")),),
        ),
    ] = 1.0
    draft: Annotated[
        float,
        Parameter(
            "Draft angle",
            0.0,
            60.0,
            0.5,
            unit="°",
            help="Between walls and normals.",
            idle_while=(("kind", ("split",)),),
        ),
    ] = 3.0
    gap: Annotated[
        float,
        Parameter(
            "Gap",
            1e-3,
            1e4,
            unit="mm",
            help="Round a button.",
            idle_while=(("kind", ("in", "raised", "cut", "split")),),
        ),
    ] = 0.5
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this detail.")] = None
    finish: Annotated[
        Finish,
        Parameter("Finish", choices=FINISHES),
    ] = "matt"
