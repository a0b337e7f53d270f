"""3MF as slicers and CAD programs write it: objects, what is put together of them, colours.

Core specification 1.3, the materials extension's colour groups and pictures, and models in several
files of one package (production extension), as Bambu Studio and Orca Slicer save projects.
"""

from __future__ import annotations

import io
import posixpath
import zipfile
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.damaged_files import as_format_errors
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_DEPTH, MAX_FACES, MAX_PARTS, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.polygons import checked_mesh, is_degenerate
from bozzetto.exchange.mesh.stacked_pictures import Pictures
from bozzetto.exchange.reading import Reading
from bozzetto.exchange.safe_xml import parse_events
from bozzetto.exchange.zip_entries import unpacked, unpacking
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import Color, FaceGroup, Shapes, Surface
from bozzetto.geometry.texture import Texture

MILLIMETRES_OF: Final = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}

PLACED: Final = frozenset({"model", "surface"})
"""Types of objects that are shapes; the others are supports and helpers of a slicer."""

MAX_MODEL_BYTES: Final = 400 << 20
"""Largest model, unpacked: some four million triangles."""

MAX_MODELS: Final = 1_000
"""Files of models in one package."""

MAX_REPEATS: Final = 1e6
"""How often a picture may be repeated on its way to a triangle."""

MODEL: Final = "/3D/3dmodel.model"
"""Where nearly all programs keep the model, for packages that do not say where."""

MODEL_KIND: Final = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"

NO_COLOR: Final = -1

FIRST_TEXEL: Final = -2
"""Numbers of corners from here downwards are places in pictures; others are in the palette."""

PLAIN: Final[Color] = (200, 200, 200)
"""Of corners without a colour on a mesh that has others."""

Key = tuple[str, str]
"""Path of the model and id of a resource in it."""


@dataclass
class _Object:
    """A mesh, or a list of other objects at their places."""

    name: str
    kind: str
    group: str
    index: str
    scale: float  # millimetres in a unit of its model
    places: array[float] = field(default_factory=lambda: array("d"))
    corners: array[int] = field(default_factory=lambda: array("q"))
    colors: array[int] = field(default_factory=lambda: array("q"))
    components: list[tuple[Key, Array]] = field(default_factory=list)


