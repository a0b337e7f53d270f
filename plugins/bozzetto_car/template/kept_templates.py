"""Templates to begin cars with that are not bundled: a person's own, and those of plugins.

A person keeps theirs in a folder.

Each is an ordinary template file (``bozzetto-car-template/1``), so it can be copied to other
machines, imported and named by marks files as well. What cannot be read is passed over, for the
folder is the person's.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

from bozzetto.errors import UserError
from bozzetto.plugin import TemplateFile
from bozzetto_car.template.loader import read_template
from bozzetto_car.template.model import Template
from bozzetto_car.template.schema import LARGEST_FILE

ENDING: Final = ".json"

MOST_KEPT: Final = 60
"""Most templates that are offered, the first ones by their names."""

MOST_ALIKE: Final = 1000
"""Most files with names that differ by a number only."""


@dataclass(frozen=True, eq=False)
class KeptTemplate:
    """A template that a person keeps.

    Attributes
    ----------
    path : Path
    source : str
        Its file.
    template : Template
    """

    path: Path
    source: str
    template: Template


def kept_templates(folder: Path) -> tuple[KeptTemplate, ...]:
    """Return the templates in a folder by their file names; none where there is no folder."""
    found: list[KeptTemplate] = []
    try:
        paths = sorted(path for path in folder.iterdir() if path.suffix.lower() == ENDING)
    except OSError:
        return ()
    for path in paths:
        if len(found) == MOST_KEPT:
            break
        try:
            if path.stat().st_size <= LARGEST_FILE:
                source = path.read_text("utf-8")
                found.append(KeptTemplate(path, source, _read(source)))
        except (OSError, UnicodeDecodeError, UserError):
            continue
    return tuple(found)


@lru_cache(maxsize=MOST_KEPT)
def _read(source: str) -> Template:
    return read_template(source.encode())


def plugin_template(file: TemplateFile) -> KeptTemplate:
    """Return a template that a plugin brings.

    Raises
    ------
    UserError
        If it cannot be used; the message names the plugin.
    """
    try:
        if file.path.stat().st_size > LARGEST_FILE:
            raise UserError(f"It is larger than {LARGEST_FILE} bytes.")
        source = file.path.read_text("utf-8")
        return KeptTemplate(file.path, source, _read(source))
    except OSError as problem:
        why = f"It cannot be read: {problem.strerror}."
    except UnicodeDecodeError:
        why = "It is no text in UTF-8."
    except UserError as problem:
        why = problem.message
    raise UserError(
        f"The template {file.path.name} of the plugin {file.plugin_name} is left out. {why} Tell "
        "its author; all other templates are there."
    )


def keep_template(folder: Path, content: bytes) -> Path:
    """Add a template to those that are kept; none of the others is written over.

    Parameters
    ----------
    folder : Path
        Where they are; it is made if it is missing.
    content : bytes
        File of the template.

    Returns
    -------
    Path
        Its file, which is called like the id of the template.

    Raises
    ------
    UserError
        If it cannot be read as a template, or cannot be written.
    """
    template = read_template(content)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for number in range(1, MOST_ALIKE):
            path = folder / f"{template.id}{f'_{number}' if number > 1 else ''}{ENDING}"
            with suppress(FileExistsError):
                _write_new(path, content)
                return path
    except OSError as problem:
        raise UserError(
            f"The template cannot be kept in {folder}: {problem.strerror}. Save it as a file "
            "instead: Object, Car, Save this car as a template."
        ) from None
    raise UserError(f"There are {MOST_ALIKE - 1} templates of this name. Take another name.")


def _write_new(path: Path, content: bytes) -> None:
    """Write a file that is not there yet; nothing of it stays if that fails."""
    file = path.open("xb")
    try:
        with file:
            file.write(content)
    except OSError:
        path.unlink()
        raise


def forget_template(kept: KeptTemplate) -> None:
    """Remove a template from those that are kept; cars that began with it have it still.

    Raises
    ------
    UserError
        If its file cannot be removed.
    """
    try:
        kept.path.unlink(missing_ok=True)
    except OSError as problem:
        raise UserError(
            f"{kept.path.name} cannot be removed: {problem.strerror}. Remove it in its folder, "
            f"{kept.path.parent}."
        ) from None
