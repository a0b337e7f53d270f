"""USD, read: the meshes of a scene with their names, materials, pictures and bones.

From text (``.usda``), from the binary form (``.usdc``), and from packages with either (``.usdz``).
What a scene takes from other files comes from the same folder, or from the same package.
"""

from __future__ import annotations

import io
import zipfile
from collections import Counter
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.damaged_files import as_format_errors
from bozzetto.errors import FormatError
from bozzetto.exchange.color import WHITE, linear_to_srgb
from bozzetto.exchange.limits import (
    MAX_DEPTH,
    MAX_FACES,
    MAX_MESH_BYTES,
    MAX_PARTS,
    MAX_VERTICES,
    at_most,
)
from bozzetto.exchange.mesh.polygons import check_places, checked_mesh, is_degenerate, triangulate
from bozzetto.exchange.mesh.stacked_pictures import Pictures
from bozzetto.exchange.reading import Reading
from bozzetto.exchange.usd.analytic_bodies import ANALYTIC, OFF, put_mesh
from bozzetto.exchange.usd.composition import Composition
from bozzetto.exchange.usd.read_copies import SCATTER, copies_of
from bozzetto.exchange.usd.read_looks import ReadLook, ReadLooks
from bozzetto.exchange.usd.read_places import local_matrix, moves
from bozzetto.exchange.usd.read_skeletons import RATE, ReadSkeletons
from bozzetto.exchange.usd.usda_text import ReadPrim
from bozzetto.exchange.zip_entries import unpacked, unpacking
from bozzetto.geometry.rig import Skin
from bozzetto.geometry.shapes import FaceGroup, Shapes, Surface

SCENES: Final = (".usda", ".usdc", ".usd")

MAX_ENTRIES: Final = 100_000

UNIT: Final = 0.01
"""Metres in a unit, where a file does not say it."""

Y_UP: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rows: our x, y and z (up) from x, y (up) and z of the file."""

CURVED: Final = frozenset(("BasisCurves", "NurbsCurves", "NurbsPatch", "HermiteCurves", "Points"))
HIDDEN: Final = frozenset(("proxy", "guide"))
"""Purposes of what is there for the work only."""

PLACES: Final = ("primvars:st", "primvars:UVMap", "primvars:st0", "primvars:map1")
"""Places in pictures, as most programs call them."""

PAINTS: Final = (("primvars:displayColor", 3), ("primvars:Color", 4), ("primvars:Col", 4))
"""Colours of vertices, and how many numbers each is: USD's own, and as Blender calls them."""

NOTE: Final = "userProperties:"
"""Begins the names of custom properties."""

BLENDERS: Final = "userProperties:blender:"
"""Begins those that Blender writes of itself."""

OBJECTS_NAME: Final = f"{BLENDERS}object_name"
DATAS_NAME: Final = f"{BLENDERS}data_name"
"""Names that Blender's objects, and what they show, have there."""

