"""Draw the cars of the gallery, and write down their marks and strokes.

Run ``python docs/draw_cars.py``, with names of cars if not all are wanted. The same files come out
every time, for the hand trembles by fixed numbers.
"""

from __future__ import annotations

import json
import re
import sys
import zlib
from pathlib import Path

import car_designs
import numpy as np
from car_lines import lines
from car_marks import best_drawn, marks_of, strokes_of, styling_of
from car_pencil import Sheet
from car_seen import Car, Seen
from car_tones import tones
from picture_kit import GALLERY

from bozzetto_car.template.loader import bundled

CARS = GALLERY / "car"


def main(names: list[str], folder: Path = CARS) -> int:
    """Draw all cars, or those that are named, into a folder."""
    for name in names or car_designs.VIEWS:
        network, cameras = car_designs.truth(bundled(name))
        car = Car.of(network)
        views, styled = [], []
        for number, camera in enumerate(cameras):
            file = f"{name}-{number + 1}.png" if number else f"{name}.png"
            seen = Seen.of(car, camera)
            draw(seen, folder / file)
            rng = generator(f"{file} marks")
            width, height = car_designs.SIZE
            views.append(
                {
                    "kind": "auto",
                    "image": {"file": file, "width": width, "height": height},
                    "marks": marks_of(seen, rng),
                    "strokes": strokes_of(seen, rng),
                }
            )
            styled += styling_of(seen, number, rng)
        record = {
            "image": views[0]["image"],
            "template": name,
            "views": views,
            "dimensions": {"WB": float(np.ptp(car.wheels[:, 0]))},
            "styling": best_drawn(styled),
        }
        (folder / f"{name}.json").write_text(written(record), "utf-8")
    return 0


def draw(seen: Seen, path: Path) -> None:
    """One picture."""
    sheet = Sheet(*car_designs.SIZE, generator(path.name))
    tones(sheet, seen)
    lines(sheet, seen)
    sheet.save(path)
    print(f"wrote {path.name}, {path.stat().st_size // 1000} kB")


def generator(words: str) -> np.random.Generator:
    """The same numbers for the same words."""
    return np.random.default_rng(zlib.crc32(words.encode()))


def written(record: dict[str, object]) -> str:
    """JSON with places in rows, as one would write them by hand."""
    pair = re.compile(r"\[\s+(-?[\d.]+),\s+(-?[\d.]+)\s+\]")
    text = pair.sub(r"[\1, \2]", json.dumps(record, indent=1))
    return re.sub(r"\],\s+\[", "], [", text) + "\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
