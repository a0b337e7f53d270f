"""Layers that show a drawing, and picking under the pen. Imports solids and below."""