MAX_REPEATS: Final = 1e6
"""How often a picture may be repeated on its way to a triangle."""


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read the meshes of a scene, in millimetres with Z up.

    Parameters
    ----------
    data : bytes
        Text, or a package.
    reading : Reading, optional
        Where pictures lie beside it, and what is told.
    """
    reading = reading or Reading()
    if not data.startswith(b"PK"):
        scene = Composition(reading.beside)
        return _Scene(scene.composed(data), reading, scene).shapes()
    with as_format_errors(), unpacking():
        zipped = zipfile.ZipFile(io.BytesIO(data))
    with as_format_errors(), zipped:
        names = zipped.namelist()
        at_most(len(names), MAX_ENTRIES, "entries")
        first = next((name for name in names if name.lower().endswith(SCENES)), None)
        if first is None:
            raise FormatError("There is no scene in this package. Export it again.")
        scene = Composition(partial(_entry, zipped, frozenset(names)))
        root = scene.composed(unpacked(zipped, first, MAX_MESH_BYTES, "a scene"), first)
        return _Scene(root, reading, scene).shapes()


def _entry(zipped: zipfile.ZipFile, names: frozenset[str], name: str, kind: str) -> bytes:
    if name not in names:
        raise FormatError("It is not in the package.")
    return unpacked(zipped, name, MAX_MESH_BYTES, f"a {kind}")


class _Placed(NamedTuple):
    """A mesh that is shown.

    Attributes
    ----------
    holders : list of ReadPrim
        Itself and what it is in, the innermost first.
    world : array (4, 4)
        From its axes to our world, as columns.
    """

    holders: list[ReadPrim]
    world: Array


class _Scene:
    """A scene whose text is understood.

    Parameters
    ----------
    root : ReadPrim
        What stands at its top.
    reading : Reading
        What is told.
    composition : Composition
        That put it together.
    """

    def __init__(self, root: ReadPrim, reading: Reading, composition: Composition) -> None:
        self._root, self._reading, self._load = root, reading, composition.picture
        self._prims = {one.path: one for one in root.walk()}
        self._worlds: dict[str, Array] = {}
        self._pictures = Pictures("USD", reading)
        self._looks = ReadLooks(self._prims, reading)
        rate = root.said.get("timeCodesPerSecond", root.said.get("framesPerSecond"))
        rate = rate if isinstance(rate, float) and 0.0 < rate < 1e6 else RATE
        self._skeletons = ReadSkeletons(self._prims, self._worlds, rate, reading)
        self._left: Counter[str] = Counter(arcs=composition.missing, variants=composition.unread)
        tops = [one.name for one in root.children if one.kind == "def"]
        self._top = tops[0] if len(tops) == 1 else root.said.get("defaultPrim")
        self._size = [0, 0]

    def shapes(self) -> Shapes:
        """Return all meshes."""
        meshes = self._placed()
        with np.errstate(all="ignore"):  # numbers may be extreme; what comes of them is looked at
            parts = [part for one in meshes if (part := self._part(one)) is not None]
        self._tell()
        if not parts:
            raise FormatError(
                " ".join(("There are no faces in this file.", *self._reading.left_out))
            )
        return Shapes(surfaces=tuple(parts))

    def _frame(self) -> Array:
        """Return the change (4, 4) from the axes and the unit of the scene to ours."""
        said = self._root.said
        unit = said.get("metersPerUnit", UNIT)
        if not isinstance(unit, float) or not 1e-9 <= unit <= 1e9:
            raise FormatError("Its unit (metersPerUnit) is no length. Save it again.")
        matrix = np.eye(4)
        matrix[:3, :3] = 1000.0 * unit * (np.eye(3) if said.get("upAxis") == "Z" else Y_UP)
        return matrix

    def _placed(self) -> list[_Placed]:
        """Return every mesh that is shown, where it is and what it is in."""
        found: list[_Placed] = []
        frame, scattered = self._frame(), 0
        waiting: list[tuple[ReadPrim, Array, list[ReadPrim]]] = [
            (one, frame, []) for one in reversed(self._root.children)
        ]
        while waiting:
            prim, above, holders = waiting.pop()
            if prim.kind != "def" or prim.said.get("active") == 0.0:
                continue
            if prim.word("visibility") == "invisible" or prim.word("purpose") in HIDDEN:
                self._left["hidden"] += 1
                continue
            matrix, resets = local_matrix(prim)
            with np.errstate(all="ignore"):
                world = (frame if resets else above) @ matrix
            if not np.isfinite(world).all():
                raise FormatError("A transform moves its parts further than a scene can reach.")
            self._worlds[prim.path] = world
            inner = [prim, *holders]
            self._left["motions"] += moves(prim)
            if prim.type in ANALYTIC:
                self._left["round"] += put_mesh(prim)
            if prim.type == "Mesh":
                found.append(_Placed(inner, world))
                at_most(len(found), MAX_PARTS, "parts")
            self._left["bodies"] += prim.type == "TetMesh"
            self._left["curves"] += prim.type in CURVED
            self._left["cameras"] += prim.type == "Camera"
            self._left["lights"] += prim.type.endswith("Light")
            self._left["notes"] += any(
                name.startswith(NOTE) and not name.startswith(BLENDERS) for name in prim.values
            )
            if prim.type != SCATTER:  # whose children are what it repeats
                waiting += [(one, world, inner) for one in reversed(prim.children)]
                continue
            copies = copies_of(prim)
            scattered += len(copies)
            at_most(scattered, MAX_PARTS, "copies")
            at_most(len(inner), MAX_DEPTH, "levels of copies")
            for copy in reversed(copies):
                repeated = self._prims.get(copy.path)
                if repeated is not None:
                    waiting.append((repeated, world @ copy.matrix, inner))
        return found

    def _tell(self) -> None:
        for key, what, many, why in (
            ("arcs", "what it takes from elsewhere", "what it takes from {} other places",
             "it is not in this folder or not a scene, or depends on itself; save it flattened: "
             "“usdcat --flatten in.usda -o out.usda”"),
            ("variants", "what is not chosen of a set of variants",
             "what is not chosen of {} sets of variants", "choose it there and save it again"),
            ("hidden", "a hidden part", "{} hidden parts", "show them and save it again"),
            ("bodies", "a body that is no mesh", "{} bodies that are no meshes",
             "turn them into meshes first"),
            ("round", "the exact form of a round body", "the exact form of {} round bodies",
             f"their triangles are at most {100.0 * OFF:.2g} % of their size off"),
            ("curves", "a set of curves, patches or points",
             "{} sets of curves, patches or points", "they have no faces"),
            ("subdivided", "that a part is subdivided", "that {} parts are subdivided",
             "their cages are read; apply the subdivision first"),
            ("faces", "the colours of the faces of a part", "the colours of the faces of {} parts",
             "give them materials"),
            ("forms", "that a part changes its form", "that {} parts change their form",
             "the first one is read"),
            ("motions", "a motion", "{} motions", "only those of bones are read"),
            ("cameras", "a camera", "{} cameras", "only shapes are read"),
            ("lights", "a light", "{} lights", "only shapes are read"),
            ("notes", "what is noted of a part besides", "what is noted of {} parts besides",
             "custom properties are not kept"),
        ):  # fmt: skip
            count = self._left[key]
            if count:
                words = what if count == 1 else many.format(count)
                self._reading.tell(f"Left out of the USD file: {words} ({why}).")

    def _part(self, placed: _Placed) -> Surface | None:
        """Return a mesh as a part; None where it has no faces."""
        holders = placed.holders
        prim = holders[0]
        points, counts, rings = (
            prim.numbers("points", 3), prim.numbers("faceVertexCounts", 1),
            prim.numbers("faceVertexIndices", 1),
        )  # fmt: skip
        if points is None or counts is None or rings is None:
            return None
        check_places(points)
        sizes, corners = _whole(counts, "faceVertexCounts"), _whole(rings, "faceVertexIndices")
        if (sizes < 0).any() or int(sizes.sum()) != len(corners):
            raise FormatError("A mesh has not as many corners as its faces say.")
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
            raise FormatError("A face names a vertex that the file does not hold.")
        self._size[0] += len(points)
        self._size[1] += int(np.maximum(sizes - 2, 0).sum())
        at_most(self._size[0], MAX_VERTICES, "vertices")
        at_most(self._size[1], MAX_FACES, "triangles")
        self._left["subdivided"] += prim.word("subdivisionScheme") not in ("", "none")
        self._left["forms"] += len(prim.values.get("points.timeSamples") or ()) > 1
        corner = triangulate(points[corners], np.arange(len(corners)), sizes).astype(np.intp)
        owner = np.repeat(np.arange(len(sizes)), np.maximum(sizes - 2, 0))
        proper = ~is_degenerate(corners[corner].astype(np.int32)) & ~self._holes(prim, owner)
        corner, owner = corner[proper], owner[proper]
        if not len(corner):
            return None
        looks, kind = self._groups(holders, len(sizes))
        order = np.argsort(kind[owner], kind="stable")
        corner, owner = corner[order], owner[order]
        used = np.bincount(kind[owner], minlength=len(looks))
        world, skin = self._world(placed, len(points))
        turn = world[:3, :3]
        with np.errstate(all="ignore"):
            flipped = bool(np.linalg.det(turn) < 0.0) != (prim.word("orientation") == "leftHanded")
            places = points @ turn.T + world[:3, 3]
        if flipped:
            corner = corner[:, ::-1]
        colors = self._colors(prim, len(points), corners)
        mesh = checked_mesh(places, corners[corner], _normals(prim, len(points), turn), colors)
        part = Surface(mesh, _name_of_mesh(holders), path=self._path(holders))
        part = _grouped(part, [(look, int(n)) for look, n in zip(looks, used, strict=True) if n])
        if part.color is None and not part.groups:
            part = replace(part, color=_whole_color(prim))
        if skin is not None and skin.rig.is_posed:
            posed = skin.posed(part.mesh)
            check_places(posed.vertices)
            skin, part = replace(skin, rest=part.mesh), replace(part, mesh=posed)
        part = replace(part, skin=skin)
        return self._with_picture(part, prim, looks, used, corner, corners, len(points))

    def _holes(self, prim: ReadPrim, owner: Index) -> Flags:
        holes = prim.numbers("holeIndices", 1)
        return np.isin(owner, [] if holes is None else holes[:, 0])

    def _path(self, holders: list[ReadPrim]) -> tuple[str, ...]:
        """Return the names of what a mesh is in; the top of the scene and a rig are no groups."""
        outer = holders[1:]
        if outer and outer[-1].name == self._top:
            outer = outer[:-1]
        names = [_title(one) for one in outer if one.type != "SkelRoot"]
        if names and names[0] == _name_of_mesh(
            holders
        ):  # one that holds a mesh of its name is its place
            names = names[1:]
        return tuple(reversed(names))

    def _world(self, placed: _Placed, count: int) -> tuple[Array, Skin | None]:
        """Return the change from the axes of a mesh to our world, and the bones that it follows."""
        holders = placed.holders
        prim = holders[0]
        skeleton = self._skeletons.followed(holders)
        if skeleton is not None:
            try:
                skin = skeleton.skin(prim, count, self._reading)
                bound = prim.numbers("primvars:skel:geomBindTransform", 16)
                world = skeleton.matrix
                if bound is not None and len(bound) == 1:
                    world = world @ bound[0].reshape(4, 4).T
                if not np.isfinite(world).all():
                    raise FormatError("They are too far away.")
            except FormatError as error:
                self._reading.tell(
                    f"Left out of the USD file: the bones of a part. {error.message}"
                )
            else:
                return world, skin
        return placed.world, None

    def _groups(self, holders: list[ReadPrim], count: int) -> tuple[list[ReadLook | None], Index]:
        """Return the looks of a mesh, and which of them each polygon has."""
        whole = next((look for one in holders if (look := self._looks.bound_to(one))), None)
        looks: list[ReadLook | None] = [whole]
        kind = np.zeros(count, np.intp)
        for subset in holders[0].children:
            if subset.type != "GeomSubset" or subset.word("elementType") not in ("", "face"):
                continue
            look = self._looks.bound_to(subset)
            faces = subset.numbers("indices", 1)
            if look is None or faces is None:
                continue
            rows = _whole(faces, "indices")
            if len(rows) and not 0 <= rows.min() <= rows.max() < count:
                raise FormatError("A group names a face that its mesh does not have.")
            at_most(len(looks), MAX_PARTS, "parts and groups")
            kind[rows] = len(looks)
            looks.append(look._replace(name=subset.title))
        return looks, kind

    def _colors(
        self, prim: ReadPrim, count: int, corners: Index
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]] | None:
        """Return the colours of vertices; None where there are none."""
        name, wide = next((one for one in PAINTS if one[0] in prim.values), PAINTS[0])
        found = _primvar(prim, name, wide)
        if found is None or len(found[0]) == 1:
            return None
        rows, interpolation = found
        if interpolation == "faceVarying" and len(rows) == len(corners):
            of_vertices = np.ones((count, wide))
            of_vertices[corners] = rows
            if (of_vertices[corners] == rows).all():  # all faces round a vertex agree
                rows, interpolation = of_vertices, "vertex"
        if interpolation not in ("vertex", "varying") or len(rows) != count:
            self._left["faces"] += 1
            return None
        colors = np.full((count, 4), 255, np.uint8)
        colors[:, :3] = linear_to_srgb(rows[:, :3])
        shares = _primvar(prim, "primvars:displayOpacity", 1)
        if shares is not None and len(shares[0]) == count:
            opaque = np.clip(np.nan_to_num(shares[0][:, 0]), 0.0, 1.0)
            colors[:, 3] = np.rint(255.0 * opaque)
        return colors

    def _with_picture(
        self, part: Surface, prim: ReadPrim, looks: list[ReadLook | None], used: Index,
        corner: Index, corners: Index, count: int,
    ) -> Surface:  # fmt: skip
        """Return a part with the pictures of its materials, if there are any.

        Parameters
        ----------
        part : Surface
            Without them.
        prim : ReadPrim
            The mesh.
        looks, used
            What its triangles look like, and how many have each.
        corner : (f, 3) int array
            Of each triangle, among all corners of its polygons.
        corners : (n,) int array
            The vertices of these.
        count : int
            Of vertices.
        """
        at = np.zeros((len(corner), 3, 2))
        names, unused, begin = [], set(_names_of_places(prim, len(corners))), 0
        for look, n in zip(looks, used.tolist(), strict=True):
            if not n:
                continue
            own, picture = slice(begin, begin + n), "" if look is None else look.picture
            begin += n
            if look is not None and picture:
                name = _places_of(prim, look)
                found = _primvar(prim, name, 2)
                rows = None if found is None else _by_corner(*found, corners, count)
                rows = None if rows is None else look.moved.places(rows)
                if rows is None or not (np.abs(rows) <= MAX_REPEATS).all():
                    picture = ""
                    self._reading.tell(
                        "Left out of the USD file: the picture of a material. Its places on the "
                        "surface are not in the file."
                    )
                else:
                    at[own] = rows[corner[own]]
                    unused.discard(name)
            names.append(picture)
        if unused:
            self._reading.tell_of_unused_places("USD")
        files = sorted({name for name in names if name})
        if not files:
            return part
        for file in files:
            self._pictures.add(file, partial(self._load, file))
        shown = [files.index(name) if name else -1 for name in names]
        plain = [(*((look.color if look else None) or WHITE), 255)
                 for look, n in zip(looks, used, strict=True) if n]  # fmt: skip
        sizes = used[used > 0]
        texture = self._pictures.texture(
            np.repeat(shown, sizes),
            files,
            at,
            np.repeat(np.array(plain, np.uint8), sizes, 0),
        )
        if texture is None:
            return part
        groups = tuple(replace(group, color=None) for group in part.groups)
        mesh = replace(part.mesh, colors=None)
        return replace(part, mesh=mesh, color=None, groups=groups, texture=texture)


def _title(prim: ReadPrim) -> str:
    """Return the name for people, without what USD does not allow where Blender says it."""
    return prim.word(OBJECTS_NAME) or prim.title


def _name_of_mesh(holders: list[ReadPrim]) -> str:
    """Return the name of the innermost; what Blender's objects show is called as these are."""
    shown = len(holders) > 1 and bool(holders[0].word(DATAS_NAME))
    return (holders[1].word(OBJECTS_NAME) if shown else "") or holders[0].title


