"""Draw the products of the gallery: write down the strokes and steps of a simulated hand.

Run ``python docs/draw_products.py``, with names of products if not all are wanted. The same files
come out every time, for the hand trembles by fixed numbers.
"""

from __future__ import annotations

import sys
from pathlib import Path

import product_designs
from picture_kit import GALLERY, HERE

PRODUCTS = GALLERY / "product"
SAMPLES_FOLDER = HERE.parent / "plugins" / "bozzetto_product" / "samples"
SAMPLES = {"mouse": "computer-mouse", "remote": "remote-control", "lamp": "table-lamp"}
"""Products that come with the plugin, and their names there; a picture lies beside each."""


def main(names: list[str], folder: Path = PRODUCTS) -> int:
    """Draw all products, or those that are named, into a folder."""
    folder.mkdir(exist_ok=True)
    for name in names or product_designs.NAMES:
        hand = getattr(product_designs, name)()
        path = hand.write(folder / f"{name}.json")
        if folder == PRODUCTS and name in SAMPLES:
            hand.facts["image"] = {"file": f"{SAMPLES[name]}.png"}
            hand.write(SAMPLES_FOLDER / f"{SAMPLES[name]}.json")
        print(f"wrote {path.name}, {path.stat().st_size // 1000} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
