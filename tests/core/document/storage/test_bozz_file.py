"""The file: what goes in comes out, other programs can read it, damage is one error."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import zipfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.document.model import Document, Model, OpaqueState
from bozzetto.document.storage import bozz_reader, migrations
from bozzetto.document.storage.bozz_file import (
    decode_document,
    encode_document,
    read_document,
    write_document,
)
from bozzetto.document.storage.bozz_reader import document_info
from bozzetto.document.waiting_ink import WaitingStroke, marked, strokes_of
from bozzetto.errors import DocumentError, UserError
from bozzetto.geometry.placement import Placement
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.view.camera import Camera
from tests.document_kit import (
    Everything,
    FakeRegistry,
    Ink,
    full_stroke,
    rich_document,
    same_document,
    same_state,
    stroke,
    underlay,
)


class Nobody:
    """A registry without a single modeler."""

    def state_type(self, modeler_id):
        return None

    def upgrade(self, modeler_id, state, version):
        raise AssertionError

    def sources(self, modeler_id, state):
        raise AssertionError


def entries(content: bytes) -> dict[str, bytes]:
    """What Python's own zip reader finds."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


def repacked(content: bytes, **changes: bytes | None) -> bytes:
    """The same file with entries exchanged (or left out), checksums and all."""
    found = {**entries(content), **{k.replace("__", "/"): v for k, v in changes.items()}}
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, body in found.items():
            if body is not None:
                archive.writestr(name, body)
    return file.getvalue()


def edited(content: bytes, name: str, change) -> bytes:
    """The same file with a JSON entry changed by a function."""
    tree = json.loads(entries(content)[name])
    tree = change(tree) or tree
    return repacked(content, **{name: json.dumps(tree).encode()})


def test_a_document_comes_back_as_it_was(tmp_path):
    document = rich_document()
    write_document(document, tmp_path / "a.bozz")
    again, report = read_document(tmp_path / "a.bozz", FakeRegistry())
    assert same_document(document, again)
    assert not report.read_only
    assert len(report.warnings) == 1
    assert "absent.modeler" in report.warnings[0]


def test_an_empty_document_comes_back():
    again, report = decode_document(encode_document(Document()), Nobody())
    assert same_document(Document(), again)
    assert report.warnings == ()


def test_equal_documents_make_equal_files():
    assert encode_document(rich_document()) == encode_document(rich_document())


@pytest.mark.skipif(shutil.which("unzip") is None, reason="unzip is not installed")
def test_unzip_finds_nothing_wrong(tmp_path):
    write_document(rich_document(), tmp_path / "a.bozz", thumbnail=b"\x89PNG")
    subprocess.run(["unzip", "-tq", tmp_path / "a.bozz"], check=True, capture_output=True)


def test_the_kind_of_file_can_be_told_from_its_first_bytes():
    content = encode_document(rich_document())
    assert content[30:38] == b"mimetype"
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert archive.namelist()[:2] == ["mimetype", "manifest.json"]


def test_samples_can_be_read_by_hand():
    document = rich_document()
    found = entries(encode_document(document))
    offsets = np.frombuffer(found["core/strokes/offsets.u4"], "<u4")
    ink = [*document.models[0].state.strokes, *document.models[1].state.strokes]
    ink += document.models[2].state.strokes
    for name in ("x", "y", "pressure", "t", "tilt_x", "tilt_y", "twist"):
        column = np.frombuffer(found[f"core/strokes/{name}.f4"], "<f4")
        for number, drawn in enumerate(ink):
            part = column[offsets[number] : offsets[number + 1]]
            assert (part == getattr(drawn, name)).all()
    assert len(offsets) == len(ink) + 1


def test_columns_that_no_stroke_has_are_left_out():
    plain = Document((Model("a", "A", "test.ink", Ink(Strokes([stroke(), stroke(1)]))),))
    names = entries(encode_document(plain))
    assert {name for name in names if name.startswith("core/strokes/")} == {
        "core/strokes/offsets.u4",
        "core/strokes/x.f4",
        "core/strokes/y.f4",
    }
    again, _ = decode_document(encode_document(plain), FakeRegistry())
    assert same_document(plain, again)


def test_arrays_of_an_opened_document_cannot_be_written_to():
    again, _ = decode_document(encode_document(rich_document()), FakeRegistry())
    state = again.models[0].state
    for array in (state.weights, state.mesh.vertices, state.strokes[0].x, state.best.twist):
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True


