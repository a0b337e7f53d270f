"""Curves in STEP and IGES files, read back by parsers of our own and evaluated by SciPy."""

from __future__ import annotations

import re
import subprocess
import sys
import unicodedata

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange import formats
from bozzetto.exchange.cad import cad_curves as curve_pieces
from bozzetto.exchange.cad.cad_curves import bezier_pieces, checked_curves
from bozzetto.exchange.cad.iges import write_shapes as iges
from bozzetto.exchange.cad.step import write_shapes as step
from bozzetto.exchange.cad.step_text import real, string
from bozzetto.exchange.export import encode_shapes, export
from bozzetto.geometry import Curve, Mesh, Shapes, Solid
from tests.core.exchange.curve_kit import (
    BROKEN,
    CIRCLE,
    CORNER,
    CURVES,
    NAMES,
    WITHOUT_CORNER,
    Iges,
    Step,
    domain,
    points,
    ring,
    same_places,
    values,
)

LINE = [[0, 0, 0], [10, 0, 5]]
WRITERS = {"step": (step, Step), "iges": (iges, Iges)}


def back(kind, *curves):
    """Curves written and read again."""
    write, read = WRITERS[kind]
    return read(write(Shapes(curves=curves))).curves()


def random_curve(seed):
    """Any degree, any knots that a curve may have, weights or none."""
    rng = np.random.default_rng(seed)
    degree, count = int(rng.integers(1, 7)), int(rng.integers(8, 30))
    knots = np.sort(rng.choice(rng.random(count), count + degree + 1))
    knots[degree], knots[count] = min(knots[degree], 0.1), max(knots[count], 0.9)
    weights = rng.uniform(0.1, 10, count) if seed % 2 else None
    return Curve(degree, np.sort(knots), rng.normal(size=(count, 3)) * 100, weights)


# -- exactness -----------------------------------------------------------------------------


@pytest.mark.parametrize("kind", WRITERS)
def test_every_curve_comes_back_in_its_place(kind):
    curves = WITHOUT_CORNER if kind == "iges" else CURVES
    found = back(kind, *curves)
    assert [c.name for c in found] == [c.name for c in curves]
    assert [c.closed for c in found] == [c.closed for c in curves]
    for one, other in zip(curves, found, strict=True):
        assert other.degree == one.degree
        assert same_places(one, other) <= 1e-9, one.name


@pytest.mark.parametrize("kind", WRITERS)
def test_what_needs_no_change_comes_back_bit_for_bit(kind):
    clamped = [c for c in CURVES if c.name in ("roof", "circle", "corner", "polyline", "five")]
    clamped = [c for c in clamped if kind != "iges" or c is not CORNER]
    for one, other in zip(clamped, back(kind, *clamped), strict=True):
        np.testing.assert_array_equal(one.control_points, other.control_points)
        np.testing.assert_array_equal(one.knots, other.knots)
        if one.weights is not None:
            np.testing.assert_array_equal(one.weights, other.weights)


def test_a_corner_ends_a_curve_in_iges():
    """Readers cut there, and complain; control points stay bit for bit."""
    found = back("iges", CORNER)
    assert [c.name for c in found] == ["corner", "corner"]
    for one, own in zip(found, (CORNER.control_points[:4], CORNER.control_points[3:]), strict=True):
        np.testing.assert_array_equal(one.control_points, own)
        assert len(np.unique(one.knots)) == 2


@pytest.mark.parametrize("kind", WRITERS)
def test_numbers_of_every_size_keep_all_digits(kind):
    rng = np.random.default_rng(3)
    places = rng.normal(size=(500, 3)) * 10.0 ** rng.integers(-300, 9, (500, 3))
    places[:5] = [[1 / 3, -0.0, 5e-324], [1e9, -1e9, 1e8], [1e16 / 1e9, 0.1, 123456789.0],
                  [2**-0.5, 1e-5, 1e-4], [1.5e22 / 1e15, 7, -7]]  # fmt: skip
    (found,) = back(kind, Curve(1, np.r_[0, np.linspace(0, 1, 500), 1], places))
    np.testing.assert_array_equal(found.control_points, places)


@pytest.mark.parametrize("kind", WRITERS)
def test_a_broken_curve_is_one_for_every_stretch(kind):
    found = back(kind, BROKEN)
    assert [domain(c) for c in found] == [(0, 1), (1, 2), (2, 4)]
    for piece in found:
        a, b = domain(piece)
        u = np.linspace(a, b, 50)[1:-1]
        np.testing.assert_allclose(values(piece, u), values(BROKEN, u), atol=1e-9)
        assert piece.name == "broken"
        assert not piece.closed


def test_any_curve_keeps_its_places():
    for seed in range(200):
        curve = random_curve(seed)
        begin, end = domain(curve)
        pieces = checked_curves(Shapes(curves=(curve,)))
        assert (domain(pieces[0])[0], domain(pieces[-1])[1]) == (begin, end)
        for piece in pieces:
            u = np.linspace(*domain(piece), 40)[1:-1]
            np.testing.assert_allclose(values(piece, u), values(curve, u), atol=1e-9)
            _, times = np.unique(piece.knots, return_counts=True)
            assert times[0] == times[-1] == curve.degree + 1
            assert (times[1:-1] <= curve.degree).all()


