from __future__ import annotations

import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packaging.specifiers import SpecifierSet
from packaging.version import Version

from bozzetto.plugin.host.manifest import ManifestError, api_accepts, find_folder, read_manifest

WHOLE = """
id = "author.thing"
title = "Thing"
summary = "Makes things."
version = "1.2"
api = ">=2,<3"

[[modeler]]
id = "author.thing"
title = "Thing"
icon = "icons/thing.svg"
hint = "Draw a thing."
samples = ["samples/one.json", { file = "samples/two.svg", title = "Two" }]
abilities = ["panel"]
order = 7
"""


def read(folder: Path, text: str | bytes):
    content = text.encode() if isinstance(text, str) else text
    (folder / "plugin.toml").write_bytes(content)
    return read_manifest(folder)


def test_everything_is_read(tmp_path):
    manifest = read(tmp_path, WHOLE)
    assert (manifest.id, manifest.title, manifest.version) == ("author.thing", "Thing", "1.2")
    (modeler,) = manifest.modelers
    assert modeler.hint == "Draw a thing."
    assert modeler.abilities == {"panel"}
    assert modeler.listed
    assert modeler.order == 7
    assert [(s.file, s.title) for s in modeler.samples] == [
        ("samples/one.json", "one"),
        ("samples/two.svg", "Two"),
    ]
    assert manifest.warnings == ()


def test_unknown_keys_are_told_and_ignored(tmp_path):
    manifest = read(tmp_path, 'colour = "red"\n' + WHOLE + 'shape = "round"\n')
    assert len(manifest.warnings) == 2
    assert "colour" in manifest.warnings[0]
    assert "shape" in manifest.warnings[1]
    assert "author.thing" in manifest.warnings[1]


@pytest.mark.parametrize(
    ("old", "new", "names"),
    [
        ('id = "author.thing"\ntitle', "title", "id"),
        ('id = "author.thing"\ntitle', 'id = "thing"\ntitle', "id"),
        ('id = "author.thing"\ntitle', 'id = "Author Thing.x"\ntitle', "id"),
        ('title = "Thing"', "title = 3", "title"),
        ('title = "Thing"', 'title = ""', "title"),
        ('api = ">=2,<3"', 'api = "one"', "api"),
        ('api = ">=2,<3"', 'api = ">=1;<2"', "api"),
        ('api = ">=2,<3"', "api = 1", "api"),
        ("order = 7", 'order = "first"', "order"),
        ('abilities = ["panel"]', 'abilities = ["fly"]', "abilities"),
        ("order = 7", "facts = [1]", "facts"),
        ("icons/thing.svg", "../thing.svg", "icon"),
        ("icons/thing.svg", "/etc/thing.svg", "icon"),
        ("icons/thing.svg", "icons/thing.exe", "icon"),
        ("icons/thing.svg", "C:/thing.svg", "icon"),
        ("icons/thing.svg", "..\\\\thing.svg", "icon"),
        ("samples/one.json", "samples/../../one.json", "sample"),
        ("samples/one.json", "one.py", "sample"),
        ('title = "Two"', "name = 2", "title"),
        ("[[modeler]]", "[modeler]", "modeler"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, old, new, names):
    assert old in WHOLE
    with pytest.raises(ManifestError) as caught:
        read(tmp_path, WHOLE.replace(old, new, 1))
    assert "plugin.toml" in caught.value.message
    assert names in caught.value.message


@pytest.mark.parametrize(
    ("facts", "keys"),
    [
        ("", ()),
        ('facts = ""', ()),
        ('facts = "views"', ("views",)),
        ('facts = ["views", "rules"]', ("views", "rules")),
        ("facts = []", ()),
        ('facts = ["", "views"]', ("views",)),
    ],
)
def test_files_are_told_by_one_key_or_several(tmp_path, facts, keys):
    manifest = read(tmp_path, WHOLE.replace("order = 7", f"order = 7\n{facts}", 1))
    assert manifest.modelers[0].facts == keys


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"id = ",
        b"\xff\xfe\x00",
        b"[[modeler]]",
        WHOLE.partition("[[modeler]]")[0].encode(),
        b"x = " + b"[" * 5000,
        b"#" * 100_000,
        (WHOLE + "\n[[modeler]]" + WHOLE.partition("[[modeler]]")[2]).encode(),
    ],
)
def test_hostile_files_are_refused(tmp_path, content):
    with pytest.raises(ManifestError):
        read(tmp_path, content)


def test_missing_file_and_folder_in_its_place(tmp_path):
    with pytest.raises(ManifestError):
        read_manifest(tmp_path)
    (tmp_path / "plugin.toml").mkdir()
    with pytest.raises(ManifestError):
        read_manifest(tmp_path)


@given(st.binary(max_size=200))
def test_any_bytes_give_a_manifest_or_a_sentence(tmp_path_factory, content):
    folder = tmp_path_factory.mktemp("manifest")
    with pytest.raises(ManifestError):
        read(folder, content)


def test_package_is_found_without_importing_it(make_package):
    package = make_package("raise RuntimeError('imported')")
    assert (find_folder(package) / "plugin.toml").is_file()
    assert package not in sys.modules


@pytest.mark.parametrize("name", ["no_such_package_anywhere", "json", "os", "a.b", "", "../x"])
def test_packages_that_are_none(name):
    with pytest.raises(ManifestError):
        find_folder(name)


signs = st.sampled_from([">=", "<=", ">", "<", "=="])
numbers = st.integers(0, 4)
bounds = st.builds(lambda s, a, b: f"{s}{a}.{b}", signs, numbers, numbers)


@given(st.lists(bounds, min_size=1, max_size=3), numbers, numbers)
def test_ranges_mean_what_packaging_says(parts, major, minor):
    wanted = ",".join(parts)
    said = SpecifierSet(wanted).contains(Version(f"{major}.{minor}"))
    assert api_accepts(wanted, (major, minor)) == said


def test_own_sides_are_each_named_once(tmp_path):
    def said(sides):
        (tmp_path / "plugin.toml").write_text(
            'id = "a.b"\ntitle = "T"\nversion = "1"\napi = ">=2,<3"\n[[modeler]]\nid = "a.b"\n'
            f'title = "T"\nicon = "i.svg"\nhint = "H"\nsides = {sides}\n'
        )
        return read_manifest(tmp_path).modelers[0].sides

    assert said('{ front = "left", left = "front" }') == {"front": "left", "left": "front"}
    with pytest.raises(ManifestError, match="once on the left and once on the right"):
        said('{ front = "left" }')
    with pytest.raises(ManifestError, match="sides"):
        said('{ nose = "left", left = "nose" }')
