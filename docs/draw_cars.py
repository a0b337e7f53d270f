"""Draw the cars of the gallery, and write down their marks and strokes.

Run ``python docs/draw_cars.py``, with names of cars if not all are wanted; ``coupe-photo`` is the
coupé in a picture that looks like a photograph. The same files come out every time, for the hand
trembles by fixed numbers.
"""

from __future__ import annotations

import json
import re
import sys
import zlib
from pathlib import Path
from typing import Any

import car_designs
import numpy as np
from car_lines import lines
from car_marks import best_drawn, marks_of, strokes_of, styling_of
from car_pencil import Sheet
from car_photos import photograph
from car_seen import Car, Seen
from car_tones import tones
from picture_kit import GALLERY

from bozzetto_car.template.loader import bundled

CARS = GALLERY / "car"


def main(names: list[str], folder: Path = CARS) -> int:
    """Draw all cars, or those that are named, into a folder."""
    photos = {f"{name}-photo": name for name in car_designs.PHOTOGRAPHED}
    for name in names or (*car_designs.VIEWS, *photos):
        if name in photos:
            take(photos[name], name, folder)
            continue
        network, cameras = car_designs.truth(bundled(name))
        car = Car.of(network)
        views, styled = [], []
        for number, camera in enumerate(cameras):
            file = f"{name}-{number + 1}.png" if number else f"{name}.png"
            seen = Seen.of(car, camera)
            draw(seen, folder / file)
            rng = generator(f"{file} marks")
            views.append(told(seen, file, rng))
            styled += styling_of(seen, number, rng)
        write(name, car, views, styled, folder / f"{name}.json")
    return 0


def take(name: str, stem: str, folder: Path) -> None:
    """Make the picture of a car that looks like a photograph, and mark it."""
    network, camera = car_designs.photographed(bundled(name))
    car, file = Car.of(network), f"{stem}.jpg"
    photograph(network, camera, generator(file)).save(folder / file, quality=88)
    seen, rng = Seen.of(car, camera), generator(f"{file} marks")
    views = [told(seen, file, rng)]
    write(name, car, views, styling_of(seen, 0, rng), folder / f"{stem}.json")


def told(seen: Seen, file: str, rng: np.random.Generator) -> dict[str, Any]:
    """What a person tells of one picture."""
    width, height = car_designs.SIZE
    return {
        "kind": "auto",
        "image": {"file": file, "width": width, "height": height},
        "marks": marks_of(seen, rng),
        "strokes": strokes_of(seen, rng),
    }


def write(
    name: str, car: Car, views: list[dict[str, Any]], styled: list[dict[str, Any]], path: Path
) -> None:
    """Write the file of a car."""
    record = {
        "image": views[0]["image"],
        "template": name,
        "views": views,
        "dimensions": {"WB": float(np.ptp(car.wheels[:, 0]))},
        "styling": best_drawn(styled),
    }
    path.write_text(written(record), "utf-8")


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
