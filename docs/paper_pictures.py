"""The picture of paper that becomes ink: photographs, the traced lines, and solids made of them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from picture_kit import HERE, save

if TYPE_CHECKING:
    from bozzetto.ink.drawing import Drawing

PLUGINS = HERE.parent / "plugins"
PANEL = (480, 360)
"""Width and height of one picture in the row, pixels."""

GAP = 12
"""White between two of them, pixels."""

ROWS = (
    ("bozzetto.silhouette", PLUGINS / "bozzetto_silhouette" / "samples" / "horse.json", 4),
    ("bozzetto.polyhedron", PLUGINS / "bozzetto_polyhedron" / "samples" / "stairs.json", 6),
)


def paper_to_ink() -> None:
    """A photographed outline and a photographed line drawing, from paper to solids."""
    import numpy as np

    rows = [row_of(*row) for row in ROWS]
    width, height = PANEL
    sheet = np.full((2 * height + GAP, 3 * width + 2 * GAP, 4), 255, np.uint8)
    for number, panels in enumerate(rows):
        for column, panel in enumerate(panels):
            top, left = number * (height + GAP), column * (width + GAP)
            sheet[top : top + height, left : left + width] = panel
    save(sheet, "paper-to-ink.png", smooth=True)


def row_of(modeler: str, sample: Path, seed: int) -> tuple[Any, Any, Any]:
    """Return the photograph, the traced lines over the page, and the solid."""
    sys.path.insert(0, str(HERE.parent))
    import numpy as np

    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.ink.trace.placed_ink import page_drawing
    from bozzetto.ink.trace.trace import sheet_of, trace
    from tests.core.ink.trace.figures_paper import PAGE, placed
    from tests.core.ink.trace.pencil_paper import TABLE, paper_picture

    strokes = read_drawing(sample, trusted=True).strokes
    lines = placed([np.asarray(stroke.points, float) for stroke in strokes])
    pressures = [np.asarray(stroke.pressure, float) for stroke in strokes]
    pixels, _ = paper_picture(lines, PAGE, TABLE, seed, pressures)
    sheet = sheet_of(pixels)
    traced = trace(sheet)
    drawing = page_drawing(traced, sheet.size, sample.stem)
    return fitted(pixels), fitted(drawn_over(sheet.pixels, drawing)), solid(modeler, drawing)


def drawn_over(pixels: Any, drawing: Drawing) -> Any:
    """Return a page, faint, with its traced lines."""
    import numpy as np
    from PIL import Image, ImageDraw

    image = Image.blend(
        Image.fromarray(pixels).convert("RGB"), Image.new("RGB", pixels.shape[1::-1], "white"), 0.6
    )
    pen = ImageDraw.Draw(image)
    for stroke in drawing.strokes:
        width = round(3 + 6 * float(np.median(stroke.pressure)))
        places = [(float(x), float(y)) for x, y in stroke.points]
        pen.line(places, fill=(200, 66, 38), width=width, joint="curve")
    return np.asarray(image.convert("RGBA"))


def fitted(pixels: Any) -> Any:
    """Return a picture as large as a panel, its border cut."""
    import numpy as np
    from PIL import Image, ImageOps

    return np.asarray(ImageOps.fit(Image.fromarray(pixels), PANEL, Image.Resampling.LANCZOS))


def solid(modeler: str, drawing: Drawing) -> Any:
    """Return what a modeler makes of a drawing, without its ink, upright where it can do that."""
    from bozzetto.document import Document
    from bozzetto.plugin import Context
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.scene import Scene
    from bozzetto.scene.snapshot import picture
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    model = bench.sources.from_drawing(modeler, drawing, {})
    for command in bench.commands.of(modeler):
        if command.id == "ground":
            model = bench.commands.run(model, command, Context())
    scene = bench.scene(Document((model,)), Job())
    kept = tuple(layer for layer in scene.layers if layer.name not in ("ink", "drawing"))
    return picture(Scene(kept), size=PANEL)


if __name__ == "__main__":
    paper_to_ink()
