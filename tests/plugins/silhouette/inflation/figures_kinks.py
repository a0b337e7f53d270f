"""Kinked ellipses: ``python -m tests.plugins.silhouette.inflation.figures_kinks``.

Ellipses of 120 by 60 with one slip of the pen, or a tremor all along; seeds that no test uses.
"""

from __future__ import annotations

import numpy as np

from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.inflation.inflation import ConvolutionHeights
from bozzetto_silhouette.inflation.variational_relief import VariationalHeights
from tests.plugins.silhouette.inflation.kinked_ellipses import (
    LONG,
    SHORT,
    ellipse,
    end_shares,
    inflated,
    slipped,
    trembling,
)

COUNT = 30
SEED = 910_000


def main() -> None:
    """Print the table."""
    volume = 4.0 / 3.0 * np.pi * LONG * SHORT**2
    print("| Surface | Ellipse | Volume / ellipsoid, worst | Ends / ellipsoid, 5 %, worst "
          "| Flattest place, worst |")  # fmt: skip
    print("| --- | --- | --- | --- | --- |")
    for surface, heights in (
        ("Interpolate exactly", VariationalHeights()), ("Round", ConvolutionHeights())
    ):  # fmt: skip
        for words, lines in (
            ("clean", [ellipse()[0]]),
            ("a kink of 0.5 to 1.5 px", list(slipped(SEED, COUNT))),
            ("a tremor of 0.3 px", list(trembling(SEED, COUNT))),
        ):
            solids = [inflated(points, heights) for points in lines]
            ends = [share for solid in solids for share in end_shares(solid)]
            found = [measure(solid) for solid in solids]
            shares = np.array([one.volume for one in found]) / volume
            worst = shares[np.abs(shares - 1.0).argmax()]
            print(
                f"| {surface} | {words} | {worst:.3f} | {np.quantile(ends, 0.05):.2f}, "
                f"{min(ends):.2f} | {min(one.flattest for one in found):.2f} |"
            )


if __name__ == "__main__":
    main()
