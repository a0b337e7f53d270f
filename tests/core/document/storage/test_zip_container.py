"""The container against hostile files, and against other programs' idea of a zip."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bozzetto.document.storage.zip_container import (
    DTYPES,
    ContainerReader,
    ContainerWriter,
    Part,
    all_finite,
    decode_json,
    is_safe_name,
)
from bozzetto.errors import DocumentError


def packed(entries: dict[str, bytes], method: int = zipfile.ZIP_STORED) -> bytes:
    """The same by Python's zip writer."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return file.getvalue()


def written(entries: dict[str, bytes]) -> bytes:
    writer = ContainerWriter()
    for name, content in entries.items():
        writer.add(name, content)
    file = io.BytesIO()
    writer.write(file)
    return file.getvalue()


ENTRIES = {"a.txt": b"hello", "b/c.bin": bytes(range(256)) * 40, "empty": b"", "grün/ü": b"x"}


def test_python_reads_what_is_written():
    with zipfile.ZipFile(io.BytesIO(written(ENTRIES))) as archive:
        assert archive.testzip() is None
        assert {name: archive.read(name) for name in archive.namelist()} == ENTRIES
        assert {info.compress_type for info in archive.infolist()} == {zipfile.ZIP_STORED}


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_what_other_programs_pack_is_read(method):
    reader = ContainerReader(packed(ENTRIES | {"folder/": b""}, method))
    assert {name: reader.read(name) for name in reader.unread()} == ENTRIES
    assert reader.unread() == ()


def test_a_zip_made_without_seeking_is_read():
    class Stream(io.BytesIO):
        def seekable(self) -> bool:
            return False

        def tell(self) -> int:
            raise OSError

        seek = tell

    file = Stream()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.txt", b"hello" * 100)
    assert ContainerReader(file.getvalue()).read("a.txt") == b"hello" * 100


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(sorted(DTYPES)).flatmap(
        lambda name: arrays(
            DTYPES[name],
            st.lists(st.integers(0, 5), min_size=0, max_size=3).map(tuple),
            elements={"allow_nan": False, "allow_infinity": False} if name[0] == "f" else None,
        )
    ),
    st.binary(max_size=40),
)
def test_arrays_lie_in_the_file_as_numpy_would_put_them(array, before):
    writer = ContainerWriter()
    writer.add("before", before)
    name = writer.add_array("some/array", array)
    file = io.BytesIO()
    writer.write(file)
    with zipfile.ZipFile(io.BytesIO(file.getvalue())) as archive:
        by_hand = np.frombuffer(archive.read(name), array.dtype.newbyteorder("<"))
    assert by_hand.tobytes() == array.tobytes()
    reader = ContainerReader(file.getvalue())
    reader.declare(writer.parts)
    again = reader.array(name)
    assert again.dtype == array.dtype
    assert again.shape == array.shape
    assert again.tobytes() == array.tobytes()
    assert again.flags.aligned
    assert not again.flags.writeable


def test_arrays_in_a_deflated_or_unaligned_file_are_read_too():
    array = np.arange(50, dtype="<f8")
    for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        for pad in range(8):
            content = packed({"x" * (pad + 1): b"", "a.f8": array.tobytes()}, method)
            reader = ContainerReader(content)
            reader.declare([Part("a.f8", "f8", (50,), zlib.crc32(array.tobytes()))])
            again = reader.array("a.f8")
            assert again.flags.aligned
            assert (again == array).all()


# -- hostile files -----------------------------------------------------------------------------


def refused(content: bytes) -> str:
    """The message with which a file is refused, whatever it takes to find out."""

    def read_all() -> None:
        reader = ContainerReader(content)
        for name in reader.unread():
            reader.read(name)

    with pytest.raises(DocumentError) as found:
        read_all()
    return str(found.value)


def test_a_bomb_is_refused_before_it_is_unpacked():
    assert "unpacks" in refused(packed({"bomb": bytes(300 << 20)}, zipfile.ZIP_DEFLATED))


