"""The pictures of the product and polyhedron modelers, from their samples."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from picture_kit import GALLERY, HERE, save

if TYPE_CHECKING:
    import numpy as np

    from bozzetto.document import Model
    from bozzetto.scene import Palette, Scene
    from bozzetto.view import Camera

PLUGINS = HERE.parent / "plugins"
SIZE = (760, 560)
THIRD = (520, 400)
SOLIDS = {"house": 28.0, "bracket": -28.0, "stairs": 28.0, "chair": -28.0, "tower": 28.0}
"""How far each is turned aside, degrees."""

MECHANISMS = {
    "robot-arm": (3.0, 0.0),
    "four-bar": (2.0, 0.0),
    "straight-line": (2.0, 0.0),
    "walking-leg": (2.0, 0.0),
    "walker": (4.0, 0.0),
    "scissor-lift": (1.0, 0.0),
    "folding-screen": (1.2, 0.0),
    "folding-box": (2.0, 0.0),
}
"""For how long each moves, s, and how far it is turned aside, degrees."""


def samples() -> None:
    """The mouse from two sides, with stripes of light; sketches beside the solids they became."""
    from bozzetto.scene import DARK, LIGHT
    from bozzetto.view.standard_views import standard_view

    scene, camera, _ = solved("product", "mouse")
    front = standard_view(camera, "three-quarter")
    both = [
        drawn(scene, front, LIGHT),
        drawn(scene, front, LIGHT, shading="zebra"),
    ]
    save(beside(both), "product-mouse.png")
    from bozzetto.view import turn

    looks = (
        ("bracket", LIGHT, -28.0),
        ("house", DARK, 28.0),
        ("stairs", LIGHT, 28.0),
        ("chair", LIGHT, -28.0),
        ("tower", LIGHT, 28.0),
    )
    for name, palette, angle in looks:
        scene, camera, model = solved("polyhedron", name)
        aside = turn(camera, angle, 6.0)
        pair = [drawn(sketch_of(model), camera, palette), drawn(scene, aside, palette)]
        save(beside(pair), f"polyhedron-{name}.png")


def linkages() -> None:
    """Four linkages after two seconds, with the paths of their points."""
    import numpy as np

    from bozzetto.document import Document
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.scene import LIGHT
    from bozzetto.workbench.films import frames
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    shown = []
    for name in ("four-bar", "straight-line", "walking-leg", "scissor-lift"):
        _, camera, model = solved("polyhedron", name)
        *_, end = frames(bench, Document((model,)), 2.0, 60.0)
        shown.append(drawn(bench.scene(end, Job()), camera, LIGHT))
    rows = [beside(shown[:2]), beside(shown[2:])]
    save(np.concatenate(rows), "polyhedron-linkages.png")


def gallery() -> None:
    """For each line drawing: the sketch, what it became, and how it unfolds or moves."""
    from dataclasses import replace

    from bozzetto.document import Document
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.scene import LIGHT
    from bozzetto.view import turn
    from bozzetto.view.standard_views import standard_view
    from bozzetto.workbench.films import frames
    from bozzetto.workbench.workbench import Workbench

    bench, folder = Workbench(Registry()), GALLERY / "polyhedron"
    folder.mkdir(exist_ok=True)
    for name, angle in SOLIDS.items():
        scene, camera, model = solved("polyhedron", name)
        unfolded = bench.set_parameters(model, {"files": "nets", "tab": 4.0})
        pages = bench.scene(Document((unfolded,)), Job())
        page = replace(pages, layers=tuple(x for x in pages.layers if x.name == "page"))
        row = [
            drawn(sketch_of(model), camera, LIGHT, size=THIRD),
            drawn(scene, turn(camera, angle, 6.0), LIGHT, size=THIRD),
            drawn(page, standard_view(camera, "top"), LIGHT, size=THIRD),
        ]
        save(beside(row), f"{name}.png", folder)
    for name, (seconds, angle) in MECHANISMS.items():
        _, camera, model = solved("polyhedron", name)
        aside = turn(camera, angle, 0.0)
        *_, half = frames(bench, Document((model,)), 0.5 * seconds, 60.0)
        *_, end = frames(bench, half, 0.5 * seconds, 60.0)
        row = [drawn(sketch_of(model), camera, LIGHT, size=THIRD)]
        row += [drawn(bench.scene(each, Job()), aside, LIGHT, size=THIRD) for each in (half, end)]
        save(beside(row), f"{name}.png", folder)


def solved(plugin: str, name: str) -> tuple[Scene, Camera, Model]:
    """Return a sample as it is shown, and the view that it was drawn in."""
    from bozzetto.document import Document
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

    path: Path = PLUGINS / f"bozzetto_{plugin}" / "samples" / f"{name}.json"
    drawing = read_drawing(path)
    bench = Workbench(Registry())
    model = bench.sources.from_drawing(f"bozzetto.{plugin}", drawing, {})
    return bench.scene(Document((model,)), Job()), drawing.camera, model


def sketch_of(model: Model) -> Scene:
    """Return the strokes of a model as they lie on the sheet."""
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.scene import Layer, Lines, Scene

    strokes = Registry().guarded(model.modeler).ink(model.state)
    lines = []
    for stroke in strokes:
        camera = stroke.camera
        places = camera.on_plane(stroke.points, camera.target, camera.axes[2])
        firm = float(stroke.pressure.mean())
        lines.append(
            Lines(places.astype("float32"), width=1.0 + 2.2 * firm, opacity=min(0.35 + firm, 1.0))
        )
    return Scene((Layer("sketch", tuple(lines)),))


def drawn(
    scene: Scene,
    camera: Camera,
    palette: Palette,
    shading: str = "clay",
    size: tuple[int, int] = SIZE,
) -> np.ndarray:
    """Return a picture of all of a scene."""
    from bozzetto.scene.snapshot import picture
    from bozzetto.view import fit_points

    view = fit_points(camera.with_viewport(*size), scene.points())
    return picture(scene, camera=view, size=size, palette=palette, shading=shading)


def beside(pictures: list[np.ndarray]) -> np.ndarray:
    """Return pictures in one row."""
    import numpy as np

    return np.concatenate([np.asarray(each) for each in pictures], axis=1)
