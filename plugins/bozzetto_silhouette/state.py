"""The recipe of a silhouette model: outlines on sheets, and how to inflate them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from bozzetto.ink import Strokes
from bozzetto.plugin import Parameter
from bozzetto_silhouette.sheet import Sheet

__all__ = ["Part", "SilhouetteState"]


@dataclass(frozen=True)
class Part:
    """One outline with its holes.

    Parameters
    ----------
    strokes : Strokes
        Raw ink: the outer outline and the outlines of holes, in the order drawn.
    sheet : Sheet
        Where they lie.
    """

    strokes: Strokes
    sheet: Sheet = Sheet()


@dataclass(frozen=True)
class SilhouetteState:
    """Parts and the parameters that all of them share."""

    parts: tuple[Part, ...] = ()
    inflation: Annotated[
        float,
        Parameter(
            "Inflation",
            0.2,
            3.0,
            step=0.05,
            help="How deep the shape swells; 1 is round, the silhouette stays as drawn.",
        ),
    ] = 1.0
    softness: Annotated[
        float,
        Parameter(
            "Blend softness",
            1.25,
            2.0,
            step=0.05,
            help="How softly limbs flow into the body.",
        ),
    ] = 1.4
    resolution: Annotated[
        int,
        Parameter(
            "Resolution",
            32,
            256,
            step=16,
            unit="cells",
            help="Cells along the longest side; thin places are always refined.",
        ),
    ] = 128
