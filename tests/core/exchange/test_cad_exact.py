"""STEP and IGES by our own readers: curves exact, bodies of whole surfaces, nothing hostile."""

from __future__ import annotations

import math
import random
import time
from itertools import pairwise

import numpy as np
import pytest

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.cad import cad_reader, iges_reader, step_reader
from bozzetto.exchange.cad.cad_curves import checked_curves
from bozzetto.exchange.cad.curve_pieces import ellipse_arc, joined, part_of, polyline
from bozzetto.exchange.cad.curves_drawing import are_flat, drawing_of_curves
from bozzetto.exchange.cad.step_records import Instances
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh.manifold_check import enclosed_volume
from bozzetto.geometry import Brep, Curve, Placement, Shapes
from bozzetto.geometry.brep.planes import plane_face
from bozzetto.geometry.brep.sewing import sewn

BOTH = pytest.mark.parametrize("ending", ["step", "igs"])
SEEDS = pytest.mark.parametrize("seed", range(6))


def random_curves(seed):
    """Curves of every degree up to seven, some rational, some coloured, over odd ranges."""
    rng = np.random.default_rng(seed)
    for number in range(10):
        degree = int(rng.integers(1, 8))
        inner = np.sort(rng.choice(np.round(rng.uniform(0.1, 0.9, 5), 3), rng.integers(0, 4)))
        count = degree + 1 + len(inner)
        knots = np.concatenate((np.zeros(degree + 1), inner, np.ones(degree + 1)))
        yield Curve(
            degree,
            (knots - 0.5) * 10.0 ** rng.uniform(-2, 2),
            rng.normal(size=(count, 3)) * 100,
            rng.uniform(0.3, 3.0, count) if rng.random() < 0.5 else None,
            name=f"“{number}” d'été \\ 曲线",
            color=tuple(map(int, rng.integers(0, 256, 3))) if number % 2 else None,
        )


@BOTH
@SEEDS
def test_our_curves_come_back_as_they_left(tmp_path, ending, seed):
    shapes = Shapes(curves=tuple(random_curves(seed)))
    path = tmp_path / f"a.{ending}"
    export(shapes, path)
    read = read_mesh_file(path, trusted=seed > 0)  # the first in a process of its own
    assert read.left_out == ()
    written = checked_curves(shapes, corners=ending == "step")
    assert len(read.shapes.curves) == len(written)
    for one, two in zip(written, read.shapes.curves, strict=True):
        assert (one.degree, one.closed, one.color) == (two.degree, two.closed, two.color)
        assert (one.control_points == two.control_points).all()
        assert (one.knots == two.knots).all()
        assert (one.weights is None) == (two.weights is None)
        assert one.weights is None or (one.weights == two.weights).all()
        assert ending == "igs" or one.name == two.name
    export(read.shapes, tmp_path / f"b.{ending}")
    assert (tmp_path / f"b.{ending}").read_bytes() == path.read_bytes()


def step(lines, unit="(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))", more=""):
    """Return a STEP file of numbered instances whose curves are those of instance 100."""
    data = [
        f"#1={unit};", "#2=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));",
        "#3=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#1,#2))"
        "REPRESENTATION_CONTEXT('',''));",
        "#10=CARTESIAN_POINT('',(1.,2.,3.));", "#11=DIRECTION('',(0.,0.,1.));",
        "#12=DIRECTION('',(0.,1.,0.));", "#13=AXIS2_PLACEMENT_3D('',#10,#11,#12);",
        "#14=CIRCLE('',#13,5.);", "#15=VECTOR('',#12,2.);", "#16=LINE('',#10,#15);",
        "#17=ELLIPSE('',#13,5.,3.);", *lines,
        "#101=GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION('',(#13,#100),#3);", more,
    ]  # fmt: skip
    head = "ISO-10303-21;HEADER;FILE_SCHEMA(('X'));ENDSEC;DATA;"
    return (head + "\n".join(data) + "\nENDSEC;END-ISO-10303-21;\n").encode()


def curves_of(lines, **more):
    return step_reader.read_exactly(step(lines, **more), bodies=False).curves


def ends(curve):
    return curve.value(curve.range)