def _names_of_places(prim: ReadPrim, corners: int) -> list[str]:
    """Return the names of what seem to be places in pictures: two numbers for each corner."""
    return [
        name
        for name, value in prim.values.items()
        if name in PLACES
        or (
            name.startswith("primvars:")
            and isinstance(value, np.ndarray)
            and value.size == 2 * corners
            and prim.remarks.get(name, {}).get("interpolation") == "faceVarying"
        )
    ]


def _places_of(prim: ReadPrim, look: ReadLook) -> str:
    """Return the name of the places in its picture: as the material says, or as programs do."""
    named = f"primvars:{look.places}"
    if look.places and named in prim.values:
        return named
    return next((name for name in PLACES if name in prim.values), PLACES[0])


def _grouped(part: Surface, looks: list[tuple[ReadLook | None, int]]) -> Surface:
    """Return a part with a group for each look; a single one that is called like it is no group."""
    groups = []
    for look, count in looks:
        one = look or ReadLook(part.name)
        groups.append(FaceGroup(one.name or part.name, count, one.color, one.finish))
    if len(groups) > 1:
        return replace(part, groups=tuple(groups))
    (group,) = groups
    if group.finish == "matt" and group.name == part.name:
        return replace(part, color=group.color)
    return replace(part, groups=(group,))


