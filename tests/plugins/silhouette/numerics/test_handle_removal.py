"""Narrow handles and tunnels: found wherever they are, taken out, and nothing else."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from bozzetto_silhouette.inflation.manifold_check import as_manifold, topology_of
from bozzetto_silhouette.numerics import handle_removal
from bozzetto_silhouette.numerics.handle_loops import shortest_loop
from bozzetto_silhouette.numerics.handle_removal import without_narrow_handles

FINE = 0.08
"""Edges of the meshes here, at most."""


def meshed(solid: manifold3d.Manifold) -> tuple[np.ndarray, np.ndarray]:
    mesh = solid.refine_to_length(FINE).to_mesh64()
    return np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts).astype(np.int32)


def drilled(*holes: tuple[float, float, float, int]) -> manifold3d.Manifold:
    """A plate of 3 x 2 x 0.3 with holes (x, y, radius, sides) through it."""
    plate = manifold3d.Manifold.cube([3.0, 2.0, 0.3])
    for x, y, radius, sides in holes:
        drill = manifold3d.Manifold.cylinder(2.0, radius, radius, sides)
        plate -= drill.translate([x, y, -1.0])
    return plate


def bridged(*widths: float) -> manifold3d.Manifold:
    """Two blocks with bars of some widths from one to the other."""
    whole = manifold3d.Manifold.cube([2.0, 2.0, 1.0])
    whole += whole.translate([3.0, 0.0, 0.0])
    for k, width in enumerate(widths):
        bar = manifold3d.Manifold.cube([1.4, width, width])
        whole += bar.translate([1.8, 0.5 + 0.6 * k, 0.4])
    return whole


def taken_out(solid: manifold3d.Manifold, longest: float) -> tuple[int, float]:
    """The genus and the volume of what is left; it is closed, and no vertex has moved."""
    vertices, faces = meshed(solid)
    faces, parents = without_narrow_handles(vertices, faces, np.full(len(vertices), longest))
    np.testing.assert_array_equal(parents[: len(vertices)], np.arange(len(vertices)))
    found = topology_of(vertices[parents], faces)
    assert found.watertight
    assert found.components == topology_of(*meshed(solid)).components
    assert as_manifold(vertices[parents], faces).status().name == "NoError"
    return found.genus, found.volume


@pytest.mark.parametrize(("longest", "left"), [(0.0, 4), (0.2, 3), (0.4, 2), (1.0, 1), (9.0, 0)])
def test_holes_up_to_a_length_around_are_closed(longest: float, left: int) -> None:
    # Around them they are 0.10, 0.30, 0.62 and 3.1 long.
    plate = drilled(
        (0.5, 0.5, 0.02, 3), (2.5, 1.5, 0.05, 6), (0.6, 1.5, 0.1, 16), (1.6, 1.0, 0.5, 32)
    )
    genus, volume = taken_out(plate, longest)
    assert genus == left
    # The walls of a closed hole lie in one place: they enclose nothing.
    assert volume == pytest.approx(plate.volume(), rel=1e-9)


def test_a_thin_bridge_is_cut_and_thick_ones_stay() -> None:
    whole = bridged(0.4, 0.02, 0.3)
    assert whole.genus() == 2
    genus, volume = taken_out(whole, 0.2)
    assert genus == 1
    assert volume == pytest.approx(whole.volume(), rel=1e-9)


def test_the_only_bridge_is_no_handle() -> None:
    assert taken_out(bridged(0.02), 0.2)[0] == 0
    vertices, faces = meshed(bridged(0.02))
    same, parents = without_narrow_handles(vertices, faces, np.full(len(vertices), 0.2))
    np.testing.assert_array_equal(same, faces)
    assert len(parents) == len(vertices)


def test_where_the_mesh_is_to_stay_holes_stay() -> None:
    vertices, faces = meshed(drilled((0.5, 0.5, 0.02, 3), (2.5, 1.5, 0.02, 3)))
    longest = np.where(vertices[:, 0] > 1.5, 0.2, 0.0)
    left, parents = without_narrow_handles(vertices, faces, longest)
    assert topology_of(vertices[parents], left).genus == 1
    assert (vertices[parents[len(vertices) :], 0] > 2.0).all()


def test_several_places_are_mended_each_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []
    real = handle_removal.shortest_loop

    def counted(vertices, faces, *rest) -> object:
        sizes.append(len(faces))
        return real(vertices, faces, *rest)

    monkeypatch.setattr(handle_removal, "shortest_loop", counted)
    plate = drilled((1.5, 1.0, 0.3, 32))
    ring = manifold3d.CrossSection.circle(0.02, 8).translate([0.1, 0.0]).revolve(24)
    centres = [(0.5, 0.5), (1.2, 1.6), (2.5, 1.5)]
    for x, y in centres:
        plate += ring.rotate([90.0, 0.0, 0.0]).translate([x, y, 0.3])
    vertices, faces = meshed(plate)
    near = np.min([np.hypot(*(vertices[:, :2] - centre).T) for centre in centres], axis=0)
    left, parents = without_narrow_handles(vertices, faces, np.where(near < 0.2, 0.2, 0.0))
    found = topology_of(vertices[parents], left)
    assert topology_of(vertices, faces).genus == 4
    assert (found.genus, found.watertight) == (1, True)  # what is drilled stays
    assert max(sizes[:3]) < 0.2 * len(faces)
    assert found.volume == pytest.approx(plate.volume(), rel=1e-9)


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1])
def test_the_shortest_loop_of_a_ring_goes_around_its_tube(turn: float) -> None:
    tube = manifold3d.CrossSection.circle(0.3, 40).translate([1.0, 0.0]).revolve(60)
    vertices, faces = meshed(tube.rotate([30.0 * turn, 50.0 * turn, 0.0]))
    loop = shortest_loop(vertices, faces, np.zeros(1, np.intp), np.full(len(vertices), 2.6))
    assert loop is not None
    way = vertices[loop] - vertices[np.roll(loop, 1)]
    length = np.linalg.norm(way, axis=1).sum()
    assert 0.97 * 2.0 * np.pi * 0.3 <= length <= 1.25 * 2.0 * np.pi * 0.3
    edges = {tuple(sorted(pair)) for a, b, c in faces.tolist() for pair in ((a, b), (b, c), (c, a))}
    ways = np.sort(np.stack([loop, np.roll(loop, 1)], axis=1), axis=1)
    assert {tuple(pair) for pair in ways.tolist()} <= edges
    assert shortest_loop(vertices, faces, np.zeros(1, np.intp), np.full(len(vertices), 1.5)) is None
