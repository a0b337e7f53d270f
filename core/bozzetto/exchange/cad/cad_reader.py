"""STEP and IGES, read: curves exactly, and bodies as triangles near their exact surfaces.

Curves are read by `step_reader` and `iges_reader`. Bodies are read with Open CASCADE, the extra
``bozzetto[cad]`` (`cadquery-ocp-novtk`); without it those that `step_reader` and `iges_reader`
know. Assemblies are taken apart into their bodies, each called like the occurrence that it is of,
or like the product where occurrences have no names of their own. The edges of faces are cut alike
on both sides, so that closed bodies stay closed.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import FormatError
from bozzetto.exchange.cad import iges_reader, step_reader
from bozzetto.exchange.cad.iges_reader import has_faces
from bozzetto.exchange.cad.step_reader import FACES
from bozzetto.exchange.limits import MAX_DEPTH, MAX_FACES, at_most
from bozzetto.exchange.mesh.gltf_scene import LOOKS
from bozzetto.exchange.mesh.polygons import checked_mesh, without_degenerate
from bozzetto.exchange.optional_libraries import library
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.brep.tessellation import TOLERANCE
from bozzetto.geometry.meshed_shapes import meshed
from bozzetto.geometry.shapes import Color, FaceGroup, Finish, Shapes, Solid, Surface

OFF: Final = 5e-4
"""How far triangles may be off their surface, as a share of the size of all."""

TURN: Final = 0.35
"""Angle between neighbouring triangles of a curved surface, radians."""

SAME: Final = 2.0**-22
"""Places that are nearer than this share of the size are one: what float32 can tell apart."""

MAX_BODIES: Final = 20_000

OTHER_FILE: Final = re.compile(
    rb"DOCUMENT_FILE\s?\(\s?'([^']{1,120}\.(?:stp|step))'", re.IGNORECASE
)
"""A part of an assembly that a STEP file only names (ISO 10303-203, external references)."""

UNNAMED: Final = re.compile(
    r"COMPOUND|COMPSOLID|SOLID|SHELL|FACE|WIRE|EDGE|=>\[[\d:]*\]"
    r"|Open CASCADE STEP translator [\d. ]+"
)
"""What the library calls shapes that nobody named: when it reads them, such as several of one
product, and when a program writes them with it."""

AUTOMATIC: Final = re.compile(r"(?:NAUO)?\d*", re.IGNORECASE)
"""What programs call an occurrence of a product if nobody gave it a name."""

NAMED: Final = 4
"""Files that a sentence names."""


class _Look(NamedTuple):
    """The colour of something, and of what it seems to be made."""

    color: Color | None
    finish: Finish = "matt"


@dataclass(frozen=True)
class _Body:
    """A body of the file.

    Attributes
    ----------
    shape : TopoDS_Shape
        In its product.
    place : TopLoc_Location
        Of the product.
    name : str
    look : _Look
    path : tuple of str
        Names of the assemblies that it is in, the outermost first.
    """

    shape: Any
    place: Any
    name: str
    look: _Look
    path: tuple[str, ...]


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read the bodies and curves of a STEP or IGES file.

    Parameters
    ----------
    data : bytes
        The file.
    reading : Reading, optional
        Where it is told what is left out.

    Raises
    ------
    UserError
        If only Open CASCADE knows its faces, and is not installed.
    FormatError
        If the file is damaged or too large, or holds neither faces nor curves.
    """
    reading = reading or Reading()
    step = data[:4096].lstrip().startswith(b"ISO-10303-21")
    if not step and not _is_iges(data):
        raise FormatError("This is neither a STEP nor an IGES file.")
    faces = FACES.search(data) is not None if step else has_faces(data)
    has_kernel = find_spec("OCP") is not None
    read_exactly = step_reader.read_exactly if step else iges_reader.read_exactly
    exact = read_exactly(data, bodies=faces and not has_kernel)
    curves = tuple(exact.curves)
    surfaces: tuple[Surface, ...] = ()
    solids: tuple[Solid, ...] = ()
    lines = 0
    if has_kernel and (faces or not curves):
        surfaces, lines = _bodies_of(data, step, reading)
    elif exact.bodies:
        made = meshed(Shapes(breps=tuple(exact.bodies)))
        surfaces, solids = made.surfaces, made.solids
        _tell_triangles(reading, (*surfaces, *solids), TOLERANCE)
    left = [f"{count} × {what}" for what, count in sorted(exact.other_curves.items())]
    if lines and not curves and not left:
        left = ["a curve" if lines == 1 else f"{lines} curves"]
    if left:
        reading.tell(f"Left out: {', '.join(left)}; save curves as B-splines, or as DXF or SVG.")
    elsewhere = list(dict.fromkeys(OTHER_FILE.findall(data))) if step else []
    if elsewhere:
        names = ", ".join(name.decode("latin-1") for name in elsewhere[:NAMED])
        more = ", …" if len(elsewhere) > NAMED else ""
        reading.tell(
            f"Left out: the parts of this assembly that lie in other files ({names}{more}). Open "
            "those, or save the assembly as one file."
        )
    if faces and not has_kernel and (exact.other_bodies or not exact.bodies):
        if not exact.bodies and not curves:
            library("OCP", "cad")
        count = "Some bodies" if exact.bodies else "The bodies"
        reading.tell(
            f"Left out: {count.lower()}, whose faces are not all planes or whole B-splines. They "
            "need a library. Install it into Bozzetto's Python with: pip install 'bozzetto[cad]'"
        )
    if not (surfaces or solids or curves):
        raise FormatError(
            " ".join(("There are neither faces nor curves in this file.", *reading.left_out))
        )
    return Shapes(solids=solids, surfaces=surfaces, curves=curves)


