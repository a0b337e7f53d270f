"""Make every picture of the documentation, with the program itself.

Run ``python docs/make_pictures.py`` after a change that can be seen. Nothing is drawn by
hand: the shapes are built from the sample drawings, and the window is the real one, drawn
in with simulated pen events.
"""

from __future__ import annotations

import os
import sys
import tempfile
from typing import TYPE_CHECKING

import car_pictures
import paper_pictures
import product_pictures
import solid_pictures
import symmetry_pictures
from picture_kit import GALLERY, HERE, PICTURES, grab, opened, pen_stroke, save, until, wait

if TYPE_CHECKING:
    from bozzetto_app.main_window import Window

SAMPLES = HERE.parent / "plugins" / "bozzetto_silhouette" / "samples"
OUTLINES = HERE.parent / "tests" / "data" / "silhouettes"


def main() -> int:
    """Make all pictures."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    home = tempfile.mkdtemp(prefix="bozzetto-pictures-")
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME"):
        os.environ[name] = home
    PICTURES.mkdir(exist_ok=True)
    shapes()
    gallery()
    comparison()
    window()
    symmetry_pictures.gallery()
    symmetry_pictures.window()
    car_pictures.gallery()
    car_pictures.bodies()
    car_pictures.templates()
    car_pictures.twists()
    car_pictures.window()
    solid_pictures.samples()
    solid_pictures.linkages()
    solid_pictures.gallery()
    product_pictures.gallery()
    product_pictures.paper()
    paper_pictures.paper_to_ink()
    return 0


# -- shapes, without a window --


def shapes() -> None:
    """The samples as solids, the ink of one, and the skeleton of another."""
    from bozzetto.document import Document
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.scene import DARK, LIGHT, Layer, Lines, Points, Scene, Shaded
    from bozzetto.scene.snapshot import picture
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    heart = bench.sources.from_drawing(
        "bozzetto.silhouette", read_drawing(OUTLINES / "heart.svg"), {}
    )
    seen = bench.model_scene(heart, bench.solve(heart, Job()))
    save(picture(seen, size=(800, 600), shading="zebra"), "heart.png")
    for name in ("horse", "fish", "key"):
        model = bench.sources.from_drawing(
            "bozzetto.silhouette", read_drawing(SAMPLES / f"{name}.json"), {}
        )
        scene = bench.scene(Document((model,)), Job())
        solid = Scene(tuple(layer for layer in scene.layers if layer.name != "ink"))
        palette = DARK if name == "fish" else LIGHT
        save(picture(solid, palette=palette, size=(800, 600)), f"{name}.png")
        ink = Scene(
            tuple(
                Layer("ink", tuple(Lines(i.points, i.starts, "ink", i.width) for i in layer.items))
                for layer in scene.layers
                if layer.name == "ink"
            )
        )
        save(picture(ink, view="front", size=(800, 600)), f"{name}-ink.png")
        if name == "horse":
            shapes = bench.shapes((model,), Job())
            bones = shapes.skeletons[0]
            glass = Shaded(shapes.solids[0].mesh, opacity=0.35)
            lines = [
                Lines(bones.joints[pair], color="second", width=2.5, hidden="show")
                for pair in bones.bones
            ]
            joints = Points(bones.joints, color="accent", size=6.0, hidden="show")
            seen = Scene((Layer("skeleton", (glass, *lines, joints)),))
            save(picture(seen, view="front", size=(800, 600)), "skeleton.png")


def gallery() -> None:
    """The objects of the gallery, from their ink and its steps."""
    from bozzetto.document import Document
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.scene import Scene
    from bozzetto.scene.snapshot import picture
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    for path in sorted(GALLERY.glob("*.json")):
        model = bench.sources.from_drawing("bozzetto.silhouette", read_drawing(path), {})
        scene = bench.scene(Document((model,)), Job())
        solid = Scene(tuple(layer for layer in scene.layers if layer.name == "shape"))
        save(picture(solid, size=(640, 500)), path.with_suffix(".png").name, GALLERY)


def comparison() -> None:
    """Zero lines of fields alone over the outlines: the paper's, the paper's fitted, ours."""
    sys.path.insert(0, str(HERE.parent))
    import numpy as np

    from bozzetto.scene import Layer, Lines, Scene
    from bozzetto.scene.snapshot import picture
    from bozzetto_silhouette.implicit.convolution_field import convolution_field
    from bozzetto_silhouette.outline.normalized import frame_of
    from bozzetto_silhouette.outline.outline import outline_from_rings
    from tests.comparison import weights_of, zero_lines
    from tests.plugins.silhouette.outlines import svg_rings

    def closed(rings: list[np.ndarray], shift: np.ndarray, color: str, width: float) -> Lines:
        around = [np.vstack((ring, ring[:1])) + shift for ring in rings]
        flat = np.concatenate(around)
        starts = np.cumsum([0] + [len(ring) for ring in around[:-1]])
        points = np.column_stack((flat[:, 0], np.zeros(len(flat)), -flat[:, 1]))
        return Lines(points, starts, color=color, width=width)

    items = []
    for row, name in enumerate(("key", "hand-paper", "spider")):
        rings = svg_rings(OUTLINES / f"{name}.svg")
        low, high = np.vstack(rings).min(axis=0), np.vstack(rings).max(axis=0)
        rings = [(ring - 0.5 * (low + high)) / float((high - low).max()) for ring in rings]
        outline = outline_from_rings(rings)
        for column, (rule, kernel, weights) in enumerate(
            (
                ("paper", "cauchy", "local"),
                ("paper", "cauchy", "outline"),
                ("exact", "scalis", "ours"),
            )
        ):
            frame = frame_of(outline, rule)
            field = convolution_field(frame, kernel=kernel)
            shift = 1.15 * np.array([column, row])
            lines = zero_lines(frame, field, weights_of(field))[weights]
            items += [
                closed(rings, shift, "ghost", 3.0),
                closed(lines, shift, "accent", 2.0),
            ]
    scene = Scene((Layer("lines", tuple(items)),))
    save(picture(scene, view="front", size=(900, 900)), "paper-against-default.png")


# -- the real window --


def window() -> None:
    """The window while a horse is drawn in it, when it stands, dark, and after a mistake."""
    import numpy as np

    from bozzetto.exchange.import_file import read_drawing
    from bozzetto_app.style.theme import Theme

    shown = opened()
    session = shown.session
    grab(shown, "window-empty.png")

    drawing = read_drawing(SAMPLES / "horse.json")
    session.view.set_camera(drawing.camera.with_viewport(*session.view.camera.viewport))
    camera = session.view.camera
    scale = camera.pixels_per_mm / drawing.camera.pixels_per_mm
    for stroke in drawing.strokes:
        middle = stroke.points - [part / 2 for part in drawing.camera.viewport]
        path = middle * scale + [part / 2 for part in camera.viewport]
        pen_stroke(shown.canvas, path, stroke.pressure, lambda: grab(shown, "drawing.png"))
    until(lambda: not session.busy)
    wait(2.0)
    shown.canvas.views.look("three-quarter")
    wait(1.0)
    shown.canvas.views.fit()
    wait(1.0)
    until(lambda: not session.busy)
    wait(1.0)
    grab(shown, "window.png")
    shown.set_theme(Theme.DARK)
    wait(1.0)
    grab(shown, "window-dark.png")

    shown.set_theme(Theme.LIGHT)
    session.files.new()
    shown.canvas.views.look("front")
    wait(0.5)
    turn = np.linspace(0.0, 2.0 * np.pi, 120)
    middle = np.array(session.view.camera.viewport) / 2.0
    eight = middle + 220.0 * np.stack((np.sin(turn), 0.6 * np.sin(2.0 * turn)), 1)
    pen_stroke(shown.canvas, eight, np.full(len(turn), 0.5), lambda: None)
    until(lambda: not session.busy)
    wait(0.5)
    grab(shown, "wrong.png")
    creature(shown)
    shown.keeper.close()


def creature(shown: Window) -> None:
    """The creature of the gallery with an ear that is arranged, and its tail that is posed."""
    import numpy as np

    from bozzetto.scene import Handle
    from bozzetto_app.style.theme import Theme

    session = shown.session

    def rest() -> None:
        wait(0.5)
        until(lambda: not session.busy)
        wait(2.0)

    def drag(held: Handle, way: tuple[float, float]) -> None:
        (start,), _ = session.view.camera.project([held.point])
        path = start + np.linspace(0.0, 1.0, 60)[:, None] * way
        pen_stroke(shown.canvas, path, np.full(len(path), 0.5), lambda: None)
        rest()

    session.files.new()
    session.files.exchange.import_file(GALLERY / "creature.json")
    rest()
    shown.canvas.views.look("three-quarter")
    wait(1.0)
    shown.canvas.views.fit()
    rest()
    model, parts = session.selection.id, session.parts.of(session.selection.id).parts
    session.toolbox.take_tool("arrange")
    session.parts.select(model, next(part.id for part in parts if part.name == "Ear"))
    rest()
    grab(shown, "arrange.png")
    shown.set_theme(Theme.DARK)
    session.parts.select(model, "")
    session.objects.set_parameter("posing", True)
    rest()
    joints = [item for _, item in session.scene.visible.items() if isinstance(item, Handle)]
    tail = [item for item in joints if item.tip.startswith("Tail")]
    drag(tail[-1], (-60.0, 90.0))
    grab(shown, "pose.png")


if __name__ == "__main__":
    sys.exit(main())
