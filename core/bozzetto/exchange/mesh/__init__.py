"""Formats of triangle meshes: STL, OBJ, PLY, 3MF, glTF."""