def test_bezier_pieces_are_the_curve():
    from scipy.interpolate import BPoly

    for seed in range(60):
        for curve in checked_curves(Shapes(curves=(random_curve(seed),))):
            places = np.unique(curve.knots)
            u = np.linspace(places[0], places[-1], 100)
            lifted = BPoly(np.moveaxis(bezier_pieces(curve), 1, 0), places)(u)
            got = lifted[:, :3] / lifted[:, 3:]
            np.testing.assert_allclose(got, values(curve, u), atol=1e-9)


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("degree", [2, 3, 5])
def test_a_mirrored_ring_stays_exactly_mirrored(kind, degree):
    count = 11
    ring = points(count)
    for i in range(count):  # of a row of `degree` more, the last is the first one's image
        image = (degree - 1 - i) % count
        ring[image] = ring[i] * (1, -1 if image != i else 0, 1)
    knots = np.arange(count + 2 * degree + 1.0)
    curve = Curve(degree, knots, np.vstack((ring, ring[:degree])), closed=True)
    (found,) = back(kind, curve)
    mirrored = found.control_points[::-1] * (1, -1, 1)
    np.testing.assert_array_equal(found.control_points, mirrored)
    assert same_places(curve, found) <= 1e-9


def test_knots_that_differ_by_rounding_alone_are_one():
    third = [0.1 + 0.2, 0.3]
    curve = Curve(3, [0] * 4 + sorted(third) + [1] * 4, points(6))
    (made,) = checked_curves(Shapes(curves=(curve,)))
    assert len(np.unique(made.knots)) == 3
    assert same_places(curve, made) <= 1e-9


@pytest.mark.parametrize("knots", [[1e300] * 2 + [1.5e308] * 2, [-8e307] * 2 + [8e307] * 2,
                                   [0, 0, 1e-300, 1e-300]])  # fmt: skip
def test_parameters_of_odd_size_become_common_ones(knots):
    for kind in WRITERS:
        (found,) = back(kind, Curve(1, knots, LINE))
        np.testing.assert_array_equal(found.knots, [0, 0, 1, 1])
        np.testing.assert_array_equal(found.control_points, LINE)


def test_weights_of_odd_size_keep_the_curve():
    for size in (1e-200, 1e200):
        curve = Curve(2, CIRCLE.knots, CIRCLE.control_points, CIRCLE.weights * size)
        for kind in WRITERS:
            (found,) = back(kind, curve)
            np.testing.assert_allclose(
                np.hypot(*values(found, np.linspace(0, 4, 99))[:, ::2].T), 10
            )


# -- what else the files say -----------------------------------------------------------------


def test_step_says_millimetres_and_one_shape():
    file = Step(step(Shapes(curves=CURVES)))
    lengths = [r for r in file.instances.values() if "LENGTH_UNIT" in r]
    assert [r["SI_UNIT"] for r in lengths] == [[".MILLI.", ".METRE."]]
    ((_, (product, shape)),) = file.of("SHAPE_DEFINITION_REPRESENTATION")
    assert "PRODUCT_DEFINITION_SHAPE" in file.instances[product]
    (kind,) = file.instances[shape]
    assert kind == "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION"
    assert b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'))" in step(
        Shapes(curves=CURVES)
    )
    text = [v for record in file.instances.values() for v in record.values()]
    named = set(re.findall(r"#\d+", str(text)))
    assert named <= set(file.instances)


def test_iges_says_millimetres_and_its_reach():
    file = Iges(iges(Shapes(curves=CURVES)))
    assert file.settings[:2] == [",", ";"]
    assert file.settings[13:15] == ["2", "MM"]
    assert len(file.settings) == 25
    reach = float(file.settings[19].replace("D", "E"))
    assert reach >= max(np.abs(c.control_points).max() for c in CURVES if c.name != "floating")


def test_iges_tells_flat_curves_from_others():
    flags = {}
    for curve in (CIRCLE, CURVES[0], Curve(1, [0, 0, 1, 1], LINE, name="line")):
        file = Iges(iges(Shapes(curves=(curve,))))
        (entity,) = [e for e in file.entities.values() if e[0] == 126]
        normal = [float(v.replace("D", "E")) for v in entity[3][-6:-3]]
        flags[curve.name] = int(entity[3][2])
        if flags[curve.name]:
            spread = curve.control_points - curve.control_points[0]
            np.testing.assert_allclose(spread @ normal, 0, atol=1e-9)
            assert np.linalg.norm(normal) == pytest.approx(1)
    assert flags == {"circle": 1, "roof": 0, "line": 1}


