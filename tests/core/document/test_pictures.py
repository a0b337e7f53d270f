"""Pictures within states: kept once, in documents and in the journal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from bozzetto.document.model import Document, Model
from bozzetto.document.recovery.journal_records import ChangeWriter, Replay
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.document.storage.bozz_reader import parse_document
from bozzetto.document.storage.state_codec import (
    check_encodable,
    decode_state,
    encode_state,
    state_digest,
)
from bozzetto.errors import DocumentError, FormatError
from bozzetto.scene import Picture
from tests.document_kit import FakeRegistry

MODELER = "test.sketches"


@dataclass(frozen=True)
class Sketch:
    picture: Picture | None
    marks: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Sketches:
    sketches: tuple[Sketch, ...] = ()


REGISTRY = FakeRegistry(**{MODELER: (Sketches, 1)})
NOISE = np.random.default_rng(2).integers(0, 256, (120, 90, 4), np.uint8)
PICTURE = Picture.of(NOISE, "Front 3/4")


def document(*sketches):
    return Document((Model("m1", "Car", MODELER, Sketches(sketches)),))


def test_a_document_keeps_the_picture_to_the_bit(tmp_path):
    path = tmp_path / "car.bozz"
    write_document(document(Sketch(PICTURE, ((1.0, 2.0),)), Sketch(None), Sketch(PICTURE)), path)
    back, report = read_document(path, REGISTRY)
    assert report.warnings == ()
    first, none, again = back.models[0].state.sketches
    assert none.picture is None
    assert first.picture.encoded.tobytes() == PICTURE.encoded.tobytes()
    assert (first.picture.name, first.picture.width, first.picture.height) == ("Front 3/4", 90, 120)
    np.testing.assert_array_equal(first.picture.pixels, NOISE)
    # One picture in two sketches is stored once, and packed already.
    assert path.stat().st_size < 1.3 * PICTURE.encoded.size
    assert again.picture.encoded is first.picture.encoded


def test_the_journal_takes_a_picture_once(tmp_path):
    empty = document()
    path = tmp_path / "car.bozz"
    write_document(empty, path)
    changes, replay = ChangeWriter(empty), Replay(parse_document(path.read_bytes()))
    with_picture = changes.record(document(Sketch(PICTURE)), (), 1.0)
    assert len(with_picture) > PICTURE.encoded.size
    replay.feed(with_picture)
    for number in range(1, 6):
        record = changes.record(document(Sketch(PICTURE, ((1.0, 2.0),) * number)), (), 2.0)
        assert len(record) < 4000
        replay.feed(record)


def test_hostile_states_are_refused():
    good = encode_state(Sketches((Sketch(PICTURE),)))
    for words in (b'"width":90', b'"height":120'):
        assert words in good.json
        name = words.split(b":")[0]
        for bad in (b":0", b":-3", b":1e9", b":10000000000", b':"x"', b":null"):
            broken = type(good)(good.json.replace(words, name + bad), good.strokes, good.arrays)
            with pytest.raises(DocumentError):
                decode_state(Sketches, broken)
    floats = type(good)(good.json, good.strokes, (np.zeros(4),))
    with pytest.raises(DocumentError):
        decode_state(Sketches, floats)
    # Bytes that are no picture are let in: they are told when they are looked at.
    rubbish = type(good)(good.json, good.strokes, (np.frombuffer(b"rubbish", np.uint8),))
    (sketch,) = decode_state(Sketches, rubbish).sketches
    with pytest.raises(FormatError):
        _ = sketch.picture.pixels


def test_equal_pictures_have_equal_digests():
    twin = Picture.of(NOISE, "Front 3/4")
    one, other = (Sketches((Sketch(picture),)) for picture in (PICTURE, twin))
    check_encodable(Sketches, one)
    assert state_digest(one) == state_digest(other)
    changed = NOISE.copy()
    changed[0, 0, 0] ^= 1
    third = Sketches((Sketch(Picture.of(changed, "Front 3/4")),))
    assert state_digest(third) != state_digest(one)
