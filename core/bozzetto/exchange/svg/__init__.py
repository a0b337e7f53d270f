"""SVG, read as outlines and written as curves."""