def test_lines_and_arcs_of_step_are_cut_where_their_file_says():
    line, arc, back = curves_of([
        "#20=TRIMMED_CURVE('Edge',#16,(PARAMETER_VALUE(0.5)),(PARAMETER_VALUE(3.)),.T.,.PARAMETER.);",
        "#21=TRIMMED_CURVE('',#14,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(1.5707963267948966)),"
        ".T.,.PARAMETER.);",
        "#22=CARTESIAN_POINT('',(1.,7.,3.));", "#23=CARTESIAN_POINT('',(-4.,2.,3.));",
        "#24=TRIMMED_CURVE('',#14,(#23),(#22),.F.,.CARTESIAN.);",
        "#100=GEOMETRIC_CURVE_SET('Set',(#20,#21,#24));",
    ])  # fmt: skip
    assert (line.name, arc.name) == ("Edge", "Set")
    assert ends(line) == pytest.approx(np.array([[1, 3, 3], [1, 8, 3]]))
    assert ends(arc) == pytest.approx(np.array([[1, 7, 3], [-4, 2, 3]]))
    assert ends(back) == pytest.approx(np.array([[-4, 2, 3], [1, 7, 3]]))
    for curve in (arc, back):  # the shorter way, both times
        at = curve.value(np.linspace(*curve.range, 50))
        assert np.linalg.norm(at - (1, 2, 3), axis=1) == pytest.approx(5.0)
        assert (at[:, 0] <= 1 + 1e-9).all()


def test_rows_of_curves_are_one_curve():
    (whole,) = curves_of([
        "#20=CARTESIAN_POINT('',(1.,7.,3.));", "#21=CARTESIAN_POINT('',(9.,7.,3.));",
        "#22=POLYLINE('',(#21,#20));", "#23=CARTESIAN_POINT('',(-4.,2.,3.));",
        "#24=TRIMMED_CURVE('',#14,(#20),(#23),.T.,.CARTESIAN.);",
        "#25=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#22);",
        "#26=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#24);",
        "#100=COMPOSITE_CURVE('Row',(#25,#26),.F.);",
    ])  # fmt: skip
    assert whole.name == "Row"
    assert whole.degree == 2
    assert ends(whole) == pytest.approx(np.array([[9, 7, 3], [-4, 2, 3]]))
    on = whole.value(np.linspace(*whole.range, 300))
    straight = (np.abs(on[:, 1] - 7) < 1e-9) & (on[:, 0] > 1 - 1e-9)
    round_ = np.abs(np.linalg.norm(on - (1, 2, 3), axis=1) - 5.0) < 1e-9
    assert (straight | round_).all()


@pytest.mark.parametrize(
    ("unit", "size"),
    [
        ("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.))", 1000.0),
        ("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.CENTI.,.METRE.))", 10.0),
        ("(CONVERSION_BASED_UNIT('INCH',#4)LENGTH_UNIT()NAMED_UNIT(#6))", 25.4),
    ],
)
def test_units_of_step(unit, size):
    inch = (
        "#4=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#5);"
        "#5=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));"
    )
    lines = ["#100=GEOMETRIC_CURVE_SET('',(#14,#17));"]
    circle, ellipse = curves_of(lines, unit=unit, more=inch)
    at = circle.value(np.linspace(*circle.range, 99)) / size - (1, 2, 3)
    assert np.linalg.norm(at, axis=1) == pytest.approx(5.0)
    at = ellipse.value(np.linspace(*ellipse.range, 99)) / size - (1, 2, 3)
    assert (at[:, 1] / 5) ** 2 + (at[:, 0] / 3) ** 2 == pytest.approx(1.0)
    assert circle.closed
    assert ellipse.closed


def test_assemblies_place_curves_as_often_as_they_are_used():
    placed = (
        "#200=CARTESIAN_POINT('',(0.,0.,0.));#201=AXIS2_PLACEMENT_3D('',#200,$,$);"
        "#202=CARTESIAN_POINT('',(10.,0.,0.));#203=AXIS2_PLACEMENT_3D('',#202,#11,#12);"
        "#204=CARTESIAN_POINT('',(0.,0.,50.));#205=AXIS2_PLACEMENT_3D('',#204,$,$);"
        "#206=SHAPE_REPRESENTATION('',(#201,#203,#205),#3);"
    ) + "".join(
        f"#{n}=ITEM_DEFINED_TRANSFORMATION('','',#201,#{to});"
        f"#{n + 1}=(REPRESENTATION_RELATIONSHIP('','',#101,#206)"
        f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{n})SHAPE_REPRESENTATION_RELATIONSHIP());"
        for n, to in ((210, 203), (220, 205))
    )
    lines = ["#20=CARTESIAN_POINT('',(4.,2.,3.));", "#100=POLYLINE('',(#10,#20));"]
    found = curves_of(lines, more=placed)
    places = sorted(ends(curve).round(9).tolist() for curve in found)
    assert places == [[[1, 2, 53], [4, 2, 53]], [[8, 1, 3], [8, 4, 3]]]


