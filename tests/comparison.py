"""The paper's kernels and skeleton against the default: ``python -m tests.comparison [--write]``.

Every outline is given to every kernel with both skeletons. Measured are the zero line of the
field itself in the plane of the drawing, with local weights and with fitted ones, its height
above the skeleton, and the solid that comes out after the correction. With ``--write`` the
tables go into ``docs/paper-against-default.md``.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.implicit.convolution_field import ConvolutionField, convolution_field
from bozzetto_silhouette.inflation.inflation import ConvolutionHeights
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid, solidify
from bozzetto_silhouette.model.state import Kernel
from bozzetto_silhouette.outline.normalized import Frame, SkeletonRule, frame_of
from bozzetto_silhouette.outline.outline import Outline, outline_from_rings
from tests.fidelity import FOLDERS, cases, even_odd, hausdorff, table
from tests.plugins.silhouette.outlines import svg_rings

Points = NDArray[np.float64]

DOCUMENT = Path(__file__).parents[1] / "docs" / "paper-against-default.md"
KERNELS: tuple[Kernel, ...] = get_args(Kernel)
RULES: tuple[SkeletonRule, ...] = get_args(SkeletonRule)
NAMES = {
    "scalis": "scale-invariant sextic",
    "cauchy": "Cauchy",
    "inverse-cubic": "1 / r³",
    "inverse-quartic": "1 / r⁴",
    "quartic": "compact quartic",
    "sextic": "compact sextic",
}

RASTER = 112
"""Nodes of the raster along the longest side; zero lines run between them."""

MARGIN = 0.12
"""Room around the drawing, as a share of its size: where a field joins limbs it swells."""

RESOLUTION = 64
"""Cells of the solids that are timed and measured."""

HALVINGS = 24
"""Of the interval in which a height is sought."""


@dataclass(frozen=True)
class Found:
    """What was measured of one outline; times in ms."""

    iou: float
    hausdorff: float
    right: bool
    height: float
    ms: float = float("nan")


Row = tuple[Kernel, SkeletonRule, str]
"""Kernel, skeleton, and which weights, or "solid"."""


# -- the field itself ------------------------------------------------------------------------------


def weights_of(field: ConvolutionField) -> dict[str, Points]:
    """Factors for the segments: the local ones, the paper's fit, and ours."""
    from scipy.optimize import nnls

    samples = field.rim.points
    shares = field.summation.over(samples).shares(np.zeros(len(samples)))
    fitted, _ = nnls(shares, np.ones(len(samples)), maxiter=100 * shares.shape[1])
    return {"local": np.ones(len(field.weights)), "outline": fitted, "ours": field.weights}


def zero_lines(
    frame: Frame, field: ConvolutionField, weights: dict[str, Points]
) -> dict[str, list[Points]]:
    """Rings in the object frame along which the uncorrected field has the iso-value in z = 0."""
    from skimage.measure import find_contours

    low, high = (f(frame.rim.points, axis=0) for f in (np.min, np.max))
    step = (1.0 + 2.0 * MARGIN) / RASTER
    axes = [np.arange(a - MARGIN, b + MARGIN + step, step) for a, b in zip(low, high, strict=True)]
    xy = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    shares = field.summation.over(xy.reshape(-1, 2)).shares(np.zeros(xy[..., 0].size))
    start = np.array([axis[0] - step for axis in axes])
    found = {}
    for what, factors in weights.items():
        total = np.maximum(shares @ factors, 1e-5)
        level, _ = field.summation.level(total, np.full(len(total), 0.1))
        # Outside of all, so that every line closes. Fields above the iso-value all over the
        # raster have no line at all.
        padded = np.pad(level.reshape(xy.shape[:2]), 1, constant_values=level.min() - 1.0)
        lines = [line for line in find_contours(padded, 0.0) if len(line) > 3]
        found[what] = [(start + step * line[:-1]) * frame.scale + frame.origin for line in lines]
    return found


