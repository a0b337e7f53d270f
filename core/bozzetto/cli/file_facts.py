"""Facts about files, told without building anything."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bozzetto.errors import UserError
from bozzetto.exchange.formats import find, readers
from bozzetto.exchange.import_file import is_mesh, read_drawing, read_image, read_mesh_file


def facts_of(path: Path, *, trusted: bool = False) -> dict[str, Any]:
    """Return facts about a document, drawing, mesh or picture, as plain JSON values.

    Parameters
    ----------
    path : Path
        The file.
    trusted : bool
        As in `import_file.read_mesh`.

    Raises
    ------
    UserError
        If it cannot be read, or its ending is unknown.
    """
    if path.suffix.lower() == ".bozz":
        from bozzetto.document.storage.bozz_reader import document_info

        return document_info(path)
    if path.is_dir():
        raise UserError(f"“{path}” is a folder. Choose a file inside it.")
    holds = find(path, readers()).holds
    if "image" in holds:
        height, width, _ = read_image(path, trusted=trusted).shape
        return {"kind": "picture", "size_px": [width, height]}
    if not is_mesh(path):
        drawing = read_drawing(path, trusted=trusted)
        return {
            "kind": "drawing",
            "camera": drawing.camera.kind,
            "canvas_px": list(drawing.camera.viewport),
            "strokes": len(drawing.strokes),
            "samples": sum(len(stroke) for stroke in drawing.strokes),
            "pressure": any(stroke.has_pressure for stroke in drawing.strokes),
            "facts": sorted(drawing.facts),
            "pictures": [
                f"{name}, {picture.width} × {picture.height} px"
                for name, picture in drawing.pictures.items()
            ],
            "left_out": list(drawing.left_out),
        }
    mesh = read_mesh_file(path, trusted=trusted)
    shapes = mesh.upright
    parts = list(shapes.meshes())
    bounds = [part.mesh.bounds for part in parts]
    reach = [curve.control_points for curve in shapes.curves]
    bounds += [np.array([points.min(axis=0), points.max(axis=0)]) for points in reach]
    low, high = np.min(bounds, axis=(0, 1)), np.max(bounds, axis=(0, 1))
    return {
        "kind": "mesh",
        "parts": len(parts),
        "vertices": sum(len(part.mesh.vertices) for part in parts),
        "triangles": sum(len(part.mesh.faces) for part in parts),
        **({"curves": len(shapes.curves)} if shapes.curves else {}),
        "size_mm": [round(float(v), 6) for v in high - low],
        "told": list(mesh.told()),
    }
