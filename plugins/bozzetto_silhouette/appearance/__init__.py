"""Colours, textures and normals of solids. Imports solids and below."""
