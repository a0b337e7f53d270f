"""Networks of curves in files: what is read, what is refused, and in which words."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

from bozzetto.errors import Cancelled, UserError
from bozzetto.exchange.formats import FORMATS, find
from bozzetto.exchange.left_out import parts_left_out
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.geometry import GapError, Shapes, Spline
from bozzetto.ink import distances_to_polyline
from bozzetto.plugin import Job
from bozzetto_product.hand_over import shapes
from bozzetto_product.hand_over.imported import product_of_network, product_of_shapes
from bozzetto_product.hand_over.network_file import network_of
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.modeler import ProductModeler
from tests.plugins.product.detail_kit import ball_curves, solved

CORNERS = {
    "a": (0, 0, 0), "b": (100, 0, 0), "c": (100, 60, 0), "d": (0, 60, 0),
    "e": (0, 0, 40), "f": (100, 0, 40), "g": (100, 60, 40), "h": (0, 60, 40),
}  # fmt: skip
BOX = ("ab", "bc", "cd", "da", "ef", "fg", "gh", "he", "ae", "bf", "cg", "dh")

LINE = [[0, 0, 0], [1, 0, 0]]


def box(scale: float = 1.0) -> dict:
    curves = [
        {"name": edge, "points": (scale * np.array([CORNERS[end] for end in edge])).tolist()}
        for edge in BOX
    ]
    return {"network": {"curves": curves}, "unit": "mm"}


def report(facts: dict) -> dict:
    modeler = ProductModeler()
    state = product_of_network(facts)
    return modeler.report(state, modeler.solve(state, Job()), Job())


def test_a_box_closes_with_six_surfaces() -> None:
    told = report(box())
    assert told["closed"]
    assert told["joints"] == 8
    assert told["surfaces"] == len(told["patches"]) == 6
    assert len(told["loops"]) == len(told["patches"]) == 6
    faces = {frozenset(loop) for loop in told["loops"]}
    assert frozenset(("ab", "bf", "ef", "ae")) in faces
    assert all(len(loop) == 4 for loop in told["loops"])


def each_twice(facts: dict) -> dict:
    """Return a network with every curve twice: the other one backward, with points of its own."""
    curves = facts["network"]["curves"]
    for curve in list(curves):
        (begin, *_, end) = np.array(curve["points"])
        shares = np.linspace(0.0, 1.0, 9)[::-1, None] ** 1.5
        points = (begin + shares * (end - begin)).tolist()
        curves.append({"name": f"{curve['name']}-again", "points": points})
    return facts


def test_a_curve_that_is_there_twice_is_one() -> None:
    """As programs write the edges of each surface, the shared ones twice."""
    once, twice = report(box()), report(each_twice(box()))
    assert twice["loops"] == once["loops"]
    assert twice["closed"]
    assert [p["area_mm2"] for p in twice["patches"]] == [p["area_mm2"] for p in once["patches"]]


@pytest.mark.parametrize("seed", range(3))
def test_a_curve_that_is_there_twice_may_stand_anywhere(seed: int) -> None:
    """As a program writes the edges of each surface: joints are those of the curves kept."""
    facts = each_twice(box())
    curves = facts["network"]["curves"]
    order = np.random.default_rng(seed).permutation(len(curves))
    facts["network"]["curves"] = [curves[k] for k in order]
    told = report(facts)
    assert told["closed"]
    assert told["joints"] == 8
    areas = sorted(p["area_mm2"] for p in told["patches"])
    np.testing.assert_allclose(areas, sorted(p["area_mm2"] for p in report(box())["patches"]))


def test_the_other_name_of_a_curve_stands_for_it() -> None:
    facts = each_twice(box())
    facts["network"] |= {
        "loops": [["ab", "bf-again", "ef", "ae-again"], ["ab-again", "bc", "cd", "da"]],
        "creases": {"ab-again": 0},
        "pressure": {"ab-again bc cd-again da": 0.5},
    }
    told = report(facts)
    assert [sorted(loop) for loop in told["loops"]] == [
        ["ab", "ae", "bf", "ef"], ["ab", "bc", "cd", "da"],
    ]  # fmt: skip
    assert network_of(facts).state.of_kind(Curve)[0].edge == "smooth"
    facts["network"]["loops"] = [["ab-again/1", "bc", "cd", "da"]]
    with pytest.raises(UserError, match="same curve as “ab”"):
        network_of(facts)


def test_curves_that_are_near_or_lie_on_another_in_part_stay() -> None:
    facts = box()
    facts["network"]["curves"] += [
        {"name": "part", "points": [[0, 0, 0], [50, 0, 0]]},
        {"name": "near", "points": [[0, 0, 40.5], [100, 0, 40.5]]},
        {"name": "bow", "points": [[100 * t, 0, 40 * t * (1 - t)] for t in np.linspace(0, 1, 20)]},
    ]
    assert len(network_of(facts).state.of_kind(Curve)) == len(BOX) + 3


def test_a_thousand_times_larger_is_the_same_network() -> None:
    small, large = report(box()), report(box(1000.0))
    assert small["loops"] == large["loops"]
    areas = np.array([[p["area_mm2"] for p in told["patches"]] for told in (small, large)])
    assert np.allclose(areas[1], 1e6 * areas[0], rtol=1e-5)


def test_units_scale_the_points() -> None:
    facts = box()
    facts["unit"] = "cm"
    points = np.vstack([c.spline.control_points for c in network_of(facts).state.of_kind(Curve)])
    assert points.max() == 1000.0


def test_ends_that_coincide_become_joints_and_an_end_on_a_curve_a_t_joint() -> None:
    facts = box()
    facts["network"]["curves"].append({"name": "mid", "points": [[50, 0, 40], [50, 60, 40]]})
    told = report(facts)
    names = {name for loop in told["loops"] for name in loop}
    assert {"ef/1", "ef/2", "gh/1", "gh/2", "mid"} <= names
    assert len(told["loops"]) == 7
    assert told["closed"]


def test_curves_that_cross_are_joined_where_they_cross() -> None:
    lines = [
        {"name": f"{axis}{k}", "points": [[-10, 10 * k, 0], [30, 10 * k, 0]]
         if axis == "u" else [[10 * k, -10, 0], [10 * k, 30, 0]]}
        for axis in "uv" for k in range(3)
    ]  # fmt: skip
    state = network_of({"network": {"curves": lines}}).state
    assert len(state.joints) == 9
    assert all(len(joint.meetings) == 2 for joint in state.joints)


def test_named_loops_are_the_surfaces_and_no_others() -> None:
    facts = box()
    facts["network"]["loops"] = [["ab", "bf", "ef", "ae"], ["ab", "bc", "cd", "da"]]
    facts["network"]["creases"] = {"ab": 0}
    facts["network"]["pressure"] = {"ab bc cd da": 0.5}
    state = product_of_network(facts)
    assert [patch.pressure for patch in state.of_kind(Patch)] == [0.0, 0.5]
    assert next(c for c in state.of_kind(Curve) if c.name == "ab").edge == "smooth"


def test_points_are_fitted_within_the_tolerance() -> None:
    turn = np.linspace(0.0, 2.5, 80)
    points = np.column_stack((100 * np.cos(turn), 100 * np.sin(turn), 20 * turn))
    network = network_of({"network": {"curves": [{"name": "c", "points": points.tolist()}]}})
    (curve,) = network.state.of_kind(Curve)
    feet = curve.spline.value(curve.spline.foot_points(points))
    assert np.linalg.norm(feet - points, axis=1).max() <= network.tolerance
    assert len(curve.spline.control_points) < 14
    assert (curve.spline.control_points[[0, -1]] == points[[0, -1]]).all()


def test_a_ring_is_one_closed_curve_with_one_surface() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    points = np.column_stack((50 * np.cos(turn), 30 * np.sin(turn), 5 * np.cos(2 * turn)))
    points[-1] = points[0]
    facts = {"network": {"curves": [{"name": "ring", "points": points.tolist()}]}}
    (curve,) = network_of(facts).state.of_kind(Curve)
    assert curve.spline.closed
    assert report(facts)["loops"] == [["ring"]]


def _broken() -> dict[str, object]:
    def made(change) -> dict:
        facts = deepcopy(box())
        change(facts)
        return facts

    def curve(facts: dict, value: object) -> None:
        facts["network"]["curves"][0] = value

    def points(facts: dict, value: object) -> None:
        facts["network"]["curves"][0]["points"] = value

    def network(facts: dict, key: str, value: object) -> None:
        facts["network"][key] = value

    return {
        "no object": {"network": 7},
        "no curves": {"network": {}},
        "empty": {"network": {"curves": []}},
        "unknown key": made(lambda f: network(f, "loop", [])),
        "unit": made(lambda f: f.update(unit="furlong")),
        "unit of a wrong kind": made(lambda f: f.update(unit=["mm"])),
        "curve no object": made(lambda f: curve(f, [1, 2])),
        "no points": made(lambda f: curve(f, {"name": "x"})),
        "one point": made(lambda f: points(f, [[0, 0, 0]])),
        "flat points": made(lambda f: points(f, [[0, 0], [1, 1]])),
        "words": made(lambda f: points(f, [["a", 0, 0], [1, 1, 1]])),
        "not a number": made(lambda f: points(f, [[float("nan"), 0, 0], [1, 1, 1]])),
        "too far": made(lambda f: points(f, [[1e300, 0, 0], [1, 1, 1]])),
        "too far in its unit": made(lambda f: (points(f, [[1e5, 0, 0], [1, 1, 1]]),
                                               f.update(unit="m"))),
        "huge integer": made(lambda f: points(f, [[10**400, 0, 0], [1, 1, 1]])),
        "one place": made(lambda f: points(f, [[1, 1, 1]] * 5)),
        "all one place": {"network": {"curves": [{"name": "a", "points": [[1, 1, 1]] * 3}]}},
        "true": made(lambda f: points(f, [[True, 0, 0], [1, 1, 1]])),
        "name twice": made(lambda f: f["network"]["curves"].append(f["network"]["curves"][0])),
        "name of a wrong kind": made(lambda f: curve(f, {"name": 5, "points": LINE})),
        "name with a slash": made(lambda f: curve(f, {"name": "a/1", "points": LINE})),
        "loop of unknown curves": made(lambda f: network(f, "loops", [["ab", "zz"]])),
        "loop that is open": made(lambda f: network(f, "loops", [["ab", "bc"]])),
        "loop of nothing": made(lambda f: network(f, "loops", [[]])),
        "loops of a wrong kind": made(lambda f: network(f, "loops", "ab bc")),
        "crease too large": made(lambda f: network(f, "creases", {"ab": 3})),
        "crease of nobody": made(lambda f: network(f, "creases", {"zz": 1})),
        "crease of a piece": made(lambda f: network(f, "creases", {"ab/1": 0})),
        "pressure of no surface": made(lambda f: network(f, "pressure", {"ab gh": 1})),
        "pressure without end": made(lambda f: network(f, "pressure", {"ab": float("inf")})),
    }  # fmt: skip


@pytest.mark.parametrize("name", _broken())
def test_what_makes_no_sense_is_refused_with_a_sentence(name: str) -> None:
    with pytest.raises(UserError) as refused:
        product_of_network(_broken()[name])
    assert refused.value.message.rstrip().endswith(".")


def test_the_command_line_writes_groups_that_share_their_vertices(tmp_path: Path) -> None:
    from bozzetto.cli.main import main

    file, shape, told = (tmp_path / name for name in ("net.json", "net.obj", "told.json"))
    file.write_text(json.dumps(box()))
    words = ["build", "product", str(file), "-o", str(shape), "--report", str(told)]
    assert main(words) == 0
    lines = shape.read_text().splitlines()
    assert len({line for line in lines if line.startswith("g ")}) == 6
    places = [line for line in lines if line.startswith("v ")]
    assert len(places) == len(set(places))
    assert json.loads(told.read_text())["closed"]


@pytest.mark.interop
def test_a_closed_network_is_one_valid_solid_for_cad(tmp_path: Path) -> None:
    pytest.importorskip("OCP")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    from bozzetto.cli.main import main

    file, shape = tmp_path / "net.json", tmp_path / "net.step"
    file.write_text(json.dumps(box()))
    assert main(["build", "product", str(file), "-o", str(shape)]) == 0
    reader = STEPControl_Reader()
    reader.ReadFile(str(shape))
    reader.TransferRoots()
    read = reader.OneShape()
    assert BRepCheck_Analyzer(read).IsValid()
    solids = TopExp_Explorer(read, TopAbs_ShapeEnum.TopAbs_SOLID)
    assert solids.More()
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(read, properties)
    assert properties.Mass() == pytest.approx(100 * 60 * 40, rel=1e-9)


def test_a_part_that_misses_its_edges_loses_its_exact_form_alone_and_that_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def misses(parts: object) -> None:
        raise GapError("an edge lies 1 mm beside a face")

    monkeypatch.setattr(shapes, "sewn", misses)
    state = product_of_network({"network": {"curves": ball_curves()}})
    (solid,) = shapes_of(state, solved(state)).solids
    assert solid.exact is None
    assert len(solid.mesh.faces) > 0
    (told,) = parts_left_out(Shapes(solids=(solid,)), find("a.step", FORMATS))
    assert "no exact surfaces" in str(told)


def test_curves_beyond_all_measure_are_refused_with_a_sentence() -> None:
    far = ShapeCurve(1, np.array([0, 0, 1, 2, 2.0]), 1e12 * np.array([LINE[0], LINE[1], [0, 1, 1]]))
    with pytest.raises(UserError, match="too far"):
        product_of_shapes(Shapes(curves=(far,)))


def test_a_recipe_holds_no_curve_beyond_all_measure() -> None:
    with pytest.raises(UserError, match="farther"):
        Curve("c", "c", spline=Spline.uniform(1e12 * np.eye(4, 3)))


def test_three_closed_circles_whose_seams_lie_on_crossings_are_a_ball() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 61)
    x, y, zero = 30.0 * np.cos(turn), 30.0 * np.sin(turn), 0.0 * turn
    circles = {"a": (x, y, zero), "b": (y, zero, x), "c": (zero, x, y)}
    curves = [{"name": k, "points": np.column_stack(p).tolist()} for k, p in circles.items()]
    told = report({"network": {"curves": curves}, "unit": "mm"})
    assert told["closed"]
    assert len(told["patches"]) == 8
    area = sum(patch["area_mm2"] for patch in told["patches"])
    assert area == pytest.approx(4.0 * np.pi * 30.0**2, rel=0.01)


@pytest.mark.parametrize(
    ("name", "told"), [("Côté gauche / bas", "“Côté gauche bas”"), ("/", "“c”"), (" a ", "“a”")]
)
def test_a_name_that_cannot_be_told_apart_is_told_with_one_that_goes(name, told):
    facts = box()
    facts["network"]["curves"][3]["name"] = name
    with pytest.raises(UserError) as problem:
        product_of_network(facts)
    assert name in str(problem.value)
    assert f"Call the curve {told}" in str(problem.value)


def test_names_may_have_blanks_as_those_of_the_window_have():
    facts = box()
    for curve in facts["network"]["curves"]:
        curve["name"] = " ".join(curve["name"])
    facts["network"]["loops"] = [["a b", "b f", "e f", "a e"], ["a b", "b c", "c d", "d a"]]
    facts["network"]["pressure"] = {"b c a b d a c d": 0.5}
    state = product_of_network(facts)
    assert [patch.pressure for patch in state.of_kind(Patch)] == [0.0, 0.5]


@pytest.mark.parametrize("over", [0.02, 0.06, 0.15])
@pytest.mark.parametrize("turned", [False, True])
def test_a_ring_of_two_strokes_that_overlap_meets_once_on_each_side(over, turned):
    """Tails that lie along the other stroke are left to it; curves stay where they were drawn."""
    high = np.linspace(0.0, 60.0, 21)
    curves = [
        {"name": f"rib{k}", "points": np.column_stack((40 * c + 0 * high, 40 * s + 0 * high, high))}
        for k, (c, s) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1)))
    ]
    for level in (0.0, 60.0):
        for half in (0, 1):
            at = np.linspace(np.pi * half, np.pi * (half + 1) + over, 40)
            rows = np.column_stack(
                (40.1 * np.cos(at), 40.1 * np.sin(at), level + 0.05 * half + 0 * at)
            )
            rows = rows[::-1] if turned and half else rows
            curves.append({"name": f"ring{level:.0f}-{half}", "points": rows})
    curves = [{**curve, "points": curve["points"].tolist()} for curve in curves]
    state = product_of_network({"network": {"curves": curves}})
    assert sorted(len(patch.boundary) for patch in state.of_kind(Patch)) == [2, 2, 4, 4, 4, 4]
    given = {curve["name"]: np.array(curve["points"]) for curve in curves}
    made = {curve.name: curve.spline for curve in state.of_kind(Curve)}
    assert made.keys() == given.keys()
    for name, points in given.items():
        own = made[name].value(np.linspace(*made[name].range, 300))
        assert distances_to_polyline(own, points).max() < 1.0
        away = [spline.least_distances(points) for spline in made.values()]
        assert np.min(away, axis=0).max() < 1.0


def test_surfaces_are_painted_and_called_as_the_file_says() -> None:
    facts = box()
    facts["network"]["paint"] = {
        "ab bc cd da": {"color": [226, 88, 62], "finish": "gloss", "name": "Face"},
        "ef fg gh he": {"finish": "glass"},
    }
    state = product_of_network(facts)
    told = {(patch.name, patch.color, patch.finish) for patch in state.of_kind(Patch)}
    assert ("Face", (226, 88, 62), "gloss") in told
    assert sorted(finish for _, _, finish in told) == ["glass", "gloss", *["matt"] * 4]
    result = ProductModeler().solve(state, Job())
    (solid,) = shapes_of(state, result).solids
    groups = {group.name: group for group in solid.groups}
    assert groups["Face"].color == (226, 88, 62)


@pytest.mark.parametrize(
    ("paint", "words"),
    [
        ({"ab bc": {"finish": "gloss"}}, "no surface has exactly"),
        ({"ab zz": {}}, "not there"),
        ({"ab bc cd da": {"colour": [1, 2, 3]}}, "has a key “colour”"),
        ({"ab bc cd da": {"color": [1, 2]}}, "red, green, blue"),
        ({"ab bc cd da": {"color": [1, 2, 300]}}, "255"),
        ({"ab bc cd da": {"finish": "wood"}}, "is one of matt"),
        ({"ab bc cd da": {"name": " "}}, "is a text"),
        ({"ab bc cd da": "red"}, "no object"),
        ([1], "no object"),
    ],
)
def test_paint_that_makes_no_sense_is_refused(paint: object, words: str) -> None:
    facts = box()
    facts["network"]["paint"] = paint
    with pytest.raises(UserError, match=words):
        product_of_network(facts)


def test_a_band_of_one_side_whose_border_is_filled_is_no_solid() -> None:
    def band(u: float | np.ndarray, v: float | np.ndarray) -> np.ndarray:
        reach = 50.0 + v * np.cos(u / 2)
        return np.stack([reach * np.cos(u), reach * np.sin(u), v * np.sin(u / 2)], axis=-1)

    rows = [band(np.linspace(0.0, 4 * np.pi, 161), 12.0)]
    rows += [band(2 * np.pi * k / 3, np.linspace(-12.0, 12.0, 11)) for k in range(3)]
    curves = [{"name": f"c{k}", "points": row.tolist()} for k, row in enumerate(rows, 1)]
    told = report({"network": {"curves": curves}})
    assert len(told["patches"]) >= 3
    assert not told["closed"]
    assert told["open_edges"] or any("one side only" in warning for warning in told["warnings"])


@pytest.mark.parametrize("after", [0, 5, len(BOX) - 1, len(BOX)])
def test_reading_can_be_cancelled_at_every_curve_and_after_them(after: int) -> None:
    asked = []

    def is_cancelled() -> bool:
        asked.append(None)
        return len(asked) > after

    with pytest.raises(Cancelled):
        product_of_network(box(), job=Job(cancelled=is_cancelled))
    assert len(asked) == after + 1
