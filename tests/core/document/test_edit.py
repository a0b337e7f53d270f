"""What a person does to objects, views and underlays; the old document never changes."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.document.model import Document, Model, NamedView, Underlay
from bozzetto.document.storage.bozz_file import encode_document
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement
from tests.document_kit import CAMERA, SIDE, Ink, rich_document, underlay

DOCUMENT = rich_document()
LOCKED = edit.lock_model(DOCUMENT, "m1", True).document
MOVED = Placement(offset=(1.0, 2.0, 3.0))
OTHER = underlay("Other")


def as_it_is(model, sources):
    return model


@pytest.mark.parametrize(
    ("change", "label"),
    [
        (lambda d: edit.add_model(d, Model("n", "Body", "test.ink", Ink())), "Add “Body 2”"),
        (lambda d: edit.change_state(d, "m1", Ink(), "Draw"), "Draw"),
        (lambda d: edit.rename_model(d, "m1", " Belly "), "Rename to “Belly”"),
        (lambda d: edit.show_model(d, "m1", False), "Hide “Body”"),
        (lambda d: edit.show_model(d, "m3", True), "Show “Ink”"),
        (lambda d: edit.lock_model(d, "m1", True), "Lock “Body”"),
        (lambda d: edit.lock_model(d, "m2", False), "Unlock “Handle”"),
        (lambda d: edit.color_model(d, "m1", (1, 2, 3)), "Colour “Body”"),
        (lambda d: edit.place_model(d, "m1", MOVED), "Move “Body”"),
        (lambda d: edit.delete_models(d, ["m1"]), "Delete “Body”"),
        (lambda d: edit.delete_models(d, ["m1", "m3"]), "Delete 2 objects"),
        (lambda d: edit.duplicate_model(d, "m1"), "Duplicate “Body”"),
        (lambda d: edit.move_model(d, "m1", 2), "Reorder “Body”"),
        (lambda d: edit.add_view(d, "Top", CAMERA), "Keep view “Top”"),
        (lambda d: edit.delete_view(d, "Side"), "Delete view “Side”"),
        (lambda d: edit.change_underlay(d, OTHER), "Change underlay “Other”"),
        (lambda d: edit.delete_underlay(d, "scan"), "Delete underlay “Scan”"),
    ],
)
def test_an_edit_makes_a_new_document_that_can_be_saved(change, label):
    before = encode_document(DOCUMENT)
    document, said = change(DOCUMENT)
    assert said == label
    assert encode_document(DOCUMENT) == before
    assert encode_document(document) != before


@pytest.mark.parametrize(
    "change",
    [
        lambda d: edit.change_state(d, "m1", Ink(), "Draw"),
        lambda d: edit.rename_model(d, "m1", "Belly"),
        lambda d: edit.color_model(d, "m1", None),
        lambda d: edit.place_model(d, "m1", MOVED),
        lambda d: edit.delete_models(d, ["m3", "m1"]),
    ],
)
def test_locked_objects_refuse(change):
    with pytest.raises(UserError, match=r"“Body” is locked\. Unlock"):
        change(LOCKED)


def test_locked_objects_can_be_hidden_copied_and_moved_in_the_list():
    edit.show_model(LOCKED, "m1", False)
    edit.move_model(LOCKED, "m1", 2)
    copy = edit.duplicate_model(LOCKED, "m1").document.models[1]
    assert not copy.locked


@pytest.mark.parametrize(
    ("name", "copies"),
    [
        ("Body", ("Body 2", "Body 3")),
        ("Body 7", ("Body 2", "Body 3")),
        ("Roadster 1960", ("Roadster 1960 2", "Roadster 1960 3")),
        ("n" * 200, ("n" * 180 + " 2", "n" * 180 + " 3")),
    ],
)
def test_a_copy_and_its_copy_are_counted_on(name, copies):
    document = Document().with_model(Model("a", name, "test.ink", Ink()))
    first = edit.duplicate_model(document, "a").document
    again = edit.duplicate_model(first, first.models[1].id).document
    assert {model.name for model in again.models} == {name, *copies}


@pytest.mark.parametrize("at", [0, 1, 2])
def test_reordering_counts_without_the_object(at):
    document = edit.move_model(DOCUMENT, "m2", at).document
    others = [model.id for model in document if model.id != "m2"]
    assert others == ["m1", "m3"]
    assert document.place_of("m2") == at


def test_a_copy_stands_behind_its_original_under_its_own_name_and_id():
    document = edit.duplicate_model(DOCUMENT, "m1").document
    original, copy = document.models[0], document.models[1]
    assert copy.name == "Body 2"
    assert copy.id != original.id
    assert copy.state is original.state


def test_copies_come_where_they_stood_or_beside_what_they_would_lie_on():
    step = (5.0, 0.0, -5.0)
    copied = edit.copied_models(DOCUMENT, ["m1", "m2"])
    elsewhere = edit.paste_models(Document(), copied, as_it_is, step).document
    assert [model.placement for model in elsewhere] == [model.placement for model in copied]
    # The second is in the way, and they stay together.
    document = edit.delete_models(DOCUMENT, ["m1"]).document
    for times in (1.0, 2.0, 3.0):
        document = edit.paste_models(document, copied, as_it_is, step).document
        for model, copy in zip(copied, document.models[-2:], strict=True):
            moved = np.subtract(copy.placement.offset, model.placement.offset)
            assert moved.tolist() == (times * np.array(step)).tolist()
    twin = edit.duplicate_models(DOCUMENT, ["m1"], as_it_is, step).document.models[1]
    assert twin.placement.offset == step


def test_a_step_too_small_for_where_things_are_ends_all_the_same():
    far = edit.place_model(DOCUMENT, "m1", Placement(offset=(1e18, 0.0, 0.0))).document
    assert len(edit.duplicate_models(far, ["m1"], as_it_is, (1e-3, 0.0, 0.0)).document) == 4


def test_a_view_of_the_same_name_is_replaced():
    document = edit.add_view(DOCUMENT, "Side", CAMERA).document
    assert document.views == (NamedView("Front", CAMERA), NamedView("Side", CAMERA))


@pytest.mark.parametrize(
    "change",
    [
        lambda d: edit.rename_model(d, "gone", "x"),
        lambda d: edit.delete_models(d, []),
        lambda d: edit.delete_view(d, "gone"),
        lambda d: edit.delete_underlay(d, "gone"),
        lambda d: edit.rename_model(d, "m1", "  "),
        lambda d: edit.rename_model(d, "m1", "two\nlines"),
        lambda d: edit.rename_model(d, "m1", "\ud800"),
        lambda d: edit.rename_model(d, "m1", "x" * 201),
        lambda d: edit.add_view(d, "", SIDE),
    ],
)
def test_what_cannot_be_done_is_explained(change):
    with pytest.raises(UserError):
        change(DOCUMENT)


@pytest.mark.parametrize("name", ["../x", "a/b", "", ".x", "x" * 65, "a\n", "ü"])
def test_ids_that_could_leave_the_file_are_refused(name):
    with pytest.raises(ValueError, match="id"):
        Model(name, "N", "test.ink", Ink())
    with pytest.raises(ValueError, match="id"):
        Model("n", "N", name, Ink())


def test_what_could_not_be_read_again_cannot_be_made():
    with pytest.raises(ValueError, match="colour"):
        Model("n", "N", "test.ink", Ink(), color=(0, 0, 256))
    corners = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)
    with pytest.raises(ValueError, match="shape"):
        Underlay("u", "U", np.zeros((2, 2, 3), np.uint8), *corners)
    with pytest.raises(ValueError, match="finite"):
        Underlay("u", "U", np.zeros((2, 2, 4), np.uint8), (np.nan, 0.0, 0.0), *corners[1:])


def test_a_document_is_made_of_any_row_of_models():
    models = [Model(f"m{n}", "M", "test.ink", Ink()) for n in range(200)]
    document = Document(tuple(models))
    assert list(document) == models
    assert document.models[150] is models[150]
    assert list(document.without_model("m150")) == models[:150] + models[151:]
