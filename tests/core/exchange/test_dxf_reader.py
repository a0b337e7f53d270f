"""Drawings from CAD: lines of DXF files as ink, against files that ezdxf writes."""

from __future__ import annotations

import io
import random
import re

import numpy as np
import pytest

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.cad import dxf_document
from bozzetto.exchange.cad.dxf_reader import read_drawing
from bozzetto.exchange.import_file import read_drawing as read_file

pytest.importorskip("ezdxf", reason="the extra “dxf” is not installed")


def drawn(draw, units=4):
    """The bytes of a drawing that a function makes in a model space."""
    import ezdxf

    document = ezdxf.new("R2010", units=units)
    draw(document.modelspace())
    text = io.StringIO()
    document.write(text)
    return document.encode(text.getvalue())


def lines_of(drawing):
    """The strokes in millimetres, y up."""
    from bozzetto.exchange.page_layout import Sheet

    sheet = Sheet.of_front_view(drawing.camera)
    return [
        sheet.to_units(np.column_stack([one.x, one.y]).astype(float), one.camera) * (1.0, -1.0)
        for one in drawing.strokes
    ]


def square(space, side=40.0, **more):
    corners = [(0, 0), (side, 0), (side, side), (0, side)]
    for k in (2, 0, 3, 1):  # in no order, one backwards
        a, b = corners[k], corners[(k + 1) % 4]
        space.add_line(*((b, a) if k == 3 else (a, b)), dxfattribs=more)


def test_lines_that_close_become_one_stroke():
    (line,) = lines_of(read_drawing(drawn(square), "a"))
    assert line[0] == pytest.approx(line[-1])
    assert np.ptp(line, axis=0) == pytest.approx([40.0, 40.0], abs=1e-3)
    a, b = line[:-1], line[1:]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
    assert abs(area) == pytest.approx(1600.0, rel=1e-4)


def test_where_three_lines_meet_each_is_an_edge():
    def house(space):
        square(space)
        space.add_line((0, 0), (40, 40))

    assert len(lines_of(read_drawing(drawn(house), "a"))) == 5


def test_a_chain_that_does_not_close_stays_in_pieces():
    def zigzag(space):
        for k in range(3):
            space.add_line((10 * k, 10 * (k % 2)), (10 * k + 10, 10 * ((k + 1) % 2)))

    assert len(lines_of(read_drawing(drawn(zigzag), "a"))) == 3


@pytest.mark.parametrize(("units", "size"), [(1, 25.4), (4, 1.0), (5, 10.0), (6, 1000.0)])
def test_units_are_those_of_the_file(units, size):
    drawing = read_drawing(drawn(square, units), "a")
    assert np.ptp(lines_of(drawing)[0], axis=0) == pytest.approx([40 * size] * 2, rel=1e-4)
    assert drawing.left_out == ()


def test_a_file_without_a_unit_says_so():
    drawing = read_drawing(drawn(square, units=0), "a")
    assert "does not say its unit" in " ".join(drawing.left_out)


def test_curves_are_where_they_were():
    def curves(space):
        space.add_circle((100, 0), 20)
        space.add_arc((0, 100), 30, 20, 110)
        space.add_ellipse((200, 100), (30, 0), 0.5)
        space.add_lwpolyline([(0, 0, 0.0), (50, 0, 1.0), (50, 20, 0.0)], format="xyb")
        space.add_spline([(0, 200), (20, 220), (40, 190), (70, 210)])

    circle, arc, ellipse, bulge, spline = lines_of(read_drawing(drawn(curves), "a"))
    assert np.hypot(*(circle - (100, 0)).T) == pytest.approx(20.0, abs=0.1)
    assert circle[0] == pytest.approx(circle[-1], abs=1e-3)
    assert np.hypot(*(arc - (0, 100)).T) == pytest.approx(30.0, abs=0.1)
    angles = np.degrees(np.arctan2(*(arc - (0, 100)).T[::-1]))
    assert (angles.min(), angles.max()) == pytest.approx((20.0, 110.0), abs=0.1)
    level = ((ellipse - (200, 100)) / (30, 15)) ** 2
    assert level.sum(axis=1) == pytest.approx(1.0, abs=0.02)
    assert bulge[:, 0].max() == pytest.approx(60.0, abs=0.1)
    assert spline[[0, -1]] == pytest.approx(np.array([[0, 200], [70, 210]]), abs=1e-3)