def _bodies_of(data: bytes, step: bool, reading: Reading) -> tuple[tuple[Surface, ...], int]:
    """Return what Open CASCADE makes of a file's bodies, and how many of its edges are loose."""
    kernel = _Kernel()
    document = kernel.opened(data, step=step)
    bodies = list(kernel.bodies(document))
    at_most(len(bodies), MAX_BODIES, "bodies")
    size = kernel.meshed(bodies)
    found: list[Surface] = []
    lines = triangles = 0
    for body in bodies:
        lines += kernel.loose_edges(body.shape)
        for faces in kernel.faces_by_solid(body.shape):
            surface = kernel.surface(body, faces, size)
            if surface is not None:
                found.append(surface)
                triangles += len(surface.mesh.faces)
                at_most(triangles, MAX_FACES, "triangles")
    if found:
        _tell_triangles(reading, found, OFF, size)
    return tuple(found), lines


def _tell_triangles(
    reading: Reading, parts: Sequence[Surface | Solid], share: float, size: float | None = None
) -> None:
    """Say how far triangles are off what they are made of; `size` is that of all parts, mm."""
    if size is None:
        boxes = np.array([part.mesh.bounds for part in parts], float)
        size = float(np.linalg.norm(boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)))
    triangles = sum(len(part.mesh.faces) for part in parts)
    reading.tell(
        f"Left out: the exact surfaces; their {triangles:,} triangles are at most "
        f"{share * size:.2g} mm off. Keep the file for CAD."
    )


def _is_iges(data: bytes) -> bool:
    """Whether the first line says that it is of the section that IGES begins with."""
    return data[72:73] == b"S" and data[73:80].strip().isdigit()


