"""The modeler of imported meshes: the contract, and that nothing is lost on the way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.storage.state_codec import decode_state, encode_state
from bozzetto.geometry import Mesh, Placement, Shapes, Solid, Surface, cylinder, ruled_surface
from bozzetto.plugin import Job
from bozzetto.scene import Shaded
from bozzetto.testing import ModelerContract, Pen, Shell, same
from bozzetto_mesh.modeler import ImportedMesh, MeshState


def _block(size: float) -> Mesh:
    """A tetrahedron."""
    corners = size * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
    return Mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32))


def _volume(mesh: Mesh) -> float:
    a, b, c = mesh.vertices[mesh.faces].astype(float).transpose(1, 0, 2)
    return float(np.einsum("nk,nk->", a, np.cross(b, c)) / 6.0)


def _sheet() -> Mesh:
    corners = np.array([[0, 0, 0], [5, 0, 0], [5, 5, 0], [0, 5, 0]], np.float32)
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))


GIVEN = Shapes(solids=(Solid(_block(1.0)), Solid(_block(3.0))), surfaces=(Surface(_sheet()),))


class TestMesh(ModelerContract):
    modeler = "bozzetto.mesh"

    def sketch(self, shell: Shell, pen: Pen) -> None:
        """There is nothing to draw: a file is read instead; pens of two seeds read two files."""
        shapes = Shapes(solids=(Solid(_block(1.0 + pen.seed)),), surfaces=GIVEN.surfaces)
        shell.put(ImportedMesh().read_shapes(shapes))


def test_what_was_closed_stays_closed() -> None:
    state = ImportedMesh().read_shapes(GIVEN)
    assert state.closed == (True, True, False)
    handed = ImportedMesh().shapes(state, ImportedMesh().solve(state, Job()))
    assert [s.mesh for s in handed.solids] == [s.mesh for s in GIVEN.solids]
    assert [s.mesh for s in handed.surfaces] == [s.mesh for s in GIVEN.surfaces]


def _rigged() -> Shapes:
    from tests.core.exchange.skinned import skinned
    from tests.core.exchange.test_gltf_round_trip import in_groups, moving

    worm = moving(in_groups(skinned(7, 40.0, texture=True, turned=True)), shifts=True)
    posed = replace(worm, path=("animals", "worms"))
    # As files have it: posed by exactly what its rig says.
    rest = posed.skin.rest
    rig = replace(posed.skin.rig, shifts=np.full((7, 3), 0.5))
    skin = replace(posed.skin, rig=rig)
    return Shapes(solids=(replace(posed, skin=skin, mesh=skin.posed(rest)), Solid(_block(2.0))))


def test_skins_pictures_and_hierarchy_are_kept_in_documents() -> None:
    given = _rigged()
    state = ImportedMesh().read_shapes(given)
    kept = decode_state(MeshState, encode_state(state))
    assert same(kept, state)
    handed = ImportedMesh().shapes(kept, ImportedMesh().solve(kept, Job()))
    assert same(handed, given)


def test_skins_are_turned_upright_with_their_meshes() -> None:
    state = replace(ImportedMesh().read_shapes(_rigged()), up="y", unit="cm")
    (worm, _) = ImportedMesh().shapes(state, ImportedMesh().solve(state, Job())).solids
    before = _rigged().solids[0].mesh.vertices.astype(float)
    wanted = 10.0 * before[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    np.testing.assert_allclose(worm.mesh.vertices, wanted, atol=1e-3)
    np.testing.assert_allclose(worm.skin.posed(worm.skin.rest).vertices, wanted, atol=1e-2)


def test_groups_and_pictures_are_shown_in_their_colours() -> None:
    (layer,) = ImportedMesh().scene(ImportedMesh().read_shapes(_rigged()), None).layers
    worm = layer.items[0]
    assert same(worm.texture, _rigged().solids[0].texture)
    np.testing.assert_array_equal(worm.mesh.faces, _rigged().solids[0].mesh.faces)
    plain = replace(_rigged().solids[0], texture=None)
    (layer,) = (
        ImportedMesh().scene(ImportedMesh().read_shapes(Shapes(solids=(plain,))), None).layers
    )
    assert [item.color for item in layer.items] == [group.color for group in plain.groups]
    assert sum(len(item.mesh.faces) for item in layer.items) == len(plain.mesh.faces)


def test_exact_surfaces_come_as_meshes() -> None:
    can = cylinder((0, 0, 0), (0, 0, 10), 4.0)
    open_side = ruled_surface(can.edges[0], can.edges[0].placed(Placement(offset=(0, 0, 3))))
    state = ImportedMesh().read_shapes(Shapes(breps=(can, open_side)))
    assert state.closed == (True, False)
    np.testing.assert_allclose(state.meshes[0].bounds, [(-4, -4, 0), (4, 4, 10)], atol=0.01)


def test_a_stored_state_comes_back_as_it_was() -> None:
    state = ImportedMesh().read_shapes(GIVEN)
    back = decode_state(MeshState, encode_state(state))
    assert same(back, state)
    assert back.closed == state.closed


def test_every_mesh_is_shown() -> None:
    state = ImportedMesh().read_shapes(GIVEN)
    shown = [item for _, item in ImportedMesh().scene(state, None).items()]
    assert all(isinstance(item, Shaded) for item in shown)
    assert [item.mesh for item in shown] == list(state.meshes)


def test_nothing_from_nothing() -> None:
    assert ImportedMesh().read_shapes(Shapes()) == MeshState()
    assert not ImportedMesh().shapes(MeshState(), MeshState())


def test_the_axis_and_the_unit_of_a_file_can_be_told_afterwards() -> None:
    block = Mesh(_block(1.0).vertices * np.array((1.0, 2.0, 3.0), np.float32), _block(1.0).faces)
    state = ImportedMesh().read_shapes(Shapes(solids=(Solid(block),)))
    told = replace(state, up="y", unit="in")
    (solid,) = ImportedMesh().shapes(told, ImportedMesh().solve(told, Job())).solids
    np.testing.assert_allclose(np.ptp(solid.mesh.vertices, axis=0), (25.4, 76.2, 50.8), rtol=1e-6)
    assert solid.mesh.vertices[:, 2].min() == 0.0  # what pointed up points up
    assert _volume(solid.mesh) == pytest.approx(25.4**3 * 1.0)  # and nothing is mirrored
    ((_, shown),) = ImportedMesh().scene(told, None).items()
    assert isinstance(shown, Shaded)
    assert same(shown.mesh, solid.mesh)
    assert same(ImportedMesh().solve(state, Job()).meshes, state.meshes)
