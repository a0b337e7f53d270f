from __future__ import annotations

import subprocess
import sys
import threading

import pytest

from bozzetto.errors import UserError
from bozzetto.plugin.host.registry import Registry

WORKING = """
from bozzetto.plugin import Modeler, hookimpl
from dataclasses import dataclass

IMPORTS = []
IMPORTS.append(1)

@dataclass(frozen=True)
class State:
    number: int = 0

class Mine(Modeler):
    id = __name__ + ".modeler"
    state_type = State
    state_version = 3
    def solve(self, state, job): return None
    def scene(self, state, result): return None
    def shapes(self, state, result): return None
    def upgrade(self, state, version): return {**state, "from": version}

@hookimpl
def bozzetto_modelers():
    return [Mine()]
"""


def status(registry: Registry, package: str) -> str:
    return next(info.status for info in registry.plugins() if info.package == package)


def fault(registry: Registry, package: str) -> str:
    return next(info.fault for info in registry.plugins() if info.package == package)


def test_lists_need_no_import(make_package):
    package = make_package(WORKING)
    registry = Registry(extra=[package])
    info = registry.info(f"{package}.modeler")
    assert (info.title, info.hint, info.plugin) == ("Modeler", "Draw.", f"{package}.plugin")
    assert info.icon.is_file()
    assert info in registry.modelers()
    assert status(registry, package) == "ready"
    assert package not in sys.modules
    assert registry.modeler(f"{package}.modeler").id == f"{package}.modeler"
    assert status(registry, package) == "loaded"


