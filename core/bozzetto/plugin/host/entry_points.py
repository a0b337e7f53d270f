"""Packages that installed distributions announce, read from their ``entry_points.txt``.

`importlib.metadata` says the same, and is asked where a distribution may lie in anything but a
folder; but it imports the reader of e-mail headers, which takes as long as all plugins' manifests.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from importlib.machinery import PathFinder

ENDINGS = (".dist-info", ".egg-info")
"""Of folders that tell of a distribution."""


def announced(group: str) -> set[str]:
    """Return the objects that distributions announce in a group, such as "package:thing".

    Of two distributions with one name the first one on the path counts, as it does for imports.
    """
    if not _all_folders():
        from importlib.metadata import entry_points

        return {entry.value for entry in entry_points(group=group)}
    values: set[str] = set()
    names: set[str] = set()
    for folder in dict.fromkeys(sys.path):
        for name, text in _told_in(folder or "."):
            if name not in names:
                names.add(name)
                values.update(_values(text, group))
    return values


def _all_folders() -> bool:
    """Whether distributions can lie in folders only: no archives, no finders of others."""
    others = (finder for finder in sys.meta_path if finder is not PathFinder)
    return not any(hasattr(finder, "find_distributions") for finder in others) and not any(
        os.path.isfile(place) for place in sys.path if not place.endswith(f"{os.sep}{_STDLIB_ZIP}")
    )


_STDLIB_ZIP = f"python{sys.version_info.major}{sys.version_info.minor}.zip"
"""Archive of the standard library, which stands on every path and announces nothing."""


def _told_in(folder: str) -> Iterator[tuple[str, str]]:
    """Yield names and entry points of the distributions in a folder; "" of one that has none."""
    try:
        with os.scandir(folder) as found:
            entries = [entry for entry in found if entry.name.endswith(ENDINGS)]
    except OSError:
        return
    for entry in entries:
        name = entry.name.rpartition(".")[0].partition("-")[0]
        try:
            with open(os.path.join(entry.path, "entry_points.txt"), encoding="utf-8") as file:
                text = file.read()
        except (OSError, UnicodeDecodeError):
            text = ""
        yield name.lower().replace("-", "_").replace(".", "_"), text


def _values(text: str, group: str) -> Iterator[str]:
    """Yield the values of a group of an INI text."""
    inside = False
    for line in map(str.strip, text.splitlines()):
        if line.startswith("["):
            inside = line.strip("[] ") == group
        elif inside and "=" in line and not line.startswith(("#", ";")):
            yield line.partition("=")[2].strip()
