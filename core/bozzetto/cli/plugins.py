"""``bozzetto plugins``: list them, switch them on and off, check one, begin a new one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from bozzetto.cli.output import EXIT_ERROR, say_on_screen
from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.plugin.host.registry import PluginInfo

ACTIONS = ("list", "check", "enable", "disable", "new")
"""Actions of the command."""


def plugins(options: argparse.Namespace) -> int:
    """Do one of the `ACTIONS` and return the exit code."""
    if options.action == "list":
        _list()
        return 0
    if options.package is None:
        what = {"check": "package or file to check", "new": "id it gets, such as author.thing"}.get(
            options.action, "plugin is meant"
        )
        raise UserError(f"Say which {what}: bozzetto plugins {options.action} NAME.")
    if options.action == "check":
        return _check(options.package)
    if options.action == "new":
        return _new(options.package, options.license)
    _switch(options.package, options.action == "enable")
    return 0


def _new(plugin_id: str, license_name: str) -> int:
    from bozzetto.cli.new_plugin import LICENSES, new_plugin

    if license_name not in LICENSES:
        raise UserError(f"There is no licence {license_name!r}. Write {' or '.join(LICENSES)}.")
    made = new_plugin(plugin_id, Path.cwd(), license_name)
    print(f"{made.name} is written. Go on with:")
    print(f"    pip install -e './{made.name}[test]'")
    print(f"    bozzetto plugins check {made.name}")
    return 0


def _list() -> None:
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.host.switched_off import switched_off

    found = Registry(disabled=switched_off() or ()).plugins()
    for plugin in found:
        package = "" if plugin.package == plugin.id else f"  (package {plugin.package})"
        told = f"{plugin.id}  {plugin.version}  {plugin.status}  {plugin.summary}".rstrip()
        print(f"{told}{package}")
        for reason in (plugin.fault, *plugin.warnings):
            if reason:
                print(f"    {reason}")
    if not found:
        print("No plugin is installed.")


def _check(package: str) -> int:
    from bozzetto.testing.lint import check_file, findings_in

    path = Path(package)
    is_file = path.is_file()
    findings = []
    for finding in check_file(path) if is_file else findings_in(package, say_on_screen):
        findings.append(finding)
        print(finding, flush=True)
    if not any(finding.serious for finding in findings):
        fine = "the file is" if is_file else "manifest, files, import and contract are"
        print(f"{package}: {fine} in order{', but see above' if findings else ''}.")
    return EXIT_ERROR if any(finding.serious for finding in findings) else 0


def _switch(name: str, on: bool) -> None:
    """Switch a plugin on or off, for the window as well."""
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.host.switched_off import switch, switched_off

    off = switched_off() or frozenset()
    found = Registry(disabled=off).plugins()
    plugin = _named(name, found)
    if plugin is None and not (on and name in off):
        known = ", ".join(info.id for info in found) or "none"
        raise UserError(f"There is no plugin {name!r}; there are: {known}.")
    plugin_id = name if plugin is None else plugin.id
    switch(plugin_id, on)
    if not on:
        print(f"{plugin_id} is switched off. Its objects are kept as they are.")
    elif plugin is not None and plugin.fault:
        print(f"{plugin_id} is switched on, but cannot be used. {plugin.fault}")
    else:
        print(f"{plugin_id} is switched on.")


def _named(name: str, found: tuple[PluginInfo, ...]) -> PluginInfo | None:
    """Return the plugin that a person means: by its id, its package, or the last part of its id."""
    for meant in (
        [info for info in found if info.id == name],
        [info for info in found if info.package == name],
        [info for info in found if info.id.rpartition(".")[2] == name],
    ):
        if len(meant) == 1:
            return meant[0]
    return None