class _Kernel:
    """The parts of Open CASCADE that are asked."""

    def __init__(self) -> None:
        for module in (
            "BRep", "BRepBndLib", "BRepMesh", "Bnd", "IFSelect", "IGESCAFControl", "Quantity",
            "STEPCAFControl", "TCollection", "TDF", "TDataStd", "TDocStd", "TopAbs", "TopExp",
            "TopLoc", "TopoDS", "XCAFDoc",
        ):  # fmt: skip
            setattr(self, module, library(f"OCP.{module}", "cad"))

        self._main: Any = None
        messages = library("OCP.Message", "cad").Message.DefaultMessenger_s()
        messages.ChangePrinters().Clear()  # it would count entities on our standard output

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    def opened(self, data: bytes, *, step: bool) -> Any:
        """Return the document that is in a file."""
        reader = (
            self.STEPCAFControl.STEPCAFControl_Reader()
            if step
            else self.IGESCAFControl.IGESCAFControl_Reader()
        )
        reader.SetNameMode(True)
        reader.SetColorMode(True)
        document = self.TDocStd.TDocStd_Document(
            self.TCollection.TCollection_ExtendedString("bozzetto")
        )
        handle, path = tempfile.mkstemp(suffix=".step" if step else ".igs")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            status = reader.ReadFile(path)
            done = status == self.IFSelect.IFSelect_ReturnStatus.IFSelect_RetDone
            if not done or not reader.Transfer(document):
                raise FormatError(
                    "It is damaged, or not what its name says. Save it again where it was made."
                )
        finally:
            os.unlink(path)
        return document

    def bodies(self, document: Any) -> Iterator[_Body]:
        """Yield the products of a document, assemblies taken apart, each at its place.

        Where a product is used it may have another colour than its own, which comes first then;
        that of an assembly is for what has none.
        """
        self._main = document.Main()
        tool = self.XCAFDoc.XCAFDoc_DocumentTool.ShapeTool_s(self._main)
        roots = self._filled(tool.GetFreeShapes)
        nowhere = self.TopLoc.TopLoc_Location()
        waiting: list[tuple[Any, Any, str, _Look | None, _Look | None, tuple[str, ...], int]]
        waiting = [(one, nowhere, "", None, None, (), 0) for one in roots]
        shared = self._shared_names(tool)
        seen = 0
        while waiting:
            label, place, name, around, used, path, depth = waiting.pop(0)
            seen += 1
            at_most(seen, 4 * MAX_BODIES, "products")
            at_most(depth, MAX_DEPTH, "levels of assemblies")
            look = used or self._look_of(label)
            if tool.IsReference_s(label):
                place = place.Multiplied(tool.GetLocation_s(label))
                waiting.append((self._product(label), place, name, around, look, path, depth + 1))
                continue
            own = name or self._name(label)
            if tool.IsAssembly_s(label):
                inside = (*path, own) if own else path
                names = self._names_in(tool, label, shared)
                waiting += [
                    (one, place, called or own, look or around, None, inside, depth + 1)
                    for one, called in names
                ]
            else:
                look = look or around or _Look(None)
                yield _Body(tool.GetShape_s(label), place, own, look, path)

    def _shared_names(self, tool: Any) -> set[str]:
        """Return the names that occurrences of several products have: they mean nothing."""
        products: dict[str, str] = {}
        shared = set()
        for whole in self._filled(tool.GetShapes):
            for one in self._filled(partial(tool.GetComponents_s, whole)):
                name, product = self._name(one), self._entry(self._product(one))
                if products.setdefault(name, product) != product:
                    shared.add(name)
        return shared

    def _names_in(self, tool: Any, whole: Any, shared: set[str]) -> Iterator[tuple[Any, str]]:
        """Yield the parts of an assembly with their names; no two assemblies in it have the same.

        An occurrence has its own name, or that of its product where it has none, or one that says
        nothing.
        """
        seen: Counter[str] = Counter()
        for one in self._filled(partial(tool.GetComponents_s, whole)):
            name, product = self._name(one), self._product(one)
            if name in shared or AUTOMATIC.fullmatch(name):
                name = self._name(product) or name
            if tool.IsAssembly_s(product):
                seen[name] += 1
                if seen[name] > 1:
                    name = f"{name} {seen[name]}"
            yield one, name

    def _product(self, occurrence: Any) -> Any:
        """Return the label of the product that is used somewhere."""
        referred = self.TDF.TDF_Label()
        self.XCAFDoc.XCAFDoc_ShapeTool.GetReferredShape_s(occurrence, referred)
        return referred

    def _entry(self, label: Any) -> str:
        """Return what tells a label from all others."""
        text = self.TCollection.TCollection_AsciiString()
        self.TDF.TDF_Tool.Entry_s(label, text)
        return str(text.ToCString())

    def _filled(self, fill: Callable[[Any], object]) -> Any:
        """Return the labels that a function puts into an empty row of them."""
        labels = self._labels()
        fill(labels)
        return labels

    def _labels(self) -> Any:
        """Return an empty row of labels, which is called otherwise since Open CASCADE 8."""
        row = getattr(self.TDF, "TDF_LabelSequence", None)
        return (row or library("OCP.collections", "cad").Sequence_TDF_Label)()

    def _name(self, label: Any) -> str:
        found = self.TDataStd.TDataStd_Name()
        if not label.FindAttribute(self.TDataStd.TDataStd_Name.GetID_s(), found):
            return ""
        text = str(found.Get().ToExtString())[:200]
        text = "".join(sign for sign in text if sign.isprintable()).strip()
        return "" if UNNAMED.fullmatch(text) else text

    def _look_of(self, thing: Any, tool: Any = None) -> _Look | None:
        """Return the look of a label, or with a tool that of a shape."""
        found = self.Quantity.Quantity_ColorRGBA()
        kinds = self.XCAFDoc.XCAFDoc_ColorType
        ask = self.XCAFDoc.XCAFDoc_ColorTool.GetColor_s if tool is None else tool.GetColor
        for kind in (kinds.XCAFDoc_ColorSurf, kinds.XCAFDoc_ColorGen):
            if ask(thing, kind, found):
                values = found.GetRGB().Values(self.Quantity.Quantity_TypeOfColor.Quantity_TOC_sRGB)
                red, green, blue = (round(255 * min(max(float(v), 0.0), 1.0)) for v in values)
                clear = float(found.Alpha()) < 0.5 * (1.0 + LOOKS["glass"][2])
                return _Look((red, green, blue), "glass" if clear else "matt")
        return None

    def meshed(self, bodies: list[_Body]) -> float:
        """Cut all bodies into triangles, and return their size."""
        box = self.Bnd.Bnd_Box()
        for body in bodies:
            self.BRepBndLib.BRepBndLib.Add_s(body.shape, box, False)
        if box.IsVoid():
            return 0.0
        low, high = box.CornerMin(), box.CornerMax()
        size = float(low.Distance(high))
        for body in bodies:
            self.BRepMesh.BRepMesh_IncrementalMesh(body.shape, OFF * size, False, TURN, False)
        return size

    def loose_edges(self, shape: Any) -> int:
        """Return how many edges belong to no face."""
        return sum(1 for _ in self._inside(shape, "EDGE", outside="FACE"))

    def faces_by_solid(self, shape: Any) -> Iterator[list[Any]]:
        """Yield the faces of each solid, of each shell beside, and those that are left."""
        for kind, around in (("SOLID", None), ("SHELL", "SOLID")):
            for body in self._inside(shape, kind, outside=around):
                yield list(self._inside(body, "FACE"))
        yield list(self._inside(shape, "FACE", outside="SHELL"))

    def _inside(self, shape: Any, kind: str, outside: str | None = None) -> Iterator[Any]:
        kinds = self.TopAbs.TopAbs_ShapeEnum
        wanted = [getattr(kinds, f"TopAbs_{one}") for one in (kind, outside or "SHAPE")]
        explorer = self.TopExp.TopExp_Explorer(shape, *wanted)
        while explorer.More():
            yield explorer.Current()
            explorer.Next()

    def surface(self, body: _Body, faces: list[Any], size: float) -> Surface | None:
        """Return the triangles of faces in groups of one colour; None where there are none."""
        tool = self.XCAFDoc.XCAFDoc_DocumentTool.ColorTool_s(self._main)
        places: list[Array] = []
        corners: dict[_Look, list[Index]] = {}
        count = 0
        for face in faces:
            nodes, triangles = self._triangles(face)
            look = self._look_of(face, tool) or body.look
            corners.setdefault(look, []).append(triangles + count)
            places.append(nodes)
            count += len(nodes)
        if not count:
            return None
        grid = SAME * max(size, 1e-9)
        whole = np.concatenate(places)
        _, first, joined = np.unique(
            np.round(whole / grid), axis=0, return_index=True, return_inverse=True
        )
        rows = [
            without_degenerate(joined.ravel()[np.concatenate(row)].astype(np.int32))
            for row in corners.values()
        ]
        if not sum(map(len, rows)):
            return None
        if body.place.Transformation().IsNegative():  # mirrored
            rows = [row[:, ::-1] for row in rows]
        mesh = checked_mesh(_moved(whole[first], body.place), np.concatenate(rows))
        groups = tuple(
            FaceGroup(body.name, len(row), *look)
            for look, row in zip(corners, rows, strict=True)
            if len(row)
        )
        plain = len(groups) == 1 and groups[0].finish == "matt"
        color = groups[0].color if len(groups) == 1 else body.look.color
        return Surface(mesh, body.name, color, () if plain else groups, path=body.path)

    def _triangles(self, face: Any) -> tuple[Array, Index]:
        """Return the places (n, 3) and triangles (m, 3) of one face, in its product."""
        found = self.TopLoc.TopLoc_Location()
        tool = self.TopoDS.TopoDS
        as_face = getattr(tool, "Face_s", None) or tool.Face
        mesh = self.BRep.BRep_Tool.Triangulation_s(as_face(face), found)
        if mesh is None:
            return np.zeros((0, 3)), np.zeros((0, 3), np.intp)
        nodes = [mesh.Node(k) for k in range(1, mesh.NbNodes() + 1)]
        places = np.array([(one.X(), one.Y(), one.Z()) for one in nodes], float)
        rows = np.array([mesh.Triangle(k).Get() for k in range(1, mesh.NbTriangles() + 1)], np.intp)
        if face.Orientation() == self.TopAbs.TopAbs_Orientation.TopAbs_REVERSED:
            rows = rows[:, ::-1]
        return _moved(places, found), rows - 1


def _moved(places: Array, location: Any) -> Array:
    """Return places (n, 3) moved by a location."""
    turn = location.Transformation()
    matrix = np.array([[turn.Value(i, j) for j in (1, 2, 3, 4)] for i in (1, 2, 3)], float)
    return np.asarray(places @ matrix[:, :3].T + matrix[:, 3])