def test_blocks_are_taken_apart_and_placed():
    def blocks(space):
        block = space.doc.blocks.new("b")
        block.add_line((0, 0), (10, 0))
        outer = space.doc.blocks.new("c")
        outer.add_blockref("b", (0, 5))
        space.add_blockref("c", (100, 0), dxfattribs={"xscale": 2, "rotation": 90})
        space.add_blockref("b", (0, 0), dxfattribs={"column_count": 3, "column_spacing": 20})

    lines = sorted(lines_of(read_drawing(drawn(blocks), "a")), key=lambda one: one[0, 0])
    assert len(lines) == 4
    assert np.abs(np.ptp(lines[-1], axis=0) - (0, 20)).max() < 1e-3
    assert [one[:, 0].min() for one in lines[:3]] == pytest.approx([0, 20, 40], abs=1e-3)


def test_colours_come_from_the_line_or_its_layer_and_hidden_layers_are_not_seen():
    def colored(space):
        space.doc.layers.add("red", color=1)
        space.doc.layers.add("off").off()
        space.add_line((0, 0), (10, 0), dxfattribs={"layer": "red"})
        space.add_line((0, 5), (10, 5)).rgb = (1, 2, 3)
        space.add_line((0, 9), (10, 9))
        space.add_line((0, 12), (10, 12), dxfattribs={"layer": "off"})

    strokes = read_drawing(drawn(colored), "a").strokes
    assert [one.color for one in strokes] == [(255, 0, 0), (1, 2, 3), None]


def test_what_is_no_line_is_told():
    def mixed(space):
        square(space)
        space.add_text("Front")
        space.add_text("Side")
        space.add_point((1, 2))
        space.add_line((0, 0, 0), (0, 0, 50))
        space.add_line((50, 0, 0), (60, 0, 50))

    drawing = read_drawing(drawn(mixed), "a")
    said = " ".join(drawing.left_out)
    assert "2 TEXT" in said
    assert "1 POINT" in said
    assert "seen from above" in said
    assert len(drawing.strokes) == 2


def test_a_drawing_of_text_alone_is_refused():
    with pytest.raises(FormatError, match=r"no lines.*TEXT"):
        read_drawing(drawn(lambda space: space.add_text("Front")), "a")


def test_ours_comes_back(tmp_path):
    from bozzetto.exchange.export import export
    from bozzetto.geometry import Curve, Shapes

    places = np.array([[0, 0, 0], [30, 0, 0], [30, 20, 0], [0, 20, 0]], float)
    curve = Curve(3, np.array([0, 0, 0, 0, 1, 1, 1, 1.0]), places)
    export(Shapes(curves=(curve,)), tmp_path / "a.dxf")
    for trusted in (True, False):
        (line,) = lines_of(read_file(tmp_path / "a.dxf", trusted=trusted))
        assert line[0] == pytest.approx([0, 0], abs=1e-3)
        assert line[-1] == pytest.approx([0, 20], abs=1e-3)


def test_a_file_of_endless_blocks_is_refused(monkeypatch):
    monkeypatch.setattr(dxf_document, "MAX_STROKES", 1000)

    def bomb(space):
        space.doc.blocks.new("b0").add_line((0, 0), (1, 0))
        for k in range(1, 12):
            block = space.doc.blocks.new(f"b{k}")
            for side in range(4):
                block.add_blockref(f"b{k - 1}", (side, k))
        space.add_blockref("b11", (0, 0))

    with pytest.raises(FormatError, match="more than"):
        read_drawing(drawn(bomb), "a")


def outcome(data):
    """Return what is said of a file; nothing where it is read."""
    try:
        read_drawing(data, "a")
    except UserError as said:
        return said.message
    return ""


def test_damaged_files_raise_nothing_but_sentences_and_log_nothing(caplog):
    def some(space):
        square(space)
        space.add_circle((0, 0), 5)
        space.add_spline([(0, 200), (20, 220), (40, 190), (70, 210)])

    good, rng, said = drawn(some), random.Random(8), []
    for _ in range(40):
        bad = bytearray(good)
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(bad))
            bad[at : at + rng.choice((1, 2, 30))] = rng.randbytes(rng.choice((0, 1, 2, 30)))
        said.append(outcome(bytes(bad)))
    assert "" in said
    assert caplog.records == []
    assert outcome(good[:2000])
    assert "text" in outcome(b"AutoCAD Binary DXF\r\n\x1a\0")
    assert "not a DXF" in outcome(b"hello")