def test_colours_are_kept():
    file = Step(step(Shapes(curves=CURVES)))
    ((_, (_, members)),) = file.of("GEOMETRIC_CURVE_SET")
    assert [file.color(m) for m in members] == [c.color for c in CURVES]
    found = Iges(iges(Shapes(curves=WITHOUT_CORNER))).curves()
    assert [c.color for c in found] == [c.color for c in WITHOUT_CORNER]


@pytest.mark.parametrize("name", NAMES)
def test_odd_names(name):
    curve = Curve(1, [0, 0, 1, 1], LINE, name=name)
    (found,) = back("step", curve)
    assert found.name == re.sub("[\x00-\x1f\x7f-\x9f\ud800-\udfff]", " ", name).strip()
    (found,) = back("iges", curve)
    assert found.name.isascii()
    for letter in filter(str.isascii, name):
        assert letter in found.name or not letter.isprintable()


def test_accents_come_off_in_iges():
    (found,) = back("iges", Curve(1, [0, 0, 1, 1], LINE, name="Ärmel é 漢"))
    assert found.name == "Armel e ?"
    assert unicodedata.is_normalized("NFC", found.name)


def test_strings_and_reals_by_the_letter():
    assert string("it's \\ ä😀") == "'it''s \\\\ \\X2\\00E4\\X0\\\\X4\\0001F600\\X0\\'"
    said = [real(v) for v in (0, -0.0, 1, -2.5, 1e-6, 1.5e22, 1e22, 100)]
    assert said == ["0.", "0.", "1.", "-2.5", "1.E-6", "1.5E22", "1.E22", "100."]


@pytest.mark.parametrize("write", [step, iges])
def test_equal_curves_give_equal_files(write):
    assert write(Shapes(curves=CURVES)) == write(Shapes(curves=CURVES))


# -- refused -------------------------------------------------------------------------------


def poisoned(attribute, value):
    """A curve with a number that its maker let through."""
    curve = Curve(2, [0, 0, 0, 1, 1, 1], points(3), [1, 2, 1], name="rail")
    array = np.array(getattr(curve, attribute))
    array.flat[2] = value
    object.__setattr__(curve, attribute, array)
    return curve


@pytest.mark.parametrize("ending", ["step", "stp", "iges", "igs", "svg"])
@pytest.mark.parametrize(
    ("curve", "said"),
    [
        (poisoned("control_points", np.nan), "“rail” holds a number that is not finite"),
        (poisoned("knots", np.nan), "not finite"),
        (poisoned("weights", np.inf), "not finite"),
        (poisoned("weights", 1e-200), "weights"),
        (Curve(1, [0, 0, 1, 1], [[0, 0, 0], [1e10, 0, 0]]), "further"),
        (Curve(1, [0, 0, 1, 1], [[3, 4, 5], [3, 4, 5]], name="dot"), "“dot” has no length"),
        (Curve(3, np.zeros(9), points(5)), "no length"),
        (Curve(30, [0] * 31 + [1] * 31, points(31)), "degree 30"),
    ],
)
def test_what_no_reader_could_use_is_refused(tmp_path, ending, curve, said):
    good = Curve(1, [0, 0, 1, 1], LINE)
    with pytest.raises(UserError, match=said):
        export(Shapes(curves=(good, curve)), tmp_path / f"a.{ending}")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("ending", ["step", "iges", "dxf", "3dm", "svg"])
def test_meshes_are_refused_with_words(ending):
    tetra = Mesh(
        [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    with pytest.raises(UserError, match=r"curves, and there are none\. Use one of \.stl"):
        encode_shapes(Shapes(solids=(Solid(tetra),)), f"a.{ending}")
    with pytest.raises(UserError, match="nothing to export"):
        encode_shapes(Shapes(), f"a.{ending}")


def test_more_points_than_can_be_written_are_refused_before_any_work(monkeypatch):
    monkeypatch.setattr(curve_pieces, "MAX_CONTROL_POINTS", 10)
    with pytest.raises(UserError, match="12 control points together"):
        step(Shapes(curves=(ring(3, 3), ring(3, 3))))
    assert step(Shapes(curves=(ring(3, 3),)))


@pytest.mark.parametrize(("ending", "name", "extra"), [("dxf", "ezdxf", "dxf"),
                                                       ("3dm", "rhino3dm", "rhino")])  # fmt: skip
def test_a_missing_library_says_what_to_install(monkeypatch, ending, name, extra):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(UserError, match=rf"{name}.*pip install 'bozzetto\[{extra}\]'"):
        encode_shapes(Shapes(curves=CURVES), f"a.{ending}")


def test_the_writers_import_nothing_heavy():
    code = (
        "import sys; import bozzetto.exchange.cad.step, bozzetto.exchange.cad.iges,"
        " bozzetto.exchange.cad.dxf, bozzetto.exchange.cad.rhino;"
        " heavy = {'scipy', 'ezdxf', 'rhino3dm'} & set(sys.modules);"
        " assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_endings_of_the_issue_are_known():
    known = {ending for one in formats.writers("curves") for ending in one.endings}
    assert {".step", ".stp", ".iges", ".igs", ".svg", ".dxf", ".3dm"} <= known