def test_cameras_are_shared():
    many = Strokes([stroke(n, camera=Camera(fov_y=20.0 + n % 2)) for n in range(10)])
    content = encode_document(Document((Model("a", "A", "test.ink", Ink(many)),)))
    assert len(json.loads(entries(content)["core/strokes.meta.json"])["cameras"]) == 2


def test_parts_of_absent_plugins_survive_byte_for_byte():
    first = encode_document(rich_document())
    closed, report = decode_document(first, Nobody())
    assert len(report.warnings) == 3
    assert all(isinstance(model.state, OpaqueState) for model in closed)
    second = encode_document(closed)
    assert entries(second) == entries(first)
    # … also when somebody edits around them
    front = Model("new", "New", "test.ink", Ink(Strokes([full_stroke(77)])))
    moved = closed.with_model(front, at=0).with_model(
        replace(closed.models[0], placement=Placement(offset=(1.0, 0.0, 0.0)))
    )
    kept = {n: b for n, b in entries(first).items() if n.startswith(("plugins/", "notes/"))}
    third = encode_document(moved)
    assert kept.items() <= entries(third).items()
    # … and the plugin finds its own again.
    opened, _ = decode_document(third, FakeRegistry())
    assert same_state(opened.model("m1").state, rich_document().model("m1").state)


def test_what_nobody_knows_is_kept_and_derived_is_dropped():
    content = repacked(
        encode_document(rich_document()),
        **{"vendor/x.bin": b"\1\2", "derived/cache.bin": b"old", "core/future.json": b"{}"},
    )
    document, _ = decode_document(content, FakeRegistry())
    found = entries(encode_document(document))
    assert found["vendor/x.bin"] == b"\1\2"
    assert found["core/future.json"] == b"{}"
    assert "derived/cache.bin" not in found


def test_a_state_that_its_modeler_cannot_read_stays_closed_and_whole():
    content = encode_document(rich_document())
    name = "plugins/test.ink/m3/state.json"
    odd = entries(content)[name].replace(b"1.0", b"99.0")
    document, report = decode_document(repacked(content, **{name: odd}), FakeRegistry())
    assert isinstance(document.model("m3").state, OpaqueState)
    assert any("Thickness" in warning for warning in report.warnings)
    assert entries(encode_document(document))[name] == odd


def test_states_of_older_versions_are_upgraded_and_newer_ones_stay_closed():
    @dataclass(frozen=True)
    class Later:
        thickness: float
        strokes: Strokes
        upgraded_from: int = 0

    content = encode_document(rich_document())
    later = FakeRegistry(test__ink=(Later, 2))
    document, _ = decode_document(content, later)
    model = document.model("m3")
    assert model.state.upgraded_from == 1
    assert model.state_version == 2
    newer = encode_document(document)
    assert decode_document(newer, later)[0].model("m3").state.upgraded_from == 1
    document, report = decode_document(newer, FakeRegistry())
    assert isinstance(document.model("m3").state, OpaqueState)
    assert any("newer" in warning for warning in report.warnings)
    assert entries(encode_document(document)) == entries(newer)


def test_a_newer_file_says_so_or_opens_for_looking_only():
    content = encode_document(rich_document())
    late = edited(content, "manifest.json", lambda m: m.update(version=9, min_reader=8))
    with pytest.raises(DocumentError, match="Update"):
        decode_document(late, FakeRegistry())
    mild = edited(content, "manifest.json", lambda m: m.update(version=9, novelty=[1]))
    document, report = decode_document(mild, FakeRegistry())
    assert report.read_only
    assert same_document(document, rich_document())


def test_an_older_file_is_migrated_step_by_step(monkeypatch):
    def newest(trees):
        manifest = {**trees["manifest.json"], "version": migrations.VERSION + 1}
        views = {**trees["core/views.json"], "views": []}
        return {**trees, "manifest.json": manifest, "core/views.json": views}

    content = encode_document(rich_document())
    steps = (*migrations.STEPS, newest)
    monkeypatch.setattr(bozz_reader, "VERSION", len(steps) + 1)
    monkeypatch.setattr(bozz_reader, "migrate", lambda t, v: migrations.migrate(t, v, steps))
    document, report = decode_document(content, FakeRegistry())
    assert document.views == ()
    assert same_state(tuple(document), tuple(rich_document()))
    assert not report.read_only


def test_migrations_start_where_the_file_is():
    steps = [lambda t, n=n: {**t, "path": [*t["path"], n]} for n in (1, 2, 3)]
    assert migrations.migrate({"path": []}, 2, steps)["path"] == [2, 3]
    assert migrations.migrate({"path": []}, 4, steps)["path"] == []


