"""USD's binary form: what it holds is what its text does; what is damaged is refused."""

from __future__ import annotations

import random
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.damaged_files import as_format_errors
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.usd.composition import everything as all_prims
from bozzetto.exchange.usd.crate import parsed_crate
from bozzetto.exchange.usd.crate_bytes import integers, lz4_block, unpacked
from bozzetto.exchange.usd.reader import read_shapes
from bozzetto.exchange.usd.usda_text import parsed
from tests.core.exchange.test_usd import everything
from tests.usd_reader import python_of_usd

SCENES = Path(__file__).parents[2] / "data" / "scenes"
"""A scene that USD's own library wrote, as text and in the binary form."""


def same_parts(one, other):
    one, other = list(one.meshes()), list(other.meshes())
    assert len(one) == len(other) > 0
    for mine, its in zip(one, other, strict=True):
        assert type(mine) is type(its)
        assert (mine.name, mine.path, mine.color, mine.groups) == (
            its.name, its.path, its.color, its.groups,
        )  # fmt: skip
        np.testing.assert_array_equal(mine.mesh.faces, its.mesh.faces)
        np.testing.assert_allclose(mine.mesh.vertices, its.mesh.vertices, atol=1e-5)
        assert (mine.mesh.colors is None) == (its.mesh.colors is None)
        if mine.mesh.colors is not None:
            np.testing.assert_array_equal(mine.mesh.colors, its.mesh.colors)
        assert (mine.texture is None) == (its.texture is None)
        if mine.texture is not None:
            np.testing.assert_array_equal(mine.texture.pixels, its.texture.pixels)
        assert (mine.skin is None) == (its.skin is None)
        if mine.skin is not None:
            assert mine.skin.rig.names == its.skin.rig.names
            np.testing.assert_array_equal(mine.skin.rig.parents, its.skin.rig.parents)
            np.testing.assert_allclose(mine.skin.rig.joints, its.skin.rig.joints, atol=1e-6)
            np.testing.assert_allclose(mine.skin.weights, its.skin.weights, atol=1e-6)
            for clip, played in zip(mine.skin.clips, its.skin.clips, strict=True):
                np.testing.assert_allclose(clip.seconds, played.seconds)
                np.testing.assert_allclose(clip.turns, played.turns, atol=1e-6)


def flat(value):
    """All words and all numbers of a value, in their order."""
    if isinstance(value, str):
        return [str(value)], []
    if isinstance(value, (list, tuple)):
        both = [flat(one) for one in value]
        return [w for one, _ in both for w in one], [n for _, one in both for n in one]
    return [], np.ravel(value).tolist()


def test_the_binary_form_says_what_the_text_says():
    text = parsed((SCENES / "worm.usda").read_bytes())
    crate = parsed_crate((SCENES / "worm.usdc").read_bytes())
    mine, its = list(all_prims(text)), list(all_prims(crate))
    assert [(one.kind, one.type, one.path) for one in mine] == [
        (one.kind, one.type, one.path) for one in its
    ]
    for one, other in zip(mine, its, strict=True):
        assert one.values.keys() == other.values.keys()
        assert set(one.variants) == set(other.variants)
        for name, value in one.values.items():
            words, numbers = flat(value)
            assert flat(other.values[name])[0] == words
            np.testing.assert_allclose(flat(other.values[name])[1], numbers, rtol=1e-6)


