"""The registry: which plugins there are, and their modelers on first use.

The lists come from manifests alone; a plugin's code is imported when one of its modelers
is first asked for. Plugins are found, imported and called one by one, because one raising
implementation aborts a whole pluggy call, and pluggy's own discovery stops at the first
package that cannot be imported.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Final

import msgspec
from msgspec.structs import asdict, replace

from bozzetto.errors import DocumentError, UserError, words_of
from bozzetto.plugin import API_VERSION
from bozzetto.plugin.guard.guard import Guard, PluginFault
from bozzetto.plugin.host.entry_points import announced
from bozzetto.plugin.host.listing import (
    ModelerInfo,
    PluginInfo,
    Standing,
    Status,
    TemplateFile,
)
from bozzetto.plugin.host.loading import ask, check_modelers, import_plugin
from bozzetto.plugin.host.manifest import (
    Manifest,
    ManifestError,
    api_accepts,
    find_folder,
    read_manifest,
)

if TYPE_CHECKING:
    import pluggy

    from bozzetto.plugin.guard.guarded_modeler import GuardedModeler
    from bozzetto.plugin.modeler import Modeler
    from bozzetto.plugin.panel import PanelHost

__all__ = ["GROUP", "ModelerInfo", "PluginInfo", "Registry"]

GROUP: Final = "bozzetto.plugins"
"""Entry-point group; the value is the package that holds plugin.toml."""


class _Plugin(msgspec.Struct, eq=False):
    """One plugin, with its manifest and, once imported, its modelers."""

    package: str
    folder: Path = Path()
    manifest: Manifest | None = None
    fault: str = ""
    details: str = ""
    infos: tuple[ModelerInfo, ...] = ()
    modelers: dict[str, Modeler[Any, Any]] | None = None
    id_taken: bool = False
    loading: threading.Lock = msgspec.field(default_factory=threading.Lock)

    @property
    def id(self) -> str:
        return self.manifest.id if self.manifest and not self.id_taken else self.package

    @property
    def name(self) -> str:
        """Its title and its id, for messages: by the id it is switched off from a terminal."""
        return f"“{self.manifest.title}” ({self.id})" if self.manifest else self.id

    def info(self, modeler_id: str) -> ModelerInfo | None:
        return next((info for info in self.infos if info.id == modeler_id), None)


class Registry:
    """The plugins of this session.

    Parameters
    ----------
    disabled : iterable of str
        Ids of plugins that are listed but never imported.
    no_plugins : bool
        Safe mode: all that are installed count as disabled.
    extra : iterable of str
        Packages to take in beside the installed ones, such as one under development.

    Attributes
    ----------
    guard : Guard
        Every call into a modeler goes through it.

    Notes
    -----
    All methods may be called from any thread. Only `modeler` and what builds on it may
    take long, as they import.
    """

    def __init__(
        self,
        *,
        disabled: Iterable[str] = (),
        no_plugins: bool = False,
        extra: Iterable[str] = (),
    ) -> None:
        self.guard = Guard(self._plugin_of, self._name_of)
        self._disabled = set(disabled)
        self._plugins: dict[str, _Plugin] = {}
        self._lock = threading.RLock()
        self._manager: pluggy.PluginManager | None = None
        for package in _installed():
            info = self.add_package(package)
            if no_plugins:
                self._disabled.add(info.id)
        for package in extra:
            self.add_package(package)

    def _hooks(self) -> pluggy.PluginManager:
        """Return the hooks of all plugins; they are made when the first one is asked for."""
        import pluggy

        from bozzetto.plugin import hooks

        with self._lock:
            if self._manager is None:
                self._manager = pluggy.PluginManager(hooks.PROJECT)
                self._manager.add_hookspecs(hooks)
            return self._manager

    # -- the lists, from manifests alone ------------------------------------------------------

    def add_package(self, package: str) -> PluginInfo:
        """Take in a package by its import name, without importing it.

        A package that is known already stays as it is.
        """
        with self._lock:
            if package not in self._plugins:
                plugin = _Plugin(package)
                try:
                    plugin.folder = find_folder(package)
                    plugin.manifest = read_manifest(plugin.folder)
                    self._look_over(plugin, plugin.manifest)
                    plugin.infos = tuple(_modeler_infos(plugin))
                except ManifestError as problem:
                    plugin.fault = problem.message
                except Exception as problem:
                    # Finding a package runs other people's import hooks.
                    plugin.fault = f"{package} cannot be found: {words_of(problem)}."
                    plugin.details = traceback.format_exc()
                self._plugins[package] = plugin
            return self._info(self._plugins[package])

    def plugins(self) -> tuple[PluginInfo, ...]:
        """Return all plugins, by their ids, broken and disabled ones too."""
        with self._lock:
            infos = [self._info(plugin) for plugin in self._plugins.values()]
        return tuple(sorted(infos, key=lambda info: (info.id, info.package)))

    def modelers(self) -> tuple[ModelerInfo, ...]:
        """Return the modelers of all plugins neither broken nor disabled, in their order."""
        with self._lock:
            infos = [
                info
                for plugin in self._plugins.values()
                if not plugin.fault and plugin.id not in self._disabled
                for info in plugin.infos
            ]
        return tuple(sorted(infos, key=lambda info: (info.order, info.title, info.id)))

    def templates(self, modeler_id: str) -> tuple[TemplateFile, ...]:
        """Return the templates that plugins neither broken nor disabled bring for a modeler."""
        with self._lock:
            row = [
                TemplateFile(plugin.id, plugin.name, plugin.folder / file)
                for plugin in self._plugins.values()
                if plugin.manifest and not plugin.fault and plugin.id not in self._disabled
                for file in plugin.manifest.templates.get(modeler_id, ())
            ]
        return tuple(sorted(row, key=lambda file: file.name))

    def info(self, modeler_id: str) -> ModelerInfo:
        """Return what a manifest says about a modeler.

        Raises
        ------
        UserError
            If no plugin announces it.
        """
        return self._find(modeler_id)[1]

    def resolve(self, name: str) -> str:
        """Return the id of the modeler that a person means: its id, or the last part of it.

        Raises
        ------
        UserError
            If there is none, or several.
        """
        ids = [info.id for info in self.modelers()]
        if name in ids:
            return name
        found = [known for known in ids if known.rpartition(".")[2] == name]
        if len(found) == 1:
            return found[0]
        if found:
            raise UserError(f"{name!r} can be {' or '.join(found)}. Write out which.")
        with self._lock:
            announced = [info.id for plugin in self._plugins.values() for info in plugin.infos]
        for known in announced:
            if name in (known, known.rpartition(".")[2]):
                self.modeler(known)  # says why it cannot be used
        raise self._absent(name)

    def told_by(self, facts: Mapping[str, object]) -> str:
        """Return the modeler that reads files with such facts; "" for none, or several."""
        ids = [info.id for info in self.modelers() if any(key in facts for key in info.facts)]
        return ids[0] if len(ids) == 1 else ""

    def standing(self, modeler_id: str) -> Standing:
        """Whether a modeler can be used now, told without importing anything."""
        with self._lock:
            for plugin in self._plugins.values():
                if plugin.info(modeler_id):
                    return Standing(self._info(plugin).status, plugin.id)
        return Standing("absent")

    def plugin_at(self, files: Iterable[str]) -> PluginInfo | None:
        """Return the plugin that a traceback leads to: the first whose package has a file of it.

        Parameters
        ----------
        files : iterable of str
            Source files, those of the innermost calls first.

        Returns
        -------
        PluginInfo or None
            None where all files are others', or the plugin is switched off already.
        """
        with self._lock:
            infos = {
                plugin.folder: self._info(plugin)
                for plugin in self._plugins.values()
                if plugin.folder != Path()
            }
        for file in files:
            for folder in PurePath(file).parents:
                if info := infos.get(Path(folder)):
                    return info if info.status != "disabled" else None
        return None

    def set_disabled(self, plugin_id: str, disabled: bool) -> None:
        """Switch a plugin off or on again. One that is imported stays so, but is not called."""
        with self._lock:
            (self._disabled.add if disabled else self._disabled.discard)(plugin_id)

    # -- modelers, imported on first use ----------------------------------------------------------

    def modeler(self, modeler_id: str) -> Modeler[Any, Any]:
        """Return a modeler, imported and ready to work.

        Raises
        ------
        UserError
            If it is not installed, disabled or broken; says what to do.
        """
        plugin, _ = self._find(modeler_id)
        if plugin.id in self._disabled:
            raise UserError(
                f"The plugin {plugin.name} is switched off. Switch it on in the list of plugins: "
                f"Help › Plugins, or “bozzetto plugins enable {plugin.id}”."
            )
        self.guard.refuse_if_off(plugin.id)
        with plugin.loading:
            if plugin.modelers is None and not plugin.fault:
                self._load(plugin)
        if plugin.modelers is None:
            raise UserError(
                f"The plugin {plugin.name} cannot be used. {plugin.fault} "
                "Update or remove it, or tell its author."
            )
        return plugin.modelers[modeler_id]

    def guarded(self, modeler_id: str) -> GuardedModeler:
        """Return a modeler of which every call passes the guard and every answer is checked.

        Raises
        ------
        UserError
            As `modeler`.
        """
        from bozzetto.plugin.guard.guarded_modeler import GuardedModeler  # it imports numpy

        return GuardedModeler(self.guard, self.modeler(modeler_id))

    def state_type(self, modeler_id: str) -> tuple[type[Any], int] | None:
        """Return type and version of a modeler's states; None where the modeler is unavailable."""
        try:
            modeler = self.modeler(modeler_id)
        except UserError:
            return None
        return modeler.state_type, modeler.state_version

    def upgrade(self, modeler_id: str, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Return the stored form of an older state in today's shape; unchanged if nobody knows it.

        The stored form becomes the plugin's own, which may change what is in it.

        Raises
        ------
        UserError, PluginFault
            If the modeler is there and cannot upgrade the state.
        """
        try:
            modeler = self.modeler(modeler_id)
        except UserError:
            return state
        upgraded = self.guard.call(
            modeler_id, "upgrade", lambda version: modeler.upgrade(dict(state), version), version
        )
        if not isinstance(upgraded, dict):
            raise self.guard.blame(
                modeler_id, f"upgrade gave {type(upgraded).__name__} where a dict belongs"
            )
        return upgraded

    def sources(self, modeler_id: str, state: Any) -> tuple[str, ...]:
        """Return the ids of the models that a state is made from.

        Raises
        ------
        DocumentError
            If the modeler fails over it.
        """
        try:
            return self.guarded(modeler_id).sources(state)
        except (UserError, PluginFault) as problem:
            raise DocumentError(str(problem)) from problem

    def panel(self, modeler_id: str, parent: object, host: PanelHost) -> object | None:
        """Return the plugin's own widget for a modeler, or None.

        Raises
        ------
        UserError
            As `modeler`.
        PluginFault
            If making it fails.
        """
        plugin, info = self._find(modeler_id)
        if "panel" not in info.abilities:
            return None
        self.modeler(modeler_id)
        made = self.guard.call(
            modeler_id,
            "bozzetto_panel",
            lambda: ask(
                self._hooks(),
                plugin.id,
                "bozzetto_panel",
                modeler_id=modeler_id,
                parent=parent,
                host=host,
            ),
        )
        return made[0] if made else None

    def faults_in(self, file: Path) -> list[str] | None:
        """Return the faults of a file of a plugin's own kind; None if no plugin knows its kind.

        Raises
        ------
        PluginFault
            If a plugin fails over it.
        """
        with self._lock:
            manifests = {plugin.id: plugin.manifest for plugin in self._plugins.values()}
        for plugin_id, said in manifests.items():
            if said is None or not said.checks_files or not said.modelers:
                continue
            modeler_id = said.modelers[0].id
            self.modeler(modeler_id)
            told = self.guard.call(
                modeler_id,
                "bozzetto_faults",
                partial(ask, self._hooks(), plugin_id, "bozzetto_faults", file=file),
            )
            if told:
                return [str(fault) for fault in told[0]]
        return None

    # -- inside ------------------------------------------------------------------------------------

    def _find(self, modeler_id: str) -> tuple[_Plugin, ModelerInfo]:
        """Find the plugin that announces a modeler, and what it says of it."""
        with self._lock:
            for plugin in self._plugins.values():
                if info := plugin.info(modeler_id):
                    return plugin, info
        raise self._absent(modeler_id)

    def _absent(self, name: str) -> UserError:
        known = ", ".join(info.id for info in self.modelers()) or "none"
        return UserError(
            f"No plugin in use has the modeler {name!r}. Install its plugin, or choose one of "
            f"these: {known}."
        )

    def _plugin_of(self, modeler_id: str) -> str:
        with self._lock:
            for plugin in self._plugins.values():
                if plugin.info(modeler_id):
                    return plugin.id
        return modeler_id

    def _name_of(self, plugin_id: str) -> str:
        with self._lock:
            named = (plugin.name for plugin in self._plugins.values() if plugin.id == plugin_id)
            return next(named, plugin_id)

    def _look_over(self, plugin: _Plugin, said: Manifest) -> None:
        """Refuse what is written for another program version, or taken by another plugin."""
        if not api_accepts(said.api, API_VERSION):
            plugin.fault = (
                f"It was written for version {said.api} of the plugin contract and this is "
                f"{API_VERSION[0]}.{API_VERSION[1]}. Update the plugin or the program."
            )
        ids = {entry.id for entry in said.modelers}
        for other in self._plugins.values():
            if other.manifest is None:
                continue
            doubles = ids & {entry.id for entry in other.manifest.modelers}
            if other.id == said.id or doubles:
                taken = f"modeler {min(doubles)}" if doubles else f"id {said.id}"
                plugin.fault = (
                    f"The {taken} is already taken by the package {other.package}. "
                    f"Remove {other.package} or {plugin.package}."
                )
                # Switching one of two plugins off must not switch the other off as well.
                plugin.id_taken = plugin.id_taken or other.id == said.id
                # Its modelers are the other's: they must not be found under this name.
                plugin.manifest = replace(said, modelers=())

    def _load(self, plugin: _Plugin) -> None:
        """Import a plugin; whatever goes wrong becomes its fault."""
        entries = plugin.manifest.modelers if plugin.manifest else ()

        def work() -> dict[str, Modeler[Any, Any]]:
            import_plugin(self._hooks(), plugin.package, plugin.id)
            told = ask(self._hooks(), plugin.id, "bozzetto_modelers")
            return check_modelers(told, {entry.id: entry.abilities for entry in entries})

        try:
            plugin.modelers = self.guard.call(entries[0].id, "its import", work)
        except UserError as problem:
            plugin.fault = problem.message
        except PluginFault as problem:
            plugin.fault = f"{problem.what[:1].upper()}{problem.what[1:]}."
            plugin.details = problem.details

    def _info(self, plugin: _Plugin) -> PluginInfo:
        said = plugin.manifest
        status: Status = "ready" if plugin.modelers is None else "loaded"
        fault = plugin.fault
        if self.guard.is_off(plugin.id) and not fault:
            fault = "It failed several times and is switched off until the next start."
        if plugin.id in self._disabled:
            status = "disabled"
        elif fault:
            status = "broken"
        return PluginInfo(
            plugin.id,
            said.title if said else plugin.package,
            said.summary if said else "",
            said.version if said else "",
            plugin.package,
            status,
            fault,
            plugin.details,
            said.warnings if said else (),
        )


def _modeler_infos(plugin: _Plugin) -> Iterator[ModelerInfo]:
    for entry in plugin.manifest.modelers if plugin.manifest else ():
        yield ModelerInfo(
            **asdict(entry)
            | {
                "plugin": plugin.id,
                "folder": plugin.folder,
                "icon": plugin.folder / entry.icon,
                "samples": tuple(plugin.folder / sample.file for sample in entry.samples),
                "sample_titles": tuple(sample.title for sample in entry.samples),
            }
        )


def _installed() -> list[str]:
    """Return the packages that distributions announce, in an order that does not change.

    The bundled ones come first, so that a third party's cannot take their ids.
    """
    packages = {value.partition(":")[0].strip() for value in announced(GROUP)}
    return sorted(packages, key=lambda package: (not package.startswith("bozzetto_"), package))