def test_what_is_no_spline_is_told(tmp_path):
    data = step([
        "#20=POLYLINE('',(#10,#21));", "#21=CARTESIAN_POINT('',(4.,2.,3.));",
        "#22=PARABOLA('',#13,2.);", "#23=POLYLINE('',(#10,#999));",
        "#100=GEOMETRIC_CURVE_SET('',(#20,#22,#23,#16));",
    ])  # fmt: skip
    (tmp_path / "a.step").write_bytes(data)
    read = read_mesh_file(tmp_path / "a.step")
    assert len(read.shapes.curves) == 1
    (said,) = read.left_out
    for words in ("1 × parabola", "1 × damaged curve", "1 × a line without an end"):
        assert words in said


# -- IGES --------------------------------------------------------------------------------------


def iges(entities, unit=2):
    """Return a file of entities: kind, form, matrix, parameters."""
    from bozzetto.exchange.cad.iges import _fields, _rows  # noqa: PLC2701

    directory, parameters = [], []
    for kind, form, matrix, values in entities:
        rows = list(_rows([str(kind), *values.split(",")], 64))
        first = len(parameters) + 1
        parameters += [f"{row:<64}{len(directory) + 1:>8}" for row in rows]
        directory.append(_fields(kind, first, 0, 0, 0, 0, matrix, 0, "00000000"))
        directory.append(_fields(kind, 0, 2, len(rows), form, "", "", "Label", 0))
    settings = ["1H,", "1H;", "1HX", "1HX", "1HX", "1HX", "32", "38", "7", "308", "17", "1HX",
                "1.", str(unit), "2HIN", "1", "0.1"]  # fmt: skip
    sections = {"S": [""], "G": list(_rows(settings, 72)), "D": directory, "P": parameters}
    lines = [
        f"{row:<72}{letter}{number:>7}"
        for letter, rows in sections.items()
        for number, row in enumerate(rows, 1)
    ]
    return "\n".join(lines).encode()


def test_curves_of_iges():
    data = iges([
        (124, 0, 0, "0.,-1.,0.,10.,1.,0.,0.,20.,0.,0.,1.,30."),
        (100, 0, 0, "3.,1.,2.,6.,2.,1.,7."),
        (110, 0, 1, "0.,0.,0.,4.,0.,0."),
        (106, 12, 0, "2,3,0.,0.,0.,1.,0.,0.,1.,1.,5."),
        (106, 63, 0, "1,3,7.,0.,0.,1.,0.,1.,1."),
        (104, 1, 0, ".04,0.,.25,0.,0.,-1.,6.,5.,0.,0.,2."),
        (112, 0, 0, "3,0,3,1,0.,2.,1.,2.,3.,4.,0.,1.,0.,0.,5.,0.,0.,1."),
    ], unit=1)  # fmt: skip
    made = iges_reader.read_exactly(data, bodies=False).curves
    arc, line, path, ring, conic, cubic = made
    inch = 25.4
    assert all((c.name, c.color) == ("Label", (255, 0, 0)) for c in made)
    at = arc.value(np.linspace(*arc.range, 40)) / inch - (1, 2, 3)
    assert np.linalg.norm(at, axis=1) == pytest.approx(5.0)
    assert at[[0, -1]] == pytest.approx(np.array([[5, 0, 0], [0, 5, 0]]))
    assert ends(line) / inch == pytest.approx(np.array([[10, 20, 30], [10, 24, 30]]))
    assert path.control_points / inch == pytest.approx(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 5]]))
    assert ring.closed
    assert len(ring.control_points) == 4
    at = conic.value(np.linspace(*conic.range, 40)) / inch
    assert (at[:, 0] / 5) ** 2 + (at[:, 1] / 2) ** 2 == pytest.approx(1.0)
    assert at[[0, -1]] == pytest.approx(np.array([[5, 0, 6], [0, 2, 6]]))
    t = np.linspace(0.0, 2.0, 30)
    powers = np.column_stack((1 + 2 * t + 3 * t**2 + 4 * t**3, t, 5 + t**3))
    assert cubic.value(t) / inch == pytest.approx(powers)


# -- pieces ------------------------------------------------------------------------------------