def test_info_tells_without_asking_a_plugin(tmp_path):
    write_document(rich_document(), tmp_path / "a.bozz")
    info = document_info(tmp_path / "a.bozz")
    assert json.loads(json.dumps(info)) == info
    assert info["plugins"] == ["absent.modeler", "test.everything", "test.ink"]
    assert [entry["name"] for entry in info["objects"]] == ["Body", "Handle", "Ink"]
    assert [entry["strokes"] for entry in info["objects"]] == [3, 1, 1]
    assert info["views"] == ["Side", "Front"]
    assert info["underlays"] == ["Scan"]
    assert info["waiting_strokes"] == 4


def bad_models(change):
    return lambda content: edited(content, "core/models.json", change)


def without(name):
    return lambda content: repacked(content, **{name: None})


def shifted(tree):
    tree[1]["strokes"] = [0, 4]


def grabbing(tree):
    tree[1]["arrays"] = tree[0]["arrays"][:1]


def repeating(tree):
    tree[1]["arrays"] *= 2


@pytest.mark.parametrize(
    "harm",
    [
        without("manifest.json"),
        without("mimetype"),
        without("core/models.json"),
        without("core/views.json"),
        without("core/strokes.meta.json"),
        without("core/strokes/offsets.u4"),
        without("core/strokes/x.f4"),
        without("core/underlays/scan.png"),
        without("plugins/test.ink/m3/state.json"),
        without("plugins/absent.modeler/m2/0.f4"),
        lambda c: repacked(c, mimetype=b"application/zip"),
        lambda c: repacked(c, **{"core/underlays/scan.png": b"\x89PNG nonsense"}),
        lambda c: repacked(c, **{"core/strokes/x.f4": bytes(8)}),
        lambda c: repacked(c, **{"core/models.json": b"[" * 10**6}),
        lambda c: edited(c, "manifest.json", lambda m: m.update(format="else")),
        lambda c: edited(c, "manifest.json", lambda m: m.update(version=0)),
        lambda c: edited(c, "manifest.json", lambda m: m.update(version="1")),
        lambda c: edited(c, "manifest.json", lambda m: m.pop("parts")),
        lambda c: edited(c, "manifest.json", lambda m: m["parts"].append(m["parts"][0])),
        lambda c: edited(c, "manifest.json", lambda m: m["parts"][0].update(shape=[10**12])),
        lambda c: edited(c, "manifest.json", lambda m: m["parts"][0].update(dtype="O")),
        bad_models(lambda t: t[1]["header"].update(id="m1")),
        bad_models(lambda t: t[1]["header"].update(id="../../x")),
        bad_models(lambda t: t[1]["header"].update(modeler="a/b")),
        bad_models(lambda t: t[1]["header"].update(name="")),
        bad_models(lambda t: t[1]["header"].update(name="a\nb")),
        bad_models(lambda t: t[1]["header"].update(color=[0, 0, 256])),
        bad_models(lambda t: t[1]["header"]["placement"].update(scale=0.0)),
        bad_models(
            lambda t: t[1]["header"]["placement"].update(rotation=[1e308, -1e308] * 4 + [1])
        ),
        bad_models(lambda t: t[1].update(strokes=[3, 10**9])),
        bad_models(lambda t: t[1].update(strokes=[3, -1])),
        bad_models(lambda t: t.pop()),
        bad_models(shifted),
        bad_models(grabbing),
        bad_models(repeating),
        lambda c: edited(c, "core/views.json", lambda t: t["camera"].update(fov_y=0.0)),
        lambda c: edited(c, "core/views.json", lambda t: t["underlays"][0].update(opacity=2)),
        lambda c: edited(c, "core/views.json", lambda t: t["underlays"][0].update(id="gone")),
        lambda c: edited(c, "core/strokes.meta.json", lambda t: t["strokes"].pop()),
        lambda c: edited(c, "core/strokes.meta.json", lambda t: t.update(cameras=[])),
        lambda c: edited(c, "core/strokes.meta.json", lambda t: t["strokes"][0].append(1)),
        lambda c: c[:-1],
        lambda c: c[1:],
        lambda c: b"",
        lambda c: b"PK" * 500,
    ],
)
def test_damage_and_malice_are_one_error(harm):
    with pytest.raises(DocumentError):
        decode_document(harm(encode_document(rich_document())), FakeRegistry())


