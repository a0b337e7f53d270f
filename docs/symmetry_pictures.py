"""The pictures of the symmetry modeler: its gallery, and how a curve is drawn in the window."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from picture_kit import GALLERY, grab, opened, pen_stroke, save, until, wait

if TYPE_CHECKING:
    import numpy as np

    from bozzetto.scene import Scene
    from bozzetto.view import Camera
    from bozzetto_app.main_window import Window

INKS = GALLERY / "symmetry"
FOV = 24.0
"""Opening angle of the views, degrees: a long lens."""

VIEWS = {"": (38.0, 20.0), "-side": (90.0, 0.0), "-back": (142.0, 26.0)}
"""Angle from the centre plane and above the floor, degrees, by what follows in the file's name."""

PREVIEW = 3.0
"""Seconds in which a preview is sure to be there, on a machine that does much else, too."""

BEST = {"mouse": (54.0, 36.0), "vacuum-cleaner": (52.0, 22.0)}
"""The first view of what is seen better from elsewhere."""


def gallery() -> None:
    """The drawn objects from three sides; one of them on dark paper."""
    from bozzetto.scene import DARK, LIGHT
    from bozzetto.scene.snapshot import picture

    for path in sorted(INKS.glob("*.json")):
        lines, box = shown(path)
        for ending, angles in VIEWS.items():
            size = (640, 460) if ending else (1200, 800)
            scene = drawn_side(lines) if ending == "-side" else lines if ending else box + lines
            if not ending:
                angles = BEST.get(path.stem, angles)
            view = camera(scene, *angles, size=size)
            dark = path.stem == "car-lines" and not ending
            palette = DARK if dark else LIGHT
            pixels = picture(scene, camera=view, size=size, palette=palette)
            save(pixels, f"{path.stem}{ending}.png", INKS)


def shown(path: Path) -> tuple[Scene, Scene]:
    """The curves of an ink file, none of them chosen; and its box, quiet."""
    from bozzetto.document import Document
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.scene import Layer, Scene
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.symmetry", read_drawing(path), {})
    model = replace(model, state=replace(model.state, selected="", grid=False))
    layers = bench.scene(Document((model,)), Job()).layers
    curves = tuple(
        Layer(layer.name, tuple(replace(item, width=2.8) for item in layer.items))
        for layer in layers
        if layer.name == "curves"
    )
    box = tuple(
        Layer(layer.name, tuple(replace(item, width=1.0, opacity=0.5) for item in layer.items))
        for layer in layers
        if layer.name == "box"
    )
    return Scene(curves), Scene(box)


def drawn_side(lines: Scene) -> Scene:
    """Without the mirror images, which have the second colour."""
    from bozzetto.scene import Layer, Scene

    return Scene(
        tuple(
            Layer(layer.name, tuple(item for item in layer.items if item.color != "second"))
            for layer in lines.layers
        )
    )


def camera(scene: Scene, azimuth: float, elevation: float, *, size: tuple[int, int]) -> Camera:
    """One that shows all of a scene; level ones are parallel, as on a drawing board."""
    import numpy as np

    from bozzetto.view import Camera
    from bozzetto.view.navigation import fit_points
    from bozzetto.view.standard_views import look_along

    a, e = np.radians((azimuth, elevation))
    way = -np.array((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))
    kind = "perspective" if elevation else "orthographic"
    return fit_points(
        look_along(Camera(kind=kind, fov_y=FOV, viewport=size), way), scene.points(), 0.04
    )


# -- in the window --


def window() -> None:
    """A rail in two strokes, bows across, one curve drawn over; the box; the car."""
    import numpy as np

    from bozzetto_app.style.theme import Theme

    window = opened()
    session = window.session
    session.toolbox.take_modeler("bozzetto.symmetry")
    look(window, 4.0, 20.0)
    grab(window, "symmetry-advice.png")

    look(window, 38.0, 20.0)
    side = through((-84, 18, 22), (-52, 33, 50), (0, 38, 64), (52, 31, 56), (88, 14, 30))
    mirror = np.array((1.0, -1.0, 1.0))
    draw(window, side)
    drawn_from = session.view.camera
    look(window, 66.0, 34.0)
    grab(window, "symmetry-first.png")
    session.view.set_camera(drawn_from)
    draw(window, side * mirror, "symmetry-second.png")
    look(window, 66.0, 34.0)
    grab(window, "symmetry-pair.png")

    look(window, 62.0, 32.0)
    for middle, top in ((-26.0, 84.0), (34.0, 82.0)):
        draw(window, bow(middle, top))
    look(window, 38.0, 20.0)
    session.parts.select(session.selection.id, session.parts.of(session.selection.id).parts[0].id)
    rest(window)
    session.toolbox.take_tool("modify")
    stretch = side[50:170]
    hump = np.sin(np.linspace(0.0, np.pi, len(stretch)))[:, None] ** 2
    draw(window, stretch + hump * np.array((0.0, 2.0, -9.0)), "symmetry-modify.png")
    session.toolbox.take_tool("box")
    wait(PREVIEW)
    rest(window)
    grab(window, "symmetry-box.png")
    session.toolbox.take_tool("draw")

    session.files.new()
    window.set_theme(Theme.DARK)
    session.files.exchange.import_file(INKS / "car-lines.json")
    rest(window)
    look(window, 38.0, 16.0)
    session.parts.select(session.selection.id, "")
    wait(PREVIEW)
    rest(window)
    grab(window, "symmetry-car.png")
    window.keeper.close()


def through(*points: tuple[float, float, float] | np.ndarray) -> np.ndarray:
    """A smooth curve through places, (200, 3)."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    places = np.array(points, float)
    steps = np.sqrt(np.linalg.norm(np.diff(places, axis=0), axis=1))
    along = np.concatenate(([0.0], np.cumsum(steps)))
    return np.asarray(CubicSpline(along, places)(np.linspace(0.0, along[-1], 200)))


def bow(middle: float, top: float) -> np.ndarray:
    """A curve across the plane, (200, 3)."""
    import numpy as np

    turn = np.linspace(-1.2, 1.2, 200)
    sides = np.sin(turn) / np.sin(turn[-1])
    drop = 1.0 - np.cos(turn)
    return np.column_stack((middle - 9.0 * drop, 36.0 * sides, top - 32.0 * drop))


def look(window: Window, azimuth: float, elevation: float) -> None:
    """Turn the view so far from the centre plane, with room around the box."""
    session = window.session
    viewport = session.view.camera.viewport
    session.view.set_camera(camera(session.scene.visible, azimuth, elevation, size=viewport))
    window.canvas.views.fit()
    rest(window)


def rest(window: Window) -> None:
    """Let the window come to rest."""
    wait(0.6)
    until(lambda: not window.session.busy)
    wait(1.2)


def draw(window: Window, curve: np.ndarray, picture: str = "") -> None:
    """Draw the image of a curve; with a picture of it when four fifths are drawn."""
    import numpy as np

    ink = window.session.view.camera.project(curve)[0]
    pressure = 0.3 + 0.4 * np.sin(np.linspace(0.0, np.pi, len(ink)))

    def seen() -> None:
        if picture:
            wait(PREVIEW)
            grab(window, picture)

    pen_stroke(window.canvas, ink, pressure, seen)
    rest(window)
