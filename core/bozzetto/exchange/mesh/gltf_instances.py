"""Copies of one mesh in a glTF file (EXT_mesh_gpu_instancing), read: a node for each."""

from __future__ import annotations

from typing import Final

import msgspec
import numpy as np

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.limits import MAX_PARTS, at_most
from bozzetto.exchange.mesh.gltf_scene import Gltf, Node, Record
from bozzetto.exchange.mesh.gltf_values import Blobs, values_of
from bozzetto.typed_data import decode_json

INSTANCING: Final = "EXT_mesh_gpu_instancing"

WIDTHS: Final = {"TRANSLATION": 3, "ROTATION": 4, "SCALE": 3}
"""Attributes that say where copies are, and how many values each has."""


class Copies(Record):
    """Rows of values, one for each copy."""

    attributes: dict[str, int] = msgspec.field(default_factory=dict)


def place_copies(gltf: Gltf, blobs: Blobs) -> None:
    """Give nodes that show copies of their mesh a node below for each, in its stead.

    Raises
    ------
    FormatError
        If it is not said where they are, or not for each.
    """
    copies = 0
    for node in list(gltf.nodes):
        raw = node.extensions.get(INSTANCING)
        if raw is None or node.mesh is None:
            continue
        try:
            record: Copies = decode_json(raw, Copies)
        except msgspec.MsgspecError as error:
            raise FormatError(
                f"Copies of a mesh cannot be understood: {words_of(error)}."
            ) from None
        known = {name: k for name, k in record.attributes.items() if name in WIDTHS}
        rows = {name: values_of(gltf, blobs, k, WIDTHS[name]) for name, k in known.items()}
        counts = {len(values) for values in rows.values()}
        if len(counts) != 1 or not all(np.isfinite(values).all() for values in rows.values()):
            raise FormatError("Where the copies of a mesh are is not in the file.")
        (count,) = counts
        copies += count
        at_most(copies, MAX_PARTS, "parts")
        for k in range(count):
            copy = Node(mesh=node.mesh, name=f"{node.name or 'copy'} {k + 1}")
            for name, values in rows.items():
                setattr(copy, name.lower(), tuple(values[k].tolist()))
            node.children.append(len(gltf.nodes))
            gltf.nodes.append(copy)
        node.mesh = None