def test_more_objects_than_parts_are_refused_before_they_are_made():
    """A list of them held the interpreter, and the window with it, until all were made."""
    content = bad_models(lambda tree: tree * 200)(encode_document(rich_document()))
    with pytest.raises(DocumentError, match="more objects than it holds"):
        decode_document(content, FakeRegistry())


@pytest.mark.parametrize("offsets", [[0, 3, 2], [1, 2, 3], [0, 0, 3], [0, 1], [0, 1, 2**32 - 1]])
def test_lengths_of_strokes_must_be_possible(offsets):
    plain = Document((Model("a", "A", "test.ink", Ink(Strokes([stroke(count=1), stroke(1, 2)]))),))
    raw = np.array(offsets, "<u4").tobytes()

    def lie(manifest):
        part = next(p for p in manifest["parts"] if p["name"].endswith("offsets.u4"))
        part.update(shape=[len(offsets)], crc=zipfile.crc32(raw))

    content = repacked(encode_document(plain), **{"core/strokes/offsets.u4": raw})
    with pytest.raises(DocumentError):
        decode_document(edited(content, "manifest.json", lie), FakeRegistry())


def test_files_that_cannot_be_read_are_explained(tmp_path):
    with pytest.raises(UserError, match="no file"):
        read_document(tmp_path / "none.bozz", Nobody())
    with pytest.raises(UserError, match="cannot be read"):
        read_document(tmp_path, Nobody())
    if os.path.exists("/dev/null"):
        with pytest.raises(UserError, match="not a file"):
            read_document("/dev/null", Nobody())
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.bozz")
        with pytest.raises(UserError, match="not a file"):
            read_document(tmp_path / "pipe.bozz", Nobody())
    (tmp_path / "empty.bozz").write_bytes(b"")
    with pytest.raises(DocumentError, match="cut short"):
        read_document(tmp_path / "empty.bozz", Nobody())


def test_numbers_of_numpy_do_not_keep_a_document_from_being_saved():
    placed = Placement(offset=tuple(np.arange(3.0)), scale=np.float32(2.0))
    document = Document(
        (Model("a", "A", "test.ink", Ink(), placed),), underlays=(underlay(),), camera=Camera()
    )
    again, _ = decode_document(encode_document(document), FakeRegistry())
    assert again.models[0].placement == Placement(offset=(0.0, 1.0, 2.0), scale=2.0)


GOLDEN = Path(__file__).parents[3] / "data" / "documents"


STROKE_FIELDS = sorted(name for name in Stroke.__slots__ if not name.startswith("_"))