@dataclass
class _Package:
    """Content of the models of a package, and the colours that they name."""

    objects: dict[Key, _Object] = field(default_factory=dict)
    palette: list[Color] = field(default_factory=list)
    groups: dict[Key, list[int]] = field(default_factory=dict)  # of the palette, or of texels
    items: list[tuple[Key, Array]] = field(default_factory=list)
    lattices: int = 0
    layered: int = 0
    pictures: dict[Key, str] = field(default_factory=dict)  # where they are
    shown: list[Key] = field(default_factory=list)  # pictures in which places are named
    texels: array[float] = field(default_factory=lambda: array("d"))  # u, v, number of the picture

    def paths(self) -> list[str]:
        """Return where the pictures are that are shown, by their numbers."""
        missing = [key for key in self.shown if key not in self.pictures]
        if missing:
            raise FormatError(f"It names picture {missing[0][1][:20]}, which it does not hold.")
        return [self.pictures[key] for key in self.shown]


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read what lies on the plate, in millimetres.

    Parameters
    ----------
    data : bytes
        The package.
    reading : Reading, optional
        Where it is told what is left out.
    """
    reading = reading or Reading()
    if not data.startswith(b"PK"):
        raise FormatError("This is not a 3MF file.")
    with as_format_errors(), unpacking():
        zipped = zipfile.ZipFile(io.BytesIO(data))
    with as_format_errors(), zipped:
        names = {"/" + name.lstrip("/"): name for name in zipped.namelist()}
        at_most(len(names), 100 * MAX_MODELS, "entries")
        package = _Package()
        first = _start_of(zipped, names)
        models, waiting = {first}, [first]
        while waiting:
            path = waiting.pop()
            if path not in names:
                raise FormatError(f"Its part “{path[:80]}” is missing. Save it again.")
            _ModelReader(package, path, top=path == first).read(
                unpacked(zipped, names[path], MAX_MODEL_BYTES, "a model")
            )
            named = {key[0] for one in package.objects.values() for key, _ in one.components}
            named |= {key[0] for key, _ in package.items}
            waiting += sorted(named - models)
            models |= named
            at_most(len(models), MAX_MODELS, "models")
        pictures = Pictures("3MF", reading)
        for path in package.paths():
            pictures.add(path, partial(_picture, zipped, names, path))
    helpers: set[Key] = set()
    parts = list(_parts(package, pictures, helpers))
    _tell(package, len(helpers), reading)
    if not parts:
        raise FormatError(" ".join(("There are no faces in this file.", *reading.left_out)))
    return Shapes(surfaces=tuple(parts))


def _tell(package: _Package, helpers: int, reading: Reading) -> None:
    for count, what, many, why in (
        (helpers, "a support or helper of a slicer", "{} supports or helpers of a slicer",
         "they are no part of the shape"),
        (package.lattices, "a beam of a lattice", "{} beams of a lattice",
         "save it as triangles in the program that made it"),
        (package.layered, "the layers of a part", "the layers of {} parts",
         "its triangles are read, which may be no more than a box around it"),
    ):  # fmt: skip
        if count:
            words = what if count == 1 else many.format(count)
            reading.tell(f"Left out of the 3MF file: {words} ({why}).")


def _picture(zipped: zipfile.ZipFile, names: dict[str, str], path: str) -> bytes:
    if path not in names:
        raise FormatError("It is not in the file.")
    return unpacked(zipped, names[path], MAX_MODEL_BYTES, "a model")


def _start_of(zipped: zipfile.ZipFile, names: dict[str, str]) -> str:
    """Return the path of the model that the package begins with."""
    found: list[str] = []

    def start(_: str, tag: str, attributes: dict[str, str]) -> None:
        if tag == "Relationship" and attributes.get("Type") == MODEL_KIND:
            found.append("/" + attributes.get("Target", "").lstrip("/"))

    if "/_rels/.rels" in names:
        parse_events(unpacked(zipped, names["/_rels/.rels"], MAX_MODEL_BYTES, "a model"), start)
    start_of = found[0] if found else MODEL
    if start_of not in names:
        raise FormatError("There is no model in this 3MF file. Export it again.")
    return start_of


class _ModelReader:
    """Reads one model of a package; numbers go to arrays as they come, not to a tree."""

    def __init__(self, package: _Package, path: str, *, top: bool) -> None:
        self._package, self._path, self._top = package, path, top
        self._scale = 1.0
        self._object = _Object("", "model", "", "", 1.0)
        self._group: list[int] = []

    def read(self, data: bytes) -> None:
        """Add what a model holds to the package.

        Raises
        ------
        FormatError
            If it is no XML, or a number in it is none.
        """
        parse_events(data, self._started)

    def _started(self, _: str, tag: str, attributes: dict[str, str]) -> None:
        try:
            self._start(tag, attributes)
        except KeyError as error:
            raise FormatError(f"Something in its model lacks “{error.args[0]}”.") from None
        except (ValueError, OverflowError):
            raise FormatError("A number in its model cannot be understood.") from None

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        match tag:
            case "vertex":
                places = self._object.places
                places.append(float(attributes["x"]))
                places.append(float(attributes["y"]))
                places.append(float(attributes["z"]))
                if len(places) % 30_000 == 0:
                    at_most(len(places) // 3, MAX_VERTICES, "vertices")
            case "triangle":
                self._triangle(attributes)
            case "model":
                unit = attributes.get("unit", "millimeter").strip().lower()
                if unit not in MILLIMETRES_OF:
                    raise FormatError(f"Its unit “{unit[:40]}” is none that 3MF knows.")
                self._scale = MILLIMETRES_OF[unit]
            case "object" if (key := (self._path, attributes["id"])) in self._package.objects:
                # Some write a mesh and what hangs on it as two objects with one number.
                self._object = self._package.objects[key]
            case "mesh" if self._object.corners:
                raise FormatError("Two of its meshes have one number. Export it again.")
            case "object":
                self._object = _Object(
                    attributes.get("name", ""),
                    attributes.get("type", "model"),
                    attributes.get("pid", ""),
                    attributes.get("pindex", "0"),
                    self._scale,
                )
                self._package.objects[self._path, attributes["id"]] = self._object
            case "component":
                self._object.components.append(self._placed(attributes))
                at_most(len(self._object.components), MAX_PARTS, "parts")
            case "item" if self._top:
                if attributes.get("printable", "1") in ("1", "true"):
                    self._package.items.append(self._placed(attributes))
                at_most(len(self._package.items), MAX_PARTS, "parts")
            case "basematerials" | "colorgroup":
                self._group = self._package.groups.setdefault((self._path, attributes["id"]), [])
            case "base":
                self._color(attributes.get("displaycolor", ""))
            case "color":
                self._color(attributes.get("color", ""))
            case "beam":
                self._package.lattices += 1
            case "slicestack":
                self._package.layered += 1
            case "texture2d":
                path = posixpath.normpath("/" + attributes["path"].lstrip("/"))
                self._package.pictures[self._path, attributes["id"]] = path
            case "texture2dgroup":
                self._group = self._package.groups.setdefault((self._path, attributes["id"]), [])
                self._package.shown.append((self._path, attributes["texid"]))
                at_most(len(self._package.shown), MAX_PARTS, "pictures")
            case "tex2coord":
                self._texel(float(attributes["u"]), float(attributes["v"]))

    def _placed(self, attributes: dict[str, str]) -> tuple[Key, Array]:
        """Return which object is meant, and its matrix (4, 4) in millimetres, for columns."""
        path = next((said for key, said in attributes.items() if key.endswith(" path")), self._path)
        matrix = np.eye(4)
        if "transform" in attributes:
            numbers = np.array(attributes["transform"].split(), float)
            if numbers.shape != (12,) or not np.isfinite(numbers).all():
                raise ValueError
            matrix[:3] = numbers.reshape(4, 3).T
            matrix[:3, 3] *= self._scale
        return (posixpath.normpath("/" + path.lstrip("/")), attributes["objectid"]), matrix

    def _color(self, said: str) -> None:
        """Add a colour to the group that is open; alpha is passed over."""
        self._group.append(len(self._package.palette))
        digits = said.removeprefix("#")
        if len(digits) not in (6, 8):
            raise FormatError(f"Its colour “{said[:20]}” cannot be understood.")
        red, green, blue = (int(digits[k : k + 2], 16) for k in (0, 2, 4))
        self._package.palette.append((red, green, blue))
        at_most(len(self._package.palette), MAX_VERTICES, "colours")

    def _texel(self, u: float, v: float) -> None:
        """Add a place in a picture to the group that is open."""
        texels = self._package.texels
        if not self._package.shown or not max(abs(u), abs(v)) <= MAX_REPEATS:
            raise ValueError
        self._group.append(FIRST_TEXEL - len(texels) // 3)
        texels.extend((u, v, len(self._package.shown) - 1))
        at_most(len(texels) // 3, 3 * MAX_FACES, "places in pictures")

    def _triangle(self, attributes: dict[str, str]) -> None:
        one = self._object
        one.corners.extend((int(attributes["v1"]), int(attributes["v2"]), int(attributes["v3"])))
        group = self._package.groups.get((self._path, attributes.get("pid", one.group)))
        first = attributes.get("p1", one.index if "pid" not in attributes else "0")
        if group:
            for name in ("p1", "p2", "p3"):
                index = int(attributes.get(name, first))
                if not 0 <= index < len(group):
                    raise FormatError("A triangle names a colour that the file does not hold.")
                one.colors.append(group[index])
        else:
            one.colors.extend((NO_COLOR,) * 3)
        if len(one.corners) % 30_000 == 0:
            at_most(len(one.corners) // 3, MAX_FACES, "triangles")


def _parts(package: _Package, pictures: Pictures, helpers: set[Key]) -> Iterator[Surface]:
    """Yield what lies on the plate, each mesh at its place; one without a name has its group's.

    What is no shape is noted in `helpers`.
    """
    visits = triangles = 0
    waiting = [(key, matrix, "", 1) for key, matrix in reversed(package.items)]
    while waiting:
        key, matrix, name, depth = waiting.pop()
        visits += 1
        at_most(visits, MAX_PARTS, "parts")
        at_most(depth, MAX_DEPTH, "levels of parts")
        one = package.objects.get(key)
        if one is None:
            raise FormatError(f"It names object {key[1][:20]}, which it does not hold.")
        if depth > len(package.objects):
            raise FormatError("One of its parts is a part of itself.")
        if one.kind not in PLACED:
            helpers.add(key)
            continue
        if one.corners:
            triangles += len(one.corners) // 3
            at_most(triangles, MAX_FACES, "triangles")
            yield _surface(one, matrix, one.name or name, package, pictures)
        for inner, own in reversed(one.components):
            waiting.append((inner, matrix @ own, one.name or name, depth + 1))


def _surface(
    one: _Object, matrix: Array, name: str, package: _Package, pictures: Pictures
) -> Surface:
    """Return a mesh at its place; a mirrored one is turned right side out."""
    palette = package.palette
    places = np.frombuffer(one.places, float).reshape(-1, 3) * one.scale
    with np.errstate(all="ignore"):  # what is not finite is refused
        places = places @ matrix[:3, :3].T + matrix[:3, 3]
    faces = np.frombuffer(one.corners, np.int64).reshape(-1, 3)
    colors = np.frombuffer(one.colors, np.int64).reshape(-1, 3)
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        faces, colors = faces[:, ::-1], colors[:, ::-1]
    proper = ~is_degenerate(faces)
    faces, colors = faces[proper], colors[proper]
    if (colors <= FIRST_TEXEL).any():
        texture = _texture(colors, package, pictures)
        if texture is not None:
            return Surface(checked_mesh(places, faces), name, None, texture=texture)
        colors = np.maximum(colors, NO_COLOR)
    if (colors == colors[:1, :1]).all():
        color = palette[colors[0, 0]] if len(colors) and colors[0, 0] != NO_COLOR else None
        return Surface(checked_mesh(places, faces), name, color)
    if (colors == colors[:, :1]).all():  # a colour for each triangle
        order = np.argsort(colors[:, 0], kind="stable")
        kinds, counts = np.unique(colors[:, 0], return_counts=True)
        groups = tuple(
            FaceGroup("", int(count), None if kind == NO_COLOR else palette[kind])
            for kind, count in zip(kinds, counts, strict=True)
        )
        return Surface(checked_mesh(places, faces[order]), name, None, groups)
    checked_mesh(places, faces)
    return Surface(_painted(places, faces, colors, palette), name)


def _texture(colors: Index, package: _Package, pictures: Pictures) -> Texture | None:
    """Return the picture of triangles whose corners (f, 3) have these numbers."""
    texels = np.frombuffer(package.texels, float).reshape(-1, 3)
    pictured: Flags = np.asarray((colors <= FIRST_TEXEL).all(axis=1), bool)
    found = texels[np.where(pictured[:, None], FIRST_TEXEL - colors, 0)]
    shown = np.where(pictured, found[:, 0, 2].astype(np.intp), -1)
    table = np.array([(*color, 255) for color in (*package.palette, PLAIN)], np.uint8)
    plain = table[np.maximum(colors, NO_COLOR)[:, 0]]
    return pictures.texture(shown, package.paths(), found[..., :2], plain)


def _painted(places: Array, faces: Index, colors: Index, palette: list[Color]) -> Mesh:
    """Return a mesh with a colour for each corner: one vertex for each colour at a place."""
    used, corners = np.unique(
        np.stack((faces.ravel(), colors.ravel()), axis=1), axis=0, return_inverse=True
    )
    table = np.array(
        [(*color, 255) for color in (*palette, PLAIN)], np.uint8
    )  # the last one is for corners without a colour
    return checked_mesh(places[used[:, 0]], corners.reshape(-1, 3), colors=table[used[:, 1]])
