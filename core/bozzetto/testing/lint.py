"""``bozzetto plugins check``: faults of a plugin that its author should know first."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from bozzetto.errors import FormatError, Unfinished, UserError
from bozzetto.exchange.safe_xml import parse_xml
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.manifest import Manifest, ManifestError, find_folder, read_manifest
from bozzetto.plugin.host.registry import Registry

LARGEST_ICON = 64 * 1024
"""Bytes; an icon is a few strokes."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or could be better.

    Attributes
    ----------
    serious : bool
        Whether the plugin cannot be used like this.
    where : str
        File, modeler or article of the contract.
    message : str
    """

    serious: bool
    where: str
    message: str

    def __str__(self) -> str:
        return f"{'error' if self.serious else 'note'}: {self.where}: {self.message}"


def _nobody(_: str) -> None:
    pass


def check_package(package: str, begins: Callable[[str], None] = _nobody) -> list[Finding]:
    """Check a plugin, and return all that is to be said of it; see `findings_in`."""
    return list(findings_in(package, begins))


def findings_in(package: str, begins: Callable[[str], None] = _nobody) -> Iterator[Finding]:
    """Check a plugin: manifest, icons, templates, import, hooks, modelers, and the whole contract.

    Parameters
    ----------
    package : str
        Import name; it need not be installed with an entry point. The id of an installed
        plugin does as well.
    begins : callable
        Told what is tried next, such as "author.thing, ranges (13 of 26)": some of it takes minutes
        where a solve takes a second.

    Yields
    ------
    Finding
        Those of each modeler once it was tried: who stops waiting has what was found until then.
    """
    ids = {known.id: known.package for known in Registry().plugins()}
    package = ids.get(package, package)
    try:
        folder = find_folder(package)
        manifest = read_manifest(folder)
    except ManifestError as problem:
        yield Finding(True, package, problem.message)
        return
    for warning in manifest.warnings:
        yield Finding(False, package, warning)
    yield from _check_icons(folder, [entry.icon for entry in manifest.modelers])
    registry = Registry(extra=(package,))
    info = registry.add_package(package)
    if info.status == "broken":
        yield Finding(True, manifest.id, info.fault)
        return
    yield from _check_templates(registry, folder, manifest)
    if not manifest.modelers:
        return
    with suppress(UserError, PluginFault):  # told below, of each modeler
        registry.modeler(manifest.modelers[0].id)
    yield from _check_classes(package)
    if package in sys.modules:  # else its import failed, and all else follows from that
        yield from _check_hooks(package, manifest)
    for entry in manifest.modelers:
        yield from _check_modeler(package, entry.id, begins)


def check_file(path: Path) -> list[Finding]:
    """Check a file that a plugin reads besides drawings, such as a template.

    Raises
    ------
    UserError
        If no plugin knows files of this kind.
    """
    faults = Registry().faults_in(path)
    if faults is None:
        raise UserError(
            f"No plugin knows the kind of file that {path.name} is. Check its format, or give the "
            "name of a package."
        )
    return [Finding(True, path.name, fault) for fault in faults]


def _check_icons(folder: Path, icons: Iterable[str]) -> list[Finding]:
    told = {icon: icon_fault(folder / icon) for icon in icons}
    return [Finding(True, icon, fault) for icon, fault in sorted(told.items()) if fault]


def icon_fault(path: Path) -> str:
    """Return the fault of an icon, or "".

    An icon must be an SVG without scripts, entities, event handlers and outside content:
    it is drawn wherever the list of modelers is, before its plugin is trusted to run.
    """
    if not path.is_file():
        return "this icon is missing"
    content = path.read_bytes()
    if len(content) > LARGEST_ICON:
        return f"an icon has at most {LARGEST_ICON} bytes"
    try:
        root = parse_xml(content)
    except FormatError as problem:
        return f"not an SVG file: {problem.message}"
    if root.tag != "svg":
        return f"its first element is <{root.tag}> and not <svg>"
    found = ["<!DOCTYPE>"] if b"<!DOCTYPE" in content else []
    waiting = [root]
    while waiting:
        element = waiting.pop(0)
        waiting[:0] = element.children
        if element.tag.lower() in ("script", "foreignobject", "image", "style"):
            found.append(f"<{element.tag}>")
        for key, value in element.attributes.items():
            name = key.rpartition(" ")[2]
            outside = name == "href" and not value.startswith("#")
            if name.lower().startswith("on") or outside or "url(http" in value.lower():
                found.append(name)
    return f"an icon must not contain {', '.join(found)}" if found else ""


def _check_templates(registry: Registry, folder: Path, manifest: Manifest) -> list[Finding]:
    """Return what is wrong with templates, as the plugins say whose modelers these are for."""
    findings = []
    for modeler_id, files in manifest.templates.items():
        absent = registry.standing(modeler_id).status == "absent"
        if absent:
            told = f"no plugin here has this modeler, and {', '.join(files)} could not be checked"
            findings.append(Finding(False, modeler_id, told))
        for file in files:
            if not (folder / file).is_file():
                findings.append(Finding(True, file, "this template is missing"))
            elif not absent:
                findings += _template_faults(registry, folder / file, file)
    return findings


def _template_faults(registry: Registry, path: Path, file: str) -> list[Finding]:
    try:
        faults = registry.faults_in(path)
    except (UserError, PluginFault) as problem:
        faults = [str(problem)]
    if faults is None:
        faults = ["no plugin knows this kind of file"]
    return [Finding(True, file, fault) for fault in faults]


def _check_classes(package: str) -> list[Finding]:
    """Return what is misspelt in the classes that the import of a package has made so far."""
    from bozzetto.testing.spelling import class_faults, derived_classes

    kinds = derived_classes(package)
    return [Finding(True, package, fault) for kind in kinds for fault in class_faults(kind)]


def _check_hooks(package: str, manifest: Manifest) -> list[Finding]:
    """Return hooks that the manifest announces and the package lacks, and the reverse."""
    abilities = {ability for entry in manifest.modelers for ability in entry.abilities}
    announced = {
        "bozzetto_panel": ("panel" in abilities, 'abilities = ["panel"]'),
        "bozzetto_faults": (manifest.checks_files, "checks_files = true"),
    }
    findings = []
    for hook, (is_announced, key) in announced.items():
        there = hasattr(sys.modules.get(package), hook)
        if is_announced and not there:
            told = f"the manifest says {key}, and the package has no hook {hook}"
            findings.append(Finding(True, manifest.id, told))
        if there and not is_announced:
            told = f"the package has the hook {hook}, and the manifest does not say {key}"
            findings.append(Finding(True, manifest.id, told))
    return findings


def _check_modeler(package: str, modeler_id: str, begins: Callable[[str], None]) -> list[Finding]:
    from bozzetto.testing.call_watch import CallWatch, Unanswered
    from bozzetto.testing.checks import CHECKS
    from bozzetto.testing.spelling import check_spelling
    from bozzetto.testing.subject import Subject

    registry = Registry(extra=(package,))
    info = registry.info(modeler_id)
    folder = info.folder
    try:
        tools = registry.guarded(modeler_id).tools()
    except (UserError, PluginFault) as problem:
        plugin = next(known for known in registry.plugins() if known.id == info.plugin)
        told = _with_place(problem, folder)
        if plugin.fault:
            told = _placed(plugin.fault, plugin.details, folder)
        return [Finding(True, modeler_id, told)]
    looked_at = info.icon.relative_to(folder).as_posix()
    icons = {tool.icon for tool in tools if tool.icon} - {looked_at}
    findings = _check_icons(folder, icons)
    watch = CallWatch()
    subject = Subject(modeler_id, (package,), opened=watch.add)
    told_by: dict[tuple[bool, str], list[str]] = {}
    for number, check in enumerate(CHECKS, start=1):
        if check.run is check_spelling and _check_classes(package):
            continue  # told already
        begins(f"{modeler_id}, {check.name} ({number} of {len(CHECKS)})")
        try:
            watch.run(partial(check.run, subject))
        except Unanswered as problem:
            rest = [each.name for each in CHECKS[number:]]
            told = f"{problem.message}; {len(rest)} more checks were not tried"
            told_by.setdefault((True, _placed(told, problem.details, folder)), []).append(
                check.name
            )
            break
        except (UserError, Unfinished) as problem:
            told = f"could not be tried with a plain drawing ({problem}); use ModelerContract"
            told_by.setdefault((False, told), []).append(check.name)
        except (AssertionError, PluginFault) as problem:
            told = _with_place(problem, folder)
            told_by.setdefault((True, told), []).append(check.name)
    return findings + [
        Finding(serious, f"{modeler_id}, {_few(names)}", told)
        for (serious, told), names in told_by.items()
    ]


def _few(names: list[str]) -> str:
    """Return the first two names, and how many more there are."""
    return ", ".join(names[:2]) + (f" and {len(names) - 2} more" if len(names) > 2 else "")


def _with_place(problem: BaseException, folder: Path) -> str:
    """Return the message of a problem, and the line of the plugin where it arose.

    A fault is told in its own words whatever check met it, so that the same fault is told once.
    """
    fault = problem if isinstance(problem, PluginFault) else problem.__cause__
    if not isinstance(fault, PluginFault):
        return str(problem)
    return _placed(str(fault), fault.details, folder)


def _placed(told: str, traceback: str, folder: Path) -> str:
    """Return a sentence with the last line of the plugin in a traceback, if there is one."""
    frames = re.findall(r'File "([^"]+)", line (\d+)', traceback)
    own = [(path, line) for path, line in frames if Path(path).is_relative_to(folder)]
    return f"{told} ({own[-1][0]}, line {own[-1][1]})" if own else told
