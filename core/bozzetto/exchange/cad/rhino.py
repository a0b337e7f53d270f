"""3dm (Rhino 7): exact surfaces and curves, a layer for each object.

Faces are surfaces of their own, those of one object a group: rhino3dm cannot join them, but
Rhino's own Join can, for their edges agree. It cannot trim either: trimmed faces are triangles
there, and the report of what is left out names them. Written with rhino3dm, the extra
``bozzetto[rhino]``. Every object gets an identity of its own, so that equal shapes give files
that differ there.
"""

from __future__ import annotations

import base64
import re
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.cad.cad_curves import checked_curves
from bozzetto.exchange.cad.cad_surfaces import checked_breps
from bozzetto.exchange.handover import MILLIMETRES, FileFrame, Unit
from bozzetto.exchange.optional_libraries import library
from bozzetto.geometry.basis import lifted
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.brep.tessellation import face_meshes
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import Color, Curve, Shapes

VERSION: Final = 7
"""The version of the file: Rhino 7 and all later ones read it."""

UNIT_WORDS: Final[dict[Unit, str]] = {
    "mm": "Millimeters",
    "cm": "Centimeters",
    "m": "Meters",
    "in": "Inches",
}

UNFIT: Final = re.compile("::")
"""Parts the names of layers that lie in one another."""

DEFAULT_LAYER: Final = "Bozzetto"

BLACK: Final = (0, 0, 0)

BRACKETS: Final = ("(", "[", "{", ")", "]", "}")
"""With these no name begins: openNURBS would drop it."""


def write_shapes(shapes: Shapes, frame: FileFrame = MILLIMETRES) -> bytes:
    """Write the exact surfaces and curves as 3dm, with names, colours and layers.

    Parts of one name lie on one layer of that name and of the first one's colour.

    Raises
    ------
    UserError
        As `checked_breps` and `checked_curves`, or if rhino3dm is not installed.
    """
    rhino = library("rhino3dm", "rhino")
    breps = checked_breps(shapes)
    curves = checked_curves(shapes) if shapes.curves or not breps else ()
    model = rhino.File3dm()
    model.ApplicationName = "Bozzetto"
    model.Settings.ModelUnitSystem = getattr(rhino.UnitSystem, UNIT_WORDS[frame.unit])
    layers = _Layers(rhino, model)
    for number, brep in enumerate(breps):
        group = rhino.Group()
        group.Name = _name(brep.name)
        model.Groups.Add(group)
        whole = all(face.is_whole for face in brep.faces)
        meshes = (None,) * len(brep.faces) if whole else face_meshes(brep)
        for face, mesh in zip(brep.faces, meshes, strict=True):
            look = _look(rhino, face.name or brep.name, face.color or brep.color)
            look.LayerIndex = layers.of(brep.name, brep.color)
            look.AddToGroup(number)
            if mesh is None or face.is_whole:
                model.Objects.AddSurface(_surface(rhino, face.surface), look)
            else:
                model.Objects.AddMesh(_mesh(rhino, mesh), look)
    for curve in curves:
        look = _look(rhino, curve.name, curve.color)
        look.LayerIndex = layers.of(curve.name, curve.color)
        model.Objects.AddCurve(_curve(rhino, curve), look)
    options = rhino.File3dmWriteOptions()
    options.Version = VERSION
    return base64.b64decode(model.Encode(options))


class _Layers:
    """The layers of a model, made when the first object of a name comes."""

    def __init__(self, rhino: Any, model: Any) -> None:
        self._rhino, self._model = rhino, model
        self._known: dict[str, int] = {}

    def of(self, name: str, color: Color | None) -> int:
        """Return the number of the layer of a name."""
        word = UNFIT.sub("_", _name(name)).strip() or DEFAULT_LAYER
        if word not in self._known:
            layer = self._rhino.Layer()
            layer.Name = word
            layer.Color = (*(color or BLACK), 255)
            self._known[word] = self._model.Layers.Add(layer)
        return self._known[word]


def _curve(rhino: Any, curve: Curve) -> Any:
    count = len(curve.control_points)
    made = rhino.NurbsCurve(3, curve.weights is not None, curve.degree + 1, count)
    for place, knot in enumerate(curve.knots[1:-1].tolist()):  # openNURBS has no outermost
        made.Knots[place] = knot
    weights = np.ones(count) if curve.weights is None else curve.weights
    lifted = np.column_stack((curve.control_points * weights[:, None], weights))
    for place, point in enumerate(lifted.tolist()):
        made.Points[place] = rhino.Point4d(*point)
    return made


def _surface(rhino: Any, surface: BSplineSurface) -> Any:
    (m, n), (p, q) = surface.control_points.shape[:2], surface.degrees
    made = rhino.NurbsSurface.Create(3, surface.weights is not None, p + 1, q + 1, m, n)
    for knots, row in ((made.KnotsU, surface.knots_u), (made.KnotsV, surface.knots_v)):
        for place, knot in enumerate(row[1:-1].tolist()):
            knots[place] = knot
    for (i, j), point in zip(np.ndindex(m, n), _rows(surface).tolist(), strict=True):
        made.Points[i, j] = rhino.Point4d(*point)
    return made


def _rows(surface: BSplineSurface) -> Array:
    """Return homogeneous control points, all v of the first u, then of the next, (m n, 4)."""
    return lifted(surface.control_points, surface.weights).reshape(-1, 4)


def _mesh(rhino: Any, mesh: Mesh) -> Any:
    made = rhino.Mesh()
    for place in mesh.vertices.tolist():
        made.Vertices.Add(*place)
    for triangle in mesh.faces.tolist():
        made.Faces.AddFace(*triangle)
    return made


def _look(rhino: Any, name: str, color: Color | None) -> Any:
    look = rhino.ObjectAttributes()
    look.Name = _name(name)
    if color is not None:
        look.ColorSource = rhino.ObjectColorSource.ColorFromObject
        look.ObjectColor = (*color, 255)
    return look


def _name(name: str) -> str:
    return f"_{name}" if name.startswith(BRACKETS) else name