@pytest.mark.parametrize("ending", ["usdc", "usd"])
def test_a_scene_in_the_binary_form_is_read(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    path.write_bytes((SCENES / "worm.usdc").read_bytes())
    found, text = read_mesh_file(path), read_mesh_file(SCENES / "worm.usda")
    same_parts(found.shapes, text.shapes)
    assert found.left_out == text.left_out
    names = [part.name for part in found.shapes.meshes()]
    assert names == ["skin", "A tent", "A tent", "ball", "cube"]
    worm = next(found.shapes.meshes())
    assert worm.skin.rig.names == ("Lower bone", "Upper bone")
    assert len(worm.skin.clips) == 1


CONVERT = """
import sys
from pxr import Sdf
assert Sdf.Layer.FindOrOpen(sys.argv[1]).Export(sys.argv[2])
"""


@pytest.mark.interop
@pytest.mark.parametrize("version", ["0.7.0", "0.8.0", "0.10.0"])
def test_our_own_scene_comes_back_from_the_binary_form(tmp_path, version):
    export(everything(), tmp_path / "a.usda")
    subprocess.run(
        [python_of_usd(), "-c", CONVERT, str(tmp_path / "a.usda"), str(tmp_path / "a.usdc")],
        check=True,
        timeout=120,
        env={"USD_WRITE_NEW_USDC_FILES_AS_VERSION": version},
    )
    data = (tmp_path / "a.usdc").read_bytes()
    assert data.startswith(b"PXR-USDC")
    found, text = (read_mesh_file(tmp_path / f"a.{ending}") for ending in ("usdc", "usda"))
    same_parts(found.shapes, text.shapes)
    assert found.left_out == text.left_out == ()


def test_another_version_is_refused_with_what_to_do(tmp_path):
    for version in (b"\x00\x03\x00", b"\x01\x00\x00"):
        (tmp_path / "a.usdc").write_bytes(b"PXR-USDC" + version + bytes(100))
        with pytest.raises(FormatError, match=r"Save it as \.usda"):
            read_mesh_file(tmp_path / "a.usdc")


def test_cut_short_anywhere_it_is_refused_or_read():
    data = (SCENES / "worm.usdc").read_bytes()
    told = 0
    for end in range(8, len(data), 97):
        with as_format_errors():
            try:
                read_shapes(data[:end])
            except UserError:
                told += 1
    assert told > 50


@pytest.mark.parametrize("seed", range(4))
def test_changed_anywhere_it_is_refused_or_read(seed):
    data, rng = (SCENES / "worm.usdc").read_bytes(), random.Random(seed)
    read = told = 0
    for _ in range(400):
        broken = bytearray(data)
        for _ in range(rng.choice((1, 2, 8))):
            at = rng.randrange(8, len(broken) - 8)
            broken[at : at + rng.choice((1, 8))] = rng.randbytes(rng.choice((1, 8)))
        try:
            with as_format_errors():
                read_shapes(bytes(broken))
            read += 1
        except UserError:
            told += 1
    assert read
    assert told


def packed_block(data, rng):
    """LZ4, packed greedily by words of four; lengths of 15 and more take more bytes."""

    def size(number):
        if number < 15:
            return b""
        full, rest = divmod(number - 15, 255)
        return b"\xff" * full + bytes([rest])

    out, kept, at, seen = b"", b"", 0, {}
    while at < len(data):
        word = data[at : at + 4]
        before = seen.get(word)
        seen[word] = at
        if len(word) == 4 and before is not None and at + 9 < len(data) and rng.random() < 0.9:
            length = 4
            while at + length < len(data) - 5 and data[before + length] == data[at + length]:
                length += 1
            token = min(len(kept), 15) << 4 | min(length - 4, 15)
            back = (at - before).to_bytes(2, "little")
            out += bytes([token]) + size(len(kept)) + kept + back + size(length - 4)
            kept, at = b"", at + length
        else:
            kept, at = kept + data[at : at + 1], at + 1
    return out + bytes([min(len(kept), 15) << 4]) + size(len(kept)) + kept


@given(st.binary(max_size=60), st.integers(1, 400), st.randoms(use_true_random=False))
def test_what_is_packed_comes_back(words, times, rng):
    data = words * times + b"end"
    block = packed_block(data, rng)
    assert lz4_block(block, len(data)) == data
    assert unpacked(b"\0" + block, len(data)) == data
    with pytest.raises(FormatError):
        lz4_block(block, len(data) - 1)


@pytest.mark.parametrize("width", [4, 8])
@given(
    values=st.lists(st.integers(-(2**31), 2**31 - 1) | st.integers(-200, 200), min_size=1),
    common=st.integers(-300, 300),
)
def test_integers_come_back(width, values, common):
    steps = np.diff(np.array([0, *values], np.int64))
    if width == 4:
        steps = steps.astype(np.int32).astype(np.int64)
    sizes = (1, 2, 4) if width == 4 else (2, 4, 8)
    codes, body = [], b""
    for step in steps.tolist():
        if step == common:
            codes.append(0)
            continue
        code = next(
            k for k, size in enumerate(sizes, 1) if -(1 << 8 * size - 1) <= step < 1 << 8 * size - 1
        )
        codes.append(code)
        body += step.to_bytes(sizes[code - 1], "little", signed=True)
    head = bytearray((2 * len(codes) + 7) // 8)
    for number, code in enumerate(codes):
        head[number // 4] |= code << 2 * (number % 4)
    data = common.to_bytes(width, "little", signed=True) + bytes(head) + body
    assert integers(data, len(values), width).tolist() == values
