"""The pictures of the product modeler's gallery: curves, surfaces, and the painted product."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import draw_products
from draw_products import SAMPLES
from picture_kit import GALLERY, save
from symmetry_pictures import camera

if TYPE_CHECKING:
    import numpy as np

    from bozzetto.document import Model
    from bozzetto.scene import Layer, Scene
    from bozzetto.scene.renderer.shading import Shading
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_product.model.state import ProductState

INKS = GALLERY / "product"
LARGE, SMALL, CARD = (1200, 800), (640, 460), (288, 216)

SHADINGS: tuple[Shading, ...] = ("clay", "zebra")
"""Of both rows of the picture of surfaces as in the paper."""

PRESSURE = 0.12
"""Of all surfaces in the picture of those as in the paper."""

VIEWS = {
    "sandal": ((-46.0, 26.0), (-125.0, 38.0)),
    "lamp": ((-60.0, 14.0), (-40.0, -24.0)),
    "shaver": ((-142.0, 26.0), (-52.0, 24.0)),
    "helmet": ((-38.0, 24.0), (-135.0, 18.0)),
    "mouse": ((-52.0, 30.0), (-130.0, 24.0)),
    "remote": ((-58.0, 36.0), (-120.0, 50.0)),
}
"""Where each product is seen best, and a second view: degrees round and above."""


WORN = {"sandal": (226, 190, 166), "helmet": (214, 200, 186)}
"""Products that are shown on what they were drawn on, and its colour."""

WITHIN = 0.985
"""Size of an object that was drawn on: surfaces between curves on it dip below it a little."""


def gallery() -> None:
    """Each product large; beside it its curves, its surfaces in calm colours, and another side."""
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.scene import Scene
    from bozzetto.workbench.workbench import Workbench

    for path in sorted(INKS.glob("*.json")):
        bench = Workbench(Registry())
        model = bench.sources.from_drawing("bozzetto.product", read_drawing(path), {})
        painted, plain, lines = scenes_of(bench, model)
        if path.stem in WORN:
            painted = Scene((*painted.layers, worn_layer(bench, model, WORN[path.stem])))
        pictures_of(path.stem, painted, plain, lines)
    network_card()


def worn_layer(bench: Workbench, model: Model, color: tuple[int, int, int]) -> Layer:
    """The object that a product was drawn on, or its first rough shape, as a body of a colour."""
    from bozzetto.plugin.job import Job
    from bozzetto.scene import Layer, Shaded
    from bozzetto_product.model.rough_shapes import RoughShape
    from bozzetto_product.rough_shapes.shapes import rough_mesh

    if not model.linked:
        shape = next(node for node in model.state.nodes if isinstance(node, RoughShape))
        return Layer("worn", (Shaded(rough_mesh(shape), color=color),))
    (solid,) = bench.own_shapes(model.linked[0], Job()).solids
    middle = solid.mesh.bounds.mean(axis=0)
    vertices = middle + WITHIN * (solid.mesh.vertices - middle)
    mesh = replace(solid.mesh, vertices=vertices.astype("float32"))
    return Layer("worn", (Shaded(mesh, color=color),))


def pictures_of(name: str, painted: Scene, plain: Scene, lines: Scene) -> None:
    """Write the pictures of a product."""
    import numpy as np

    from bozzetto.scene import LIGHT

    first, second = VIEWS.get(name, ((-50.0, 25.0), (130.0, 25.0)))
    save(drawn(painted, first, LARGE, LIGHT), f"{name}.png", INKS, smooth=True)
    row = [
        drawn(lines, first, SMALL, LIGHT),
        drawn(plain, first, SMALL, LIGHT),
        drawn(painted, second, SMALL, LIGHT),
    ]
    save(np.concatenate(row, axis=1), f"{name}-steps.png", INKS, smooth=True)
    if name in SAMPLES:
        card = drawn(painted, first, CARD, LIGHT)
        save(card, f"{SAMPLES[name]}.png", draw_products.SAMPLES_FOLDER)


def network_card() -> None:
    """The picture beside the sample that is a network of curves: its surfaces in calm colours."""
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.scene import LIGHT
    from bozzetto.workbench.workbench import Workbench

    sample = draw_products.SAMPLES_FOLDER / "mouse.json"
    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.product", read_drawing(sample), {})
    _, plain, _ = scenes_of(bench, model)
    card = drawn(plain, VIEWS["mouse"][0], CARD, LIGHT)
    save(card, "mouse.png", draw_products.SAMPLES_FOLDER)


def paper() -> None:
    """The sample fair, as in the paper, and that pressed and evened; below with stripes."""
    import json

    import numpy as np

    from bozzetto.plugin.job import Job
    from bozzetto.scene import LIGHT, Scene
    from bozzetto_product import modeler
    from bozzetto_product.hand_over.imported import product_of_network
    from bozzetto_product.model.patches import CurveGroup, Patch

    sample = Path(modeler.__file__).parent / "samples" / "mouse.json"
    fair = product_of_network(json.loads(sample.read_text(encoding="utf-8")))
    plain = replace(fair, surfaces="paper")
    pressed = tuple(
        replace(node, within="all", pressure=PRESSURE) if isinstance(node, Patch) else node
        for node in plain.nodes
    )
    evened = replace(plain, nodes=(*pressed, CurveGroup("all", "All", v_spring=1.0)))
    product = modeler.ProductModeler()
    rows = []
    for shading in SHADINGS:
        row = []
        for state in (fair, plain, evened):
            layers = product.scene(state, product.solve(state, Job())).layers
            kept = ("surfaces", "curves") if shading == "clay" else ("surfaces",)
            scene = Scene(tuple(layer for layer in layers if layer.name in kept))
            row.append(drawn(scene, (-52.0, 30.0), SMALL, LIGHT, shading))
        rows.append(np.concatenate(row, axis=1))
    save(np.concatenate(rows), "product-paper.png")


def scenes_of(bench: Workbench, model: Model) -> tuple[Scene, Scene, Scene]:
    """A product as it was painted, in calm colours with its curves, and its curves alone."""
    from bozzetto.plugin.job import Job
    from bozzetto.scene import Layer, Lines, Scene
    from bozzetto_product.model.patches import Patch
    from bozzetto_product.model.rough_shapes import RoughShape

    state: ProductState = model.state
    bare = tuple(
        replace(node, visible=False) if isinstance(node, RoughShape) else node
        for node in state.nodes
    )
    model = replace(model, state=replace(state, nodes=bare, selected=""))
    layers = bench.model_scene(model, bench.solve(model, Job())).layers
    calm = tuple(
        replace(node, color=None, finish="matt") if isinstance(node, Patch) else node
        for node in bare
    )
    other = replace(model, state=replace(model.state, nodes=calm))
    plain = bench.model_scene(other, bench.solve(other, Job())).layers

    def only(row: tuple[Layer, ...], *names: str) -> tuple[Layer, ...]:
        return tuple(layer for layer in row if layer.name in names)

    seams = tuple(
        Layer(
            layer.name,
            tuple(
                replace(item, color="ink", width=1.0, opacity=0.4, hidden="hide")
                for item in layer.items
                if isinstance(item, Lines)
            ),
        )
        for layer in only(layers, "curves")
    )
    return (
        Scene((*only(layers, "surfaces"), *seams)),
        Scene(only(plain, "surfaces", "curves", "joints")),
        Scene(only(layers, "curves", "joints")),
    )


def drawn(
    scene: Scene,
    angles: tuple[float, float],
    size: tuple[int, int],
    palette: object,
    shading: Shading = "clay",
) -> np.ndarray:
    """A picture of all of a scene."""
    import numpy as np

    from bozzetto.scene.snapshot import picture

    view = camera(scene, *angles, size=size)
    return np.asarray(picture(scene, camera=view, size=size, palette=palette, shading=shading))
