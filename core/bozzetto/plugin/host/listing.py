"""Descriptions of plugins and modelers, known before any of their code runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import msgspec

Status = Literal["ready", "loaded", "disabled", "broken"]


class PluginInfo(msgspec.Struct, frozen=True):
    """A plugin in the list.

    Attributes
    ----------
    id : str
        From its manifest; the package's name where that cannot be read, or another package has
        the id already. No two plugins of a list have the same.
    title, summary, version : str
    package : str
    status : {"ready", "loaded", "disabled", "broken"}
        "ready" plugins are imported on first use.
    fault : str
        Why it is broken, in one sentence; else "".
    details : str
        The traceback behind that, where there is one.
    warnings : tuple of str
        What in its manifest was ignored.
    """

    id: str
    title: str
    summary: str
    version: str
    package: str
    status: Status
    fault: str = ""
    details: str = ""
    warnings: tuple[str, ...] = ()


class TemplateFile(msgspec.Struct, frozen=True):
    """A file with which models of a modeler can begin, as a plugin brings it; nobody has read it.

    Attributes
    ----------
    plugin : str
        Id of the plugin.
    plugin_name : str
        Its title and id, for messages.
    path : Path
        The file; it need not be there.
    """

    plugin: str
    plugin_name: str
    path: Path

    @property
    def name(self) -> str:
        """Its name in files: id of the plugin, and name of the file without its ending."""
        return f"{self.plugin}/{self.path.stem}"


class Standing(msgspec.Struct, frozen=True):
    """Whether a modeler can be used now.

    Attributes
    ----------
    status : {"ready", "loaded", "disabled", "broken", "absent"}
        Status of its plugin; "absent" where none has it.
    plugin : str
        Id of the plugin; "" where it is absent.
    """

    status: Status | Literal["absent"]
    plugin: str = ""


class ModelerInfo(msgspec.Struct, frozen=True):
    """A modeler as its manifest announces it.

    Attributes
    ----------
    id, title, hint : str
    plugin : str
        Id of its plugin.
    folder : Path
        The plugin's package; icons of tools are relative to it.
    icon : Path
        SVG file.
    samples : tuple of Path
        Ink files.
    sample_titles : tuple of str
        Their names for people.
    abilities : frozenset of str
        See `ModelerEntry`.
    listed : bool
        Whether a person can choose it.
    order : int
        Place in the row of modelers, small first.
    facts : tuple of str
        The keys by which its files are told from others.
    sides : mapping of str to str
        Its own names of sides, and the world's for each; see `ModelerEntry`.
    replaces : bool
        Whether what it follows is hidden when it begins.
    """

    id: str
    title: str
    hint: str
    plugin: str
    folder: Path
    icon: Path
    samples: tuple[Path, ...] = ()
    sample_titles: tuple[str, ...] = ()
    abilities: frozenset[str] = frozenset()
    listed: bool = True
    order: int = 50
    facts: tuple[str, ...] = ()
    sides: Mapping[str, str] = {}
    replaces: bool = False
