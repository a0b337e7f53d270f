"""``bozzetto plugins new``: a complete plugin to begin with."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Iterator
from datetime import date
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Final

from bozzetto.atomic_files import write_bytes
from bozzetto.errors import UserError
from bozzetto.plugin.host.manifest import ID_IN_WORDS, ID_PATTERN

LICENSES: Final = {
    "MIT": """MIT License

Copyright (c) {{year}} the authors of {{distribution}}

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and
associated documentation files (the "Software"), to deal in the Software without restriction,
including without limitation the rights to use, copy, modify, merge, publish, distribute,
sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or
substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT
NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM,
DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT
OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
""",
    "none": "",
}
"""Texts of licences by their SPDX names; "none" leaves the choice for later."""

TEMPLATE: Final = "plugin_template"
ENDING: Final = ".txt"
"""Files of the template have it behind their names: they are no modules of the program."""

LONGEST_ID: Final = 80


def new_plugin(plugin_id: str, folder: Path, license_name: str) -> Path:
    """Write a complete plugin that passes ``bozzetto plugins check`` and ``mypy --strict``.

    Parameters
    ----------
    plugin_id : str
        "author.thing"; its last part names the package, ``bozzetto_thing``.
    folder : Path
        Where the folder of the package is made.
    license_name : str
        One of `LICENSES`.

    Returns
    -------
    Path
        The folder that was made.

    Raises
    ------
    UserError
        If the id is none, the name is taken, the folder is there already, or it cannot be written.
    """
    words = _words(plugin_id)
    made = folder / words["package"]
    if made.exists():
        raise UserError(f"{made} is there already. Remove it, or take another name.")
    if importlib.util.find_spec(words["package"]) is not None:
        raise UserError(f"A package {words['package']} is installed already. Take another name.")
    words["license_field"] = "" if license_name == "none" else f'license = "{license_name}"\n'
    written = dict(_filled(files("bozzetto.cli") / TEMPLATE, words))
    if license_name != "none":
        written["LICENSE"] = _fill(LICENSES[license_name], words)
    for name, text in written.items():
        path = made / name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            raise UserError(
                f"The folder {path.parent} cannot be made: {problem.strerror}. Write elsewhere."
            ) from None
        write_bytes(path, text.encode())
    return made


def _words(plugin_id: str) -> dict[str, str]:
    """Return what stands for the placeholders of the template."""
    if not re.fullmatch(ID_PATTERN, plugin_id) or len(plugin_id) > LONGEST_ID:
        raise UserError(f"{plugin_id!r} is no id for a plugin. Write {ID_IN_WORDS}.")
    thing = plugin_id.rpartition(".")[2]
    parts = [part for part in thing.split("_") if part]
    return {
        "id": plugin_id,
        "thing": thing,
        "package": f"bozzetto_{thing}",
        "distribution": "-".join(("bozzetto", *parts)),
        "Title": " ".join(parts).capitalize(),
        "Class": "".join(part.capitalize() for part in parts),
        "year": str(date.today().year),
    }


def _filled(
    folder: Traversable, words: dict[str, str], within: str = ""
) -> Iterator[tuple[str, str]]:
    """Yield every file of the template by its name in the package."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        name = words["package"] if entry.name == "package" else entry.name
        name = name.replace("thing", words["thing"])
        if entry.is_dir():
            yield from _filled(entry, words, f"{within}{name}/")
        elif name.endswith(ENDING):
            text = _fill(entry.read_text(encoding="utf-8"), words)
            yield f"{within}{name.removesuffix(ENDING)}", text


def _fill(text: str, words: dict[str, str]) -> str:
    return re.sub(r"\{\{(\w+)\}\}", lambda found: words[found[1]], text)