@SEEDS
def test_parts_and_rows_are_exact(seed):
    for curve in random_curves(seed):
        low, high = curve.range
        cuts = low + (high - low) * np.array([0.0, 0.31, 0.77, 1.0])
        parts = [part_of(curve, a, b) for a, b in pairwise(cuts)]
        for part, a, b in zip(parts, cuts[:-1], cuts[1:], strict=True):
            at = np.linspace(a, b, 20)
            assert np.abs(part.value(at) - curve.value(at)).max() < 1e-9
        (whole,) = joined(parts)
        at = np.linspace(low, high, 50)
        assert np.abs(whole.value(at - low + whole.range[0]) - curve.value(at)).max() < 1e-8


@SEEDS
def test_a_row_of_different_curves_is_run_in_their_order(seed):
    rng = random.Random(seed)
    arc = ellipse_arc((0, 0, 0), (3, 0, 0), (0, 2, 0), 0.0, rng.uniform(0.1, 6.2))
    end = arc.value(arc.range)[1]
    one, far = end + np.ones(3), end + np.array([5.0, 5.0, 5.0])
    last = ellipse_arc(one - (0, 0, 1), (0, 0, 1), (1, 0, 0), 0.0, 2.0)
    row = (arc, polyline([end, one]), last)
    (whole,) = joined(row)
    expected = np.concatenate([c.value(np.linspace(*c.range, 30)) for c in row])
    dense = whole.value(np.linspace(*whole.range, 20_001))
    off = [np.linalg.norm(dense - place, axis=1).min() for place in expected]
    assert max(off) < 2e-3
    apart = polyline([far, 2 * far])
    assert len(joined((arc, apart))) == 2


def test_ink_of_curves_is_seen_along_their_shortest_side():
    ring = [polyline([(0, 0, 0), (9, 0, 0), (9, 5, 0)]), polyline([(0, 0, 0), (9, 5, 0)])]
    for placement, said in (
        (Placement(), ()), (Placement((1, 0, 0, 0, 0, -1, 0, 1, 0)), ()),
    ):  # fmt: skip
        drawing = drawing_of_curves([one.placed(placement) for one in ring], "x")
        (stroke,) = drawing.strokes  # what closes is one stroke
        assert np.ptp(stroke.x) == pytest.approx(9.0, rel=1e-5)
        assert np.ptp(stroke.y) == pytest.approx(5.0, rel=1e-5)
        assert drawing.left_out == said
        assert are_flat([one.placed(placement) for one in ring])
    assert not are_flat([polyline([(0, 0, 0), (9, 8, 1)])])
    drawing = drawing_of_curves([polyline([(0, 0, 0), (9, 8, 1)])], "x")
    assert "as seen from above" in drawing.left_out[0]


# -- bodies without a library ------------------------------------------------------------------


def box(*size):
    """Return a closed box, one face for each side, with names."""
    x, y, z = size
    corners = np.array([[i, j, k] for i in (0, x) for j in (0, y) for k in (0, z)], float)
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return sewn([plane_face([corners[list(side)]]) for side in sides], "Box", (10, 200, 30))


@BOTH
def test_bodies_of_planes_and_whole_surfaces_need_no_library(tmp_path, ending, monkeypatch):
    monkeypatch.setattr(cad_reader, "find_spec", lambda name: None)
    rng = np.random.default_rng(3)
    from bozzetto.geometry.brep.surface import BSplineSurface

    net = np.stack(np.meshgrid(*2 * [np.arange(4.0)], indexing="ij"), -1) * 30
    net = np.concatenate((net, rng.normal(size=(4, 4, 1)) * 9), axis=2)
    knots = np.repeat([0.0, 1.0], 4)
    bent = Brep.of_surface(BSplineSurface((3, 3), knots, knots, net), "Bent")
    shapes = Shapes(breps=(box(10, 20, 30), bent))
    export(shapes, tmp_path / f"a.{ending}")
    read = read_mesh_file(tmp_path / f"a.{ending}", trusted=True)
    (solid,), (surface,) = read.shapes.solids, read.shapes.surfaces
    assert enclosed_volume(solid.mesh) == pytest.approx(6000.0, rel=1e-6)
    assert solid.name == "Box"
    assert surface.name == "Bent"
    exact = bent.faces[0].surface
    u = rng.uniform(size=200)
    places = exact.value(u, rng.uniform(size=200))
    off = [np.linalg.norm(surface.mesh.vertices - place, axis=1).min() for place in places]
    assert max(off) < 9.0  # the triangles are that large
    assert "exact surfaces" in read.left_out[0]


