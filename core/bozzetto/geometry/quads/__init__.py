"""Meshes of quads laid over surfaces of triangles."""
