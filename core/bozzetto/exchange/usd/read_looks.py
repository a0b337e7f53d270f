"""Materials of a USD scene, read: colour, picture, and of what a thing seems to be made."""

from __future__ import annotations

import math
import posixpath
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.color import WHITE, linear_to_srgb
from bozzetto.exchange.mesh.gltf_scene import LOOKS
from bozzetto.exchange.reading import Reading
from bozzetto.exchange.usd.usda_text import Asset, ReadPrim
from bozzetto.geometry.shapes import Color, Finish

SURFACE: Final = "UsdPreviewSurface"
PICTURE: Final = "UsdUVTexture"
MOVED: Final = "UsdTransform2d"
RELIEF: Final = ("normal", "occlusion", "emissiveColor", "displacement")

MOST_LINKS: Final = 16
"""Connections that are followed from an input to what it shows."""


class Moved(NamedTuple):
    """How a picture lies by its places: these are scaled, turned and shifted, in this order."""

    scale: tuple[float, float] = (1.0, 1.0)
    degrees: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)

    def places(self, rows: Array) -> Array:
        """Return places (n, 2) where the picture has them."""
        angle = math.radians(self.degrees)
        cos, sin = math.cos(angle), math.sin(angle)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray((rows * self.scale) @ [(cos, sin), (-sin, cos)] + self.offset)


class ReadLook(NamedTuple):
    """Kept part of a material; the picture is a file as named in the scene.

    `places` is the primvar that says where the picture lies; empty where the material names none.
    """

    name: str
    color: Color | None = None
    finish: Finish = "matt"
    picture: str = ""
    places: str = ""
    moved: Moved = Moved()


@dataclass
class ReadLooks:
    """The materials of a scene, those that were asked for so far.

    Parameters
    ----------
    prims : dict of str to ReadPrim
        All of the scene, by their paths.
    reading : Reading
        Where it is told what is left out.
    """

    prims: dict[str, ReadPrim]
    reading: Reading
    _known: dict[str, ReadLook | None] = field(default_factory=dict)

    def bound_to(self, prim: ReadPrim) -> ReadLook | None:
        """Return the look that a prim names; None if it names none that can be read."""
        for name in ("material:binding:preview", "material:binding"):
            for target in prim.targets(name):
                path = absolute(target, prim.path)
                if path not in self._known:
                    self._known[path] = self._look(path)
                return self._known[path]
        return None

    def _look(self, path: str) -> ReadLook | None:
        material = self.prims.get(path)
        if material is None:
            self.reading.tell(
                "Left out of the USD file: a material that is not in it. Save the scene flattened."
            )
            return None
        surface = self._source(material, "outputs:surface")
        if surface is None or surface.word("info:id") != SURFACE:
            found = (one for one in material.walk() if one.word("info:id") == SURFACE)
            surface = next(found, None)
        if surface is None:
            self.reading.tell(
                "Left out of the USD file: a material of a kind that is not read. Save it with "
                "UsdPreviewSurface."
            )
            return ReadLook(material.title)
        picture, places, moved = "", "", Moved()
        source = self._source(surface, "inputs:diffuseColor")
        color: Color | None = None
        if source is not None and source.word("info:id") == PICTURE:
            file = source.values.get("inputs:file")
            picture = str(file) if isinstance(file, Asset) else ""
            places, moved = self._places(source)
        elif source is None:
            shade = surface.numbers("inputs:diffuseColor", 3)
            if shade is not None and len(shade) == 1:
                red, green, blue = (int(v) for v in linear_to_srgb(shade[0]))
                color = None if (red, green, blue) == WHITE else (red, green, blue)
        if any(f"inputs:{name}.connect" in surface.values for name in RELIEF):
            self.reading.tell(
                "Left out of the USD file: pictures of relief, shade or glow (colours are kept)."
            )
        return ReadLook(material.title, color, _finish(surface), picture, places, moved)

    def _places(self, picture: ReadPrim) -> tuple[str, Moved]:
        """Return the primvar by which a picture lies, and how it is moved on the way there."""
        moved, source = Moved(), self._source(picture, "inputs:st")
        if source is not None and source.word("info:id") == MOVED:
            scale, offset = _pair(source, "inputs:scale", 1.0), _pair(source, "inputs:translation")
            moved = Moved(scale, source.number("inputs:rotation") or 0.0, offset)
            source = self._source(source, "inputs:in")
        return ("" if source is None else source.word("inputs:varname")), moved

    def _source(self, prim: ReadPrim, name: str) -> ReadPrim | None:
        """Return the shader that an input is connected to, through whatever is between."""
        for _ in range(MOST_LINKS):
            targets = prim.targets(f"{name}.connect")
            if not targets:
                return None
            holder, _, name = absolute(targets[0], prim.path).rpartition(".")
            found = self.prims.get(holder)
            if found is None or found.word("info:id"):
                return found
            prim = found
        return None


def _pair(prim: ReadPrim, name: str, usual: float = 0.0) -> tuple[float, float]:
    """Return the value of a property that is two numbers."""
    value = prim.numbers(name, 2)
    if value is None or value.shape != (1, 2):
        return usual, usual
    return float(value[0, 0]), float(value[0, 1])


def absolute(path: str, here: str) -> str:
    """Return a path from the root, of one that may be seen from a prim."""
    return posixpath.normpath(posixpath.join(here, path))


def _finish(surface: ReadPrim) -> Finish:
    """Return the finish whose looks are nearest; what is not said is as USD has it."""
    own = []
    for name, usual in (("metallic", 0.0), ("roughness", 0.5), ("opacity", 1.0)):
        said = surface.number(f"inputs:{name}")
        own.append(usual if said is None or not math.isfinite(said) else min(max(said, 0.0), 1.0))
    return min(LOOKS, key=lambda finish: math.dist(LOOKS[finish], own))
