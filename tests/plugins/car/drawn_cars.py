"""Cars that no template knows, drawn: with their pictures' marks and strokes, and the truth.

A `Drawn` car knows what a marks file tells (`Drawn.marks_file`) and what it keeps to itself: the
network and the cameras. `drawn` makes one by chance, `in_gallery` gives those of the documentation.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.view import Camera
from bozzetto.view.calibration import resect
from bozzetto_car.body.chain_smoothing import anneal, smooth_chains
from bozzetto_car.body.default_shape import pull_out_panels
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.camera.visibility import facing
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, edge_called, with_tangents
from tests.plugins.car.sketched import FRONT_QUARTER, View, looking, styled
from tests.plugins.car.traced_car import drawn as seen_line

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[3]
GALLERY = ROOT / "docs" / "gallery" / "car"

GALLERY_CARS = ("sedan", "hatchback", "minivan")

TREMOR = 0.7
"""Of a pen on a stroke, px, standard deviation of the bend halfway along."""

STROKED = ("C3-C4", "C4-C5", "C1-C2", "S3.{}-S2.{}", "S4.{}-S3.{}", "B3.{}-B2.{}", "B4.{}-B3.{}")
"""Edges that a random sketch has strokes of: roof, bonnet, shoulder and sill."""


@dataclass(frozen=True)
class Picture:
    """One sketch of a car.

    Attributes
    ----------
    camera : Camera
        The true one; its viewport is the picture.
    marks : dict of str to (float, float)
        By name of the node, px, with a hand's error.
    strokes : dict of str to (k, 2) float
        By name of the edge, px.
    """

    camera: Camera
    marks: dict[str, tuple[float, float]]
    strokes: dict[str, Array]


@dataclass(frozen=True)
class Drawn:
    """A car and its sketches.

    Attributes
    ----------
    network : Network
        The true nodes and edges.
    pictures : tuple of Picture
    """

    network: Network
    pictures: tuple[Picture, ...]

    def marked(self) -> tuple[MarkedView, ...]:
        """The sketches as the solve takes them, with cameras found from the template."""
        template, views = self.template, []
        for picture in self.pictures:
            nodes = np.array([template.node[name] for name in picture.marks])
            marks = np.array(list(picture.marks.values()))
            found = resect(template.positions[nodes], marks, picture.camera.viewport)
            views.append(MarkedView(found.camera, nodes, marks))
        return tuple(views)

    @property
    def template(self) -> Template:
        return self.network.template

    @property
    def positions(self) -> Array:
        return self.network.positions

    def places(self, picture: int = 0) -> Array:
        """Where all nodes are in a picture, (n, 2) px."""
        return self.pictures[picture].camera.project(self.positions)[0]

    def marks_file(self) -> dict[str, Any]:
        """What stands in a marks file: no camera, and nothing of the truth."""
        views = []
        for picture in self.pictures:
            width, height = picture.camera.viewport
            views.append(
                {
                    "kind": "auto",
                    "image": {"width": int(width), "height": int(height)},
                    "marks": {name: list(place) for name, place in picture.marks.items()},
                    "strokes": {name: line.tolist() for name, line in picture.strokes.items()},
                }
            )
        return {"image": views[0]["image"], "template": self.template.id, "views": views}


def drawn(
    template: Template,
    seed: int,
    views: Sequence[View] = (FRONT_QUARTER,),
    hand: float = 2.0,
    kind: str = "perspective",
) -> Drawn:
    """A styled car by chance, with its own tangents; marks on all nodes that face each view."""
    rng = np.random.default_rng(seed)
    network = bent(anneal(Network.of(template, styled(template, seed))), rng)
    pictures = []
    for view in views:
        camera = looking(network.positions, view, rng, kind)
        nodes = np.flatnonzero(facing(template, network.positions, camera))
        places = camera.project(network.positions)[0] + rng.normal(
            0.0, hand, (len(network.positions), 2)
        )
        marks = {template.names[node]: tuple(places[node].tolist()) for node in nodes}
        side = "R" if "WF.R" in marks else "L"
        strokes = {
            name: stroke(network, camera, name, rng)
            for name in (words.format(side, side) for words in STROKED)
            if set(name.split("-")) <= set(marks)
        }
        pictures.append(Picture(camera, marks, strokes))
    return Drawn(network, tuple(pictures))


def bent(network: Network, rng: np.random.Generator, share: float = 0.06) -> Network:
    """Tangents turned and stretched by a share of their length, smooth as the chains want it."""
    lengths = np.linalg.norm(network.tangents, axis=2, keepdims=True)
    moved = network.tangents + rng.normal(0.0, 1.0, network.tangents.shape) * share * lengths
    ends = {(e, k): moved[e, k] for e in range(len(moved)) for k in (0, 1)}
    return pull_out_panels(smooth_chains(with_tangents(network, ends)))


def stroke(network: Network, camera: Camera, name: str, rng: np.random.Generator) -> Array:
    """An edge as a pen goes along it, (k, 2) px."""
    path = seen_line(camera, network.control_points[edge_called(network.template, name)])
    waves = np.arange(1, 4)
    bends = np.sin(np.pi * np.linspace(0.0, 1.0, len(path))[:, None] * waves)
    return np.asarray(path + bends @ (rng.normal(0.0, TREMOR, (3, 2)) / waves[:, None]))


def marks_in(name: str) -> dict[str, Any]:
    """The marks file of a car in the gallery."""
    return dict(json.loads((GALLERY / f"{name}.json").read_text("utf-8")))


@cache
def in_gallery(name: str) -> Drawn:
    """A car of the gallery with the truth that its marks file keeps to itself."""
    network, cameras = in_docs("car_designs").truth(bundled(name))
    pictures = []
    for view, camera in zip(marks_in(name)["views"], cameras, strict=True):
        marks = {node: tuple(place) for node, place in view["marks"].items()}
        strokes = {edge: np.array(line) for edge, line in view["strokes"].items()}
        pictures.append(Picture(camera, marks, strokes))
    return Drawn(network, tuple(pictures))


def in_docs(name: str) -> ModuleType:
    """A module of those that make the documentation's pictures."""
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(ROOT / "docs"))
