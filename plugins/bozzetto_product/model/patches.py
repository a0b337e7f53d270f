"""Surfaces within loops of curves, and groups of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from bozzetto.ink import Strokes
from bozzetto.plugin import Group, Parameter, Part
from bozzetto_product.model.appearance import FINISHES, Color, Finish
from bozzetto_product.model.joints import Boundary


@dataclass(frozen=True)
class Patch(Part):
    """A surface within a loop of curves.

    Parameters
    ----------
    boundary : tuple of Run
        Head to tail, counter-clockwise seen from outside. Joints within a run may be added later.
    confirmed : bool
        A person switched it on: finding loops never takes it away.
    mirrored : bool
        The mirror image is there as well.
    pulls, pulls_mirrored : Strokes
        Raw ink, each stroke with its camera, that its contour follows one after another, and
        ink that was drawn so over its mirror image.
    """

    boundary: Boundary = ()
    confirmed: bool = False
    mirrored: bool = False
    pulls: Strokes = Strokes()
    pulls_mirrored: Strokes = Strokes()
    pressure: Annotated[
        float,
        Parameter(
            "Pressure",
            -2.0,
            2.0,
            0.01,
            help="Inflates the surface, or sucks it in; measured by volume.",
        ),
    ] = 0.0
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this surface.")] = None
    finish: Annotated[
        Finish,
        Parameter("Finish", choices=FINISHES),
    ] = "matt"


@dataclass(frozen=True)
class CurveGroup(Group):
    """Parts that belong together; its surfaces may be faired as one."""

    let_go: Annotated[
        float,
        Parameter(
            "Let curves go",
            0.0,
            1.0,
            0.01,
            help="How far curves between the group's surfaces give way to one fair surface.",
        ),
    ] = 0.0
    v_spring: Annotated[
        float,
        Parameter(
            "V-spring",
            0.0,
            1.0,
            0.01,
            help="Of surfaces as in the paper: how far they are evened across their curves.",
        ),
    ] = 0.0
