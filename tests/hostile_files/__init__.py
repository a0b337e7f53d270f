"""Files made to hurt their readers, as small generators: what once hurt stays here for ever.

Each family makes a file of about so many bytes. Most are read or refused in time that grows
with their size; a few are small and ask for much, and have one size only.
"""

from __future__ import annotations

from importlib import import_module

from tests.hostile_files.families import FAMILIES, Family, families

__all__ = ["FAMILIES", "Family", "families"]

FORMATS = (
    "inkml",
    "svg",
    "ink_json",
    "obj",
    "stl",
    "ply",
    "off",
    "glb",
    "gltf",
    "threemf",
    "usd",
    "dxf",
    "step_and_iges",
    "pictures",
)
"""Modules with the families of a format, in the order of the list."""

for _format in FORMATS:
    import_module(f"tests.hostile_files.{_format}")