def test_many_small_bombs_are_refused_by_their_sum():
    bomb = zlib.compressobj(9, zlib.DEFLATED, -15)
    body = bomb.compress(bytes(800_000)) + bomb.flush()
    facts = entry(body, size=800_000, method=8)
    count = (2 << 30) // 800_000 + 1
    assert "unpacks" in refused(assembled([(b"n%04d" % n, facts) for n in range(count)]))


def entry(body, *, size=None, packed_size=None, method=0, crc=None, flags=0):
    """Facts of an entry, any of which may be a lie."""
    return (
        body,
        len(body) if size is None else size,
        len(body) if packed_size is None else packed_size,
        method,
        zlib.crc32(body) if crc is None else crc,
        flags,
    )


def assembled(entries, *, places=None, end=None):
    """A zip by hand: local headers, directory, end record."""
    blob, directory, offsets = b"", b"", []
    for name, rest in entries:
        body, size, packed_size, method, crc, flags = rest
        offsets.append(len(blob))
        head = struct.pack(
            "<4s5H3I2H", b"PK\3\4", 20, flags, method, 0, 33, crc, packed_size, size, len(name), 0
        )
        blob += head + name + body
    for number, (name, rest) in enumerate(entries):
        body, size, packed_size, method, crc, flags = rest
        place = offsets[number] if places is None else places[number]
        directory += struct.pack(
            "<4s6H3I5H2I",
            b"PK\1\2", 20, 20, flags, method, 0, 33, crc, packed_size, size, len(name),
            0, 0, 0, 0, 0, place,
        ) + name  # fmt: skip
    count = len(entries)
    facts = (0, 0, count, count, len(directory), len(blob), 0) if end is None else end
    return blob + directory + struct.pack("<4s4H2IH", b"PK\5\6", *facts)


def one(name: bytes = b"a", body: bytes = b"hello", **lies: int) -> bytes:
    return assembled([(name, entry(body, **lies))])


def test_the_hand_made_zip_is_sound_where_it_does_not_lie():
    assert ContainerReader(one()).read("a") == b"hello"
    with zipfile.ZipFile(io.BytesIO(one())) as archive:
        assert archive.testzip() is None


@pytest.mark.parametrize(
    "lies",
    [
        {"size": 6},
        {"size": 4},
        {"size": 2**32 - 1},
        {"packed_size": 2**32 - 1, "size": 2**32 - 1},
        {"packed_size": 4, "size": 4},
        {"crc": 1},
        {"method": 8},
        {"method": 12},
        {"flags": 1},
        {"flags": 64},
    ],
)
def test_lying_entries_are_refused(lies):
    refused(one(**lies))


@pytest.mark.parametrize("size", [99, 101, 4000])
def test_a_deflated_entry_that_is_longer_or_shorter_than_it_says_is_refused(size):
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    body = deflate.compress(b"x" * 100) + deflate.flush()
    assert ContainerReader(one(body=body, size=100, method=8, crc=zlib.crc32(b"x" * 100)))
    refused(one(body=body, size=size, method=8, crc=zlib.crc32(b"x" * 100)))


def test_overlapping_entries_are_refused():
    hello = entry(b"hello")
    refused(assembled([(b"a", hello), (b"b", hello)], places=[0, 0]))
    inner = one(b"b", b"inner")[: 30 + 1 + 5]
    nested = assembled([(b"a", entry(inner)), (b"b", entry(b"inner"))], places=[0, 31])
    with zipfile.ZipFile(io.BytesIO(nested)) as archive:
        assert archive.namelist() == ["a", "b"]
    assert "overlap" in refused(nested)


@pytest.mark.parametrize(
    "name",
    [
        b"../evil",
        b"a/../../b",
        b"/etc/passwd",
        b"C:\\x",
        b"c:x",
        b"a\\b",
        b"a\0b",
        b"a\nb",
        b"./a",
        b"a//b",
        b"",
        b"..",
        b"\xff\xfe",
        b"x" * 600,
    ],
)
def test_names_that_lead_elsewhere_are_refused(name):
    refused(one(name))
    if name.isascii():
        assert not is_safe_name(name.decode())