def _whole(rows: Array, name: str) -> Index:
    """Return numbers (n, 1) as whole ones, (n,)."""
    values = rows[:, 0]
    if not (np.abs(values) < 2.0**31).all() or (values != np.rint(values)).any():
        raise FormatError(f"The numbers of “{name}” are not whole.")
    return values.astype(np.intp)


def _primvar(prim: ReadPrim, name: str, width: int) -> tuple[Array, str] | None:
    """Return the rows of a primvar and what they are of; None where there are none."""
    rows = prim.numbers(name, width)
    if rows is None or not len(rows):
        return None
    said = prim.remarks.get(name, {}).get("interpolation", "constant")
    which = prim.numbers(f"{name}:indices", 1)
    if which is not None:
        index = _whole(which, f"{name}:indices"[:40])
        if not len(index) or not 0 <= index.min() <= index.max() < len(rows):
            raise FormatError(f"The numbers of “{name[:40]}” name others that are not there.")
        rows = rows[index]
    return rows, str(said)


def _by_corner(rows: Array, interpolation: str, corners: Index, count: int) -> Array | None:
    """Return the rows of all corners; None where there are not as many as there should be."""
    if interpolation == "faceVarying" and len(rows) == len(corners):
        return rows
    if interpolation in ("vertex", "varying") and len(rows) == count:
        return np.asarray(rows[corners])
    return None


def _whole_color(prim: ReadPrim) -> tuple[int, int, int] | None:
    """Return the one colour that a mesh without a material is shown in."""
    found = _primvar(prim, "primvars:displayColor", 3)
    if found is None or len(found[0]) != 1 or prim.targets("material:binding"):
        return None
    red, green, blue = (int(v) for v in linear_to_srgb(found[0][0]))
    return red, green, blue


def _normals(prim: ReadPrim, count: int, turn: Array) -> Array | None:
    """Return the unit normals of vertices in our axes; None where the file has none of these."""
    name = "primvars:normals" if "primvars:normals" in prim.values else "normals"
    said = prim.remarks.get(name, {}).get("interpolation", "vertex")
    try:
        rows = prim.numbers(name, 3)
    except FormatError:  # of another type: they change nothing of the shape
        return None
    if rows is None or len(rows) != count or said not in ("vertex", "varying"):
        return None
    with np.errstate(all="ignore"):
        a, b, c = turn.T  # normals turn with the cofactors
        cofactors = np.column_stack((np.cross(b, c), np.cross(c, a), np.cross(a, b)))
        turned = rows @ cofactors.T * np.sign(np.linalg.det(turn))
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        return np.asarray(turned / length) if (length > 0.0).all() else None
