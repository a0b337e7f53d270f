"""Buffer of a glTF file that is being written, with its views and accessors."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray


@dataclass
class GltfBuffers:
    """Bytes, and the records that say what they are.

    Attributes
    ----------
    blob : bytearray
    views, accessors : list of dict
        As the description has them.
    """

    blob: bytearray = field(default_factory=bytearray)
    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)

    def view(self, content: bytes, **more: int) -> int:
        """Add bytes; return the number of their view."""
        size = len(content)
        self.views.append({"buffer": 0, "byteOffset": len(self.blob), "byteLength": size, **more})
        self.blob.extend(content + b"\0" * (-size % 4))  # what follows stays aligned
        return len(self.views) - 1

    def put(
        self,
        values: NDArray[Any],
        kind: str,
        component: int,
        target: int | None = None,
        **more: Any,
    ) -> int:
        """Add an accessor of values; return its number.

        Parameters
        ----------
        values : array
            In the type of the component.
        kind : {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT4"}
            What each row is.
        component : int
            The format's number of their type.
        target : int, optional
            For what graphics cards use them.
        **more
            Other entries of its record.
        """
        view = self.view(values.tobytes(), **({} if target is None else {"target": target}))
        accessor = {"bufferView": view, "componentType": component, "type": kind}
        self.accessors.append({**accessor, "count": len(values), **more})
        return len(self.accessors) - 1
