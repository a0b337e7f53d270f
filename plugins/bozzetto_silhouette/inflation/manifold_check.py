"""Checks that a mesh is a solid, and has the topology that was drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Faces
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.outline.outline import Outline

if TYPE_CHECKING:
    from manifold3d import Manifold


@dataclass(frozen=True)
class Topology:
    """Topology of a mesh.

    Attributes
    ----------
    status : str
        In the words of manifold3d: ``"NoError"`` when every edge joins two faces that run
        along it in opposite directions.
    volume : float
        In cubed units of the mesh; negative means inside out.
    genus : int
        Handles, of all its surfaces together.
    components : int
        Closed surfaces that do not touch.
    bodies : int
        Those of them that enclose something; the others bound hollows.
    """

    status: str
    volume: float
    genus: int
    components: int
    bodies: int

    @property
    def watertight(self) -> bool:
        """Whether the mesh bounds a solid."""
        return self.status == "NoError"


@dataclass(frozen=True)
class Soundness(Topology):
    """The topology that was found, and the one that the drawing has.

    Attributes
    ----------
    expected_genus : int
        Holes of the drawing.
    expected_components : int
        Outer rings of the drawing.
    """

    expected_genus: int
    expected_components: int

    @property
    def ok(self) -> bool:
        """Whether the solid is sound and has the topology of the drawing."""
        return (
            self.watertight
            and self.volume > 0.0
            and self.genus == self.expected_genus
            and self.components == self.expected_components
        )


def as_manifold(vertices: Array, faces: Faces) -> Manifold:
    """Convert a mesh to a manifold3d solid, in double precision.

    It gets copies: manifold3d takes no read-only arrays, not even those that it gave.
    """
    import manifold3d

    mesh = manifold3d.Mesh64(
        np.array(vertices, dtype=np.float64, order="C"), np.array(faces, dtype=np.uint64, order="C")
    )
    return manifold3d.Manifold(mesh)


def original_numbers(solid: Manifold) -> set[int]:
    """Return the numbers under which manifold3d keeps the meshes apart that a solid was made of."""
    return {int(number) for number in solid.to_mesh64().run_original_id}


def soundness_of(vertices: Array, faces: Faces, outline: Outline) -> Soundness:
    """Check a mesh (v, 3), (f, 3) against the outline it was made from."""
    return Soundness(
        **vars(topology_of(vertices, faces)),
        expected_genus=outline.genus,
        expected_components=outline.components,
    )


def topology_of(vertices: Array, faces: Faces) -> Topology:
    """Find the topology of a mesh (v, 3), (f, 3).

    Notes
    -----
    Counted from the faces themselves, which takes a fifth of the time that manifold3d needs
    to build its solid: this runs while a person waits. Exports ask manifold3d.
    """
    # Two edges join the three corners of a face.
    a, b = faces[:, [0, 1, 1, 2]].reshape(-1, 2).T
    used = np.bincount(faces.ravel(), minlength=len(vertices)) > 0
    pieces, label = connected_pieces(a, b, len(vertices))
    components = pieces - int((~used).sum())
    # Euler's formula, summed over the bodies; of three half edges each face owns one and a half.
    euler = int(used.sum()) - 3 * len(faces) // 2 + len(faces)
    volumes = np.bincount(label[faces[:, 0]], _wedges(vertices, faces), minlength=pieces)
    return Topology(
        _status(vertices, faces),
        volume_of(vertices, faces),
        components - euler // 2,
        components,
        int((volumes > 0.0).sum()),
    )


def _status(vertices: Array, faces: Faces) -> str:
    if not np.isfinite(vertices).all():
        return "NonFiniteVertex"
    first = faces.astype(np.int64).ravel()
    second = np.roll(faces, -1, axis=1).astype(np.int64).ravel()
    along = np.sort(first * len(vertices) + second)
    against = np.sort(second * len(vertices) + first)
    closed = len(along) > 0 and np.array_equal(along, against) and (np.diff(along) > 0).all()
    return "NoError" if closed else "NotManifold"


def volume_of(vertices: Array, faces: Faces) -> float:
    """Return the volume of a mesh by the divergence theorem."""
    return float(_wedges(vertices, faces).sum())


def _wedges(vertices: Array, faces: Faces) -> Array:
    """Return each face's share of the volume, about a vertex to keep digits far away."""
    a, b, c = (vertices - vertices[:1])[faces].transpose(1, 0, 2)
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, np.float64)