def heights(field: ConvolutionField, xy: Points, factors: Points) -> Points:
    """Height of the uncorrected field at points of the plane, by bisection; 0 outside."""
    sums = field.summation.over(xy)
    low, high = np.zeros(len(xy)), np.ones(len(xy))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        total, _ = sums.total(factors, middle, slope=False)
        low, high = np.where(total >= 1.0, middle, low), np.where(total >= 1.0, high, middle)
    return np.sqrt(low)


def _percentile(height: Points, wanted: Points) -> float:
    """Height over the union of the inscribed balls, 95th percentile."""
    return float(np.percentile(height / wanted, 95))


def measured_lines(outline: Outline, frame: Frame, field: ConvolutionField) -> dict[str, Found]:
    """The uncorrected field against the drawing."""
    drawn, weights = outline.polygon(), weights_of(field)
    exact = frame_of(outline).skeleton
    wanted = exact.heights(exact.nodes[:, :2])
    found = {}
    for what, rings in zero_lines(frame, field, weights).items():
        seen = even_odd(rings)
        above = _percentile(heights(field, exact.nodes[:, :2], weights[what]), wanted)
        polygons = [p for p in getattr(seen, "geoms", [seen]) if p.geom_type == "Polygon"]
        if seen.is_empty:
            found[what] = Found(0.0, 1.0, False, above)
            continue
        holes = sum(len(p.interiors) for p in polygons)
        found[what] = Found(
            drawn.intersection(seen).area / drawn.union(seen).area,
            hausdorff(drawn, seen, 1e-3 * outline.diagonal) / outline.diagonal,
            (len(polygons), holes) == (outline.components, outline.genus),
            above,
        )
    return found


# -- the solid -------------------------------------------------------------------------------------


def height_over_balls(solid: SilhouetteSolid, frame: Frame) -> float:
    """Height of a solid above the default skeleton's nodes over the union of its balls."""
    from scipy.interpolate import LinearNDInterpolator

    nodes = frame.skeleton.transformed(frame.scale, frame.origin)
    square = LinearNDInterpolator(solid.plan.points, solid.front)(nodes.nodes[:, :2])
    known = np.isfinite(square)
    wanted = nodes.heights(nodes.nodes[:, :2])
    return _percentile(np.sqrt(square[known]), wanted[known])


def measured_solid(outline: Outline, kernel: Kernel, rule: SkeletonRule) -> Found:
    """The solid that is delivered."""
    begun = time.process_time()
    solid = solidify(
        outline, resolution=RESOLUTION, height_model=ConvolutionHeights(1.4, kernel), rule=rule
    )
    took = 1000.0 * (time.process_time() - begun)
    found = measure(solid)
    above = height_over_balls(solid, frame_of(outline))
    return Found(found.iou, found.hausdorff_share, found.topology_ok, above, took)


def compared(path: Path) -> dict[Row, Found]:
    """Everything about one outline."""
    rings = svg_rings(path)
    found: dict[Row, Found] = {}
    for rule in RULES:
        for kernel in KERNELS:
            # Remembered by the outline itself: another one, so that the time counts all.
            outline = outline_from_rings(rings)
            found[kernel, rule, "solid"] = measured_solid(outline, kernel, rule)
            frame = frame_of(outline, rule)
            field = convolution_field(frame, kernel=kernel)
            for what, one in measured_lines(outline, frame, field).items():
                found[kernel, rule, what] = one
    return found


# -- saying it -------------------------------------------------------------------------------------

FIGURES = (
    "IoU, median", "IoU, worst", "Hausdorff / diagonal, median", "topology right",
    "height / balls, median", "height / balls, worst",
)  # fmt: skip


def figures(found: Sequence[Found]) -> list[str]:
    """One row of a table."""
    iou = np.array([one.iou for one in found])
    far = np.array([one.hausdorff for one in found])
    above = np.array([one.height for one in found])
    return [
        f"{np.median(iou):.4f}",
        f"{iou.min():.4f}",
        f"{100 * np.median(far):.2f} %",
        f"{100 * np.mean([f.right for f in found]):.0f} %",
        f"{np.median(above):.2f}",
        f"{above.max():.2f}",
    ]


