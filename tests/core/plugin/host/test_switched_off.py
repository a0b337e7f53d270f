"""Which plugins are switched off: one setting, and two packages that are told apart."""

from __future__ import annotations

import pytest

from bozzetto.cli.main import main
from bozzetto.errors import UserError
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.host.switched_off import keep_switched_off, settings_file, switch, switched_off

SAME_ID = """
id = "{author}.plugin"
title = "Plugin"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "twin.modeler"
title = "Twin"
icon = "icon.svg"
hint = "Draw."
"""


@pytest.fixture
def run(capfd):
    """Run a command of ``bozzetto plugins``: code, output, errors."""

    def plugins(*words):
        capfd.readouterr()
        code = main(["plugins", *words])
        return code, *capfd.readouterr()

    return plugins


def test_nothing_is_kept_before_anybody_switches_something():
    assert switched_off() is None
    assert not settings_file().exists()


def test_one_is_switched_without_touching_the_others():
    keep_switched_off(["a.one", "b.two"])
    switch("a.one", True)
    switch("c.three", False)
    assert switched_off() == {"b.two", "c.three"}


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b'{"disabled": 7}', b"\xff\xfe", b"[" * 9000]
)
def test_a_damaged_file_keeps_nothing_from_starting(content):
    settings_file().parent.mkdir(parents=True, exist_ok=True)
    settings_file().write_bytes(content)
    assert switched_off() is None
    switch("a.one", False)
    assert switched_off() == {"a.one"}


def test_entries_that_are_no_ids_are_passed_over():
    settings_file().parent.mkdir(parents=True, exist_ok=True)
    settings_file().write_text('{"disabled": ["a.one", 7, null]}')
    assert switched_off() == {"a.one"}


def test_a_folder_that_cannot_be_made_is_told(monkeypatch, tmp_path):
    (tmp_path / "taken").write_text("a file")
    for name in ("XDG_CONFIG_HOME", "APPDATA"):
        monkeypatch.setenv(name, str(tmp_path / "taken"))
    with pytest.raises(UserError, match="cannot be made"):
        switch("a.one", False)


def test_the_command_line_switches_off_and_on(run):
    code, said, _ = run("disable", "car")
    assert (code, said) == (0, "bozzetto.car is switched off. Its objects are kept as they are.\n")
    assert switched_off() == {"bozzetto.car"}
    assert "bozzetto.car  0.1.0  disabled" in run("list")[1]
    assert run("enable", "bozzetto_car")[1] == "bozzetto.car is switched on.\n"
    assert switched_off() == frozenset()


def test_a_plugin_that_nobody_knows_is_refused(run):
    code, _, errors = run("disable", "nobody.knows")
    assert code == 2
    assert "no plugin 'nobody.knows'; there are: bozzetto.car" in errors
    assert run("enable")[0] == 2
    keep_switched_off(["gone.plugin"])
    assert run("enable", "gone.plugin")[0] == 0
    assert switched_off() == frozenset()


def test_a_modeler_that_is_switched_off_is_not_built_with(run, tmp_path, capfd):
    run("disable", "silhouette")
    (tmp_path / "a.svg").write_text('<svg><path d="M0,0 L40,0 L40,30 L0,30 Z"/></svg>')
    words = ["build", "silhouette", str(tmp_path / "a.svg"), "-o", str(tmp_path / "a.stl")]
    assert main(words) == 2
    assert "is switched off. Switch it on" in capfd.readouterr().err


def test_the_reason_of_broken_is_printed(run, monkeypatch, make_package):
    broken = make_package(manifest="id = 7")
    monkeypatch.setattr("bozzetto.plugin.host.registry.announced", lambda group: [broken])
    code, said, _ = run("list")
    assert code == 0
    first, reason = said.splitlines()
    assert f"{broken}    broken" in first
    assert reason.startswith("    In plugin.toml: ")


def test_two_packages_with_one_id_are_told_apart(run, monkeypatch, make_package):
    twins = [make_package(manifest=SAME_ID.replace("{author}", "twin")) for _ in range(2)]
    monkeypatch.setattr("bozzetto.plugin.host.registry.announced", lambda group: twins)
    first, second = Registry().plugins() if Registry().plugins()[0].id == twins[1] else (
        Registry().plugins()[::-1]
    )  # fmt: skip
    assert {first.id, second.id} == {twins[1], "twin.plugin"}
    said = run("list")[1]
    assert f"(package {twins[0]})" in said
    assert f"already taken by the package {twins[0]}" in said
    run("disable", twins[1])
    registry = Registry(disabled=switched_off())
    assert {info.id: info.status for info in registry.plugins()} == {
        "twin.plugin": "ready",
        twins[1]: "disabled",
    }
    assert registry.standing("twin.modeler").status == "ready"


def test_how_a_modeler_stands(make_package):
    package = make_package()
    registry = Registry(extra=[package])
    modeler = f"{package}.modeler"
    assert registry.standing(modeler).status == "ready"
    registry.set_disabled(f"{package}.plugin", True)
    assert registry.standing(modeler).status == "disabled"
    assert registry.standing(modeler).plugin == f"{package}.plugin"
    assert registry.standing("nobody.knows").status == "absent"
