"""Materials of OBJ files (MTL), read: colour, and of what a thing seems to be made."""

from __future__ import annotations

import math
import posixpath
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from bozzetto.errors import UserError
from bozzetto.exchange.color import linear_to_srgb
from bozzetto.exchange.limits import at_most
from bozzetto.exchange.mesh.gltf_scene import LOOKS
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import Color, Finish

MAX_MATERIALS: Final = 20_000

MAX_BYTES: Final = 16 << 20
"""Size of a library: a hundred thousand materials."""

ROUGHEST: Final = 1.0
"""Of a material that does not say how rough it is."""

OPAQUE: Final = 1.0

LINEAR: Final = b"# Blender"
"""Begins libraries whose colours are linear; in all others they are as on the screen."""

OPTIONS: Final = {"-o": 3, "-s": 3, "-t": 3, "-mm": 2, "-bm": 1, "-texres": 1, "-clamp": 1}
"""Options before the name of a picture, and how many values they have at most."""


class Look(NamedTuple):
    """Kept part of a material; the picture is a file as named, seen from that of the mesh."""

    color: Color | None = None
    finish: Finish = "matt"
    picture: str = ""


PLAIN: Final = Look()


def materials_of(libraries: Sequence[str], reading: Reading) -> dict[str, Look]:
    """Return the looks of materials by their names.

    Parameters
    ----------
    libraries : sequence of str
        Names of files beside the one that is read; one that is not there is told.
    reading : Reading
        Where they lie, and what is told.
    """
    found: dict[str, Look] = {}
    for name in dict.fromkeys(libraries):
        try:
            data = reading.beside(name, "file of materials")
        except UserError as error:
            reading.tell(f"Left out of the OBJ file: its materials. {error.message}")
            continue
        at_most(len(data), MAX_BYTES, "bytes of materials")
        found |= _looks(data, posixpath.dirname(name.replace("\\", "/")), reading)
    return found


def _looks(data: bytes, folder: str, reading: Reading) -> dict[str, Look]:
    """Return the looks that one library holds; what cannot be understood is passed over."""
    linear = data.startswith(LINEAR)
    said: dict[str, dict[str, list[float]]] = {}
    own: dict[str, list[float]] = {}
    pictures: dict[str, str] = {}
    name = ""
    for line in data.decode("utf-8", "replace").splitlines():
        word, rest = (*line.split(None, 1), "", "")[:2]
        if word == "newmtl":
            name = rest.strip()
            own = said.setdefault(name, {})
            at_most(len(said), MAX_MATERIALS, "materials")
        elif word == "map_Kd":
            file = _picture(rest, reading)
            if file:
                pictures[name] = posixpath.join(folder, file)
        elif word in ("Kd", "d", "Tr", "Ns", "Pr", "Pm"):
            numbers = _numbers(rest)
            if numbers:
                own[word] = numbers
    return {
        name: _look(values, linear=linear)._replace(picture=pictures.get(name, ""))
        for name, values in said.items()
    }


def _picture(rest: str, reading: Reading) -> str:
    """Return the file that a line names, after its options."""
    words = rest.split()
    at = 0
    while at < len(words) and words[at] in OPTIONS:
        option = words[at]
        values: list[str] = []
        at += 1
        while at < len(words) and len(values) < OPTIONS[option]:
            if option != "-clamp" and not _numbers(words[at]):
                break
            values.append(words[at])
            at += 1
        if option in ("-o", "-s", "-t") and any(float(v) != (option == "-s") for v in values):
            reading.tell("Left out of the OBJ file: that a picture is moved or scaled.")
    return rest.split(None, at)[at].strip().replace("\\", "/") if at < len(words) else ""


def _numbers(text: str) -> list[float]:
    """Return the numbers of a line; none if one of them is no finite number."""
    try:
        values = [float(word) for word in text.split()[:3]]
    except ValueError:
        return []
    return values if all(map(math.isfinite, values)) else []


def _look(said: dict[str, list[float]], *, linear: bool) -> Look:
    shade = said.get("Kd", [])
    color: Color | None = None
    if len(shade) == 3:
        bounded = np.clip(shade, 0.0, 1.0)
        values = linear_to_srgb(bounded) if linear else np.rint(255.0 * bounded)
        red, green, blue = (int(value) for value in values)
        color = None if (red, green, blue) == (255, 255, 255) else (red, green, blue)
    if "Pr" not in said and "Pm" not in said and "d" not in said and "Tr" not in said:
        return Look(color)
    opacity = said["d"][0] if "d" in said else OPAQUE - said.get("Tr", [0.0])[0]
    if "Pr" not in said and "Pm" not in said:  # of the two that differ in what lets light through
        some: tuple[Finish, ...] = ("matt", "glass")
        return Look(color, min(some, key=lambda finish: abs(LOOKS[finish][2] - opacity)))
    own = (said.get("Pm", [0.0])[0], said.get("Pr", [ROUGHEST])[0], opacity)
    return Look(color, min(LOOKS, key=lambda finish: math.dist(LOOKS[finish], own)))
