"""Figures that modelers often report, in a designer's words and units.

A plugin names its figures as its field does; this table says the usual ones as they are
spoken at a table. Whatever is not here is made readable from its key.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from bozzetto_app.i18n import tr

__all__ = ["KnownFigure", "known_figures", "known_values"]

PERCENT = 100.0
PER_CM2, PER_CM3 = 1e-2, 1e-3
"""Square and cubic millimetres in centimetres."""


@dataclass(frozen=True)
class KnownFigure:
    """How one figure is said.

    Parameters
    ----------
    label : str
    tip : str
        What is measured, with the field's own name for it.
    factor : float
        From the reported value to the one shown.
    unit : str
    digits : int
        Decimals; negative: as many as a bare number gets.
    spread : bool
        A list of it is summed up: the middle one, and the largest.
    most : float
        From there on `beyond` is said in its place.
    beyond : str
    """

    label: str
    tip: str
    factor: float = 1.0
    unit: str = ""
    digits: int = -1
    spread: bool = False
    most: float = math.inf
    beyond: str = ""


@lru_cache(maxsize=1)
def known_figures() -> dict[str, KnownFigure]:
    """By the key without its unit."""
    return {
        "iou": KnownFigure(
            tr("Figures", "Match"),
            tr("Figures", "Area that shape and drawing share, of all they cover together (IoU)"),
            PERCENT,
            "%",
            2,
        ),
        "hausdorff": KnownFigure(
            tr("Figures", "Largest deviation"),
            tr("Figures", "Farthest that the contour is from the drawn line (Hausdorff distance)"),
            unit="mm",
            digits=2,
        ),
        "hausdorff_share": KnownFigure(
            tr("Figures", "Deviation by size"),
            tr("Figures", "The largest deviation, as a part of the drawing’s diagonal"),
            PERCENT,
            "%",
            2,
        ),
        "worst_place": KnownFigure(
            tr("Figures", "Worst place"),
            tr("Figures", "Where the contour is farthest from the drawn line"),
            unit="mm",
            digits=0,
        ),
        "status": KnownFigure(
            tr("Figures", "Solid"), tr("Figures", "Whether other programs can use it as a solid")
        ),
        "watertight": KnownFigure(
            tr("Figures", "Watertight"), tr("Figures", "Without a gap, so that it can be printed")
        ),
        "volume": KnownFigure(
            tr("Figures", "Volume"), tr("Figures", "Enclosed by the surface"), PER_CM3, "cm³", 1
        ),
        "area": KnownFigure(
            tr("Figures", "Surface"), tr("Figures", "Area of the surface"), PER_CM2, "cm²", 1
        ),
        "genus": KnownFigure(
            tr("Figures", "Holes"), tr("Figures", "Holes that go through it (genus)")
        ),
        "components": KnownFigure(
            tr("Figures", "Pieces"), tr("Figures", "Pieces that do not touch")
        ),
        "thinnest_wall": KnownFigure(
            tr("Figures", "Thinnest wall"),
            tr("Figures", "Where two sides lie closest together; tips do not count"),
            unit="mm",
            digits=2,
        ),
        "thinnest_place": KnownFigure(
            tr("Figures", "Thinnest place"),
            tr("Figures", "Where the thinnest wall is"),
            unit="mm",
            digits=0,
        ),
        "smallest_detail": KnownFigure(
            tr("Figures", "Smallest detail"),
            tr("Figures", "Nearly all of the shape is thicker than this, tips included"),
            unit="mm",
            digits=2,
        ),
        "size": KnownFigure(
            tr("Figures", "Size"),
            tr("Figures", "Width, depth and height"),
            unit="mm",
            digits=1,
        ),
        "ready": KnownFigure(
            tr("Figures", "Can be printed"),
            tr("Figures", "Closed, in one piece, and no wall is too thin for common printers"),
        ),
        "thickness_ratio": KnownFigure(
            tr("Figures", "Roundness"),
            tr("Figures", "Half the thickness, as a part of the largest circle in the drawing"),
            PERCENT,
            "%",
            0,
        ),
        "asymmetry": KnownFigure(
            tr("Figures", "Asymmetry"),
            tr("Figures", "Difference of the halves before and behind the sheet"),
            PERCENT,
            "%",
            1,
        ),
        "reading": KnownFigure(
            tr("Figures", "Read as"), tr("Figures", "What the strokes of the curve were taken for")
        ),
        "margin": KnownFigure(
            tr("Figures", "Next reading"),
            tr("Figures", "How many times worse the next best reading fits; near 1 it is a guess"),
            unit="×",
            digits=1,
            most=1000.0,
            beyond=tr("Figures", "none"),
        ),
        "sigma": KnownFigure(
            tr("Figures", "Off per pixel"),
            tr("Figures", "Error of points in space for one pixel of error in the drawing"),
            unit="mm",
            digits=2,
            spread=True,
        ),
        "rms": KnownFigure(
            tr("Figures", "Off the ink"),
            tr("Figures", "Distance of the strokes from the picture of the curve (RMS)"),
            unit="px",
            digits=2,
        ),
        "residual": KnownFigure(
            tr("Figures", "Off the marks"),
            tr("Figures", "Distance of the marks from where their points are seen"),
            unit="px",
            digits=1,
            spread=True,
        ),
        "leave_one_out": KnownFigure(
            tr("Figures", "Without its say"),
            tr("Figures", "Distance of each mark from where all the others have it"),
            unit="px",
            digits=1,
            spread=True,
        ),
        "crease": KnownFigure(
            tr("Figures", "Creases"),
            tr("Figures", "Angles at which surfaces meet along their edges"),
            unit="°",
            digits=1,
            spread=True,
        ),
        **{
            short: KnownFigure(words, tip, unit="mm", digits=0)
            for short, words, tip in (
                ("LN", tr("Figures", "Length"), tr("Figures", "From nose to tail")),
                ("WD", tr("Figures", "Width"), tr("Figures", "Without mirrors")),
                ("HG", tr("Figures", "Height"), tr("Figures", "From the ground to the roof")),
                ("FO", tr("Figures", "Front overhang"), tr("Figures", "Nose to front wheel")),
                ("WB", tr("Figures", "Wheelbase"), tr("Figures", "Front wheel to rear wheel")),
            )
        },
    }


@lru_cache(maxsize=1)
def known_values() -> dict[str, tuple[str, bool | None]]:
    """Words that libraries return, said plainly; with a verdict where there is one."""
    return {
        "NoError": (tr("Figures", "sound"), True),
        "NotManifold": (tr("Figures", "not closed"), False),
        "NonFiniteVertex": (tr("Figures", "broken"), False),
        "ok": (tr("Figures", "sound"), True),
        "pair": (tr("Figures", "left and right"), None),
        "self": (tr("Figures", "across the plane"), None),
        "plane": (tr("Figures", "in the plane"), None),
        "half": (tr("Figures", "one side, waiting"), None),
    }
