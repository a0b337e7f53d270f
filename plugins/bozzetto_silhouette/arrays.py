"""Types of the arrays that are handed around; their shapes stand in the docstrings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Flags = NDArray[np.bool_]
Faces = NDArray[np.int32]
"""Corners of triangles, as files and graphics cards take them."""
