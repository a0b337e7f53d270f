"""Ink JSON and InkML: exact there and back, and plain words for what is wrong."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.export import write_drawing
from bozzetto.exchange.import_file import read_drawing
from bozzetto.exchange.ink import ink_json, inkml
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.view import Camera

DRAWN = sorted((Path(__file__).parents[4] / "shared/data/silhouettes/ink").glob("*.json"))

small = st.floats(-1e6, 1e6, width=32)


@st.composite
def strokes(draw, camera):
    count = draw(st.integers(1, 12))
    column = lambda values: st.lists(values, min_size=count, max_size=count)  # noqa: E731
    maybe = lambda values: st.none() | column(values)  # noqa: E731
    own = draw(st.sampled_from([camera, Camera(fov_y=20.0, viewport=(300, 100))]))
    angle = st.floats(-90, 90, width=32)
    return Stroke(
        draw(column(small)),
        draw(column(small)),
        own,
        pressure=draw(maybe(st.floats(0, 1, width=32))),
        t=draw(maybe(st.floats(0, 100, width=32))),
        tilt_x=draw(maybe(angle)),
        twist=draw(maybe(st.floats(0, 359, width=32))),
        tool=draw(st.sampled_from(["pen", "eraser", "mouse", "imported"])),
        color=draw(st.none() | st.tuples(*[st.integers(0, 255)] * 3)),
        group=draw(st.text(st.characters(codec="utf-8", exclude_categories=["C"]), max_size=8)),
    )


CAMERA = Camera(kind="orthographic", height=135.6, eye=(1, -5, 3), target=(1, 0, 3))
json_values = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(-1e9, 1e9)
    | st.text(st.characters(codec="utf-8", exclude_categories=["C"]), max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.just("key"), inner),
    max_leaves=5,
)  # fmt: skip


@pytest.mark.parametrize("format", [ink_json, inkml], ids=["json", "inkml"])
@given(
    items=st.lists(strokes(CAMERA), min_size=1, max_size=4),
    extra=st.dictionaries(st.sampled_from(["box", "plane", "marks"]), json_values, max_size=2),
)
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_there_and_back_is_the_same_drawing(format, items, extra):
    drawing = Drawing(Strokes(items), CAMERA, "a", extra)
    assert format.read_drawing(format.write_drawing(drawing), "a") == drawing


@pytest.mark.skipif(not DRAWN, reason="the drawn outlines are not here")
@pytest.mark.parametrize("ending", ["json", "inkml"])
def test_drawn_outlines_there_and_back(tmp_path, ending):
    for path in DRAWN:
        drawing = read_drawing(path)
        raw = json.loads(path.read_text())["strokes"]
        assert len(raw) == len(drawing.strokes)
        for given_, stroke in zip(raw, drawing.strokes, strict=True):
            np.testing.assert_array_equal(np.float32(given_["x"]), stroke.x)
            assert stroke.has_pressure == ("pressure" in given_)
        out = tmp_path / f"{path.stem}.{ending}"
        write_drawing(drawing, out)
        assert read_drawing(out) == drawing


# -- ink JSON ----------------------------------------------------------------------------------


def document(**changes):
    top = {
        "format": "bozzetto-ink/1",
        "canvas": {"width": 400, "height": 300},
        "camera": {"kind": "perspective", "eye": [0, -9, 0], "target": [0, 0, 0], "fov_y": 30},
        "strokes": [{"x": [1, 2], "y": [3, 4.5]}, {"x": [5], "y": [6], "curve": "roof"}],
        "box": {"size": [1, 2, 3]},
    } | changes
    return json.dumps({k: v for k, v in top.items() if v is not None}).encode()


def test_the_smallest_file_by_hand():
    drawing = ink_json.read_drawing(document(), "name")
    assert drawing.camera == Camera(eye=(0, -9, 0), fov_y=30, viewport=(400, 300))
    assert drawing.strokes[0].points.tolist() == [[1, 3], [2, 4.5]]
    assert not drawing.strokes[0].has_pressure
    assert not drawing.strokes[0].has_time
    assert drawing.strokes[1].group == "roof"
    assert drawing.facts == {"box": {"size": [1, 2, 3]}}
    assert drawing.name == "name"


@pytest.mark.parametrize("format_", ["other-things/3", "x", "bozzetto-car-template/1"])
def test_facts_may_have_a_format_of_their_own(format_):
    said = {"format": format_, "rules": {"a": 1}}
    drawing = ink_json.read_drawing(json.dumps(said).encode(), "facts")
    assert drawing.facts == said
    assert not len(drawing.strokes)


@pytest.mark.parametrize(
    "said",
    [
        {"format": "other-things/3"},
        {"format": "bozzetto-ink/9", "rules": {}},
        {"format": "other-things/3", "strokes": []},
        {"format": 3, "rules": {}},
    ],
)
def test_other_formats_with_ink_or_nothing_are_refused(said):
    with pytest.raises(FormatError):
        ink_json.read_drawing(json.dumps(said).encode(), "facts")


def test_a_curve_may_be_named_by_a_number():
    made = ink_json.read_drawing(document().replace(b'"roof"', b"7"), "name")
    assert made.strokes[1].group == "7"
    with pytest.raises(FormatError):
        ink_json.read_drawing(document().replace(b'"roof"', b"7.5"), "name")


def test_a_byte_order_mark_is_no_damage():
    assert ink_json.read_drawing(b"\xef\xbb\xbf" + document(), "name").strokes[1].group == "roof"


PLAIN_CAMERA = {"eye": [0, 0, 0], "target": [0, 1, 0]}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"format": "bozzetto-ink/2"}, "bozzetto-ink/1"),
        ({"format": None}, "format"),
        ({"camera": None}, "“camera” is missing"),
        ({"strokes": None}, "“strokes” is missing"),
        ({"strokes": [{"x": [1], "y": [1]}] * 2 + [{"x": [1, 2], "y": [1]}]},
         "stroke 3: x and y differ in length"),
        ({"strokes": [{"x": [1], "y": [1], "t": []}]}, "stroke 1: x and t differ"),
        ({"strokes": [{"x": [], "y": []}]}, "stroke 1:.*samples"),
        ({"strokes": [{"x": ["1"], "y": [1]}]}, r"stroke 1:.*x\[0\]"),
        ({"strokes": [{"x": [1]}]}, "stroke 1:.*y"),
        ({"strokes": [{"x": [1e30], "y": [1]}]}, "stroke 1"),
        ({"strokes": [{"x": [1], "y": [1], "tool": "brush"}]}, "stroke 1:.*tool"),
        ({"strokes": [{"x": [1], "y": [1], "color": [1, 2, 300]}]}, "stroke 1:.*color"),
        ({"camera": {"kind": "fisheye", **PLAIN_CAMERA}}, "camera:.*kind"),
        ({"camera": {"kind": "orthographic", **PLAIN_CAMERA}}, "camera:.*“height”"),
        ({"camera": {"kind": "perspective", **PLAIN_CAMERA}}, "camera:.*“fov_y”"),
        ({"camera": {"kind": "perspective", "fov_y": 500, **PLAIN_CAMERA}}, "camera:.*angle"),
        ({"canvas": {"width": 0, "height": 5}}, "camera:.*canvas"),
        ({"canvas": {"width": 5}}, "canvas:.*height"),
        ({"camera": {"kind": "perspective", "fov_y": 9, "eye": [1e300, 0, 0], "target": [0, 0, 0]}},
         "camera:.*eye"),
    ],
)  # fmt: skip
def test_ink_json_names_the_place(changes, said):
    with pytest.raises(FormatError, match=said):
        ink_json.read_drawing(document(**changes), "a")


@pytest.mark.parametrize(
    "data",
    [b"", b"[]", b"{", b"\xff\xfe", b'{"format": NaN}', b"[" * 100_000, b'{"a":' * 50_000,
     b'{"format":"bozzetto-ink/1","canvas":{"width":1,"height":1},"camera":{"kind":"perspective",'
     b'"eye":[0,0,0],"target":[0,1,0],"fov_y":9},"strokes":[],"deep":' + b"[" * 90_000],
)  # fmt: skip
def test_ink_json_that_is_none(data):
    with pytest.raises(FormatError):
        ink_json.read_drawing(data, "a")


def test_an_empty_drawing_is_not_written(tmp_path):
    with pytest.raises(UserError, match="empty"):
        write_drawing(Drawing(Strokes(), CAMERA), tmp_path / "a.json")
    with pytest.raises(UserError, match=r"\.json.*\.inkml"):
        write_drawing(Drawing(Strokes(), CAMERA), tmp_path / "a.stl")


# -- InkML ---------------------------------------------------------------------------------------


def ink(body, definitions=""):
    text = (
        '<ink xmlns="http://www.w3.org/2003/InkML">'
        f"<definitions>{definitions}</definitions>{body}</ink>"
    )
    return inkml.read_drawing(text.encode(), "a")


def front(stroke):
    places = stroke.camera.on_plane(stroke.points, (0, 0, 0), (0, 1, 0))
    return places[:, [0, 2]] * (1, -1)


def test_the_first_example_of_the_recommendation():
    drawing = ink("<trace>10 0, 9 14, 8 28, 7 42</trace><trace>130 155, 144 159</trace>")
    np.testing.assert_allclose(front(drawing.strokes[0])[:2], [[10, 0], [9, 14]], atol=1e-4)
    assert [len(s) for s in drawing.strokes] == [4, 2]
    assert drawing.strokes[0].tool == "imported"


def test_differences_as_in_the_recommendation():
    # Section 3.2.1: "1125 18432,'23'43,"7"-8,3-5" means
    # (1125, 18432), (1148, 18475), (1178, 18510), (1211, 18540).
    drawing = ink("""<trace>1125 18432,'23'43,"7"-8,3-5</trace>""")
    np.testing.assert_allclose(
        front(drawing.strokes[0]),
        [[1125, 18432], [1148, 18475], [1178, 18510], [1211, 18540]],
        atol=1e-3,
    )


def test_absolute_after_differences_and_repeats():
    drawing = ink("<trace>5 5,'1'2,!20!30,* 31</trace>")
    np.testing.assert_allclose(
        front(drawing.strokes[0]), [[5, 5], [6, 7], [20, 30], [20, 31]], atol=1e-4
    )


def test_hexadecimal_values_and_the_pen_in_the_air():
    # Section 3.2.1: a value may be a hexadecimal number; section 3.2.1, "type": penUp.
    drawing = ink("<trace>#A -#1F, #0 3</trace><trace type='penUp'>1 2, 3 4</trace>")
    assert len(drawing.strokes) == 1
    np.testing.assert_allclose(front(drawing.strokes[0]), [[10, -31], [0, 3]], atol=1e-4)
    with pytest.raises(FormatError, match="trace 1"):
        ink(f"<trace>#{'F' * 400} 1</trace>")


FORMAT = (
    '<context xml:id="c1"><inkSource><traceFormat><channel name="Y" type="integer" units="cm"/>'
    '<channel name="X" type="integer" units="cm"/><channel name="F" type="integer" max="1000"/>'
    '<channel name="S" type="boolean"/><channel name="T" type="integer" units="ms"/>'
    '<intermittentChannels><channel name="OTx" units="rad"/></intermittentChannels>'
    "</traceFormat></inkSource></context>"
    '<context xml:id="c2"><traceFormat><channel name="X"/><channel name="Y"/></traceFormat>'
    "</context>"
)


def test_channels_in_any_order_with_units():
    drawing = ink(
        '<traceGroup contextRef="#c1"><trace>1 2 500 T 7000, 3 4 1000 F 7008 0.5</trace>'
        '</traceGroup><trace contextRef="#c2">1 2</trace>',
        FORMAT,
    )
    stroke = drawing.strokes[0]
    np.testing.assert_allclose(front(stroke), [[20, 10], [40, 30]], atol=1e-4)
    np.testing.assert_allclose(stroke.pressure, [0.5, 1])
    np.testing.assert_allclose(stroke.t, [0, 0.008], atol=1e-6)
    np.testing.assert_allclose(stroke.tilt_x, [0, np.degrees(0.5)], rtol=1e-6)
    np.testing.assert_allclose(front(drawing.strokes[1]), [[1, 2]], atol=1e-4)
    assert not drawing.strokes[1].has_pressure


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("", "no ink"),
        ("<trace></trace>", "trace 1: it holds no sample"),
        ("<trace>1 2</trace><trace>1 2 3</trace>", "trace 2: sample 1"),
        ("<trace>1 x</trace>", "trace 1: sample 1"),
        ("<trace>1 1e80</trace>", "larger"),
        ('<annotation type="bozzetto-camera">{</annotation><trace>1 2</trace>', "annotation"),
        ('<trace xmlns:b="urn:bozzetto:ink" b:tool="axe">1 2</trace>', "axe"),
        ('<trace xmlns:b="urn:bozzetto:ink" b:color="[1]">1 2</trace>', "annotation"),
    ],
)
def test_inkml_that_cannot_be_read(body, said):
    with pytest.raises(FormatError, match=said):
        ink(body)


def test_our_inkml_is_plain_inkml_to_others():
    drawing = Drawing(
        Strokes([Stroke([1, 2], [3, 4], CAMERA, pressure=[0, 1]), Stroke([5], [6], CAMERA)]), CAMERA
    )
    root = ElementTree.fromstring(inkml.write_drawing(drawing))
    space = "{http://www.w3.org/2003/InkML}"
    contexts = root.findall(f"{space}definitions/{space}context")
    names = {
        c.get("{http://www.w3.org/XML/1998/namespace}id"): [
            e.get("name") for e in c.iter(f"{space}channel")
        ]
        for c in contexts
    }
    traces = root.findall(f"{space}trace")
    assert [names[t.get("contextRef")[1:]] for t in traces] == [["X", "Y", "F"], ["X", "Y"]]
    assert traces[0].text == "1.0 3.0 0.0, 2.0 4.0 1.0"


@pytest.mark.parametrize(("units", "told"), [("", True), ("dev", True), ("himetric", False)])
def test_inkml_without_a_unit_says_how_large_it_is_read(units, told):
    """Handwriting sets hold counts of a tablet: a formula is 1.3 mm wide, or five metres."""
    from bozzetto.exchange.ink.inkml import read_drawing as read_inkml

    said = f' units="{units}"' if units else ""
    drawing = read_inkml(
        '<ink xmlns="http://www.w3.org/2003/InkML"><traceFormat>'
        f'<channel name="X"{said}/><channel name="Y"{said}/></traceFormat>'
        "<trace>0 0, 4000 100, 4755 1297</trace></ink>".encode(),
        "a",
    )
    assert [line.split(":")[0] for line in drawing.left_out] == (
        ["Read as millimetres, 4,755 × 1,297"] if told else []
    )


STEPS = (
    '<ink xmlns="http://www.w3.org/2003/InkML"><definitions><context xml:id="c">'
    '<inkSource xml:id="s">'
    '<traceFormat><channel name="X" type="{type}"{units}/><channel name="Y" type="{type}"{units}/>'
    '<channel name="OTx" type="integer" units="deg"/></traceFormat><channelProperties>'
    '<channelProperty channel="X" name="resolution" value="1000" units="1/cm"/>'
    '<channelProperty channel="Y" name="resolution" value="1000" units="1/cm"/>'
    '<channelProperty channel="OTx" name="resolution" value="100" units="1/deg"/>'
    "</channelProperties></inkSource></context></definitions>"
    '<trace contextRef="#c">0 0 1902, 4000 300 -500</trace></ink>'
)


@pytest.mark.parametrize(
    ("kind", "units", "mm"),
    [
        ("integer", ' units="cm"', 0.01),  # Word and Journal
        ("integer", "", 0.01),  # OneNote
        ("decimal", "", 0.01),
        ("decimal", ' units="cm"', 10.0),
        ("decimal", ' units="mm"', 1.0),
    ],
)
def test_steps_of_a_device_are_as_large_as_its_resolution_says(kind, units, mm):
    from bozzetto.exchange.ink.inkml import read_drawing as read_inkml

    drawing = read_inkml(STEPS.format(type=kind, units=units).encode(), "a")
    assert not drawing.left_out
    size = np.ptp(front(drawing.strokes[0]), axis=0)
    np.testing.assert_allclose(size, [4000 * mm, 300 * mm], rtol=1e-4)
    np.testing.assert_allclose(drawing.strokes[0].tilt_x, [19.02, -5.0], atol=1e-4)


@pytest.mark.parametrize("value", ["0", "-5", "x", "", "1e99", "nan"])
def test_a_resolution_that_cannot_be_is_passed_over(value):
    from bozzetto.exchange.ink.inkml import read_drawing as read_inkml

    text = STEPS.format(type="integer", units="").replace('"1000"', f'"{value}"')
    drawing = read_inkml(text.encode(), "a")
    assert "does not say its unit" in drawing.left_out[0]
    np.testing.assert_allclose(np.ptp(front(drawing.strokes[0]), axis=0), [4000, 300], rtol=1e-4)
