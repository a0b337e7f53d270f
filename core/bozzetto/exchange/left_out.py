"""Content for which a format has no place, in words that a person can act on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from bozzetto.exchange.formats import Format
from bozzetto.geometry.brep.brep import Brep
from bozzetto.geometry.shapes import Shapes, Solid, Surface

MESH_FILES: Final = {"solid": "3MF or STL", "open surface": "GLB or OBJ"}
"""Formats that take parts made of triangles, by the name of the part."""


@dataclass(frozen=True)
class LeftOut:
    """Something that is not in a file, and why.

    Attributes
    ----------
    what : str
        Such as "2 solids".
    names : tuple of str
    reason : str
        Such as "they have no exact surfaces".
    advice : str
        What to do instead, such as "save them as 3MF or STL".
    is_content : bool
        False for what nobody draws or paints, such as the axes of a shape. It stands in reports
        and is not said aloud.
    """

    what: str
    names: tuple[str, ...]
    reason: str
    advice: str
    is_content: bool = True

    def sentence(self, file: str) -> str:
        """Return one line, such as "Left out of the STEP file: …"; `file` is "STEP file"."""
        return f"Left out of the {file}: {self.what} ({self.reason}); {self.advice}."

    def as_values(self) -> dict[str, Any]:
        """Return plain JSON values for a report."""
        return {
            "what": self.what,
            "names": list(self.names),
            "reason": self.reason,
            "advice": self.advice,
        }


def with_place(shapes: Shapes, chosen: Format) -> Shapes:
    """Return the parts that a format has a place for; exact surfaces may become triangles there."""
    holds = chosen.holds
    mesh = "mesh" in holds
    return Shapes(
        solids=shapes.solids if mesh else (),
        surfaces=tuple(s for s in shapes.surfaces if mesh and len(s.mesh.faces)),
        curves=shapes.curves if "curves" in holds else (),
        patchworks=shapes.patchworks if mesh or "surfaces" in holds else (),
        breps=_breps(shapes, mesh=mesh) if mesh or "surfaces" in holds else (),
    )


def _breps(shapes: Shapes, *, mesh: bool) -> tuple[Brep, ...]:
    """Return the exact surfaces; without those of parts that are written as triangles."""
    exact = (
        replace(part.exact, name=part.name, color=part.exact.color or part.color)
        for part in (() if mesh else shapes.meshes())
        if part.exact is not None
    )
    return (*shapes.breps, *exact)


def parts_left_out(shapes: Shapes, chosen: Format) -> tuple[LeftOut, ...]:
    """Return what of some shapes is left out of a file of a format.

    Parts, and of the parts that are written their painted colours and their bones.
    """
    kept = with_place(shapes, chosen)
    found: list[LeftOut] = []
    if "mesh" not in chosen.holds:
        exact = "surfaces" in chosen.holds
        for word, row in (("solid", shapes.solids), ("open surface", shapes.surfaces)):
            parts = tuple(part for part in row if not exact or part.exact is None)
            if parts:
                reason = f"{_they(parts)} no exact surfaces" if exact else _only("curves")
                found.append(_left_out(word, parts, reason, MESH_FILES[word]))
    else:
        empty = tuple(surface for surface in shapes.surfaces if not len(surface.mesh.faces))
        if empty:
            what, reason = _count(len(empty), "open surface"), f"{_they(empty)} no triangles"
            found.append(LeftOut(what, _names(empty), reason, "draw more of it, then export"))
    exact_ones = (*shapes.patchworks, *shapes.breps)
    if exact_ones and not (kept.patchworks or kept.breps):
        found.append(_left_out("exact surface", exact_ones, _only("curves"), "STEP or IGES"))
    if shapes.curves and not kept.curves:
        found.append(_left_out("curve", shapes.curves, _only("triangles"), "STEP or SVG"))
    if shapes.skeletons:
        names, what = _names(shapes.skeletons), _count(len(shapes.skeletons), "axis", "axes")
        reason, advice = "no format has a place for them", "other modelers can start from them"
        found.append(LeftOut(what, names, reason, advice, is_content=False))
    found += _trims_left_out(kept.breps, chosen)
    return (*found, *_properties_left_out(tuple(kept.meshes()), chosen))


def _trims_left_out(breps: Sequence[Brep], chosen: Format) -> list[LeftOut]:
    """Return the exact form of trimmed faces, where a format holds surfaces and cannot trim."""
    if "surfaces" not in chosen.holds or "trims" in chosen.keeps:
        return []
    trimmed = [(brep, sum(not face.is_whole for face in brep.faces)) for brep in breps]
    named = tuple(brep.name for brep, count in trimmed if count)
    if not named:
        return []
    what = f"the exact form of {_count(sum(count for _, count in trimmed), 'trimmed face')}"
    reason, advice = "such files hold whole surfaces; these became triangles", "save as STEP"
    return [LeftOut(what, named, reason, advice)]


def _properties_left_out(parts: Sequence[Solid | Surface], chosen: Format) -> list[LeftOut]:
    """Return which properties the written parts lose."""
    found = []
    painted = [s for s in parts if s.mesh.colors is not None or s.texture is not None]
    if painted and "colors" not in chosen.keeps:
        what = f"the colours of {_count_parts(painted)}"
        advice = "save as GLB, USD, 3MF, OBJ or PLY to keep them"
        found.append(LeftOut(what, _names(painted), "it holds shapes without colours", advice))
    jointed = [s for s in parts if s.skin is not None]
    if jointed and "bones" not in chosen.keeps:
        what = f"the bones of {_count_parts(jointed)}"
        reason = "the shape is written as it is posed now"
        advice, posed = "save as GLB or USD to keep them", any(map(_is_posed, jointed))
        found.append(LeftOut(what, _names(jointed), reason, advice, is_content=posed))
    return found


def pictures_left_out(
    before: Sequence[Solid | Surface], written: Sequence[Solid | Surface]
) -> tuple[LeftOut, ...]:
    """Return the pictures that parts lost with some of their triangles."""
    lost = [
        one
        for one, other in zip(before, written, strict=False)
        if one.texture is not None and other.texture is None
    ]
    if not lost:
        return ()
    what = f"the {_count(len(lost), 'picture')} on {_count_parts(lost)}"
    reason, advice = "pictures belong to the triangles, which are fewer now", "allow all triangles"
    return (LeftOut(what, _names(lost), reason, advice),)


def _count_parts(parts: Sequence[Solid | Surface]) -> str:
    """Return how many there are, in the word for all of them."""
    solid = all(isinstance(part, Solid) for part in parts)
    return _count(len(parts), "solid" if solid else "part")


def _is_posed(part: Solid | Surface) -> bool:
    """Whether somebody bent a part: bones alone come with every drawing."""
    rest = None if part.skin is None else part.skin.rest
    return rest is not None and bool((rest.vertices != part.mesh.vertices).any())


def _left_out(word: str, parts: Sequence[Any], reason: str, files: str) -> LeftOut:
    them = "it" if len(parts) == 1 else "them"
    what = _count(len(parts), word)
    return LeftOut(what, _names(parts), reason, f"save {them} as {files}")


def _count(number: int, word: str, many: str = "") -> str:
    return f"{number} {word if number == 1 else many or word + 's'}"


def _names(parts: Sequence[Any]) -> tuple[str, ...]:
    return tuple(part.name for part in parts)


def _they(parts: Sequence[Any]) -> str:
    return "it has" if len(parts) == 1 else "they have"


def _only(kind: str) -> str:
    return f"such files hold {kind} only"
