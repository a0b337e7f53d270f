"""Thousands of damaged files: nothing but `UserError` may come out of a reader."""

from __future__ import annotations

import json
import random
import struct
import subprocess
import sys
import textwrap

import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.formats import FORMATS
from tests.reliability.mutated_files import mutated, read, seeds
from tests.sizes import sized

CASES = 3000
LONG_CASES = sized(10_000, 200_000)
"""For each format; the suite of strangers' files does many more of all."""

MEMORY = 3 << 30
"""Address space of the process that reads the hungry files, bytes."""


def attack(endings, count, seed):
    rng = random.Random(seed)
    sound = [one for one in seeds() if one[0] in endings]
    read_well = told = 0
    for case in range(count):
        ending, content = rng.choice(sound)
        broken = mutated(content, rng)
        try:
            read(ending, broken)
            read_well += 1
        except UserError as error:
            told += bool(error.message)
        except Exception as error:
            raise AssertionError(f"case {case} of {ending}: {broken!r}") from error
    assert 0 < read_well < count
    assert told == count - read_well


READ = [one for one in FORMATS if one.reads and one.id not in ("cad", "dxf-drawing", "dxf-mesh")]
"""Readers of ours; those of other libraries are tried where these are."""


@pytest.mark.filterwarnings("ignore::UserWarning:PIL", "ignore::PIL.Image.DecompressionBombWarning")
@pytest.mark.filterwarnings("ignore:::tifffile")
@pytest.mark.parametrize("one", READ, ids=[one.id for one in READ])
def test_only_user_errors_escape(one):
    attack(one.endings, CASES, seed=one.id)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning:PIL", "ignore::PIL.Image.DecompressionBombWarning")
@pytest.mark.filterwarnings("ignore:::tifffile")
@pytest.mark.parametrize("one", READ, ids=[one.id for one in READ])
def test_only_user_errors_escape_for_long(one):
    attack(one.endings, LONG_CASES, seed=f"{one.id} long")


def test_the_seeds_are_good():
    for ending, content in seeds():
        read(ending, content)
    assert {ending for one in READ for ending in one.endings} - {e for e, _ in seeds()} == {
        ".jpeg", ".tiff",
    }  # fmt: skip


def glb_of(document, blob):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x4E4942)
    )
    return b"glTF" + struct.pack("<II", 2, 20 + len(body) + len(blob)) + body + blob


def hungry_files():
    """Small files that ask for much."""
    accessor = {"bufferView": 0, "componentType": 5126, "count": 2**40, "type": "VEC3"}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 2**50}],
        "bufferViews": [{"buffer": 0, "byteLength": 2**50, "byteStride": 12}],
        "accessors": [accessor],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * 1000}],
    }
    yield ".glb", glb_of(document, bytes(4096))
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 19999999\n"
    yield ".ply", head + b"property double x\n" * 200 + b"end_header\n"
    yield ".ply", head + b"end_header\n"
    lists = b"element face 9999999\nproperty list uint double vertex_indices\nend_header\n"
    yield ".ply", b"ply\nformat binary_little_endian 1.0\n" + lists + b"\xff\xff\xff\x7f" * 99
    yield ".stl", b"x" * 80 + b"\xff\xff\xff\x7f" + bytes(5000)
    curve = b"C" + b"1e9 -1e9 -1e9 1e9 1 1 " * 40_000
    yield ".svg", b'<svg><path d="M0 0' + curve + b'"/></svg>'
    yield (
        ".svg",
        b"<svg>" + b"<g>" * 90 + b"<path d='M0 0L1 1'/>" * 5_000 + b"</g>" * 90 + b"</svg>",
    )
    yield ".inkml", b"<ink><trace>" + b"1 1," * 1_500_000 + b"</trace></ink>"
    yield ".json", b'{"format":"bozzetto-ink/1","canvas":{},"camera":{},"strokes":[' + b"0," * 10**6
    yield ".bmp", b"BM" + bytes(12) + struct.pack("<IiiHHIIiiII", 40, 2**30, 2**30, 1, 24, *[0] * 6)


@pytest.mark.skipif(sys.platform != "linux", reason="limits memory the Linux way")
def test_small_files_cannot_eat_the_memory(tmp_path):
    endings = []
    for number, (ending, data) in enumerate(hungry_files()):
        endings.append(ending)
        (tmp_path / f"{number}{ending}").write_bytes(data)
    code = """
        import resource, sys
        from pathlib import Path
        resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[2]),) * 2)
        from bozzetto.errors import UserError
        from bozzetto.exchange import import_file as importing
        for path in sorted(Path(sys.argv[1]).iterdir()):
            name = {".svg": "drawing", ".inkml": "drawing", ".json": "drawing", ".bmp": "image"}
            try:
                getattr(importing, "read_" + name.get(path.suffix, "mesh"))(path)
                print(path.name, "read")
            except UserError as error:
                print(path.name, error.message[:60])
    """
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", textwrap.dedent(code), str(tmp_path), str(MEMORY)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
    assert len(done.stdout.splitlines()) == len(endings)
