"""Entry points read from files: what `importlib.metadata` says, without its imports."""

from __future__ import annotations

import sys
import zipfile
from importlib.metadata import entry_points

import pytest

from bozzetto.plugin.host.entry_points import announced

INI = """
# a remark
[console_scripts]
thing = thing:main

[some.group]
one = thing_one
two=thing_two:attribute [extra]
 three = thing.three
"""


def told(group):
    return {entry.value for entry in entry_points(group=group)}


@pytest.mark.parametrize("group", ["bozzetto.plugins", "console_scripts", "pytest11", "none.such"])
def test_what_is_installed_here_is_found(group):
    assert announced(group) == told(group)


@pytest.mark.parametrize("ending", ["1.0.dist-info", "2.1-py3.11.egg-info"])
def test_the_first_of_two_with_one_name_counts(tmp_path, monkeypatch, ending):
    for place, text in (("a", INI), ("b", INI.replace("thing_one", "other"))):
        folder = tmp_path / place / f"Some.Thing-{ending}"
        folder.mkdir(parents=True)
        (folder / "entry_points.txt").write_text(text)
        (folder / "METADATA").write_text("Name: some-thing\nVersion: 1.0\n")
        (folder / "PKG-INFO").write_text("Name: some-thing\nVersion: 1.0\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path / "a"), str(tmp_path / "b"), *sys.path])
    found = announced("some.group")
    assert (
        found == {"thing_one", "thing_two:attribute [extra]", "thing.three"} == told("some.group")
    )


def test_folders_that_cannot_be_read_announce_nothing(tmp_path, monkeypatch):
    (tmp_path / "empty-1.0.dist-info").mkdir()
    (tmp_path / "odd-1.0.dist-info").mkdir()
    (tmp_path / "odd-1.0.dist-info" / "entry_points.txt").write_bytes(b"\xff\xfe[some.group]\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path), str(tmp_path / "gone"), *sys.path])
    assert announced("some.group") == set()


def test_a_distribution_in_an_archive_is_found_too(tmp_path, monkeypatch):
    archive = tmp_path / "wheel.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("thing-1.0.dist-info/entry_points.txt", INI)
        file.writestr("thing-1.0.dist-info/METADATA", "Name: thing\nVersion: 1.0\n")
    monkeypatch.setattr(sys, "path", [str(archive), *sys.path])
    assert "thing_one" in announced("some.group") == told("some.group")