def test_duplicate_names_are_refused():
    twice = (b"a", entry(b"hello"))
    assert "forbidden name" in refused(assembled([twice, twice]))


@pytest.mark.parametrize(
    "end",
    [
        (0, 0, 2, 2, 47, 36, 0),
        (0, 0, 0, 0, 47, 36, 0),
        (1, 0, 1, 1, 47, 36, 0),
        (0, 0, 1, 2, 47, 36, 0),
        (0, 0, 1, 1, 46, 36, 0),
        (0, 0, 1, 1, 47, 35, 0),
        (0, 0, 1, 1, 47, 36, 9),
        (0, 0, 65535, 65535, 47, 36, 0),
    ],
)
def test_lying_ends_are_refused(end):
    assert ContainerReader(assembled([(b"a", entry(b"hello"))], end=(0, 0, 1, 1, 47, 36, 0)))
    refused(assembled([(b"a", entry(b"hello"))], end=end))


def test_every_truncation_and_every_flipped_bit_is_refused_or_harmless():
    content = written(ENTRIES)
    for cut in range(len(content)):
        refused(content[:cut])
    small = written({"a": b"hello", "b": b"world"})
    for place in range(len(small)):
        for bit in range(8):
            changed = bytearray(small)
            changed[place] ^= 1 << bit
            try:
                reader = ContainerReader(bytes(changed))
                contents = {name: reader.read(name) for name in reader.unread()}
            except DocumentError:
                continue
            assert set(contents.values()) == {b"hello", b"world"}  # a date, a version, a name


@pytest.mark.parametrize(
    ("dtype", "shape", "crc"),
    [
        ("f4", (3,), None),
        ("f4", (2, 2), None),
        ("f4", (-2, -1), None),
        ("f4", (10**12,), None),
        ("f4", (10**12, 0), None),
        ("f4", (2**63, 2**63), None),
        ("f4", (1, 1, 1, 1, 2), None),
        ("O", (2,), None),
        ("f16", (2,), None),
        ("f4", (2,), 7),
    ],
)
def test_absurd_arrays_are_refused(dtype, shape, crc):
    content = np.array([1.0, 2.0], "<f4").tobytes()
    reader = ContainerReader(packed({"x": content}))
    reader.declare([Part("x", dtype, shape, zlib.crc32(content) if crc is None else crc)])
    with pytest.raises(DocumentError):
        reader.array("x")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_arrays_that_are_not_finite_are_refused(value, dtype):
    array = np.ones(1000, dtype)
    array[777] = value
    assert not all_finite(array)
    reader = ContainerReader(packed({"x": array.tobytes()}))
    reader.declare([Part("x", dtype, (1000,), zlib.crc32(array.tobytes()))])
    with pytest.raises(DocumentError):
        reader.array("x")


def test_finite_arrays_whose_sum_overflows_are_finite():
    assert all_finite(np.full(1000, 3e38, np.float32))
    assert not all_finite(np.array([np.inf, -np.inf, 1.0]))


def test_parts_listed_twice_or_missing_are_refused():
    reader = ContainerReader(packed({"x": b""}))
    with pytest.raises(DocumentError):
        reader.declare([Part("x", "u1", (0,), 0), Part("x", "u1", (0,), 0)])
    with pytest.raises(DocumentError):
        reader.array("y")
    reader.declare([Part("y", "u1", (0,), 0)])
    with pytest.raises(DocumentError):
        reader.array("y")


@pytest.mark.parametrize("text", [b"[" * 10**6, b"\xff", b"", b"1e999", b'{"a":1', b"9" * 5000])
def test_json_fails_in_one_way(text):
    with pytest.raises(DocumentError):
        decode_json(text, list)


def test_the_writer_refuses_what_the_reader_would():
    writer = ContainerWriter()
    writer.add("a", b"")
    for name in ("a", "../b", "b\\c", ""):
        with pytest.raises(ValueError, match="entry"):
            writer.add(name, b"")
    with pytest.raises(ValueError, match="complex"):
        writer.add_array("z", np.zeros(2, complex))