def test_start_imports_nothing_heavy():
    code = (
        "import sys; from bozzetto.plugin.host.registry import Registry; r = Registry(); "
        "assert {m.id for m in r.modelers()} >= {'bozzetto.silhouette'}, r.plugins(); "
        "print([m for m in sys.modules if m.split('.')[0] in ('scipy', 'skimage', 'shapely', "
        "'manifold3d', 'PIL', 'PySide6', 'pytest') or m.startswith('bozzetto_')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


BROKEN = {
    "its own exception": "raise ValueError('at import')",
    "a missing module": "import there_is_no_such_module",
    "exit": "import sys; sys.exit(3)",
    "a syntax error": "def (:",
    "endless recursion": "def f(): f()\nf()",
    "no hook": "",
    "an undecorated hook": "def bozzetto_modelers(): return []",
    "a hook that does not exist": (
        "from bozzetto.plugin import hookimpl\n@hookimpl\ndef bozzetto_modelerz(): return []"
    ),
    "an argument that does not exist": (
        "from bozzetto.plugin import hookimpl\n@hookimpl\ndef bozzetto_modelers(shell): return []"
    ),
    "nothing delivered": (
        "from bozzetto.plugin import hookimpl\n@hookimpl\ndef bozzetto_modelers(): return []"
    ),
    "no list": (
        "from bozzetto.plugin import hookimpl\n@hookimpl\ndef bozzetto_modelers(): return 3"
    ),
    "a raising hook": (
        "from bozzetto.plugin import hookimpl\n@hookimpl\ndef bozzetto_modelers(): return 1 / 0"
    ),
    "another id": WORKING.replace('id = __name__ + ".modeler"', 'id = "x.y"'),
    "one twice": WORKING.replace("[Mine()]", "[Mine(), Mine()]"),
    "a modeler without solve": WORKING.replace("def solve", "def resolve"),
    "a state that can be changed": WORKING.replace("frozen=True", "frozen=False"),
    "a state that is no dataclass": WORKING.replace("state_type = State", "state_type = dict"),
    "a version that is none": WORKING.replace("state_version = 3", "state_version = '3'"),
    "words of a figure that are none": WORKING.replace(
        "    state_version = 3", "    state_version, figures = 3, {'gap': 'Gap'}"
    ),
    "a first parameter that is none": WORKING.replace(
        "    state_version = 3", "    state_version, first_parameters = 3, ('gap',)"
    ),
    "a class and no object": WORKING.replace("[Mine()]", "[3]"),
}


def test_who_delivers_another_id_is_told_both(make_package):
    package = make_package(BROKEN["another id"])
    registry = Registry(extra=[package])
    with pytest.raises(UserError) as caught:
        registry.modeler(f"{package}.modeler")
    assert f"announces {package}.modeler" in caught.value.message
    assert "delivers x.y" in caught.value.message
    assert "decorator" not in caught.value.message


def test_a_traceback_leads_to_the_innermost_plugin(make_package, tmp_path):
    inner, outer = make_package(WORKING), make_package(WORKING)
    registry = Registry(extra=[inner, outer])
    folders = {
        info.package: registry.info(f"{info.package}.modeler").icon.parent
        for info in registry.plugins()
        if info.package in (inner, outer)
    }
    files = [
        str(tmp_path / "native.py"),
        str(folders[inner] / "deep" / "solve.py"),
        str(folders[outer] / "solve.py"),
    ]
    found = registry.plugin_at(files)
    assert found is not None
    assert found.package == inner
    registry.set_disabled(found.id, True)
    assert registry.plugin_at(files) is None
    assert registry.plugin_at(files[2:]).package == outer
    assert registry.plugin_at(files[:1]) is None
    assert registry.plugin_at(()) is None


@pytest.mark.parametrize("code", BROKEN.values(), ids=BROKEN)
def test_a_broken_plugin_does_not_break_the_others(make_package, code):
    before, broken, after = make_package(WORKING), make_package(code), make_package(WORKING)
    registry = Registry(extra=[before, broken, after])
    assert status(registry, broken) == "ready"
    with pytest.raises(UserError, match="cannot be used") as caught:
        registry.modeler(f"{broken}.modeler")
    assert broken in caught.value.message
    assert status(registry, broken) == "broken"
    assert fault(registry, broken).endswith(".")
    assert registry.state_type(f"{broken}.modeler") is None
    stored = {"number": 4}
    assert registry.upgrade(f"{broken}.modeler", stored, 1) == stored
    for package in (before, after):
        assert registry.modeler(f"{package}.modeler").id == f"{package}.modeler"
    assert f"{broken}.modeler" not in [info.id for info in registry.modelers()]


def test_import_is_tried_once_and_its_traceback_kept(make_package):
    package = make_package("import there_is_no_such_module")
    registry = Registry(extra=[package])
    for _ in range(5):
        with pytest.raises(UserError, match="there_is_no_such_module"):
            registry.modeler(f"{package}.modeler")
    assert registry.guard.faults(f"{package}.plugin") == 1
    (info,) = [info for info in registry.plugins() if info.package == package]
    assert "ModuleNotFoundError" in info.details


@pytest.mark.parametrize(
    "manifest",
    [None, "id = ", 'id = "a.b"', "\0"],
    ids=["missing", "no toml", "half", "a zero byte"],
)
def test_a_bad_manifest_is_listed_with_a_sentence(make_package, manifest):
    good, bad = make_package(WORKING), make_package("raise RuntimeError", manifest)
    registry = Registry(extra=[bad, good])
    assert status(registry, bad) == "broken"
    assert "plugin.toml" in fault(registry, bad)
    assert registry.modeler(f"{good}.modeler")


def test_a_package_that_is_not_there():
    registry = Registry(extra=["no_such_package_anywhere"])
    assert status(registry, "no_such_package_anywhere") == "broken"


@pytest.mark.parametrize("api", [">=3", "<2", ">=1,<2", "==2.9"])
def test_another_contract_is_refused_without_import(make_package, api):
    package = make_package(
        "raise RuntimeError",
        'id = "{author}.plugin"\ntitle = "P"\nversion = "1"\napi = "' + api + '"\n'
        '[[modeler]]\nid = "{author}.modeler"\ntitle = "M"\nicon = "i.svg"\nhint = "H"',
    )
    registry = Registry(extra=[package])
    assert status(registry, package) == "broken"
    with pytest.raises(UserError, match="Update"):
        registry.modeler(f"{package}.modeler")
    assert package not in sys.modules


def test_the_second_of_two_with_one_id_is_refused(make_package):
    manifest = (
        'id = "twin.plugin"\ntitle = "T"\nversion = "1"\napi = ">=1"\n'
        '[[modeler]]\nid = "twin.modeler"\ntitle = "T"\nicon = "i.svg"\nhint = "H"'
    )
    code = WORKING.replace('__name__ + ".modeler"', '"twin.modeler"')
    first, second = make_package(code, manifest), make_package(code, manifest)
    other = make_package(code, manifest.replace("twin.plugin", "other.plugin"))
    registry = Registry(extra=[first, second, other])
    assert [status(registry, package) for package in (first, second, other)] == [
        "ready",
        "broken",
        "broken",
    ]
    for package in (second, other):
        assert first in fault(registry, package)
        assert package in fault(registry, package)
    assert type(registry.modeler("twin.modeler")).__module__ == first
    assert second not in sys.modules


def test_a_package_named_twice_is_one_plugin(make_package):
    package = make_package(WORKING)
    registry = Registry(extra=[package, package])
    assert registry.add_package(package).status == "ready"
    assert [info.package for info in registry.plugins()].count(package) == 1


def test_disabling(make_package):
    package = make_package(WORKING)
    registry = Registry(extra=[package], disabled=[f"{package}.plugin"])
    assert status(registry, package) == "disabled"
    with pytest.raises(UserError, match="Switch it on"):
        registry.modeler(f"{package}.modeler")
    assert package not in sys.modules
    assert registry.state_type(f"{package}.modeler") is None
    registry.set_disabled(f"{package}.plugin", False)
    assert registry.modeler(f"{package}.modeler")
    registry.set_disabled(f"{package}.plugin", True)
    with pytest.raises(UserError, match="Switch it on"):
        registry.modeler(f"{package}.modeler")
    assert f"{package}.modeler" not in [info.id for info in registry.modelers()]


def test_safe_mode_lists_and_uses_none():
    registry = Registry(no_plugins=True)
    assert {info.status for info in registry.plugins()} == {"disabled"}
    assert registry.modelers() == ()


def test_absent_modelers(make_package):
    registry = Registry(extra=[make_package(WORKING)])
    with pytest.raises(UserError, match=r"nobody\.nothing"):
        registry.modeler("nobody.nothing")
    with pytest.raises(UserError):
        registry.info("nobody.nothing")
    assert registry.state_type("nobody.nothing") is None
    assert registry.upgrade("nobody.nothing", {"a": 1}, 1) == {"a": 1}


def test_state_types_and_upgrades(make_package):
    package = make_package(WORKING)
    registry = Registry(extra=[package])
    state_type, version = registry.state_type(f"{package}.modeler")
    assert state_type.__name__ == "State"
    assert version == 3
    stored = {"number": 1}
    assert registry.upgrade(f"{package}.modeler", stored, 2) == {"number": 1, "from": 2}
    assert stored == {"number": 1}


def test_an_upgrade_may_change_the_stored_form_that_it_gets(make_package):
    body = 'state["number"] = state.pop("count"); state["rows"][0].append(2); return state'
    source = WORKING.replace('return {**state, "from": version}', body)
    package = make_package(source)
    registry = Registry(extra=[package])
    stored = {"count": 1, "rows": [[1]]}
    assert registry.upgrade(f"{package}.modeler", stored, 1) == {"number": 1, "rows": [[1, 2]]}
    assert status(registry, package) == "loaded"


@pytest.mark.parametrize("why", ["the contract", "switched off"])
def test_a_modeler_that_is_installed_and_cannot_be_used_says_why(make_package, why):
    api = ">=1,<2" if why == "the contract" else ">=2"
    package = make_package(
        WORKING,
        f'id = "{{author}}.plugin"\ntitle = "P"\nversion = "1"\napi = "{api}"\n[[modeler]]\n'
        'id = "{author}.modeler"\ntitle = "M"\nicon = "icon.svg"\nhint = "H"',
    )
    registry = Registry(extra=[package])
    (info,) = [one for one in registry.plugins() if one.package == package]
    registry.set_disabled(info.id, why == "switched off")
    with pytest.raises(UserError, match="switched off" if why == "switched off" else "written for"):
        registry.resolve("modeler")


def test_names_are_resolved(make_package):
    one, two = make_package(WORKING), make_package(WORKING)
    registry = Registry(extra=[one, two])
    assert registry.resolve("silhouette") == "bozzetto.silhouette"
    assert registry.resolve(f"{one}.modeler") == f"{one}.modeler"
    with pytest.raises(UserError, match=one):
        registry.resolve("modeler")
    with pytest.raises(UserError, match="nothing"):
        registry.resolve("nothing")


def test_many_threads_import_once(make_package):
    slow = "import time\ntime.sleep(0.1)\n" + WORKING
    package = make_package(slow)
    registry = Registry(extra=[package])
    found, start = [], threading.Barrier(8)

    def work():
        start.wait()
        found.append(registry.modeler(f"{package}.modeler"))

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 8
    assert len(set(map(id, found))) == 1


def test_lists_answer_while_a_plugin_is_imported(make_package):
    held = "import sys\nsys.importing.set()\nsys.release.wait(20)\n" + WORKING
    package = make_package(held)
    registry = Registry(extra=[package])
    sys.importing, sys.release = threading.Event(), threading.Event()
    try:
        thread = threading.Thread(target=registry.modeler, args=(f"{package}.modeler",))
        thread.start()
        assert sys.importing.wait(20)
        assert f"{package}.modeler" in [info.id for info in registry.modelers()]
        assert status(registry, package) == "ready"
        registry.add_package(make_package(WORKING))
        assert thread.is_alive()
    finally:
        sys.release.set()
        thread.join()
        del sys.importing, sys.release


def test_panel_only_where_announced(make_package, workshop, faulty):
    assert workshop.registry.panel("faulty.modeler", "parent", None) == ("faulty.modeler", "parent")
    package = make_package(WORKING)
    assert Registry(extra=[package]).panel(f"{package}.modeler", None, None) is None