def test_other_bodies_ask_for_the_library(tmp_path, monkeypatch):
    monkeypatch.setattr(cad_reader, "find_spec", lambda name: None)
    monkeypatch.setitem(__import__("sys").modules, "OCP", None)
    export(Shapes(breps=(box(1, 2, 3),)), tmp_path / "a.step")
    text = (tmp_path / "a.step").read_text().replace("=PLANE(", "=CYLINDRICAL_SURFACE(")
    (tmp_path / "b.step").write_text(text)
    with pytest.raises(UserError, match=r"bozzetto\[cad\]"):
        read_mesh_file(tmp_path / "b.step", trusted=True)


# -- hostile -----------------------------------------------------------------------------------

CYCLE = [
    "#20=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#100);",
    "#100=COMPOSITE_CURVE('',(#20,#20),.F.);",
]
BRANCHES = [
    f"#{n}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#{n + 1});"
    f"#{n + 1}=COMPOSITE_CURVE('',({','.join([f'#{n + 2}'] * 9)}),.F.);"
    for n in range(20, 80, 2)
]
MANY_KNOTS = [
    "#20=B_SPLINE_CURVE_WITH_KNOTS('',1,(#10,#10),.U.,.F.,.U.,(900000000,2),(0.,1.),.U.);",
    "#100=GEOMETRIC_CURVE_SET('',(#20));",
]


@pytest.mark.parametrize(
    "data",
    [
        step(CYCLE), step([*BRANCHES, "#100=COMPOSITE_CURVE('',(#20),.F.);"]), step(MANY_KNOTS),
        step(["#100=GEOMETRIC_CURVE_SET('',(" + "(" * 5000 + ")" * 5000 + "));"]),
        step(["#1=" * 200_000, "#100=POLYLINE('',('"]),
        step(["/*" * 200_000, "#100=POLYLINE('',(#10));"]),
        step(["#100=GEOMETRIC_CURVE_SET('',(#100,#100,#100));"]),
        step(["#20=CIRCLE('',#13,1.E400);#100=GEOMETRIC_CURVE_SET('',(#20));"]),
    ],
    ids=["cycle", "branches", "knots", "brackets", "unclosed", "comments", "self", "infinite"],
)  # fmt: skip
def test_hostile_step_files_hold_no_curve_and_say_so_soon(data):
    began = time.process_time()
    try:
        found = step_reader.read_exactly(data, bodies=True)
    except FormatError:
        found = None
    assert found is None or not found.curves
    assert time.process_time() - began < 10.0


@BOTH
@SEEDS
def test_damaged_files_are_read_or_refused(tmp_path, ending, seed):
    rng = random.Random(seed)
    export(Shapes(curves=tuple(random_curves(seed))), tmp_path / f"a.{ending}")
    good = (tmp_path / f"a.{ending}").read_bytes()
    read = step_reader.read_exactly if ending == "step" else iges_reader.read_exactly
    for _ in range(30):
        bad = bytearray(good)
        for _ in range(rng.randint(1, 20)):
            at = rng.randrange(len(bad))
            bad[at : at + rng.choice((1, 2, 30))] = rng.randbytes(rng.choice((0, 1, 2, 30)))
        try:
            found = read(bytes(bad), bodies=rng.random() < 0.5)
        except FormatError:
            continue
        assert all(np.isfinite(curve.control_points).all() for curve in found.curves)


def test_iges_whose_entities_share_all_lines_is_refused_soon():
    line = "110,0.,0.,0.,1.,1.,1.;".ljust(64) + "       1P      1"
    entry = f"{110:>8}{1:>8}".ljust(72) + "D      1\n" + f"{110:>8}{0:>8}{0:>8}{9000:>8}".ljust(72)
    rows = ["".ljust(72) + "S      1", "1H,,1H;;".ljust(72) + "G      1"]
    data = "\n".join([*rows, *[entry + "D      2"] * 9000, *[line] * 9000]).encode()
    began = time.process_time()
    with pytest.raises(FormatError, match="lines of parameters"):
        iges_reader.read_exactly(data, bodies=True)
    assert time.process_time() - began < 10.0


def test_strings_hold_their_signs():
    data = step(["#100=POLYLINE('it''s \\X2\\00E9\\X0\\ /* no; */ \\S\\i',(#10,#20));",
                 "#20 = CARTESIAN_POINT /* a; 'b */ ('',\n(4.,2.,3.));"])  # fmt: skip
    instances = Instances(data)
    record = instances.record(100, "POLYLINE")
    assert record is not None
    assert record.values[0] == "it's é /* no; */ é"
    (curve,) = step_reader.read_exactly(data, bodies=False).curves
    assert ends(curve)[1] == pytest.approx([4, 2, 3])
    assert math.isclose(curve.range[1], 1.0)
