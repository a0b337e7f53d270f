"""Drawings of solids and surfaces: edges and outlines with hidden lines, and sheets of them."""
