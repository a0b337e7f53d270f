"""The words, units and bounds of the figures that `report` tells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from bozzetto.plugin import Figure
from bozzetto_silhouette.analysis.report import PRINTABLE_DETAIL, PRINTABLE_WALL, UNLIKE

PERCENT: Final = 100.0
PER_CM2, PER_CM3 = 1e-2, 1e-3
"""Square and cubic millimetres in centimetres."""

FIGURES: Final[Mapping[str, Figure]] = {
    "iou": Figure(
        "Match", "Area that shape and drawing share, of all they cover together (IoU)",
        "%", PERCENT, 2, good=0.97, bad=0.95,  # the goals of docs/fidelity.md
    ),
    "hausdorff": Figure(
        "Largest deviation",
        "Farthest that the contour is from the drawn line (Hausdorff distance)",
        "mm", digits=2,
    ),
    "hausdorff_share": Figure(
        "Deviation by size", "The largest deviation, as a part of the drawing’s diagonal",
        "%", PERCENT, 2, good=0.008, bad=UNLIKE,  # docs/fidelity.md
    ),
    "worst_place": Figure(
        "Worst place", "Where the contour is farthest from the drawn line", "mm", digits=0
    ),
    "status": Figure(
        "Solid", "Whether other programs can use it as a solid",
        values={
            "NoError": "sound", "NotManifold": "not closed", "NonFiniteVertex": "broken",
        },
        verdicts={"NoError": True, "NotManifold": False, "NonFiniteVertex": False},
    ),
    "watertight": Figure(
        "Watertight", "Without a gap, so that it can be printed", good=True, bad=False
    ),
    "volume": Figure("Volume", "Enclosed by the surface", "cm³", PER_CM3, 1),
    "area": Figure("Surface", "Area of the surface", "cm²", PER_CM2, 1),
    "genus": Figure("Holes", "Holes that go through it (genus)"),
    "components": Figure("Pieces", "Pieces that do not touch"),
    "thinnest_wall": Figure(
        "Thinnest wall", "Where two sides lie closest together; tips do not count",
        "mm", digits=2, good=PRINTABLE_WALL, bad=PRINTABLE_DETAIL,
    ),
    "thinnest_place": Figure("Thinnest place", "Where the thinnest wall is", "mm", digits=0),
    "smallest_detail": Figure(
        "Smallest detail", "Nearly all of the shape is thicker than this, tips included",
        "mm", digits=2,
    ),
    "size": Figure("Size", "Width, depth and height", "mm", digits=1),
    "ready": Figure(
        "Can be printed", "Closed, in one piece, and no wall is too thin for common printers",
        good=True, bad=False,
    ),
    "thickness_ratio": Figure(
        "Roundness", "Half the thickness, as a part of the largest circle in the drawing",
        "%", PERCENT, 0,
    ),
    "flattest": Figure(
        "Flattest place", "Half the thickness where it is flattest, as a part of a round section",
        "%", PERCENT, 0,
    ),
    "asymmetry": Figure(
        "Asymmetry", "Difference of the halves before and behind the sheet", "%", PERCENT, 1
    ),
}  # fmt: skip
