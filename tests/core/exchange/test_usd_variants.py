"""USD's choices (variants), and copies that are scattered at points."""

from __future__ import annotations

import re

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange.import_file import read_mesh_file
from tests.core.exchange.test_usd_composition import AT, boxes, write
from tests.usd_reader import asked_usd

CHAIR = """
def Xform "top" (
    variants = { string size = "small"  string "back" = "none" }
    prepend variantSets = ["size", "back"]
)
{
    variantSet "size" = {
        "small" { def Cube "seat" { double size = 2 } }
        "large" { def Cube "seat" { double size = 6 } def Cube "arm" { double size = 1 } }
    }
    variantSet "back" = {
        "none" { }
        "high" (payload = @back.usda@  prepend variantSets = "wood") {
            over "seat" { double size = 99 }
            variantSet "wood" = { "oak" { def Cube "oak" { double size = 3 } } }
        }
    }
}
"""
BACK = 'def Xform "top" { def Cube "board" { double size = 4 } }'
ROOM = """
def Xform "top"
{
    def "plain" (references = @chair.usda@) { }
    def "big" (references = @chair.usda@  variants = { string size = "large" }) { }
    def "carved" (
        references = @chair.usda@
        variants = { string size = "medium"  string back = "high"  string wood = "oak" }
    ) { }
    def "own" (references = @chair.usda@  variants = { string size = "large" }) {
        over "seat" { double size = 5 }
    }
    def "pair" (references = @pair.usda@) {
        over "second" (variants = { string size = "large" }) { }
    }
}
"""
PAIR = """
def Xform "top" {
    def "first" (references = @chair.usda@) { }
    def "second" (references = </top/first>) { }
}
"""

ASKED = """
answer = []
for prim in Usd.PrimRange(stage.GetPseudoRoot()):
    if prim.IsA(UsdGeom.Cube):
        answer.append([prim.GetName(), UsdGeom.Cube(prim).GetSizeAttr().Get()])
"""


def in_lines(body):
    """OpenUSD wants each statement on a line of its own."""
    return re.sub(r"(?<=[{}]) +| +(?=})|  +", "\n", body)


@pytest.fixture
def room(tmp_path):
    for name, body in (("chair", CHAIR), ("back", BACK), ("pair", PAIR), ("room", ROOM)):
        write(tmp_path / f"{name}.usda", in_lines(body))
    return tmp_path / "room.usda"


def sizes(path):
    return [(name, size) for name, _, size in boxes(path)[0]]


def test_what_is_chosen_is_read_and_the_strongest_chooses(room):
    assert sizes(room) == [
        ("seat", 2),  # as the chair itself says
        ("seat", 6), ("arm", 1),  # as whoever takes it says
        ("board", 4), ("oak", 3),  # of the payload and the set in a choice; its seat is none
        ("seat", 5), ("arm", 1),  # what is said of it where it stands is stronger
        ("seat", 2), ("seat", 6), ("arm", 1),
    ]  # fmt: skip


def test_what_is_not_chosen_is_told(tmp_path, room):
    assert any("not chosen of" in line for line in boxes(room)[1])
    write(tmp_path / "one.usda", 'def Xform "top" (variants = { string a = "b" } variantSets = "a")'
          ' { variantSet "a" = { "b" { def Cube "c" { double size = 1 } } } }')  # fmt: skip
    assert boxes(tmp_path / "one.usda") == ([("c", 0, 1)], ())


@pytest.mark.interop
def test_usds_own_library_chooses_the_same(room):
    assert sorted(sizes(room)) == sorted((name, size) for name, size in asked_usd(ASKED, room))


@pytest.mark.interop
def test_choices_in_the_binary_form_are_those_of_the_text(tmp_path, room):
    script = (
        "from pxr import Sdf\n"
        "answer = [Sdf.Layer.FindOrOpen(p).Export(p[:-1] + 'c') for p in sys.argv[1:]]"
    )
    texts = sorted(tmp_path.glob("*.usda"))
    before = sizes(room)
    assert all(asked_usd(script, *texts))
    for text in texts:
        text.write_bytes(text.with_suffix(".usdc").read_bytes())
    assert sizes(room) == before


def test_a_choice_that_takes_in_itself_ends(tmp_path):
    write(tmp_path / "a.usda", 'def Xform "top" (variants = { string s = "x" } variantSets = "s") {'
          ' variantSet "s" = { "x" (references = </top>) { def Cube "c" { double size = 1 }'
          ' def "d" (references = </top>) { } } } }')  # fmt: skip
    rows, told = boxes(tmp_path / "a.usda")
    assert rows == [("c", 0, 1)]
    assert any("depends on itself" in line for line in told)


def test_choices_in_choices_without_end_are_refused(tmp_path):
    deep = 'variantSet "s" = { "x" { ' * 3000
    write(tmp_path / "a.usda", f'def Xform "top" {{ {deep}')
    with pytest.raises(FormatError):
        read_mesh_file(tmp_path / "a.usda")


def test_a_reference_within_what_is_referred_to_stays_within_it(tmp_path):
    write(tmp_path / "part.usda", 'def Xform "top" { def Cube "a" { double size = 3 }\n'
          f'def "b" (references = </top/a>) {{ {AT.format(7)} }} }}')  # fmt: skip
    write(tmp_path / "scene.usda", 'def Xform "top" { def "x" (references = @part.usda@) { } }')
    assert boxes(tmp_path / "scene.usda") == ([("a", 0, 3), ("b", 7, 3)], ())