def plain(value):
    """A document as JSON values, by no code of ours: what ``v1.json`` was written with."""
    if isinstance(value, np.ndarray):
        return {"dtype": value.dtype.str, "shape": list(value.shape), "hex": value.tobytes().hex()}
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, float):
        return value.hex()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, Stroke):
        return {name: plain(getattr(value, name)) for name in STROKE_FIELDS}
    if hasattr(value, "__dataclass_fields__"):
        fields = {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
        return {"class": type(value).__name__, **fields}
    return [plain(item) for item in value]


LATER = ("sources", "frozen", "linked")
"""Fields of models that came with version 3; empty where nothing is followed."""


def told(value):
    """The JSON values without fields that came later and are what they are by default."""
    if isinstance(value, dict):
        return {
            key: told(entry)
            for key, entry in value.items()
            if entry is not None and not (key in LATER and entry == [])
        }
    return [told(entry) for entry in value] if isinstance(value, list) else value


def test_the_golden_file_of_version_1_opens_for_ever():
    document, report = decode_document((GOLDEN / "v1.bozz").read_bytes(), FakeRegistry())
    now = plain(document)
    assert now.pop("waiting") == []  # came with version 2
    assert told(now) == told(json.loads((GOLDEN / "v1.json").read_text()))
    assert not report.read_only
    assert isinstance(document.model("m2").state, OpaqueState)
    assert isinstance(document.model("m1").state, Everything)


def test_the_golden_file_of_version_2_opens_for_ever():
    document, report = decode_document((GOLDEN / "v2.bozz").read_bytes(), FakeRegistry())
    assert told(plain(document)) == told(json.loads((GOLDEN / "v2.json").read_text()))
    assert not report.read_only
    assert [one.status for one in document.waiting] == "new unfinished refused failed".split()


class Linked:
    """Knows the linked states of the golden file of version 3."""

    def state_type(self, modeler_id):
        return {"test.linked": (LinkedState, 1)}.get(modeler_id)

    def upgrade(self, modeler_id, state, version):
        raise AssertionError

    def sources(self, modeler_id, state):
        return state.sources


@dataclass(frozen=True)
class LinkedState:
    sources: tuple[str, ...] = ()
    strokes: Strokes = Strokes()
    weights: NDArray[np.float64] = field(default_factory=lambda: frozen([], np.float64))


def linked_document():
    """What version 3 keeps: a follower, one with frozen sources, and a closed follower."""
    state = LinkedState((), Strokes([full_stroke(1)]), frozen([0.1, 1 / 3], np.float64))
    a = Model("a", "Body", "test.linked", state)
    moved = Placement(scale=2.0, offset=(1.0, 2.0, 3.0))
    b = Model("b", "Skin", "test.linked", replace(state, sources=("a",)), sources=("a",))
    b = replace(b, placement=moved, frozen=(replace(a, placement=moved.inverse()),))
    c = Model("c", "Far", "test.linked", LinkedState(("b", "d")), sources=("b", "d"))
    c = replace(c, frozen=(b,))
    opaque = OpaqueState(7, b'{"odd":1}', (stroke(3),), (frozen([1.5], np.float32),))
    e = Model("e", "Closed", "absent.modeler", opaque, state_version=7, sources=("a", "d"))
    d = Model("d", "Living", "test.linked", state)
    return Document((b, c, d, replace(e, frozen=(a,))))


def test_the_golden_file_of_version_3_opens_for_ever():
    document, report = decode_document((GOLDEN / "v3.bozz").read_bytes(), Linked())
    assert plain(document) == json.loads((GOLDEN / "v3.json").read_text())
    assert not report.read_only
    assert same_document(document, linked_document())


def test_what_version_2_knows_of_version_3_is_unharmed_by_frozen_models():
    """A reader of version 2 finds the strokes and the arrays that it expects, and no others."""
    content = encode_document(linked_document())
    loose = Document(replace(model, frozen=(), sources=()) for model in linked_document())
    ours, theirs = entries(content), entries(encode_document(loose))
    for name in set(ours) & set(theirs) - {"manifest.json", "core/models.json"}:
        if not name.startswith("core/frozen") and not name.endswith("state.json"):
            assert ours[name] == theirs[name], name
    assert all(name.startswith(("core/frozen", "frozen/")) for name in set(ours) - set(theirs))


def test_waiting_ink_comes_back_and_a_document_without_any_has_no_columns_for_it():
    document = rich_document()
    content = encode_document(document)
    again, _ = decode_document(content, FakeRegistry())
    assert same_document(again, document)
    assert [one.stroke for one in again.waiting] == [one.stroke for one in document.waiting]
    assert not same_document(again, document.with_waiting(document.waiting[:3]))
    dry = encode_document(document.with_waiting(()))
    assert not [name for name in entries(dry) if "core/waiting/" in name]
    assert decode_document(dry, FakeRegistry())[0].waiting == ()


def test_what_a_plugin_says_of_ink_can_always_be_written():
    said = "half \ud800 a character"
    new = (WaitingStroke(stroke(1)),)
    assert marked(new, (), "refused", modeler="m", tool="t") is new
    ink = marked(
        new,
        strokes_of(new),
        "refused",
        modeler="m",
        tool="\udfff",
        reason=said + "x" * 5000,
        places=[(np.nan, 1.0), (2.0, 3.0)],
    )
    again, _ = decode_document(encode_document(Document(waiting=ink)), FakeRegistry())
    assert again.waiting[0].reason.startswith("half ? a character")
    assert again.waiting[0].places == ((2.0, 3.0),)


@pytest.mark.parametrize(
    "change",
    [
        lambda entries: entries[:-1],
        lambda entries: [*entries, entries[0]],
        lambda entries: entries[0].update(status="lost"),
        lambda entries: entries[0].update(places=[[1.0]]),
        lambda entries: entries[0].update(places=[[None, 1.0]]),
        lambda entries: [7],
    ],
)
def test_a_wrong_list_of_waiting_ink_is_refused(change):
    content = edited(encode_document(rich_document()), "core/waiting.json", change)
    with pytest.raises(DocumentError):
        decode_document(content, FakeRegistry())


def test_there_is_a_golden_file_for_every_version():
    kept = {path.name for path in GOLDEN.glob("v*.bozz")}
    assert kept == {f"v{n}.bozz" for n in range(1, migrations.VERSION + 1)}