def page(found: dict[str, dict[Row, Found]]) -> str:
    """The document."""
    skeleton = {"exact": "ours", "paper": "paper's"}
    fits = {"local": "local", "outline": "global, paper's", "ours": "global, ours"}

    def of(row: Row) -> list[Found]:
        return [one[row] for one in found.values()]

    lines = [
        [NAMES[kernel], skeleton[rule], fits[what], *figures(of((kernel, rule, what)))]
        for rule in reversed(RULES)
        for kernel in KERNELS
        for what in ("local", "outline", "ours")
    ]
    solids = []
    for rule in reversed(RULES):
        for kernel in KERNELS:
            here = of((kernel, rule, "solid"))
            ms = f"{np.median([f.ms for f in here]):.0f} ms"
            row = [NAMES[kernel], skeleton[rule], *figures(here), ms]
            if (kernel, rule) == ("scalis", "exact"):
                row = [f"**{cell}**" for cell in row]
            solids.append(row)
    parts = [
        "# The paper against the default",
        f"Made by `python -m tests.comparison --write` from {len(found)} outlines; do not edit "
        "the tables. How it is computed: [silhouette](silhouette.md), section 9.",
        "**The paper's** (Kukelova and Durikovic, *SketchCo*, 2007): the skeleton of circles of "
        "triangles, kernels in closed form with weights linear along each segment, local weights "
        "first and then a global fit to the outline. **Ours:** the skeleton on the medial axis "
        "with exact radii; the scale-invariant kernel (after Zanni et al., 2013); rows in the fit "
        "that ask for a height and hold the weights even; the correction at the outline; the "
        "fairing. Read into the paper, because we do not have its details: how the circles of a "
        "sleeve are compared, the radii of the local weights, and that the fit's weights are not "
        "negative.",
        "## The field alone",
        f"The zero line of the uncorrected field in the plane of the drawing, on a raster of "
        f"{RASTER}, and its height above the nodes of our skeleton over the union of the "
        "inscribed balls (95th percentile of each outline). *Local*: each segment by its own "
        "radius, as on an endless line. *Global, paper's*: one factor for each segment, least "
        "squares on the outline. *Global, ours*: with the further rows, which pay for heights "
        "with the outline, because the correction will make that exact. A field that is above the "
        "iso-value all over the raster has no line, and an IoU of 0.",
        table(("Kernel", "Skeleton", "Weights", *FIGURES), lines),
        "![Outlines in grey; fields alone in colour](pictures/paper-against-default.png)",
        "The drawn outline in grey; in colour the zero line of the field alone. Left: the paper's "
        "skeleton and Cauchy's kernel with local weights. Middle: the same with the paper's fit. "
        "Right: our skeleton, kernel and fit, before the correction.",
        "## The solid",
        f"After the correction and the fairing, at {RESOLUTION} cells; our fit. Time is "
        "processor time from the outline to the checked solid.",
        table(("Kernel", "Skeleton", *FIGURES, "time, median"), solids),
    ]
    return "\n\n".join(parts) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, print, and on wish write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="outlines; all when none is named")
    parser.add_argument("--write", action="store_true", help=f"write docs/{DOCUMENT.name}")
    given: Any = parser.parse_args(arguments)
    wanted = [case for case in cases(FOLDERS) if not case.is_ink]
    if given.names:
        wanted = [case for case in wanted if case.name in given.names]
    found = {}
    for case in wanted:
        found[case.name] = compared(case.outline)
        print(f"{len(found)} / {len(wanted)} {case.name}", file=sys.stderr, flush=True)
    text = page(found)
    if given.write:
        DOCUMENT.write_text(text, encoding="utf-8")
    else:
        print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
