"""The pieces of a body that does not hang together, each with the hollows inside it."""

from __future__ import annotations

from dataclasses import replace

from bozzetto_polyhedron.solid.boolean import compact
from bozzetto_polyhedron.solid.face_rings import signed_volume
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import shells_of


def pieces_of(body: PlanarBody) -> tuple[PlanarBody, ...]:
    """Return each piece of a body as one of its own, in the order of their faces.

    Parameters
    ----------
    body : PlanarBody
        A solid; a sheet stays as it is.
    """
    shells = shells_of(body.faces)
    if not body.closed or len(shells) == 1:
        return (body,)
    parts = [_part(body, shell) for shell in shells]
    volumes = [signed_volume(part.vertices, part.faces) for part in parts]
    outer = [k for k, volume in enumerate(volumes) if volume > 0.0]
    members = {k: list(shells[k]) for k in outer}
    for number, volume in enumerate(volumes):
        if volume > 0.0:
            continue
        around = [k for k in outer if _is_within(parts[number], parts[k])]
        owner = min(around or outer, key=lambda k: volumes[k])
        members[owner] += shells[number]
    return tuple(_part(body, sorted(faces)) for faces in members.values())


def _part(body: PlanarBody, faces: list[int]) -> PlanarBody:
    return compact(
        replace(
            body,
            faces=tuple(body.faces[k] for k in faces),
            normals=body.normals[faces],
            offsets=body.offsets[faces],
        )
    )


def _is_within(inner: PlanarBody, outer: PlanarBody) -> bool:
    """Whether the box around one part lies within that around another."""
    low, high = outer.vertices.min(axis=0), outer.vertices.max(axis=0)
    return bool((inner.vertices >= low).all() and (inner.vertices <= high).all())
