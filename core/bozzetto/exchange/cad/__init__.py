"""Formats of exact curves and surfaces: STEP, IGES, 3dm, DXF."""
