"""Write how outer dimensions of cars vary together: ``python docs/write_car_sizes.py TABLE.csv``.

The table has a row for each car, with its `length_mm`, `width_mm`, `wheelbase_mm` and, where it is
told, `height_mm_as_tabled`. What is written is a covariance of logarithms; no row of the table, and
no mean, goes into the program.
"""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).parents[1] / "plugins/bozzetto_car/solver/car_sizes.json"
COLUMNS = ("length_mm", "width_mm", "wheelbase_mm", "height_mm_as_tabled")
ABOUT = (
    "Covariance of the natural logarithms of length, width, wheelbase and height of production "
    "cars. Computed from facts tabled in two public teaching data sets: car90 of the R package "
    "rpart (Consumer Reports 1990; package under GPL-2 or GPL-3) and Cars93 of the R package MASS "
    "(Lock 1993; package under GPL-2 or GPL-3). Neither table is contained here; a covariance of "
    "facts is under the licence of this program, Apache-2.0."
)


def covariance_of(path: Path) -> tuple[list[list[float]], int]:
    """Return the covariance (4, 4) of the cars whose height is told, and their number."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = [[row[name] for name in COLUMNS] for row in csv.DictReader(file)]
    told = np.log(np.array([row for row in rows if all(row)], float))
    return np.round(np.cov(told.T), 7).tolist(), len(told)


if __name__ == "__main__":
    covariance, count = covariance_of(Path(sys.argv[1]))
    names = ["length", "width", "wheelbase", "height"]
    made = {"about": ABOUT, "cars": count, "dimensions": names, "covariance": covariance}
    TARGET.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
