"""What the report tells of surfaces is what anybody measures on the files beside it."""

import json
import struct

import numpy as np
import pytest

from bozzetto.cli.main import main


def read_obj(text):
    """Return normals, and for each group its corners as pairs of place and normal."""
    normals, groups, own = [], {}, []
    for line in text.splitlines():
        word, *rest = line.split()
        if word == "vn":
            normals.append([float(x) for x in rest])
        elif word == "g":
            (name,) = rest
            assert name not in groups
            own = groups[name] = []
        elif word == "f":
            own += [(int(a) - 1, int(b) - 1) for a, _, b in (x.split("/") for x in rest)]
    return np.array(normals), groups


def read_glb(data):
    """Return normals, and for each primitive its corners as pairs of place and normal."""
    size = struct.unpack_from("<I", data, 12)[0]
    scene, blob = json.loads(data[20 : 20 + size]), data[28 + size :]

    def rows(number, kind, width):
        entry = scene["accessors"][number]
        view = scene["bufferViews"][entry["bufferView"]]
        start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
        return np.frombuffer(blob, kind, entry["count"] * width, start).reshape(-1, width)

    groups, normals = {}, None
    for mesh in scene["meshes"]:
        for one in mesh["primitives"]:
            places = rows(one["attributes"]["POSITION"], "<f4", 3)
            normals = rows(one["attributes"]["NORMAL"], "<f4", 3)
            _, place = np.unique(places, axis=0, return_inverse=True)
            corners = rows(one["indices"], "<u4", 1).ravel()
            name = scene["materials"][one["material"]]["name"]
            groups[name] = list(zip(place.ravel()[corners].tolist(), corners.tolist(), strict=True))
    return normals, groups


def largest_angle(normals, groups, pair):
    """Return the largest angle in degrees between both groups' normals at places of both."""
    here, there = (dict(groups[name]) for name in pair)
    met = sorted(here.keys() & there.keys())
    a, b = (normals[[row[k] for k in met]].astype(float) for row in (here, there))
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))).max()


def sheet(tilt):
    """Two bent surfaces side by side; with a tilt, the tangents at a joint lie in no plane."""

    def row(f):
        return [f(t) for t in np.linspace(0.0, 1.0, 25)]

    def height(x, y):
        return 20.0 * np.sin(x / 30.0) + y * y / 300.0

    def along(y, lift):  # lifted behind its middle by as much as there is tilt
        def at(t):
            x = 80.0 * t
            return [x, y, height(x, y) + lift * max(0.0, x - 40.0)]

        return at

    def across(x, lift):
        return lambda t: [x, 60.0 * t, height(x, 60.0 * t) + lift * (1.0 - t) * max(0.0, x - 40.0)]

    curves = {
        "front left": row(lambda t: along(0.0, tilt)(0.5 * t)),
        "front right": row(lambda t: along(0.0, tilt)(0.5 + 0.5 * t)),
        "back left": row(lambda t: along(60.0, 0.0)(0.5 * t)),
        "back right": row(lambda t: along(60.0, 0.0)(0.5 + 0.5 * t)),
        "left": row(across(0.0, tilt)),
        "middle": row(across(40.0, tilt)),
        "right": row(across(80.0, tilt)),
    }
    named = [{"name": k.replace(" ", "_"), "points": v} for k, v in curves.items()]
    return {"network": {"curves": named, "creases": {"middle": 0}}, "unit": "mm"}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    def build(facts, *endings):
        folder = tmp_path_factory.mktemp("built")
        (folder / "net.json").write_text(json.dumps(facts))
        made = []
        for ending in endings:
            out, told = folder / f"net.{ending}", folder / "told.json"
            words = ["build", "product", str(folder / "net.json"), "-o", str(out)]
            assert main([*words, "--report", str(told)]) == 0
            made.append(out.read_bytes())
        return json.loads(told.read_text()), made

    return build


@pytest.mark.parametrize("tilt", [0.0, 0.06, 0.3])
def test_angles_in_files_of_triangles_are_those_told(built, tilt):
    told, (obj, glb) = built(sheet(tilt), "obj", "glb")
    (edge,) = told["edges"]
    assert edge["smooth"]
    assert (edge["angle_deg"] > 0.5) == (tilt > 0)
    groups = {patch["name"]: patch["group"] for patch in told["patches"]}
    by_obj = largest_angle(*read_obj(obj.decode()), [groups[name] for name in edge["patches"]])
    by_glb = largest_angle(*read_glb(glb), edge["patches"])
    assert by_obj == pytest.approx(edge["angle_vertices_deg"], abs=1e-3)
    assert by_glb == pytest.approx(edge["angle_vertices_deg"], abs=1e-3)
    for patch in told["patches"]:
        assert patch["g1_vertices_deg"] == edge["angle_vertices_deg"]
        assert patch["g1_deg"] == edge["angle_deg"] >= edge["angle_vertices_deg"]


@pytest.mark.parametrize("tilt", [0.0, 0.03, 0.3])
def test_a_smooth_edge_that_ends_in_a_kink_is_told_with_its_angle(built, tilt):
    told, _ = built(sheet(tilt), "obj")
    (edge,) = told["edges"]
    said = [line for line in told["warnings"] if "no common plane" in line]
    assert len(said) == (edge["angle_deg"] >= 5.0)
    for line in said:
        assert line.startswith("middle is smooth")
        assert f"{edge['angle_deg']:.0f}°" in line