# -- copies --

SCATTER = """
def Xform "top" {{
    def PointInstancer "field" {{
        rel prototypes = [ </top/field/kinds/box>, </top/field/kinds/pair> ]
        {lists}
        {at}
        def Scope "kinds" {{
            def Cube "box" {{ double size = 2  {box} }}
            def Xform "pair" {{
                def Cube "left" {{ double size = 1  {left} }}
                def Cube "right" {{ double size = 1 }}
            }}
        }}
    }}
}}
"""
PLACES = "(10, 20, 30), (-5, 0, 2), (0, 0, 0), (1, 2, 3)"
LISTS = f"int[] protoIndices = [0, 1, 0, 1]\npoint3f[] positions = [{PLACES}]\n"


def scattered(path, lists=LISTS, box="", left="", at=""):
    write(path, in_lines(SCATTER.format(lists=lists, box=box, left=left, at=at)))
    found = read_mesh_file(path)
    return np.array([np.sort(p.mesh.bounds.ravel()) for p in found.shapes.meshes()]), found


def test_copies_stand_at_their_places(tmp_path):
    _, found = scattered(tmp_path / "a.usda", box=AT.format(100), at=AT.format(1000))
    rows = [(p.name, *p.mesh.bounds.mean(axis=0).round(6)) for p in found.shapes.meshes()]
    assert rows == [
        ("box", 1110, 20, 30), ("left", 995, 0, 2), ("right", 995, 0, 2),
        ("box", 1100, 0, 0), ("left", 1001, 2, 3), ("right", 1001, 2, 3),
    ]  # fmt: skip
    assert not found.left_out or "round" in found.left_out[0]


def test_copies_are_scaled_then_turned_then_moved(tmp_path):
    lists = (
        "int[] protoIndices = [0]\npoint3f[] positions = [(10, 0, 0)]\n"
        "float3[] scales = [(1, 2, 3)]\n"
        "quath[] orientations = [(0.7071067811865476, 0, 0, 0.7071067811865476)]\n"
    )
    _, found = scattered(tmp_path / "a.usda", lists, box=AT.format(5))
    (part,) = found.shapes.meshes()
    # Five along x is five along y once it is turned by a quarter about z.
    np.testing.assert_allclose(part.mesh.bounds, [[8, 4, -3], [12, 6, 3]], atol=1e-6)


@pytest.mark.parametrize(
    ("lists", "count"),
    [
        (LISTS + "int64[] invisibleIds = [1, 2]\n", 3),
        (LISTS + "int64[] ids = [7, 8, 9, 5]\nint64[] invisibleIds = [8, 5]\n", 2),
        (LISTS.replace("[0, 1, 0, 1]", "[0, 5, -1, 0]"), 2),
    ],
)
def test_copies_that_are_hidden_or_of_no_kind_are_not_there(tmp_path, lists, count):
    assert len(scattered(tmp_path / "a.usda", lists)[0]) == count


@pytest.mark.parametrize(
    "lists",
    [
        LISTS.replace("[0, 1, 0, 1]", "[0, 1, 0]"),
        LISTS + "float3[] scales = [(1, 1, 1)]\n",
        LISTS + "quath[] orientations = [(0, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0)]\n",
        LISTS.replace("(10, 20, 30)", "(1e30, nan, 0)"),
    ],
)
def test_lists_that_do_not_fit_are_refused(tmp_path, lists):
    with pytest.raises(FormatError):
        scattered(tmp_path / "a.usda", lists)


def test_copies_of_what_scatters_them_end(tmp_path):
    body = SCATTER.replace("</top/field/kinds/box>", "</top/field>").format(
        lists=LISTS, box="", left="", at=""
    )
    write(tmp_path / "a.usda", body)
    with pytest.raises(FormatError):
        read_mesh_file(tmp_path / "a.usda")


COPIES = """
from pxr import Usd
answer = []
time = Usd.TimeCode.EarliestTime()
for prim in stage.Traverse():
    if prim.IsA(UsdGeom.PointInstancer):
        one = UsdGeom.PointInstancer(prim)
        places = UsdGeom.XformCache(time).GetLocalToWorldTransform(prim)
        for row in one.ComputeInstanceTransformsAtTime(time, time):
            answer.append([list(r) for r in row * places])
"""


@pytest.mark.interop
def test_usds_own_library_has_copies_at_the_same_places(tmp_path):
    count, rng = 12, np.random.default_rng(3)
    turns = rng.normal(size=(count, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]

    def rows(table):
        return ", ".join(str(tuple(map(float, row))) for row in table)

    lists = (
        f"int[] protoIndices = {[0] * count}\n"
        f"point3f[] positions = [{rows(rng.normal(size=(count, 3)) * 20)}]\n"
        f"float3[] scales = [{rows(rng.uniform(0.3, 3, (count, 3)))}]\n"
        f"quatf[] orientationsf = [{rows(turns)}]\n"
    )
    path = tmp_path / "a.usda"
    _, found = scattered(path, lists, box=AT.format(3), at=AT.format(50))
    corners = np.array([[x, y, z, 1] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    for part, matrix in zip(found.shapes.meshes(), asked_usd(COPIES, path), strict=True):
        places = corners @ np.array(matrix)
        np.testing.assert_allclose(
            part.mesh.bounds, [places[:, :3].min(0), places[:, :3].max(0)], rtol=1e-5, atol=1e-5
        )
