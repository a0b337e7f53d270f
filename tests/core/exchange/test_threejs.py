"""Our GLB files in the hands of three.js: pictures, places, materials, and motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.exchange.mesh import glb
from bozzetto.geometry import FaceGroup, Mesh, Shapes, Solid
from tests.threejs import SIDE, asked

pytestmark = pytest.mark.interop

PLUGINS = Path(__file__).parents[3] / "plugins"

BOX = Mesh(
    [[x, y, z] for x in (0, 10) for y in (0, 20) for z in (0, 40)],
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]],
)  # fmt: skip


def test_z_is_up_in_the_drawing_and_y_in_the_browser():
    seen = asked(glb.write_shapes(Shapes(solids=(Solid(BOX, "Box"),))), picture=True)
    assert seen["low"] == pytest.approx([0, 0, -0.020], abs=1e-8)
    assert seen["high"] == pytest.approx([0.010, 0.040, 0], abs=1e-8)
    share = seen["picture"].mean()
    assert share == pytest.approx(0.010 * 0.040 / (2 * seen["half"]) ** 2, rel=0.02)


def test_what_a_part_is_made_of_is_told():
    finishes = {"glass": (150, 200, 255), "rubber": (12, 12, 12), "metal": (230, 230, 230)}
    groups = tuple(FaceGroup(name, 4, color, name) for name, color in finishes.items())
    seen = asked(glb.write_shapes(Shapes(solids=(Solid(BOX, "Box", groups=groups),))))
    glass, rubber, metal = seen["meshes"]
    assert glass["transparent"]
    assert glass["opacity"] < 0.6 < rubber["opacity"] == metal["opacity"] == 1.0
    assert metal["metalness"] > 0.9 > 0.1 > rubber["metalness"]
    assert rubber["roughness"] > glass["roughness"]


@pytest.mark.parametrize(
    ("modeler", "sample"),
    [
        ("silhouette", "horse.json"),
        ("product", "computer-mouse.json"),
        ("polyhedron", "bracket.json"),
        ("car", "hatchback.json"),
    ],
)
def test_a_sample_looks_as_its_triangles_do(tmp_path, modeler, sample):
    """The shadow of the model from the front, against that of our own triangles in an STL file."""
    import trimesh
    from PIL import Image, ImageDraw

    source = str(PLUGINS / f"bozzetto_{modeler}" / "samples" / sample)
    for ending in ("glb", "stl"):
        assert main(["build", modeler, source, "-o", str(tmp_path / f"a.{ending}")]) == 0
    seen = asked((tmp_path / "a.glb").read_bytes(), picture=True)
    corners = trimesh.load_mesh(tmp_path / "a.stl").triangles[..., [0, 2]] / 1000.0
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    assert seen["low"][:2] == pytest.approx(low, abs=1e-6)
    assert seen["high"][:2] == pytest.approx(high, abs=1e-6)
    scale = 0.5 * SIDE / seen["half"]
    flat = 0.5 * SIDE + (corners - 0.5 * (low + high)) * (scale, -scale) - 0.5
    image = Image.new("1", (SIDE, SIDE))
    draw = ImageDraw.Draw(image)
    for triangle in flat:
        draw.polygon([tuple(place) for place in triangle], fill=1)
    expected = np.asarray(image)
    both = (seen["picture"] & expected).sum()
    assert both / (seen["picture"] | expected).sum() > 0.97


def test_a_mechanism_moves_as_it_was_filmed():
    from scipy.spatial.transform import Rotation

    def frame(share: float) -> Shapes:
        turn = Rotation.from_rotvec((0, 0, 2.0 * share)).as_matrix()
        moved = Mesh(BOX.vertices @ turn.T + (50 * share, 0, 0), BOX.faces)
        return Shapes(solids=(Solid(moved, "Arm"),))

    shares = np.linspace(0.0, 1.0, 31)
    film = glb.write_motion([frame(share) for share in shares], shares.tolist())
    times = (0.0, 0.5, 0.9)
    seen = asked(film, times)
    assert seen["clips"] == 1
    for time, places in zip(times, seen["frames"], strict=True):
        expected = frame(time).solids[0].mesh.vertices[:, [0, 2, 1]] * (1, 1, -1) / 1000.0
        away = np.linalg.norm(places[:, None] - expected, axis=2)
        assert away.min(axis=1).max() < 1e-5
        assert away.min(axis=0).max() < 1e-5