def test_entities_of_other_programs_are_left_out_and_told():
    known, last = drawn(square).rsplit(b"  0\nLINE\n", 1)
    of_it, rest = last.split(b"  0\n", 1)
    unknown = b"  0\nVENDOR_THING\n  5\nFFF" + of_it[of_it.index(b"\n330\n") :]
    drawing = read_drawing(known + b"  0\nLINE\n" + of_it + unknown + b"  0\n" + rest, "a")
    assert len(drawing.strokes) == 1
    assert "VENDOR_THING" in " ".join(drawing.left_out)


def test_many_lines_on_one_another_stay_apart():
    def pile(space):
        for _ in range(3000):
            space.add_line((0, 0), (30, 40))

    assert len(read_drawing(drawn(pile), "a").strokes) == 3000


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_more_entities_than_the_budget_allows_are_counted_before_the_library_begins(
    monkeypatch, ending
):
    def begins(name, extra):
        raise AssertionError(f"{name} of {extra} was asked")

    monkeypatch.setattr(dxf_document, "library", begins)
    monkeypatch.setattr(dxf_document, "MAX_STROKES", 2000)
    head = ["0", "SECTION", "2", "ENTITIES"]
    # A layer called 0 and a height of zero are no entities.
    line = ["  0", "LINE", "  8", "0", " 10", "0", " 20", "0", " 30", "0", " 11", "1", " 21", "1"]
    count = dxf_document.MAX_STROKES
    for many, said in ((count - 2, AssertionError), (count + 2, FormatError)):
        with pytest.raises(said, match="lines" if said is FormatError else "ezdxf"):
            read_drawing(ending.join([*head, *line * many, "0", "ENDSEC", ""]).encode(), "a")


OLD = (
    "999\nDXF from OpenSCAD\n0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1006\n0\nENDSEC\n"
    "0\nSECTION\n2\nENTITIES\n{}0\nENDSEC\n0\nEOF\n"
)


def test_polylines_of_a_newer_release_in_an_older_file_are_read():
    """As OpenSCAD writes: no mark of a class, no handle."""
    corners = "".join(f"10\n{x}\n20\n{y}\n" for x, y in ((0, 0), (30, 0), (30, 20), (0, 20)))
    line = "0\nLINE\n8\n0\n10\n40\n20\n0\n11\n50\n21\n0\n"
    content = OLD.format(f"0\nLWPOLYLINE\n8\n0\n90\n4\n70\n1\n{corners}{line}").encode()
    one, other = lines_of(read_drawing(content, "a"))
    assert np.ptp(one, axis=0) == pytest.approx([30.0, 20.0], abs=1e-3)
    assert np.ptp(other, axis=0) == pytest.approx([10.0, 0.0], abs=1e-3)


def test_a_drawing_that_lies_on_a_sheet_alone_is_read():
    """As SolidWorks writes."""
    import ezdxf

    document = ezdxf.new("R2010", units=4)
    square(document.layout("Layout1"))
    text = io.StringIO()
    document.write(text)
    (line,) = lines_of(read_drawing(document.encode(text.getvalue()), "a"))
    assert np.ptp(line, axis=0) == pytest.approx([40.0, 40.0], abs=1e-3)


LAYOUTS = re.compile(r"( *3\nModel\n *350\n\w+\n)( *3\nLayout1\n *350\n\w+\n)")


def test_the_model_counts_and_not_its_sheets_whatever_their_order():
    """Layouts stand in the file in any order; views of the model are on them, and frames."""
    import ezdxf

    for alone in (False, True):
        document = ezdxf.new("R2010", units=4)
        sheet = document.layout("Layout1")
        sheet.add_viewport((50, 50), (80, 80), (0, 0), 80)
        sheet.add_line((0, 0), (297, 0))
        document.modelspace().add_text("a note")
        if not alone:
            square(document.modelspace())
        text = io.StringIO()
        document.write(text)
        content, swaps = LAYOUTS.subn(r"\2\1", text.getvalue())
        assert swaps == 1
        assert next(one.name for one in ezdxf.read(io.StringIO(content)).layouts) == "Layout1"
        for each in (text.getvalue(), content):
            (line,) = lines_of(read_drawing(document.encode(each), "a"))
            size = np.ptp(line, axis=0).tolist()
            assert size == pytest.approx([297.0, 0.0] if alone else [40.0, 40.0], abs=1e-3)


def test_an_entity_that_is_damaged_is_told():
    def bad(space):
        square(space)
        spline = space.add_open_spline([(0, 0), (9, 0), (9, 9), (0, 9)])
        spline.knots = [0.0, 0.0, 1.0]

    (said,) = read_drawing(drawn(bad), "a").left_out
    assert "1 damaged SPLINE" in said
