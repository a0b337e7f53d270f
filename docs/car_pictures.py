"""The pictures of the car modeler: its gallery step by step, and what a body can tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from picture_kit import GALLERY, grab, opened, pen_stroke, save, until, wait
from symmetry_pictures import camera

if TYPE_CHECKING:
    import numpy as np

    from bozzetto.document import Model
    from bozzetto.scene import Palette, Scene
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.main_window import Window
    from bozzetto_car.camera.sketch_camera import SketchCamera
    from bozzetto_car.state import CarState, Sketch

CARS = GALLERY / "car"
DRAWN = (
    "sedan",
    "hatchback",
    "minivan",
    "coupe",
    "estate",
    "suv",
    "pickup",
    "van",
    "city_car",
    "limousine",
)
PANEL = (640, 400)
"""Size of one of six pictures, px: cut like the sketches."""

TRIMMED = (20, 28)
"""What is cut off each above and below, px."""

GAP, CAPTION = 10, 30
"""Between panels, and for the words below each, px."""

WORDS = (
    "1  The sketch and its marks",
    "2  The template, seen through the camera found from them",
    "3  Deformed: camera and shape solved together",
    "4  Edges traced",
    "5  Styling curves, drawn on the body",
    "6  The curves alone",
)
TEMPLATE = (300, 170)
"""Size of a picture of a template, px."""

TEMPLATE_SEEN = ((38.0, 13.0), (142.0, 16.0))
"""From where templates are seen: azimuth and elevation, degrees."""

TWISTS = (480, 270)
"""Size of a picture of twists, px."""

TWISTS_SEEN = ((150.0, 15.0), (40.0, 15.0))
"""From where the cars with twists are seen: azimuth and elevation, degrees."""

FAINT = 0.5
"""Strength of a sketch that has lines over it."""

LARGE = (1200, 750)
LOOKS = {"sedan": (130.0, 12.0), "hatchback": (-140.0, 13.0), "minivan": (138.0, 17.0)}
"""From where the cars with pictures in the text are seen best: angle from the tail and above the
floor, degrees."""

BEHIND = (-35.0, 16.0)
"""Where one looks at what a sketch of the front does not show."""

PATIENCE = 3
"""How often the window is let come to rest, for one answer leads to the next: a view that turns,
say, asks for a scene."""

MARKED_FIRST = 12
MARKED_LAST = 24
"""Marks that are set when a picture of the window is made."""

DRAWN_FROM = {"minivan": 1}
"""The sketch through which the steps are seen, where that is not the first."""


def gallery() -> None:
    """Each drawn car in six steps, seen as it was drawn."""
    for name in DRAWN:
        save(strip(name), f"{name}-steps.png", CARS, smooth=True)


def bodies() -> None:
    """What became of three drawn cars, one on dark paper; colours that tell more of a surface."""
    from bozzetto.scene import DARK, LIGHT

    for name in LOOKS:
        palette = DARK if name == "minivan" else LIGHT
        save(large(name, palette, "styling", look=LOOKS[name]), f"car-{name}.png", smooth=True)
    for shading in ("zebra", "curvature", "certainty"):
        look = BEHIND if shading == "certainty" else LOOKS["hatchback"]
        plain = large("hatchback", LIGHT, look=look, shading=shading)
        save(plain, f"car-{shading}.png", smooth=True)


def templates() -> None:
    """All templates as complete cars, from before and behind."""
    import unicodedata  # the font of the pictures has no accents

    import numpy as np
    from PIL import Image, ImageDraw

    from bozzetto.scene import LIGHT, Scene, render
    from bozzetto.view import Camera, fit_points, triple
    from bozzetto_car.body.build import body_of
    from bozzetto_car.state import CarState
    from bozzetto_car.template.loader import TEMPLATES, bundled
    from bozzetto_car.template.model import ViewHint
    from bozzetto_car.view.scene import scene_of

    across, (width, height) = 2, TEMPLATE
    rows = -(-len(TEMPLATES) // across)
    sheet = Image.new("RGB", (2 * across * width, rows * (height + CAPTION)), LIGHT.paper)
    words = ImageDraw.Draw(sheet)
    for number, name in enumerate(TEMPLATES):
        row, column = divmod(number, across)
        state = CarState(template=name, network=False, complete=True)
        body = body_of(state)
        hidden = ("handles", "joints")
        layers = tuple(one for one in scene_of(state, body).layers if one.name not in hidden)
        places = body.network.positions
        middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
        for turn, seen in enumerate(TEMPLATE_SEEN):
            eye = triple(middle + 14_000.0 * ViewHint(*seen).toward_eye)
            near = Camera("perspective", eye, triple(middle), fov_y=24.0, viewport=TEMPLATE)
            ground = np.vstack((places, places * (1.0, 1.0, 0.0)))
            pixels = render(Scene(layers), fit_points(near, ground, 0.06), LIGHT, size=TEMPLATE)
            at = ((2 * column + turn) * width, row * (height + CAPTION))
            sheet.paste(Image.fromarray(np.asarray(pixels)).convert("RGB"), at)
        below = (2 * column + 1) * width, (row + 1) * (height + CAPTION) - CAPTION // 2
        plain = unicodedata.normalize("NFD", bundled(name).title).encode("ascii", "ignore")
        words.text(below, plain.decode(), LIGHT.ink, anchor="mm", font_size=17)
    save(np.asarray(sheet), "car-templates.png", smooth=True)


def twists() -> None:
    """Zebra stripes on a sedan and a hatchback, each with twists of 0 and with those it has."""
    import numpy as np

    from bozzetto.geometry.patches import Patchwork, coons_nets, shaded
    from bozzetto.scene import DARK, LIGHT, Layer, Scene, Shaded, render
    from bozzetto.view import Camera, fit_points, triple
    from bozzetto_car.template.fair_patches import fair_nets
    from bozzetto_car.template.loader import bundled
    from bozzetto_car.template.model import ViewHint
    from bozzetto_car.template.network import Network

    rows = []
    for name, palette, seen in zip(("sedan", "hatchback"), (LIGHT, DARK), TWISTS_SEEN, strict=True):
        network = Network.of(bundled(name))
        edges, sides = network.control_points, network.template.sides
        row = []
        for nets in (coons_nets(edges, sides), fair_nets(network)):
            mesh = shaded(Patchwork(nets, edges, sides.astype(np.int32)), 24)
            body = Scene((Layer("body", (Shaded(mesh, finish="zebra"),)),))
            places = nets.reshape(-1, 3)
            middle = places.mean(axis=0)
            eye = triple(middle + 14_000.0 * ViewHint(*seen).toward_eye)
            near = Camera("perspective", eye, triple(middle), fov_y=24.0, viewport=TWISTS)
            row.append(render(body, fit_points(near, places, 0.05), palette, size=TWISTS))
        rows.append(np.hstack(row))
    save(np.vstack(rows), "car-twists.png", smooth=True)


def built(name: str) -> tuple[Workbench, Model]:
    """A drawn car from its file of marks, as it was drawn: no dimension is set."""
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.car", read_drawing(CARS / f"{name}.json"), {})
    return bench, replace(model, state=replace(model.state, selected="", wheelbase=0.0))


# -- six steps --


def strip(name: str) -> np.ndarray:
    """Six steps of a car in two rows, with words below each."""
    import numpy as np
    from PIL import Image, ImageDraw, ImageFont

    from bozzetto.scene import LIGHT
    from bozzetto.scene.snapshot import picture

    bench, model = built(name)
    above, below = TRIMMED
    width, height = PANEL[0], PANEL[1] - above - below
    size = (3 * width + 2 * GAP, 2 * (height + CAPTION) + GAP)
    sheet = Image.new("RGB", size, LIGHT.paper)
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(18)
    for number, (scene, sketch_camera) in enumerate(steps(bench, model, DRAWN_FROM.get(name, 0))):
        pixels = picture(scene, camera=sketch_camera.view(PANEL), size=PANEL)[above:-below]
        row, column = divmod(number, 3)
        x, y = column * (width + GAP), row * (height + CAPTION + GAP)
        sheet.paste(Image.fromarray(pixels).convert("RGB"), (x, y))
        pen.text((x + 6, y + height + 4), WORDS[number], fill=LIGHT.ink, font=font)
    return np.asarray(sheet)


def steps(bench: Workbench, model: Model, number: int) -> list[tuple[Scene, SketchCamera]]:
    """The scenes of six steps, each with the stand of the sketch through which it is seen."""
    from bozzetto_car.body.build import body_of
    from bozzetto_car.camera.sketch_camera import SketchCamera
    from bozzetto_car.template.network import Network

    whole: CarState = model.state
    drawn = whole.sketches[number]
    marked = replace(whole, nodes=whole.sketches, edits=())
    deformed, traced = body_of(marked), body_of(whole)
    template, found = deformed.template, deformed.solved.placed[drawn.id].resection
    at_first = SketchCamera.behind(found.camera, found.shift, template.positions)
    then, now = deformed.sketch_cameras[drawn.id], traced.sketch_cameras[drawn.id]
    return [
        (hung(drawn, then, 1.0) + dots(drawn, then), then),
        (hung(drawn, at_first) + lines(Network.of(template)) + dots(drawn, at_first), at_first),
        (hung(drawn, then) + lines(deformed.network) + dots(drawn, then), then),
        (shown(bench, model, ("body", "wheels", "network")), now),
        (shown(bench, model, ("body", "wheels", "styling")), now),
        (shown(bench, model, ("wheels", "styling")), now),
    ]


def hung(drawn: Sketch, sketch_camera: SketchCamera, strength: float = FAINT) -> Scene:
    """A sketch where it hangs."""
    from bozzetto.scene import Layer, Scene

    return Scene((Layer("sketch", (sketch_camera.image(drawn.picture, strength),)),))


def dots(drawn: Sketch, sketch_camera: SketchCamera) -> Scene:
    """The marks of a sketch."""
    from bozzetto.scene import Layer, Points, Scene

    places = sketch_camera.lifted([(mark.u, mark.v) for mark in drawn.marks])
    rim = Points(places, color="paper", size=11.0, hidden="show")
    return Scene((Layer("marks", (rim, Points(places, color="accent", size=7.5, hidden="show"))),))


def lines(network: object) -> Scene:
    """The edges of a template or of a car, those of both sides."""
    from bozzetto.scene import Layer, Scene
    from bozzetto_car.view.edge_items import network_lines

    edges = network_lines(network.control_points, "second", 1.8)
    return Scene((Layer("edges", (replace(edges, hidden="show"),)),))


def shown(bench: Workbench, model: Model, layers: Sequence[str], **values: object) -> Scene:
    """Some layers of a car as the program shows it; styling curves in a broader line."""
    from bozzetto.document import Document
    from bozzetto.plugin.job import Job
    from bozzetto.scene import Layer, Scene

    model = replace(model, state=replace(model.state, **values))
    scene = bench.scene(Document((model,)), Job())
    kept = {layer.name: layer for layer in scene.layers if layer.name in layers}
    if "styling" in kept:
        hidden = "hide" if "body" in kept else "show"
        broad = (replace(item, width=2.6, hidden=hidden) for item in kept["styling"].items)
        kept["styling"] = Layer("styling", tuple(broad))
    return Scene(tuple(kept.values()))


# -- large --


def large(
    name: str, palette: Palette, *layers: str, look: tuple[float, float], **values: object
) -> np.ndarray:
    """A drawn car, with some more layers than its body and wheels."""
    from bozzetto.scene.snapshot import picture

    scene = shown(*built(name), ("body", "wheels", *layers), **values)
    view = camera(scene, *look, size=LARGE)
    return picture(scene, camera=view, size=LARGE, palette=palette)


# -- in the window --


def window() -> None:
    """A dropped sketch with some marks and the loupe at the next one; all marks; a finished car."""
    import json

    from bozzetto_app.style.theme import Theme

    shown = opened()
    session = shown.session
    session.toolbox.take_modeler("bozzetto.car")
    session.files.exchange.import_file(CARS / "sedan.png")
    rest(shown)
    told = json.loads((CARS / "sedan.json").read_text(encoding="utf-8"))["views"][0]["marks"]
    for number in range(MARKED_LAST):
        mark(shown, told, "car-loupe.png" if number == MARKED_FIRST else "")
    rest(shown)
    grab(shown, "car-marked.png")

    session.files.new()
    session.files.exchange.import_file(CARS / "sedan.json")
    rest(shown)
    session.objects.set_parameter("shading", "zebra")
    shown.set_theme(Theme.DARK)
    shown.canvas.views.look("three-quarter")
    rest(shown)
    shown.canvas.views.fit()
    rest(shown)
    grab(shown, "car-window.png")
    shown.keeper.close()


def rest(window: Window) -> None:
    """Let the window come to rest, on a machine that does much else, too."""
    for _ in range(PATIENCE):
        wait(1.5)
        until(lambda: not window.session.busy)


def mark(window: Window, told: dict[str, list[float]], picture: str) -> None:
    """Touch the point that is asked for, or say that it is not seen.

    With a picture of it while the pen is down, if one is wanted.
    """
    import numpy as np

    from bozzetto_car.body.build import body_of
    from bozzetto_car.marking.next_mark import asked_of
    from bozzetto_car.template.model import twin

    session = window.session
    state = session.selection.model.state
    body = body_of(state)
    asked = asked_of(state, body.solved)
    if asked is None:
        return
    # Which side a sketch shows is not known before both wheels are marked.
    names = [asked.node, twin(asked.node)][: 1 + (len(state.sketch.marks) < 2)]
    name = next((name for name in names if name in told), None)
    if name is None:
        session.commands.run("not-visible")
    else:
        sketch_camera = body.sketch_cameras[state.sketch.id]
        until(  # the view goes along with marks
            lambda: sketch_camera.is_seen_through(session.view.camera)
        )
        places = sketch_camera.lifted([told[name]])
        (at,), _ = session.view.camera.project(places)
        path = at + np.linspace(1.0, 0.0, 6)[:, None]
        pen_stroke(window.canvas, path, np.full(6, 0.5), lambda: picture and grab(window, picture))
    wait(0.3)
    until(lambda: not session.busy)
